#!/bin/sh
# Bad scenes: the driver says what is wrong in one line with file and line, ends with 2 and leaves no output behind.
. tests/lib/script.sh
cd "$dir" || exit 1

# A small channel with a pin: the base that each case spoils.
base() {
    cat << 'END'
[grid]      h = 10 um   m = 3   box = -100 um .. 200 um, -60 um .. 60 um
[shape pin] box = 0 .. 60 um, -20 um .. 20 um   kind = solid   material = mg4ag   grain_size = 40 um
[side x-]   flow = inlet   profile = parabola   mean = 0.01 m/s   C = 0
[side x+]   flow = outlet   p = 0
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport] D = 1e-9 m2/s
[dissolve]  rate = 1.3 um/h * (1 - C/Csat)   Csat = 56 mol/m3   grain_boundary_factor = 3
[run]       until = 1 h
[output]    fields = C, v
[probe a]   at = 100 um, 0
END
}

# rejects NAME MESSAGE [ARGUMENT...]: status 2, nothing on stdout, exactly the line "pd2d: MESSAGE", no folder.
rejects() {
    name=$1 message=$2
    shift 2
    rm -rf out
    "$programs/pd2d" bad.scene --out out "$@" > stdout 2> stderr
    status=$?
    printf 'pd2d: %s\n' "$message" > wanted
    [ $status = 2 ] && [ ! -s stdout ] && [ ! -e out ] && cmp -s stderr wanted
    said=$?
    {
        echo "status $status, folder $([ -e out ] && echo made || echo absent)"
        sed 's/^/expected /' wanted
        sed 's/^/found    /' stderr
        sed 's/^/stdout   /' stdout
    } > log
    verdict "$name" $said
}

# spoil NAME SED MESSAGE: one edit of the base.
spoil() {
    base | sed "$2" > bad.scene
    rejects "$1" "$3"
}

spoil "no h" 's/h = 10 um  *m/m/' "bad.scene:1: found no 'h' in [grid], expected h = a length [m]"
for side in x- x+ y- y+; do
    base | sed "/^\[side $side\]/d; s/mu = 1e-3 Pa s/& time = implicit\n[side $side] flow = open/" > bad.scene
    line=$(grep -n 'time = implicit' bad.scene | cut -d: -f1)
    rejects "a flow in time beside the open side $side" \
        "bad.scene:$line: time: found 'implicit' beside an open side, expected prescribed"
done
spoil "no unit" 's/h = 10 um/h = 10/' \
    "bad.scene:1: column 17: found a number without unit, expected a length [m]: write its unit, for example \
nm, um, mm, m, km"
spoil "wrong unit" 's/mean = 0.01 m\/s/mean = 0.01 kg/' \
    "bad.scene:3: column 56: found a mass [kg], expected a speed [m/s]"
spoil "unknown unit" 's/until = 1 h/until = 1 hr/' \
    "bad.scene:8: column 23: found 'hr', expected a unit or an operator: did you mean 'hm'?"
spoil "unknown key" 's/until/untl/' \
    "bad.scene:8: found the unknown key 'untl' in [run], expected one of until, rtol, max_dissolved_fraction, \
max_step: did you \
mean 'until'?"
# pictures
drawn() { spoil "$1" "s/fields = C, v/images = C, kind  $2/" "$3"; }
drawn "a range of a field that is not drawn" 'range = v 0 .. 1 m\/s' \
    "bad.scene:9: range: found 'v', expected one of the fields of 'images'"
drawn "a range of no field" 'range = 0 .. 1' "bad.scene:9: range: found '0', expected one of the fields of 'images'"
drawn "half a range" 'range = C 5 mol\/m3' \
    "bad.scene:9: range: found '5 mol/m3' behind 'C', expected a range: C 0 .. 1 mol/m3"
drawn "a range whose first value has no unit" 'range = C 5 .. 6 mol\/m3' \
    "bad.scene:9: range: 5: column 1: found a number without unit, expected a concentration [mol/m3]: write its unit, \
for example umol/m3, mmol/m3, mol/m3, kmol/m3"
drawn "a range of labels" 'range = kind 0 .. 1' "bad.scene:9: range: found 'kind', whose values have a colour each"
drawn "a range twice" 'range = C 0 .. 1 mol\/m3, C 0 .. 2 mol\/m3' "bad.scene:9: range: found 'C' twice"
drawn "an empty range" 'range = C 1 mol\/m3 .. 1 mol\/m3' \
    "bad.scene:9: range: found 1 .. 1 of 'C', expected the smaller value first"
drawn "a logarithmic range from zero" 'log = C  range = C 0 .. 1 mol\/m3' \
    "bad.scene:9: range: found 0 of 'C', which is drawn by its logarithm, expected a positive value"
drawn "the logarithm of labels" 'log = kind' "bad.scene:9: log_scale: found 'kind', whose values have a colour each"
drawn "the logarithm of what is not drawn" 'log = v' \
    "bad.scene:9: log_scale: found 'v', expected one of the fields of 'images'"
drawn "an unknown map" 'map = jet' \
    "bad.scene:9: colormap: found 'jet', expected violet, viridis, grey or diverging, or one of them behind a field"
drawn "a map of what is not drawn" 'map = v grey' \
    "bad.scene:9: colormap: found 'v', expected one of the fields of 'images'"
drawn "no share" 'percentile = 0' \
    "bad.scene:9: percentile: found 0 %, expected a share above 0 and up to 100 %"
drawn "a share without its unit" 'percentile = 98' \
    "bad.scene:9: percentile: found 9800 %, expected a share above 0 and up to 100 %"
drawn "an unknown format" 'format = png, gif' "bad.scene:9: format: found 'gif', expected png, svg or both"
drawn "a width of nothing" 'width = 0' \
    "bad.scene:9: column 39: found 0, expected a whole number from 120 to 4000"
drawn "unknown cells" 'cells = round' \
    "bad.scene:9: column 39: found 'round', expected one of blocky, smooth"
drawn "contours of what is not drawn" 'contours = v 8' \
    "bad.scene:9: contours: found 'v', expected one of the fields of 'images'"
drawn "contours of labels" 'contours = kind 2' \
    "bad.scene:9: contours: found 'kind', whose values have a colour each"
drawn "no number of contours" 'contours = C 2.5' \
    "bad.scene:9: contours: found '2.5' behind 'C', expected a number of lines from 1 to 32, or values: C at 1 2 \
mol/m3"
drawn "too many contours" 'contours = C 33' \
    "bad.scene:9: contours: found '33' behind 'C', expected a number of lines from 1 to 32, or values: C at 1 2 \
mol/m3"
drawn "contours at no value" 'contours = C at mol\/m3' \
    "bad.scene:9: contours: found no value behind 'C at', expected some: C at 1 2 mol/m3"
drawn "contours twice" 'contours = C 8, C at 1 mol\/m3' "bad.scene:9: contours: found 'C' twice"
drawn "streamlines over what is not drawn" 'streamlines = v' \
    "bad.scene:9: streamlines: found 'v', expected one of the fields of 'images'"
drawn "streamlines twice" 'streamlines = C, C 30' "bad.scene:9: streamlines: found 'C' twice"
drawn "too many streamlines" 'streamlines = kind 101' \
    "bad.scene:9: streamlines: found '101' behind 'kind', expected how many fit side by side, from 4 to 100"
drawn "no number of arrows" 'vectors = C many' \
    "bad.scene:9: vectors: found 'many' behind 'C', expected how many fit side by side, from 4 to 100"
drawn "a surface in 2D" 'surface = yes' "bad.scene:9: surface: found in 2D, expected it in 3D"
drawn "a view of nothing" 'view = 1, 1, 1' "bad.scene:9: view: found without 'surface'"
drawn "no animation" 'animate = gif' \
    "bad.scene:9: column 41: found 'gif', expected one of no, yes, false, true, off, on"
spoil "a key of pictures without any" 's/fields = C, v/fields = C  width = 500/' \
    "bad.scene:9: width: found without 'images', the fields that are drawn"
spoil "no until" 's/until = 1 h//' "bad.scene:8: found no 'until' in [run], expected until = a time [s]"
spoil "a unit in other letters" 's/D = 1e-9 m2/D = 1e-9 m²/' \
    "bad.scene:6: column 22: found 'm²', expected a unit or an operator"
spoil "unknown section" 's/\[transport\]/[transprt]/' \
    "bad.scene:6: scene: found the section [transprt], expected one of constants, grid, shape, side, flow, gas, \
transport, dissolve, corrode, solid, crack, table, chemistry, species, reaction, mineral, potential, electrode, \
surface, \
run, output, probe, line, plane, force, transfer, total, measured: \
did you mean 'transport'?"
spoil "cut without solid" 's/^\[run\]/[crack a] points = 0 um, 0 um, 60 um, 0 um\n[run]/' \
    "bad.scene:8: crack: found no [solid] section, expected one"
solid='[solid] E = 45 GPa   nu = 0.3\n[side y-] ux = 0 um   uy = 0 um\n'
spoil "cut of half a corner" "s/^\[run\]/$solid[crack a] points = 0 um, 0 um, 60 um\n[run]/" \
    "bad.scene:10: points: found 3 numbers, expected 2 or more corners of a line, 2 numbers each"
spoil "cut without name" "s/^\[run\]/$solid[crack] points = 0 um, 0 um, 60 um, 0 um\n[run]/" \
    "bad.scene:10: crack: expected a short name: [crack NAME]"
spoil "cut of no length" "s/^\[run\]/$solid[crack a] points = 0 um, 0 um, 0 um, 0 um\n[run]/" \
    "bad.scene:10: points: found corner 2 at the place of corner 1, expected another place"
spoil "contours too close" "s/^\[run\]/$solid[crack a] points = 0 um, 0 um, 60 um, 0 um   contour_radii = 0 um, 9 um, \
99 um\n[run]/" "bad.scene:10: contour_radii: found 0 and 9e-06 m, expected growing radii a horizon m h or more \
apart, here \
2e-05 m"
spoil "metal too thin for its grips" "s/^\[run\]/$solid[run]/;s/-20 um .. 20 um/-60 um .. -20 um/" \
    "bad.scene:8: grip: the side y- holds 4 rows of nodes, two horizons, and no line of metal has one more that is \
free behind them: choose a smaller h, or a grip"
spoil "metal too thin to bear" "s/^\[run\]/$solid[run]/;s/-20 um .. 20 um/-60 um .. -50 um/" \
    "bad.scene:8: solid: the metal is too thin to bear loads: no node has bonds along all directions; choose a \
smaller h"
breaks="correspondence breaks by fracture_energy (without yield_stress), strength or critical_stretch, at rest; \
ordinary, \
neo_hookean and hencky by strength or critical_stretch, at rest; bond_based by fracture_energy, at rest and in \
motion; yield_stress is of \
correspondence and hencky at rest"
spoil "yield below the balance" "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   yield_stress = 1 Pa/" \
    "bad.scene:8: yield_stress: found 1 Pa, expected 0 or at least 1000 rtol E = 450000 Pa: balances are no finer"
spoil "toughness and stretch" "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   fracture_energy = 5 J\/m2   \
critical_stretch = 0.1/" \
    "bad.scene:8: fracture_energy: found beside critical_stretch, expected one of critical_stretch, strength and \
fracture_energy"
spoil "toughness of rubber" \
    "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   model = neo_hookean   fracture_energy = 5 J\/m2/" \
    "bad.scene:8: fracture_energy: found with model = neo_hookean, expected another one of both: $breaks"
spoil "toughness of metal that flows" \
    "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   yield_stress = 400 MPa   fracture_energy = 5 J\/m2/" \
    "bad.scene:8: fracture_energy: found with yield_stress, expected critical_stretch or strength: energies of bonds \
are those of \
metal that does not flow"
spoil "J of metal that flows" "s/^\[run\]/$solid[crack a] points = 0 um, 0 um, 60 um, 0 um   contour_radii = 0 um, \
29 um, \
99 um\n[run]/;s/nu = 0.3/nu = 0.3   yield_stress = 400 MPa/" \
    "bad.scene:10: contour_radii: found with yield_stress, expected small strains in balance: J is theirs"
spoil "unknown key of metal" "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   fracture_enery = 5 J\/m2/" \
    "bad.scene:8: found the unknown key 'fracture_enery' in [solid], expected one of E, nu, model, \
plane, yield_stress, hardening_modulus, fracture_energy, strength, critical_stretch, dynamics, density, body_force, \
dissolution_factor, m, influence, \
rtol: did you mean 'fracture_energy'?"
spoil "ratio of springs" "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   model = bond_based/" \
    "bad.scene:8: nu: found 0.3 with model = bond_based, expected their 0.25, or another material: $breaks"
spoil "springs that dissolve" "s/^\[run\]/$solid[run]/;s/nu = 0.3/model = bond_based/" \
    "bad.scene:8: model: found beside metal that dissolves, expected model = correspondence"
spoil "motion of what dissolves" "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   dynamics = yes   density = 7 g\/cm3/" \
    "bad.scene:8: dynamics: found beside metal that dissolves, expected dynamics = no"
spoil "density without motion" "s/^\[run\]/$solid[run]/;s/nu = 0.3/nu = 0.3   density = 7 g\/cm3/" \
    "bad.scene:8: density: found without dynamics = yes, expected both"
spoil "fractional cells" 's/h = 10 um/h = 7 um/' \
    "bad.scene:1: box: found 300 um on axis x, 42.8571 cells of 7 um, expected a whole number of cells"
spoil "one range" 's/, -60 um .. 60 um//' "bad.scene:1: box: found 1 range, expected 2, one for each axis: \
pd1d runs scenes in 1D"
spoil "range backwards" 's/-60 um .. 60 um/60 um .. -60 um/' \
    "bad.scene:1: column 57: found a range from 6e-05 to -6e-05, expected its start below its end"
spoil "m too large" 's/m = 3/m = 9/' "bad.scene:1: m: found 9, expected a value from 1 to 6"
spoil "negative density" 's/rho = 1000/rho = -1000/' "bad.scene:5: rho: found -1000 kg/m3, expected a positive value"
spoil "unknown side" 's/side x+/side w+/' "bad.scene:4: side: found [side w+], expected one of x-, x+, y-, y+ in 2D"
spoil "unknown profile" 's/parabola/parabole/' \
    "bad.scene:3: column 38: found 'parabole', expected one of uniform, parabola, expression: did you mean \
'parabola'?"
spoil "no speed" 's/mean = 0.01 m\/s//' "bad.scene:3: found no 'mean' in [side x-], expected mean = a speed [m/s]"
spoil "no outlet" 's/flow = outlet   p = 0/flow = noslip/' \
    "bad.scene:5: flow: found an inlet and no outlet, expected flow = outlet in a [side ...]"
spoil "no solid" 's/kind = solid   material = mg4ag   grain_size = 40 um/kind = wall/' \
    "bad.scene:7: dissolve: found no solid, expected a [shape ...] with kind = solid"
spoil "no transport" '/transport/d' \
    "bad.scene:6: dissolve: found no [transport] section, expected one: the metal goes into the fluid"
spoil "no Csat" 's/Csat = 56 mol\/m3//' \
    "bad.scene:7: column 38: found 'Csat', expected a known variable, constant or function"
spoil "rate not a speed" 's/1.3 um\/h \*/1.3 um */' \
    "bad.scene:7: column 20: found a length [m], expected a speed [m/s]"
spoil "gb_factor without grains" 's/grain_size = 40 um//' \
    "bad.scene:7: grain_boundary_factor: found 3 without grains, expected grain_size = SIZE in a solid [shape ...]"
spoil "unknown material" 's/mg4ag/iron/' "bad.scene:2: material: found 'iron', expected mg4ag, steel304, \
copper or alloy625"
spoil "unknown field" 's/fields = C, v/fields = C, T/' \
    "bad.scene:9: fields: found 'T', expected some of C, v, p, kind, grain, phase, D, rate, density, or none"
spoil "field without physics" \
    's/fields = C, v/fields = C, v, grain/;s/grain_size = 40 um//;s/grain_boundary_factor = 3//' \
    "bad.scene:9: fields: found 'grain', which needs a solid [shape] with grain_size"
spoil "probe outside" 's/at = 100 um/at = 300 um/' \
    "bad.scene:10: at: found 0.0003 m on axis x, expected a place inside the box"
spoil "two shapes in one" 's/kind = solid/kind = solid   ball = 0, 0   radius = 5 um/' \
    "bad.scene:2: ball: found beside 'box', expected one primitive or operation in a [shape] section"
spoil "small letter" 's/C\/Csat/c\/Csat/' \
    "bad.scene:7: column 36: found 'c', expected a known variable, constant or function: did you mean 'C'?"
spoil "beyond all times" 's/until = 1 h/until = 1e300 s/' \
    "bad.scene:8: until: found 3.16881e+292 year, expected a value above 0 s and at most 3.16881e+22 year"
# scenes of another dimension
spoil "box in 3D" 's/-60 um .. 60 um/-60 um .. 60 um, 0 .. 40 um/' \
    "bad.scene:1: column 73: found ',', expected the end (at most 2 items, one for each axis: pd3d runs scenes in 3D)"
spoil "point in 3D" 's/at = 100 um, 0/at = 100 um, 0, 0/' \
    "bad.scene:10: column 27: found ',', expected the end (at most 2 items, one for each axis: pd3d runs scenes in 3D)"
spoil "force in 3D" 's/mu = 1e-3 Pa s/mu = 1e-3 Pa s   force = 0, 0, 1 m\/s2/' \
    "bad.scene:5: column 61: found ',', expected the end (at most 2 items, one for each axis: pd3d runs scenes in 3D)"
spoil "point in 1D" 's/at = 100 um, 0/at = 100 um/' \
    "bad.scene:10: at: found 1 number, expected 2, one for each axis: pd1d runs scenes in 1D"
spoil "side in 3D" 's/\[side x+\]/[side z+]/' \
    "bad.scene:4: side: found [side z+], expected one of x-, x+, y-, y+ in 2D"
spoil "unknown operand" 's/\[side x-\]/[shape b] union = pin, tube   kind = wall\n[side x-]/' \
    "bad.scene:3: union: found 'tube', expected the name of a [shape] above"
spoil "unused shape" 's/\[side x-\]/[shape b] ball = 0, 0   radius = 20 um\n[side x-]/' \
    "bad.scene:3: shape: 'b' has no kind and is part of no other shape, expected kind = solid, wall, \
medium, passive, grip or solution"
spoil "missing mask" 's/\[side x-\]/[shape b] mask = none.png   corner = 0, 0   cell = 1 um   kind = wall\n[side x-]/' \
    "bad.scene:3: mask: file: cannot open 'none.png': No such file or directory"
spoil "key twice" 's/until = 1 h/until = 1 h   until = 2 h/' \
    "bad.scene:8: found 'until' a second time in [run], first on line 8; expected it once"
spoil "solid outside" 's/box = 0 .. 60 um, -20/box = 0 .. 60 um, -80/' \
    "bad.scene:2: grid: the solid reaches from -8e-05 m to 2e-05 m on axis 1, outside of the box -6e-05 m .. \
6e-05 m"
spoil "solid too thin" 's/-20 um .. 20 um/-1 um .. 1 um/' \
    "bad.scene:2: grid: the solid covers no node: it is thinner than the spacing or lies inside the wall"
spoil "flow without section" '/^\[flow\]/d' \
    "bad.scene:3: flow: found 'inlet' without a [flow] section, expected C = ... alone to hold a concentration"
spoil "inlet closed" 's/box = 0 .. 60 um, -20 um .. 20 um/box = -100 um .. 60 um, -60 um .. 60 um/' \
    "bad.scene:3: inlet: side x-: the inlet is closed by wall or solid"
spoil "negative initial" 's/D = 1e-9 m2\/s/D = 1e-9 m2\/s   initial = 1 mol\/m3 * x\/(1 um)/' \
    "bad.scene:6: model: initial gives C = -95 mol/m3 at x = -9.5e-05 m, expected a finite value of at least 0"
spoil "box below the axis" 's/m = 3/m = 3   geometry = axisymmetric/' \
    "bad.scene:1: box: found y from -60 um, expected the distance from the axis to begin at 0 or at least at one \
horizon, 30 um"
round='s/m = 3/m = 3   geometry = axisymmetric/;s/-60 um .. 60 um/0 .. 60 um/'
spoil "wall on the axis" "$round"';s/\[flow\]/[side y-] flow = noslip\n[flow]/' \
    "bad.scene:5: flow: found 'noslip' on the axis, expected mirror or nothing"
spoil "mirror around the axis" "$round"';s/\[flow\]/[side y+] flow = mirror\n[flow]/' \
    "bad.scene:5: flow: found 'mirror' around an axis, expected noslip, inlet, outlet or open"
# watch NAME SECTION MESSAGE: the base with one more section on line 11.
watch() {
    { base; echo "$2"; } > bad.scene
    rejects "$1" "bad.scene:11: $3"
}
watch "line without end" "[line a] from = 0, 0   points = 5" "found no 'to' in [line a], expected to = a length [m]"
watch "line without points" "[line a] from = 0, 0   to = 50 um, 0" \
    "found no 'points' in [line a], expected points = a whole number"
watch "line of no length" "[line a] from = 0, 0   to = 0, 0   points = 5" \
    "to: found the point of 'from', expected another one"
watch "line drawn without field" "[line a] from = 0, 0   to = 50 um, 0   points = 5   fields = C   images = v" \
    "images: found a field that is not among 'fields'"
watch "plane at the end" "[plane a] at = x 198 um" \
    "at: found 0.000198 m, expected a place at least half a cell inside of the box"
watch "plane without axis" "[plane a] at = 10 um" "at: found '10 um', expected an axis and a place: y 0 um"
watch "force without box" "[force a] balance = no" "found no 'box' in [force a], expected box = a .. b, one range for \
each axis"
watch "force on nothing" "[force a] shape = none" \
    "shape: found 'none', expected the name of a [shape] with kind = solid or wall"
watch "force too near" "[force a] box = -10 um .. 80 um, -30 um .. 60 um" \
    "force: cells 3 .. 12 of axis 1: a box of fluid two cells inside of 12 is expected; balance = no leaves it out"
watch "coefficient without length" "[force a] box = -30 um .. 90 um, -40 um .. 40 um   reference_speed = 1 m/s" \
    "found no 'reference_length' in [force a], expected reference_length = a length [m]"
watch "transfer without surface" "[transfer a] reference_length = 1 mm" \
    "found no 'surface' in [transfer a], expected surface = a concentration [mol/m3]"
watch "bulk without axis" "[transfer a] reference_length = 1 mm   surface = Csat   fluid = bulk" \
    "fluid: found 'bulk' without the axis of the stream, expected along = x or y"
watch "medium without diffusivity" "[shape b] ball = 0, 0   radius = 5 um   kind = medium" \
    "found no 'D' in [shape b], expected D = a diffusivity [m2/s]"
watch "wall of negative concentration" "[shape b] ball = 0, 50 um   radius = 5 um   kind = wall   C = -1 mol/m3" \
    "C: found -1 mol/m3, expected at least 0"
watch "watching without name" "[total] box = 0 .. 1 um, 0 .. 1 um" "total: expected a short name: [total NAME]"
watch "misspelt key of a line" "[line a] form = 0, 0   to = 50 um, 0   points = 5" \
    "found the unknown key 'form' in [line a], expected one of from, to, points, spacing, fields, images: did you \
mean 'from'?"
spoil "probe in the wall" \
    's/at = 100 um, 0/at = 100 um, 0\n[shape lid] box = 90 um .. 120 um, -60 um .. 60 um   kind = wall/' \
    "bad.scene:10: probe: 'a' stands in the wall, 10 um behind its surface, expected a place in the fluid or metal, or \
on a surface: move it by that much"
# ---- bodies in motion ----

# glass NAME SED MESSAGE: one edit of a plate that moves.
glass() {
    sed "$2" > bad.scene << 'END'
[grid]      h = 1 mm   box = 0 .. 40 mm, 0 .. 20 mm
[shape plt] box = 0 .. 40 mm, 0 .. 20 mm   kind = solid
[side y+]   traction = 0 Pa, 1 MPa
[solid]     model = bond_based   E = 72 GPa   fracture_energy = 100 J/m2   dynamics = yes   density = 2 g/cm3
[crack a]     points = 0 mm, 10 mm, 20 mm, 10 mm
[run]       until = 10 us
[output]    every = 10 us   fields = u
END
    rejects "$1" "bad.scene:$3"
}

glass "motion without density" 's/density = 2 g.cm3//' \
    "4: found no 'density' in [solid], expected density = a density [kg/m3]"
glass "motion without end" 's/until = 10 us//' "6: found no 'until' in [run], expected until = a time [s]"
glass "stretch of springs" 's/fracture_energy = 100 J.m2/critical_stretch = 0.01/' \
    "4: critical_stretch: found with model = bond_based, expected another one of both: $breaks"
glass "small strains that break in motion" \
    's/bond_based/correspondence   nu = 0.3/;s/fracture_energy = 100 J.m2/critical_stretch = 0.01/' \
    "4: critical_stretch: found with dynamics = yes, expected another one of both: $breaks"
glass "J of springs" 's/10 mm$/10 mm   contour_radii = 3 mm, 6 mm, 9 mm/' \
    "5: contour_radii: found with model = bond_based, expected small strains in balance: J is theirs"
glass "stress of springs" 's/fields = u/fields = u, mises/' \
    "7: fields: found 'mises', which needs a [solid] section whose model is not bond_based"

# ---- bond-based corrosion ----

pit() {
    cat << 'END'
[grid]      h = 2 um   m = 3   box = 0 .. 40 um, 0 .. 40 um
[shape met] box = 0 .. 40 um, 0 .. 20 um   kind = solid   material = steel304
[side y+]   flow = open
[corrode]   rate = 1 um/s   Csat = 5 mol/L   D = 1e-9 m2/s
[run]       until = 1 s
END
}

# pits NAME SED MESSAGE: one edit of the pit.
pits() {
    pit | sed "$2" > bad.scene
    rejects "$1" "bad.scene:$3"
}

pits "corrode beside dissolve" 's/\[run/[dissolve] rate = 1 um\/s\n[run/' \
    "4: corrode: found beside [dissolve], expected one of them: each says how the metal goes"
pits "D beside transport" 's/\[run/[transport] D = 1e-9 m2\/s\n[run/' \
    "4: D: found beside a [transport] section, expected it there"
water='s/flow = open/flow = noslip/;s/\[run/[flow] rho = 1 g\/cm3   mu = 1 mPa s\n[run/'
pits "activation in a stream" "s/D =/control = activation   D =/;$water" \
    "4: control: found 'activation' beside [flow], expected diffusion: with activation all fluid holds bulk"
pits "printed weights in a stream" "s/D =/kernel = square   weights = published   D =/;$water" \
    "4: weights: found 'published' beside [flow], expected calibrated: no flow is exact with others"
pits "corrode without rate" 's/rate = 1 um\/s//' "4: found no 'rate' in [corrode], expected rate = a speed [m/s]"
pits "rate and current" 's/rate =/current = 1 A\/m2   rate =/' \
    "4: current: found beside 'rate', expected one of them"
pits "current of a speed" 's/rate =/current =/' \
    "4: column 23: found a speed [m/s], expected a current density [A/m2]"
pits "Csat above Cs" 's/5 mol\/L/200 mol\/L/' \
    "4: Csat: found 200 kmol/m3, expected a value above 0 mol/m3 and at most 142.805 kmol/m3"
pits "no D" 's/D = 1e-9 m2\/s//' "4: found no 'D' in [corrode], expected D = a diffusivity [m2/s]"
pits "negative bulk" 's/D =/bulk = -1 mol\/m3   D =/' \
    "4: bulk: found -1 mol/m3, expected a value from 0 mol/m3 to 5 kmol/m3"
pits "charge of none" 's/D =/charge = 0   D =/' "4: charge: found 0, expected a value above 0 and at most 10"
pits "unknown control" 's/D =/control = mixed   D =/' \
    "4: column 56: found 'mixed', expected one of diffusion, activation"
pits "unknown drive" 's/D =/driving_force = none   D =/' \
    "4: column 62: found 'none', expected one of constant, difference"
pits "unknown kernel" 's/D =/kernel = cube   D =/' "4: column 55: found 'cube', expected one of area, square, inverse"
pits "unknown weights" 's/D =/weights = own   D =/' \
    "4: column 56: found 'own', expected one of calibrated, published"
pits "fraction of nothing" 's/until =/fraction = 0   until =/' \
    "5: max_dissolved_fraction: found 0, expected a value above 0 and at most 1"
pits "unknown breaking" 's/D =/breaking = random   D =/' \
    "4: column 57: found 'random', expected one of deterministic, stochastic"
pits "seed of nothing" 's/D =/seed = 2   D =/' "4: seed: found without breaking = stochastic, expected both"
pits "seed below zero" 's/D =/breaking = stochastic   seed = -1   D =/' \
    "4: column 77: found -1, expected a whole number from 0 to 2147483647"
pits "inlet without flow" 's/flow = open/flow = inlet/' \
    "3: flow: found 'inlet' without a [flow] section, expected C = ... alone to hold a concentration"
pits "held side that is open" 's/flow = open/flow = open   C = 0/' \
    "3: C: found beside flow = open, expected bulk in [corrode], or C without open"
pits "printed area weights" 's/D =/weights = published   D =/' \
    "4: front: this kernel has no coefficient of the continuum in 2D"

# ---- gas ----

tube() {
    cat << 'END'
[grid]      h = 10 mm   m = 2   box = 0 .. 400 mm, 0 .. 100 mm
[side x-]   flow = inlet
[gas]       rho = if(x < 0.2 m, 1 kg/m3, 0.5 kg/m3)   p = 1 Pa   vx = 0.1 m/s
[run]       until = 0.1 s
END
}

# gases NAME SED MESSAGE: one edit of the tube.
gases() {
    tube | sed "$2" > bad.scene
    rejects "$1" "bad.scene:$3"
}

for beside in "flow] rho = 1 g/cm3" "transport] D = 1e-9 m2/s" "dissolve] rate = 1 um/s" "corrode] rate = 1 um/s"; do
    gases "gas beside ${beside%%]*}" "s|\[run|[$beside\\n[run|" \
        "3: gas: found beside [${beside%%]*}], expected [gas] alone: an inviscid gas carries nothing \
and attacks nothing"
done
gases "axisymmetric gas" 's/m = 2/m = 2   geometry = axisymmetric/' \
    "3: gas: found in a box with geometry = axisymmetric, expected planar"
gases "no pressure" 's/p = 1 Pa//' "3: found no 'p' in [gas], expected p = a pressure [Pa]"
gases "no density" 's/rho = .*m3)//' "3: found no 'rho' in [gas], expected rho = a density [kg/m3]"
gases "no end of a gas" 's/until = 0.1 s//' "4: found no 'until' in [run], expected until = a time [s]"
gases "pressure of nothing" 's/p = 1 Pa/p = 0 Pa/' "3: p: found 0 Pa, expected a positive value"
gases "a gas of one degree less" 's/p = 1 Pa/p = 1 Pa   gamma = 1/' \
    "3: gamma: found 1, expected a value above 1 and at most 10"
gases "too long steps" 's/p = 1 Pa/p = 1 Pa   cfl = 1.5/' "3: cfl: found 1.5, expected a value above 0 and at most 1"
gases "third order" 's/p = 1 Pa/p = 1 Pa   order = third/' "3: column 74: found 'third', expected one of second, first"
gases "rough wall of a gas" 's/flow = inlet/flow = noslip/' \
    "2: column 20: found 'noslip', expected one of slip, inlet, outlet, periodic, mirror: did you mean 'slip'?"
gases "profile of a gas" 's/flow = inlet/flow = inlet   profile = uniform/' \
    "2: found the unknown key 'profile' in [side x-], expected one of flow"
gases "vacuum somewhere" 's/0.5 kg/0 kg/' "3: gas: the initial state at (0.205, ...) m has rho = 0 kg/m3, v = \
(0.1, ...) m/s and p = 1 Pa: density and pressure must be positive and finite"
gases "concentration of a gas" 's/until = 0.1 s/until = 0.1 s\n[output] fields = C/' \
    "5: fields: found 'C', which needs a [transport] or [corrode] section"
gases "plane in a gas" 's/\[run/[plane a] at = x 0.2 m\n[run/' \
    "4: plane: found beside [gas], expected [line] or [total]"

# ---- tables ----

# tables NAME TABLE SECTION MESSAGE: the pit with one more section on line 6 and its file.
tables() {
    { pit; echo "$3"; } > bad.scene
    printf "$2" > law.csv
    rejects "$1" "bad.scene:6: $4"
}
law='[table f] file = law.csv   x = C in mol/L   y = i in A/m2'
tables "no file of a table" 'C,i\n' '[table f] file = lwa.csv   x = C   y = i' \
    "file: file: cannot open 'lwa.csv': No such file or directory"
tables "no such column" 'C,j\n0,1\n1,2\n' "$law" "y: found 'i', expected a column of law.csv: C, j"
tables "no such unit" 'C,i\n0,1\n1,2\n' '[table f] file = law.csv   x = C in mool   y = i' \
    "x: found 'mool', expected a unit such as mol/L behind 'in'"
tables "table that goes back" '# i(C)\nC,i\n0,1\n2,3\n1,2\n' "$law" \
    "file: law.csv:5: found x = 1, y = 2 behind x = 2, y = 3, expected ascending values"
tables "point twice" 'C,i\n0,1\n0,2\n' "$law" \
    "file: law.csv:3: found x = 0, y = 2 behind x = 0, y = 1, expected ascending values"
tables "no number" 'C,i\n0,1\n1,two\n' "$law" "y: csv: law.csv:3: column 'i': 'two' is not a number"
tables "infinite value" 'C,i\n0,inf\n1,2\n' "$law" "file: law.csv:2: found x = 0, y = inf, expected finite values"
tables "one point" 'C,i\n0,1\n' "$law" "file: curve: found 1 point, expected at least 2"
tables "fields missing" 'C,i\n0,1\n1\n' "$law" "file: csv: law.csv:3: 1 fields, expected 2 as in the line of names"
tables "name of a function" 'C,i\n0,1\n1,2\n' '[table log] file = law.csv   x = C   y = i' \
    "table: found the name 'log', expected one that expressions do not have"
tables "unknown outside" 'C,i\n0,1\n1,2\n' "$law   outside = zero" \
    "column 71: found 'zero', expected one of hold, error"
printf 'C,i\n0,1\n1,2\n' > law.csv
{ pit | sed 's|rate = 1 um/s|current = f(1 s)|'; echo "$law"; } > bad.scene
rejects "argument of another dimension" \
    "bad.scene:4: column 25: found a time [s], expected a concentration [mol/m3] as the argument of f"

base > bad.scene
rejects "bad override" \
    "command line: h: column 8: found a number without unit, expected a length [m]: write its unit, for example \
nm, um, mm, m, km" grid.h=10
rejects "one bad override of two" \
    "command line: threads: column 14: found 3000, expected a whole number from 0 to 1024" \
    grid.h="10 um" grid.threads=3000
rejects "unknown override" \
    "command line: found the key 'nothing', which no section of bad.scene has, expected section.key" nothing=1
rejects "an override of a key that no section has" "command line: found the key 'every', which no section of \
bad.scene has, expected section.key: output.every" every=1min
rejects "an override without a value" "command line: found nothing after 'until=', expected a value: a key of the \
scene is not taken back here, but in its text" run.until=
rejects "unknown label" \
    "command line: found the section [side y], expected one of bad.scene (its labels: x-, x+)" side.y.C=1
base > bad.scene
for time in 10 "10 m" "-1 s" s "" never; do
    rejects "checkpoint '$time'" \
        "--checkpoint expects a time such as 10min or 0 s, or off; see pd2d --help" --checkpoint "$time"
done
rejects "check and resume" "file: cannot open 'out/checkpoint.bin': No such file or directory" --quiet --check --resume
rejects "nothing to resume" "file: cannot open 'out/checkpoint.bin': No such file or directory" --quiet --resume
printf 'dx = 5e-6\nR_wir = 40e-6\n' > bad.scene
rejects "flat: unknown key" \
    "bad.scene:2: found the unknown key 'R_wir' in the file, expected one of dx, m_ratio, R_wire, L_wire, \
R_tube, L_upstream, L_downstream, rho_f, mu_f, Q_flow, rho_m, D_liquid, C_solid_init, C_liquid_init, \
C_thresh, grain_size_mean, grain_size_std, gb_width_cells, k_corr, gb_corr_factor, flow_conv_tol, \
T_final ...: did you mean 'R_wire'?"
printf 'dx = 7e-6\n' > bad.scene
rejects "flat: fractional cells" "bad.scene:1: dx: 2 R_tube are 42.8571 cells, expected a whole number of them"
printf 'dx = abc\n' > bad.scene
rejects "flat: not a number" \
    "bad.scene:1: column 6: found 'abc', expected a known variable, constant or function: did you mean 'abs'?"
printf 'R_wire = 200e-6\n' > bad.scene
rejects "flat: pin wider than tube" "bad.scene:1: R_wire: found 0.0002, expected less than R_tube = 0.00015"
printf 'C_thresh = 1.5\n' > bad.scene
rejects "flat: out of range" "bad.scene:1: C_thresh: found 1.5, expected a value from 0 to 0.99"
printf '\000\001\002' > bad.scene
rejects "not text" "bad.scene:1: found byte 0x00, expected text"
: > bad.scene
rejects "empty" "bad.scene:1: scene: found an empty file, expected sections or lines key = value"
rm -f bad.scene
rejects "missing" "file: cannot open 'bad.scene': No such file or directory"

# ---- pipes, devices and folders in the place of files: nothing waits for them, nothing reads them without an end
mkfifo pipe
mkdir folder
for at in pipe folder /dev/zero; do
    case $at in
    pipe) why="it is a pipe or a socket, expected a file" ;;
    folder) why="Is a directory" ;;
    *) why="it is a device, expected a file" ;;
    esac
    why="file: cannot open '$at': $why"
    rm -f bad.scene
    ln -s "$at" bad.scene
    rejects "a scene: $at" "$(echo "$why" | sed "s|'$at'|'bad.scene'|")"
    rm bad.scene
    plain() {
        base > bad.scene
        echo "$2" >> bad.scene
        rejects "$1: $at" "bad.scene:11: $3$why"
    }
    plain "a mask" "[shape b] mask = $at   corner = 0 um, 0 um   cell = 1 um   kind = wall" "mask: "
    plain "voxels" "[shape b] raw = $at   size = 9, 9   corner = 0 um, 0 um   cell = 1 um   kind = wall" "raw: "
    plain "a table" "[table f] file = $at   x = C   y = i" "file: "
    plain "measured points" "[measured a] file = $at   time = t in h   value = loss in %   of = volume_loss" "file: "
    plain "species" "[chemistry] include = $at" "include: "
done
rmdir folder

# ---- what is not known is left out of the lines of results, whatever the scene is called
cat > nan.scene << 'END'
[grid]      h = 1 um   box = 0 um .. 16 um, 0 um .. 16 um
[shape s]   box = 0 um .. 16 um, 0 um .. 16 um   kind = solid   material = copper
[transport] D = 1e-9 m2/s
[dissolve]  rate = 0 m/s
[run]       until = 1 s
[output]    fields = none
[total inf] box = 0 um .. 16 um, 0 um .. 8 um
END
"$programs/pd2d" nan.scene --out out --quiet > stdout 2> stderr
[ $? = 0 ] && grep -q '^result case=nan total=inf time=1 volume=0 dissolved=0 solid=' stdout &&
    ! grep -q '=-*nan [a-z_]*=[a-z]*$\|C_m[a-z]*=' stdout
said=$?
cat stdout stderr > log
verdict "a result without its unknown figures" $said
rm -rf out

# ---- limits and places
for folder in /etc ../x a/../../x C:x; do
    base | sed "s|C, v\$|C, v   folder = $folder|" > bad.scene
    rejects "folder $folder" \
        "bad.scene:9: folder: found '$folder', expected a folder below the current one, without '..': \
only who starts the run may choose another"
done
base > bad.scene
for size in 2XB -1GB 0 1e99TB; do
    rejects "memory limit $size" \
        "--memory-limit expects a size such as 2GB, 1.5 GiB or 500 MB; see pd2d --help" \
        --memory-limit "$size"
done
# A run that needs more than the limit ends with 1 before it has written anything.
rm -rf out
"$programs/pd2d" bad.scene --out out --memory-limit 300kB > stdout 2> stderr
[ $? = 1 ] && [ ! -s stdout ] && [ ! -e out ] && [ "$(wc -l < stderr)" = 1 ] &&
    grep -q '^pd2d: memory: the run needs about [0-9.]* MB, the limit is 0.3 MB$' stderr
said=$?
cat stdout stderr > log
verdict "memory limit" $said
# So does one whose files do not fit: what is read counts.
head -c 400000 /dev/zero > large.raw
echo "[shape b] raw = large.raw   size = 500, 800   corner = 0 um, 0 um   cell = 1 um   kind = wall" >> bad.scene
rm -rf out
"$programs/pd2d" bad.scene --out out --memory-limit 300kB > stdout 2> stderr
[ $? = 1 ] && [ ! -s stdout ] && [ ! -e out ] &&
    grep -q '^pd2d: bad.scene:11: raw: file: needs 0.4 MB more, [0-9.]* MB are in use, the limit is 0.3 MB$' stderr
said=$?
cat stdout stderr > log
verdict "memory limit, of a file" $said

score
