#!/bin/sh
# The options of --help are those of the man page, the shell completions and the guide; the man page has no mistake that
# man or mandoc see.
. tests/lib/script.sh

"$programs/pd2d" --help | sed -n 's/^  \(--[a-z-]*\).*/\1/p' | sort -u > "$dir/wanted"
check "--help has options" [ "$(wc -l < "$dir/wanted")" -ge 16 ]
"$programs/pd2d" --help | head -n 4 | grep -o -e '--[a-z-]*' | sort -u > "$dir/usage"
sed -n 's/^\.It Fl -\([a-z-]*\).*/--\1/p' docs/pd2d.1 | sort > "$dir/man"
sed -n '/^\.Sh SYN/,/^\.Sh DES/p' docs/pd2d.1 | grep -o 'Fl -[a-z-]*' | sed 's/Fl -/--/' | sort -u > "$dir/synopsis"
sed -n '/options="/,/"$/p' tools/install/pd2d.bash | grep -o -e '--[a-z-]*' | sort > "$dir/bash"
sed -n "s/^    '\**\(--[a-z-]*\)\[.*/\1/p" tools/install/_pd2d | sort > "$dir/zsh"
sed -n '/^## 5 The programs/,/^`pd1d`/p' docs/guide.md | grep -o -e '--[a-z-]*' | sort -u > "$dir/guide"
for text in usage man synopsis bash zsh guide; do
    diff "$dir/wanted" "$dir/$text" > "$dir/log"
    verdict "the options of --help and those of $text"
done
for text in docs/pd2d.1 tools/install/pd2d.bash tools/install/_pd2d; do
    for dim in 1 2 3; do check "$text: pd${dim}d" grep -q "pd${dim}d" $text; done
done

# lints COMMAND...: it says nothing but of the length of lines.
lints() {
    command -v "$1" > /dev/null || { echo "skipped: $1 is not installed"; skipped=$((skipped + 1)); return; }
    "$@" 2>&1 > "$dir/out" | cat - "$dir/out" | grep -E 'warning|WARNING|ERROR' > "$dir/log"
    check "$*" [ ! -s "$dir/log" ]
}
lints mandoc -Tlint docs/pd2d.1
if command -v man > /dev/null && man --warnings -l docs/pd2d.1 > /dev/null 2>&1; then
    man --warnings -l docs/pd2d.1 2> "$dir/log" > /dev/null
    check "man --warnings" [ ! -s "$dir/log" ]
fi

if command -v bash > /dev/null; then
    # completes WANTED WORD...: the completions of the last word.
    completes() {
        wanted=$1
        shift
        found=$(bash -c '. tools/install/pd2d.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _pdcorr "$1"
            echo "${COMPREPLY[*]}"' bash "$programs/pd2d" "$@" 2> "$dir/log")
        [ "$found" = "$wanted" ]
        verdict "pd2d $*: completes to '$found', expected '$wanted'" $?
    }
    completes "--threads" --thr
    completes "pit plate" --new p
    completes "constants corrode crack chemistry" --keys c
    completes "examples/scenes/mg_wire.scene" examples/scenes/mg_wire.
fi
score
