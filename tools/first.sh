#!/bin/sh
# first.sh WAY URL: one way of a new user, by the commands of the pages alone, timed. WAY: figure, law, browser, pkg-config,
# cmake or change, a row of docs/start.md. For a Debian machine on which nothing is installed yet (debootstrap makes one
# in a folder), as root. Works in a new folder with an environment of its own. Prints seconds: packages, commands, and
# the processor time of those.
way=$1 url=$2
dir=$(mktemp -d) && cd "$dir" || exit 1
mkdir home
log=$dir/log

clean() { env -i HOME="$dir/home" PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
now() { date +%s; }
# indented PAGE FROM TO: the blocks of commands from the line FROM to the line TO, both patterns.
indented() {
    awk -v from="$2" -v to="$3" '$0 ~ from { on = 1 } on && $0 ~ to { on = 0 } /^```/ { fenced = !fenced }
        on && !fenced && /^(       |    )[^ ]/ { sub(/^ +/, ""); print }' "$1"
}
# fenced PAGE NUMBER LANGUAGE: that block of code.
fenced() {
    awk -v n="$2" -v fence="\`\`\`$3" '$0 == fence { k++; inside = k == n; next } /^```/ { inside = 0 } inside' "$1"
}

# The page lies in the repository, whose address a reader has: git alone stands before the clock.
begin=$(now)
clean apt-get update > "$log" 2>&1 && clean apt-get install -y --no-install-recommends git ca-certificates >> "$log" 2>&1 &&
    clean git clone -q "$url" pdcorr >> "$log" 2>&1 && cd pdcorr || { cat "$log"; exit 1; }
packages=$(awk -F '|' -v way="$way" '$2 ~ way { gsub(/`/, "", $3); print $3 }' docs/start.md)
[ "$packages" ] || { echo "docs/start.md has no way $way"; exit 2; }
# shellcheck disable=SC2086
clean apt-get install -y --no-install-recommends $packages >> "$log" 2>&1 || { tail "$log"; exit 1; }
installed=$(now)

page=docs/tutorials/program.md
case $way in
figure)
    fenced docs/tutorials/python.md 1 python > figure.py
    { indented docs/tutorials/python.md '^## The package' '^## A first'; echo 'python3 figure.py'; } > run ;;
law)
    fenced docs/tutorials/python.md 2 python > law.py
    { indented docs/tutorials/python.md '^## The package' '^## A first'; echo 'python3 law.py'; } > run ;;
browser) indented docs/tutorials/browser.md '^## Open' '^## Change' > run ;;
pkg-config)
    fenced $page 1 c > main.c
    indented $page '^## With pkg-config' '^## With CMake' > run ;;
cmake)
    fenced $page 1 c > main.c
    fenced $page 1 cmake > CMakeLists.txt
    { indented $page '^## With pkg-config' 'export'; indented $page '^## With CMake' '^What is installed'; } > run ;;
change)
    words='spacing, one or one an axis'
    echo "sed -i 's/$words/distance of the nodes, $words/' src/scene/keys.c docs/guide.md" > run
    indented .github/CONTRIBUTING.md '^1\. Clone' '^4\. ' | sed '/^git clone/d; /^cd pdcorr/d' >> run
    echo 'git -c user.name=me -c user.email=me@example.org commit -qam "Keys: other words for the spacing"' >> run ;;
esac
cat run
clean sh -ec '. ./run; times > times' > "$log" 2>&1 || { tail -n 30 "$log"; exit 1; }
tail -n 3 "$log"
done=$(now)
echo "$way: packages $((installed - begin)) s, commands $((done - installed)) s, processor: $(tail -n 1 times)"
