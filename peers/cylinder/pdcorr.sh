# n, or x:y: cells a diameter on a lattice that fits the cylinder, or cells along and across the channel.
. "$CASE/../pdcorr.sh"
case $1 in
*:*) h="2.2 m / ${1%:*}, 0.41 m / ${1#*:}" ;;
*) h="0.1 m / $1" ;;
esac
pd 2 "grid.h=$h" << 'EOF'
[grid]      h = 5 mm   m = 1   box = 0 .. 2.2 m, 0 .. 0.41 m
[shape c]   ball = 0.2 m, 0.2 m   radius = 0.05 m   kind = wall
[side x-]   flow = inlet   profile = parabola   mean = 0.2 m/s
[side x+]   flow = outlet
[flow]      rho = 1 kg/m3   mu = 1e-3 Pa s   speed = 0.2 m/s   length = 0.1 m   steady = 1e-6
[output]    fields = p   images = none
[probe front]  at = 0.15 m, 0.2 m   fields = p
[probe back]   at = 0.25 m, 0.2 m   fields = p
[force c]   box = 0.1 m .. 0.3 m, 0.1 m .. 0.3 m   speed = 0.2 m/s   length = 0.1 m
EOF
echo "peer drag=$(value cx_balance force=c) lift=$(value cy_balance force=c)" \
    "pressure=$(calc "$(last probes.csv front_p) - $(last probes.csv back_p)")"
