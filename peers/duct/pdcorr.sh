# A duct of side 1 m, four cells long, closed on itself, under a body force; n cells a side.
. "$CASE/../pdcorr.sh"
pd 3 "grid.h=1 m / $1" "grid.box=0 .. 4 m / $1, 0 .. 1 m, 0 .. 1 m" "probe.middle.at=2 m / $1, 0.5 m, 0.5 m" \
    "plane.cut.at=x 2 m / $1" << 'END'
[grid]    h = 1 m / 8   box = 0 .. 0.5 m, 0 .. 1 m, 0 .. 1 m
[side x-] flow = periodic
[side x+] flow = periodic
[flow]    rho = 1 kg/m3   mu = 1 Pa s   force = 1 m/s2, 0, 0
[output]  fields = none   images = none
[plane cut]     at = x 0.25 m
[probe middle]  at = 0.25 m, 0.5 m, 0.5 m   fields = v
END
echo "peer flow=$(value flow plane=cut) middle=$(last probes.csv middle_vx)"
