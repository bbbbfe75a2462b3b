#!/bin/sh
# --sweep: a folder for each combination, the table and the plot; runs that fail or are refused; signals.
. tests/lib/script.sh
cd "$dir" || exit 1
export OMP_NUM_THREADS=1

cat > slab.scene << 'END'
[grid]        h = 10 um   m = 2   box = 0 .. 200 um, 0 .. 20 um
[shape metal] box = 50 um .. 150 um, 0 .. 20 um   kind = solid
[transport]   D = 1e-9 m2/s
[dissolve]    rate = 10 um/h
[run]         until = 1 h
[output]      every = 15 min   fields = C   images = none
END

# sweep STATUS ARGUMENT...
sweep() {
    wanted=$1
    shift
    "$programs/pd2d" slab.scene --out out "$@" > log 2>&1
    [ $? = "$wanted" ]
}

# cell RUN COLUMN: of the table.
cell() {
    awk -F, -v run="$1" -v name="$2" '/^#/ { next } head == "" { head = $0; for (k = 1; k <= NF; k++) at[$k] = k; next }
        $1 == run { print $at[name] }' out/sweep.csv
}

# holds RUN COLUMN VALUE
holds() {
    found=$(cell "$1" "$2")
    awk -v f="$found" -v e="$3" 'BEGIN { d = f - e; if (d < 0) d = -d
        exit !(f == e || (f + 0 == f && e + 0 == e && d < 0.01 * e)) }'
    said=$?
    verdict "$1 $2: '$found', expected $3" $said
}

mkdir elsewhere out
ln -s ../elsewhere out/run002
check "a link in the place of the folder of a run" sweep 2 --sweep "rate=5,10,20 um/h"
grep -q "^pd2d: sweep: 'out/run002' is a link, expected the folder of a run or none: remove it$" log &&
    [ -z "$(ls elsewhere)" ]
verdict "it is refused, and nothing is written behind it"
rm -r out elsewhere

check "six runs side by side" sweep 0 --sweep "rate=5,10,20 um/h" --sweep "run.until=30 min, 1 h" --threads 2
holds run001 "rate [um/h]" 5
holds run006 "rate [um/h]" 20
holds run002 run.until "1 h"
holds run001 result_volume_loss 0.05
holds run004 result_volume_loss 0.2
holds run006 result_volume_loss 0.4
holds run006 status "done"
rows=$(grep -c '^run0' out/sweep.csv)
[ "$rows" = 6 ] && [ -s out/sweep.png ] && [ -s out/run003/diagnostics.csv ]
verdict "a row for each run, a plot, a folder each" $?
cp out/sweep.csv side.csv
check "the same one after another" sweep 0 --sweep "rate=5,10,20 um/h" --sweep "run.until=30 min, 1 h" --threads 1
sed 's/,[0-9]*,$/,,/' side.csv > a && sed 's/,[0-9]*,$/,,/' out/sweep.csv > b # but for the memory of threads
cmp a b > log 2>&1
verdict "side by side or one after another: the same table" $?

# a run that fails: law without a value
check "a run that fails ends with 1" sweep 1 --sweep "rate=10 um/h, 10 um/h*sqrt(1 - t/30 min), 5 um/h" --threads 2
holds run001 status "done"
holds run002 status failed
holds run003 status "done"
grep -q '^run002,.*the rate law gives' out/sweep.csv
verdict "the table says why a run failed" $?

# a signal: 3, and what was not begun is stopped, too
"$programs/pd2d" slab.scene --out out --sweep "rate=1,2,3,4 um/h" run.max_step="0.05 s" --threads 2 > log 2>&1 &
sleep 1
kill -TERM $!
wait $!
[ $? = 3 ] && grep -q '^run001,1,stopped,' out/sweep.csv && grep -q '^run004,4,stopped,not begun' out/sweep.csv
verdict "a signal ends all runs" $?
"$programs/pd2d" slab.scene rate="1 um/h" run.max_step="0.05 s" --out out/run001 --resume --quiet > log 2>&1 &
sleep 0.5
kill -TERM $!
wait $!
[ $? = 3 ]
verdict "a run of a sweep goes on by itself" $?

# refused at once, before anything runs
refused() {
    expected=$1
    shift
    rm -rf out
    sweep 2 "$@" && [ ! -e out ] && grep -qF -- "$expected" log
    said=$?
    verdict "$*: expected '$expected', status 2 and no folder" $said
}
refused "no_such_key" --sweep "no_such_key=1,2"
refused "expected key = value, value" --sweep "rate"
refused "expected key = value, value" --sweep ""
refused "a value before and behind each comma" --sweep "rate="
refused "a value before and behind each comma" --sweep "rate=1 um/h,,2 um/h"
refused "each key once" --sweep "rate=1 um/h" --sweep "rate=2 um/h"
refused "without unit" --sweep "rate=1,2"
refused "whole number of cells" --sweep "h=10 um, 30 um"
refused "goes without" --sweep "h=10 um" --resume
score
