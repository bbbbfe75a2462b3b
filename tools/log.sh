#!/bin/sh
# log.sh LOG OF COMMAND...: runs the command and writes LOG: what it said, then a line "exit N". With OF, the number of
# logs to come, it says how far the tests are, in seconds since LOG's folder got its file `begin`. Programs run side by
# side: each has one thread unless OMP_NUM_THREADS says otherwise, and threads sleep at barriers. A command that has not
# ended after PD_TEST_LIMIT seconds (3600; 0: no limit) is stopped with all that it has started, and has failed: its
# status is 124, or 137 where it had to be killed. Without `timeout` of coreutils there is no limit.
log=$1 of=$2
shift 2
folder=$(dirname "$log")
mkdir -p "$folder"
limit=${PD_TEST_LIMIT:-3600}
begin=$(date +%s)
if [ "$limit" != 0 ] && timeout -k 1 1 true 2> /dev/null; then
    set -- timeout -k 10 "$limit" "$@"
else
    limit=0
fi
OMP_WAIT_POLICY=passive OMP_NUM_THREADS=${OMP_NUM_THREADS:-1} "$@" > "$log.new" 2>&1
status=$?
case $status in
124 | 137) [ "$limit" = 0 ] || [ $(($(date +%s) - begin)) -lt "$limit" ] ||
               echo "stopped: no end after $limit s (PD_TEST_LIMIT)" >> "$log.new" ;;
esac
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
! tail -n 2 "$log" | grep -q '^stopped: ' || result=$(tail -n 2 "$log" | head -n 1)
printf '[%3d of %d] %4d s  %s %s: %s (%s s of processor time)\n' "$done" "$of" \
    $(($(date +%s) - $(cat "$folder/begin"))) "$word" "$(basename "$log" .log)" "${result:-exit $status}" "$seconds"
