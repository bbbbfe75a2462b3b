#!/bin/sh
# slow: weekly
# The examples of the Python package run and draw. Skipped without numpy or matplotlib.
. tests/lib/script.sh
. tests/lib/python.sh
$python -c 'import matplotlib' 2> /dev/null || skip_all "matplotlib for Python is not installed"
for example in drivers/python/examples/*.py; do
    (cd "$dir" && MPLBACKEND=Agg $python "$root/$example" --quick) > "$dir/log" 2>&1
    verdict "$example"
    check "$example draws" test -s "$dir/out/python/$(basename "$example" .py).png"
done
score
