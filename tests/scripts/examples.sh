#!/bin/sh
# slow: yes
# Every program of examples/ compiles alone with pdcorr.h, without a warning, and runs, linked to the library.
. tests/lib/script.sh
cc=${CC:-cc}
# takes NAME: the file under examples/ that the program reads, if it reads any.
takes() {
    case $1 in *mesh) echo ring.msh ;; *own_physics) echo 11_own_physics.scene ;; *) echo scenes/mg_pin_2d.scene ;; esac
}
for file in examples/*.c; do
    name=$(basename "$file" .c)
    # warnings of the header are those of check-compilers, those of the example come below
    "$cc" -std=c99 -fsyntax-only -Werror ${OMP:-} -I. "$file" > "$dir/log" 2>&1
    verdict "$file alone"
    dim=$(sed -n 's/^#define PD_DIM \([123]\).*/\1/p' "$file")
    linked "$dim"
    # shellcheck disable=SC2086
    "$cc" -std=c99 -O2 -Wall -Wextra -Wpedantic -Werror -DPDCORR_LINKED ${OMP:-} -I. "$file" $library \
        -o "$dir/$name" -lm > "$dir/log" 2>&1 &&
        (cd "$dir" && "./$name" "$root/examples/$(takes "$name")") >> "$dir/log" 2>&1
    verdict "$file"
done
score
