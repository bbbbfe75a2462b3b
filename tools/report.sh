#!/bin/sh
# report.sh DIR DOCS: puts the sections that validate1d, validate2d and validate3d have written into DIR together as
# DOCS/validation.md, misses first, with their figures in DOCS/img/validation/.
#
# report.sh --performance DIR DOCS: the same of bench1d, 2d and 3d, as DOCS/performance.md. Sections that an earlier run
# has left in DIR count, so that single cases can be run again.
kind=validation
[ "$1" = --performance ] && kind=performance && shift
dir=$1 docs=$2
if [ $kind = validation ]; then
    [ -f "$dir/summary_1d.md" ] && [ -f "$dir/summary_2d.md" ] && [ -f "$dir/summary_3d.md" ] || {
        echo "report.sh: $dir lacks the summary of a dimension; run validate1d, 2d and 3d with --out $dir" >&2
        exit 1
    }
else
    ls "$dir"/goals_*_2d.md > /dev/null 2>&1 || {
        echo "report.sh: $dir holds no section; run bench1d, 2d and 3d with --out $dir" >&2
        exit 1
    }
fi
pictures=$docs/img/$kind
rm -rf "$pictures"
mkdir -p "$pictures" || exit 1

rows() {
    if [ $kind = validation ]; then cat "$dir/summary_1d.md" "$dir/summary_2d.md" "$dir/summary_3d.md"
    else cat "$dir"/goals_*.md; fi
}
# In the order of the cases of the report.
names() {
    if [ $kind = validation ]; then rows | sed 's/^[^[]*\[\([a-z0-9_]*\), .*/\1/' | awk '!seen[$0]++'
    else printf '%s\n' counts scenes study kernels csr scaling triad; fi
}
processor() { sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo 2> /dev/null | head -n 1; }
load() { cut -d ' ' -f 1 /proc/loadavg 2> /dev/null || echo unknown; }

head_of_validation() {
    cat << END
# Validation

Solutions compared with closed forms and published figures. Written by \`make validation\`, which runs every case of
\`drivers/validate/\`; only the times differ from run to run. One case: \`build/validate2d poiseuille\`; the options
tell \`build/validate2d --help\`. A goal holds at the levels named with it; a guard holds coarse levels to what they
reach, for \`make test\`.

## Summary

$((met + missed)) goals are judged: $met are met, $missed are missed.

| verdict | case | part | measure | goal | found |
|---|---|---|---|---|---|
END
}
head_of_performance() {
    cat << END
# Performance

What the operators, the solvers and whole runs cost, and what error that buys. Written by \`make bench\`, which runs
every case of \`drivers/bench/\`. One case: \`build/bench2d kernels\`; the options tell \`build/bench2d --help\`. Counts
of evaluations and iterations do not depend on the machine. Times do: these are of one machine
($(processor), $(getconf _NPROCESSORS_ONLN) cores, load average $(load) when this was written), and on a shared
one ratios of times that were taken in turns mean more than the times.

## Summary

$((met + missed)) goals are judged: $met are met, $missed are missed.

| verdict | case | measure | goal | found |
|---|---|---|---|---|
END
}

missed=$(rows | grep -c -v '^| met ')
met=$(rows | grep -c '^| met ')
{
    head_of_$kind
    rows | grep -v '^| met '
    rows | grep '^| met '
    echo
    echo "## Cases"
    # The dimensions of a case stand together.
    for name in $(names); do
        for k in 1 2 3; do
            [ -f "$dir/${name}_${k}d.md" ] || continue
            echo
            echo "<a id=\"$name-${k}d\"></a>"
            echo
            sed "s#](${name}_${k}d#](img/$kind/${name}_${k}d#" "$dir/${name}_${k}d.md"
        done
    done
} > "$docs/$kind.md.part" || exit 1
for picture in $(sed -n "s#.*](img/$kind/\([^)]*\)).*#\1#p" "$docs/$kind.md.part"); do
    cp "$dir/$picture" "$pictures/" || exit 1
done
mv "$docs/$kind.md.part" "$docs/$kind.md"
