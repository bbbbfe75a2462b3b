. "$CASE/../pdcorr.sh"
low="$(calc "-2 / $1") m"
pd 2 << EOF
[grid]        h = $(calc "1 / $1") m   box = 0 .. 1 m, $low .. 1 m
[side x-]     flow = mirror
[side x+]     flow = mirror
[shape a]     box = 0 .. 0.5 m, $low .. 0 m   kind = solid
[shape b]     box = 0.5 m .. 1 m, $low .. 0 m   kind = solid
[potential]   conductivity = 1 S/m
[electrode a] shape = a   curve = linear   E0 = -1 V   resistance = 0.1 ohm m2
[electrode b] shape = b   curve = linear   E0 = 0 V   resistance = 0.1 ohm m2
[output]      fields = none   images = none
EOF
echo "peer current=$(value current electrode=a) end=$(value least electrode=a)"
