#!/bin/sh
# docs/architecture.md and its drawing show the rooms and modules that src/ has.
. tests/lib/script.sh

sh tools/rooms.sh --check > "$dir/log" 2>&1
verdict "sh tools/rooms.sh brings docs/architecture.md to the modules of src/"
for file in $(grep -o '`src/[a-z_/]*\.[ch]`' docs/architecture.md | tr -d '`' | sort -u); do
    check "docs/architecture.md names $file" test -f "$file"
done
score
