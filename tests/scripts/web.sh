#!/bin/sh
# slow: weekly
# The page for browsers (drivers/web) in headless Chromium: messages at their lines, a pin that runs, pauses, stops, and
# writes the files of pd2d. Screenshots come into build/web/screenshots.
. tests/lib/script.sh
. tests/lib/wasi.sh
python=/usr/bin/python3
for tool in chromium chromedriver; do command -v $tool > /dev/null || skip_all "$tool is not installed"; done
$python -c 'import selenium' 2> /dev/null || skip_all "selenium for Python is not installed"

sh tools/first.sh --commands browser > "$dir/run" 2> "$dir/log"
BUILD=$build sh -ec '. "$1"' sh "$dir/run" > "$dir/log" 2>&1
verdict "the page is built, by the commands of docs/tutorials/browser.md"
if [ "$failed" != 0 ]; then
    score
    exit 1
fi
most=1175000 # rooms of physics, of geometry and of what a user is told are a sixth more than a million
command -v wasm-opt > /dev/null || most=1230000
for dim in 1 2 3; do
    size=$(wc -c < "$build/web/pdcorr${dim}d.wasm")
    check "pdcorr${dim}d.wasm: $size bytes, expected at most $most" test "$size" -le "$most"
    sent=$(gzip -9 -c "$build/web/pdcorr${dim}d.wasm" | wc -c)
    check "pdcorr${dim}d.wasm: $sent bytes as it is sent, expected at most 530000" test "$sent" -le 530000
done
! grep -n '\.\(indexOf\|lastIndexOf\|includes\)(' drivers/web/worker.js drivers/web/wasi.js > "$dir/log"
verdict "no search by vectors before a run, after which Firefox computes slowly (worker.js, text)"

sed 's/h = 5 um/h = 10 um/; s/until = 9 h/until = 1 h/' examples/scenes/mg_pin_2d.scene > "$dir/mg_pin_2d.scene"
"$programs/pd2d" "$dir/mg_pin_2d.scene" --out "$dir/native" --threads 1 --quiet > "$dir/log" 2>&1
verdict "pd2d runs the pin"
timeout 900 $python tests/web.py "$build/web/index.html" "$dir" "$build/web/screenshots" \
    "$(command -v chromium)" "$(command -v chromedriver)" > "$dir/found" 2> "$dir/log"
verdict "the page was tried to the end"
grep -v '^[0-9]* passed' "$dir/found"
counts=$(sed -n 's/^\([0-9]*\) passed, \([0-9]*\) failed$/\1 \2/p' "$dir/found")
passed=$((passed + ${counts% *} + 0)) failed=$((failed + ${counts#* } + 0))
score
