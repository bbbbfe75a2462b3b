"""The page of drivers/web in headless Chromium: web.py PAGE REFERENCE FOLDER CHROMIUM CHROMEDRIVER.

REFERENCE holds mg_pin_2d.scene and, in native/, what pd2d has written for it. Screenshots go to FOLDER. Prints a line
for each failure, and "N passed, N failed" in the end.
"""
import csv
import math
import sys
import time
import zipfile
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

CLOSE = 1e-12  # [-] of numbers in tables, over the largest of their column
WAIT = 300.0  # [s]

page, reference, pictures = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3])
chromium, driver_path = sys.argv[4:6]
loads = reference / "downloads"
loads.mkdir()
pictures.mkdir(parents=True, exist_ok=True)
count = {True: 0, False: 0}


def check(text, right):
    count[bool(right)] += 1
    if not right:
        print(f"failed: {text}", flush=True)


def browser():
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for word in ("headless=new", "no-sandbox", "disable-gpu", "disable-dev-shm-usage", "window-size=1440,1100"):
        options.add_argument("--" + word)
    options.add_experimental_option("prefs", {"download.default_directory": str(loads.resolve())})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(driver_path), options=options)


driver = browser()


def script(text, *values):
    return driver.execute_script(text, *values)


def element(name):
    return driver.find_element(By.ID, name)


def text_of(name):
    return script("return document.getElementById(arguments[0]).textContent", name)


def wait(what, limit=WAIT):
    end = time.monotonic() + limit
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(0.1)
    return None


def state():
    return script("return document.body.dataset.state")


def ended():
    return wait(lambda: state() in ("done", "stopped", "failed") and state())


def write(text):
    script("""const e = document.getElementById('editor');
              e.value = arguments[0];
              e.dispatchEvent(new Event('input'))""", text)


def shows(name, part):
    return wait(lambda: part in element(name).get_attribute("aria-label"), 10.0)


def verdict_is(part):
    return wait(lambda: part in text_of("verdict"), 30.0)


def picture(name, width, height):
    driver.set_window_size(width, height)
    script("window.scrollTo(0, 0)")
    time.sleep(0.5)
    driver.save_screenshot(str(pictures / f"{name}.png"))


def loaded(name):
    path = loads / name
    return wait(lambda: path.exists() and not list(loads.glob("*.crdownload")) and path, 30.0)


# ---- comparisons ----


def tables_agree(one, two):
    """Headings alike, numbers close; figures that are rounding alone (a ledger, a flux of nothing) are below 1e-12."""
    rows = [list(csv.reader(line for line in data.decode().splitlines() if line[:1] != "#")) for data in (one, two)]
    if len(rows[0]) != len(rows[1]) or rows[0][0] != rows[1][0]:
        return False
    for column in zip(*(zip(a, b) for a, b in zip(rows[0][1:], rows[1][1:]))):
        numbers = [(float(a), float(b)) for a, b in column]
        size = max([abs(b) for _, b in numbers if math.isfinite(b)] + [1.0])
        for a, b in numbers:
            if not (math.isnan(a) and math.isnan(b)) and not abs(a - b) <= CLOSE * size:
                return False
    return True


def pixels_or_values(path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkPNGReader
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader

    reader = vtkPNGReader() if path.suffix == ".png" else vtkXMLImageDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    out = reader.GetOutput()
    data = out.GetPointData() if path.suffix == ".png" else out.GetCellData()
    return [vtk_to_numpy(data.GetArray(k)).astype(float) for k in range(data.GetNumberOfArrays())]


def files_agree(name, bytes_here, path):
    if bytes_here == path.read_bytes():
        return True
    if path.suffix == ".csv":
        return tables_agree(bytes_here, path.read_bytes())
    if path.suffix not in (".png", ".vti"):
        return False
    here = reference / name
    here.write_bytes(bytes_here)
    close = 2.0 if path.suffix == ".png" else 1e-7  # shades; the values are in single precision
    for a, b in zip(pixels_or_values(here), pixels_or_values(path)):
        size = 1.0 if path.suffix == ".png" else max(abs(b).max(), 1e-300)
        if a.shape != b.shape or abs(a - b).max() > close * size:
            return False
    return True


# ---- what is tried ----


def opens():
    driver.get(page.as_uri())
    check("the page opens with the pin, which can be read", verdict_is("The scene can be read."))
    check("the pin is in the editor", "[shape pin]" in element("editor").get_property("value"))
    names = script("return [...document.getElementById('choice').options].map(o => o.text)")
    check("there are examples and templates", "mg_pin_2d" in names and "pit_2d" in names and len(names) > 15)
    for k, name in enumerate(names):
        script("""document.getElementById('verdict').textContent = '';
                  const c = document.getElementById('choice');
                  c.value = arguments[0];
                  c.dispatchEvent(new Event('change'))""", str(k))
        check(f"{name} can be read", verdict_is("The scene can be read."))
    unnamed = script("""
        const all = document.querySelectorAll('button, a.button, select, input, textarea, canvas[role], pre');
        const named = e => e.textContent.trim() || e.getAttribute('aria-label') || (e.labels && e.labels.length);
        return [...all].filter(e => !named(e)).map(e => e.id)""")
    check(f"everything has a name for screen readers, found {unnamed}", not unnamed)


def marks_errors(text):
    wrong = text.replace("(1 - C/Csat)", "(1 - C/Cxat)")
    line = 1 + wrong[: wrong.index("Cxat")].count("\n")
    column = 1 + len(wrong[: wrong.index("Cxat")].split("\n")[-1])
    write(wrong)
    check("a wrong name is told with line and column", verdict_is(f"Line {line}, column {column}: found 'Cxat'"))
    check("its line is marked", script("return document.querySelector('#gutter b').textContent") == str(line))
    element("verdict").click()
    place = script("const e = document.getElementById('editor'); return e.value.slice(0, e.selectionStart)")
    check("the message leads to its place", wrong.startswith(place) and wrong[len(place):].startswith("Cxat"))
    mark, box = (script("""const r = document.getElementById(arguments[0]).getBoundingClientRect();
                           return [r.top, r.bottom]""", name) for name in ("bubble", "editor"))
    check("the message stands in the editor", element("bubble").is_displayed() and box[0] <= mark[0] <= box[1])
    check("the editor says so", element("editor").get_attribute("aria-invalid") == "true")
    picture("error", 1440, 1100)
    write(text)
    check("the mark goes", verdict_is("The scene can be read.") and not element("mark").is_displayed())
    write(text.replace("[probe top] at = 200 um", "[probe top] at = -600 um"))
    verdict_is("The scene can be read.")
    element("run").click()
    check("what the builders refuse fails the run", ended() == "failed")
    check("and is marked, too", script("return document.querySelector('#gutter b').textContent") == "26")


def runs(text):
    write(text)
    verdict_is("The scene can be read.")
    element("editor").send_keys(Keys.CONTROL, Keys.ENTER)
    begun = time.monotonic()
    check("the pin runs, started by keys", ended() == "done")
    print(f"the pin: {time.monotonic() - begun:.2f} s in the browser", flush=True)
    check("a field was drawn", shows("picture", "C mol/m3 at"))
    check("a curve was drawn", shows("plot", "volume lost"))
    ink = script("""const c = document.getElementById('picture');
                    const pixels = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
                    return new Set(new Uint32Array(pixels.buffer)).size""")
    check("the picture has many colours", ink > 20)
    options = script("return [...document.getElementById('field').options].map(o => o.value)")
    check(f"all fields of the scene can be chosen, found {options}",
          options == ["C", "v", "p", "kind", "grain", "phase", "D", "rate", "density"])
    picture("light", 1440, 1100)
    script("""const f = document.getElementById('field');
              f.value = 'v';
              f.dispatchEvent(new Event('change'))""")
    check("another field is shown", shows("picture", "v m/s at"))
    element("high").send_keys("0.1")
    check("its colours end where they are told", shows("picture", "to 0.1"))
    element("theme").click()
    picture("dark", 1440, 1100)
    picture("phone", 390, 2300)
    wide = script("return document.documentElement.scrollWidth - window.innerWidth")
    check(f"nothing is wider than a phone, found {wide} pixels", wide <= 0)
    element("theme").click()
    driver.set_window_size(1440, 1100)


def downloads():
    element("zip").click()
    path = loaded("mg_pin_2d.zip")
    check("a ZIP comes", path)
    native = reference / "native"
    with zipfile.ZipFile(path) as archive:
        check("the ZIP is whole", archive.testzip() is None)
        here = {name: archive.read(name) for name in archive.namelist()}
    wanted = {entry.name for entry in native.iterdir() if entry.name != "pdcorr.lock"}
    check(f"it holds the files of pd2d: {wanted ^ set(here)}", wanted == set(here))
    same = 0
    for name in sorted(wanted & set(here)):
        same += here[name] == (native / name).read_bytes()
        check(f"{name} is that of pd2d", files_agree(name, here[name], native / name))
    print(f"{same} of {len(wanted)} files are byte for byte those of pd2d", flush=True)
    driver.find_element(By.LINK_TEXT, "diagnostics.csv").click()
    path = loaded("diagnostics.csv")
    check("a single file is the same", path and path.read_bytes() == here["diagnostics.csv"])


def stops(text):
    for was, becomes in (("h = 10 um", "h = 5 um"), ("until = 1 h", "until = 9 h"), ("rtol = 4e-3", "rtol = 1e-4")):
        text = text.replace(was, becomes)
    write(text)
    verdict_is("The scene can be read.")
    element("run").click()
    step = lambda: text_of("steps")
    check("steps are shown", wait(lambda: step() not in ("–", "0"), 120.0))
    element("pause").click()
    wait(lambda: False, 3.0)
    before = step()
    wait(lambda: False, 1.5)
    check("a pause holds the run", state() == "paused" and step() == before)
    element("pause").click()
    check("and it goes on", wait(lambda: step() != before, 60.0))
    element("stop").click()
    check("stop ends it", ended() == "stopped")
    share = script("return document.getElementById('progress').value")
    check("before its time", 0.0 < share < 1.0)
    names = script("return [...document.querySelectorAll('#files a')].map(a => a.textContent)")
    check("with its files", "volume_loss.png" in names and sum(name.endswith(".vti") for name in names) >= 2)


def other_dimensions():
    for name in ("plate_1d", "pit_3d"):
        script("""const c = document.getElementById('choice');
                  c.value = [...c.options].find(o => o.text === arguments[0]).value;
                  c.dispatchEvent(new Event('change'))""", name)
        verdict_is("The scene can be read.")
        element("run").click()
        check(f"{name} runs: {text_of('verdict')}", ended() == "done")
        picture(name, 1440, 1100)


try:
    scene = (reference / "mg_pin_2d.scene").read_text(encoding="utf-8")
    opens()
    script("""const c = document.getElementById('choice');
              c.value = [...c.options].find(o => o.text === 'mg_pin_2d').value;
              c.dispatchEvent(new Event('change'))""")
    marks_errors(scene)
    runs(scene)
    downloads()
    stops(scene)
    other_dimensions()
    asked = script("return performance.getEntriesByType('resource').map(e => e.name)")
    asked = [name for name in asked if not name.startswith(("blob:", "data:"))]
    check(f"nothing is loaded from elsewhere, found {asked}", not asked)
    said = [entry for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    check(f"the console is silent, found {said}", not said)
finally:
    driver.quit()
print(f"{count[True]} passed, {count[False]} failed")
