#!/bin/sh
# What ParaView gets of a run: open_in_paraview.py compiles, and where PD_PARAVIEW names a pvpython or pvbatch it draws;
# VTK for Python (Debian: python3-vtk9) reads fields, units, codes, blanks and times of the files.
. tests/lib/script.sh
find_python 'import sys; assert sys.version_info >= (3, 9)'
[ "$python" ] || skip_all "Python is not installed"
cat > "$dir/bar.scene" << 'END'
[grid]      h = 10 um   box = 0 .. 200 um, 0 .. 100 um
[shape bar] box = 0 .. 200 um, 30 um .. 70 um   kind = solid   material = mg4ag   grain_size = 30 um
[shape lid] box = 150 um .. 200 um, 80 um .. 100 um   kind = wall
[side x-]   ux = 0 um   uy = 0 um
[side x+]   ux = 0.1 um   uy = 0 um
[side y-]   C = 0
[transport] D = 1e-9 m2/s
[dissolve]  rate = 3 um/h
[solid]     E = 45 GPa   nu = 0.3
[run]       until = 2 h
[output]    every = 1 h   fields = C, kind, grain, phase, u, mises   images = none
END
"$programs/pd2d" "$dir/bar.scene" --out "$dir/run" --quiet > "$dir/log" 2>&1
verdict "the run"
check "open_in_paraview.py compiles" $python -m py_compile "$dir/run/open_in_paraview.py"
check "open_in_paraview.py is a file of the run" grep -qx open_in_paraview.py "$dir/run/pdcorr.files"
[ "$(wc -L < "$dir/run/open_in_paraview.py")" -le 120 ]
verdict "lines of open_in_paraview.py"

find_python 'import vtkmodules.vtkIOXML'
if [ "$python" ]; then
    $python - "$dir/run" > "$dir/log" 2>&1 << 'END'
import math, os, re, sys
from vtkmodules.vtkCommonCore import vtkDataArray
from vtkmodules.vtkIOXML import vtkXMLImageDataReader
folder = sys.argv[1]
entries = re.findall('timestep="([^"]*)".*file="([^"]*)"', open(folder + "/simulation.pvd").read())
assert [float(t) for t, _ in entries] == [0.0, 3600.0, 7200.0], entries
for time, name in entries:
    reader = vtkXMLImageDataReader()
    reader.SetFileName(os.path.join(folder, name))
    reader.Update()
    image = reader.GetOutput()
    data, more = image.GetCellData(), image.GetFieldData()
    assert more.GetArray("TimeValue").GetValue(0) == float(time)
    names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
    assert names == ["C", "kind", "grain", "phase", "u", "mises"], names
    assert (data.GetScalars().GetName(), data.GetVectors().GetName()) == ("C", "u")
    units = {n: data.GetArray(n).GetInformation().Get(vtkDataArray.UNITS_LABEL()) for n in names}
    assert units == {"C": "mol/m3", "kind": None, "grain": None, "phase": None, "u": "m", "mises": "Pa"}, units
    def codes(name):
        array = more.GetAbstractArray(name)
        return [array.GetValue(k) for k in range(array.GetNumberOfValues())]
    assert codes("kind_names") == ["outside", "fluid", "metal", "wall"]
    assert codes("phase_names") == ["fluid or wall", "metal"]
    seen = set()
    for cell in range(image.GetNumberOfCells()):
        value = lambda n: data.GetArray(n).GetTuple(cell)
        kind = codes("kind_names")[int(value("kind")[0])]
        seen.add(kind)
        blank = [math.isnan(x) for n in ("u", "mises") for x in value(n)[:2]]
        assert blank == [kind != "metal"] * 3, (cell, kind, value("u"), value("mises"))
        assert (value("grain")[0] >= 0) == (kind == "metal")
        assert value("phase")[0] == (kind == "metal") and math.isfinite(value("C")[0])
    assert seen - {"outside"} == {"fluid", "metal", "wall"}, seen
    low, high = data.GetArray("u").GetFiniteRange(-1)
    assert math.isfinite(low) and math.isfinite(high)
END
    verdict "VTK reads units, codes and blanks"
else
    echo "skipped: VTK for Python is not installed: what it reads"
    skipped=$((skipped + 1))
fi

# draws FIELD: a picture, and the range over all times. PD_PARAVIEW: "xvfb-run -a pvbatch", for example.
draws() {
    rm -f "$dir/picture.png"
    (cd / && timeout 300 $PD_PARAVIEW "$dir/run/open_in_paraview.py" "$dir/picture.png" "$1") > "$dir/log" 2>&1
    [ -s "$dir/picture.png" ] && grep -q "^run: 3 times, $1 from [-0-9.e+]* to [-0-9.e+]*$" "$dir/log"
    verdict "ParaView draws $1"
}
if [ "${PD_PARAVIEW:-}" ]; then
    for field in C mises grain; do draws $field; done
else
    echo "skipped: PD_PARAVIEW names no pvpython: the pictures of ParaView"
    skipped=$((skipped + 1))
fi
score
