#!/bin/sh
# tools/log.sh: what a command said and its status; a command that does not end is stopped and has failed.
. tests/lib/script.sh

# log OF COMMAND...: its log is $dir/one.log, what it says $dir/said.
log() {
    sh tools/log.sh "$dir/one.log" "$@" > "$dir/said" 2>&1
    cp "$dir/one.log" "$dir/log"
}

log '' sh -c 'echo of interest; exit 3'
check "a command that fails" [ "$(cat "$dir/one.log")" = "of interest
exit 3" ]
log '' sh -c 'echo "2 passed, 0 failed"'
check "a command that ends" [ "$(tail -n 1 "$dir/one.log")" = "exit 0" ]
date +%s > "$dir/begin"
log 1 sh -c 'echo "2 passed, 0 failed"'
grep -q '^\[  1 of 1\] .* ok one: 2 passed, 0 failed (.* s of processor time)$' "$dir/said"
verdict "how far the tests are"
OF=1 PD_TEST_LIMIT=0 log 1 sh -c 'sleep 1; exit 124'
check "without a limit a status is that of the command" [ "$(cat "$dir/one.log")" = "exit 124" ]

# without `timeout`: no limit, and all else as before
mkdir "$dir/bin"
for tool in sh dirname mkdir awk rm mv date ls grep tail basename cat head; do
    ln -s "$(command -v $tool)" "$dir/bin/$tool"
done
PATH=$dir/bin PD_TEST_LIMIT=1 sh tools/log.sh "$dir/one.log" '' sh -c 'echo of interest; exit 3'
check "a machine without timeout" [ "$(cat "$dir/one.log")" = "of interest
exit 3" ]

if ! timeout -k 1 1 true 2> /dev/null; then
    echo "skipped: timeout of coreutils is not there"
    skipped=1
    score
    exit
fi
begin=$(date +%s)
PD_TEST_LIMIT=1 log 1 sh -c 'echo "2 passed, 0 failed"; (sleep 3; touch "$0") & sleep 61' "$dir/late"
check "it is stopped soon" [ $(($(date +%s) - begin)) -lt 30 ]
check "what the log says" [ "$(cat "$dir/one.log")" = "2 passed, 0 failed
stopped: no end after 1 s (PD_TEST_LIMIT)
exit 124" ]
grep -q 'FAILED one: stopped: no end after 1 s' "$dir/said"
verdict "what the line of progress says"
! sh tools/sum.sh "$dir/one.log" > "$dir/log"
verdict "the sum of what was stopped"
check "its failure is counted" [ "$(tail -n 1 "$dir/log")" = "2 passed, 1 failed" ]
# a command that does not listen is killed, ten seconds later
PD_TEST_LIMIT=1 log '' sh -c 'trap "" TERM; sleep 0.1; while :; do sleep 0.2; done'
check "a command that does not listen" [ "$(tail -n 2 "$dir/one.log")" = "stopped: no end after 1 s (PD_TEST_LIMIT)
exit 137" ]
check "what a stopped command had started is stopped" [ ! -e "$dir/late" ]
score
