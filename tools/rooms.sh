#!/bin/sh
# rooms.sh [--check]: the rooms of src/ for docs/architecture.md, from src/MODULES, the includes and the first words of
# the headers: the table between the lines `<!-- rooms -->` and `<!-- end of rooms -->`, and docs/img/rooms.svg.
# --check writes nothing and fails where they differ.
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
page=docs/architecture.md drawing=docs/img/rooms.svg

# room|what it is for
cat > "$dir/purpose" << 'END'
core|memory, errors, threads, random numbers
lattice|nodes, families, bonds, operators, sides of the box
solve|linear solvers, multigrid, steps in time; no physics
flow|flow of the liquid, steady and in time; gas
chemistry|species, reactions, activities; knows no lattice
transport|what the liquid carries: advection, diffusion
react|species that flow, diffuse and react
solid|mechanics: points, elasticity, cracks
metal|metals, laws, dissolving surfaces, pits, salt layers
potential|electrodes, electric potential, galvanic currents
couple|one step of everything; the ledger
io|formats of files: VTK, PNG, CSV, state
scene|scene files become a setup
physics|the physics of a scene: what each builds, steps, samples, needs
run|a setup becomes files: output, studies
END

# Lines of rooms: the first word is a folder.
while read -r room modules; do
    [ ! -d "src/$room" ] || echo "$room $modules"
done < src/MODULES > "$dir/rooms"

# room|module|what its header says of it in one sentence
while read -r room modules; do
    for m in $modules; do
        [ ! -f "src/$room/$m.h" ] || echo "src/$room/$m.h"
    done
done < "$dir/rooms" > "$dir/headers"
# shellcheck disable=SC2046
awk 'function say() {
        sub(/^ *[a-z_]*: */, "", words); sub(/[.] .*/, "", words); sub(/ *\(theory.*/, "", words)
        sub(/[. ]*$/, "", words); gsub(/\|/, ",", words)
        split(name, part, "/"); sub(/\.h$/, "", part[3])
        printf "%s|%s|%s\n", part[2], part[3], words
    }
    FNR == 1 { if (name) say(); name = FILENAME; words = ""; ended = 0 }
    ended { next }
    { sub(/^\/\*/, ""); sub(/^ \*/, ""); ended = sub(/\*\/.*/, ""); gsub(/^ +| +$/, "") }
    $0 == "" { ended = 1; next }
    { words = words " " $0 }
    END { say() }' $(cat "$dir/headers") > "$dir/modules"

# Pairs of rooms: the first includes the second.
for room in $(cut -d' ' -f1 "$dir/rooms"); do
    grep -ho '^#include "[a-z_]*/' "src/$room"/*.[ch] | sed 's/.*"//; s,/$,,' | sort -u | sed "s/^/$room /"
done | awk '$1 != $2' > "$dir/includes"

{
    echo '| room | module | what it is |'
    echo '|---|---|---|'
    awk -F'|' 'NR == FNR { purpose[$1] = $2; next }
        $1 != last { printf "| **[src/%s](../src/%s)** | | **%s** |\n", $1, $1, purpose[$1]; last = $1 }
        { printf "| | [`%s`](../src/%s/%s.h) | %s |\n", $2, $1, $2, $3 }' "$dir/purpose" "$dir/modules"
} > "$dir/table"

# A room stands above all that it includes; arrows are the includes that no others imply.
awk -F'|' -v includes="$dir/includes" '
FILENAME ~ /purpose$/ { purpose[$1] = $2; next }
{ if (!($1 in list)) order[rooms++] = $1; list[$1] = list[$1] (list[$1] == "" ? "" : "  ") $2 }
function reach(a, b, k) {
    if (uses[a, b]) return 1
    for (k = 0; k < rooms; k++) if (uses[a, order[k]] && reach(order[k], b)) return 1
    return 0
}
function text(x, y, size, weight, colour, words) {
    printf "<text x=\"%d\" y=\"%d\" font-size=\"%d\" font-weight=\"%s\" fill=\"%s\">%s</text>\n", \
        x, y, size, weight, colour, words
}
END {
    while ((getline line < includes) > 0) { split(line, pair, " "); uses[pair[1], pair[2]] = 1 }
    for (r = 0; r < rooms; r++) { # the longest way down
        changed = 0
        for (a = 0; a < rooms; a++) for (b = 0; b < rooms; b++)
            if (uses[order[a], order[b]] && level[order[a]] <= level[order[b]]) {
                level[order[a]] = level[order[b]] + 1
                changed = 1
            }
        if (!changed) break
    }
    for (a = 0; a < rooms; a++) { if (level[order[a]] > top) top = level[order[a]]; width[level[order[a]]]++ }
    # rooms of scenes and files stand on the right
    right["io"] = right["scene"] = 1
    high = 106; gap = 30; wide = 880; half = 480
    total = (top + 1) * (high + gap) + gap
    printf "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\">\n", \
        wide + 40, total
    printf "<defs><marker id=\"tip\" viewBox=\"0 0 10 10\" refX=\"9\" refY=\"5\" markerWidth=\"8\" markerHeight=\"8\" "
    print "orient=\"auto\"><path d=\"M0 0L10 5L0 10z\" fill=\"#456\"/></marker></defs>"
    printf "<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/>\n", wide + 40, total
    for (a = 0; a < rooms; a++) {
        r = order[a]
        y[r] = gap + (top - level[r]) * (high + gap)
        x[r] = right[r] ? 20 + half + 24 : 20
        w[r] = right[r] ? wide - half - 24 : (r == "core" || r == "lattice" || r == "run") ? wide : half
    }
    for (a = 0; a < rooms; a++) for (b = 0; b < rooms; b++) {
        if (!uses[order[a], order[b]]) continue
        implied = 0
        for (k = 0; k < rooms; k++) if (uses[order[a], order[k]] && reach(order[k], order[b])) implied = 1
        if (implied) continue
        p = order[a]; q = order[b]
        if (w[p] < wide) from = x[p] + w[p] / 2; else from = x[q] + w[q] / 2
        if (w[q] < wide) to = x[q] + w[q] / 2; else to = x[p] + w[p] / 2
        if (w[p] == wide && w[q] == wide) from = to = 20 + half / 2
        if (right[p] && !right[q] && w[q] < wide) { from = x[p] + 30; to = x[q] + w[q] - 60 }
        printf "<line x1=\"%d\" y1=\"%d\" x2=\"%d\" y2=\"%d\" stroke=\"#456\" stroke-width=\"2\" ", \
            from, y[p] + high, to, y[q] - 2
        print "marker-end=\"url(#tip)\"/>"
    }
    for (a = 0; a < rooms; a++) {
        r = order[a]
        fill = right[r] || r == "run" ? "#fdf3e1" : \
            r == "core" || r == "solve" || r == "lattice" ? "#eef3f8" : "#e6f4ea"
        printf "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" rx=\"8\" fill=\"%s\" stroke=\"#456\"/>\n", \
            x[r], y[r], w[r], high, fill
        text(x[r] + 14, y[r] + 25, 18, "bold", "#123", r)
        text(x[r] + (length(r) > 6 ? 120 : 96), y[r] + 25, 13, "normal", "#345", purpose[r])
        n = split(list[r], name, "  "); line = ""; row = 0
        for (k = 1; k <= n; k++) {
            if (length(line) + length(name[k]) + 2 > (w[r] - 28) / 5.9) {
                text(x[r] + 14, y[r] + 47 + 15 * row++, 12, "normal", "#567", line)
                line = ""
            }
            line = line (line == "" ? "" : "  ") name[k]
        }
        text(x[r] + 14, y[r] + 47 + 15 * row, 12, "normal", "#567", line)
    }
    print "</svg>"
}' "$dir/purpose" "$dir/modules" > "$dir/rooms.svg"

awk -v table="$dir/table" '
/^<!-- rooms -->$/ { print; print ""; while ((getline line < table) > 0) print line; print ""; skip = 1; next }
/^<!-- end of rooms -->$/ { skip = 0 }
!skip' "$page" > "$dir/page"

if [ "$1" = --check ]; then
    cmp "$dir/page" "$page" && cmp "$dir/rooms.svg" "$drawing"
else
    cp "$dir/page" "$page" && cp "$dir/rooms.svg" "$drawing"
fi
