# n cells a diameter along the channel and as many across as fit; half the depth, the other half is its mirror image.
. "$CASE/../pdcorr.sh"
across=$(calc "int(4.1 * $1 + 0.5)")
half=$(calc "int(2.05 * $1 + 0.5)")
pd 3 "grid.h=0.1 m / $1, 0.41 m / $across, 0.205 m / $half" << 'EOF'
[grid]      h = 10 mm   m = 1   box = 0 .. 2.5 m, 0 .. 0.41 m, 0 .. 0.205 m
[shape c]   cylinder = z   centre = 0.5 m, 0.2 m, 0   radius = 0.05 m   kind = wall
[side x-]   flow = inlet   profile = expression
            vx = 16 * 0.45 m/s * y * (0.41 m - y) * z * (0.41 m - z) / (0.41 m)^4
[side x+]   flow = outlet
[side z+]   flow = mirror
[flow]      rho = 1 kg/m3   mu = 1e-3 Pa s   speed = 0.2 m/s   length = 0.1 m   steady = 1e-6
[output]    fields = none   images = none
[force c]   shape = c   speed = 0.2 m/s   area = 0.1 m * 0.205 m
EOF
echo "peer drag=$(value cx force=c) lift=$(value cy force=c)"
