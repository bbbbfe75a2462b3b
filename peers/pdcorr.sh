# For the pdcorr files of all cases; . it. PD is the folder of the programs.

# pd DIMENSION KEY=VALUE...: run the scene on the standard input with the values; its result lines are kept in `lines`.
pd() {
    dimension=$1
    shift
    cat > case.scene
    "$PD/pd${dimension}d" case.scene "$@" --threads 1 --quiet --out out > lines || { cat lines; exit 1; }
}

# value KEY WORD...: KEY of the one result line that holds all the words.
value() {
    key=$1
    shift
    cp lines found
    for word; do
        grep -F -- " $word " found > fewer
        mv fewer found
    done
    sed -n "s/.* $key=\([^ ]*\).*/\1/p" found
}

# calc EXPRESSION: its value, by awk.
calc() { awk "BEGIN { printf \"%.12g\\n\", $1 }"; }

# last FILE COLUMN: the last value of the column of a table (CSV) in the output whose head begins with COLUMN.
last() {
    awk -F, -v name="$2" 'NR == 1 { for (k = 1; k <= NF; k++) if (index($k, name " [") == 1) at = k }
        END { print $at }' "out/$1"
}
