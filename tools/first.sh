#!/bin/sh
# first.sh WAY URL: one way of a new user, by what the pages say alone, timed. WAY is a row of docs/start.md: figure,
# law, browser, pkg-config, cmake, change. As root on a Debian machine on which nothing is installed, such as a folder
# that debootstrap has made. It clones URL into a new folder, with an environment of its own. Prints seconds for
# packages and commands, and the processor time of the commands.
# first.sh --commands WAY: what it would run, of the pages of this checkout.

# indented PAGE FROM TO: the commands of a page from the line FROM to the line TO.
indented() {
    awk -v from="$2" -v to="$3" '$0 ~ from { on = 1 } on && $0 ~ to { on = 0 } /^```/ { fenced = !fenced }
        on && !fenced && /^(       |    )[^ ]/ { sub(/^ +/, ""); print }' "$1"
}
# put PAGE NUMBER LANGUAGE FILE: that block of code of a page into a file.
put() {
    echo "cat > $4 << 'END_OF_FILE'"
    awk -v n="$2" -v fence="\`\`\`$3" '$0 == fence { k++; inside = k == n; next } /^```/ { inside = 0 } inside' "$1"
    echo END_OF_FILE
}

commands() {
    python=docs/tutorials/python.md program=docs/tutorials/program.md change=.github/CONTRIBUTING.md
    words='spacing, one or one an axis'
    case $1 in
    figure) put $python 1 python figure.py; indented $python '^## The package' '^## A first'; echo python3 figure.py ;;
    law) put $python 2 python law.py; indented $python '^## The package' '^## A first'; echo python3 law.py ;;
    browser) indented docs/tutorials/browser.md '^## Open' '^## Change' ;;
    pkg-config) put $program 1 c main.c; indented $program '^## With pkg-config' '^## With CMake' ;;
    cmake)
        put $program 1 c main.c
        put $program 1 cmake CMakeLists.txt
        indented $program '^## With pkg-config' '^ *export'
        indented $program '^## With CMake' '^What is installed' ;;
    change)
        indented $change '^1\. Clone' '^2\. ' | sed '/^git clone/d; /^cd pdcorr/d'
        echo "sed -i 's/$words/distance of the nodes, $words/' src/scene/keys.c docs/guide.md"
        indented $change '^3\. Bring' '^4\. '
        echo 'git -c user.name=me -c user.email=me@example.org commit -qam "Keys: other words for the spacing"' ;;
    *) return 1 ;;
    esac
}
if [ "$1" = --commands ]; then
    commands "$2"
    exit
fi

way=$1 url=$2
dir=$(mktemp -d) && cd "$dir" && mkdir home || exit 1
log=$dir/log
clean() { env -i HOME="$dir/home" PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
install() { clean apt-get install -y --no-install-recommends "$@" >> "$log" 2>&1; }
fail() {
    tail -n 30 "$log"
    exit 1
}

begin=$(date +%s)
clean apt-get update > "$log" 2>&1 && install git ca-certificates || fail
clean git clone -q "$url" pdcorr >> "$log" 2>&1 || fail
cd pdcorr || exit 1
packages=$(awk -F '|' -v way="$way" '$2 == " " way " " { gsub(/`/, "", $3); print $3; exit }' docs/start.md)
[ "$packages" ] || { echo "docs/start.md has no way $way"; exit 2; }
# shellcheck disable=SC2086
install $packages || fail
installed=$(date +%s)
commands "$way" > "$dir/run"
clean sh -ec '. "$1"; times > times' sh "$dir/run" > "$log" 2>&1 || fail
tail -n 3 "$log"
echo "$way: packages $((installed - begin)) s, commands $(($(date +%s) - installed)) s, processor $(tail -n 1 times)"
