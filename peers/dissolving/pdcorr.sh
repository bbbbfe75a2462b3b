# A quarter of the disc; n cells a radius of 50 um. n:sphere: the quarter turns about an axis.
. "$CASE/../pdcorr.sh"
case $1 in
*:sphere) geometry=axisymmetric side= ;;
*) geometry=planar side='[side y-] flow = mirror' ;;
esac
pd 2 "grid.h=50 um / ${1%:*}" "grid.geometry=$geometry" << END
[grid]       h = 5 um   box = 0 .. 160 um, 0 .. 160 um
[shape disc] ball = 0, 0   radius = 50 um   kind = solid   material = mg4ag
[shape rim]  ball = 0, 0   radius = 150 um   outside = yes   kind = wall   C = 0
[side x-]    flow = mirror
$side
[transport]  D = 1e-9 m2/s
[dissolve]   rate = 10 um/s * (1 - C/Csat)   Csat = 100 mol/m3   Cs = 1000 mol/m3
[run]        until = 10 s
[output]     fields = none   images = none
END
echo "peer loss=$(value volume_loss dim=2)"
