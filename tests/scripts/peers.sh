#!/bin/sh
# slow: weekly
# The cases of peers/: pdcorr, at the first resolution of each, gives the figures that are kept in peers/measured, and
# docs/peers.md is what is made of them. Skipped without rows that were measured, and without matplotlib.
. tests/lib/script.sh
[ -d peers/measured ] || skip_all "peers/measured is not there: make peers measures it"
find_python 'import matplotlib, numpy'
[ "$python" ] || skip_all "numpy and matplotlib for Python are not installed (Debian: python3-matplotlib)"
export PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg

# Every case that is kept is there, and the other way round.
for case in peers/*/case.ini; do
    case=${case#peers/}
    check "${case%/*}: rows are kept" test -s "peers/measured/${case%/*}.csv"
done
for kept in peers/measured/*.csv; do
    name=$(basename "$kept" .csv)
    [ "$name" = machine ] || check "$kept: a case" test -f "peers/$name/case.ini"
done

$python peers/peers.py --check --build "$programs" > "$dir/log" 2>&1
status=$?
right=$(sed -n 's/^\([0-9]*\) passed.*/\1/p' "$dir/log")
passed=$((passed + ${right:-0}))
verdict "figures of pdcorr are those that are kept; make peers measures them anew" $status

cp README.md "$dir/README.md"
$python peers/peers.py --report --docs "$dir/docs" --readme "$dir/README.md" > "$dir/log" 2>&1
verdict "the report is made"
diff "$dir/README.md" README.md > "$dir/log" 2>&1
verdict "the table of README.md is made of peers/measured, too"
diff "$dir/docs/peers.md" docs/peers.md > "$dir/log" 2>&1
verdict "docs/peers.md is made of peers/measured; peers/peers.py --report makes it"
for picture in "$dir"/docs/img/peers/*.png; do
    check "docs/img/peers/${picture##*/} is there" test -s "docs/img/peers/${picture##*/}"
done
score
