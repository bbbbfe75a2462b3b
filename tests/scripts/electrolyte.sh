#!/bin/sh
# The equilibrium of electrolytes by pd1d, pd2d, pd3d: figures, tables, refusals; each in one message.
. tests/lib/script.sh
fluids=$root/examples/electrolytes
cd "$dir" || exit 1

# value KEY FILE: of its line of results.
value() { sed -n "s/^result .* $1=\([^ ]*\).*/\1/p" "$2"; }
near() { awk -v a="$1" -v b="$2" -v most="$3" 'BEGIN { exit !(a != "" && a - b < most && b - a < most) }'; }

for dim in 1 2 3; do
    "$programs/pd${dim}d" "$fluids/hbss.electrolyte" --speciate > "hbss$dim" 2> log
    verdict "HBSS in ${dim}D"
done
check "the same in every dimension" sh -c 'cmp hbss1 hbss2 && cmp hbss2 hbss3'
check "HBSS has the pH that is asked for" near "$(value pH hbss2)" 7.4 1e-6
check "its elements" near "$(value err_elements hbss2)" 0 1e-12
check "its charge" near "$(value charge hbss2)" 0 1e-10
check "hydroxyapatite above its saturation" [ "$(value supersaturated hbss2)" = 1 ]
"$programs/pd2d" "$fluids/hbss.electrolyte" --speciate --quiet > quiet 2> log
check "--quiet: the result alone" [ "$(wc -l < quiet)" = 1 ]
check "nothing is written" [ ! -e output ]

# HCl for 50 mM of Tris: about 45 mM in the recipe, for 36.5 C
"$programs/pd2d" "$fluids/sbf.electrolyte" --speciate > sbf 2> log
check "SBF: the acid for its buffer" near "$(sed -n 's/^note: +\(.*\) mM H+ for.*/\1/p' sbf)" 45 3

# Mg(OH)2 that is there: PHREEQC's wateq4f, docs/validation.md
"$programs/pd2d" "$fluids/brucite.electrolyte" --speciate "species.Mg(OH)2(s).initial=10 mM" > brucite 2> log
check "brucite" near "$(value pH brucite)" 10.396 0.02

# acid that enters: its pH is said where it is another one; -log10 of 1 mM is 3, but for activities
"$programs/pd2d" "$fluids/saline.electrolyte" --speciate chemistry.activity=ideal species.H+.inlet="1 mM" \
    species.Cl-.inlet="1 mM" species.Na+.inlet="0 mM" > acid 2> log
check "the pH of the start beside it" near "$(sed -n 's/^pH  *//p' acid)" 7 1e-4
check "the pH of the inlet" near "$(sed -n 's/^pH of the inlet *//p' acid)" 3 1e-4
"$programs/pd2d" "$fluids/saline.electrolyte" --speciate > same 2> log
grep -q '^pH  ' same && ! grep -q '^pH of the inlet' same
verdict "one pH where what enters is the fluid itself" $?

# a strong base in water is its concentration
"$programs/pd2d" "$fluids/saline.electrolyte" --titrate "Na+ + OH- 0..10 mM 11" chemistry.activity=ideal \
    > base.csv 2> log
verdict "a titration"
check "its rows" [ "$(wc -l < base.csv)" = 12 ]
awk -F, 'NR == 1 { n = NF; exit $1 != "added [mol/m3]" || $2 != "pH [-]" }
    { want = NR == 2 ? 7 : 11 + log($1) / log(10); bad += NF != n || $2 - want > 2e-4 || want - $2 > 2e-4 }
    END { exit bad > 0 }' base.csv
verdict "its pH"
check "its line of results" grep -q '^result case=saline rows=11 pH_first=7.000000 pH_last=12.0' log
# magnesium and its hydroxide: without minerals the pH is higher, with them what precipitates holds it
for minerals in given all; do
    "$programs/pd2d" "$fluids/brucite.electrolyte" --titrate "Mg2+ + 2 OH- 0..5 mM 6" chemistry.minerals=$minerals \
        > $minerals.csv 2> $minerals.log
    verdict "magnesium, minerals = $minerals"
done
check "magnesium without precipitation" near "$(sed -n 's/.*pH_last=//p' given.log)" 11.8 0.15
check "magnesium that precipitates" near "$(sed -n 's/.*pH_last=//p' all.log)" 10.396 0.02

# refuses MESSAGE ARGUMENT...: status 2 and that one line.
refuses() {
    printf 'pd2d: %s\n' "$1" > wanted
    shift
    "$programs/pd2d" "$@" > out 2> log
    [ $? = 2 ] && [ ! -s out ] && cmp -s log wanted
    said=$?
    sed 's/^/expected /' wanted >> log
    verdict "pd2d $*" $said
}
cp "$fluids"/*.electrolyte .
refuses "sbf.electrolyte:5: chemistry: the charges sum to -7.4 mol/m3, 4.41 % of the ionic strength, expected 0: \
correct a concentration, or name the ion that makes up for it by balance_ion = Cl-" \
    sbf.electrolyte --speciate "species.SO4-2.initial=4.2 mM"
refuses "command line: found the section [species Zn2+], expected one of hbss.electrolyte (its labels: Na+, K+, Mg2+, \
Ca2+, Cl-, HCO3-, H2PO4-, HPO4-2, SO4-2, Mg(OH)2(s), CaCO3(s), Ca5(PO4)3OH(s), CaHPO4:2H2O(s), MgHPO4:3H2O(s), \
MgOH+, MgHCO3+, MgCO3, MgSO4, MgHPO4, CaHCO3+, CaCO3, CaSO4, CaHPO4, CaPO4-, CO3-2, CO2, H+, OH-, PO4-3)" \
    hbss.electrolyte --speciate "species.Zn2+.initial=1 mM"
refuses "hbss.electrolyte:4: chemistry: found species without a [grid], expected one for a run, or --speciate for \
their equilibrium" hbss.electrolyte
refuses "titrate: found 'Na+ + OH- 1 mM', expected a reagent, a range with its unit and a number of rows from 2 to \
100000, such as Na+ + OH- 0..1 mM 21" saline.electrolyte --titrate "Na+ + OH- 1 mM"
for range in "0x0..1 mM" "0..0x1 mM" "nan..1 mM" "0..inf mM" "0,5..1 mM"; do
    refuses "titrate: found 'Na+ + OH- $range 3', expected a reagent, a range with its unit and a number of rows \
from 2 to 100000, such as Na+ + OH- 0..1 mM 21" saline.electrolyte --titrate "Na+ + OH- $range 3"
done
refuses "titrate: found 'Na+ + OH- 0..1 mM 4294967298', expected a reagent, a range with its unit and a number of rows \
from 2 to 100000, such as Na+ + OH- 0..1 mM 21" saline.electrolyte --titrate "Na+ + OH- 0..1 mM 4294967298"
refuses "reaction: 'the reagent' has the species 'NaOH', which nobody defines: define it, or take one of Na+, Cl-, H+, \
OH-, H2O" saline.electrolyte --titrate "NaOH 0..1 mM 3"
refuses "electrolyte: the reagent 'OH-' has the charge -1, expected a neutral one such as Na+ + OH-" \
    saline.electrolyte --titrate "OH- 0..1 mM 3"
rejects_usage pd2d "--speciate and --titrate run nothing, expected a file and key=value alone" saline.electrolyte \
    --speciate --check
rejects_usage pd2d "no scene file given" --speciate
"$programs/pd2d" saline.electrolyte --titrate "Na+ + OH- 0..-1 mM 3" > out 2> log
check "more than there is" [ $? = 1 ]
score
