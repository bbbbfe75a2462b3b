#!/bin/sh
# slow: yes
# What a program prints has to arrive: with a full or closed standard output every program says so and ends with 1, and
# the files of its run are whole.
. tests/lib/script.sh
[ -c /dev/full ] || skip_all "there is no /dev/full"
cat > "$dir/slab.scene" << 'END'
[grid]      h = 0.1 m   box = 0 .. 1 m, 0 .. 0.2 m
[side x-]   C = 1 mol/m3
[transport] D = 1 m2/s
[run]       until = 0.1 s
[probe a]   at = 0.5 m, 0.1 m
END

# lost NAME PROGRAM ARGUMENT...: full, then closed.
lost() {
    name=$1
    shift
    message="$(basename "$1"): lines of the standard output are lost: it is closed or full"
    "$@" > /dev/full 2> "$dir/log"
    [ $? = 1 ] && [ "$(tail -n 1 "$dir/log")" = "$message" ]
    verdict "$name into a full disk"
    "$@" >&- 2> "$dir/log"
    [ $? = 1 ] && [ "$(tail -n 1 "$dir/log")" = "$message" ]
    verdict "$name into nothing"
}
for program in pd validate bench stability; do
    for k in 1 2 3; do lost "$program${k}d --help" "$programs/$program${k}d" --help; done
done
for program in validate bench stability; do lost "$program --list" "$programs/${program}2d" --list; done
lost "validate" "$programs/validate2d" patch --quick --quiet
lost "a check" "$programs/pd2d" "$dir/slab.scene" --out "$dir/check" --check
lost "a run" "$programs/pd2d" "$dir/slab.scene" --out "$dir/out" --quiet
"$programs/pd2d" "$dir/slab.scene" --out "$dir/whole" --quiet > "$dir/log" 2>&1 &&
    diff -r "$dir/out" "$dir/whole" > "$dir/log"
verdict "the files of a run whose lines are lost"
"$programs/pd2d" "$dir/slab.scene" --quiet > "$dir/log" 2>&1 --out "$dir/out" until=s
[ $? = 2 ]
verdict "an error keeps its own status"
score
