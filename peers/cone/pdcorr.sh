# One turn in 1 s; difference from the cone at the nodes, from the VTK file.
. "$CASE/../pdcorr.sh"
pd 2 "grid.h=1 m / $1" << 'END'
[grid]      h = 1 m / 50   box = 0 .. 1 m, 0 .. 1 m
[side x-]   flow = open
[side x+]   flow = open
[side y-]   flow = open
[side y+]   flow = open
[flow]      rho = 1 kg/m3   mu = 1 Pa s   speed = 1 m/s   length = 1 m   time = given
            vx = 2*pi*(0.5 m - y)/1 s
            vy = 2*pi*(x - 0.5 m)/1 s
[transport] D = 1e-12 m2/s   initial = 1 mol/m3 * max(1 - sqrt((x - 0.5 m)^2 + (y - 0.25 m)^2)/0.15 m, 0)
[run]       until = 1 s
[output]    every = 1 s   fields = C   images = none
END
/usr/bin/python3 "$CASE/off.py" "$1" out/*_000001_t1.0s.vti
