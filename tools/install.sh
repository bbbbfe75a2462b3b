#!/bin/sh
# install.sh install|uninstall|list|soname: puts header, libraries, programs, man pages, completions and scenes below
# DESTDIR/PREFIX, removes them, or prints their paths, or the name inside the shared library. `make install` sets the
# variables DESTDIR PREFIX BINDIR INCLUDEDIR LIBDIR DATADIR MANDIR BUILD OMP. Uninstalling removes these files, and
# folders that are pdcorr's own.
set -e
number() { sed -n "s/^#define PD_VERSION_$1 //p" src/core/config.h; }
major=$(number MAJOR) minor=$(number MINOR) patch=$(number PATCH)
version=$major.$minor.$patch
soname=libpdcorr.so.$major
[ "$major" != 0 ] || soname=libpdcorr.so.0.$minor # before 1.0 a minor version may change what programs rely on
if [ "$1" = soname ]; then
    echo "$soname"
    exit
fi
for folder in "$PREFIX" "$BINDIR" "$INCLUDEDIR" "$LIBDIR" "$DATADIR" "$MANDIR"; do
    case $folder in
    /*) ;;
    *) echo "install: found the folder '$folder', expected an absolute path" >&2; exit 2 ;;
    esac
done

# The files to be: "MODE SOURCE PATH", "link TARGET PATH" or "made SOURCE PATH", which fill replaces words in.
files() {
    for header in pdcorr.h pdcorr_app.h; do echo "644 $header $INCLUDEDIR/$header"; done
    for dim in 1 2 3; do echo "755 $BUILD/pd${dim}d $BINDIR/pd${dim}d"; done
    echo "755 $BUILD/lib/libpdcorr.so $LIBDIR/libpdcorr.so.$version"
    echo "link libpdcorr.so.$version $LIBDIR/$soname"
    echo "link $soname $LIBDIR/libpdcorr.so"
    echo "644 $BUILD/lib/libpdcorr.a $LIBDIR/libpdcorr.a"
    echo "made tools/install/pdcorr.pc.in $LIBDIR/pkgconfig/pdcorr.pc"
    echo "made tools/install/pdcorrConfig.cmake.in $LIBDIR/cmake/pdcorr/pdcorrConfig.cmake"
    echo "made tools/install/pdcorrConfigVersion.cmake.in $LIBDIR/cmake/pdcorr/pdcorrConfigVersion.cmake"
    echo "644 docs/pd2d.1 $MANDIR/man1/pd2d.1"
    echo "link pd2d.1 $MANDIR/man1/pd1d.1"
    echo "link pd2d.1 $MANDIR/man1/pd3d.1"
    echo "644 tools/install/pd2d.bash $DATADIR/bash-completion/completions/pd2d"
    echo "link pd2d $DATADIR/bash-completion/completions/pd1d"
    echo "link pd2d $DATADIR/bash-completion/completions/pd3d"
    echo "644 tools/install/_pd2d $DATADIR/zsh/site-functions/_pd2d"
    echo "644 LICENSE $DATADIR/doc/pdcorr/LICENSE"
    for folder in scenes electrolytes; do
        for file in $(find examples/$folder -type f | sort); do
            echo "644 $file $DATADIR/pdcorr/$folder/${file#examples/$folder/}"
        done
    done
}

# "../../..", from the folder of the CMake files to PREFIX; LIBDIR has to lie below it.
up() {
    case $LIBDIR/ in
    "$PREFIX"/*) echo "${LIBDIR#"$PREFIX"/}/cmake/pdcorr" | sed 's#[^/][^/]*#..#g' ;;
    *) echo "install: found LIBDIR=$LIBDIR, expected a folder below PREFIX=$PREFIX" >&2; return 1 ;;
    esac
}

fill() {
    static=
    [ -z "$OMP" ] || static=";$OMP"
    sed -e "s#@PREFIX@#$PREFIX#; s#@INCLUDEDIR@#$INCLUDEDIR#; s#@LIBDIR@#$LIBDIR#; s#@VERSION@#$version#" \
        -e "s#@UP@#$up#; s#@INCLUDE@#${INCLUDEDIR#"$PREFIX"/}#; s#@LIB@#${LIBDIR#"$PREFIX"/}#; s#@SONAME@#$soname#" \
        -e "s#@MAJOR@#$major#g; s#@MINOR@#$minor#g; s#@STATIC@#$static#" "$1"
}

case $1 in
install)
    up=$(up)
    case $INCLUDEDIR/ in
    "$PREFIX"/*) ;;
    *) echo "install: found INCLUDEDIR=$INCLUDEDIR, expected a folder below PREFIX=$PREFIX" >&2; exit 2 ;;
    esac
    files | while read -r kind source path; do
        mkdir -p "$DESTDIR${path%/*}"
        new=$DESTDIR$path.new # a program that runs keeps its file
        case $kind in
        link) ln -sf "$source" "$DESTDIR$path"; continue ;;
        made) fill "$source" > "$new" && chmod 644 "$new" ;;
        *) cp "$source" "$new" && chmod "$kind" "$new" ;;
        esac
        mv "$new" "$DESTDIR$path"
    done
    echo "installed pdcorr $version below $DESTDIR$PREFIX" ;;
uninstall)
    files | while read -r kind source path; do rm -f "$DESTDIR$path"; done
    for folder in pdcorr/scenes/validation pdcorr/scenes/templates pdcorr/scenes pdcorr/electrolytes pdcorr \
        doc/pdcorr; do
        rmdir "$DESTDIR$DATADIR/$folder" 2> /dev/null || true
    done
    rmdir "$DESTDIR$LIBDIR/cmake/pdcorr" 2> /dev/null || true
    echo "removed pdcorr $version from $DESTDIR$PREFIX" ;;
list) files | while read -r kind source path; do echo "$path"; done ;;
*) echo "usage: install.sh install|uninstall|list|soname" >&2; exit 2 ;;
esac
