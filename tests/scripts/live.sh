#!/bin/sh
# A run that is watched: --follow, --live, --progress, and the line of progress on a terminal.
. tests/lib/script.sh
cat > "$dir/pin.scene" << 'END'
[grid]      h = 10 um   box = 0 .. 200 um, 0 .. 100 um
[shape pin] box = 0 .. 100 um, 0 .. 100 um   kind = solid   material = mg4ag
[side x+]   C = 0
[transport] D = 1e-9 m2/s
[dissolve]  rate = 3 um/h
[run]       until = 4 h
[output]    every = 1 h   fields = C, kind   images = C
[probe a]   at = 150 um, 50 um   fields = C, kind
[probe m]   at = 50 um, 50 um    fields = C
[total all]
[plane p]   at = x 170 um
END
pd() { "$programs/pd2d" "$dir/pin.scene" "$@"; }

pd --out "$dir/plain" --quiet > "$dir/result" 2> "$dir/log"
verdict "the run without any of it"
pd --out "$dir/csv" --follow --quiet > "$dir/rows.csv" 2> "$dir/stderr"
verdict "--follow --quiet"
check "its result lines are on stderr" grep -q '^result case=pin dim=2' "$dir/stderr"
check "nothing else is" [ "$(grep -vc '^result ' "$dir/stderr")" = 0 ]
diff -r "$dir/plain" "$dir/csv" > "$dir/log"
verdict "it changes no file"
# The rows are those of the tables, each column of which they have. Python's csv module reads them.
if command -v python3 > /dev/null; then
    python3 - "$dir" > "$dir/log" 2>&1 << 'END'
import csv, sys
folder = sys.argv[1]
def table(path):
    lines = [line for line in open(path) if not line.startswith("#")]
    rows = list(csv.reader(lines))
    return {name: [float(row[k]) for row in rows[1:]] for k, name in enumerate(rows[0])}
rows = table(folder + "/rows.csv")
def same(name, values):
    assert rows[name] == values, (name, rows[name], values)
total, plane = table(folder + "/csv/total_all.csv"), table(folder + "/csv/plane_p.csv")
assert len(total["time [s]"]) > 4 and rows["step [-]"] == [float(k) for k in range(len(total["time [s]"]))]
same("time [s]", total.pop("time [s]"))
for name, values in total.items(): same("total.all." + name, values)
plane.pop("time [s]")
for name, values in plane.items(): same("plane.p." + name, values)
assert max(rows["probe.a.C [mol/m3]"]) > 0 and set(rows["probe.a.kind [-]"]) == {1.0}
same("probe.m.C [mol/m3]", [0.0] * len(rows["time [s]"]))  # metal, as in the table
same("probe.m.C [mol/m3]", table(folder + "/csv/probes.csv")["m_C [mol/m3]"])
same("probe.a.C [mol/m3]", table(folder + "/csv/probes.csv")["a_C [mol/m3]"])
dt = rows["dt [s]"]
assert all(abs(b - a - d) <= 1e-9 * b for a, b, d in zip(rows["time [s]"], rows["time [s]"][1:], dt[1:]))
END
    verdict "rows are those of the tables"
fi
pd --out "$dir/text" --follow > "$dir/text.log" 2> "$dir/log"
verdict "--follow"
awk '/^ *time  *step/ { head = NF; getline; units = NF; next } head && !/^[a-z]/ { rows++; if (NF != head) wrong = 1;
     if (width && length($0) != width) wrong = 1; width = length($0) }
     END { exit !(head > 10 && units == head && rows > 4 && !wrong) }' "$dir/text.log"
verdict "--follow prints aligned columns"
check "result lines come behind" sh -c "tail -n 1 '$dir/text.log' | grep -q '^result case=pin dim=2'"

# --live: the last picture under one name, which a viewer always finds whole; the next run removes it.
pd --out "$dir/live" --live --quiet > "$dir/log" 2>&1
verdict "--live"
check "latest_C.png is the last picture" cmp -s "$dir/live/latest_C.png" "$(ls "$dir/live"/C_*.png | tail -n 1)"
check "it is listed once" [ "$(grep -c '^latest_C.png' "$dir/live/pdcorr.files")" = 1 ]
check "nothing is left of writing it" [ ! -e "$dir/live/latest_C.png.part" ]
check "the curve of the loss is that of the run without it" cmp "$dir/live/volume_loss.png" "$dir/plain/volume_loss.png"
check "it is listed once, too" [ "$(grep -c '^volume_loss.png' "$dir/live/pdcorr.files")" = 1 ]
# A run that is killed in its middle leaves a whole curve, and one without --live none.
for live in --live ""; do
    # shellcheck disable=SC2086
    "$programs/pd2d" "$dir/pin.scene" --out "$dir/killed$live" $live --quiet "run.max_step=2 s" > "$dir/log" 2>&1 &
    child=$!
    while kill -0 $child 2> /dev/null && [ ! -e "$(echo "$dir/killed$live"/C_000002_*.png)" ]; do sleep 0.02; done
    kill -KILL $child 2> /dev/null
    wait $child 2> /dev/null
done
check "--live: the curve is there, whole, in the middle of a run" \
    [ "$(tail -c 8 "$dir/killed--live/volume_loss.png" | head -c 4)" = IEND ]
check "the run was not at its end" [ ! -e "$(echo "$dir/killed--live"/C_000004_*.png)" ]
check "without --live there is none" [ ! -e "$dir/killed/volume_loss.png" ]
pd --out "$dir/live" --quiet > "$dir/log" 2>&1
check "the next run removes it" [ ! -e "$dir/live/latest_C.png" ]

# A file gets lines of progress now and then, with all that they should say.
line='^pin \[[#.]*\] *[0-9.]* %  [0-9.]* s.*  step [0-9]*, t = [0-9.]* [a-z]*, dt = [0-9.]* [a-z]*, [0-9.e-]* % lost'
pd --out "$dir/lines" --progress "0 s" > /dev/null 2> "$dir/log"
check "--progress '0 s': lines" [ "$(grep -c "$line" "$dir/log")" -ge 1 ]
check "lines without a control character" [ "$(LC_ALL=C tr -d '\n -~' < "$dir/log" | wc -c)" = 0 ]
for quiet in "--progress off" "--progress 1h" "--progress 0s --quiet"; do
    # shellcheck disable=SC2086
    pd --out "$dir/lines" $quiet > /dev/null 2> "$dir/log"
    check "$quiet: none" [ ! -s "$dir/log" ]
done
for time in 3 "3 m" -1s ""; do
    rejects_usage_here() {
        pd --progress "$time" > "$dir/out" 2> "$dir/log"
        [ $? = 2 ] && grep -q -- "--progress expects a time such as 10 s or 5min, or off" "$dir/log"
    }
    check "--progress '$time' is refused" rejects_usage_here
done
pd --sweep "rate=1, 2 um/h" --follow > /dev/null 2> "$dir/log"
check "--sweep with --follow is refused" [ $? = 2 ]

# On a terminal of 60 columns the line replaces itself and does not wrap.
if command -v python3 > /dev/null; then
    python3 - "$programs/pd2d" "$dir/pin.scene" "$dir/terminal" > "$dir/log" 2>&1 << 'END'
import fcntl, os, pty, struct, sys, termios
pid, fd = pty.fork()
if pid == 0:
    fcntl.ioctl(2, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 60, 0, 0))
    os.execv(sys.argv[1], [sys.argv[1], sys.argv[2], "--out", sys.argv[3], "h=5 um"])
text = b""
while True:
    try:
        piece = os.read(fd, 65536)
    except OSError:
        break
    if not piece:
        break
    text += piece
assert os.waitpid(pid, 0)[1] == 0
lines = [part.split(b"\x1b[K")[0] for part in text.split(b"\r") if b"\x1b[K" in part]
assert lines, text
assert all(len(line) <= 59 for line in lines), lines
assert any(b"step " in line for line in lines), lines
END
    verdict "the line of progress on a terminal"
fi

# A run that is stopped and goes on prints the rows of one that was not, the last of the first part twice.
: > "$dir/first.csv"
"$programs/pd2d" "$dir/pin.scene" --out "$dir/half" --follow --quiet --checkpoint "0 s" "run.max_step=1 min" \
    >> "$dir/first.csv" 2> "$dir/log" &
child=$!
while kill -0 $child 2> /dev/null && [ "$(wc -l < "$dir/first.csv")" -lt 6 ]; do sleep 0.05; done
kill -TERM $child 2> /dev/null
wait $child
if [ $? = 3 ]; then
    "$programs/pd2d" "$dir/pin.scene" --out "$dir/half" --follow --quiet "run.max_step=1 min" --resume \
        > "$dir/second.csv" 2> "$dir/log"
    verdict "--follow --resume"
    "$programs/pd2d" "$dir/pin.scene" --out "$dir/one" --follow --quiet "run.max_step=1 min" \
        > "$dir/one.csv" 2> "$dir/log"
    { cat "$dir/first.csv"; sed 1,2d "$dir/second.csv"; } | cmp - "$dir/one.csv" > "$dir/log" 2>&1
    verdict "rows before and behind a stop"
    check "it goes on with the row that was last" grep -qxF "$(sed -n 2p "$dir/second.csv")" "$dir/first.csv"
fi
score
