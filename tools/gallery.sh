#!/bin/sh
# gallery.sh [NAME...]: runs the scenes and templates of docs/site/gallery.txt, all or those named, and puts their
# pictures into docs/img/: two minutes of processor time.
build=${BUILD:-build}
dir=$(mktemp -d) || exit 1
trap 'rm -rf "$dir"' EXIT
grep -v '^#' docs/site/gallery.txt | while IFS=';' read -r name picture which more; do
    picture=${picture# } which=${which# }
    [ "$which" != - ] || continue
    case " ${*:-$name} " in *" $name "*) ;; *) continue ;; esac
    scene=examples/scenes/$name.scene
    [ -f "$scene" ] || scene=examples/scenes/templates/${name}_2d.scene
    case $name in *_1d) dim=1 ;; *_3d) dim=3 ;; *) dim=2 ;; esac
    if [ ! -d "$dir/$name" ]; then
        echo "runs $name"
        eval "\"$build/pd${dim}d\" \"$scene\" $more --out \"$dir/$name\" --quiet" > "$dir/log" 2>&1 || {
            cat "$dir/log"
            exit 1
        }
    fi
    found=
    for file in "$dir/$name/$which.png" "$dir/$name/${which}"_*.png; do [ ! -f "$file" ] || found=$file; done
    [ "$found" ] || { echo "$name draws no $which"; exit 1; }
    mkdir -p "docs/$(dirname "$picture")"
    cp "$found" "docs/$picture"
done
