#!/bin/sh
# slow: yes
# make install: what it writes and what not; programs that use the header, the shared and the static library, by
# pkg-config and CMake, also where the tree has been moved; make uninstall. As a page says it: tests/scripts/ways.sh.
. tests/lib/script.sh
CC=${CC:-cc}
prefix=/opt/pd
tree=$dir/root$prefix

# made TARGET: with the programs that are built, and libraries that need no speed: that of two dimensions is compiled.
mkdir -p "$dir/build/lib"
cp "$programs/pd1d" "$programs/pd2d" "$programs/pd3d" "$dir/build"
for dim in 1 3; do
    plain $dim
    cp "$object" "$dir/build/lib/pdcorr${dim}d.o"
done
made() {
    make CC="$CC" BUILD="$dir/build" CFLAGS='-std=c99 -O0' OPENMP=0 DESTDIR="$dir/root" PREFIX=$prefix \
        -o "$dir/build/pd1d" -o "$dir/build/pd2d" -o "$dir/build/pd3d" -o "$dir/build/lib/pdcorr1d.o" \
        -o "$dir/build/lib/pdcorr3d.o" "$1" > "$dir/log" 2>&1
}
files() { (cd "$1" && find . ! -type d | sed 's#^\./##' | sort); }

mkdir -p "$dir/root"
check "make install" made install
version=$("$tree/bin/pd2d" --version | sed 's/pdcorr //')
short=${version%.*}
{
    for dim in 1 2 3; do
        echo "bin/pd${dim}d share/man/man1/pd${dim}d.1 share/bash-completion/completions/pd${dim}d"
    done
    echo "include/pdcorr.h include/pdcorr_app.h"
    echo "lib/libpdcorr.a lib/libpdcorr.so lib/libpdcorr.so.$short lib/libpdcorr.so.$version"
    echo "lib/pkgconfig/pdcorr.pc lib/cmake/pdcorr/pdcorrConfig.cmake lib/cmake/pdcorr/pdcorrConfigVersion.cmake"
    echo "share/zsh/site-functions/_pd2d share/doc/pdcorr/LICENSE"
    files examples/scenes | sed 's#^#share/pdcorr/scenes/#'
    files examples/electrolytes | sed 's#^#share/pdcorr/electrolytes/#'
} | tr ' ' '\n' | sort > "$dir/wanted"
files "$tree" > "$dir/found"
diff "$dir/wanted" "$dir/found" > "$dir/log"
verdict "the files that make install writes"
check "no file outside of the prefix" [ "$(files "$dir/root" | wc -l)" = "$(wc -l < "$dir/wanted")" ]
check "a link in the tree for every name of the library" [ -e "$tree/lib/libpdcorr.so" ]
check "no path of the build in what is installed" \
    sh -c '! grep -rlF "$1" "$2/lib/pkgconfig" "$2/lib/cmake" "$2/share"' sh "$dir" "$tree"
check "an installed program runs an installed scene" sh -c \
    '"$1/bin/pd2d" "$1/share/pdcorr/scenes/plate_hole_2d.scene" --check > "$2/log" 2>&1' sh "$tree" "$dir"

# prints DIM BONDS PROGRAM: the line of tests/install/main.c.
prints() { [ "$("$3" 2> "$dir/log")" = "$version $version dim=$1 bonds=$2" ]; }

if command -v pkg-config > /dev/null; then
    # of the tree as it lies here
    pc() { PKG_CONFIG_LIBDIR="$tree/lib/pkgconfig" PKG_CONFIG_SYSROOT_DIR="$dir/root" pkg-config "$@" pdcorr; }
    check "pkg-config: the version" [ "$(pc --modversion)" = "$version" ]
    # shellcheck disable=SC2046
    $CC -std=c99 -DPD_DIM=2 -DPDCORR_STATIC -DPDCORR_NO_PHYSICS $(pc --cflags) tests/install/main.c \
        -o "$dir/main" $(pc --libs) 2> "$dir/log"
    verdict "pkg-config: the header"
    check "pkg-config: the header: run" prints 2 36 "$dir/main"
    for case in "1 6" "2 36" "3 178"; do
        dim=${case% *}
        # shellcheck disable=SC2046
        $CC -std=c99 -DPD_DIM="$dim" $(pc --cflags) tests/install/main.c -o "$dir/main" -lpdcorr $(pc --libs) \
            2> "$dir/log"
        verdict "pkg-config: the shared library in ${dim}D"
        LD_LIBRARY_PATH=$tree/lib prints "$dim" "${case#* }" "$dir/main"
        verdict "pkg-config: the shared library in ${dim}D: run"
    done
    if command -v readelf > /dev/null; then
        readelf -d "$dir/main" | grep -q "NEEDED.*\[libpdcorr.so.$short\]"
        verdict "a program asks for libpdcorr.so.$short"
    fi
else
    echo "skipped: pkg-config is not installed"
    skipped=$((skipped + 1))
fi
if command -v nm > /dev/null; then
    nm -D --defined-only "$tree/lib/libpdcorr.so" | awk '$2 ~ /[TDBR]/ && $3 !~ /^pd_.*_[123]d$/ { print; wrong = 1 }
        END { exit wrong }' > "$dir/log"
    verdict "the shared library offers names of its own alone"
fi

# consumer TREE [VERSION]; with a version it keeps what CMake knows of the compiler.
consumer() {
    [ -n "$2" ] || rm -rf "$dir/cmake"
    CC=$CC cmake -U pdcorr_DIR -S tests/install -B "$dir/cmake" -DCMAKE_PREFIX_PATH="$1" -DWANTED="$2" > "$dir/log" 2>&1
}
if command -v cmake > /dev/null; then
    mkdir -p "$dir/moved"
    for place in "$tree" "$dir/moved/pd"; do
        [ "$place" = "$tree" ] || mv "$tree" "$place"
        check "CMake: find_package in $place" consumer "$place"
        check "CMake: build" sh -c 'cmake --build "$1/cmake" > "$1/log" 2>&1' sh "$dir"
        check "CMake: the header" prints 2 36 "$dir/cmake/header"
        check "CMake: the shared library" prints 3 178 "$dir/cmake/shared"
        check "CMake: the static library" prints 3 178 "$dir/cmake/static"
        [ "$place" = "$tree" ] || mv "$place" "$tree"
    done
    check "CMake: this version" consumer "$tree" "$version"
    for other in 0.0.9 0.2 1.0 9.1; do
        ! consumer "$tree" $other && grep -q "not accepted:" "$dir/log"
        verdict "CMake: version $other is not found"
    done
else
    echo "skipped: cmake is not installed"
    skipped=$((skipped + 1))
fi

echo mine > "$tree/share/pdcorr/mine"
check "make uninstall" made uninstall
check "only what others have put there stays" [ "$(files "$dir/root")" = "${prefix#/}/share/pdcorr/mine" ]
rm "$tree/share/pdcorr/mine"
check "make uninstall again" made uninstall
check "no folder of its own stays" [ ! -e "$tree/share/pdcorr" ]

DESTDIR="$dir/root" PREFIX=opt BINDIR=/b INCLUDEDIR=/i LIBDIR=/l DATADIR=/d MANDIR=/m BUILD=b OMP='' \
    sh tools/install.sh install > "$dir/log" 2>&1
[ $? = 2 ] && grep -q "found the folder 'opt', expected an absolute path" "$dir/log"
verdict "a relative prefix is refused"
score
