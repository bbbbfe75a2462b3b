# script: what every shell script of tests/ starts with, sourced from the root of the checkout.
#
#   root, build   folders of the checkout and of what is built, absolute
#   programs      folder of pd1d, pd2d and pd3d
#   dir           a folder of its own, gone in the end; $dir/log: what the last command said
#   verdict, check, rejects_usage, score   count and report
#   block         code of a text
#   figure        a number of a run whose output is $dir/out and whose log is $dir/log
#   linked        $library, what programs in a dimension are linked to
#   plain         $object, the library in a dimension without optimisation
#   find_python   $python, with what a test needs of it

root=$PWD
build=${BUILD:-build}
case $build in /*) ;; *) build=$root/$build ;; esac
programs=${PROGRAMS:-$build}
case $programs in /*) ;; *) programs=$root/$programs ;; esac
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0 skipped=0

# verdict TEXT [STATUS]: counts the status of the last command; where it failed, shows TEXT and the end of the log. A
# TEXT that runs commands needs the STATUS, saved before it: shells differ in what $? is then.
verdict() {
    if [ "${2:-$?}" = 0 ]; then
        passed=$((passed + 1))
        return
    fi
    failed=$((failed + 1))
    echo "failed: $1"
    [ ! -s "$dir/log" ] || tail -n 20 "$dir/log" | sed 's/^/  /'
}

# check TEXT COMMAND...: a verdict on a command.
check() {
    checked=$1
    shift
    "$@"
    verdict "$checked"
}

# rejects_usage PROGRAM MESSAGE ARGUMENT...: wrong usage: one line on stderr, nothing on stdout, status 2.
rejects_usage() {
    rejecting=$1
    printf '%s: %s; see %s --help\n' "$1" "$2" "$1" > "$dir/wanted"
    shift 2
    "$programs/$rejecting" "$@" > "$dir/out" 2> "$dir/log"
    [ $? = 2 ] && [ ! -s "$dir/out" ] && cmp -s "$dir/log" "$dir/wanted"
    said=$?
    verdict "$rejecting $*: expected status 2 and '$(cat "$dir/wanted")'; found" $said
}

# linked DIMENSION: $library is the library of the programs that are tested, as arguments of the compiler.
linked() {
    library=$build/pdcorr${1}d.o
    [ "$programs" = "$build" ] || library="$programs/libpdcorr${1}d.so -Wl,-rpath,$programs"
}

# block PAGE NUMBER LANGUAGE: that block of code of a text.
block() {
    awk -v n="$2" -v fence="\`\`\`$3" '$0 == fence { k++; inside = k == n; next } /^```/ { inside = 0 } inside' "$1"
}

# figure KEY: of the last result line that has it; OBJECT:KEY of that of the object; FILE:COLUMN of a table's last row,
# by the number of the column or by its name.
figure() {
    case $1 in
    *.csv:*[!0-9]*) # shellcheck disable=SC2086
        awk -F, -v name="${1##*.csv:}" 'FNR == 1 { k = 0; for (n = 1; n <= NF; n++) if ($n == name) k = n }
            { row = k ? $k : "" } END { print row }' "$dir"/out/${1%%.csv:*}.csv ;;
    *.csv:*) # shellcheck disable=SC2086
        tail -q -n 1 "$dir"/out/${1%:*} | tail -n 1 | cut -d, -f "${1#*:}" ;;
    *:*) grep -F " ${1%:*} " "$dir/log" | tr ' ' '\n' | sed -n "s/^${1#*:}=//p" | tail -n 1 ;;
    *) grep '^result ' "$dir/log" | tr ' ' '\n' | sed -n "s/^$1=//p" | tail -n 1 ;;
    esac
}

# plain DIM: $object holds all of both headers in that dimension, compiled without optimisation and OpenMP. It is that
# of `make`, or one of its own where make has none of these headers.
plain() {
    object=$build/plain/pdcorr${1}d.o
    [ -f "$object" ] && [ -z "$(find "$root/pdcorr.h" "$root/pdcorr_app.h" -newer "$object")" ] && return
    object=$dir/pdcorr${1}d.o
    [ -f "$object" ] || ${CC:-cc} -std=c99 -O0 -fPIC -ffp-contract=off -DPD_DIM="$1" -DPDCORR_IMPLEMENTATION -x c \
        -c "$root/pdcorr_app.h" -o "$object" > "$dir/log" 2>&1
}

# find_python CODE: $python is the first Python that runs CODE; empty: none does.
find_python() {
    for python in python3 /usr/bin/python3; do
        ! $python -c "$1" 2> /dev/null || return 0
    done
    python=
}

# score: the line that tools/sum.sh adds up. The last command of a script.
score() {
    echo "$passed passed, $failed failed, $skipped skipped"
    [ "$failed" = 0 ]
}

# skip_all REASON: ends a script whose tools are not there.
skip_all() {
    echo "skipped: $1"
    skipped=1
    score
    exit
}
