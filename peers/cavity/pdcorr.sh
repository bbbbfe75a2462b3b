. "$CASE/../pdcorr.sh"
pd 2 "grid.h=1 m / $1" << 'END'
[grid]     h = 1 m / 64   box = 0 .. 1 m, 0 .. 1 m
[side y+]  flow = noslip   velocity = 1 m/s, 0 m/s
[flow]     rho = 1 kg/m3   mu = 1e-3 Pa s   speed = 1 m/s   length = 1 m
[output]   fields = none   images = none
[line up]      from = 0.5 m, 0   to = 0.5 m, 1 m   points = 1001   fields = v   images = none
[line across]  from = 0, 0.5 m   to = 1 m, 0.5 m   points = 1001   fields = v   images = none
END
# most TABLE COLUMN SIGN: the largest value of SIGN times a column.
most() {
    awk -F, -v name="$2" -v s="$3" 'NR == 1 { for (k = 1; k <= NF; k++) if (index($k, name) == 1) at = k; next }
        NR == 2 || s * $at > m { m = s * $at } END { printf "%.10g", s * m }' out/line_"$1"_*.csv
}
echo "peer umin=$(most up vx -1) vmax=$(most across vy 1) vmin=$(most across vy -1)"
