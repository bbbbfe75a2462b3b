#!/bin/sh
# slow: yes
# Embeds pdcorr.h and pdcorr_app.h in small user programs: they and one source file alone in an empty folder, as C99 and
# C++11, in every dimension; two dimensions in one program; and the mistakes that have to be caught by the compiler or
# the linker. pdcorr_app.h compiles by the public part of pdcorr.h. With
# PD_TEST_ALL=1 in every variant: without it, what check-compilers reads in every dimension is compiled in one here.
. tests/lib/script.sh
CC=${CC:-cc}
case $CC in *clang*) CXX=${CXX:-clang++} ;; *gcc*) CXX=${CXX:-g++} ;; *) CXX=${CXX:-c++} ;; esac

# fresh FILE...: an empty folder with both headers and the named files.
fresh() {
    rm -rf "$dir/box"
    mkdir "$dir/box"
    cp "$root/pdcorr.h" "$root/pdcorr_app.h" "$dir/box"
    for file in "$@"; do cp "$root/tests/embed/$file" "$dir/box"; done
    cd "$dir/box" || exit 1
    : > "$dir/log"
}

# c99 ARGUMENT...: compiles. strict ARGUMENT...: without a warning too, but for the one that gcc looks for line by line,
# which takes most of the time of so long a file: src/ is compiled with it.
c99() { $CC -std=c99 $OMP "$@" > "$dir/log" 2>&1; }
warn="-Wall -Wextra -Wno-misleading-indentation -Werror"
strict() { c99 $warn -Wpedantic "$@"; }

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
    # 2D and 3D also come below, together
    if [ "$dim" = 1 ] || [ "$PD_TEST_ALL" ]; then
        check "C99, $dim D: compile" c99 -DPD_DIM="$dim" embed.c -o prog -lm
        check "C99, $dim D: run" prints "dim=$dim bonds=$bonds"
    fi
    [ "$dim" = 2 ] || [ "$PD_TEST_ALL" ] || continue
    if command -v "$CXX" > /dev/null; then
        fresh embed.c
        check "C++11, $dim D: compile" \
            sh -c "$CXX -std=c++11 $OMP -DPD_DIM=$dim -x c++ embed.c -o prog -lm > $dir/log 2>&1"
        check "C++11, $dim D: run" prints "dim=$dim bonds=$bonds"
    else
        echo "skipped: $CXX is not installed: C++11, $dim D"
        skipped=$((skipped + 2))
    fi
done

# cpu COMMAND...: processor seconds of the command.
cpu() {
    sh -c '"$@" > /dev/null 2>&1 || exit; times' sh "$@" | tail -n 1 |
        awk -F '[ms ]+' '{ print 60 * ($1 + $3) + $2 + $4 }'
}

# costs TIMES COMMAND...: a compilation takes at most so many times the processor seconds that those of amalgamate and
# lint take together, 0.5 s where docs/performance.md is measured. A slow machine or a shared core slows all of them,
# but not at the same moment: one of three turns has to do.
costs() {
    most=$1
    shift
    : > "$dir/log"
    for turn in 1 2 3; do
        tools="$(cpu $CC -std=c99 -O3 -c "$root/tools/lint.c" -o tools.o) \
            $(cpu $CC -std=c99 -O3 -c "$root/tools/amalgamate.c" -o tools.o)"
        ours=$(cpu "$@")
        echo "turn $turn: $ours s, the tools $tools s: $*" | tee -a "$dir/log"
        echo "$ours $tools $most" | awk '{ exit !($1 > 0 && $1 <= $4 * ($2 + $3)) }' && return
    done
    return 1
}

# What a program with the whole header private to it does not call costs nothing.
for dim in 1 2 3; do
    fresh kernel.c
    strictly=c99
    [ "$dim" != 2 ] && [ -z "$PD_TEST_ALL" ] || strictly=strict
    check "private, $dim D: compile" $strictly -O3 -DPD_DIM="$dim" kernel.c -o prog -lm
    check "private, $dim D: run" prints exact
    if command -v size > /dev/null; then
        size prog > "$dir/log"
        check "private, $dim D: at most 100 kB" \
            awk 'NR == 2 { exit !($1 + $2 + $3 <= 100000) }' "$dir/log"
    fi
done
fresh kernel.c kernel_cut.c physics.c user.c app.c app_alone.c both.c
check "cost of kernels alone" costs 5 $CC -std=c99 -O3 -DPD_DIM=2 kernel.c -o prog -lm
less="-DPDCORR_NO_SOLID -DPDCORR_NO_CHEMISTRY -DPDCORR_NO_POTENTIAL"
if [ "$PD_TEST_ALL" ]; then
    check "cost of flow, transport and metal" \
        costs 33 $CC -std=c99 -O3 -DPD_DIM=2 $less -c physics.c -o physics.o
    check "cost of scenes" costs 62 $CC -std=c99 -O3 -DPD_DIM=2 -c app.c -o scenes.o
else
    check "cost of scenes, not optimised" costs 17.5 $CC -std=c99 -O0 -DPD_DIM=2 -c app.c -o scenes.o
fi

# The public functions: each has a user outside of its header, and all are declared where users see them.
most=356
count() { cat pdcorr.h pdcorr_app.h | grep -c '^PD_API .*('; }
check "at most $most public functions" [ "$(count)" -le "$most" ]
check "what all see stands first, in less than 8000 lines" \
    awk 'FILENAME == "pdcorr.h" && />>internal =/ { exit !(FNR < 8000) }' pdcorr.h
check "no two blank lines where a part is cut out" \
    awk '/>>internal =/ { exit twice } $0 == "" && last == "" && FNR > 1 { twice = 1 } { last = $0 }' pdcorr.h
printf '#include "pdcorr_app.h"\n' > seen.c
check "what users see" sh -c "$CC -std=c99 -E -DPD_DIM=2 seen.c > seen.i"
check "no internal function among it" sh -c '! grep -q "pdi_[a-z_]*(.*);" seen.i'
check "every public function among it" \
    [ "$(count)" = "$(grep -c '^extern .*\bpd_[a-z_0-9]*_2d *(' seen.i)" ]

# Scenes, files and pictures see of pdcorr.h what all programs see.
check "pdcorr_app.h alone" strict -O0 -DPD_DIM=2 -c app_alone.c -o app.o
printf '#define PDCORR_IMPLEMENTATION\n#include "pdcorr.h"\n' > kernel_alone.c
check "pdcorr.h alone" c99 -O0 -DPD_DIM=2 -c kernel_alone.c -o kernel.o
sed 's/^#define PDCORR_IMPLEMENTATION$//' "$root/examples/05_embed.c" > embedded.c
check "both, linked" c99 -O0 embedded.c app.o kernel.o -o prog -lm
cat > slab.scene <<'END'
[grid] h = 10 um   box = 0 um .. 100 um, 0 um .. 40 um
[shape slab] box = 50 um .. 100 um, 0 um .. 40 um   kind = solid   material = mg4ag
[transport] D = 1e-9 m2/s
[dissolve] rate = 1 um/h
[run] until = 1 h
END
check "both, linked: 1 um of 50 um dissolves" sh -c "./prog slab.scene > log 2>&1 && grep -q ' volume_loss=0.02 ' log"
if command -v "$CXX" > /dev/null; then
    check "pdcorr_app.h alone, C++11" \
        sh -c "$CXX -std=c++11 $warn $OMP -DPD_DIM=2 -x c++ -c app_alone.c -o app.o > $dir/log 2>&1"
fi

# Rooms that are left out, from several files and private to one, without a warning.
for cut in PDCORR_NO_SCENE PDCORR_NO_MODEL PDCORR_NO_SOLID PDCORR_NO_CHEMISTRY PDCORR_NO_POTENTIAL PDCORR_NO_PHYSICS; do
    check "$cut" c99 -DPD_DIM=2 -D$cut -DPDCORR_IMPLEMENTATION -x c -fsyntax-only pdcorr_app.h
    case $cut$PD_TEST_ALL in
    *1 | PDCORR_NO_MODEL | PDCORR_NO_PHYSICS)
        check "$cut, private" strict -DPD_DIM=2 -D$cut kernel.c -o prog -lm
        check "$cut, private: run" prints exact
        ;;
    *) check "$cut, private" strict -DPD_DIM=2 -D$cut -fsyntax-only kernel.c ;;
    esac
done
# Metal dissolves with the same bits whether mechanics are compiled in or not: imbalances are sums of rounding.
if [ "$PD_TEST_ALL" ]; then
    cp "$root/examples/04_pin.c" .
    for cut in "" -DPDCORR_NO_SOLID; do
        check "a pin, private $cut" c99 -O0 -DPDCORR_LINKED -DPDCORR_STATIC $cut 04_pin.c -o prog -lm
        ./prog > "pin$cut"
    done
    check "a pin: the same bits" cmp pin pin-DPDCORR_NO_SOLID
fi
check "kernels alone" strict -O1 -DPD_DIM=2 -c kernel_cut.c -o kernel_cut.o
check "kernels alone, linked" strict -O1 -DPD_DIM=2 user.c kernel_cut.o -o prog -lm
printf '#include "pdcorr.h"\nint main(void) { pd_setup s; return sizeof s == 0; }\n' > setup.c
check "no setup is declared" fails_with pd_setup c99 -DPD_DIM=2 -DPDCORR_NO_MODEL -c setup.c
check "both ways at once are refused" fails_with 'not both' c99 -DPD_DIM=2 -E both.c
if command -v "$CXX" > /dev/null; then
    check "private, C++11" \
        sh -c "$CXX -std=c++11 $warn $OMP -DPD_DIM=2 -x c++ kernel.c -o prog -lm > $dir/log 2>&1"
    check "private, C++11: run" prints exact
fi

# The program of scenes is one file.
for dim in ${PD_TEST_ALL:+2 3}; do
    fresh
    cp "$root/drivers/scene.c" "$root"/drivers/*.h "$dir/box"
    check "scene.c and its headers, $dim D: compile" c99 -DPD_DIM="$dim" scene.c -o prog -lm
    scene=pin_304_stream_2d
    [ "$dim" = 2 ] || scene=uniform_cu_3d
    check "scene.c and its headers, $dim D: run" \
        sh -c "./prog $root/examples/scenes/$scene.scene --check > log && grep -q 'bytes a node' log"
done
if [ "$PD_TEST_ALL" ]; then # `make` links it to a library
    fresh
    mkdir "$dir/box/drivers"
    cp "$root/drivers/validate.c" "$root/drivers/calm.h" "$dir/box/drivers"
    cp -r "$root/cases" "$dir/box"
    check "validate.c and its cases: compile" c99 -DPD_DIM=2 -I. drivers/validate.c -o prog -lm
    check "validate.c and its cases: run" sh -c "./prog poiseuille n=16 > log && grep -q 'result case=poiseuille' log"
fi

fresh two_dims.h two_dims_a.c two_dims_b.c two_dims_main.c user.c
check "implementation in 2D" plain 2
cp "$object" implementation.o
check "implementation in 3D" plain 3
check "user of 2D" c99 -c two_dims_a.c
check "user of 3D" c99 -c two_dims_b.c
check "2D and 3D: link" c99 two_dims_main.c two_dims_a.o two_dims_b.o implementation.o "$object" -o prog -lm
check "2D and 3D: run" prints "36 178"
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
