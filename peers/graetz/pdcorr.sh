# Cells are four times as long as high; n cells on half the height.
. "$CASE/../pdcorr.sh"
pd 2 "grid.h=2 m / $1, 0.5 m / $1" << 'END'
[grid]      h = 0.1 m, 0.025 m   m = 1   box = 0 .. 48 m, 0 .. 0.5 m
[side x-]   flow = open   C = 1 mol/m3
[side x+]   flow = open
[side y-]   C = 0 mol/m3
[side y+]   flow = mirror
[flow]      rho = 1 kg/m3   mu = 1 Pa s   speed = 1 m/s   length = 1 m   time = given
            vx = 6 m/s * (y / 1 m) * (1 - y / 1 m)
[transport] D = 1e-3 m2/s   initial = 1 mol/m3   time = steady
[output]    fields = none   images = none
[plane at] at = x 40 m
END
echo "peer bulk=$(value C_bulk plane=at)"
