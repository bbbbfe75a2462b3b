. "$CASE/../pdcorr.sh"
n=${1%:*} how=${1#*:}
if [ "$how" = grip ]; then
    low="$(calc "-2000 / $n") mm"
    held="[shape held]  box = $low .. 0 mm, 0 m .. 1 m, 0 m .. 1 m   kind = grip   ux = 0 mm   uy = 0 mm   uz = 0 mm"
else
    low="0 mm"
    held="[side x-]   ux = 0 mm   uy = 0 mm   uz = 0 mm"
fi
pd 3 << EOF
[grid]       h = $(calc "1000 / $n") mm   box = $low .. 1 m, 0 m .. 1 m, 0 m .. 1 m
[shape cube] box = $low .. 1 m, 0 m .. 1 m, 0 m .. 1 m   kind = solid
[solid]      E = 100 kPa   nu = 0.3   m = 2
$held
[side x+]    traction = 0 Pa, 100 Pa, 0 Pa
[output]     fields = none   images = none
EOF
echo "peer energy=$(value stored solid=metal)"
