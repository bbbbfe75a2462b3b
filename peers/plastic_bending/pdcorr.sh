# The argument is n:m, n cells through the depth.
. "$CASE/../pdcorr.sh"
n=${1%:*} m=${1#*:}
h=$(calc "16 / $n")
pd 2 << EOF
[grid]       h = $h mm   box = -24 mm .. 24 mm, -8 mm .. 8 mm
[shape bar]  box = -24 mm .. 24 mm, -8 mm .. 8 mm   kind = solid
[shape l]    box = -24 mm .. -20 mm, -8 mm .. 8 mm   kind = grip   ux = 0.5/(1 m*1 s)*x*y*t
[shape r]    box = 20 mm .. 24 mm, -8 mm .. 8 mm     kind = grip   ux = 0.5/(1 m*1 s)*x*y*t
[shape foot] ball = $(calc "$h / 2") mm, $(calc "$h / 2") mm   radius = $(calc "0.3 * $h") mm   kind = grip   uy = 0 mm
[solid]      E = 200 GPa   nu = 0.3   m = $m   yield = 200 MPa
[run]        until = 1 s   max_step = 0.025 s
[output]     every = 1 s   fields = none   images = none
EOF
echo "peer work=$(value work solid=metal)"
