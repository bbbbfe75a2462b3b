#!/bin/sh
# report.sh DIR DOCS: puts the sections that validate1d, validate2d and validate3d have written into DIR together as
# DOCS/validation.md, misses first, with their figures in DOCS/img/validation/.
dir=$1 docs=$2
[ -f "$dir/summary_1d.md" ] && [ -f "$dir/summary_2d.md" ] && [ -f "$dir/summary_3d.md" ] || {
    echo "report.sh: $dir lacks the summary of a dimension; run validate1d, 2d and 3d with --out $dir" >&2
    exit 1
}
pictures=$docs/img/validation
rm -rf "$pictures"
mkdir -p "$pictures" || exit 1
rows() { cat "$dir/summary_1d.md" "$dir/summary_2d.md" "$dir/summary_3d.md"; }
missed=$(rows | grep -c -v '^| met ')
met=$(rows | grep -c '^| met ')
{
    cat << END
# Validation

Solutions compared with closed forms and published figures. Written by \`make report\`, which runs every case of
\`drivers/validate/\`; only the times differ from run to run. One case: \`build/validate2d poiseuille\`; the options
tell \`build/validate2d --help\`. A goal holds at the levels named with it; a guard holds coarse levels to what they
reach, for \`make test\`.

## Summary

$((met + missed)) goals are judged: $met are met, $missed are missed.

| verdict | case | part | measure | goal | found |
|---|---|---|---|---|---|
END
    rows | grep -v '^| met '
    rows | grep '^| met '
    echo
    echo "## Cases"
    # Sections in the order of the cases; the dimensions of a case stand together.
    for name in $(rows | sed 's/^[^[]*\[\([a-z0-9_]*\), .*/\1/' | awk '!seen[$0]++'); do
        for k in 1 2 3; do
            [ -f "$dir/${name}_${k}d.md" ] || continue
            echo
            echo "<a id=\"$name-${k}d\"></a>"
            echo
            sed "s#](${name}_${k}d#](img/validation/${name}_${k}d#" "$dir/${name}_${k}d.md"
        done
    done
} > "$docs/validation.md.part" || exit 1
cp "$dir"/*.png "$pictures/" || exit 1
mv "$docs/validation.md.part" "$docs/validation.md"
