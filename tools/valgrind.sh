#!/bin/sh
# usage: valgrind.sh PROGRAM...: test programs under valgrind; ends with 1 when one of them leaks, reads what is not
# its own or fails.
if ! command -v valgrind > /dev/null; then
    echo "valgrind is not installed: no program was run"
    exit 0
fi
failed=0
for program in "$@"; do
    echo "== $program"
    OMP_NUM_THREADS=1 valgrind --quiet --error-exitcode=9 --leak-check=full --show-leak-kinds=definite,indirect \
        --errors-for-leak-kinds=definite,indirect "$program" || failed=1
done
exit $failed
