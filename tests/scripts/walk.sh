#!/bin/sh
# slow: yes
# The tutorials by what they say: their commands and what these promise, and the study in Python. From a clone to the
# end of a way: tests/scripts/ways.sh; the tutorial of the page for browsers: tests/web.py.
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
           "change:make build/pd2d" "change:make amalgam lint" "change:make test T=keys_2d"; do
    sh tools/first.sh --commands "${way%%:*}" > "$dir/log" 2>&1
    check "docs/start.md: ${way%%:*}: ${way#*:}" grep -q "^${way#*:}" "$dir/log"
    check "docs/start.md has the way ${way%%:*}" grep -q "^| ${way%%:*} |" docs/start.md
done

find_python 'import numpy, matplotlib, sys; assert sys.version_info >= (3, 9)'
if [ "$python" ]; then
    block docs/tutorials/python.md 3 python > "$walk/study.py"
    export PDCORR_LIBRARY="$build/check" PYTHONDONTWRITEBYTECODE=1 MPLBACKEND=Agg
    export PYTHONPATH="$root/drivers/python${PYTHONPATH:+:$PYTHONPATH}"
    (cd "$walk" && $python study.py) > "$dir/log" 2>&1
    verdict "Python: a fit and a sweep"
    awk '/^v = / { v = $3 } / m\/s: / { lost[++runs] = $3 }
        END { exit !(v > 1 && v < 2.2 && runs == 3 && lost[1] < lost[2] && lost[2] < lost[3]) }' "$dir/log"
    verdict "Python: a speed of the wire, and more is lost in a faster stream"
else
    echo "skipped: numpy or matplotlib for Python is not installed: a study in Python"
    skipped=$((skipped + 1))
fi
score
