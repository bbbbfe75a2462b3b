. "$CASE/../pdcorr.sh"
h=$(calc "40 / $1")
pd 2 << EOF
[grid]        h = $h mm   box = 0 mm .. 100 mm, 0 mm .. 40 mm
[shape plate] box = 0 mm .. 100 mm, 0 mm .. 40 mm   kind = solid
[crack notch] points = 0 mm, 20 mm, 50 mm, 20 mm
[side y-]     traction = 0 MPa, -14 MPa
[side y+]     traction = 0 MPa, 14 MPa
[solid]       model = bond_based  m = 3   E = 72 GPa   plane = stress   fracture_energy = 135 J/m2
              dynamics = yes   density = 2440 kg/m3
[run]         until = 34 us
[output]      every = 0.5 us   fields = none   images = none
EOF
"$PD/pd2d" case.scene --check > summary
bonds=$(sed -n 's/.* \([0-9]*\) bonds;.*/\1/p' summary)
length=$(sed -n 's/.* steps of \(.*\) s$/\1/p' summary)
# An interval between two outputs has as many equal steps as it takes.
steps=$(awk "BEGIN { k = int(0.5e-6 / $length); if (k * $length < 0.5e-6) k++; print 68 * k }")
awk -F, 'NR > 1 { print $1, $2 }' out/crack_notch.csv | sh "$CASE/speed.sh"
echo "peer cost=$(calc "1e9 * $(value cpu_s dim=2) / $bonds / $steps")"
