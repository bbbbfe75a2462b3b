#!/bin/sh
# Scenes whose inlets, walls, held values, forces and laws depend on time and place: what they do, how steps see them,
# checkpoints, coarser runs, and what is refused where.
. tests/lib/script.sh
cd "$dir" || exit 1
export OMP_NUM_THREADS=1

# run NAME ARGUMENT...: NAME.scene into NAME, what it says into log.
run() {
    name=$1
    shift
    "$programs/pd2d" "$name.scene" --quiet --out "$name" "$@" > log 2>&1
}

# value KEY: of the result line in log.
value() { sed -n "s/^result.* $1=\([^ ]*\).*/\1/p" log; }

# close FOUND EXPECTED SHARE
close() {
    awk -v f="$1" -v e="$2" -v s="$3" 'BEGIN { d = f / e - 1; if (d < 0) d = -d; exit !(f != "" && d <= s) }'
}

# loss TEXT EXPECTED SHARE ARGUMENT...: of slab.scene.
loss() {
    text=$1 expected=$2 share=$3
    shift 3
    run slab "$@"
    found=$(value volume_loss)
    close "$found" "$expected" "$share"
    said=$?
    verdict "$text: volume loss '$found', expected $expected" $said
}

cat > slab.scene << 'END'
[grid]        h = 10 um   m = 2   box = 0 .. 200 um, 0 .. 20 um
[shape metal] box = 50 um .. 150 um, 0 .. 20 um   kind = solid
[transport]   D = 1e-9 m2/s
[dissolve]    rate = 10 um/h
[run]         until = 1 h
[output]      every = 1 h   fields = C   images = none
[total all]
END
loss "a constant rate" 0.2 0.01
loss "a rate that rises" 0.3 0.01 "rate=10 um/h*(1 + t/1 h)"
loss "a rate that turns" 0.2 0.01 "rate=10 um/h*(1 + sin(2*pi*t/20 min))"
loss "a rate that jumps" 0.2833 0.01 "rate=if(t < 35 min, 10 um/h, 20 um/h)"
loss "metal that waits" 0.1 0.03 "rate=if(t < 30 min, 0 um/h, 10 um/h)"
loss "metal that waits, with a tenth of the tolerance" 0.1 0.003 "rate=if(t < 30 min, 0 um/h, 10 um/h)" run.rtol=4e-4
loss "a rate of the place" 0.4 0.01 "rate=10 um/h*if(x > 100 um, 3, 1)"

# a wall that warms up: C of a layer follows C0 (1 - exp(-t/T)), slowly against D/L^2
cat > held.scene << 'END'
[grid]      h = 10 um   m = 2   box = 0 .. 200 um, 0 .. 40 um
[side x-]   C = 5 mol/m3 * (1 - exp(-t/1 h)) * (1 + 0*y/1 m)
[side x+]   flow = mirror
[transport] D = 1e-9 m2/s   initial = 0 mol/m3
[run]       until = 2 h
[output]    every = 1 h   fields = C   images = none
[probe far] at = 195 um, 20 um
END
check "a held value follows" run held
found=$(awk -F, '/^#/ || head == "" { if ($0 !~ /^#/) head = $0; next } { v = $NF } END { print v }' held/probes.csv)
# lag L^2/(2 D) = 20 s of an exponential: 5 (1 - exp(-2)(1 + 20/3600))
close "$found" 4.3195 0.001
verdict "C at the far end is '$found', expected 4.3195" $?

# what comes in at a side goes through: amounts of a pulse
cat > pulse.scene << 'END'
[grid]      h = 10 um   m = 2   box = 0 .. 300 um, 0 .. 40 um
[side x-]   flow = inlet   profile = uniform   mean = 1 mm/s * (1 + 0.5*sin(2*pi*t/1 s))   C = 5 mol/m3*if(t<1 s,1,0)
[side x+]   flow = outlet
[side y-]   flow = mirror
[side y+]   flow = mirror
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s   reference_speed = 1 mm/s
[transport] D = 1e-9 m2/s
[run]       until = 1.2 s   rtol = 1e-3
[output]    every = 0.3 s   fields = C   images = none
[plane mid] at = x 150 um
[total all]
END
check "a pulse through a stream that beats" run pulse

# a beating force in a flow in time, beside a wall that slides to and fro
cat > beat.scene << 'END'
[grid]    h = 20 um   m = 2   box = 0 .. 80 um, 0 .. 400 um
[side x-] flow = periodic
[side x+] flow = periodic
[side y+] velocity = 1 mm/s*sin(2*pi*t/0.3 s), 0 m/s
[flow]    rho = 1000 kg/m3   mu = 1e-3 Pa s   reference_speed = 1 mm/s   reference_length = 400 um   time = implicit
          body_force = 0.01 m/s2*cos(2*pi*t/0.2 s)*(y/400 um), 0 m/s2
[run]     until = 0.1 s   max_step = 2 ms
[output]  every = 0.05 s   fields = v   images = none
[force low] box = 0 .. 80 um, -10 um .. 200 um   balance = no
END
check "walls and forces on a clock" run beat

# killed SCENE: the run ends when it has a checkpoint and goes on from there.
killed() {
    mv "$1" "whole_$1"
    "$programs/pd2d" "$1.scene" --quiet --out "$1" --checkpoint "0 s" > log 2>&1 &
    for round in 1 2 3 4 5 6 7 8 9 10; do
        [ -e "$1/checkpoint.bin" ] || sleep 0.02
    done
    kill -KILL $! 2> kill_log
    wait $! 2> kill_log
    if [ -e "$1/checkpoint.bin" ]; then run "$1" --resume; else run "$1"; fi
    diff -r "whole_$1" "$1" > log 2>&1
}
check "a stream that beats goes on after it was killed" killed pulse
check "a flow in time goes on after it was killed" killed beat

# metal of [corrode] that waits, with fluid that takes away all
cat > wait.scene << 'END'
[grid]        h = 2 um   m = 2   box = 0 .. 20 um, 0 .. 60 um
[shape metal] box = 0 .. 20 um, 0 .. 40 um   kind = solid   material = steel304
[side y+]     flow = open
[corrode]     Csat = 5 mol/L   D = 1e-5 m2/s   rate = if(t < 1.3 s, 0 um/s, 10 um/s)
[run]         until = 2 s
[output]      every = 2 s   fields = C   images = none
END
check "corrosion that waits" run wait
found=$(value volume_loss)
close "$found" 0.175 0.01
verdict "7 um of 40: volume loss '$found'" $?
check "corrosion that rises" run wait "rate=10 um/s*t/1 s"
found=$(value volume_loss)
close "$found" 0.5 0.02
verdict "20 um of 40: volume loss '$found'" $?

# coarser runs of a scene on a clock
run slab "rate=10 um/h*(1 + t/1 h)" "shape.metal.box=40 um .. 160 um, 0 .. 20 um" "grid.box=0 .. 200 um, 0 .. 40 um" \
    "shape.metal.box=40 um .. 160 um, 0 .. 40 um" --estimate-error
grep -q "err_volume_loss=" log
verdict "coarser runs follow too" $?

# refused EXPECTED SCENE ARGUMENT...: with status 2 and this in the message.
refused() {
    expected=$1 scene=$2
    shift 2
    run "$scene" "$@"
    said=$?
    [ $said = 2 ] && grep -qF -- "$expected" log
    said=$?
    verdict "$scene $*: expected '$expected'" $said
}
refused "found 'z', expected one of C, t, x, y" slab "rate=1 um/h*z/1 m"
refused "found 'z', expected one of x, y, t" held "C=1 mol/m3*z/1 m"
refused "found 't', expected one of x, y" held "initial=1 mol/m3*t/1 s"
refused "found 't', expected a constant" held "D=1e-9 m2/s*t/1 s"
refused "expected a finite value of at least 0" held "C=5 mol/m3*(t/1 h - 1)"
refused "found a function of the place, expected one of t alone" pulse "mean=1 mm/s*x/1 m"
refused "found a function of t in a scene that is steady" pulse "transport.time=steady"
score
