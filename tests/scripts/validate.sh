#!/bin/sh
# slow: yes
# Every validation case on its coarse levels in 1D, 2D and 3D: no goal or guard is missed. And the driver's manners.
# With PD_TEST_ALL=1 those too that take more than four seconds.
. tests/lib/script.sh
long=" plates_2d front_2d crevice_2d toughness_2d pit_2d mineral_2d toughness_3d mineral_3d front_3d migration_3d \
    channel3d_3d perifast_3d cylinder_3d rate_3d reaction_3d "
[ -z "$PD_TEST_ALL" ] || long=

for k in 1 2 3; do
    for name in $("$programs/validate${k}d" --list | cut -d ' ' -f 1); do
        case $long in *" ${name}_${k}d "*) continue ;; esac
        "$programs/validate${k}d" "$name" --quick --check > "$dir/log" 2>&1
        verdict "$name ${k}d"
    done
done

rejects_usage validate2d "no case has the name (--list prints them) poiseuile" poiseuile
rejects_usage validate2d "unknown option --fast" --fast
rejects_usage validate2d "unknown key (m and n can be set): h=1" h=1
rejects_usage validate2d "m expects a number from 1 to 12, found m=30" m=30
rejects_usage validate2d "--threads expects a number from 0 to 1024" --threads
rejects_usage validate2d "--out expects a folder" --out

# The report: a section, its figures and a summary, and the same text again.
"$programs/validate2d" patch --quick --quiet --out "$dir/a" > "$dir/log" 2>&1 &&
    "$programs/validate2d" patch --quick --quiet --out "$dir/b" >> "$dir/log" 2>&1
verdict "report"
for name in patch_2d.md patch_2d_1_errors.png summary_2d.md; do
    [ -s "$dir/a/$name" ] || echo "no $name"
done > "$dir/log"
sed 's/ [0-9.]* |$//' "$dir/a/patch_2d.md" > "$dir/one"
sed 's/ [0-9.]* |$//' "$dir/b/patch_2d.md" > "$dir/two"
cmp "$dir/one" "$dir/two" >> "$dir/log" 2>&1
cmp "$dir/a/summary_2d.md" "$dir/b/summary_2d.md" >> "$dir/log" 2>&1
[ ! -s "$dir/log" ]
verdict "files of the report"
score
