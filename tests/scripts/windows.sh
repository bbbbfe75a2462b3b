#!/bin/sh
# slow: weekly
# Windows by mingw-w64 and wine: header and program without a warning, files of a run like those of a native one, paths,
# checkpoints that replace one that is there, a file that another program has open, Ctrl-C.
# Debian: gcc-mingw-w64-x86-64 g++-mingw-w64-x86-64 wine wine64. They take minutes to install, so .ci/run does not.
. tests/lib/script.sh
. tests/lib/pin.sh
cross=x86_64-w64-mingw32
for tool in $cross-gcc $cross-g++ wine; do command -v $tool > /dev/null || skip_all "$tool is not installed"; done
# the headers choose float or double by size in isnan, so that warning is theirs
warn="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-float-conversion -Wno-misleading-indentation -Werror"
WINEPREFIX=$dir/wine WINEDEBUG=-all
export WINEPREFIX WINEDEBUG
cd "$dir" || exit 1

quiet() { "$@" > log 2>&1; }

printf '#define PDCORR_IMPLEMENTATION\n#include "pdcorr_app.h"\n' > unit.cpp
# shellcheck disable=SC2086
{
    check "pd2d.exe as C99" quiet $cross-gcc -std=c99 -O1 -ffp-contract=off $warn \
        -Wstrict-prototypes -Wmissing-prototypes -DPD_DIM=2 -I"$root" "$root/drivers/scene.c" -o pd2d.exe -lm -lpsapi
    check "the header as C++11" quiet $cross-g++ -std=c++11 -O0 $warn -DPD_DIM=2 -I"$root" -c unit.cpp -o unit.o
    for tool in hold interrupt; do
        check "$tool.exe" quiet $cross-gcc -std=c99 $warn "$root/tests/windows/$tool.c" -o $tool.exe
    done
}
quiet wine pd2d.exe --version || skip_all "wine runs no program: $(tail -n 1 log)"

pin > pin.scene

# A native program of the same flags: that of `make` may join or regroup operations.
check "the native program" quiet "${CC:-cc}" -std=c99 -O1 -ffp-contract=off -DPD_DIM=2 -I"$root" \
    "$root/drivers/scene.c" -o native -lm
check "a native run" quiet ./native pin.scene --out native.out --quiet
check "a run" quiet wine pd2d.exe pin.scene --out out --quiet
check "the same files, byte for byte" quiet diff -r native.out out

# runs_into SCENE OUT FOLDER: the run gives the same files in that folder.
runs_into() {
    quiet wine pd2d.exe "$1" --out "$2" --quiet && quiet diff -r -x pdcorr.files -x open_in_paraview.py native.out "$3"
}

check "backslashes and blanks" runs_into pin.scene 'a b\deep er\c' 'a b/deep er/c'
check "a backslash at the end" runs_into pin.scene 'end\' end
check "names in UTF-8, of several scripts" runs_into pin.scene 'größe\日本' größe/日本
check "a drive" runs_into "Z:$(pwd | tr / '\\')\\pin.scene" "Z:$(pwd | tr / '\\')\\drive" drive
printf '[grid] h = 10 um\n' > 'größe.scene'
quiet wine pd2d.exe 'größe.scene' --check
check "a message names the file in UTF-8" grep -q 'größe.scene' log
quiet wine pd2d.exe no.scene --check
check "a file that is missing" grep -q "cannot open 'no.scene'" log

# A file that is there is replaced, unless another program has it open: then it stays.
cp out/C_film.png before.png
wine hold.exe out/C_film.png stop > held &
holder=$!
for turn in $(seq 100); do [ ! -s held ] && sleep 0.1; done
quiet wine pd2d.exe pin.scene --out out --quiet
[ $? = 1 ]
verdict "a file that is open elsewhere: status 1"
check "a file that is open elsewhere: the message" \
    grep -q "cannot put the finished file in place as 'out/C_film.png': another program has it open" log
check "a file that is open elsewhere: it stays" cmp before.png out/C_film.png
touch stop
wait $holder
check "once it is closed" runs_into pin.scene out out

# Ctrl-C behind the first of many checkpoints; then the run goes on and ends with the files of a whole one.
quiet wine interrupt.exe half/checkpoint.bin "pd2d.exe pin.scene --out half --quiet --checkpoint 0.001s \"until=40 h\""
status=$?
if [ $status -ge 90 ]; then
    echo "skipped: wine sends no Ctrl-C here: $status"
    skipped=$((skipped + 1))
else
    verdict "Ctrl-C: status 3, found $status" "$([ $status = 3 ]; echo $?)"
    check "Ctrl-C: a checkpoint" [ -s half/checkpoint.bin ]
    cp half/checkpoint.bin first.bin
    check "the whole run" quiet ./native pin.scene --out whole --quiet "until=40 h"
    check "it goes on" quiet wine pd2d.exe pin.scene --out half --quiet --checkpoint 0.001s --resume "until=40 h"
    check "it goes on: the same files" quiet diff -r -x pdcorr.files whole half
fi
score
