#!/bin/sh
# log.sh LOG OF COMMAND...: runs the command and writes LOG: what it said, then a line "exit N". With OF, the number of
# logs to come, it says how far the tests are, in seconds since LOG's folder got its file `begin`. Programs run side by
# side: each has one thread unless OMP_NUM_THREADS says otherwise, and threads sleep at barriers.
log=$1 of=$2
shift 2
folder=$(dirname "$log")
mkdir -p "$folder"
OMP_WAIT_POLICY=passive OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} "$@" > "$log.new" 2>&1
status=$?
times > "$log.times" # of this shell, of the command
seconds=$(awk '{ u = 0; for (k = 1; k <= 2; k++) { split($k, t, /[ms]/); u += 60 * t[1] + t[2] } }
    END { printf "%.1f", u }' "$log.times")
rm -f "$log.times"
echo "exit $status" >> "$log.new"
mv "$log.new" "$log"
[ -n "$of" ] && [ -f "$folder/begin" ] || exit 0
done=$(ls "$folder" | grep -c '\.log$')
result=$(grep -E '^[0-9]+ passed, [0-9]+ failed(, [0-9]+ skipped)?$' "$log" | tail -n 1)
word=ok
[ "$status" = 0 ] || word=FAILED
printf '[%3d of %d] %4d s  %s %s: %s (%s s of processor time)\n' "$done" "$of" \
    $(($(date +%s) - $(cat "$folder/begin"))) "$word" "$(basename "$log" .log)" "${result:-exit $status}" "$seconds"
