#!/bin/sh
# slow: yes
# Embeds pdcorr.h in small user programs: it and one source file alone in an empty folder, as C99 and C++11, in every
# dimension; two dimensions in one program; and the mistakes that have to be caught by the compiler or the linker.
. tests/lib/script.sh
CC=${CC:-cc}
case $CC in *clang*) CXX=${CXX:-clang++} ;; *gcc*) CXX=${CXX:-g++} ;; *) CXX=${CXX:-c++} ;; esac

# fresh FILE...: an empty folder with pdcorr.h and the named files.
fresh() {
    rm -rf "$dir/box"
    mkdir "$dir/box"
    cp "$root/pdcorr.h" "$dir/box"
    for file in "$@"; do cp "$root/tests/embed/$file" "$dir/box"; done
    cd "$dir/box" || exit 1
    : > "$dir/log"
}

c99() { $CC -std=c99 -Wall -Wextra -Wpedantic $OMP "$@" > "$dir/log" 2>&1; }

prints() { [ "$(./prog 2>> "$dir/log")" = "$1" ]; }

# fails_with TEXT COMMAND...: the command fails and says TEXT.
fails_with() {
    text=$1
    shift
    ! "$@" && grep -q "$text" "$dir/log"
}

# bonds of a family: lattice points n != 0 with |n| < 3.5
for case in "1 6" "2 36" "3 178"; do
    dim=${case% *} bonds=${case#* }
    fresh embed.c
    check "C99, $dim D: compile" c99 -DPD_DIM="$dim" embed.c -o prog -lm
    check "C99, $dim D: run" prints "dim=$dim bonds=$bonds"
    if command -v "$CXX" > /dev/null; then
        fresh embed.c
        check "C++11, $dim D: compile" \
            sh -c "$CXX -std=c++11 -Wall -Wextra $OMP -DPD_DIM=$dim -x c++ embed.c -o prog -lm > $dir/log 2>&1"
        check "C++11, $dim D: run" prints "dim=$dim bonds=$bonds"
    else
        echo "skipped: $CXX is not installed: C++11, $dim D"
        skipped=$((skipped + 2))
    fi
done

# What a program with the whole header private to it does not call costs nothing.
for dim in 1 2 3; do
    fresh kernel.c
    check "private, $dim D: compile" c99 -Werror -O3 -DPD_DIM="$dim" kernel.c -o prog -lm
    check "private, $dim D: run" prints exact
    if command -v size > /dev/null; then
        size prog > "$dir/log"
        check "private, $dim D: at most 100 kB" \
            awk 'NR == 2 { exit !($1 + $2 + $3 <= 100000) }' "$dir/log"
    fi
done
if command -v "$CXX" > /dev/null; then
    check "private, C++11" \
        sh -c "$CXX -std=c++11 -Wall -Wextra -Werror $OMP -DPD_DIM=2 -x c++ kernel.c -o prog -lm > $dir/log 2>&1"
    check "private, C++11: run" prints exact
fi

fresh two_dims.h two_dims_a.c two_dims_b.c two_dims_main.c
check "2D and 3D: compile" c99 two_dims_a.c two_dims_b.c two_dims_main.c -o prog -lm
check "2D and 3D: run" prints "36 178"

fresh user.c implementation.c
check "implementation in 2D" c99 -DPD_DIM=2 -c implementation.c
check "user in 2D" c99 -DPD_DIM=2 -c user.c -o user2.o
check "user in 3D" c99 -DPD_DIM=3 -c user.c -o user3.o
check "same dimension links" c99 user2.o implementation.o -o prog -lm
check "other dimension does not link" fails_with pd_ctx_init_3d c99 user3.o implementation.o -o prog -lm
check "two implementations do not link" fails_with pd_ctx_init_2d sh -c \
    "cp implementation.o again.o && $CC $OMP user2.o implementation.o again.o -o prog -lm > $dir/log 2>&1"
check "no dimension is refused" fails_with 'define PD_DIM as 1, 2 or 3' c99 -c user.c
check "dimension 4 is refused" fails_with 'PD_DIM must be 1, 2 or 3' c99 -DPD_DIM=4 -c user.c
fresh late.c
check "late implementation is refused" fails_with 'before the first inclusion' c99 -DPD_DIM=2 -c late.c
fresh mixed.c
check "two dimensions in one file are refused" fails_with 'two values of PD_DIM' c99 -c mixed.c
printf '#include "pdcorr.h"\n#include "pdcorr.h"\nint main(void) { return 0; }\n' > twice.c
check "one dimension included twice" c99 -DPD_DIM=2 twice.c -o prog

score
