#!/bin/sh
# usage: static.sh DIMENSIONS TOOL...: cppcheck and clang-tidy on src/ in, for example, "1 2 3" dimensions; a tool that
# is not installed is named and passed over. Ends with 1 when something was found.
found=0 dims=$1
shift
for tool in "$@"; do
    if ! command -v "$tool" > /dev/null; then
        echo "$tool is not installed: passed over"
        continue
    fi
    for dim in $dims; do
        echo "== $tool in ${dim}D"
        case $tool in
        # Left out: structs set by memset; uninitialised values, which cppcheck suspects in arrays that a callee fills
        # (compilers, sanitizers and valgrind look for them).
        cppcheck) cppcheck --quiet --std=c99 --enable=warning,portability,performance --inline-suppr \
            --suppress=memsetClassFloat --suppress=uninitvar --suppress=ctuuninitvar --error-exitcode=1 -DPD_DIM=$dim \
            -DPDI_SPLIT -UPDCORR_IMPLEMENTATION -U_WIN32 -U_OPENMP -Isrc src || found=1 ;;
        # One file at a time: what it knows of va_list spills over from one to the next (clang-tidy 14).
        clang-tidy) for file in src/*/*.c; do
                clang-tidy --quiet "$file" -- -std=c99 -DPD_DIM=$dim -DPDI_SPLIT -Isrc 2> /dev/null || found=1
            done ;;
        esac
    done
done
exit $found
