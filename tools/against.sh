#!/bin/sh
# against.sh CHECKOUT OUT: scenes of `examples/scenes` with the programs of this checkout and with those of another one,
# each with its own scene files, in turns on two threads. Both have been built (`make`). OUT gets a section of the
# performance report with the least of three wall times, and its goals: what a scene may take of the time that it takes
# there. Times of two machines cannot be compared; those of two programs on one can. OUT/against.txt, where it is there,
# says why goals are missed.
there=$1 out=$2 threads=2 turns=3
[ -x "$there/build/pd2d" ] && [ -x "$there/build/pd3d" ] && [ -d "$out" ] || {
    echo "usage: against.sh CHECKOUT OUT; expected build/pd2d and build/pd3d in CHECKOUT, and a folder OUT" >&2
    exit 2
}
commit=$(git -C "$there" rev-parse --short HEAD) || exit 1
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT

# run CHECKOUT DIMENSION SCENE OVERRIDE...: wall seconds, megabytes, evaluations and steps.
run() {
    of=$1 dim=$2 scene=$3
    shift 3
    rm -rf "$dir/run"
    "$of/build/pd${dim}d" "$of/examples/scenes/$scene.scene" "$@" --threads $threads --quiet --out "$dir/run" \
        > "$dir/log" 2>&1 || { cat "$dir/log" >&2; return 1; }
    awk '/^result / && / wall_s=/ {
        for (k = 2; k <= NF; k++) { split($k, pair, "="); value[pair[1]] = pair[2] }
        printf "%s %s %s %s\n", value["wall_s"], value["peak_rss_mb"], "evals" in value ? value["evals"] : "-",
            value["steps"] }' "$dir/log"
}

# compare GOAL DIMENSION SCENE OVERRIDE...: one row; GOAL 0: none.
compare() {
    goal=$1 dim=$2 scene=$3
    shift 3
    : > "$dir/there"
    : > "$dir/here"
    for turn in $(seq $turns); do
        run "$there" "$dim" "$scene" "$@" >> "$dir/there" && run . "$dim" "$scene" "$@" >> "$dir/here" || exit 1
    done
    before=$(sort -n "$dir/there" | head -n 1) after=$(sort -n "$dir/here" | head -n 1)
    echo "$before $after" | awk -v name="$scene${*:+ $*}" '{
        printf "| %s | %.2f | %.2f | %.2f ", name, $1, $5, $5 / $1
        printf "| %s | %s | %s | %s | %s | %s |\n", $4, $8, $3, $7, $2, $6 }' >> "$dir/rows"
    [ "$goal" = 0 ] || echo "$before $after" | awk -v name="$scene" -v goal="$goal" -v commit="$commit" '{
        printf "| %s | [against, 2D](#against-2d) ", $5 / $1 <= goal ? "met" : "**missed**"
        printf "| %s: wall time over that of %s | at most %s | %.3g |\n", name, commit, goal, $5 / $1 }' \
        >> "$out/goals_against_2d.md"
}

rm -f "$out/goals_against_2d.md"
compare 0.333 2 mg_pin_2d
compare 0 2 mg_pin_axi
compare 1 2 crevice_625_2d output.images=none
compare 0 2 pit_304_2d output.images=none
compare 0.5 3 validation/channel3d_3d 'run.until=10 s'
compare 0.51 3 mg_pin_3d 'run.until=1 h'
compare 0.44 3 pits_304_3d 'run.until=18 s' 'output.every=18 s' output.images=none
{
    cat << END
### against, 2D: The same scenes by another version

Wall times of whole runs with their files, on $threads threads, by the programs of this version and by those of commit
$commit, each with its own scene files, in turns; the least of $turns. Goals of time that were set for the machine on
which that version was timed are shares of its time here.

*Run.* \`sh tools/against.sh CHECKOUT OUT\`

| scene | $commit [s] | here [s] | ratio | steps there | here | evaluations there | here | memory there [MB] | here |
|---|---|---|---|---|---|---|---|---|---|
END
    cat "$dir/rows"
    [ ! -f "$out/against.txt" ] || { echo; cat "$out/against.txt"; }
} > "$out/against_2d.md"
