#!/bin/sh
# templates.sh [--check]: writes src/scene/template.c from examples/scenes/templates/NAME_2d.scene and the like, a
# string for each line, since C99 promises none longer than 4095 bytes. --check: status 1 when the file is another one.
out=src/scene/template.c
new=$(mktemp) || exit 1
trap 'rm -f "$new"' EXIT
folder=examples/scenes/templates

# names DIM: the templates of that dimension.
names() { for file in $folder/*_"$1"d.scene; do basename "$file" _"$1"d.scene; done; }

{
    echo "/* template: see template.h. Written by tools/templates.sh from $folder/. */"
    echo '#include "scene/template.h"'
    echo
    directive=if
    for dim in 1 2 3; do
        echo "#$directive PD_DIM == $dim"
        directive=elif
        for name in $(names $dim); do
            echo "static const char *const pdi_template_of_${name}[] = {"
            sed 's/\\/\\\\/g; s/"/\\"/g; s/^/"/; s/$/",/' "$folder/${name}_${dim}d.scene"
            echo '    NULL};'
        done
        echo
        echo 'static const pd_template pdi_template_all[] = {'
        for name in $(names $dim); do echo "    {\"$name\", pdi_template_of_$name},"; done
        echo '    {NULL, NULL}};'
    done
    cat << 'END'
#endif

const pd_template *pd_templates(int *count)
{
    *count = (int)(sizeof pdi_template_all / sizeof pdi_template_all[0]) - 1;
    return pdi_template_all;
}
END
} > "$new"
if [ "$1" = --check ]; then
    cmp -s "$new" $out && exit
    echo "$out is not made of $folder/: make amalgam"
    exit 1
fi
cmp -s "$new" $out || cp "$new" $out
