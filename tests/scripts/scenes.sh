#!/bin/sh
# slow: yes
# The validation scenes run, and their tables show what closed forms, series and published figures say. Where the
# validate programs have the same case, the figures are the same.
. tests/lib/script.sh

# run NAME SCENE [key=value ...]: a scene, with overrides, under a name of its own.
run() {
    name=$1 scene=$2
    shift 2
    file=examples/scenes/validation/$scene.scene
    [ -f "$file" ] || file=examples/scenes/$scene.scene
    kind=${scene##*_}
    [ "$kind" = axi ] && kind=2d
    "$programs/pd$kind" "$file" "$@" --out "$dir/$name" > "$dir/$name.log" 2>&1 ||
        cat "$dir/$name.log"
}

# need NAME: runs the scene of that name, once.
need() { [ -d "$dir/$1" ] || run "$1" "$1"; }

# near NAME WHAT FOUND VALUE TOLERANCE: FOUND is VALUE, up to TOLERANCE times VALUE.
near() {
    awk -v f="$3" -v v="$4" -v t="$5" 'BEGIN { e = f / v - 1; exit !(f != "" && e <= t && e >= -t) }'
    verdict "$1: $2 is '$3', expected $4 within $5"
}

# shows NAME FILE KEY COLUMN VALUE TOLERANCE: the row of FILE that starts with KEY (end: the last one) has VALUE in
# COLUMN, up to TOLERANCE times VALUE.
shows() {
    need "$1"
    found=$(awk -F, -v key="$3" -v column="$4" '
        NR == 1 { for (k = 1; k <= NF; k++) if ($k == column || index($k, column " [") == 1) at = k; next }
        $1 == key || key == "end" { value = $at }
        END { print value }' "$dir/$1/$2")
    near "$1" "$4 at $3" "$found" "$5" "$6"
}

# reports NAME KEY LEAST MOST: `key=value` of the result lines, the last one of that key.
reports() {
    need "$1"
    found=$(awk -v key="$2=" '/^result/ { for (k = 1; k <= NF; k++) if (index($k, key) == 1) value = substr($k,
        length(key) + 1) } END { print value }' "$dir/$1.log")
    awk -v f="$found" -v l="$3" -v m="$4" 'BEGIN { exit !(f != "" && f + 0 >= l && f + 0 <= m) }'
    verdict "$1: $2 is '$found', expected $3 to $4"
}

# follows NAME FILE COLUMN FUNCTION TOLERANCE: COLUMN of the profile differs from FUNCTION of x by TOLERANCE at most.
follows() {
    need "$1"
    found=$(awk -F, -v column="$3" '
        NR == 1 { for (k = 1; k <= NF; k++) { if ($k == column) at = k; if ($k == "x [m]") place = k }; next }
        { x = $place; e = $at - ('"$4"'); if (e < 0) e = -e; if (e > most || most == "") most = e }
        END { print most }' "$dir/$1/$2")
    awk -v f="$found" -v t="$5" 'BEGIN { exit !(f != "" && f <= t) }'
    verdict "$1: $3 differs by '$found', expected at most $5"
}

# centred NAME FILE PLACE TOLERANCE: the centre of mass of C along the line.
centred() {
    need "$1"
    found=$(awk -F, 'NR > 1 { s += $3; m += $2 * $3 } END { print m / s }' "$dir/$1/$2")
    awk -v f="$found" -v p="$3" -v t="$4" 'BEGIN { exit !(f - p <= t && p - f <= t) }'
    verdict "$1: the centre of mass lies at '$found', expected $3 within $4"
}

# ---- gas ----

# Sod's tube: the exact solution between rarefaction and contact, and between contact and shock
shows shock_tube_1d probes.csv 0.2 rarefied_density 0.42632 1e-3
shows shock_tube_1d probes.csv 0.2 rarefied_p 0.30313 1e-3
shows shock_tube_1d probes.csv 0.2 rarefied_vx 0.92745 1e-3
shows shock_tube_1d probes.csv 0.2 rarefied_energy 0.941177 1e-3
shows shock_tube_1d probes.csv 0.2 shocked_density 0.26557 2e-3
shows shock_tube_1d probes.csv 0.2 shocked_p 0.30313 1e-3
shows shock_tube_1d probes.csv 0.2 shocked_vx 0.92745 1e-3
reports shock_tube_1d ledger 0 1e-14

# ---- flow ----

# u on the axis: the mean over a cell of a parabola seen from its centres
shows poiseuille_2d probes.csv 0 axis_vx 1.5 5e-4
shows poiseuille_2d probes.csv 0 axis_p 0.12 1e-6
shows hagen_3d probes.csv 0 axis_p 0.8 1e-6
shows startup_2d probes.csv 0.2 centre_vx 0.185193 1e-4
shows startup_2d probes.csv 0.8 centre_vx 0.428330 1e-4
shows couette_2d probes.csv 0.05 a_vx 0.113844 1e-3
shows couette_2d probes.csv 0.2 a_vx 0.411566 2e-4
shows annulus_2d probes.csv 0 a_vx 1.537394 1e-4
shows annulus_2d probes.csv 0 b_p 1.731608 3e-4
shows cavity_2d probes.csv 0 centre_vx -0.20915 3e-3
shows taylor_green_2d probes.csv 1 a_vx 0.454041 1e-3
# kinetic energy: 1/4 exp(-16 pi^2 nu t) of both
shows taylor_green_2d total_all.csv 1 "energy [J/m]" 0.0515383 1e-3
shows isotropy_2d total_all.csv 0.6 "energy [J/m]" 0.0969285 3e-3
# the series at 5 s: between the walls from u = 1 on towards 3/2 y (2 - y)
run channel channel3d_3d "h=0.1 m" "box=0 .. 0.4 m, 0 .. 2 m, 0 .. 0.4 m" "at=0.2 m, 1 m, 0.2 m" "slice=z 0.2 m" \
    "until=5 s" "every=5 s"
shows channel probes.csv 5 centre_vx 1.245925 1.5e-3
# Schaefer and Turek: drag in two ways, lift, pressure drop
shows cylinder_2d force_c.csv 0 "cx [-]" 5.57953523 4e-3
shows cylinder_2d force_c.csv 0 "cx_balance [-]" 5.57953523 2e-3
near cylinder_2d "pressure drop" "$(awk -F, 'END { print $2 - $3 }' "$dir/cylinder_2d/probes.csv")" 0.11752017 2e-2
reports cylinder_2d cy 0.009 0.012
reports cylinder_2d cy_balance 0.009 0.012
shows flux_2d plane_up.csv 0 "flow [m2/s]" 7.08e-5 1e-3
for plane in beside down; do
    shows flux_2d plane_$plane.csv 0 "flow [m2/s]" "$(awk -F, 'NR == 2 { print $3 }' "$dir/flux_2d/plane_up.csv")" 1e-6
done

# ---- transport ----

shows slab_2d probes.csv 0.1 a_C 0.525513 1e-3
follows gauss_1d line_a_000002_t1.0s.csv "C [mol/m3]" "sqrt(0.5) * exp(-x * x / 4)" 2e-4
follows gauss_2d line_a_000002_t1.0s.csv "C [mol/m3]" "0.5 * exp(-(x * x + 1 / 144) / 4)" 1.5e-3
follows gauss_3d line_a_000002_t1.0s.csv "C [mol/m3]" "sqrt(0.125) * exp(-(x * x + 2 / 36) / 4)" 6e-3
for kind in "1d [mol/m2] 2.506628" "2d [mol/m] 6.283185" "3d [mol] 1.968701"; do
    set -- $kind
    shows gauss_$1 total_all.csv 1 "dissolved $2" "$3" 1e-6
done
follows layers_1d line_a_000000_t0.0s.csv "C [mol/m3]" "x > 1e-4 / 3 ? (x - 1e-4 / 3) / (2e-4 / 3) : 0" 1e-8
shows layers_1d transfer_right.csv 0 "flux [mol/m2/s]" 1.5e-5 1e-7
follows layers_2d line_a_000001_t3.832549s.csv "C [mol/m3]" \
    "exp(-1) * (x < 1e-4 / 3 ? 1 : sin(1.615311 * (1 - x / 1e-4)) / sin(1.615311 * 2 / 3))" 4e-4
for peclet in 0.5 5 50 5e5; do
    run advection_$peclet advection_1d "D=$(awk -v p=$peclet 'BEGIN { print 0.01 / p }') m2/s"
    centred advection_$peclet line_a_000001_t0.16s.csv 0.56 1e-4
    reports advection_$peclet C_min -1e-9 1e-3
    reports advection_$peclet C_max 0.5 1.000000001
done
# round walls that hold: ln(R/r)/ln(R/a), 2/ln(R/a); 4 pi D/(1/a - 1/R)/8
follows shells_2d line_a_000000_t0.0s.csv "C [mol/m3]" "-log(x) / log(2.5)" 6e-4
shows shells_2d transfer_core.csv 0 "Sh [-]" 2.182713 1e-3
shows shells_2d transfer_core.csv 0 "area [m]" 2.513274 1e-3
reports shells_2d flux -1e-8 1e-8
shows shells_3d transfer_core.csv 0 "flux [mol/s]" 1.047198 4e-3
# a cylinder in a wide cross flow: cylinder_crossflow_sherwood_re20.csv, good to 1 %; the box adds 1.5 %
shows cylinder_mass_2d transfer_c.csv 0 "Sh [-]" 2.7341 2e-2
# next to nothing upstream, whose rounding upwinds no node
for m in 2 3; do
    run wide_$m cylinder_mass_2d "grid.m=$m" "h=1 mm / 13"
    shows wide_$m transfer_c.csv 0 "Sh [-]" 2.7341 2e-2
    reports wide_$m defect 0 1e-9
done
# a layer that no lattice of this spacing holds is told, and no other one
run thin cylinder_mass_2d "D=1e-9 m2/s"
layer="note: transfer c: the layer at its surface is [-+.e0-9]* m thick, and cells are 0.000125 m"
grep -q "^$layer: its flux wants at least 2 cells across$" "$dir/thin.log" &&
    ! grep -q "^note: transfer" "$dir/cylinder_mass_2d.log"
verdict "thin: expected a note on the layer, found $(grep note "$dir/thin.log")" $?
# local Sherwood numbers at 0.01 and 0.0147 Dh^2 U/D
shows graetz_2d transfer_wall_000000_t0.0s.csv 40.050000000000004 "Sh [-]" 7.74050 2e-2
shows graetz_2d transfer_wall_000000_t0.0s.csv 58.75 "Sh [-]" 7.58700 2e-2

# smith_hutton_published.csv, with 24 in place of 40 cells; the field stays within its bounds
run smith smith_hutton_2d "h=1 m / 24"
shows smith line_outlet_000000_t0.0s.csv 0 "C [mol/m3]" 2 1e-3
shows smith line_outlet_000000_t0.0s.csv 0.4 "C [mol/m3]" 1 3e-2
reports smith C_max 1.99 2.000000001
reports smith C_min -1e-9 1e-3

# ---- dissolution ----

# sqrt(depth^2 + gap^2) - gap, the mouth lying a gap of 0.5 um in front of the metal
shows pencil_304_1d diagnostics.csv 10 volume_loss 0.24427 1e-2
shows pencil_304_1d diagnostics.csv 100 volume_loss 0.78311 5e-3
# depth less 8 um, over the metal at the start
shows pencil_304_2d diagnostics.csv 8.9696 volume_loss 0.192293 4e-2
shows pencil_304_2d diagnostics.csv 98.9696 volume_loss 0.804655 1.5e-2
shows pencil_304_3d diagnostics.csv 8.9696 volume_loss 0.528806 6e-2
shows rate_1d diagnostics.csv 1262304 volume_loss 0.3636363636 1e-9
shows rate_2d diagnostics.csv 1262304 volume_loss 0.5765 1.5e-2
for key in pencil_304_1d pencil_304_2d pencil_304_3d rate_2d ledger_2d; do reports $key ledger 0 1e-12; done
shows ledger_2d plane_down.csv end "species [mol/m/s]" \
    "$(need ledger_2d; awk -F, 'END { print $2 }' "$dir/ledger_2d/transfer_pin.csv")" 1e-6

# ---- bond-based corrosion ----

# at 10 s of the closed form, 24.92 um: (depth - 7.881 um)/149.739 um, within 1 % of the depth, which is 1.47 % of it
run pencil_304_bonds_1d pencil_304_bonds_1d "until=9 s"
shows pencil_304_bonds_1d diagnostics.csv 9 volume_loss 0.113803 1.47e-2
# twice the spacing, at most twice the distance from the closed form
run pencil_coarse_1d pencil_304_bonds_1d "until=9 s" "h=7.881 um / 16"
shows pencil_coarse_1d diagnostics.csv 9 volume_loss 0.113803 2.94e-2
# a cube whose faces recede at the speed of the current; its edges lose more
run uniform_cu_3d uniform_cu_3d "until=25 s"
shows uniform_cu_3d diagnostics.csv 25 volume_loss 0.277018 1.5e-2
# a salt layer does not pass Csat, and what the solution of the pit holds is near to it
run pit_304_2d pit_304_2d "until=10 s"
reports pit_304_2d C_max 5.0e3 5.10001e3
reports pit_304_2d front 5e-6 9e-6
# without its cover the solution dilutes, and the pit passivates
run pit_open_2d pit_304_2d "until=10 s" "shape.hole.box=-50 um .. 50 um, 0 .. 4 um"
reports pit_open_2d front 0 1e-6
run intergranular_2d intergranular_2d "until=1 h"
run pits_304_3d pits_304_3d "until=1 s"
# a trench in a crevice: 0.0479 by the equation of the gap, of first order in the horizon (0.0458 with half the cells)
run crevice_625_2d crevice_625_2d "h=50 um, 2 um"
reports crevice_625_2d volume_loss 0.039 0.0479
reports crevice_625_2d front 8e-6 14e-6
shows crevice_625_2d diagnostics.csv end C_max 5600 1e-7
# what half a millimetre gives diffuses away, and the attack goes out
run crevice_short_2d crevice_625_2d "h=50 um, 2 um" "corrode.initial=if(x > 12.2 mm, 0.99*Csat, 0)"
reports crevice_short_2d volume_loss 0 1e-3
# around an axis: L^2/2 + b L = 2 l^2 D t with b = pi a/4 - a^2/(2 R) for the mouth, a = 50 um, in a vessel of
# R = 120 um, is 38.7 um after a minute; metal enters the fluid within the horizon of 12 um, half of which is left
# for it
run pencil_304_axi pencil_304_axi "until=1 min"
reports pencil_304_axi volume_loss 0.3225 0.3725
shows pencil_304_axi diagnostics.csv end C_max 5100 1e-6
# in a stream: no faster than bare steel, 1.65 um/s, which leaves (1 - 8.25 um/50 um)^2 of the pin after 5 s
run pin_304_stream_2d pin_304_stream_2d "until=5 s"
reports pin_304_stream_2d volume_loss 0.25 0.303
shows pin_304_stream_2d diagnostics.csv end C_max 5100 1e-6
for key in pencil_304_bonds_1d uniform_cu_3d pit_304_2d intergranular_2d pits_304_3d crevice_625_2d pencil_304_axi \
    pin_304_stream_2d; do
    reports $key ledger 0 1e-12
done
# the grains alone recede by 0.5 um of 70 um, with their boundaries by a third more at least
reports intergranular_2d volume_loss 0.0095 0.03
score
