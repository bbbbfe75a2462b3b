# n or n:Sc: cells a diameter, Schmidt number (10).
. "$CASE/../pdcorr.sh"
case $1 in *:*) sc=${1#*:} ;; *) sc=10 ;; esac
pd 2 "grid.h=1 mm / ${1%:*}" "transport.D=1e-6 m2/s / $sc" << 'END'
[grid]      geometry = axisymmetric   h = 1 mm / 8   box = -5 mm .. 10 mm, 0 .. 5 mm
[shape c]   ball = 0, 0   radius = 0.5 mm   kind = wall   C = 1 mol/m3
[side x-]   flow = inlet   profile = uniform   mean = 20 mm/s   C = 0
[side x+]   flow = outlet
[side y+]   flow = noslip    velocity = 20 mm/s, 0
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport] D = 1e-7 m2/s   time = steady
[output]    fields = none   images = none
[transfer c] box = -1 mm .. 1 mm, 0 .. 1 mm
END
# Flux over pi d D (1 mol/m3).
echo "peer sherwood=$(calc "$(value flux transfer=c) * $sc / (atan2(0, -1) * 1e-3 * 1e-6)")"
