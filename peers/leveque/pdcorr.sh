# Species and metal that dissolves; n cells across the channel. The current is that of the metal lost from 1 to 2 min,
# two electrons an atom.
. "$CASE/../pdcorr.sh"
pd 2 "grid.h=1 mm / $1" "grid.box=-1 mm .. 4 mm, -4 mm / $1 .. 1 mm" \
    "shape.left.box=-1 mm .. 0 mm, -4 mm / $1 .. 0 mm" "shape.right.box=2 mm .. 4 mm, -4 mm / $1 .. 0 mm" \
    "shape.metal.box=0 mm .. 2 mm, -4 mm / $1 .. 0 mm" << 'END'
[grid]        h = 50 um   box = -1 mm .. 4 mm, -0.2 mm .. 1 mm
[side x-]     flow = inlet   profile = parabola   mean = 10 mm/s
[side x+]     flow = outlet
[flow]        rho = 1000 kg/m3   mu = 1 mPa s
[shape left]  box = -1 mm .. 0 mm, -0.2 mm .. 0 mm   kind = wall
[shape right] box = 2 mm .. 4 mm, -0.2 mm .. 0 mm   kind = wall
[shape metal] box = 0 mm .. 2 mm, -0.2 mm .. 0 mm   kind = solid   material = steel304
[chemistry]   activity = ideal
[species O2]  D = 2e-9 m2/s      initial = 0.2 mol/m3
[species OH-] D = 5.27e-9 m2/s   initial = 1e-4 mol/m3
[species K+]  D = 1.96e-9 m2/s   initial = 1e-4 mol/m3
[species Fe2+] D = 1e-9 m2/s
[species H2O]
[transport]   D = 1e-9 m2/s
[dissolve]    rate = 1e-6 m/s * [O2]/(1 mol/m3)   reaction = 2 Fe + O2 + 2 H2O = 2 Fe2+ + 4 OH-
[run]         until = 2 min
[output]      every = 1 min   fields = none   images = none
[total t]
END
# Metal at 1 and 2 min.
echo "peer current=$(awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) if (index($k, "solid [") == 1) at = k; next }
        $1 == 60 { m = $at } $1 == 120 { printf "%.10g", 2 * 96485.33212 * (m - $at) / 60 }' out/total_t.csv)"
