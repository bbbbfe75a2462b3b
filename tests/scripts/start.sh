#!/bin/sh
# --new and --keys: every template is the file that it is made of, runs to its end and balances; bad names are refused.
. tests/lib/script.sh

sh tools/templates.sh --check > "$dir/log" 2>&1
verdict "src/scene/template.c is made of examples/scenes/templates/; make amalgam"

# balances LOG: the run did all of it, and what it lacks of the balance is rounding, in a steady field 1e-6.
balances() {
    grep '^result case=.* dim=' "$1" | tr ' ' '\n' | awk -F = '
        $1 == "ledger" || $1 == "defect" { found++; if (!($2 <= ($1 == "ledger" ? 1e-12 : 1e-6))) wrong = 1 }
        END { exit !(found && !wrong) }'
}

for dim in 1 2 3; do
    pd=$programs/pd${dim}d
    for file in examples/scenes/templates/*_"$dim"d.scene; do
        name=$(basename "$file" "_${dim}d.scene")
        "$pd" --new "$name" > "$dir/$name.scene" 2> "$dir/log"
        verdict "pd${dim}d --new $name"
        check "pd${dim}d --new $name: the file" cmp "$dir/$name.scene" "$file"
        ! grep -n 'pd[123]d' "$file" | grep -v "pd${dim}d" > "$dir/log"
        verdict "$file names another program"
        "$pd" "$dir/$name.scene" --out "$dir/out" > "$dir/log" 2>&1
        verdict "pd${dim}d runs the template $name"
        check "the template $name balances in ${dim}D" balances "$dir/log"
        # what a ball in 3D is, a wire, a plate of six cells
        ! grep '^note: ' "$dir/log" | grep -v 'is whole cells\|rings: \|in parts thinner'
        verdict "the template $name runs without a note in ${dim}D"
        rm -rf "$dir/out"
    done
    "$pd" --new > "$dir/names"
    [ "$(cat "$dir/names")" = "$(ls examples/scenes/templates | sed -n "s/_${dim}d.scene//p")" ]
    verdict "pd${dim}d --new lists the templates"
    for section in $("$pd" --keys | sed 's/^\[\([a-z]*\).*/\1/'); do
        "$pd" --keys "$section" > "$dir/log" 2>&1 && head -n 1 "$dir/log" | grep -q "^\[$section" &&
            ! grep -q '`' "$dir/log" && [ "$(grep -c '^  [A-Za-z].* unit ' "$dir/log")" -ge 1 ]
        verdict "pd${dim}d --keys $section"
    done
done

# refused STATUS TEXT ARGUMENT...: one line on stderr that holds TEXT.
refused() {
    status=$1 text=$2
    shift 2
    "$programs/pd2d" "$@" > "$dir/out" 2> "$dir/log"
    [ $? = "$status" ] && [ ! -s "$dir/out" ] && [ "$(wc -l < "$dir/log")" = 1 ] && grep -q -- "$text" "$dir/log"
    said=$?
    verdict "pd2d $* is refused: $text" $said
}
refused 2 "found 'pot', expected one of channel, couple, crevice, galvanic, pit, plate, wire" --new pot
refused 2 "found 'flwo', expected one of constants, grid" --keys flwo
refused 2 'go without a scene, found a.scene' a.scene --new pit
refused 2 'go without a scene, found a.scene' --keys flow a.scene
refused 2 'expected one of them' --new pit --keys flow
"$programs/pd2d" --version > "$dir/log" 2>&1 && grep -q '^pdcorr [0-9]*\.[0-9]*\.[0-9]*$' "$dir/log"
verdict "pd2d --version"
score
