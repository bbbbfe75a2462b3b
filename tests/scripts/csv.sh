#!/bin/sh
# All tables of a run have one style: a line of names with units, then rows, nothing else. Python's csv module reads
# them and, where it is there, pandas without an option (Debian: python3-pandas).
. tests/lib/script.sh
find_python 'import pandas'
[ "$python" ] || echo "skipped: pandas for Python is not installed: what it reads"
[ "$python" ] || find_python 'import csv'
[ "$python" ] || skip_all "Python is not installed"
cd "$dir" || exit 1
printf '# measured by no one\ntime [h],loss [%%]\n1, 3\n\n# late\n2,6.5\n' > points.csv
cat > pin.scene << 'END'
[grid]       h = 10 um   box = 0 .. 200 um, 0 .. 100 um
[shape pin]  box = 0 .. 100 um, 0 .. 100 um   kind = solid   material = mg4ag
[side x+]    C = 0
[transport]  D = 1e-9 m2/s
[dissolve]   rate = 3 um/h
[run]        until = 3 h
[output]     every = 1 h   fields = C   images = none
[probe a]    at = 150 um, 50 um   fields = C, kind, density
[total all]
[plane p]    at = x 170 um
[line l]     from = 10 um, 50 um   to = 190 um, 50 um   points = 7   fields = C, kind
[transfer t] box = 0 .. 200 um, 0 .. 100 um   along = y   reference_length = 100 um
            surface = 56 mol/m3   fluid = 0 mol/m3
[measured m] file = points.csv   value = loss in %
END
"$programs/pd2d" pin.scene --out out --quiet > log 2>&1
verdict "the run, with points that have comments"
"$programs/pd2d" pin.scene --out study --sweep "rate=1, 2 um/h" --sweep "plane.p.at=x 170 um, x 180 um" > log 2>&1
verdict "the sweep"
"$python" - out/*.csv study/sweep.csv study/run001/*.csv > log 2>&1 << 'END'
import csv, math, re, sys
try:
    import pandas
except ImportError:
    pandas = None
assert len(sys.argv) > 12, sys.argv
for path in sys.argv[1:]:
    with open(path, newline="", encoding="ascii") as file:
        rows = list(csv.reader(file))
    names, rows = rows[0], rows[1:]
    assert rows and all(len(row) == len(names) for row in rows), path
    assert len(set(names)) == len(names)
    numbers = not path.endswith("sweep.csv")
    for name in names:
        assert not numbers or re.fullmatch(r"[A-Za-z_][A-Za-z_0-9]* \[[A-Za-z0-9/% -]+\]", name), (path, name)
    if numbers:
        values = [[float(field) for field in row] for row in rows]
    if pandas is None:
        continue
    table = pandas.read_csv(path)
    assert list(table.columns) == names and len(table) == len(rows), path
    if numbers:
        assert all(kind.kind in "fi" for kind in table.dtypes), (path, table.dtypes)
        for k, row in enumerate(values):
            assert all(a == b or abs(a - b) <= 1e-12 * abs(b) or (math.isnan(a) and math.isnan(b))
                       for a, b in zip(table.iloc[k], row)), (path, k, list(table.iloc[k]), row)
END
verdict "one style of tables"
check "diagnostics" grep -q '^time \[s\],volume_loss \[-\],' out/diagnostics.csv
check "probes" [ "$(head -n 1 out/probes.csv)" = 'time [s],a_C [mol/m3],a_kind [-],a_density [kg/m3]' ]
# A run that is stopped after each row goes on with the tables, byte for byte.
for k in 1 2 3 4 5 6 7 8; do
    timeout -s TERM 0.2 "$programs/pd2d" pin.scene "run.max_step=20 s" --out cut --checkpoint "0 s" --quiet \
        $([ $k = 1 ] || [ ! -e cut/checkpoint.bin ] || echo --resume) > log 2>&1
    [ $? = 0 ] && break
done
[ ! -e cut/checkpoint.bin ] || "$programs/pd2d" pin.scene "run.max_step=20 s" --out cut --quiet --resume > log 2>&1
"$programs/pd2d" pin.scene "run.max_step=20 s" --out whole --quiet > log 2>&1
for table in diagnostics probes total_all plane_p; do
    check "$table.csv of a run in pieces" cmp -s cut/$table.csv whole/$table.csv
done
score
