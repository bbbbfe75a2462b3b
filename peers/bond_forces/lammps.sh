# A cube of peridynamic points that is stretched by its velocity.
cat > in.cube << 'EOF'
units           si
boundary        s s s
atom_style      peri
atom_modify     map array
lattice         sc 1e-3
variable        top equal ${n}*1e-3-0.5e-3
region          cube block 0 ${top} 0 ${top} 0 ${top} units box
create_box      1 cube
create_atoms    1 region cube
set             group all density 2440
set             group all volume 1e-9
neighbor        1e-4 bin
neigh_modify    delay 10 check yes
variable        d equal 3.015e-3
if "${style} == pmb" then "variable law string '$(18*48e9/(PI*v_d^4):%.15g) ${d}'" &
    else "variable law string '48e9 28.8e9 ${d}'"
pair_style      peri/${style}
pair_coeff      * * ${law} 1e10 0.0
velocity        all ramp vx -0.1 0.1 x 0 ${top} units box
fix             move all nve
timestep        5e-8
thermo          100000
run             ${steps}
EOF

# seconds N STYLE STEPS: processor time of a run, in `used`.
seconds() {
    times > before
    lmp -in in.cube -var n "$1" -var style "$2" -var steps "$3" -log none > out || { tail -3 out; exit 1; }
    times > after
    used=$(cat before after | tr ms '  ' |
        awk '{ t = 60 * $1 + $2 + 60 * $3 + $4 } FNR == 2 { a = t } FNR == 4 { print t - a }')
}

for name in spring ordinary; do
    style=pmb
    [ $name = spring ] || style=lps
    seconds "$1" $style 50
    few=$used
    seconds "$1" $style 250
    bonds=$(sed -n 's/.*total # of bonds = //p' out)
    awk -v few="$few" -v many="$used" -v bonds="$bonds" -v name=$name 'BEGIN {
        step = (many - few) / 200
        printf "peer %s_step=%.6g %s_bond=%.6g\n", name, 1e3 * step, name, 1e9 * step / (bonds / 2) }'
done
