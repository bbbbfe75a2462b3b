#!/bin/sh
# compile.sh COMPILER DIM [fopenmp] FLAG...: compile pdcorr.h with its implementation, as C99, or as C++11 when the
# compiler's name ends in ++. Fails on a warning when the flags hold -Werror. gcc finds some of its warnings while it
# optimises; those of clang, and what C++ adds to those of C, come from reading alone.
compiler=$1 dim=$2
shift 2
openmp=
if [ "$1" = fopenmp ]; then
    openmp=-fopenmp
    shift
fi
if ! command -v "$compiler" > /dev/null; then
    echo "skipped: $compiler is not installed"
    echo "0 passed, 0 failed, 1 skipped"
    exit 0
fi
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
if [ -n "$openmp" ]; then
    printf '#include <omp.h>\nint main(void) { return omp_get_max_threads() < 1; }\n' > "$dir/probe.c"
    if ! "$compiler" -fopenmp "$dir/probe.c" -o "$dir/probe" 2> "$dir/log"; then
        echo "skipped: $compiler has no OpenMP"
        echo "0 passed, 0 failed, 1 skipped"
        exit 0
    fi
fi
case $compiler in
*++)
    ending=cpp standard=c++11
    for flag in "$@"; do # these two exist for C only
        shift
        case $flag in -Wstrict-prototypes | -Wmissing-prototypes) ;; *) set -- "$@" "$flag" ;; esac
    done
    ;;
*) ending=c standard=c99 ;;
esac
work=-fsyntax-only
[ "$compiler" != gcc ] || work="-O2 -c -o $dir/unit.o"
printf '#define PDCORR_IMPLEMENTATION\n#include "pdcorr.h"\n' > "$dir/unit.$ending"
"$compiler" -std=$standard $work $openmp "$@" -DPD_DIM="$dim" -I. "$dir/unit.$ending"
