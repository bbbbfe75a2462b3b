. "$CASE/../pdcorr.sh"
pd 1 "grid.h=$(calc "10 / $1") mm" << 'EOF'
[grid]       h = 0.5 mm   m = 1   box = 0 mm .. 10 mm
[side x-]    flow = noslip   species = inlet
[chemistry]  activity = davies
[species H+]          D = 1e-9 m2/s   inlet = 10 mM   initial = 0 mM
[species OH-]         D = 1e-9 m2/s
[species Cl-]         D = 1e-9 m2/s   initial = 10 mM
[species Mg2+]        D = 1e-9 m2/s   inlet = 0 mM   initial = 5 mM
[species MgOH+]       D = 1e-9 m2/s
[species Mg(OH)2(s)]  initial = 10 mM
[reaction water]      H2O = H+ + OH-                      log10_K = -14
[reaction MgOH]       Mg2+ + H2O = MgOH+ + H+             log10_K = -11.44
[reaction brucite]    Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O    log10_K = 16.84
[mineral Mg(OH)2(s)]
[transport]  D = 1e-9 m2/s
[run]        until = 20 h
[output]     every = 20 h   fields = pH   images = none
[total all]  box = 0 mm .. 10 mm
[probe acid] at = 4 mm   fields = Mg2+
EOF
echo "peer left=$(value "Mg(OH)2(s)" total=all) magnesium=$(last probes.csv acid_Mg2+)"
