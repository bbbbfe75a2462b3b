#!/bin/sh
# slow: weekly
# Runs of programs built with OpenMP, on one and on three threads, and of programs built without it and without
# optimisation, write the same bytes: flow, transport and dissolution in 2D, bond-based corrosion in 3D.
. tests/lib/script.sh

cat > "$dir/2.scene" << 'END'
[grid]      h = 10 um   m = 3   box = -200 um .. 600 um, -150 um .. 150 um
[shape pin] box = 0 .. 100 um, -50 um .. 50 um   kind = solid   material = mg4ag   grain_size = 40 um
[side x-]   flow = inlet   profile = parabola   mean = 0.01 m/s   C = 0
[side x+]   flow = outlet
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport] D = 1e-9 m2/s
[dissolve]  rate = 1.3 um/h * (1 - C/Csat)   Csat = 56 mol/m3   grain_boundary_factor = 3
[run]       until = 2 h   max_dissolved_fraction = 0.03
[output]    every = 1 h   fields = C, v, kind   images = C
[probe a]   at = 100 um, 0
[force pin] box = -150 um .. 200 um, -100 um .. 100 um   balance = no
[total all]
END
cat > "$dir/3.scene" << 'END'
[grid]        h = 1 um   m = 3   box = -12 um .. 12 um, -12 um .. 12 um, -8 um .. 8 um
[shape block] box = -12 um .. 12 um, -12 um .. 12 um, -8 um .. 0 um
[shape pit]   ball = 0 um, 0 um, 0 um   radius = 4 um
[shape metal] difference = block, pit   kind = solid   material = steel304
[side z+]     flow = open
[corrode]     Cs = 143 mol/L   Csat = 5.1 mol/L   D = 8.5e-10 m2/s   current = 5 A/cm2
[run]         until = 0.1 s   max_step = 0.02 s
[output]      every = 0.05 s   fields = C, kind   images = C   slice = y 0.5 um
[total all]
END

for dim in 2 3; do
    # other flags than those of this build, so that the compiler has other chances to change sums
    plain $dim && ${CC:-cc} -std=c99 -O0 -DPD_DIM=$dim -DPDCORR_LINKED -I. drivers/scene.c "$object" \
        -o "$dir/pd${dim}d" -lm > "$dir/log" 2>&1
    verdict "${dim}D without OpenMP builds"
    for threads in 1 3; do
        OMP_NUM_THREADS=$threads "$programs/pd${dim}d" "$dir/$dim.scene" --out "$dir/with_${dim}_$threads" --quiet \
            > "$dir/log" 2>&1
        verdict "${dim}D on $threads threads ends"
    done
    "$dir/pd${dim}d" "$dir/$dim.scene" --out "$dir/without_$dim" --quiet > "$dir/log" 2>&1
    verdict "${dim}D without OpenMP ends"
    [ "$(ls "$dir/without_$dim" | wc -l)" -ge 5 ]
    verdict "${dim}D writes files"
    for threads in 1 3; do
        diff -rq "$dir/with_${dim}_$threads" "$dir/without_$dim" > "$dir/log" 2>&1
        verdict "${dim}D on $threads threads: the same bytes as without OpenMP"
    done
done

# Threads that wait sleep soon, unless the caller wants it otherwise: a program beside takes no more than its share.
if [ -n "${OMP:-}" ]; then
    unset OMP_WAIT_POLICY GOMP_SPINCOUNT KMP_BLOCKTIME
    OMP_DISPLAY_ENV=verbose "$programs/pd2d" "$dir/2.scene" --check --threads 2 > /dev/null 2> "$dir/log"
    grep -qi "OMP_WAIT_POLICY *= *'PASSIVE'" "$dir/log"
    verdict "waiting threads sleep"
    OMP_WAIT_POLICY=active OMP_DISPLAY_ENV=verbose "$programs/pd2d" "$dir/2.scene" --check --threads 2 > /dev/null \
        2> "$dir/log"
    grep -qi "OMP_WAIT_POLICY *= *'ACTIVE'" "$dir/log"
    verdict "the caller's own choice stays"
fi
score
