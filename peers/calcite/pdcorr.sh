# One half; the other is its mirror image. C is what the acid has turned into, 10 mol/m3 less the acid: a rate of k
# times the acid is k (Csat - C). The content is so large that the cylinder stays as it is. n cells a radius.
. "$CASE/../pdcorr.sh"
pd 2 "grid.h=0.1 mm / $1" << 'END'
[grid]       h = 0.1 mm / 8   box = 0 .. 1 mm, 0 .. 0.25 mm
[shape c]    ball = 0.5 mm, 0.25 mm   radius = 0.1 mm   kind = solid   material = mg4ag
[side x-]    flow = inlet   profile = uniform   mean = 1.2 mm/s   C = 0
[side x+]    flow = outlet
[side y-]    flow = noslip
[side y+]    flow = mirror
[flow]       rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport]  D = 1e-9 m2/s
[dissolve]   rate = 8.9125094e-4 m/s * Csat/Cs * (1 - C/Csat)   Csat = 10 mol/m3   Cs = 1e10 mol/m3
[run]        until = 20 s
[output]     fields = none   images = none
[transfer c] box = 0.3 mm .. 0.7 mm, 0.1 mm .. 0.25 mm   area = pi * 0.1 mm
END
echo "peer rate=$(value density transfer=c)"
