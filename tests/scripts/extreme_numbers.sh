#!/bin/sh
# Every number of a scene at 1e-300, 1e300, infinity, no number and below zero: each run ends in ten seconds, refused in
# one line or done, and none crashes.
. tests/lib/script.sh
cd "$dir" || exit 1

cat > flow.scene << 'END'
[grid]      h = 10 um   m = 2   box = -40 um .. 120 um, -40 um .. 40 um   threads = 1
[table law] file = law.csv   x = C   y = v
[shape pin] box = 0 um .. 40 um, -10 um .. 10 um   kind = solid   material = mg4ag   grain_size = 30 um
            grain_size_deviation = 1 um   grain_seed = 2   grain_boundary_width = 10 um
[shape rod] ball = 90 um, 0 um   radius = 12 um   kind = wall   C = 1 mol/m3
[side x-]   flow = inlet   profile = parabola   mean = 0.01 m/s   C = 0 mol/m3
[side x+]   flow = outlet   p = 0 Pa
[side y+]   velocity = 0.001 m/s, 0 m/s
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s   steady_tolerance = 1e-3   body_force = 0 m/s2, 0 m/s2
            reference_speed = 0.01 m/s   reference_length = 80 um
[transport] D = 1e-9 m2/s   initial = 0 mol/m3
[dissolve]  rate = 1.3 um/h * (1 - C/Csat)   Csat = 56 mol/m3   Cs = 70 mol/L
            grain_boundary_factor = 3   threshold = 0.1
[run]       until = 1 h   max_dissolved_fraction = 0.5   max_step = 1 h
[output]    every = 1 h   fields = none   images = none
[probe a]   at = 100 um, 0 um
[line l]    from = 60 um, -30 um   to = 60 um, 30 um   points = 5   images = none
[plane p]   at = x 70 um
[force f]   box = 70 um .. 110 um, -30 um .. 30 um   reference_speed = 1 m/s   reference_length = 1 m   balance = no
[transfer t] box = 70 um .. 110 um, -30 um .. 30 um   reference_length = 1 m   surface = 1 mol/m3   fluid = 0 mol/m3
[total all] box = -40 um .. 120 um, -40 um .. 40 um
END
printf 'C,v\n0,1\n100,0.5\n' > law.csv
cat > time.scene << 'END'
[grid]      h = 0.5 mm   m = 1   box = 0 mm .. 4 mm, 0 mm .. 4 mm
[side x-]   flow = inlet   profile = uniform   mean = 1 mm/s   C = 1 mol/m3
[side x+]   flow = outlet
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s   time = implicit   rtol = 1e-2   vx = 0 m/s   vy = 0 m/s
            reference_speed = 1 m/s   reference_length = 4 mm
[transport] D = 1e-9 m2/s
[run]       until = 0.2 ms   rtol = 1e-2
[output]    fields = none   images = none
END
cat > sound.scene << 'END'
[grid]      h = 0.5 mm   m = 1   box = 0 mm .. 4 mm, 0 mm .. 4 mm
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s   time = explicit   c0 = 0.1 m/s   eos = linear   reference_speed = 1 mm/s
            reference_length = 4 mm   vx = 0 m/s   vy = 0 m/s   body_force = 1e-3 m/s2, 0 m/s2
[run]       until = 0.1 s
[output]    fields = none   images = none
END
cat > corrode.scene << 'END'
[grid]      h = 5 um   m = 2   box = 0 um .. 100 um
[shape m]   half_space = 50 um   point = 50 um   normal = 1   kind = solid   material = steel304   grain_size = 20 um
[side x+]   flow = open
[corrode]   Cs = 143 mol/L   Csat = 5.1 mol/L   D = 8.5e-10 m2/s   current = 5 A/cm2   charge = 2.2   initial = 0 mol/m3
            bulk = 0 mol/m3   grain_boundary_factor = 2   repassivation = 0.1 mol/L   breaking = stochastic   seed = 1
[run]       until = 0.5 s   rtol = 1e-2   max_dissolved_fraction = 0.2   max_step = 0.1 s
[output]    every = 0.5 s   fields = none   images = none
END
sed -i 's/half_space = 50 um *//' corrode.scene
sed -i 's/^\[shape m\]  /[shape m]   box = 0 um .. 50 um/;s/point = 50 um *normal = 1 *//' corrode.scene
cat > bonds.scene << 'END'
[grid]      h = 5 um   m = 2   box = 0 um .. 100 um
[shape m]   box = 0 um .. 50 um   kind = solid   material = steel304
[side x+]   flow = open
[corrode]   Cs = 143 mol/L   Csat = 5.1 mol/L   D = 8.5e-10 m2/s   rate = 10 um/s   driving_force = difference
            kernel = inverse
[run]       until = 0.5 s   max_dissolved_fraction = 0.2   max_step = 0.1 s
[output]    every = 0.5 s   fields = none   images = none
END

# numbers SCENE: one line a number, "line column length", of what follows a key or a comma or dots.
numbers() {
    awk '{
        at = 1; rest = $0
        while (match(rest, /[=,.] *-?[0-9]+\.?[0-9]*(e-?[0-9]+)?/)) {
            token = substr(rest, RSTART, RLENGTH); head = token
            sub(/^[=,.] */, "", head)
            print NR, at + RSTART - 1 + RLENGTH - length(head), length(head)
            at += RSTART + RLENGTH - 1
            rest = substr($0, at)
        }
    }' "$1"
}

# tries DIM NAME: every number of NAME.scene with every value, one after the other.
tries() {
    dim=$1 name=$2
    "$programs/pd${dim}d" "$name.scene" --out "$name" --quiet --checkpoint off > out 2> log
    verdict "$name: the scene itself"
    count=0 hung=0 died=0 mute=0
    numbers "$name.scene" > places
    while read -r line column length; do
        for value in 1e-300 1e300 1e999 nan -1; do
            awk -v n="$line" -v c="$column" -v l="$length" -v v="$value" \
                'NR == n { $0 = substr($0, 1, c - 1) v substr($0, c + l) } { print }' "$name.scene" > case.scene
            timeout 10 "$programs/pd${dim}d" case.scene --out case --quiet --checkpoint off --memory-limit 500MB \
                > out 2> err < /dev/null
            status=$?
            count=$((count + 1))
            case $status in
            0 | 1 | 2) [ $status = 0 ] || [ "$(wc -l < err)" = 1 ] || { mute=$((mute + 1)); cp case.scene log; } ;;
            124) hung=$((hung + 1)); echo "hangs: $name:$line:$column $value: $(sed -n "${line}p" case.scene)" ;;
            *) died=$((died + 1)); echo "status $status: $name:$line:$column $value: $(sed -n "${line}p" case.scene)" ;;
            esac
        done
    done < places
    : > log
    [ $count -gt 20 ]
    verdict "$name: $count cases"
    [ $hung = 0 ]
    verdict "$name: $hung of $count cases do not end"
    [ $died = 0 ]
    verdict "$name: $died of $count cases crash"
    [ $mute = 0 ]
    verdict "$name: $mute of $count refusals are not one line"
}
export OMP_NUM_THREADS=1
tries 2 flow
tries 2 time
tries 2 sound
tries 1 corrode
tries 1 bonds
score
