#!/bin/sh
# slow: weekly
# The benchmarks run on small sizes, and the work of the solvers stays what it is. Counts are asserted, times never.
. tests/lib/script.sh

for k in 1 2 3; do
    "$programs/bench${k}d" --quick --quiet --threads 1 --out "$dir/report" > "$dir/lines$k" 2> "$dir/log"
    verdict "bench${k}d --quick"
done
cat "$dir"/lines? > "$dir/lines"

# at_most MOST KEY PAIR...: KEY of the one result line with all the pairs is at most MOST.
at_most() {
    most=$1 key=$2
    shift 2
    cp "$dir/lines" "$dir/found"
    for pair; do
        grep -F -- " $pair " "$dir/found" > "$dir/less"
        mv "$dir/less" "$dir/found"
    done
    value=$(sed -n "s/.* $key=\([^ ]*\) .*/\1/p" "$dir/found")
    awk -v v="$value" -v m="$most" 'BEGIN { exit !(v != "" && v + 0 == v && v <= m) }' > "$dir/log"
    verdict "$*: $key is '$value', expected at most $most"
}

# What is counted today and a few per cent, since compilers round differently.
at_most 132 evals case=counts part=pin h=1e-05
at_most 86 evals_again case=counts part=pin h=1e-05
at_most 1e-8 residual case=counts part=pin h=1e-05
at_most 15 krylov case=counts part=transport n=16 m=1 limited=0 courant=0.1
at_most 17 krylov case=counts part=transport n=16 m=1 limited=0 courant=10000
at_most 23 krylov case=counts part=transport n=16 m=1 limited=1
at_most 15 krylov case=counts part=transport n=32 m=1 limited=0 courant=0.1
at_most 17 krylov case=counts part=transport n=32 m=1 limited=0 courant=10000
at_most 24 krylov case=counts part=transport n=32 m=1 limited=1
at_most 32 krylov case=counts part=transport n=16 m=3 limited=0 courant=0.1
at_most 38 krylov case=counts part=transport n=16 m=3 limited=0 courant=10000
at_most 46 krylov case=counts part=transport n=16 m=3 limited=1
at_most 33 krylov case=counts part=transport n=32 m=3 limited=0 courant=0.1
at_most 38 krylov case=counts part=transport n=32 m=3 limited=0 courant=10000
at_most 52 krylov case=counts part=transport n=32 m=3 limited=1
at_most 46 evals case=counts part=implicit n=16
at_most 38 evals case=counts part=implicit n=32
at_most 34 krylov case=solid dim=2 part=cube n=64
at_most 39 krylov case=solid dim=3 part=cube n=16
at_most 0 unequal case=glass n=200
at_most 104 evals case=scenes name=mg_pin_2d
at_most 113 evals case=scenes name=mg_pin_axi
at_most 72 evals case=scenes name=channel3d_3d
at_most 11 steps case=scenes name=channel3d_3d
at_most 150 steps case=study dim=1 part=pulse level=1
at_most 280 steps case=study dim=1 part=pencil level=0
at_most 80 evals case=study dim=2 part=poiseuille level=0
# The three ways to the Laplacian agree.
at_most 1e-12 err_max dim=2 part=agreement
at_most 1e-12 err_max dim=3 part=agreement

rejects_usage bench2d "no case has the name (--list prints them) kernel" kernel
rejects_usage bench2d "unknown option --fast" --fast
rejects_usage bench2d "unknown key (m and n can be set): h=1" h=1
rejects_usage bench2d "n expects a whole number of at least 12, found n=2" n=2
"$programs/bench2d" counts --quick --scenes "$dir" > "$dir/log" 2>&1
[ $? = 1 ]
verdict "bench2d without its scenes"

# The report: every section, its figures, a summary.
mkdir "$dir/docs"
sh tools/report.sh --performance "$dir/report" "$dir/docs" > "$dir/log" 2>&1
verdict "report"
for name in performance.md img/performance/study_1d_pulse.png img/performance/study_2d_poiseuille.png \
    img/performance/scaling_2d_one.png; do
    [ -s "$dir/docs/$name" ] || echo "no $name"
done > "$dir/log"
[ ! -s "$dir/log" ]
verdict "files of the report"
score
