# Half of the sphere about an axis; n cells a radius of 50 um.
. "$CASE/../pdcorr.sh"
pd 2 "grid.h=50 um / $1" << 'END'
[grid]       geometry = axisymmetric   h = 5 um   box = 0 .. 160 um, 0 .. 160 um
[shape ball] ball = 0, 0   radius = 50 um   kind = solid   material = mg4ag
[shape rim]  ball = 0, 0   radius = 150 um   outside = yes   kind = wall   C = 0
[side x-]    flow = mirror
[transport]  D = 1e-9 m2/s
[dissolve]   rate = 10 um/s * (1 - C/Csat)   Csat = 100 mol/m3   Cs = 1000 mol/m3
[run]        until = 10 s
[output]     fields = none   images = none
END
echo "peer loss=$(value volume_loss dim=2)"
