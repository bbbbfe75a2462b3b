# Cells of 10 mm / n; mol/kgw stands for mol/L, constants are those of the other file, activities those of Davies. The
# argument is n, or n:steps of implicit diffusion, species by species, each with the same diffusivity.
n=${1%:*} steps=20 how=
if [ "$n" != "$1" ]; then
    steps=${1#*:}
    how="    -multi_d true 1e-9 1 0 1
    -implicit true 1 -12"
fi
data=$(dirname "$(command -v phreeqc)")/../share/phreeqc/phreeqc.dat
cat > column.phr << EOF
DATABASE $data
SOLUTION_SPECIES
H+ = H+
    log_k 0
    -dw 1e-9
Mg+2 = Mg+2
    log_k 0
    -dw 1e-9
Cl- = Cl-
    log_k 0
    -dw 1e-9
H2O = OH- + H+
    -analytic -14 0 0 0 0 0
    -dw 1e-9
Mg+2 + H2O = MgOH+ + H+
    -analytic -11.44 0 0 0 0 0
    -dw 1e-9
PHASES
Brucite
    Mg(OH)2 + 2 H+ = Mg+2 + 2 H2O
    -analytic 16.84 0 0 0 0 0
SOLUTION 0
    units mol/kgw
    pH    2 charge
    Cl    0.01
SOLUTION 1-$n
    units mol/kgw
    pH    7 charge
    Mg    0.005
    Cl    0.01
EQUILIBRIUM_PHASES 1-$n
    Brucite 0 0.01
TRANSPORT
    -cells $n
    -lengths $(awk "BEGIN { print 0.01 / $n }")
    -shifts $steps
    -time_step $(awk "BEGIN { print 72000 / $steps }")
    -flow_direction diffusion_only
    -boundary_conditions constant closed
    -diffusion_coefficient 1e-9
$how
    -print_cells 0
    -punch_frequency $steps
SELECTED_OUTPUT
    -file table
    -high_precision true
    -reset false
    -distance true
    -totals Mg
    -equilibrium_phases Brucite
    -time true
END
EOF
phreeqc column.phr column.out < /dev/null > log || { tail -c 500 log; exit 1; }
# Brucite of all cells; magnesium half-way between the two cells at 4 mm.
awk -v n="$n" '$2 == 72000 { left += $4 * 1e3 * 0.01 / n; if (($1 - 4e-3)^2 < (0.006 / n)^2) mg += 500 * $3 }
    END { printf "peer left=%.10g magnesium=%.10g\n", left, mg }' table
