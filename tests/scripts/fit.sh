#!/bin/sh
# slow: yes
# Measured points on the command line: the scene of the measured wire meets its scans, a fit finds what closed forms
# give, and bad input gives a message of one line.
. tests/lib/script.sh
OMP_NUM_THREADS=1
export OMP_NUM_THREADS
scenes=$root/examples/scenes
cd "$dir" || exit 1

# field KEY: of the last result line that has it.
field() {
    awk -v key="$1=" '/^result/ { for (k = 1; k <= NF; k++) if (index($k, key) == 1) value = substr($k,
        length(key) + 1) } END { print value }' log
}

# lies KEY LOW HIGH
lies() {
    found=$(field "$1")
    awk -v f="$found" -v l="$2" -v h="$3" 'BEGIN { exit !(f != "" && f + 0 >= l && f + 0 <= h) }'
    verdict "$1 is '$found', expected $2 to $3"
}

# The scene as it is shipped: every scan within its spread.
"$programs/pd2d" "$scenes/mg_wire.scene" --quiet --out wire > log 2>&1
verdict "mg_wire runs"
lies points 9 9
lies within_spread 9 9
lies rms 0 0.35
lies largest 0 0.6
check "volume_loss.png" test -s wire/volume_loss.png
check "ten rows of points" test "$(grep -c '^[0-9]' wire/measured_scans.csv)" = 10

# A cylinder that recedes by v (1 - exp(-t/tau)), t from 0.6872 h on, fitted to the same points with the same weights:
# v = 1.709 um/h, tau = 1.522 h, standard errors 0.261 and 0.450, chi2 1.25; without film 1.0901 and 0.0302 um/h,
# chi2 25.1. The coarse lattice is off by less than the errors.
"$programs/pd2d" "$scenes/mg_wire.scene" "h=20 um" --quiet --out fit --fit "constants.v=1..3 um/h" \
    --fit "constants.tau=0.5..4 h" > log 2>&1
verdict "a fit of two constants"
lies constants.v 1.448 1.97
lies constants.tau 1.072 1.972
lies constants.v.error 0.13 0.40
lies constants.tau.error 0.25 0.68
lies chi2 1.0 1.6
lies correlation_1_2 0.9 1
lies fine_evals 8 30
lies within_spread 9 9
"$programs/pd2d" "$scenes/mg_wire.scene" "h=20 um" "rate=v*(1 - C/Csat)" --quiet --out fit \
    --fit "constants.v=0.5..3 um/h" > log 2>&1
verdict "a fit of a constant speed"
lies constants.v 0.98 1.20
lies chi2 18 30
lies freedom 8 8

# Points of the command line, with the fit and without it.
printf 'when,lost,sd\n2,10,1\n3,15,1\n' > points.csv
"$programs/pd2d" "$scenes/mg_wire.scene" "h=20 um" --quiet --out to \
    --to "points.csv  time = when in h  value = lost in %  standard_deviation = sd in %  start = 1 h" > log 2>&1
verdict "a run with points of the command line"
lies points 2 2
check "their table" test -s to/measured_data.csv

# says TEXT STATUS ARGUMENT...: that status and one line with TEXT, no folder.
says() {
    text=$1 wanted=$2
    shift 2
    "$programs/pd2d" "$scenes/mg_wire.scene" --quiet --out none "$@" > stdout 2> log
    status=$?
    [ "$status" = "$wanted" ] && [ "$(wc -l < log)" = 1 ] && grep -qF -e "$text" log && [ ! -e none ]
    verdict "says '$text' with $wanted" $?
}
says "expected KEY=LOW..HIGH, such as" 2 --fit "v"
says "expected a finite low bound below the high one" 2 --fit "v=2..1 um/h"
says "found the key 'w', which no section of" 2 --fit "w=1..2"
says "expected a speed [m/s]" 2 --fit "v=1..2 h"
says "cannot open 'nowhere.csv'" 2 --fit "v=1..2 um/h" --to nowhere.csv
says "expected a column of points.csv: when, lost, sd" 2 --to "points.csv  time = when in h  value = loss"
says "found 2 points for 3 parameters" 2 --fit "v=1..2 um/h" --fit "tau=1..2 h" --fit "dissolve.rate_scale=1..2" \
    --to "points.csv time = when in h value = lost in %"
says "--resume goes on with one run" 2 --fit "v=1..2 um/h" --resume
score
