#!/bin/sh
# The numeric constants of src/ and their list in docs/constants.md.
#
#   constants.sh                 every constant of src/ stands in the list with its module and value, and no other
#   constants.sh --sweep NAME... what scenes cost and give with these constants over a decade, as rows of a table
#   constants.sh --write         the same for all that the list calls insensitive or to be removed, written into it.
#                                Ends with 1 when one that is called insensitive is not
#
# A constant is divided and multiplied by the square root of ten; one between 1/2 and 4 changes its distance from 1 by
# that. Insensitive: no scene of tests/constants/ takes more than 1.5 times the work, and no result moves by more than
# the loosest tolerance of these scenes, 4e-3. CC, BUILD, JOBS: compiler, folder of what is built, constants at once.
list=docs/constants.md
cc=${CC:-cc}
out=${BUILD:-build}/constants
flags='-std=c99 -O2 -ffp-contract=off -DPDI_SPLIT -DPD_DIM=2'

# "module|NAME|value" of all constants of src/.
constants() {
    grep '^ *# *define PDI\{0,1\}_' src/*/*.h src/*/*.c |
        sed -e 's/^[^:]*\/\([^./:]*\)\.[ch]: *# *define PDI\{0,1\}_/\1|/' -e 's/ *\/\*.*//' |
        sed -n 's/^\([^|]*|[A-Z0-9_]*\) \{1,\}\([-+(]*[0-9.].*\)$/\1|\2/p' | grep -v '^config|' | sort -u
}

# "module|NAME|value" of all constants of the list.
listed() {
    awk -F'|' '/^## All/ { all = 1 }
        all && /^\| `/ { gsub(/[ `]/, "", $2); gsub(/ /, "", $3); gsub(/^ | $/, "", $4)
                         print $3 "|" $2 "|" $4 }' $list | sort -u
}

# The names that the list calls $1.
called() {
    awk -F'|' -v class="$1" '/^## All/ { all = 1 }
        all && /^\| `/ && index($6, class) == 2 { gsub(/[ `]/, "", $2); print $2 }' $list | sort -u
}

agree() {
    mkdir -p "$out"
    constants > "$out/have"
    listed > "$out/listed"
    comm -23 "$out/have" "$out/listed" | sed "s|^|not in $list: |"
    comm -13 "$out/have" "$out/listed" | sed "s|^|not in src: |"
    cmp -s "$out/have" "$out/listed"
}

# build FOLDER: the objects and the program `work` of the sources in FOLDER/src, all or those named in FOLDER/changed.
build() {
    for file in $(cat "$1/changed"); do
        $cc $flags -I"$1/src" -c "$1"/src/*/"$file.c" -o "$1/obj/$file.o" || return 1
    done
    $cc $flags -DPDI_INTERNAL -I"$1/src" tests/constants/work.c "$1"/obj/*.o -o "$1/work" -lm
}

prepare() {
    rm -rf "$out"
    mkdir -p "$out/base/obj"
    cp -r src "$out/base/src"
    for file in src/*/*.c; do basename "$file" .c; done > "$out/base/changed"
    build "$out/base" && OMP_NUM_THREADS=1 "$out/base/work" tests/constants/*.scene > "$out/base/work.log"
}

# other VALUE FACTOR: whole numbers stay whole.
other() {
    awk -v text="$1" -v factor="$2" 'BEGIN {
        gsub(/[()f]/, "", text)
        v = text + 0
        if (v > 0.5 && v < 4 && v != 1) w = 1 + (v - 1) * factor
        else w = v * factor
        if (text !~ /[.e]/) { w = int(w + 0.5); if (w < 1) w = 1 }
        if (w < 0) w = 0
        printf text ~ /[.e]/ ? "%.9e" : "%d", w
    }'
}

# sweep NAME: its two rows.
sweep() {
    folder=$out/$1
    constants | grep "|$1|" | head -n 1 > "$out/$1.line"
    IFS='|' read -r module name value < "$out/$1.line"
    [ -n "$value" ] || { echo "no constant has the name $1" >&2; return 1; }
    for factor in 0.316228 3.16228; do
        rm -rf "$folder"
        mkdir "$folder"
        cp -r "$out/base/src" "$out/base/obj" "$folder"
        changed=$(other "$value" $factor)
        sed -i "s/^\( *# *define PDI\{0,1\}_$name \{1,\}\)[-+(]*[0-9.][^ ]*/\1$changed/" "$folder"/src/*/"$module".[ch]
        if grep -q "define PDI\{0,1\}_$name " "$folder"/src/*/"$module.c" 2> /dev/null; then echo "$module"
        else cat "$out/base/changed"; fi > "$folder/changed"
        build "$folder" || return 1
        OMP_NUM_THREADS=1 timeout 100 "$folder/work" tests/constants/*.scene > "$folder/work.log" 2> "$folder/err"
        row "$name" "$changed" "$folder"
    done
    rm -rf "$folder"
}

# row NAME VALUE FOLDER: the scene whose work changes most, and the result.
row() {
    awk -v name="$1" -v value="$2" '
        function grow(a, b) { return a > b ? a / b : b / a }
        {
            for (k = 2; k <= NF; k++) {
                split($k, pair, "=")
                if (pair[1] == "name") scene = pair[2]
                if (FNR == NR) base[scene, pair[1]] = pair[2]
                else now[scene, pair[1]] = pair[2]
            }
            if (FNR == NR) scenes[++count] = scene
        }
        END {
            work = 1; which = "-"; moved = 0; where = "-"
            for (s = 1; s <= count; s++) {
                scene = scenes[s]
                if (!((scene, "work") in now)) { failed = scene; continue }
                g = now[scene, "work"] / base[scene, "work"]
                if (grow(g, 1) > grow(work, 1)) { work = g; which = scene }
                for (k = split("loss u c", key, " "); k; k--) {
                    b = base[scene, key[k]]; n = now[scene, key[k]]
                    change = n - b; if (change < 0) change = -change
                    if (b != 0 && change / b > moved) { moved = change / b; where = scene " " key[k] }
                }
            }
            if (failed) printf "| `%s` | %g | fails | %s | - | - |\n", name, value, failed
            else printf "| `%s` | %g | %.2f | %s | %.1e | %s |\n", name, value, work, which, moved, where
        }' "$out/base/work.log" "$3/work.log"
}

# The rows that are not insensitive.
sensitive() {
    awk -F'|' '$4 ~ /fails/ || $4 > 1.5 || $4 < 0.66 || $6 > 4e-3' "$@"
}

case $1 in
'') agree ;;
--sweep)
    prepare || exit 1
    shift
    for name; do sweep "$name" || exit 1; done
    ;;
--one) sweep "$2" > "$out/$2.rows" || echo "$2: not swept" ;;
--write)
    prepare || exit 1
    { called insensitive; called "to be removed"; } | xargs -n 1 -P "${JOBS:-2}" sh "$0" --one
    cat "$out"/*.rows > "$out/table"
    awk -v table="$out/table" '
        /<!-- end of the sweep -->/ { skip = 0 }
        !skip { print }
        /<!-- sweep/ {
            skip = 1
            print "\n| constant | value | work | in | result moves by | in |\n|---|---|---|---|---|---|"
            while ((getline line < table) > 0) print line
            print ""
        }' $list > "$out/list"
    cp "$out/list" $list
    called insensitive | while read -r name; do sensitive "$out/$name.rows"; done > "$out/wrong"
    [ ! -s "$out/wrong" ] || { echo "called insensitive, and is not:"; cat "$out/wrong"; exit 1; }
    ;;
*) echo "usage: constants.sh [--sweep NAME... | --write]" >&2; exit 2 ;;
esac
