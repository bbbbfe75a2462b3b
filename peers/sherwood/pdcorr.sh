. "$CASE/../pdcorr.sh"
pd 2 "grid.h=1 mm / $1" << 'END'
[grid]      h = 1 mm / 8   box = -5 mm .. 10 mm, 0 .. 5 mm
[shape c]   ball = 0, 0   radius = 0.5 mm   kind = wall   C = 1 mol/m3
[side x-]   flow = inlet   profile = uniform   mean = 40 mm/s   C = 0
[side x+]   flow = outlet
[side y-]   flow = mirror
[side y+]   flow = mirror
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport] D = 1e-7 m2/s   time = steady
[output]    fields = none   images = none
[transfer c] box = -1 mm .. 1 mm, 0 .. 1 mm   length = 1 mm   surface = 1 mol/m3   fluid = inlet   area = pi * 0.5 mm
END
echo "peer sherwood=$(value Sh transfer=c)"
