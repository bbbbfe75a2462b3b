#!/bin/sh
# The folder of a run: what the former run of the same name wrote goes and nothing else, that of another run is refused,
# and so is a second run at the same time; runs that were killed block nobody. --check says so beforehand.
. tests/lib/script.sh
cd "$dir" || exit 1

cat > pin.scene << 'END'
[grid]      h = 10 um   m = 3   box = -100 um .. 200 um, -60 um .. 60 um
[shape pin] box = 0 .. 60 um, -20 um .. 20 um   kind = solid   material = mg4ag
[transport] D = 1e-9 m2/s
[dissolve]  rate = 1.3 um/h * (1 - C/Csat)   Csat = 56 mol/m3
[run]       until = 2 h
[output]    every = 1 h   fields = C   images = C
[total all]
END
sed 's/until = 2 h/until = 2000 h   max_step = 1 s/' pin.scene > slow.scene

pd() { "$programs/pd2d" "$@" > stdout 2> stderr; }
# refuses NAME MESSAGE ARGUMENT...: status 2, exactly this line, and the folder `out` as it was.
refuses() {
    name=$1 message=$2
    shift 2
    rm -rf before && cp -r out before
    pd "$@"
    [ $? = 2 ] && [ "$(cat stderr)" = "pd2d: $message" ] && diff -r before out > /dev/null
    said=$?
    { echo "expected $message"; cat stdout stderr; diff -r before out; } > log
    verdict "$name" $said
}

pd pin.scene --out fresh every=30min
pd pin.scene --out out
[ -e out/C_000002_t7200.0s.png ] && [ -e out/corr_000002_t7200.0s.vti ] && [ ! -e out/pdcorr.lock ]
verdict "a first run"
# the list names every file, and no other
(cd out && ls | grep -v pdcorr.files | sort) > there
sed '1,2d' out/pdcorr.files | grep -v '^checkpoint.bin$\|^pictures.bin$' | sort > listed
cmp -s there listed
verdict "the list is that of the files"
echo mine > out/notes.csv
echo mine > out/C_000009_t99.0s.png
pd pin.scene --out out every=30min
grep -q "^note: removed [0-9]* files of the former run from 'out'$" stdout
verdict "it says what it removed"
[ "$(cat out/notes.csv out/C_000009_t99.0s.png)" = "mine
mine" ]
verdict "files that no run wrote stay"
rm out/notes.csv out/C_000009_t99.0s.png
diff -r fresh out > log
verdict "the files are those of a run into an empty folder"

# a list that was written to do harm
echo keep > keep.csv
mkdir out/sub && echo keep > out/sub/a.csv && echo keep > out/thesis.tex
printf '%s\n' ../keep.csv sub/a.csv "$dir/keep.csv" thesis.tex .. . '' >> out/pdcorr.files
pd pin.scene --out out && [ -e keep.csv ] && [ -e out/sub/a.csv ] && [ -e out/thesis.tex ]
verdict "a list removes nothing but files of a run in its folder"
rm -r out/sub out/thesis.tex

# links, pipes and files of a stranger: none is written through, and nothing waits for one
echo precious > victim
# stranger NAME MESSAGE: the run is refused, by --check, too, and leaves what stands in the folder.
stranger() {
    for how in "" --check; do
        pd pin.scene --out strange --quiet $how
        [ $? -gt 0 ] && [ "$(cat stderr)" = "pd2d: $2" ] && [ "$(cat victim)" = precious ]
        verdict "$1 $how: $(cat stderr)"
    done
    rm -rf strange
    mkdir strange
}
alien="folder: 'strange/pdcorr.lock' is a link or holds something else, expected the lock of a run or none: remove it"
mkdir strange
ln -s ../victim strange/pdcorr.lock
stranger "a link as lock" "$alien"
ln -s ../nothing strange/pdcorr.lock
stranger "a link to nothing as lock" "$alien"
[ ! -e nothing ]
verdict "nothing is made behind it"
ln victim strange/pdcorr.lock
stranger "a second name of a file as lock" "$alien"
cp victim strange/pdcorr.lock
stranger "a text as lock" "$alien"
for text in 'x1\n' '1x\n' '1\0002\n' 1234567890123456789012345678901234567890; do
    # shellcheck disable=SC2059
    printf "$text" > strange/pdcorr.lock
    stranger "'$text' as lock" "$alien"
done
printf '12345\n' > strange/pdcorr.lock
pd pin.scene --out strange --quiet --check
verdict "the lock of a run that was killed is taken: $(cat stderr)"
rm -rf strange
mkdir strange
mkfifo strange/pdcorr.lock
stranger "a pipe as lock" "$alien"
mkfifo strange/pdcorr.files
stranger "a pipe as list" "file: cannot open 'strange/pdcorr.files': it is a pipe or a socket, expected a file"
for name in $(cd fresh && ls) pdcorr.files.part diagnostics.csv.part checkpoint.bin checkpoint.bin.part; do
    [ "$name" = pdcorr.files ] || ln -s ../victim "strange/$name"
done
for name in $(cd fresh && ls); do ln -s ../victim "strange/$name.part" 2> /dev/null; done
pd pin.scene --out strange every=30min --checkpoint "0 s" && [ "$(cat victim)" = precious ]
verdict "links in the place of files are replaced: $(cat stderr)"
rm -f strange/*.part
diff -r fresh strange > log && [ -z "$(find strange -type l)" ]
verdict "by the files of a run into an empty folder"
rm -rf strange

# another run
cp pin.scene wire.scene
other="folder: 'out' holds the files of the run 'pin', expected those of 'wire' or none: choose another folder, or \
remove 'out'"
refuses "another run" "$other" wire.scene --out out --quiet
refuses "another run, checked" "$other" wire.scene --out out --quiet --check
printf 'shopping\n' > out/pdcorr.files
refuses "no list" "folder: 'out/pdcorr.files' is not the list of files that a run keeps: remove it" pin.scene \
    --out out --quiet --check
rm -rf out before
sed 's/h = 10 um/h = 10/' pin.scene > bad.scene
pd pin.scene --out out && cp -r out before && pd bad.scene --out out
diff -r before out > log
verdict "a scene that is refused leaves the former run"

# what cannot be a folder
: > file
for path in file file/x /dev/null; do
    pd pin.scene --out $path --quiet --check
    [ $? = 2 ] && [ "$(cat stderr)" = "pd2d: file: cannot make the directory '$path': Not a directory" ]
    verdict "--check --out $path: $(cat stderr)"
done
for path in new new/below ./new "$dir/new/below/"; do
    pd pin.scene --out $path --quiet --check && [ ! -e new ]
    verdict "--check --out $path: $(cat stderr)"
done
mkdir closed && chmod 500 closed
if ! touch closed/x 2> stderr; then
    pd pin.scene --out closed/x --quiet --check
    [ $? = 2 ] && [ "$(cat stderr)" = "pd2d: file: cannot write into the directory 'closed': Permission denied" ]
    verdict "--check in a closed folder: $(cat stderr)"
fi

# two at once; a run that is killed
rm -rf out
"$programs/pd2d" slow.scene --out out --quiet > /dev/null 2>&1 &
first=$!
while [ ! -e out/checkpoint.bin ] && [ ! -s out/diagnostics.csv ] && kill -0 $first 2> /dev/null; do sleep 0.05; done
for how in "" --check --resume; do
    pd slow.scene --out out --quiet $how
    status=$?
    [ $status = 2 ] && [ "$(cat stderr)" = "pd2d: folder: another run (process $first) writes into 'out', expected a \
folder of its own: wait for it or choose another folder; if none runs, remove 'out/pdcorr.lock'" ]
    said=$?
    { echo "status $status"; cat stderr; } > log
    verdict "two runs at once $how" $said
done
kill -0 $first 2> /dev/null
verdict "the first one goes on"
kill -9 $first
wait $first 2> /dev/null
[ -e out/pdcorr.lock ] && pd slow.scene --out out --quiet until=5s
verdict "a killed run blocks nobody: $(cat stderr)"
[ ! -e out/pdcorr.lock ]
verdict "its lock is gone"

# frames behind a checkpoint go when the run goes on, and come again
rm -rf out
"$programs/pd2d" slow.scene --out out --quiet until=30s every=1s --checkpoint "0 s" > /dev/null 2>&1 &
first=$!
while [ ! -e out/C_000004_t4.0s.png ] && kill -0 $first 2> /dev/null; do sleep 0.02; done
kill -INT $first
wait $first
touch out/C_000077_t77.0s.png && echo C_000077_t77.0s.png >> out/pdcorr.files
pd slow.scene --out out --quiet until=30s every=1s --resume --check && [ -e out/C_000077_t77.0s.png ]
verdict "--check --resume reads the checkpoint and writes nothing: $(cat stderr)"
pd slow.scene --out out --quiet until=30s every=1s Csat="55 mol/m3" --resume --check
[ $? = 2 ] && grep -q "out/checkpoint.bin: it is of another scene" stderr
verdict "--check --resume refuses what --resume refuses: $(cat stderr)"
pd slow.scene --out out --quiet until=30s every=1s --resume && [ ! -e out/C_000077_t77.0s.png ]
verdict "frames behind the checkpoint go: $(cat stderr)"
pd slow.scene --out whole --quiet until=30s every=1s && diff -r whole out > log
verdict "the files of a run that was never stopped"

score
