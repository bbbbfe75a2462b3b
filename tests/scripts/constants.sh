#!/bin/sh
# Every numeric constant of src/ stands in docs/constants.md with its value and its class (tools/constants.sh).
. tests/lib/script.sh

BUILD=$dir sh tools/constants.sh > "$dir/log" 2>&1
verdict "constants and their list differ"
awk -F'|' '/^## All/ { all = 1 }
    all && /^\| `/ && $6 !~ /^ (derived|format|label|drawing|size|speed|rounding|measured|insensitive|to be removed)/ {
        print "no class: " $0
    }' docs/constants.md > "$dir/log"
[ ! -s "$dir/log" ]
verdict "constants without a class"

# A list that lacks one and holds another value of a second is complained of.
mkdir -p "$dir/tree/docs"
cp -r src "$dir/tree"
grep -v '^| `STEADY_NEWTON_FIRST_RATE` | steady_newton' docs/constants.md |
    sed '/^## All/,$s/^\(| `STEADY_NEWTON_MAX_GROWTH` | steady_newton |\) [^ ]*/\1 7/' \
        > "$dir/tree/docs/constants.md"
cp tools/constants.sh "$dir/tree"
cd "$dir/tree" || exit 1
! BUILD=$dir sh constants.sh > "$dir/log" 2>&1
verdict "a list that lacks a constant passes"
grep -q 'not in docs/constants.md: steady_newton|STEADY_NEWTON_FIRST_RATE|' "$dir/log"
verdict "the constant that the list lacks"
grep -q 'not in src: steady_newton|STEADY_NEWTON_MAX_GROWTH|7' "$dir/log"
verdict "the value that the list has wrong"
score
