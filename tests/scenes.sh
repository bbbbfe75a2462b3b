#!/bin/sh
# The validation scenes run, and their probes show what closed forms say.
build=${BUILD:-build}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
passed=0 failed=0

# shows SCENE FILE KEY COLUMN VALUE TOLERANCE: the row of FILE that starts with KEY has VALUE in COLUMN, up to TOLERANCE
# times VALUE.
shows() {
    scene=$1 file=$2 key=$3 column=$4 value=$5 tolerance=$6
    kind=${scene##*_}
    if [ ! -d "$dir/$scene" ]; then
        "$build/pd$kind" "examples/scenes/validation/$scene.scene" --out "$dir/$scene" > "$dir/log" 2>&1 ||
            cat "$dir/log"
    fi
    found=$(awk -F, -v key="$key" -v column="$column" '
        !/^#/ && head == "" { head = $0; for (k = 1; k <= NF; k++) if ($k == column) at = k; next }
        $1 == key { print $at }' "$dir/$scene/$file")
    if awk -v f="$found" -v v="$value" -v t="$tolerance" 'BEGIN { e = f / v - 1; exit !(f != "" && e <= t && e >= -t) }'
    then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "$scene: $column at $key is '$found', expected $value within $tolerance"
    fi
}

# u on the axis: the mean over a cell of a parabola seen from its centres
shows poiseuille_2d probes.csv 0 axis_vx 1.5 5e-4
shows poiseuille_2d probes.csv 0 axis_p 0.12 1e-6
shows hagen_3d probes.csv 0 axis_p 0.8 1e-6
shows startup_2d probes.csv 0.2 centre_vx 0.185193 1e-3
shows startup_2d probes.csv 0.8 centre_vx 0.428330 1e-3
shows couette_2d probes.csv 0.05 a_vx 0.113844 5e-3
shows couette_2d probes.csv 0.2 a_vx 0.411566 1e-3
shows annulus_2d probes.csv 0 a_vx 1.537394 1e-4
shows annulus_2d probes.csv 0 b_p 1.731608 3e-4
shows cavity_2d probes.csv 0 centre_vx -0.20915 5e-3
shows taylor_green_2d probes.csv 1 a_vx 0.454041 1e-2
shows slab_2d probes.csv 0.1 a_C 0.525513 4e-3
# sqrt(depth^2 + gap^2) - gap, the mouth lying a gap of 0.5 um in front of the metal
shows pencil_304_1d diagnostics.csv 10 volume_loss 0.24427 1e-2
shows pencil_304_1d diagnostics.csv 100 volume_loss 0.78311 5e-3
echo "$passed passed, $failed failed"
[ "$failed" = 0 ]
