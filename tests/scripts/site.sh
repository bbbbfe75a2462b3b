#!/bin/sh
# slow: weekly
# The site: it builds without a warning, every link leads somewhere, every word is in a dictionary, every formula can be
# drawn; and the checks find what is wrong. Half a minute of processor time.
. tests/lib/script.sh

sh tools/site.sh "$dir/site" > "$dir/log" 2>&1
status=$?
[ $status != 3 ] || skip_all "$(cat "$dir/log")"
verdict "the site builds" $status
check "the start page" grep -q "Four ways in" "$dir/site/index.html"
check "a page for a room of the header" grep -q 'id="pd-grid-build"' "$dir/site/api/lattice.html"
check "the keys of the parser" grep -q "<code.*boundary_width" "$dir/site/keys.html"
[ "$(cat "$dir"/site/theory/*.html | grep -c '<div class="math')" -gt 400 ]
verdict "the theory has its equations"
for chapter in docs/theory/*.md; do
    name=$(basename "$chapter" .md)
    check "theory.md lists the chapter $name" grep -q "](theory/$name.md)" docs/theory.md
    check "the chapter $name has its equations" grep -q '<div class="math' "$dir/site/theory/$name.html"
done
check "the site is small: below 30 MB" [ "$(du -sm "$dir/site" | cut -f 1)" -lt 30 ]

# The checks find what is wrong.
python=python3
$python -c 'import sphinx' 2> /dev/null || python=/usr/bin/python3
mkdir -p "$dir/bad" "$dir/words"
cat > "$dir/bad/index.html" << 'END'
<a href="none.html">a</a><a href="#none">b</a><img src="https://example.org/a.png">
<p id="here">[x](y.md)</p><a href="#here">c</a>
END
echo "A corosoin test." > "$dir/words/a.md"
! $python docs/site/check.py "$dir/bad" "$dir/words" > "$dir/log"
verdict "a bad site is refused"
for words in "leads nowhere: none.html" "no such place: #none" "from a network" "shows markup" \
             "'corosoin' is in no dictionary"; do
    check "a bad site: $words" grep -qF "$words" "$dir/log"
done
check "a bad site: nothing else" [ "$(wc -l < "$dir/log")" = 5 ]

$python - > "$dir/log" 2>&1 << 'END'
import sys
sys.path.insert(0, "docs/site")
sys.dont_write_bytecode = True
import equations

for text, wanted in (
    ("u_i/t + (1 - t)/2 u''", r"\frac{u_{i}}{t} + \frac{1 - t}{2}\,u^{\prime \prime }"),
    ("sum_(n_r>0) w |xi|^(d+2)", r"\sum\limits_{n_{r}> 0} \,w \lvert \xi \rvert ^{d+2}"),
    ("d_ij = max(|F_ij|/2 - D a(n), 0)", r"d_{ij} = \max(\frac{\lvert F_{ij}\rvert }{2} - D\,a(n), 0)"),
    ("K_i^-1 xi.N <= 1e-3", r"K_{i}^{-1}\,\xi \cdot N \le  10^{-3}"),
):
    found = equations.latex(text)
    if found.split() != wanted.split():
        print(f"{text}: found {found}, expected {wanted}")
        sys.exit(1)
for code in ("pd_grid_build", "examples/04_pin.c", "--fit", "h = 5 um", "make run"):
    if equations.inline(code) is not None:
        sys.exit(f"{code} is no formula")
END
verdict "equations as LaTeX"

if command -v chromium > /dev/null; then
    mkdir -p "$dir/theory"
    for page in crevice $(cd "$dir/site" && ls theory/*.html | sed 's/\.html//'); do
        timeout 120 chromium --headless --no-sandbox --disable-gpu --virtual-time-budget=10000 --dump-dom \
            "file://$dir/site/$page.html" > "$dir/$page.html" 2> /dev/null
        check "$page: formulas are drawn" grep -q 'class="katex-display"' "$dir/$page.html"
        grep -o '<span class="katex-error"[^>]*>' "$dir/$page.html" > "$dir/log"
        check "$page: every formula" [ ! -s "$dir/log" ]
    done
else
    echo "skipped: chromium is not installed: whether every formula can be drawn"
    skipped=$((skipped + 1))
fi
score
