. "$CASE/../pdcorr.sh"
cat > cube.scene << 'EOF'
[grid]      h = 1 mm   box = 0 .. 24 mm, 0 .. 24 mm, 0 .. 24 mm
[shape b]   box = 0 .. 1 m, 0 .. 1 m, 0 .. 1 m   kind = solid
[side x-]   traction = -1 MPa, 0 Pa, 0 Pa
[side x+]   traction = 1 MPa, 0 Pa, 0 Pa
[solid]     model = bond_based  E = 72 GPa   m = 3   dynamics = yes   density = 2440 kg/m3
[run]       until = 1 us
[output]    every = 1 s   fields = none   images = none
EOF
box="0 .. $1 mm, 0 .. $1 mm, 0 .. $1 mm"

# seconds STEPS KEY=VALUE...: processor time of a run, of steps as long as it takes by itself.
seconds() {
    steps=$1
    shift
    pd 3 "grid.box=$box" "shape.b.box=$box" "run.until=$(calc "($steps - 0.01) * $length") s" "$@" < cube.scene
    value cpu_s dim=3
}

# cost NAME FEW MANY KEY=VALUE...: figures of a step and of a bond.
cost() {
    name=$1 few=$2 many=$3
    shift 3
    "$PD/pd3d" cube.scene --check "grid.box=$box" "shape.b.box=$box" "$@" > summary
    length=$(sed -n 's/.* steps of \(.*\) s$/\1/p' summary)
    bonds=$(sed -n 's/.* \([0-9]*\) bonds;.*/\1/p' summary)
    step=$(calc "($(seconds "$many" "$@") - $(seconds "$few" "$@")) / ($many - $few)")
    echo "peer ${name}_step=$(calc "1e3 * $step") ${name}_bond=$(calc "1e9 * $step / $bonds")"
}
cost spring 20 80
cost ordinary 5 25 solid.model=ordinary solid.nu=0.25
