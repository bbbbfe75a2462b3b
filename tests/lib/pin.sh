# pin: prints a scene of a pin in a stream with pictures and a film, which runs in seconds; it ends within [output].
# Sourced behind script.sh.

pin() {
    cat << 'END'
[grid]      h = 10 um   m = 3   box = -100 um .. 200 um, -60 um .. 60 um
[shape pin] box = 0 .. 60 um, -20 um .. 20 um   kind = solid   material = mg4ag   grain_size = 40 um
[side x-]   flow = inlet   profile = parabola   mean = 0.01 m/s   C = 0
[side x+]   flow = outlet
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport] D = 1e-9 m2/s
[dissolve]  rate = 1.3 um/h * (1 - C/Csat)   Csat = 56 mol/m3   grain_boundary_factor = 3
[run]       until = 4 h   max_dissolved_fraction = 0.03
[probe a]   at = 100 um, 0
[total all]
[output]    every = 1 h   fields = C, v, kind   images = C, kind   animate = yes   percentile = 99 %
END
}
