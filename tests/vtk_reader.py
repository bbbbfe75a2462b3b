"""vtk_reader.py DIRECTORY DIM: open the files of vtk_reader.sh with VTK and compare them with their formulas."""
import os
import sys
import xml.etree.ElementTree

from vtkmodules.vtkCommonCore import vtkCommand, vtkDataArray
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

passed = failed = 0


def check(name, condition, detail=""):
    global passed, failed
    if condition:
        passed += 1
    else:
        failed += 1
        print("%s: failed %s" % (name, detail))


def open_image(path):
    problems = []
    reader = vtkXMLImageDataReader()
    for event in (vtkCommand.ErrorEvent, vtkCommand.WarningEvent):
        reader.AddObserver(event, lambda source, what: problems.append(what))
    check("can read", reader.CanReadFile(path), path)
    reader.SetFileName(path)
    reader.Update()
    check("no complaint of VTK", not problems, str(problems))
    return reader.GetOutput()


def near(a, b):
    return abs(a - b) <= 1e-12 * max(abs(a), abs(b))


def check_frame(path, dim, frame):
    cells = [(7, 5, 4)[d] if d < dim else 1 for d in range(3)]
    thin = min((5e-6, 2.5e-6, 1e-3)[:dim])
    spacing = [(5e-6, 2.5e-6, 1e-3)[d] if d < dim else thin for d in range(3)]
    image = open_image(path)
    data = image.GetCellData()
    check("extent", image.GetExtent() == (0, cells[0], 0, cells[1], 0, cells[2]), str(image.GetExtent()))
    check("spacing", all(map(near, image.GetSpacing(), spacing)), str(image.GetSpacing()))
    check("origin", all(near(image.GetOrigin()[d], -0.1 * (d + 1) if d < dim else 0.0) for d in range(3)))
    count = cells[0] * cells[1] * cells[2]
    check("number of cells", image.GetNumberOfCells() == count)
    time = image.GetFieldData().GetArray("TimeValue")
    check("time", time is not None and time.GetValue(0) == 6.1 * frame)
    expected = [("C", "double", 1), ("C & <half>", "float", 1), ("kind", "unsigned char", 1),
                ("grain", "int", 1), ("v", "double", 3)]
    names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
    check("names", names == [name for name, _, _ in expected], str(names))
    for name, kind, components in expected:
        array = data.GetArray(name)
        check(name + " type", array.GetDataTypeAsString() == kind, array.GetDataTypeAsString())
        check(name + " shape", (array.GetNumberOfComponents(), array.GetNumberOfTuples()) == (components, count))
    check("active", (data.GetScalars().GetName(), data.GetVectors().GetName()) == ("C", "v"))
    units = {name: data.GetArray(name).GetInformation().Get(vtkDataArray.UNITS_LABEL()) for name in names}
    check("units", units == {"C": "mol/m3", "C & <half>": "a<b>&", "kind": None, "grain": None, "v": "m/s"}, str(units))
    codes = image.GetFieldData().GetAbstractArray("kind_names")
    found = [codes.GetValue(k) for k in range(codes.GetNumberOfValues())] if codes else None
    check("codes", found == ["none", "a < b & c", "metal"], str(found))
    wrong = dict.fromkeys(names, 0)
    for cell in range(count):
        i, j, k = cell % cells[0], cell // cells[0] % cells[1], cell // (cells[0] * cells[1])
        value = i + 100 * j + 10000 * k + 0.1 + frame
        wrong["C"] += data.GetArray("C").GetValue(cell) != value
        wrong["C & <half>"] += abs(data.GetArray("C & <half>").GetValue(cell) - value) > 6e-8 * value
        wrong["kind"] += data.GetArray("kind").GetValue(cell) != (i + 2 * j + 3 * k) % 6
        wrong["grain"] += data.GetArray("grain").GetValue(cell) != -i - 1000 * j - 1000000 * k
        vector = tuple((d + 1) * value if d < dim else 0.0 for d in range(3))
        wrong["v"] += data.GetArray("v").GetTuple(cell) != vector
    for name in names:
        check(name + " values", wrong[name] == 0, "%d of %d" % (wrong[name], count))
    # A cell is where its node lies: the centre of cell 0 is half a cell inside the box.
    bounds = image.GetCell(0).GetBounds()
    check("cell 0", near((bounds[0] + bounds[1]) / 2, -0.1 + 2.5e-6), str(bounds))


def main(directory, dim):
    tree = xml.etree.ElementTree.parse(os.path.join(directory, "run.pvd")).getroot()
    check("collection", tree.tag == "VTKFile" and tree.get("type") == "Collection")
    entries = tree.findall("./Collection/DataSet")
    check("entries", len(entries) == 2)
    names = ["corr_000000_t0.0s.vti", "corr_000001_t6.1s.vti"]
    check("files", [entry.get("file") for entry in entries] == names, str([e.get("file") for e in entries]))
    check("times", [float(entry.get("timestep")) for entry in entries] == [0.0, 6.1])
    for frame, entry in enumerate(entries):
        check_frame(os.path.join(directory, entry.get("file")), dim, frame)
    print("%d passed, %d failed" % (passed, failed))
    return failed > 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2])))
