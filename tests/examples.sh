#!/bin/sh
# Every program of examples/ compiles alone with pdcorr.h, without a warning, and runs.
cc=${CC:-cc}
root=$PWD
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0
for file in examples/*.c; do
    name=$(basename "$file" .c)
    if "$cc" -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror ${OMP:-} -I. "$file" -o "$dir/$name" -lm > "$dir/log" 2>&1 &&
        (cd "$dir" && "./$name" "$root/examples/scenes/mg_pin_2d.scene") >> "$dir/log" 2>&1; then
        passed=$((passed + 1))
    else
        echo "$file failed:"
        tail -n 20 "$dir/log"
        failed=$((failed + 1))
    fi
done
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
