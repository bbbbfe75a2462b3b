#!/bin/sh
# The Python package (drivers/python) on shared libraries of the tests' own objects. Skipped without numpy for Python
# (Debian: python3-numpy). With PD_TEST_ALL its examples run, too, where matplotlib is there.
. tests/lib/script.sh
python=
for candidate in python3 /usr/bin/python3; do
    if $candidate -c 'import numpy, sys; assert sys.version_info >= (3, 9)' 2> /dev/null; then
        python=$candidate
        break
    fi
done
[ "$python" ] || skip_all "numpy for Python is not installed"
export PDCORR_LIBRARY="$build/check" PDCORR_PROGRAMS="$programs" PYTHONDONTWRITEBYTECODE=1
export PYTHONPATH="$root/drivers/python${PYTHONPATH:+:$PYTHONPATH}"
for module in scipy pycparser; do
    $python -c "import $module" 2> /dev/null || echo "skipped: $module for Python is not installed: tests that need it"
done

$python -m unittest discover -s drivers/python -t drivers/python > "$dir/log" 2>&1
sed -n '/^\(ERROR\|FAIL\):/,$p' "$dir/log"
ran=$(sed -n 's/^Ran \([0-9]*\) tests\{0,1\} .*/\1/p' "$dir/log")
count_of() { sed -n "s/^\(OK\|FAILED\).*[( ]$1=\([0-9]*\).*/\2/p" "$dir/log"; }
failures=$(count_of failures) errors=$(count_of errors) skips=$(count_of skipped)
failed=$((failed + ${failures:-0} + ${errors:-0})) skipped=$((skipped + ${skips:-0}))
passed=$((passed + ${ran:-0} - ${failures:-0} - ${errors:-0} - ${skips:-0}))
check "tests ran" test "${ran:-0}" -gt 0

if [ "$PD_TEST_ALL" ]; then
    if $python -c 'import matplotlib' 2> /dev/null; then
        for example in drivers/python/examples/*.py; do
            (cd "$dir" && MPLBACKEND=Agg $python "$root/$example" --quick) > "$dir/log" 2>&1
            verdict "$example"
            check "$example draws" test -s "$dir/out/python/$(basename "$example" .py).png"
        done
    else
        echo "skipped: matplotlib for Python is not installed: the examples"
        skipped=$((skipped + 1))
    fi
fi
score
