#!/bin/sh
# Scenes of earlier releases (tests/data/scenes-*): they are read, and their runs give its figures. A key
# that changes its name or its meaning has to take the old one, too, or say at the line what is to be written instead;
# then the scene leaves its folder, and the changelog has it.
. tests/lib/script.sh

for folder in tests/data/scenes-*; do
    grep -v '^#' "$folder/figures.txt" > "$dir/rows"
    while IFS=';' read -r scene dim arguments key value tolerance; do
        eval "set -- $arguments"
        "$programs/pd${dim# }d" "$folder/$scene" "$@" --out "$dir/out" --quiet > "$dir/log" 2>&1 < /dev/null
        verdict "$folder/$scene runs"
        key=${key# }
        found=$(figure "$key")
        awk -v f="$found" -v v="$value" -v t="$tolerance" \
            'BEGIN { e = f / v - 1; exit !(f != "" && e <= t + 0 && e >= -t) }'
        verdict "$folder/$scene: $key is '$found', expected $value"
        rm -rf "$dir/out"
    done < "$dir/rows"
    for scene in "$folder"/*.scene "$folder"/*.cfg; do
        check "$scene has a figure" grep -q "^$(basename "$scene");" "$dir/rows"
    done
done
score
