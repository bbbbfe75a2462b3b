#!/bin/sh
# Checkpoints of the drivers: runs that signals or kills end go on to the files of a run that nothing ended; statuses,
# messages and options; a full disk.
. tests/lib/script.sh
. tests/lib/pin.sh
cd "$dir" || exit 1

pin > pin.scene
cat >> pin.scene << 'END'
            streamlines = C   vectors = kind
[force pin] box = -50 um .. 100 um, -30 um .. 30 um   balance = no
END
cat > pit.scene << 'END'
[grid]        h = 1 um   m = 3   box = -8 um .. 8 um, -8 um .. 8 um, -8 um .. 4 um
[shape block] box = -8 um .. 8 um, -8 um .. 8 um, -8 um .. 0 um
[shape pit]   ball = 0 um, 0 um, 0 um   radius = 4 um
[shape metal] difference = block, pit   kind = solid   material = steel304
[side z+]     flow = open
[corrode]     Cs = 143 mol/L   Csat = 5.1 mol/L   D = 8.5e-10 m2/s   current = 5 A/cm2
[run]         until = 0.3 s   max_step = 0.02 s
[output]      every = 0.1 s   fields = C, kind   images = C   slice = y 0.5 um
              surface = density   view = 1, -2, 3   animate = yes   width = 300
[total all]
END

# begin DIM SCENE OUT ARGUMENT...: in the background; $! is its process.
begin() {
    program=$programs/pd$1d scene=$2 out=$3
    shift 3
    "$program" "$scene" --out "$out" --quiet "$@" > log 2>&1 &
}

# ends STATUS: the program in the background ends so.
ends() {
    wait $!
    [ $? = "$1" ]
}

same() { diff -r "$1" "$2" > log 2>&1; }

# the runs that nothing ends
begin 2 pin.scene pin_whole --checkpoint off --threads 1
ends 0
verdict "pin: a whole run"
begin 3 pit.scene pit_whole --threads 1
ends 0
verdict "pit: a whole run"

# when the table of folder $1 has $2 rows, or the program is gone
rows() {
    while kill -0 $! 2> /dev/null && [ "$(cat "$1/diagnostics.csv" 2> /dev/null | wc -l)" -lt "$2" ]; do
        sleep 0.01
    done
}

# signals: status 3, then --resume with other threads
for signal in INT TERM; do
    begin 2 pin.scene pin_$signal --threads 1
    rows pin_$signal 8
    kill -$signal $!
    ends 3 && grep -q '^pd2d: interrupted at t = .* s; the same command with --resume goes on$' log
    verdict "pin: SIG$signal stops it"
    [ -s pin_$signal/checkpoint.bin ] && [ ! -e pin_$signal/volume_loss.png.part ]
    verdict "pin: a checkpoint after SIG$signal"
    begin 2 pin.scene pin_$signal --threads 2 --resume
    ends 0
    verdict "pin: it goes on after SIG$signal"
    same pin_whole pin_$signal
    verdict "pin: the same files after SIG$signal"
done
begin 3 pit.scene pit_TERM --threads 2
rows pit_TERM 7
kill -TERM $!
kill -TERM $! 2> /dev/null
kill -INT $! 2> /dev/null
ends 3
verdict "pit: SIGTERM stops it, and a second one soon after changes nothing"
begin 3 pit.scene pit_TERM --threads 1 --resume
ends 0 && same pit_whole pit_TERM
verdict "pit: the same files after SIGTERM"

# stopped within long steps, by the clock: every stop is over in a second (in five under a busy machine), and the files
# are the same; the first stop may come before the first step is done
cat > slow.scene << 'END'
[grid]      h = 0.25 mm   m = 3   box = 0 .. 12 mm, 0 .. 6 mm
[shape rod] ball = 4 mm, 3 mm   radius = 1 mm   kind = wall
[side x-]   flow = inlet   profile = parabola   mean = 1 mm/s   C = 1 mol/m3
[side x+]   flow = outlet
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s   time = implicit   rtol = 1e-3
[transport] D = 1e-9 m2/s
[run]       until = 0.05 s
[output]    every = 0.05 s   fields = C, v   images = none
[total all]
END
within() {
    name=$1 arguments=$2
    begin 2 "$name.scene" "${name}_slow_whole" --checkpoint off --threads 1 $arguments
    ends 0
    verdict "$name: a whole run of long steps"
    go='' worst=0
    for wait in 0.1 0.5 0.3 0.2; do
        begin 2 "$name.scene" "${name}_slow" --threads 1 $arguments $go
        sleep $wait
        before=$(date +%s)
        kill -TERM $! 2> /dev/null || break
        wait $!
        status=$? after=$(date +%s)
        [ $((after - before)) -gt $worst ] && worst=$((after - before))
        [ $status = 3 ] || [ $status = 0 ]
        verdict "$name: status $status of a stop after $wait s" $?
        [ -s "${name}_slow/checkpoint.bin" ] && go=--resume
        [ $status = 0 ] && break
    done
    [ $worst -le 5 ]
    verdict "$name: a stop takes $worst s"
    if [ -s "${name}_slow/checkpoint.bin" ]; then
        begin 2 "$name.scene" "${name}_slow" --threads 2 $arguments --resume
        ends 0
        verdict "$name: it goes on after stops within steps"
    fi
    same "${name}_slow_whole" "${name}_slow"
    verdict "$name: the same files after stops within steps"
}
within slow ''
within pin 'max_dissolved_fraction=1 until=1h'

# killed again and again while every step makes a checkpoint: some steps on, at a moment that nobody chose
killed() {
    dim=$1 name=$2
    kills=0
    begin "$dim" "$name.scene" "${name}_kill" --checkpoint '0 s'
    while [ ! -e "${name}_kill/checkpoint.bin" ] && kill -0 $! 2> /dev/null; do sleep 0.01; done
    while [ $kills -lt 4 ]; do
        rows "${name}_kill" $((4 + 4 * kills))
        sleep "0.$(awk -v s="$kills$$" 'BEGIN { srand(s); printf "%03d", 20 * rand() }')"
        kill -9 $! 2> /dev/null || break
        wait $! 2> /dev/null
        kills=$((kills + 1))
        begin "$dim" "$name.scene" "${name}_kill" --checkpoint '0 s' --resume
    done
    ends 0
    verdict "$name: it goes on after $kills kills"
    [ $kills -ge 2 ] && same "${name}_whole" "${name}_kill"
    verdict "$name: the same files after $kills kills"
}
killed 2 pin
killed 3 pit

# refusals: status 2, one line, nothing changes
# refused NAME MESSAGE ARGUMENT...
refused() {
    name=$1 message=$2
    shift 2
    cp -r keep before
    "$programs/pd2d" pin.scene --out keep --quiet "$@" > stdout 2> log
    [ $? = 2 ] && [ ! -s stdout ] && [ "$(cat log)" = "pd2d: $message" ] && diff -r before keep > /dev/null
    verdict "$name"
    rm -rf before
}
begin 2 pin.scene keep
rows keep 8
kill -INT $!
ends 3
verdict "a checkpoint to keep"
refused "another scene" "keep/checkpoint.bin: it is of another scene: found 'dissolve.grain_boundary_factor = 3', \
expected 'dissolve.grain_boundary_factor = 2'" --resume grain_boundary_factor=2
refused "another accuracy" "keep/checkpoint.bin: it is of another scene: found no 'accuracy = 0.01', expected one" \
    --resume --accuracy 1%
cp keep/checkpoint.bin good
printf x | dd of=keep/checkpoint.bin bs=1 seek=20000 conv=notrunc 2> /dev/null
"$programs/pd2d" pin.scene --out keep --resume > stdout 2> log
[ $? = 2 ] && grep -q "^pd2d: store: 'keep/checkpoint.bin' is damaged in the item '[a-z_.]*'$" log
verdict "a damaged checkpoint"
head -c 20000 good > keep/checkpoint.bin
"$programs/pd2d" pin.scene --out keep --resume > stdout 2> log
[ $? = 2 ] && grep -q "^pd2d: store: 'keep/checkpoint.bin' is cut off in the item '[a-z_.]*'$" log
verdict "half a checkpoint"
rm keep/checkpoint.bin
refused "no checkpoint" "file: cannot open 'keep/checkpoint.bin': No such file or directory" --resume
mkdir pin3 && cp good pin3/checkpoint.bin
"$programs/pd3d" pit.scene --out pin3 --resume > stdout 2> log
[ $? = 2 ] && [ "$(cat log)" = "pd3d: store: 'pin3/checkpoint.bin' is of dimension 2, expected 3" ]
verdict "another dimension"

# without checkpoints nothing can go on
begin 2 pin.scene off --checkpoint off
rows off 8
kill -TERM $!
ends 1 && grep -q 'the output is complete up to there$' log && [ ! -e off/checkpoint.bin ]
verdict "checkpoints off"

# no room for it: the run goes on without, the checkpoint before stays whole
fine="h=5 um"
begin 2 pin.scene room_whole "$fine" until=30min fields=none images=none
ends 0
begin 2 pin.scene room "$fine" until=30min fields=none images=none
rows room 4
kill -INT $!
ends 3
verdict "room: stopped"
cp room/checkpoint.bin former
(
    trap '' XFSZ
    ulimit -f 120
    exec "$programs/pd2d" pin.scene --out room --resume --checkpoint '0 s' "$fine" until=30min fields=none images=none
) > log 2>&1 &
while kill -0 $! 2> /dev/null && ! grep -q '^note: no checkpoint' log; do sleep 0.01; done
grep -q "^note: no checkpoint at t = .* the one before stays: file: cannot write 'room/checkpoint.bin.part': " log
verdict "no room: it says so"
! kill -0 $! 2> /dev/null || cmp -s former room/checkpoint.bin
verdict "no room: the checkpoint before stays"
ends 0 && same room_whole room
verdict "no room: the run ends all the same"

score
