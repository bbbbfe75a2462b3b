# The argument is n:material:m.
. "$CASE/../pdcorr.sh"
IFS=: read -r n material m << EOF
$1
EOF
[ $material = springs ] && material=bond_based
h=$(calc "1000 / $n")
pd 1 << EOF
[grid]      h = $h mm   box = 0 m .. 1 m
[shape bar] box = 0 m .. 1 m   kind = solid
[solid]     model = $material   m = $m   E = 200 GPa   dynamics = yes   density = 8000 kg/m3
[side x+]   traction = if(t < 40 us, 1 MPa*sin(pi*t/(40 us))^2, 0 Pa)
[run]       until = 300 us
[output]    every = 300 us   fields = none   images = none
[line bar]  from = $(calc "0.5 * $h") mm   to = $(calc "1000 - 0.5 * $h") mm   points = $n   fields = u   images = none
EOF
awk -F, 'NR > 1 { print $2, $NF }' out/line_bar_000001_*.csv | sh "$CASE/error.sh"
