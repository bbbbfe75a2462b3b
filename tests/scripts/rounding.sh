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
[electrode m0] shape = m0 curve = linear E0 = 0 V polarisation_resistance = 1e-7 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V polarisation_resistance = 1e-7 ohm m2 potential = 1 V
[output] fields = none
END
sed 's/ mm/ cm/g; s/1e-7 ohm/1e-6 ohm/' "$dir/gap.scene" | scene gap_10
alike 2 gap gap_10 1e-7 current electrode=m1:least@0.1 electrode=m1:most@0.1

# A gap one cell wide between two pieces of metal, in a plane and in a ring far from its axis: what differs is in
# proportion to the cell over the radius, 1e-5.
scene gap_plane << 'END'
[grid] h = 1 um box = 0 um .. 10 um, 0 um .. 10 um
[shape m0] box = 2 um .. 7 um, 0 um .. 5 um kind = solid
[shape m1] box = 5 um .. 9 um, 6 um .. 9 um kind = solid
[potential] conductivity = 2 S/m
[electrode m0] shape = m0 curve = linear polarisation_resistance = 1e-6 ohm m2 E0 = -0.3 V potential = -0.2 V
[electrode m1] shape = m1 curve = linear polarisation_resistance = 1e-6 ohm m2 E0 = 0.1 V potential = 0.1 V
[side x+] potential = -0.5 V
[side y+] potential = -0.3 V
[output] fields = none
END
scene gap_ring << 'END'
[grid] h = 1 um box = 0 um .. 10 um, 100000 um .. 100010 um geometry = axisymmetric
[shape m0] box = 2 um .. 7 um, 100000 um .. 100005 um kind = solid
[shape m1] box = 5 um .. 9 um, 100006 um .. 100009 um kind = solid
[potential] conductivity = 2 S/m
[electrode m0] shape = m0 curve = linear polarisation_resistance = 1e-6 ohm m2 E0 = -0.3 V potential = -0.2 V
[electrode m1] shape = m1 curve = linear polarisation_resistance = 1e-6 ohm m2 E0 = 0.1 V potential = 0.1 V
[side x+] potential = -0.5 V
[side y+] potential = -0.3 V
[output] fields = none
END
alike 2 gap_plane gap_ring 2e-4 electrode=m0:density electrode=m1:density electrode=m0:most

scene side << 'END'
[grid] h = 0.1 mm box = 0 mm .. 1.3 mm, 0 mm .. 1 mm
[shape m0] box = 0 mm .. 0.7 mm, 0.1 mm .. 0.7 mm kind = solid material = mg4ag
[shape m1] box = 0 mm .. 0.395 mm, 0.7567 mm .. 0.9067 mm kind = solid material = steel304
[potential] conductivity = 1 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V polarisation_resistance = 1e-7 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V polarisation_resistance = 1e-7 ohm m2 potential = 1 V
[output] fields = none
END
scene side_turned << 'END'
[grid] h = 0.1 mm box = 0 mm .. 1 mm, 0 mm .. 1.3 mm
[shape m0] box = 0.1 mm .. 0.7 mm, 0 mm .. 0.7 mm kind = solid material = mg4ag
[shape m1] box = 0.7567 mm .. 0.9067 mm, 0 mm .. 0.395 mm kind = solid material = steel304
[potential] conductivity = 1 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V polarisation_resistance = 1e-7 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V polarisation_resistance = 1e-7 ohm m2 potential = 1 V
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

# What follows compares one direction with its image. Bodies of a union that touch: the face that they share is no
# surface, so that a bond ends where it enters the first of them.
sed 's/<a>/7.1448627867478045e-05 m/g; s/<b>/-0.00028579451146991218 m/g; s/<c>/-0.00014289725573495609 m/g
    s/<d>/0.00021434588360243407 m/g; s/<e>/-7.1448627867478045e-05 m/g; s/<f>/0.00028579451146991218 m/g
    s/<g>/-0.00026586604176627964 m/g; s/<h>/-0.00017135744788665747 m/g; s/<i>/8.7277962393596156e-06 m/g
    s/<j>/0.00013569312018821652 m/g; s/<k>/-0.00014289725573495612 m/g; s/<l>/0.00021434588360243412 m/g
    s/<m>/0.00014289725573495606 m/g' << 'END' | scene touch
[grid] h = <a> m = 2
    box = <b> .. <c>, 0 m .. <d>, <e> .. <f>
[shape m0] box = <g> .. <h>, 0 m .. <a>, <i> .. <j> kind = solid
[shape m1] box = <b> .. <k>, <a> .. <l>, <a> .. <m> kind = solid
[flow] rho = 1000 kg/m3 mu = 0.001 Pa s steady_tolerance = 1e-10
[side x+] flow = inlet profile = uniform mean = 2.6e-07 m/s
[side x-] flow = outlet
[transport] D = 1.9e-11 m2/s
[run] until = 0.01 s
[output] fields = none
[total all]
END
sed 's/<a>/7.1448627867478045e-05 m/g; s/<b>/-0.00028579451146991218 m/g; s/<c>/-0.00014289725573495609 m/g
    s/<d>/0.00021434588360243407 m/g; s/<e>/-0.00026586604176627964 m/g; s/<f>/-0.00017135744788665747 m/g
    s/<g>/-0.00013569312018821652 m/g; s/<h>/-8.7277962393596156e-06 m/g; s/<i>/-0.00014289725573495612 m/g
    s/<j>/0.00021434588360243412 m/g; s/<k>/-0.00014289725573495606 m/g
    s/<l>/-7.1448627867478045e-05 m/g' << 'END' | scene touch_mirrored
[grid] h = <a> m = 2
    box = <b> .. <c>, 0 m .. <d>, <b> .. <a>
[shape m0] box = <e> .. <f>, 0 m .. <a>, <g> .. <h> kind = solid
[shape m1] box = <b> .. <i>, <a> .. <j>, <k> .. <l> kind = solid
[flow] rho = 1000 kg/m3 mu = 0.001 Pa s steady_tolerance = 1e-10
[side x+] flow = inlet profile = uniform mean = 2.6e-07 m/s
[side x-] flow = outlet
[transport] D = 1.9e-11 m2/s
[run] until = 0.01 s
[output] fields = none
[total all]
END
alike 3 touch touch_mirrored 1e-7 energy mx

# The corner of a body lies on a node beside a mirror side: bonds that touch it there end there. Against the whole.
scene corner_node << 'END'
[grid] h = 0.000392741719323221 m m = 1.5
    box = 0.0019637085966161048 m .. 0.0027491920352625465 m, 0.003141933754585768 m .. 0.0039274171932322096 m
[shape m1] box = 0.0021600794562777153 m .. 0.0025528211756009364 m, 0 m .. 0.0033383046142473785 m kind = solid
[side y-] flow = mirror
[flow] rho = 1000 kg/m3 mu = 0.001 Pa s steady_tolerance = 1e-10
[side x+] flow = inlet profile = uniform mean = 5.4e-08 m/s
[side x-] flow = outlet
[transport] D = 1.4e-11 m2/s
[run] until = 0.8 s
[output] fields = none
[total all]
END
sed 's/<a>/0.000392741719323221 m/g; s/<b>/0.0019637085966161048 m/g; s/<c>/0.0027491920352625465 m/g
    s/<d>/0.0023564503159393263 m/g; s/<e>/0.0039274171932322096 m/g; s/<f>/0.0021600794562777153 m/g
    s/<g>/0.0025528211756009364 m/g; s/<h>/0.0029455628949241575 m/g
    s/<i>/0.0033383046142473785 m/g' << 'END' | scene corner_whole
[grid] h = <a> m = 1.5
    box = <b> .. <c>, <d> .. <e>
[shape m1] box = <f> .. <g>, <h> .. <i> kind = solid
[flow] rho = 1000 kg/m3 mu = 0.001 Pa s steady_tolerance = 1e-10
[side x+] flow = inlet profile = uniform mean = 5.4e-08 m/s
[side x-] flow = outlet
[transport] D = 1.4e-11 m2/s
[run] until = 0.8 s
[output] fields = none
[total all]
END
alike 2 corner_node corner_whole 1e-7 energy@2 mx@2

# A medium whose middle is a node, on unequal spacings and in two units: no normal is made of what has cancelled.
sed 's/<a>/5.0605948543910817e-05 m/g; s/<b>/5.6063901004537216e-05 m/g; s/<c>/7.3655493402499195e-05 m/g
    s/<d>/0.00010121189708782163 m/g; s/<e>/0.00025302974271955415 m/g; s/<f>/0.00011212780200907443 m/g
    s/<g>/0.00022425560401814884 m/g; s/<h>/0.00022096648020749758 m/g; s/<i>/0.00015181784563173244 m/g
    s/<j>/0.00030363569126346489 m/g; s/<k>/0.00028031950502268606 m/g
    s/<l>/0.00036837726701249597 m/g' << 'END' | scene medium
[grid] h = <a>, <b>, <c> m = 2
    box = <d> .. <e>, <f> .. <g>, <c> .. <h>
[shape med] box = <i> .. <j>, <b> .. <k>, <c> .. <l> kind = medium D = 3.5482534021771373e-11 m2/s
[side x+] C = 486 mol/m3*(1 + 0.9*sin(0.470537*y/(<b>)))
[transport] D = 2.8650976762964223e-11 m2/s
[run] until = 300 s max_step = 30 s
[output] fields = none
[total all]
END
sed 's/<a>/0.00035424163980737574 m/g; s/<b>/0.00039244730703176051 m/g; s/<c>/0.00051558845381749442 m/g
    s/<d>/0.00070848327961475148 m/g; s/<e>/0.001771208199036879 m/g; s/<f>/0.00078489461406352102 m/g
    s/<g>/0.0015697892281270418 m/g; s/<h>/0.001546765361452483 m/g; s/<i>/0.0010627249194221271 m/g
    s/<j>/0.0021254498388442542 m/g; s/<k>/0.0019622365351588023 m/g
    s/<l>/0.0025786408690124718 m/g' << 'END' | scene medium_7
[grid] h = <a>, <b>, <c> m = 2
    box = <d> .. <e>, <f> .. <g>, <c> .. <h>
[shape med] box = <i> .. <j>, <b> .. <k>, <c> .. <l> kind = medium D = 1.7386441670667974e-09 m2/s
[side x+] C = 486 mol/m3*(1 + 0.9*sin(0.470537*y/(<b>)))
[transport] D = 1.403897861385247e-09 m2/s
[run] until = 300 s max_step = 30 s
[output] fields = none
[total all]
END
alike 3 medium medium_7 1e-8 C_max C_min dissolved@343

# The edge of a medium beside a periodic side and a wall, mirrored: what a wall cuts is made up for by its own image.
scene edge << 'END'
[grid] h = 6.4428970591 um, 8.2798628322 um, 4.0673375256 um m = 2
    box = -12.8857941182 um .. 0 um, -8.2798628322 um .. 8.2798628322 um, -8.1346750512 um .. 0 um
[shape med] kind = medium D = 4.1e-12 m2/s
    box = -7.8561020237 um .. 17.2820830766 um, -10.554887832 um .. 20.699657081 um, -5.8773460716 um .. 7.3215750926 um
[side x-] flow = periodic
[side x+] flow = periodic
[transport] D = 2.9e-11 m2/s initial = 498 mol/m3*(1 + 0.8*sin(0.9*y/(8.2798628322 um)))
[run] until = 0.5 s max_step = 0.05 s
[output] fields = none
[total all]
END
scene edge_mirrored << 'END'
[grid] h = 6.4428970591 um, 8.2798628322 um, 4.0673375256 um m = 2
    box = 0 um .. 12.8857941182 um, -8.2798628322 um .. 8.2798628322 um, -8.1346750512 um .. 0 um
[shape med] kind = medium D = 4.1e-12 m2/s
    box = -17.2820830766 um .. 7.8561020237 um, -10.554887832 um .. 20.699657081 um, -5.8773460716 um .. 7.3215750926 um
[side x-] flow = periodic
[side x+] flow = periodic
[transport] D = 2.9e-11 m2/s initial = 498 mol/m3*(1 + 0.8*sin(0.9*y/(8.2798628322 um)))
[run] until = 0.5 s max_step = 0.05 s
[output] fields = none
[total all]
END
alike 3 edge edge_mirrored 1e-8 C_max C_min

# Bonds that run along the corner of an electrode on a node, turned.
scene run_along << 'END'
[grid] h = 0.35 mm box = 0.35 mm .. 3.15 mm, 0.35 mm .. 2.8 mm
[shape m0] box = 0.525 mm .. 1.75 mm, 0.525 mm .. 1.925 mm kind = solid
[shape m1] box = 2.1 mm .. 3.15 mm, 0.35 mm .. 2.8 mm kind = solid
[potential] conductivity = 0.39 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V polarisation_resistance = 2.3e-4 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V polarisation_resistance = 2.3e-4 ohm m2 potential = 1 V
[output] fields = none
END
scene run_along_turned << 'END'
[grid] h = 0.35 mm box = 0.35 mm .. 2.8 mm, -3.15 mm .. -0.35 mm
[shape m0] box = 0.525 mm .. 1.925 mm, -1.75 mm .. -0.525 mm kind = solid
[shape m1] box = 0.35 mm .. 2.8 mm, -3.15 mm .. -2.1 mm kind = solid
[potential] conductivity = 0.39 S/m
[electrode m0] shape = m0 curve = linear E0 = 0 V polarisation_resistance = 2.3e-4 ohm m2 potential = 0 V
[electrode m1] shape = m1 curve = linear E0 = 0 V polarisation_resistance = 2.3e-4 ohm m2 potential = 1 V
[output] fields = none
END
alike 2 run_along run_along_turned 1e-8 current electrode=m0:area electrode=m1:area

# The largest deviation of the flux, for a stream towards + and towards -: a body with an oblique surface.
scene stream << 'END'
[grid] h = 1 um box = 0 um .. 24 um, 0 um .. 9 um
[shape w] ball = 7 um, 3.2 um radius = 2.7 um kind = wall
[flow] rho = 1000 kg/m3 mu = 0.001 Pa s steady_tolerance = 1e-10
[side x-] flow = inlet profile = uniform mean = 1e-4 m/s
[side x+] flow = outlet
[run] until = 1 ms
[output] fields = none
END
sed 's/side x-/side low/; s/side x+/side x-/; s/side low/side x+/; s/7 um, 3.2/17 um, 3.2/' "$dir/stream.scene" |
    scene stream_back
alike 2 stream stream_back 1e-6 flux_max

# A side that holds what depends on the place meets a mirror side: behind that its places are those before it.
scene held << 'END'
[grid] h = 1 um m = 3 box = 0 um .. 8 um, 0 um .. 6 um
[side x+] C = 1 mol/m3*(1 + y/(2 um))
[side y-] flow = mirror
[transport] D = 1e-9 m2/s
[run] until = 10 ms max_step = 1 ms
[output] fields = none
[total all]
END
scene held_whole << 'END'
[grid] h = 1 um m = 3 box = 0 um .. 8 um, -6 um .. 6 um
[side x+] C = 1 mol/m3*(1 + abs(y)/(2 um))
[transport] D = 1e-9 m2/s
[run] until = 10 ms max_step = 1 ms
[output] fields = none
[total all]
END
alike 2 held held_whole 1e-7 C_max C_min dissolved@2
# Steady flow. What passes the surface of a body in sum is nothing, whichever of its rows comes first.
scene low_ball << 'END'
[grid] h = 1 um box = 0 um .. 24 um, 0 um .. 9 um
[shape b] ball = 12 um, 3 um radius = 2.7 um kind = wall
[flow] rho = 1e-3 kg/m3 mu = 0.001 Pa s steady_tolerance = 1e-10
[side x-] flow = inlet profile = uniform mean = 1e-3 m/s
[side x+] flow = outlet
[output] fields = v, p
[force f] box = 8 um .. 16 um, 0 um .. 8 um balance = no
[probe p] at = 10 um, 6.5 um fields = v, p
END
sed 's/side x-/side x~/; s/side x+/side x-/; s/side x~/side x+/; s/at = 10 um/at = 14 um/' "$dir/low_ball.scene" |
    scene low_ball_mirrored
alike 2 low_ball low_ball_mirrored 1e-8 probes.csv:2@-1 probes.csv:3 probes.csv:4 force_f.csv:2@-1 force_f.csv:3

# Fourth order reads nothing behind the ghosts of an outlet, one cell behind a wall.
scene behind << 'END'
[grid] h = 1 um box = 0 um .. 16 um, 0 um .. 9 um
[shape b] box = 12 um .. 15 um, 3 um .. 5 um kind = wall
[flow] rho = 1000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10 order = 4
[side x-] flow = inlet profile = uniform mean = 1 mm/s
[side x+] flow = outlet
[output] fields = none
[probe p] at = 10.5 um, 6.5 um fields = v, p
END
sed 's/12 um .. 15 um/1 um .. 4 um/; s/at = 10.5 um/at = 5.5 um/
    s/side x-/side x~/; s/side x+/side x-/; s/side x~/side x+/' "$dir/behind.scene" | scene behind_mirrored
alike 2 behind behind_mirrored 1e-8 probes.csv:2@-1 probes.csv:3 probes.csv:4

# A ball that the opening of an inlet touches between two nodes does not end it.
scene opening << 'END'
[grid] m = 3 h = 1 um box = 7 um .. 18 um, 7 um .. 13 um
[shape s0] ball = 15.5 um, 11 um radius = 2 um kind = wall
[shape s1] ball = 14 um, 10.5 um radius = 1.5 um kind = solid
[shape s2] ball = 16.5 um, 12.5 um radius = 1.5 um kind = wall
[flow] rho = 1000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10
[side x+] flow = inlet profile = uniform mean = 1 mm/s
[side x-] flow = outlet
[side y+] flow = mirror
[output] fields = none
[probe p] at = 9.5 um, 8.5 um fields = v, p
END
scene opening_mirrored << 'END'
[grid] m = 3 h = 1 um box = 7 um .. 18 um, 7 um .. 13 um
[shape s0] ball = 9.5 um, 11 um radius = 2 um kind = wall
[shape s1] ball = 11 um, 10.5 um radius = 1.5 um kind = solid
[shape s2] ball = 8.5 um, 12.5 um radius = 1.5 um kind = wall
[flow] rho = 1000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10
[side x-] flow = inlet profile = uniform mean = 1 mm/s
[side x+] flow = outlet
[side y+] flow = mirror
[output] fields = none
[probe p] at = 15.5 um, 8.5 um fields = v, p
END
alike 2 opening opening_mirrored 1e-8 probes.csv:2@-1 probes.csv:3 probes.csv:4

# Bonds that touch a ball half way to a node on another.
scene tangent << 'END'
[grid] h = 1 um, 2 um box = -3 um .. 8 um, 0 um .. 18 um
[shape s0a] ball = 5 um, 8 um radius = 3 um
[shape s0b] ball = 5.5 um, 13 um radius = 2 um
[shape s0] union = s0a, s0b kind = solid
[shape s1] box = 6.5 um .. 10 um, 10 um .. 18 um kind = wall
[shape s2] ball = 3.5 um, 0.5 um radius = 3.5 um kind = wall
[flow] rho = 1000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10 order = 4
[side y+] flow = inlet profile = uniform mean = 1 mm/s
[side y-] flow = outlet
[output] fields = none
[probe p] at = 4.5 um, 11 um fields = v, p
END
scene tangent_mirrored << 'END'
[grid] h = 1 um, 2 um box = -3 um .. 8 um, 0 um .. 18 um
[shape s0a] ball = 5 um, 10 um radius = 3 um
[shape s0b] ball = 5.5 um, 5 um radius = 2 um
[shape s0] union = s0a, s0b kind = solid
[shape s1] box = 6.5 um .. 10 um, 0 um .. 8 um kind = wall
[shape s2] ball = 3.5 um, 17.5 um radius = 3.5 um kind = wall
[flow] rho = 1000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10 order = 4
[side y-] flow = inlet profile = uniform mean = 1 mm/s
[side y+] flow = outlet
[output] fields = none
[probe p] at = 4.5 um, 7 um fields = v, p
END
alike 2 tangent tangent_mirrored 1e-7 probes.csv:2 probes.csv:3@-1 probes.csv:4

# What a node knows does not depend on which axis is the first: gradients in gaps of one cell, fits in wide families.
scene gap_cell << 'END'
[grid] h = 2 um, 0.5 um box = 0 um .. 22 um, 7 um .. 10 um
[shape s0] ball = 11.6 um, 9.3 um radius = 0.6 um kind = wall
[shape s1a] ball = 10.8 um, 9.8 um radius = 1.1 um
[shape s1b] box = 5.2 um .. 8.1 um, 8.8 um .. 9.6 um
[shape s1] union = s1a, s1b kind = wall
[shape s2] box = 12 um .. 19.9 um, 8.4 um .. 9.7 um kind = wall
[flow] rho = 100000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10
[side y+] flow = inlet profile = uniform mean = 1 mm/s
[side y-] flow = outlet
[output] fields = none
[probe p] at = 19 um, 9.75 um fields = v, p
END
scene gap_cell_turned << 'END'
[grid] h = 0.5 um, 2 um box = 7 um .. 10 um, 0 um .. 22 um
[shape s0] ball = 7.7 um, 11.6 um radius = 0.6 um kind = wall
[shape s1a] ball = 7.2 um, 10.8 um radius = 1.1 um
[shape s1b] box = 7.4 um .. 8.2 um, 5.2 um .. 8.1 um
[shape s1] union = s1a, s1b kind = wall
[shape s2] box = 7.3 um .. 8.6 um, 12 um .. 19.9 um kind = wall
[flow] rho = 100000 kg/m3 mu = 1 mPa s steady_tolerance = 1e-10
[side x-] flow = inlet profile = uniform mean = 1 mm/s
[side x+] flow = outlet
[output] fields = none
[probe p] at = 7.25 um, 19 um fields = v, p
END
alike 2 gap_cell gap_cell_turned 1e-7 probes.csv:4
scene wide << 'END'
[grid] m = 2 h = 1 um, 2 um box = 0 um .. 14 um, -3 um .. 9 um
[shape s0] ball = 9.4 um, -1.3 um radius = 3.9 um kind = wall
[shape s1] ball = 4.8 um, 6.4 um radius = 2.7 um kind = wall
[shape s2] box = 7.9 um .. 12.5 um, 3 um .. 6 um kind = wall
[flow] rho = 0.001 kg/m3 mu = 1 mPa s steady_tolerance = 1e-9
[side x+] flow = inlet profile = uniform mean = 1 mm/s
[side x-] flow = outlet
[output] fields = none
[probe p] at = 7.5 um, 6 um fields = v, p
END
scene wide_turned << 'END'
[grid] m = 2 h = 2 um, 1 um box = -3 um .. 9 um, 0 um .. 14 um
[shape s0] ball = -1.3 um, 4.6 um radius = 3.9 um kind = wall
[shape s1] ball = 6.4 um, 9.2 um radius = 2.7 um kind = wall
[shape s2] box = 3 um .. 6 um, 1.5 um .. 6.1 um kind = wall
[flow] rho = 0.001 kg/m3 mu = 1 mPa s steady_tolerance = 1e-9
[side y-] flow = inlet profile = uniform mean = 1 mm/s
[side y+] flow = outlet
[output] fields = none
[probe p] at = 6 um, 6.5 um fields = v, p
END
alike 2 wide wide_turned 1e-6 probes.csv:4
score
