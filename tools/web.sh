#!/bin/sh
# web.sh PAGE WASM1 WASM2 WASM3: one page of drivers/web with the programs of the dimensions and the scenes in it.
set -e
page=$1
shift
data=$page.data

# Scenes that a browser runs in about a minute, then all templates; a name goes without its folder.
examples="mg_pin_2d pin_304_stream_2d pit_304_2d intergranular_2d crevice_625_2d plate_hole_2d mg_pin_axi mg_wire
    pencil_304_axi pencil_304_bonds_1d shock_tube_1d"
element() { # CLASS GROUP FILE
    printf '<script type="text/plain" class="%s" data-group="%s" data-name="%s">\n' "$1" "$2" "${3##*/}"
    cat "$3"
    printf '</script>\n'
}
{
    for name in $examples; do element scene Examples "examples/scenes/$name.scene"; done
    for file in examples/scenes/templates/*.scene; do element scene Templates "$file"; done
    for file in examples/scenes/*.csv; do element beside '' "$file"; done
    dim=0
    for wasm in "$@"; do
        dim=$((dim + 1))
        printf '<script type="text/plain" id="wasm%d">' $dim
        gzip -9 -n < "$wasm" | base64 | tr -d '\n'
        printf '</script>\n'
    done
} > "$data"

# A line "@NAME@" stands for a file of drivers/web, "@data@" for what is made above.
while IFS= read -r line; do
    case $line in
    @data@) cat "$data" ;;
    @*@) line=${line#@}; cat "drivers/web/${line%@}" ;;
    *) printf '%s\n' "$line" ;;
    esac
done < drivers/web/page.html > "$page.new"
rm "$data"
mv "$page.new" "$page"
