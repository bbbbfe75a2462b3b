. "$CASE/../pdcorr.sh"
h=$(calc "200 / $1")
pd 1 << EOF
[grid]           h = $h um   m = 1   box = $(calc "-2 * $h") um .. $(calc "200 + 2 * $h") um
[shape a]        box = $(calc "-2 * $h") um .. 0 um   kind = solid   material = copper
[shape c]        box = 200 um .. $(calc "200 + 2 * $h") um   kind = solid   material = steel304
[chemistry]      activity = ideal   migration = yes
[species Cu2+]   D = 0.72e-9 m2/s   initial = 50 mM
[species SO4-2]  D = 1.065e-9 m2/s   initial = 50 mM
[potential]
[electrode anode]   shape = a   curve = expression   i = 1000 A/m2*E/(1 V)   range = -2 V .. 2 V
                    reaction = Cu = Cu2+ + 2 e-   potential = 0.45 V
[electrode cathode] shape = c   curve = expression   i = -0.1 A/m2*[Cu2+]/(50 mM)*10^(-E/(60 mV))
                    reaction = Cu = Cu2+ + 2 e-   potential = 0 V
[run]            until = 100 s
[output]         every = 100 s   fields = none   images = none
[probe first]    at = $(calc "0.5 * $h") um   fields = Cu2+
[probe second]   at = $(calc "1.5 * $h") um   fields = Cu2+
EOF
# At the surface, straight on from the two nodes beside it.
echo "peer current=$(value current electrode=anode)" \
    "salt=$(calc "1.5 * $(last probes.csv first_Cu2+) - 0.5 * $(last probes.csv second_Cu2+)")"
