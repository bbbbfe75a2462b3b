# Mean speed of a tip (lines of time [s], x [m]) from 60 mm to 80 mm.
awk 'function when(x) { return t0 + (x - x0) / ($2 - x0) * ($1 - t0) }
    NR > 1 && x0 < 0.06 && $2 >= 0.06 { from = when(0.06) }
    NR > 1 && x0 < 0.08 && $2 >= 0.08 { to = when(0.08) }
    { t0 = $1; x0 = $2 }
    END { printf "peer speed=%.8g start=%.8g\n", 0.02 / (to - from), 1e6 * from }'
