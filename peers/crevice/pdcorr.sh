. "$CASE/../pdcorr.sh"
h=$(calc "0.1 / $1")
pd 2 << EOF
[grid]           h = $h mm   box = 0 mm .. 5 mm, $(calc "-2 * $h") mm .. 0.1 mm
[shape iron]     box = 0 mm .. 5 mm, $(calc "-2 * $h") mm .. 0 mm   kind = solid   material = steel304
[side x-]        potential = 0 V
[side y+]        flow = mirror
[potential]      conductivity = 0.5 S/m
[electrode iron] shape = iron   potential = -0.30 V
                 curve = tafel   i0 = 0.01 A/m2   E0 = -0.44 V   anodic_slope = 60 mV
[output]         fields = none   images = none
[probe end]      at = 5 mm, 0.1 mm   fields = phi
EOF
echo "peer current=$(value current electrode=iron) drop=$(last probes.csv end_phi)"
