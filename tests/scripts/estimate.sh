#!/bin/sh
# --estimate-error: the estimate stands beside the true error of closed forms; coarser runs leave no files; a scene
# without them keeps its result. --accuracy: what it picks, what it leaves to the scene, whether it is right about the
# accuracy and the spacing it asks for; bad values.
. tests/lib/script.sh
scenes=$root/examples/scenes/validation

# run NAME DIM SCENE [ARGUMENT ...]: into $dir/NAME, NAME.out and NAME.err; it must end with 0.
run() {
    name=$1 dim=$2 scene=$3
    shift 3
    "$programs/pd${dim}d" "$scene" "$@" --out "$dir/$name" > "$dir/$name.out" 2> "$dir/$name.err"
    said=$?
    verdict "$name: status $said: $(cat "$dir/$name.err")" $said
}

# value NAME WORD KEY: of the last result line that holds WORD.
value() {
    awk -v word="$2" -v key="$3=" '/^result/ && index($0 " ", word " ") { for (k = 1; k <= NF; k++)
        if (index($k, key) == 1) v = substr($k, length(key) + 1) } END { print v }' "$dir/$1.out"
}

# last NAME COLUMN: of the last row of the probes.
last() {
    awk -F, -v column="$2" 'NR == 1 { for (k = 1; k <= NF; k++) if (index($k, column " [") == 1) at = k; next }
        { v = $at } END { print v }' "$dir/$1/probes.csv"
}

# honest NAME WORD KEY FOUND EXACT: the true error of FOUND lies within a factor 3 of the estimate err_KEY.
honest() {
    err=$(value "$1" "$2" "err_$3")
    awk -v e="$err" -v f="$4" -v x="$5" 'BEGIN { t = f / x - 1; if (t < 0) t = -t
        exit !(e != "" && f != "" && e > 0 && t <= 3 * e && t >= e / 3) }'
    verdict "$1: $3 is '$4', exact $5, the estimated error is '$err'"
}

# between NAME WORD KEY LOW HIGH
between() {
    found=$(value "$1" "$2" "$3")
    awk -v f="$found" -v l="$4" -v h="$5" 'BEGIN { exit !(f != "" && f + 0 >= l && f + 0 <= h) }'
    verdict "$1: $3 is '$found', expected $4 to $5"
}

# says NAME FILE TEXT: FILE (out or err) of the run holds TEXT.
says() {
    grep -qF -- "$3" "$dir/$1.$2"
    said=$?
    verdict "$1: found no '$3' in: $(cat "$dir/$1.$2")" $said
}

# ---- estimates against closed forms ----

# diffusion into a slab (Crank), order 2 observed
run slab 2 "$scenes/slab_2d.scene" --estimate-error
honest slab estimate=richardson C "$(last slab a_C)" 0.525513
between slab probe=a order_C 1.7 2.3
# a parabola is exact on any lattice, and so is a probe between its nodes
run poiseuille 2 "$scenes/poiseuille_2d.scene" "h=1 m / 40" --estimate-error
between poiseuille probe=axis err_vx 0 1e-9
between poiseuille probe=axis err_p 0 1e-6
# a pit that grows by diffusion: sqrt(depth^2 + gap^2) - gap after 10 s, order 1 (402 cells: no lattice at 4 h)
# coarser runs keep the order that the run has chosen: at 4 h it would be another
for order in auto 4; do
    run "cavity_$order" 2 "$scenes/cavity_2d.scene" "h=1 m / 24" "flow.order=$order" --estimate-error
done
grep -o 'err_[a-z_A-Z]*=[^ ]*' "$dir/cavity_auto.out" > "$dir/auto.err"
grep -o 'err_[a-z_A-Z]*=[^ ]*' "$dir/cavity_4.out" > "$dir/4.err"
test -s "$dir/auto.err" && cmp -s "$dir/auto.err" "$dir/4.err"
verdict "errors of a cavity: $(paste -sd' ' "$dir/auto.err"), with order = 4 $(paste -sd' ' "$dir/4.err")" $?

run pencil 1 "$scenes/pencil_304_1d.scene" "h=0.25 um" "until=10 s" --estimate-error
honest pencil estimate=richardson volume_loss "$(value pencil dim=1 volume_loss)" 0.24427
between pencil assumed=volume_loss order 1 1
says pencil out "the error estimate assumes orders: coarser: the lattice at 4 h cannot hold the scene: the box has 402"
# all faces at 45 degrees to the lattice
run rate 2 "$scenes/rate_2d.scene" --estimate-error
# 4 um happens to be closer (0.2 %) than 2 um (0.5 %) and 8 um (2 %): the error is within the estimate, that is all
err=$(value rate estimate=richardson err_volume_loss) found=$(value rate dim=2 volume_loss)
awk -v e="$err" -v f="$found" 'BEGIN { t = f / 0.5765 - 1; exit !(e <= 0.03 && t <= e && -t <= e) }'
verdict "rate: volume_loss is '$found', exact 0.5765, the estimated error is '$err'" $?

# planes count for the same place, between those of the coarser lattice too: in a channel the pressure falls linearly
cat > "$dir/channel.scene" << 'END'
[grid]     h = 0.05 m   box = 0 .. 1 m, -0.5 m .. 0.5 m
[side x-]  flow = inlet   profile = parabola   mean = 1 m/s
[side x+]  flow = outlet
[flow]     rho = 1 kg/m3   mu = 0.02 Pa s   steady_tolerance = 1e-9
[output]   fields = none
[plane p]  at = x 0.35 m
END
run channel 2 "$dir/channel.scene" --estimate-error
between channel plane=p err_p 0 1e-6
honest channel "estimate=richardson plane=p" flow "$(value channel "plane=p time=0" flow)" 1

# the coarser runs write nothing: the same files as without them
run plain 2 "$scenes/slab_2d.scene"
[ "$(ls "$dir/plain")" = "$(ls "$dir/slab")" ] && cmp -s "$dir/plain/diagnostics.csv" "$dir/slab/diagnostics.csv"
verdict "the estimate changes the output"

# ---- scenes that the coarser lattice cannot hold ----

# without NAME MESSAGE: status 0, the result, no estimate, one line on stderr
without() {
    name=$1 dim=$2 scene=$3 message=$4
    shift 4
    run "$name" "$dim" "$scene" --estimate-error "$@"
    printf '%s\n' "pd${dim}d: no error estimate: $message" > "$dir/wanted"
    cmp -s "$dir/wanted" "$dir/$name.err" && grep -q '^result.* volume_loss=' "$dir/$name.out" &&
        ! grep -q estimate= "$dir/$name.out"
    said=$?
    verdict "$name: expected $(cat "$dir/wanted"), found $(cat "$dir/$name.err" "$dir/$name.out")" $said
}
without odd 1 "$scenes/pencil_304_1d.scene" \
    "coarser: the lattice at 2 h cannot hold the scene: the box has 201 cells along x, expected a multiple of 2" \
    "until=1 s"
without face 1 "$scenes/rate_1d.scene" "coarser: the lattice at 2 h cannot hold the scene: the face of a shape at x = \
110 um is cell 11 of the box, expected a multiple of 2"
{ cat "$dir/channel.scene"; echo "[shape w] cylinder = y  radius = 0.02 m  centre = 0.475 m, 0 m
[shape gap] box = 0 m .. 1 m, -0.5 m .. 0 m
[shape fin] difference = w, gap  kind = wall"; } > "$dir/fin.scene"
without fin 2 "$dir/fin.scene" "coarser: the lattice at h = 100 mm cannot hold the scene: the wall near x = 475 mm is \
thinner than one of its cells"
sed '/^\[plane/d' "$dir/channel.scene" > "$dir/blind.scene"
without blind 2 "$dir/blind.scene" \
    "the scene watches nothing: add a [probe NAME] or another section of that sort"

# ---- --check finds before a run what the estimate would be refused for ----

# checked STATUS MESSAGE DIM SCENE ARGUMENT...: the last line of both streams.
checked() {
    wanted=$1 message=$2 dim=$3 scene=$4
    shift 4
    "$programs/pd${dim}d" "$scene" --check --out "$dir/checked" "$@" > "$dir/log" 2>&1
    [ $? = "$wanted" ] && tail -n 1 "$dir/log" | grep -qF -- "$message" && [ ! -e "$dir/checked" ]
    verdict "check of ${scene##*/} $*: expected $wanted and '$message'"
}
checked 2 "pd1d: no error estimate: coarser: the lattice at 2 h cannot hold the scene: the box has 201 cells along x, \
expected a multiple of 2" 1 "$scenes/pencil_304_1d.scene" --estimate-error
checked 2 "the face of a shape at x = 110 um is cell 11 of the box" 1 "$scenes/rate_1d.scene" --accuracy 1%
checked 2 "no error estimate: the scene watches nothing" 2 "$dir/blind.scene" --estimate-error
checked 0 "note: the error estimate will assume orders: coarser: the lattice at 4 h cannot hold the scene: the box" \
    1 "$scenes/pencil_304_1d.scene" "h=0.25 um" --estimate-error
checked 0 "with files and pictures" 2 "$scenes/slab_2d.scene" --estimate-error
checked 1 "pd2d: memory: the run needs about " 2 "$scenes/slab_2d.scene" --memory-limit 1MB

# ---- wanted accuracy ----

run one 2 "$scenes/slab_2d.scene" --accuracy 1%
says one out "note: accuracy 1 %: picked run.rtol = 0.005"
says one out "reached=yes"
run rate_accuracy 2 "$scenes/rate_2d.scene" --accuracy 3% --quiet
says rate_accuracy out "reached=no reached_volume_loss=yes"
run fine 2 "$scenes/slab_2d.scene" --accuracy 0.02%
says fine out "accuracy=0.0002 reached=no"
wanted=$(value fine accuracy=0.0002 wanted_h)
run again 2 "$scenes/slab_2d.scene" "h=$wanted m" --accuracy 0.0002
says again out "accuracy=0.0002 reached=yes"
awk -v f="$(last again a_C)" 'BEGIN { e = f / 0.525513 - 1; exit !(f != "" && e < 2e-4 && e > -2e-4) }'
said=$?
verdict "again: at h = $wanted the probe shows $(last again a_C), expected 0.525513 within 0.02 %" $said
# what the scene sets wins
sed 's/^\[run\] */[run] rtol = 0.02 /' "$scenes/slab_2d.scene" > "$dir/kept.scene"
run kept 2 "$dir/kept.scene" --accuracy 1%
says kept out "note: accuracy 1 %: picked nothing; the scene sets run.rtol = 0.02"
"$programs/pd2d" "$dir/kept.scene" --out "$dir/same" > "$dir/same.out" 2>&1 &&
    cmp -s "$dir/same/probes.csv" "$dir/kept/probes.csv"
verdict "kept: the accuracy changes a run whose scene sets everything"
run pin 2 "${scenes%/*}/mg_pin_2d.scene" "h=20 um" "until=10 min" "every=10 min" --accuracy 1% --quiet
says pin err "pd2d: no error estimate: coarser: the lattice at 2 h cannot hold the scene: the box has 15 cells along y"
says pin out "accuracy=0.01 reached=unknown"

# ---- bad values ----

for bad in 0 200% 60% abc 1%% % nan -1 1e-9 ''; do
    "$programs/pd2d" "$scenes/slab_2d.scene" --out "$dir/bad" --accuracy "$bad" > "$dir/bad.out" 2> "$dir/bad.err"
    status=$?
    echo "pd2d: --accuracy expects a share from 0.0001% to 50%, such as 1% or 0.01; see pd2d --help" \
        > "$dir/wanted"
    [ $status = 2 ] && cmp -s "$dir/wanted" "$dir/bad.err" && [ ! -s "$dir/bad.out" ] && [ ! -e "$dir/bad" ]
    said=$?
    verdict "--accuracy '$bad': status $status, $(cat "$dir/bad.err")" $said
done
"$programs/pd2d" "$scenes/slab_2d.scene" --accuracy > "$dir/bad.out" 2> "$dir/bad.err"
[ $? = 2 ]
verdict "--accuracy without a value is taken"
score
