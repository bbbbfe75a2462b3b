#!/bin/sh
# Rounding decides nothing: scenes that differ in their units, or are turned, mirrored or shifted by whole cells, give
# the same figures. And what lattice and shapes do to each other is told.
. tests/lib/script.sh

# scene NAME: a scene from the standard input.
scene() { cat > "$dir/$1.scene"; }

# alike DIMENSION NAME NAME TOLERANCE KEY[@FACTOR]...: figures of the second, divided by their factors, are those of the
# first, with a relative tolerance.
alike() {
    program=$programs/pd$1d first=$2 second=$3 tolerance=$4
    shift 4
    for name in "$first" "$second"; do
        rm -rf "$dir/out"
        timeout 60 "$program" "$dir/$name.scene" --quiet --threads 1 --out "$dir/out" > "$dir/log" 2>&1
        verdict "$name runs"
        for key in "$@"; do echo "$key $(figure "${key%@*}")"; done > "$dir/$name.found"
    done
    paste -d' ' "$dir/$first.found" "$dir/$second.found" > "$dir/log"
    awk -v tol="$tolerance" '{ split($1, key, "@"); factor = key[2] ? key[2] : 1; a = $2; b = $4 / factor
        e = a - b; e = e < 0 ? -e : e; size = a < 0 ? -a : a
        if ($2 == "" || $4 == "" || !(e <= tol * size)) bad = 1 } END { exit bad || NR == 0 }' "$dir/log"
    verdict "$first and $second are alike"
}

# says NAME TEXT, and not: what pd2d says of a scene.
says() {
    "$programs/pd$1d" "$dir/$2.scene" --check --out "$dir/out" > "$dir/log" 2>&1
    grep -qF -- "$3" "$dir/log"
    verdict "$2 says: $3"
}
silent() {
    "$programs/pd$1d" "$dir/$2.scene" --check --out "$dir/out" > "$dir/log" 2>&1
    ! grep -qF -- "$3" "$dir/log"
    verdict "$2 does not say: $3"
}

# A notch one cell deep beside metal, in two units: lengths by 7, D by 49.
scene notch << 'END'
[grid] h = 1e-6 m box = 0 m .. 10e-6 m, 0 m .. 10e-6 m
[shape m0] box = 1e-6 m .. 4e-6 m, 3e-6 m .. 6e-6 m kind = solid
[shape m1] box = 4e-6 m .. 9e-6 m, 1e-6 m .. 6e-6 m kind = solid
[side x-] C = 1 mol/m3
[side y-] C = 0 mol/m3
[transport] D = 1e-9 m2/s
[dissolve] rate = 1e-30 m/s
[run] until = 4 ms
[output] fields = none
[total all]
END
scene notch_7 << 'END'
[grid] h = 7e-6 m box = 0 m .. 70e-6 m, 0 m .. 70e-6 m
[shape m0] box = 7e-6 m .. 28e-6 m, 21e-6 m .. 42e-6 m kind = solid
[shape m1] box = 28e-6 m .. 63e-6 m, 7e-6 m .. 42e-6 m kind = solid
[side x-] C = 1 mol/m3
[side y-] C = 0 mol/m3
[transport] D = 49e-9 m2/s
[dissolve] rate = 1e-30 m/s
[run] until = 4 ms
[output] fields = none
[total all]
END
alike 2 notch notch_7 1e-8 C_max C_min dissolved@49

# The same turned: the corner of the box, where one side holds 1 and the other 0, belongs to both.
scene notch_turned << 'END'
[grid] h = 1 um box = 0 um .. 10 um, 0 um .. 10 um
[shape m0] box = 3 um .. 6 um, 1 um .. 4 um kind = solid
[shape m1] box = 1 um .. 6 um, 4 um .. 9 um kind = solid
[side y-] C = 1 mol/m3
[side x-] C = 0 mol/m3
[transport] D = 1e-9 m2/s
[dissolve] rate = 1e-30 m/s
[run] until = 4 ms
[output] fields = none
[total all]
END
alike 2 notch notch_turned 1e-8 C_max C_min dissolved

# Metal that meets closed sides, with a law that depends on the fluid, turned, mirrored and in millimetres.
scene corner << 'END'
[grid] h = 1 um box = 0 um .. 9 um, 0 um .. 8 um
[shape m0] box = 0 um .. 3 um, 0 um .. 4 um kind = solid
[shape m1] ball = 6 um, 5 um radius = 2.3 um kind = solid
[shape w] box = 3 um .. 5 um, 0 um .. 1 um kind = wall
[side x+] flow = mirror
[transport] D = 1e-10 m2/s
[dissolve] rate = 0.3 um/s*(1 - C/Csat) Csat = 800 mol/m3
[run] until = 4 s
[output] fields = none
[total all]
END
scene corner_turned << 'END'
[grid] h = 1 um box = 0 um .. 8 um, 0 um .. 9 um
[shape m0] box = 0 um .. 4 um, 0 um .. 3 um kind = solid
[shape m1] ball = 5 um, 6 um radius = 2.3 um kind = solid
[shape w] box = 0 um .. 1 um, 3 um .. 5 um kind = wall
[side y+] flow = mirror
[transport] D = 1e-10 m2/s
[dissolve] rate = 0.3 um/s*(1 - C/Csat) Csat = 800 mol/m3
[run] until = 4 s
[output] fields = none
[total all]
END
scene corner_mirrored << 'END'
[grid] h = 1 mm box = -9 mm .. 0 mm, 0 mm .. 8 mm
[shape m0] box = -3 mm .. 0 mm, 0 mm .. 4 mm kind = solid
[shape m1] ball = -6 mm, 5 mm radius = 2.3 mm kind = solid
[shape w] box = -5 mm .. -3 mm, 0 mm .. 1 mm kind = wall
[side x-] flow = mirror
[transport] D = 1e-4 m2/s
[dissolve] rate = 0.3 mm/s*(1 - C/Csat) Csat = 800 mol/m3
[run] until = 4 s
[output] fields = none
[total all]
END
alike 2 corner corner_turned 1e-7 C_max C_min dissolved volume_loss
alike 2 corner corner_mirrored 1e-7 C_max C_min dissolved@1e6 volume_loss

# Bonds at 45 degrees between an electrode and its partner across one cell, in two units; and electrodes at a side,
# turned.
scene gap << 'END'
[grid] h = 0.1 mm  box = 0 mm .. 1.7 mm, 0 mm .. 1.7 mm
[shape m0] ball = 0.8137 mm, 0.39263437224419526 mm radius = 0.24693437224419524 mm kind = solid material = mg4ag
[shape m1] box = 0.5678535 mm .. 1.34426288 mm, 0.7 mm .. 0.9 mm kind = solid material = steel304
[side x-] flow = mirror
[side x+] flow = mirror
[side y-] flow = mirror
[side y+] flow = mirror
[potential] conductivity = 1 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V resistance = 1e-7 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V resistance = 1e-7 ohm m2 potential = 1 V
[output] fields = none
END
sed 's/ mm/ cm/g; s/1e-7 ohm/1e-6 ohm/' "$dir/gap.scene" | scene gap_10
alike 2 gap gap_10 1e-7 current electrode=m1:least@0.1 electrode=m1:most@0.1
scene side << 'END'
[grid] h = 0.1 mm box = 0 mm .. 1.3 mm, 0 mm .. 1 mm
[shape m0] box = 0 mm .. 0.7 mm, 0.1 mm .. 0.7 mm kind = solid material = mg4ag
[shape m1] box = 0 mm .. 0.395 mm, 0.7567 mm .. 0.9067 mm kind = solid material = steel304
[potential] conductivity = 1 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V resistance = 1e-7 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V resistance = 1e-7 ohm m2 potential = 1 V
[output] fields = none
END
scene side_turned << 'END'
[grid] h = 0.1 mm box = 0 mm .. 1 mm, 0 mm .. 1.3 mm
[shape m0] box = 0.1 mm .. 0.7 mm, 0 mm .. 0.7 mm kind = solid material = mg4ag
[shape m1] box = 0.7567 mm .. 0.9067 mm, 0 mm .. 0.395 mm kind = solid material = steel304
[potential] conductivity = 1 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V resistance = 1e-7 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V resistance = 1e-7 ohm m2 potential = 1 V
[output] fields = none
END
alike 2 side side_turned 1e-8 current electrode=m0:area electrode=m1:area

# Faces through nodes, shifted by whole cells and mirrored.
scene half << 'END'
[grid] h = 2 um box = 0 um .. 40 um
[shape m] box = 5 um .. 17 um kind = solid
[transport] D = 1e-9 m2/s
[dissolve] rate = 1 nm/s
[run] until = 1 s
[output] fields = none
[total all]
END
sed 's/0 um .. 40/20 um .. 60/; s/5 um .. 17/25 um .. 37/' "$dir/half.scene" | scene half_20
sed 's/0 um .. 40 um/0.1*7 um .. 40.7 um/; s/5 um .. 17/5.7 um .. 17.7/' "$dir/half.scene" | scene half_text
sed 's/5 um .. 17/23 um .. 35/' "$dir/half.scene" | scene half_mirrored
for other in half_20 half_text half_mirrored; do
    alike 1 half $other 1e-8 C_max C_min dissolved solid volume_loss
done
says 1 half 'passes through 2 nodes'
says 1 half 'its shape holds 1.2e-05 m and its cells 1.4e-05 m, +16.7 %'

# The volume of shapes and of cells: a disc (to 1e-5), a ring around an axis, and a slab that fits. The disc has
# pi 10^2 = 314.159 cells; they are 316.
scene disc << 'END'
[grid] h = 1 um box = -15 um .. 15 um, -15 um .. 15 um
[shape m] ball = 0 um, 0 um radius = 10 um kind = solid
[transport] D = 1e-9 m2/s
[dissolve] rate = 1 nm/s
[run] until = 1 s
END
says 2 disc 'its shape holds 3.14158e-10 m2 and its cells 3.16e-10 m2, +0.586 %'
scene wire << 'END'
[grid] geometry = axisymmetric h = 4 um box = 0 um .. 40 um, 0 um .. 80 um
[shape m] box = -100 um .. 100 um, 0 um .. 42 um kind = solid
[side x-] flow = mirror
[side x+] flow = mirror
[transport] D = 1e-9 m2/s
[dissolve] rate = 1 nm/s
[run] until = 1 s
END
says 2 wire 'passes through 10 nodes'
says 2 wire '+9.75 %' # (44/42)^2
scene fits << 'END'
[grid] h = 4 um box = 0 um .. 40 um, 0 um .. 80 um
[shape m] box = 8 um .. 20 um, 0 um .. 80 um kind = solid
[transport] D = 1e-9 m2/s
[dissolve] rate = 1 nm/s
[run] until = 1 s
END
silent 2 fits 'whole cells'
silent 2 fits 'passes through'
score
