#!/bin/sh
# The Python package (drivers/python) on shared libraries of the tests' own objects. Skipped without numpy for Python
# (Debian: python3-numpy).
. tests/lib/script.sh
. tests/lib/python.sh
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
score
