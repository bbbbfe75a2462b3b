#!/bin/sh
# slow: yes
# The way of a new user, by what the pages say: the commands of the tutorials and what they promise, figures and laws in
# Python, and the first change of CONTRIBUTING in a fresh clone. What uses installed files is in tests/install.sh, the
# tutorial of the page for browsers is walked in tests/web.py.
. tests/lib/script.sh
walk=$dir/walk
mkdir -p "$walk"
ln -s "$programs" "$walk/build"
ln -s "$root/examples" "$walk/examples"

# commands PAGE: the blocks of commands of a page, but for those that are marked slow: "run COMMAND", "says TEXT".
commands() {
    awk '/^<!-- slow -->/ { slow = 1; next }
        /^```/ { fenced = !fenced }
        !fenced && /^    / {
            inside = 1
            if (!slow) { sub(/^    /, ""); print (sub(/^# */, "") ? "says " : "run ") $0 }
            next
        }
        inside && !/^$/ { inside = slow = 0 }' "$1"
}
for page in docs/tutorials/*.md; do
    commands "$page" > "$dir/commands"
    while read -r what text; do
        if [ "$what" = run ]; then
            (cd "$walk" && sh -c "$text") > "$dir/log" 2>&1 < /dev/null
            verdict "$page: $text"
        else
            check "$page says $text" grep -qF -- "$text" "$dir/log"
        fi
    done < "$dir/commands"
done
check "tutorials have commands" [ -d "$walk/out/wire" ]
for picture in wire/volume_loss.png pit/total_pit.csv crevice/simulation.pvd look/grip_x+.csv; do
    check "out/$picture" [ -s "$walk/out/$picture" ]
done

# What tools/first.sh times on a fresh machine is what the pages say.
for way in "figure:make python" "figure:python3 figure.py" "law:python3 law.py" "browser:make web" \
           "pkg-config:make install" "pkg-config:LD_LIBRARY_PATH=" "cmake:make install" "cmake:cmake/main" \
           "change:make amalgam lint" "change:make build/logs/test_keys_2d.log"; do
    sh tools/first.sh --commands "${way%%:*}" > "$dir/log" 2>&1
    check "docs/start.md: ${way%%:*}: ${way#*:}" grep -q "^${way#*:}" "$dir/log"
    check "docs/start.md has the way ${way%%:*}" grep -q "^| ${way%%:*} |" docs/start.md
done

python=
for candidate in python3 /usr/bin/python3; do
    if $candidate -c 'import numpy, matplotlib, sys; assert sys.version_info >= (3, 9)' 2> /dev/null; then
        python=$candidate
        break
    fi
done
if [ "$python" ]; then
    block docs/tutorials/python.md 1 python > "$walk/figure.py"
    block docs/tutorials/python.md 2 python > "$walk/law.py"
    block docs/tutorials/python.md 3 python > "$walk/study.py"
    export PDCORR_LIBRARY="$build/check" PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg
    export PYTHONPATH="$root/drivers/python${PYTHONPATH:+:$PYTHONPATH}"
    (cd "$walk" && $python figure.py) > "$dir/log" 2>&1
    verdict "Python: a first figure"
    check "Python: the figure" [ "$(head -c 4 "$walk/figure.png" | od -An -tx1 | tr -d ' \n')" = 89504e47 ]
    (cd "$walk" && $python law.py) > "$dir/log" 2>&1
    verdict "Python: a law"
    awk '{ lost[NR] = $(NF - 7); if ($NF + 0 > 1e-12 || $NF + 0 < -1e-12) wrong = 1 }
        END { exit wrong || NR != 2 || !(lost[2] > 0 && lost[2] < lost[1]) }' "$dir/log"
    verdict "Python: less is lost with a film, and amounts balance"
    (cd "$walk" && $python study.py) > "$dir/log" 2>&1
    verdict "Python: a fit and a sweep"
    awk '/^v = / { v = $3 } / m\/s: / { lost[++runs] = $3 }
        END { exit !(v > 1 && v < 2.2 && runs == 3 && lost[1] < lost[2] && lost[2] < lost[3]) }' "$dir/log"
    verdict "Python: a speed of the wire, and more is lost in a faster stream"
else
    echo "skipped: numpy or matplotlib for Python is not installed: the tutorial in Python"
    skipped=$((skipped + 1))
fi

# The first change: other words for a key. Objects of this checkout spare the clone what it would compile first.
if git -C "$root" rev-parse HEAD > /dev/null 2>&1; then
    clone=$dir/clone
    git clone -q --depth 1 "file://$root" "$clone" > "$dir/log" 2>&1
    verdict "a clone"
    mkdir -p "$clone/build"
    [ "$(git -C "$root" status --porcelain -uno)" ] || # else they are not those of the clone
        cp -r "$build/obj2d" "$build/flags" "$clone/build/" 2> /dev/null
    words='spacing, one or one an axis'
    check "the words are in src/scene/keys.c" grep -q "$words" "$clone/src/scene/keys.c"
    find "$clone/build" -type f -exec touch {} +
    # as the user sees it: first the one file, then both
    changed() {
        sed "s/$words/distance of the nodes, $words/" "$clone/$1" > "$dir/changed" && cp "$dir/changed" "$clone/$1"
    }
    tested() {
        (cd "$clone" && make CC="${CC:-cc}" amalgam lint build/logs/test_keys_2d.log) > "$dir/log" 2>&1 &&
            grep -q '^exit 0' "$clone/build/logs/test_keys_2d.log"
    }
    changed src/scene/keys.c
    ! tested
    verdict "a key whose words are not those of the guide is found"
    changed docs/guide.md
    check "the first change passes its test" tested
    check "the header has the change" grep -q "distance of the nodes, $words" "$clone/pdcorr.h"
else
    echo "skipped: this is no git checkout: the first change in a clone"
    skipped=$((skipped + 1))
fi
score
