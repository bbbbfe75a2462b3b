#!/bin/sh
# slow: weekly
# The ways of docs/start.md in a clone, each by the commands of its page as tools/first.sh reads them: a figure and a
# law in Python, a program of C by pkg-config and CMake, the first change. Programs are compiled without optimisation.
# The way into the browser is in tests/scripts/web.sh.
. tests/lib/script.sh
git -C "$root" rev-parse HEAD > /dev/null 2>&1 || skip_all "this is no git checkout: nothing to clone"
[ -z "$(git -C "$root" status --porcelain -uno)" ] || echo "note: the clone has the last commit, not what changed since"

clone=$dir/clone
mkdir "$dir/home"
git clone -q --depth 1 "file://$root" "$clone" > "$dir/log" 2>&1
verdict "a clone"
# in_clone COMMAND...: as a user runs it there.
in_clone() {
    (cd "$clone" && env -u BUILD -u OMP -u PROGRAMS -u PYTHONPATH -u MAKEFLAGS -u MAKELEVEL HOME="$dir/home" \
        CC="${CC:-cc}" CFLAGS='-std=c99 -O0' MPLBACKEND=Agg "$@")
}
# way NAME: its commands, of the clone's pages.
way() {
    in_clone sh tools/first.sh --commands "$1" > "$dir/run" 2> "$dir/log"
    verdict "the commands of the way $1"
    in_clone sh -ec '. "$1"' sh "$dir/run" > "$dir/log" 2>&1
    verdict "the way $1"
}

# What this checkout has compiled spares the clone most of that: objects of the tests, programs and libraries but those
# of two dimensions.
in_clone make build/flags > "$dir/log" 2>&1
if [ -z "$(git -C "$root" status --porcelain -uno)" ]; then # else they are not those of the clone
    mkdir "$clone/build/lib"
    cp -r "$build/obj2d" "$clone/build/" 2> /dev/null
    for dim in 1 3; do
        plain $dim && cp "$object" "$clone/build/lib/pdcorr${dim}d.o"
        cp "$build/pdcorr${dim}d.o" "$programs/pd${dim}d" "$clone/build/" 2> /dev/null
    done
    find "$clone/build/obj2d" "$clone/build/lib" "$clone"/build/*[13]d* -type f -exec touch {} +
fi

find_python 'import numpy, matplotlib, sys; assert sys.version_info >= (3, 9)'
if [ "$python" ]; then
    mkdir "$dir/bin" # python3 of the pages
    ln -s "$(command -v $python)" "$dir/bin/python3"
    PATH=$dir/bin:$PATH
    way figure
    check "the figure" [ "$(head -c 4 "$clone/figure.png" | od -An -tx1 | tr -d ' \n')" = 89504e47 ]
    way law
    awk '/ % lost in / { lost[++n] = $(NF - 7); if ($NF + 0 > 1e-12 || $NF + 0 < -1e-12) wrong = 1 }
        END { exit wrong || n != 2 || !(lost[2] > 0 && lost[2] < lost[1]) }' "$dir/log"
    verdict "less is lost with a film, and amounts balance"
else
    echo "skipped: numpy or matplotlib for Python is not installed: the ways figure and law"
    skipped=$((skipped + 1))
fi

for tool in pkg-config cmake; do
    if command -v $tool > /dev/null; then
        way $tool
        check "the program by $tool" grep -q '^C \[mol/m3\] is [0-9.e+-]* in the corner after 7200 s$' "$dir/log"
    else
        echo "skipped: $tool is not installed: the way $tool"
        skipped=$((skipped + 1))
    fi
done

# The first change: other words for a key.
words='spacing, one or one an axis'
way change
check "its test passes" grep -q '^exit 0' "$clone/build/logs/test_keys_2d.log"
check "the header has the change" grep -q "distance of the nodes, $words" "$clone/pdcorr_app.h"
check "it is committed" [ -z "$(git -C "$clone" status --porcelain -uno)" ]
cp docs/guide.md "$clone/docs/guide.md"
in_clone make test T=keys_2d > "$dir/log" 2>&1
! grep -q '^exit 0' "$clone/build/logs/test_keys_2d.log"
verdict "a key whose words are not those of the guide is found"
score
