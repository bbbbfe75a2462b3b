#!/bin/sh
# compile.sh COMPILER DIM [fopenmp] FLAG...: compile pdcorr_app.h, and so pdcorr.h, with their implementations, as C99,
# or as C++11 when the compiler's name ends in ++. Fails on a warning when the flags hold -Werror. gcc finds some of its
# warnings while it optimises, which it does with fopenmp alone; those of clang, and what C++ adds to those of C, come
# from reading alone.
# clang also names extensions of GNU. msvc and msvc++: clang as Microsoft's compiler, which leaves the GNU side of no
# guard, with declarations from the headers of mingw-w64.
compiler=$1 dim=$2 name=$1
shift 2
case $name in msvc*) compiler=clang${name#msvc} ;; esac
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
mingw=/usr/share/mingw-w64/include
if [ "$compiler" != "$name" ] && [ ! -f $mingw/_mingw.h ]; then
    echo "skipped: mingw-w64-common is not installed"
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
case $compiler in
gcc | g++) set -- "$@" -Wno-misleading-indentation ;; # it takes most of the time in so long a file; src/ has it
esac
case $name in
gcc) [ -z "$openmp" ] || work="-O2 -c -o $dir/unit.o" ;;
clang) work="$work -pedantic-errors -Wgnu -Wvla -Wgcc-compat -Wlanguage-extension-token" ;;
msvc*) # where attributes stand in those headers, this compiler takes none
    for word in __MINGW_ATTRIB_NORETURN __MINGW_ATTRIB_DEPRECATED __MINGW_NOTHROW; do
        printf '#include <_mingw.h>\n#undef %s\n#define %s\n' $word $word
    done > "$dir/plain.h"
    work="$work --target=x86_64-pc-windows-msvc -fms-compatibility -fms-extensions -U__clang__ -include $dir/plain.h"
    work="$work -idirafter $mingw -pedantic-errors -Wgnu -Wvla"
    if [ $standard = c++11 ]; then
        standard=c++14 # the oldest that Microsoft's compiler knows
        set -- "$@" -Wno-float-conversion # those headers have isnan of integers
    fi
    ;;
esac
printf '#define PDCORR_IMPLEMENTATION\n#include "pdcorr_app.h"\n' > "$dir/unit.$ending"
"$compiler" -std=$standard $work $openmp "$@" -DPD_DIM="$dim" -I. "$dir/unit.$ending"
status=$?
case $name in msvc*) ;; *) exit $status ;; esac
# Attributes and built-in functions are no errors for clang: none may be left where no header defines a macro.
for header in pdcorr.h pdcorr_app.h; do sed '/^ *#include </d' $header > "$dir/$header"; done
"$compiler" -std=$standard --target=x86_64-pc-windows-msvc -U__clang__ -E -P -DPD_DIM="$dim" "$dir/unit.$ending" |
    awk '/__attribute__|__builtin_|__typeof|__extension__|__asm|pragma GCC/ {
             print "for GNU compilers alone: " $0
             found = 1
         }
         END { exit found || NR < 10000 }' && exit $status
exit 1
