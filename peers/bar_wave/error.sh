# Root of the mean square error of displacements (lines of x [m], u [m]) at 300 us, over the largest: d'Alembert's
# waves from the loaded end and from the free one.
awk 'function wave(t) {
        if (t <= 0) return 0
        if (t >= 4e-5) return 5e-7
        return 0.025 * (0.5 * t - 4e-5 / (4 * pi) * sin(2 * pi * t / 4e-5))
    }
    BEGIN { pi = 3.14159265358979 }
    { u = wave(3e-4 - (1 - $1) / 5000) + wave(3e-4 - (1 + $1) / 5000); sum += ($2 - u)^2; count++ }
    END { printf "peer profile=%.8g\n", sqrt(sum / count) / 1e-6 }'
