# One dissolved substance and a wall that holds none of it; n cells across the channel. Four electrons a molecule of O2.
. "$CASE/../pdcorr.sh"
pd 2 "grid.h=1 mm / $1" "grid.box=-1 mm .. 4 mm, -4 mm / $1 .. 1 mm" \
    "shape.left.box=-1 mm .. 0 mm, -4 mm / $1 .. 0 mm" "shape.right.box=2 mm .. 4 mm, -4 mm / $1 .. 0 mm" \
    "shape.metal.box=0 mm .. 2 mm, -4 mm / $1 .. 0 mm" << 'END'
[grid]        h = 50 um   box = -1 mm .. 4 mm, -0.2 mm .. 1 mm
[side x-]     flow = inlet   profile = parabola   mean = 10 mm/s   C = 0.2 mol/m3
[side x+]     flow = outlet
[flow]        rho = 1000 kg/m3   mu = 1 mPa s
[shape left]  box = -1 mm .. 0 mm, -0.2 mm .. 0 mm   kind = wall
[shape right] box = 2 mm .. 4 mm, -0.2 mm .. 0 mm   kind = wall
[shape metal] box = 0 mm .. 2 mm, -0.2 mm .. 0 mm   kind = wall   C = 0
[transport]   D = 2e-9 m2/s   initial = 0.2 mol/m3   time = steady
[output]      fields = none   images = none
[transfer t]
END
echo "peer current=$(calc "-4 * 96485.33212 * $(value flux transfer=t)")"
