#!/bin/sh
# report.sh DIR DOCS: puts the sections that validate1d, validate2d and validate3d have written into DIR together as
# DOCS/details/validation.md, misses first, with their pictures in DOCS/img/validation/; tools/summary.sh makes the page
# to read of it, DOCS/validation.md.
#
# report.sh --performance DIR DOCS: that of bench1d, 2d and 3d. Sections that an earlier run
# has left in DIR count, so that single cases can be run again; DIR/kept.txt, where it is there, says of which machine
# they are.
#
# report.sh --stability DIR DOCS: the result lines of the logs of tests/hard/ in DIR, and what stability1d, 2d and 3d
# have written there. The reasons of the cases are the comments above their tests.
kind=validation
[ "$1" = --performance ] && kind=performance && shift
[ "$1" = --stability ] && kind=stability && shift
dir=$1 docs=$2
if [ $kind = validation ]; then
    [ -f "$dir/summary_1d.md" ] && [ -f "$dir/summary_2d.md" ] && [ -f "$dir/summary_3d.md" ] || {
        echo "report.sh: $dir lacks the summary of a dimension; run validate1d, 2d and 3d with --out $dir" >&2
        exit 1
    }
elif [ $kind = stability ]; then
    ls "$dir"/hard_*.log > /dev/null 2>&1 || {
        echo "report.sh: $dir holds no log; run the programs of tests/hard and stability1d, 2d and 3d" >&2
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
mkdir -p "$pictures" "$docs/details" || exit 1

# Rows of one table from result lines: underscores of words are spaces, `message` runs to the end of the line.
parts() {
    cat "$dir"/hard_*.log | awk -v want="$1" '
        function value(key,   at, text) {
            at = index($0, " " key "=")
            if (!at) return ""
            text = substr($0, at + length(key) + 2)
            if (key != "message" && index(text, " ")) text = substr(text, 1, index(text, " ") - 1)
            if (key == "measure" || key == "naive_what") gsub("_", " ", text)
            return text
        }
        /^result / && value("case") == want {
            outcome = value("outcome")
            found = outcome == "refused" ? "`" value("message") "`" : value("err") " " value("measure")
            if (outcome == "failed" && value("message") != "") found = found " `" value("message") "`"
            if (value("geometries") != "") found = found ", " value("geometries") " geometries, " value("refused") \
                " refused"
            plain = value("naive") == "" ? "" : value("naive") " " value("naive_what")
            part = value("part")
            gsub("_", " ", part)
            word = outcome == "failed" ? "**failed**" : outcome == "refused" ? "refused" : "right"
            print "| " word " | " part " | " value("dim") "D | " found " | " value("ledger") " | " value("bounds") \
                " | " value("steps") " | " plain " |"
        }'
}
# The comment right above the test of a case.
reason() {
    cat tests/hard/test_*.c | awk -v want="TEST($1)" '
        /^\/\*/ { text = ""; inside = 1 }
        inside { text = text " " $0 }
        inside && /\*\// { inside = 0; fresh = 1; next }
        index($0, want) == 1 && fresh { gsub("^ */[*] *| *[*]/ *$", "", text); gsub(" +[*] +", " ", text); print text }
        !inside { if ($0 !~ /^#/) fresh = 0 }'
}
geometries() {
    cat "$dir"/hard_*.log | sed -n "s/.* $1=\([0-9]*\).*/\1/p" | awk '{ n += $1 } END { print n + 0 }'
}
parts_in() { cat "$dir"/hard_*.log | grep -c "^result .* dim=$1 "; }
hard_cases() { cat "$dir"/hard_*.log | sed -n 's/^result case=\([a-z0-9_]*\) .*/\1/p' | awk '!seen[$0]++'; }

rows() {
    if [ $kind = stability ]; then cat "$dir"/hard_*.log | grep '^result ' |
        sed 's/.*outcome=failed.*/| failed /; s/.*outcome=[ar].*/| met /'
    elif [ $kind = validation ]; then cat "$dir/summary_1d.md" "$dir/summary_2d.md" "$dir/summary_3d.md"
    else cat "$dir"/goals_*.md; fi
}
# In the order of the cases of the report.
names() {
    if [ $kind = stability ]; then printf '%s\n' transport unsteady gas two_stage implicit
    elif [ $kind = validation ]; then rows | sed 's/^[^[]*\[\([a-z0-9_]*\), .*/\1/' | awk '!seen[$0]++'
    else printf '%s\n' counts scenes against species study horizon solid glass kernels csr neighbour scaling triad; fi
}
processor() { sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo 2> /dev/null | head -n 1; }
load() { cut -d ' ' -f 1 /proc/loadavg 2> /dev/null || echo unknown; }

head_of_validation() {
    cat << END
# Validation

Solutions compared with closed forms and published figures. Written by \`make validation\`, which runs every case of
\`cases/validate/\`; only the times differ from run to run. One case: \`build/validate2d poiseuille\`; for options
see \`build/validate2d --help\`. A goal holds at the levels named with it; a guard holds coarse levels to what they
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
every case of \`cases/bench/\`. One case: \`build/bench2d kernels\`; for options see \`build/bench2d --help\`. Counts
of evaluations and iterations do not depend on the machine. Times do: these are of one machine
($(processor), $(getconf _NPROCESSORS_ONLN) cores, load average $(load) when this was written), and on a shared
one ratios of times that were taken in turns mean more than the times. Sections that an earlier run has left are of the
machine of that run.$([ ! -f "$dir/kept.txt" ] || echo " $(cat "$dir/kept.txt")")

## Summary

$((met + missed)) goals are judged: $met are met, $missed are missed.

| verdict | case | measure | goal | found |
|---|---|---|---|---|
END
}

head_of_stability() {
    cat << END
# Stability

Hard cases: each runs through with the right answer, or is refused with a message. Written by \`make stability\`, which
runs the programs of \`tests/hard/\` and \`stability1d\`, \`2d\` and \`3d\`. One case:
\`build/hard_geometry_2d debris\`. These are the results of the logs at hand, with
$(geometries geometries) geometries at random that ran through and $(geometries refused) that were refused; a whole
sweep is 10,000.

$((met + missed)) parts are run, $(parts_in 1) of them in 1D, $(parts_in 2) in 2D and $(parts_in 3) in 3D: $met end as
they should, $missed do not.

\`ledger\`: largest imbalance over the amounts that were there or passed. \`bounds\`: by how much concentrations left
their bounds, over the largest of them. \`plain scheme\`: what a plain scheme does there.

## Hard cases
END
    for name in $(hard_cases); do
        echo
        echo "### $name" | tr _ ' '
        echo
        reason "$name"
        echo
        echo "| outcome | part | | error or message | ledger | bounds | steps | plain scheme |"
        echo "|---|---|---|---|---|---|---|---|"
        parts "$name" | sort -t '|' -k 3,3 -s
    done
    echo
    echo "## Longest steps"
    echo
    echo "What the integrators choose against the longest step that is stable, or keeps the bounds that the step is"
    echo "there for. Waves: from the response of the code to an impulse, for all wave vectors of a lattice."
}

missed=$(rows | grep -c -v '^| met ')
met=$(rows | grep -c '^| met ')
{
    head_of_$kind
    [ $kind = stability ] || {
        rows | grep -v '^| met '
        rows | grep '^| met '
        echo
        echo "## Cases"
    }
    # The dimensions of a case stand together.
    for name in $(names); do
        for k in 1 2 3; do
            [ -f "$dir/${name}_${k}d.md" ] || continue
            echo
            echo "<a id=\"$name-${k}d\"></a>"
            echo
            # errors over the cells stand in the tables: their plots stay in DIR
            sed "/_errors.png)\$/d; s#](${name}_${k}d#](../img/$kind/${name}_${k}d#" "$dir/${name}_${k}d.md" | cat -s
        done
    done
} > "$docs/details/$kind.md.part" || exit 1
for picture in $(sed -n "s#.*](../img/$kind/\([^)]*\)).*#\1#p" "$docs/details/$kind.md.part"); do
    cp "$dir/$picture" "$pictures/" || exit 1
done
mv "$docs/details/$kind.md.part" "$docs/details/$kind.md" && sh tools/summary.sh "$docs"
