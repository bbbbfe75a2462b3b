#!/bin/sh
# Every validation case on its coarse levels in 1D, 2D and 3D: no goal or guard is missed. And the driver's manners.
build=${BUILD:-build}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0

# verdict NAME STATUS WANTED: count, and show the log when the status is another one.
verdict() {
    if [ "$2" = "$3" ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "$1: status $2, expected $3"
        tail -n 40 "$dir/log"
    fi
}

for k in 1 2 3; do
    for name in $("$build/validate${k}d" --list | cut -d ' ' -f 1); do
        "$build/validate${k}d" "$name" --quick --check > "$dir/log" 2>&1
        verdict "$name ${k}d" $? 0
    done
done

# rejects MESSAGE ARGUMENT...: one line on stderr, nothing on stdout, status 2.
rejects() {
    printf 'validate2d: %s; validate2d --help tells the usage\n' "$1" > "$dir/wanted"
    shift
    "$build/validate2d" "$@" > "$dir/out" 2> "$dir/log"
    status=$?
    [ -s "$dir/out" ] && status="$status with output"
    cmp -s "$dir/log" "$dir/wanted" || status="$status with another message"
    verdict "validate2d $*" "$status" 2
}
rejects "no case has the name (--list prints them) poiseuile" poiseuile
rejects "unknown option --fast" --fast
rejects "unknown key (m and n can be set): h=1" h=1
rejects "m expects a number from 1 to 12, found m=30" m=30
rejects "--threads expects a number from 0 to 1024" --threads
rejects "--out expects a folder" --out

# The report: a section, its figures and a summary, and the same text again.
"$build/validate2d" patch --quick --quiet --out "$dir/a" > "$dir/log" 2>&1 &&
    "$build/validate2d" patch --quick --quiet --out "$dir/b" >> "$dir/log" 2>&1
verdict "report" $? 0
for name in patch_2d.md patch_2d_1_errors.png summary_2d.md; do
    [ -s "$dir/a/$name" ] || echo "no $name"
done > "$dir/log"
sed 's/ [0-9.]* |$//' "$dir/a/patch_2d.md" > "$dir/one"
sed 's/ [0-9.]* |$//' "$dir/b/patch_2d.md" > "$dir/two"
cmp "$dir/one" "$dir/two" >> "$dir/log" 2>&1
cmp "$dir/a/summary_2d.md" "$dir/b/summary_2d.md" >> "$dir/log" 2>&1
verdict "files of the report" "$(wc -l < "$dir/log" | tr -d ' ')" 0
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
