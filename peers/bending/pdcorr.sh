# The argument is n:material:m.
. "$CASE/../pdcorr.sh"
IFS=: read -r n material m << EOF
$1
EOF
h=$(calc "16 / $n")
pd 2 << EOF
[grid]      h = $h mm   box = 0 mm .. 80 mm, -8 mm .. 8 mm
[shape bar] box = 0 mm .. 80 mm, -8 mm .. 8 mm   kind = solid
[solid]     material = $material   m = $m   E = 70 GPa   nu = 0.499
[side x-]   traction = 20 MPa*y/(8 mm), -1 MPa*(1 - (y/(8 mm))^2)
[side x+]   traction = 0 MPa, 1 MPa*(1 - (y/(8 mm))^2)
[shape a]   ball = $(calc "0.5 * $h") mm, 0 mm   radius = $(calc "0.8 * $h") mm   kind = grip   uy = 0 mm
[shape b]   ball = $(calc "80 - 0.5 * $h") mm, 0 mm   radius = $(calc "0.8 * $h") mm   kind = grip   uy = 0 mm
[output]    fields = none   images = none
EOF
echo "peer energy=$(value stored solid=metal)"
