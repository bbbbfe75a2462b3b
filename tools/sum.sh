#!/bin/sh
# sum.sh [--since FILE] LOG...: one line for each log, what was skipped, the whole log where something failed, and the
# sum last. --since: FILE holds the second in which the tests began; logs without a failure have had their line.
# A log ends with "exit N"; its result is the last line "N passed, N failed[, N skipped]" or else its exit status.
passed=0 failed=0 skipped=0 begin=
if [ "$1" = --since ]; then
    begin=$(cat "$2")
    shift 2
fi
logs=$#
for log in "$@"; do
    name=$(basename "$log" .log)
    if [ ! -f "$log" ]; then
        echo "FAILED $name: not built"
        failed=$((failed + 1))
        continue
    fi
    status=$(sed -n '$s/^exit //p' "$log")
    result=$(grep -E '^[0-9]+ passed, [0-9]+ failed(, [0-9]+ skipped)?$' "$log" | tail -n 1)
    if [ -z "$result" ]; then
        [ "$status" = 0 ] && result='1 passed, 0 failed' || result='0 passed, 1 failed'
    fi
    set -- $(echo "$result" | tr -dc '0-9 ')
    p=$1 f=$2 s=${3:-0}
    [ "$status" != 0 ] && [ "$f" = 0 ] && f=1
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
    if [ "$f" != 0 ]; then
        echo "FAILED $name: $result (exit $status)"
        sed 's/^/    /' "$log"
    else
        [ -n "$begin" ] || echo "ok     $name: $result"
        grep '^skipped: ' "$log" | sed 's/^/    /'
    fi
done
[ -z "$begin" ] || echo "$logs logs in $(($(date +%s) - begin)) s"
if [ "$skipped" = 0 ]; then
    echo "$passed passed, $failed failed"
else
    echo "$passed passed, $failed failed, $skipped skipped"
fi
[ "$failed" = 0 ]
