#!/bin/sh
# site.sh [FOLDER]: builds the site from docs/ and the sources and checks it: pages in FOLDER (build/site), what they
# are made of in FOLDER.pages. Needs Sphinx with MyST and Furo, KaTeX, hunspell and pycparser (Debian: python3-sphinx
# python3-myst-parser furo libjs-katex hunspell hunspell-en-gb hunspell-en-us python3-pycparser). Status 3: they are not
# there.
build=${BUILD:-build}
out=${1:-$build/site}
katex=${KATEX:-/usr/share/javascript/katex}
python=
for candidate in python3 /usr/bin/python3; do
    if $candidate -c 'import sphinx, myst_parser, furo, pycparser' 2> /dev/null; then
        python=$candidate
        break
    fi
done
[ "$python" ] || { echo "the site needs Sphinx, MyST, Furo and pycparser for Python"; exit 3; }
[ -f "$katex/katex.min.js" ] || { echo "the site needs KaTeX in $katex"; exit 3; }
hunspell -d en_GB,en_US -l < /dev/null > /dev/null 2>&1 || {
    echo "the site needs hunspell with en_GB and en_US"
    exit 3
}
export PYTHONDONTWRITEBYTECODE=1
$python docs/site/stage.py "$out.pages" --build "$build" --katex "$katex" &&
    $python -m sphinx -q -W -n --keep-going -c docs/site -b html -d "$out.pages/.doctrees" "$out.pages" "$out" &&
    $python docs/site/check.py "$out" "$out.pages"
