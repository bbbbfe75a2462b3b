# A plate of peridynamic points; horizon 3.015 h; no bonds across the notch, whose lips do not touch either. The modulus
# of bonds and their stretch are those of plane stress (Bobaru and Zhang 2015).
cat > in.plate << 'EOF'
units           si
dimension       2
boundary        s s p
atom_style      peri
atom_modify     map array
variable        h equal 0.04/${n}
variable        half equal ${h}/2
lattice         sq ${h} origin 0.5 0.5 0
region          plate block 0 0.1 0 0.04 -${half} ${half} units box
create_box      1 plate
create_atoms    1 region plate
variable        volume equal ${h}^3
set             group all density 2440
set             group all volume ${volume}
region          above block 0 0.05 0.02 INF INF INF units box
region          below block 0 0.05 INF 0.02 INF INF units box
group           above region above
group           below region below
variable        d equal 3.015*${h}
variable        skin equal 0.1*${h}
neighbor        ${skin} bin
neigh_modify    delay 10 check yes exclude group above below
pair_style      peri/pmb
variable        c equal 9*72e9/(PI*${d}^3*${h})
variable        s equal sqrt(4*PI*135/(9*72e9*${d}))
pair_coeff      * * ${c} ${d} ${s} 0.0
variable        edge equal 14e6/${h}
variable        inside equal 0.04-${h}
region          top block INF INF ${inside} INF INF INF units box
region          bottom block INF INF INF ${h} INF INF units box
group           top region top
group           bottom region bottom
fix             move all nve
fix             plane all enforce2d
fix             up top addforce 0 ${edge} 0
fix             down bottom addforce 0 -${edge} 0
compute         damage all damage/atom
variable        place atom (c_damage>0.15)*(y>0.01)*(y<0.03)*x
compute         tip all reduce max v_place
variable        dt equal ${h}/6000
timestep        ${dt}
variable        every equal round(0.5e-6/${dt})
variable        steps equal round(34e-6/${dt})
thermo          ${every}
thermo_style    custom step time c_tip
thermo_modify   lost ignore
run             ${steps}
EOF
times > before
lmp -in in.plate -var n "$1" -log log > out || { tail -3 out; exit 1; }
times > after
awk '/^ *Step/ { on = 1; next } /^Loop/ { on = 0 } on { print $2, $3 }' log | sh "$CASE/speed.sh"
bonds=$(sed -n 's/.*total # of bonds = //p' out)
cat before after | tr ms '  ' | awk -v bonds="$bonds" -v n="$1" '{ t = 60 * $1 + $2 + 60 * $3 + $4 }
    FNR == 2 { a = t } FNR == 4 { printf "peer cost=%.6g\n", 1e9 * (t - a) / (bonds / 2) / (204 * n / 40) }'
