#!/bin/sh
# usage: fuzz.sh FOLDER SECONDS FUZZER...: runs the fuzzers of FOLDER one after the other on seeds from examples/ and
# what earlier runs have found; ends with 1 when one found something.
folder=$1 seconds=$2
shift 2
found=0
for name in "$@"; do
    corpus=$folder/corpus_$name
    mkdir -p "$corpus"
    case $name in
    scene) cp examples/scenes/*_2d.scene examples/scenes/*_axi.scene examples/scenes/s0_params.cfg \
        examples/scenes/validation/*_2d.scene "$corpus" ;;
    electrolyte) cp examples/electrolytes/*.electrolyte "$corpus"
        for fluid in saline hbss sbf; do # without files beside them
            (cd examples/electrolytes && cat water.* carbonate.* phosphate.* pairs.* minerals.* "$fluid.electrolyte") |
                sed 's/include = [a-z.]*\(, [a-z.]*\)*//' > "$corpus/$fluid"
        done ;;
    expression) # the values of all scenes, a file each
        n=0
        cat examples/scenes/*.scene | sed -n 's/.*= *\([^=]*\)$/\1/p' | sort -u | while read -r line; do
            n=$((n + 1))
            printf '%s' "$line" > "$corpus/seed_$n"
        done ;;
    table) printf '# a\n"t [s]",x\n1,2\n3,"4"\n' > "$corpus/seed_1" ;;
    mesh) cp tests/data/*.vtu "$corpus"
        printf 'x,y,z,volume,tag\n1,0,0,2,3\n' > "$corpus/seed_1"
        printf '$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n2 1 0 0\n' > "$corpus/seed_2"
        printf '3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 7 1 1 2 3\n$EndElements\n' >> "$corpus/seed_2"
        {
            printf '$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 1 7 0\n$EndEntities\n'
            printf '$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n'
            printf '$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n'
        } > "$corpus/seed_3" ;;
    stl) printf 'solid a\n' > "$corpus/seed_1"
        for face in '0 0 0;0 1 0;1 0 0' '0 0 0;1 0 0;0 0 1' '0 0 0;0 0 1;0 1 0' '1 0 0;0 1 0;0 0 1'; do
            printf 'facet normal 0 0 1\nouter loop\nvertex %s\nendloop\nendfacet\n' \
                "$(printf '%s' "$face" | sed 's/;/\nvertex /g')" >> "$corpus/seed_1"
        done
        printf 'endsolid\n' >> "$corpus/seed_1" ;;
    png) cp docs/img/*.png docs/img/*/*.png "$corpus" 2> /dev/null ;;
    esac
    echo "== $name, $seconds s"
    "$folder/$name" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2000 -max_len=4000 -print_final_stats=1 \
        -artifact_prefix="$folder/$name-" "$corpus" > "$folder/$name.log" 2>&1 || {
        found=1
        tail -n 40 "$folder/$name.log"
    }
    grep -E '^(Done|stat::number_of_executed_units)' "$folder/$name.log"
done
exit $found
