"""Tests of the package. PDCORR_LIBRARY: folder of the shared libraries; PDCORR_PROGRAMS: of pd2d; CC: a C compiler."""
import gc
import importlib.util
import os
import pickle
import shlex
import signal
import subprocess
import sys
import tarfile
import tempfile
import threading
import time
import unittest
import unittest.mock
from ctypes import Structure, sizeof
from pathlib import Path

import numpy as np

import pdcorr
from pdcorr import _declared
from pdcorr._library import Context, load

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PROGRAMS = os.environ.get("PDCORR_PROGRAMS", "")
UM, HOUR = 1e-6, 3600.0


def setUpModule() -> None:
    """Ctrl-C is heard: a shell that starts the tests in the background leaves it ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def has(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


PIN = """
[grid]      h = 10 um   box = -100 um .. 300 um, -100 um .. 100 um
[shape pin] box = 0 .. 200 um, -40 um .. 40 um   kind = solid   material = mg4ag
[side x-]   flow = inlet   profile = parabola   mean = 0.05 m/s   C = 0
[side x+]   flow = outlet   p = 0
[flow]      rho = 1000 kg/m3   mu = 1e-3 Pa s   steady_tolerance = 1e-6
[transport] D = 1e-9 m2/s
[dissolve]  rate = 1.21 um/h * (1 - C/Csat)   Csat = 56.1 mol/m3
[run]       until = 4 h
[output]    every = 1 h   fields = C, v   images = C
[total all] box = -100 um .. 300 um, -100 um .. 100 um
"""

# Metal in fluid at rest, which dissolves at a speed that no concentration changes.
PLATE = """
[grid]        h = 5 um   box = 0 um .. 400 um
[shape plate] box = 0 um .. 200 um   kind = solid   material = mg4ag
[side x-]     flow = mirror
[transport]   D = 1e-9 m2/s
[dissolve]    rate = 3 um/h
[run]         until = 20 h
[output]      every = 5 h
"""

# Diffusion from a side that holds a concentration.
SLAB = """
[grid]      h = 2 um   box = 0 um .. 100 um
[side x-]   C = 1 mol/m3
[transport] D = 1e-9 m2/s   initial = 0 mol/m3
[run]       until = 2 s   rtol = 1e-4
"""


class Declarations(unittest.TestCase):
    """What declare.py has written, against the compiler."""

    @unittest.skipUnless(has("pycparser"), "pycparser is not installed")
    def test_up_to_date(self):
        command = [sys.executable, HERE / "declare.py", "--check"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_layout(self):
        for dim in (1, 2, 3):
            types = vars(load(dim).types)
            structs = [t for t in types.values() if isinstance(t, type) and issubclass(t, Structure)]
            self.assertGreater(len(structs), 100)
            wanted = {t.__name__: sizeof(t) for t in structs}
            wanted |= {f"{t.__name__}.{name}": getattr(t, name).offset for t in structs for name, _ in t._fields_}
            wanted |= {f"{t.__name__}:{name}": getattr(t, name).size for t in structs for name, _ in t._fields_}
            constants = {name: v for name, v in {**vars(_declared), **types}.items()
                         if name.startswith("PD_") and isinstance(v, int)}
            self.assertGreater(len(constants), 200)
            lines = [f'printf("{key} %lld\\n", (long long){self.c_value(key)});' for key in [*wanted, *constants]]
            head = ['#include "pdcorr_app.h"', "#include <stdio.h>", "int main(void)", "{"]
            program = "\n".join([*head, *lines, "return 0;", "}", ""])
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder, "layout.c")
                path.write_text(program, encoding="utf-8")
                compiler = shlex.split(os.environ.get("CC", "cc"))
                binary = path.with_suffix("")
                subprocess.run([*compiler, "-std=c99", f"-DPD_DIM={dim}", f"-I{ROOT}", path, "-o", binary], check=True)
                said = subprocess.run([binary], check=True, capture_output=True, text=True).stdout
            found = {key: int(value) for key, value in (line.rsplit(" ", 1) for line in said.splitlines())}
            self.assertEqual(found, {**wanted, **constants})

    @staticmethod
    def c_value(key: str) -> str:
        if "." in key:
            return "offsetof({}, {})".format(*key.split("."))
        if ":" in key:
            return "sizeof((({} *)0)->{})".format(*key.split(":"))
        return key if key.startswith("PD_") else f"sizeof({key})"

    def test_every_function_is_there(self):
        for dim in (1, 2, 3):
            library = load(dim)
            for name in library.types.functions:
                self.assertTrue(callable(getattr(library, name)), name)


class Steps(unittest.TestCase):
    """Sim against closed forms and against whole runs."""

    def test_front_of_constant_speed(self):
        with pdcorr.Sim(PLATE) as sim:
            self.assertEqual((sim.dim, sim.shape, sim.until, sim.every), (1, (80,), 20 * HOUR, 5 * HOUR))
            losses = [(frame.time, frame.volume_loss) for frame in sim]
            self.assertEqual([t for t, _ in losses], [k * 5 * HOUR for k in range(5)])
            for t, loss in losses:
                self.assertAlmostEqual(loss, 3 * UM / HOUR * t / (200 * UM), delta=1e-9)
            ledger = sim.ledgers["metal"]
            self.assertLess(sim.imbalance, 1e-12)
            self.assertAlmostEqual(ledger.dissolved + ledger.solid, ledger.start, delta=1e-9 * ledger.start)

    def test_diffusion_into_a_slab(self):
        from math import erfc, sqrt

        with pdcorr.Sim(SLAB) as sim:
            sim.run_to(2.0)
            exact = np.array([erfc(x / sqrt(4 * 1e-9 * 2.0)) + erfc((200 * UM - x) / sqrt(4 * 1e-9 * 2.0))
                              for x in sim.axes[0]])
            self.assertLess(np.abs(sim.field("C") - exact).max(), 2e-3)

    def test_frames(self):
        with pdcorr.Sim(PIN) as sim:
            frames = list(sim.frames([0.0, HOUR, 1.5 * HOUR], fields=["C"]))
            self.assertEqual([f.time for f in frames], [0.0, HOUR, 1.5 * HOUR])
            self.assertEqual(frames[0].field("C").max(), 0.0)
            self.assertGreater(frames[1].field("C").max(), 0.0)
            with self.assertRaisesRegex(ValueError, "moved on"):
                frames[0].field("v")
            with self.assertRaisesRegex(ValueError, "times: found 0 s"):
                next(sim.frames([0.0]))

    def test_same_bits_as_a_run(self):
        seen = []
        result = pdcorr.run(PIN, dry=True, progress=seen.append)
        with pdcorr.Sim(PIN) as sim:
            for _ in sim:
                pass
            self.assertEqual((sim.time, sim.steps, sim.volume_loss), (result.time, result.steps, result.volume_loss))
        self.assertTrue(any("D = 1e-09" in line for line in result.summary), result.summary)
        self.assertIn("volume_loss=", result.line)

    def test_an_observer(self):
        with pdcorr.Sim(PIN) as sim:
            for _ in sim:
                pass
            last = {"C": sim.field("C"), "v": sim.field("v"), "loss": sim.volume_loss, "steps": sim.steps}
        seen, kept = [], []

        def watch(at):
            seen.append((at.when, at.steps, at.time, at.dt, at.figures["volume_loss"] - at.volume_loss))
            if at.when == "end":
                np.testing.assert_array_equal(at.field("C"), last["C"])
                np.testing.assert_array_equal(at.field("v"), last["v"])
                with self.assertRaisesRegex(pdcorr.Error, "no field has the name q"):
                    at.field("q")
                kept.append(at)

        result = pdcorr.run(PIN, dry=True, observe=watch)
        self.assertEqual((result.volume_loss, result.steps), (last["loss"], last["steps"]))
        self.assertEqual([when for when, *_ in seen], ["start", *["step"] * result.steps, "end"])
        self.assertEqual([steps for _, steps, *_ in seen[1:-1]], list(range(1, result.steps + 1)))
        self.assertEqual({difference for *_, difference in seen}, {0.0})
        with self.assertRaisesRegex(ValueError, "the instant is over"):
            kept[0].field("C")
        stopped = pdcorr.run(PIN, dry=True, observe=lambda at: at.steps == 2)
        self.assertEqual((stopped.stopped, stopped.steps), (True, 2))
        with self.assertRaisesRegex(ZeroDivisionError, "division"):
            pdcorr.run(PIN, dry=True, observe=lambda at: 1 / (at.steps - 1) > 2)

    @unittest.skipUnless(PROGRAMS, "PDCORR_PROGRAMS names no folder of pd2d")
    def test_same_files_as_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder, "pin.scene")
            scene.write_text(PIN, encoding="utf-8")
            result = pdcorr.run(scene, {"run.until": "2 h"}, h="20 um", out=Path(folder, "here"))
            subprocess.run([Path(PROGRAMS, "pd2d"), scene, "run.until=2 h", "h=20 um", "--out", Path(folder, "there")],
                           check=True, capture_output=True)
            names = sorted(p.name for p in Path(folder, "there").iterdir())
            self.assertEqual(names, sorted(p.name for p in Path(folder, "here").iterdir()))
            self.assertGreater(len(names), 5)
            for name in names:
                here, there = (Path(folder, way, name).read_bytes() for way in ("here", "there"))
                self.assertEqual(here, there, name)
            tables = result.tables
            table = tables["total_all"] if "total_all" in tables else next(iter(tables.values()))
            self.assertEqual(table["time"][-1], 2 * HOUR)
            self.assertEqual(table.unit("time"), "s")
            self.assertEqual(table.array.shape, (len(table["time"]), len(table)))

    def test_overrides(self):
        with pdcorr.Sim(PIN, {"grid.box": "-100 um .. 300 um, -60 um .. 60 um"}, h=["10 um", "20 um"]) as sim:
            self.assertEqual(sim.shape, (40, 6))
            np.testing.assert_allclose(sim.h, (10 * UM, 20 * UM))
            np.testing.assert_allclose(sim.box, ((-100 * UM, 300 * UM), (-60 * UM, 60 * UM)))
            np.testing.assert_allclose(sim.axes[1], np.array([-50, -30, -10, 10, 30, 50]) * UM)
        with self.assertRaisesRegex(TypeError, "h: found dict"):
            pdcorr.Sim(PIN, h={})

    def test_dimension(self):
        with pdcorr.Sim(SLAB, {"grid.box": "0 um .. 40 um, 0 um .. 20 um"}) as sim:
            self.assertEqual(sim.shape, (20, 10))
        with self.assertRaisesRegex(ValueError, "expected dim=1, 2 or 3"):
            pdcorr.Sim("dx = 5e-6\nR_wire = 0\n")
        with self.assertRaisesRegex(pdcorr.Error, "pd2d and pd3d run scenes in 2D and 3D"):
            pdcorr.Sim(PIN, dim=1)
        with self.assertRaisesRegex(ValueError, "dim: found 4"):
            pdcorr.Sim(PIN, dim=4)


class Fields(unittest.TestCase):
    """Arrays over memory of the library."""

    def test_shapes_and_strides(self):
        flow = ("[side x-] flow = inlet  profile = uniform  mean = 0.01 m/s\n[side x+] flow = outlet\n"
                "[flow] rho = 1000 kg/m3  mu = 1e3 Pa s\n")
        start = {1: "x/(1 m)", 2: "x/(1 m) + 10*y/(1 m)", 3: "x/(1 m) + 10*y/(1 m) + 100*z/(1 m)"}
        sizes = (6, 4, 5)
        for dim in (1, 2, 3):
            box = ", ".join(f"0 m .. {n} m" for n in sizes[:dim])
            scene = (f"[grid] h = 1 m  box = {box}\n" + (flow if dim > 1 else "") +
                     f"[transport] D = 1e-9 m2/s  initial = ({start[dim]}) * 1 mol/m3\n[run] until = 1 s\n")
            with pdcorr.Sim(scene) as sim:
                c = sim.field("C")
                self.assertEqual((sim.dim, c.shape, c.dtype), (dim, sizes[:dim], np.float64))
                self.assertEqual(c.strides, (8, 48, 192)[:dim])
                places = np.meshgrid(*sim.axes, indexing="ij")
                np.testing.assert_allclose(c, sum(10**d * places[d] for d in range(dim)), rtol=1e-14)
                self.assertFalse(c.flags.owndata)
                self.assertEqual(sim.label("C"), "C [mol/m3]")
                if dim > 1:
                    v = sim.field("v")
                    self.assertEqual(v.shape, (dim, *sizes[:dim]))
                    self.assertAlmostEqual(v[0, 0].mean(), 0.01, delta=2e-3)
                    self.assertLess(np.abs(v[1, 3]).max(), v[0, 3].max())

    def test_a_field_stays_what_it_was(self):
        sim = pdcorr.Sim(PIN)
        context = sim._context
        before = sim.field("C")
        sim.run_to(HOUR)
        after = sim.field("C")
        copy = after.copy()
        self.assertEqual(before.max(), 0.0)
        sim.close()
        sim.close()
        np.testing.assert_array_equal(after, copy)
        self.assertEqual(context.in_use, before.nbytes + after.nbytes)
        part = after[3:5]
        del after, before
        gc.collect()
        self.assertEqual(context.in_use, copy.nbytes)
        np.testing.assert_array_equal(part, copy[3:5])
        del part
        gc.collect()
        self.assertEqual(context.in_use, 0)

    def test_memory_is_free_in_the_end(self):
        sim = pdcorr.Sim(PIN, functions={"rate": lambda C: 1e-10})
        context = sim._context
        self.assertGreater(context.in_use, 100000)
        sim.step()
        del sim
        gc.collect()
        self.assertEqual(context.in_use, 0)
        with pdcorr.Sim(PIN) as sim:
            list(sim.frames([HOUR], fields=["C", "v"]))
        self.assertEqual(sim.in_use, 0)
        with self.assertRaisesRegex(ValueError, "closed"):
            sim.step()
        self.assertEqual(repr(sim), "<Sim: closed>")

    def test_no_memory_leaks_where_building_fails(self):
        contexts = []

        def make(*arguments):
            contexts.append(Context(*arguments))
            return contexts[-1]

        with unittest.mock.patch("pdcorr.sim.Context", make):
            for arguments, status in (({"m": "0.3"}, "PD_ERR_PARSE"), ({"memory_limit": 200000}, "PD_ERR_LIMIT"),
                                      ({"h": "7 um"}, "PD_ERR_ARGUMENT")):
                with self.assertRaises(pdcorr.Error) as caught:
                    pdcorr.Sim(PIN, **arguments)
                self.assertEqual(caught.exception.status, pdcorr.Status[status])
                with self.assertRaises(pdcorr.Error):
                    pdcorr.run(PIN, dry=True, **arguments)
        gc.collect()
        self.assertEqual([context.in_use for context in contexts], [0] * 6)


class Errors(unittest.TestCase):
    """Messages of the library, and of the package."""

    def test_messages(self):
        wrong = pdcorr.Status.PD_ERR_ARGUMENT
        for scene, status, message in (
                ("nowhere.scene", pdcorr.Status.PD_ERR_FILE, "nowhere.scene: there is no such file"),
                ("[grid] h = 1 um  box = 0 um .. 9 um\n[gird]\n", wrong, "scene:2: .*gird"),
                (PIN + "[probe p] at = 1 m, 0 m  fields = C\n", wrong, "scene:12: at: found 1 m on axis x")):
            with self.assertRaisesRegex(pdcorr.Error, message) as caught:
                pdcorr.Sim(scene)
            self.assertEqual(caught.exception.status, status)
        again = pickle.loads(pickle.dumps(caught.exception))
        self.assertEqual((str(again), again.status), (str(caught.exception), caught.exception.status))

    def test_wrong_calls(self):
        with pdcorr.Sim(PIN) as sim:
            with self.assertRaisesRegex(pdcorr.Error, "no field has the name q"):
                sim.field("q")
            with self.assertRaisesRegex(pdcorr.Error, "a time ahead"):
                sim.step(-1.0)
            sim.step()  # they have not spoilt it
        for arguments in ({"threads": -1}, {"threads": 1.5}, {"memory_limit": -1}):
            with self.assertRaisesRegex(ValueError, next(iter(arguments))):
                pdcorr.Sim(PIN, **arguments)

    def test_tables(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "t.csv")
            path.write_text('# from\n"time [s]",a [-],a [m]\n0,1,nan\n1,2e-3,4\n', encoding="utf-8")
            table = pdcorr.read_table(path)
            self.assertEqual(list(table), ["time [s]", "a [-]", "a [m]"])
            np.testing.assert_array_equal(table["time"], [0, 1])
            np.testing.assert_array_equal(table["a [-]"], [1, 2e-3])
            self.assertEqual(table.unit("a [m]"), "m")
            for key in ("a", "b"):
                with self.assertRaisesRegex(KeyError, "expected one of time"):
                    table[key]
            for text, message in (("", "no headings"), ("a,b\n1\n", ":2: found 1 fields"),
                                  ("a,b\n1,c\n", ":2: found 'c'"), ("a,a\n1,2\n", "twice")):
                path.write_text(text, encoding="utf-8")
                with self.assertRaisesRegex(ValueError, message):
                    pdcorr.read_table(path)


class Chemistry(unittest.TestCase):
    """Electrolytes, and species of a run as fields."""

    FLUIDS = ROOT / "examples" / "electrolytes"

    def test_speciate(self):
        """Water over brucite, and saline that takes up a base, as in the tables of the guide."""
        water = pdcorr.speciate(self.FLUIDS / "brucite.electrolyte", {"species.Mg(OH)2(s).initial": "10 mM"})
        self.assertAlmostEqual(water.ph, 10.396, delta=1e-3)
        self.assertAlmostEqual(water.species["Mg2+"], 0.1221, delta=1e-4)
        self.assertAlmostEqual(water.saturation["Mg(OH)2(s)"], 0.0, delta=1e-9)
        self.assertAlmostEqual(water.minerals["Mg(OH)2(s)"] + water.species["Mg2+"] + water.species["MgOH+"], 10.0)
        self.assertAlmostEqual(water.activity["H+"], 10.0 ** -water.ph)
        for added, ph in ((0.0, 7.0), (0.05, 9.699), (0.5, 10.699), (5.0, 11.699)):
            saline = pdcorr.speciate(self.FLUIDS / "saline.electrolyte", {"chemistry.activity": "ideal"},
                                     add={"Na+ + OH-": added})
            self.assertAlmostEqual(saline.ph, ph, delta=1e-3)
            self.assertAlmostEqual(saline.charge, 0.0, delta=1e-9)
        text = "[species H+]\n[species OH-]\n[reaction water] H2O = H+ + OH-  log10_K = -14\n"
        self.assertAlmostEqual(pdcorr.speciate(text).ph, 7.0, delta=1e-6)

    def test_refusals(self):
        with self.assertRaisesRegex(pdcorr.Error, "no such file"):
            pdcorr.speciate("nowhere.electrolyte")
        with self.assertRaisesRegex(pdcorr.Error, "charge"):
            pdcorr.speciate(self.FLUIDS / "saline.electrolyte", {"species.Na+.initial": "1 mM"})
        with self.assertRaisesRegex(pdcorr.Error, "Zn2"):
            pdcorr.speciate(self.FLUIDS / "saline.electrolyte", add={"Zn2+ + 2 OH-": 1.0})

    def test_fields(self):
        """pH and species of a run, which belong together."""
        with pdcorr.Sim(ROOT / "examples" / "scenes" / "mg_migration_1d.scene") as sim:
            sim.run_to(60.0)
            fluid = sim.field("kind") == pdcorr.Kind.FLUID
            ph, acid, base = (sim.field(name)[fluid] for name in ("pH", "H+", "OH-"))
            np.testing.assert_allclose(ph, 3.0 - np.log10(acid), atol=1e-9)
            np.testing.assert_allclose(acid * base, 1e-8, rtol=1e-6)
            self.assertGreater(ph[0], 9.0)
            self.assertEqual(sim.label("Mg2+"), "Mg2+ [mol/m3]")
            self.assertTrue(np.isfinite(sim.field("potential")[fluid]).all())
            self.assertTrue(np.isnan(sim.field("pH")[~fluid]).all())


class Functions(unittest.TestCase):
    """Python functions in the place of values of a scene."""

    def test_a_law_has_the_bits_of_the_expression(self):
        def rate(C):
            return 1.21 * UM / 3600 * (1 - C / 56.1)

        scene = PIN.replace("1.21 um/h", "1.21*1e-6/3600 * 1 m/s")
        with pdcorr.Sim(scene) as written, pdcorr.Sim(PIN, functions={"rate": rate}) as called:
            written.run_to(2 * HOUR)
            called.run_to(2 * HOUR)
            self.assertEqual(written.steps, called.steps)
            self.assertAlmostEqual(written.volume_loss, called.volume_loss, delta=1e-12)
            self.assertGreater(called.volume_loss, 0.03)

    def test_a_law_of_time_in_closed_form(self):
        with pdcorr.Sim(PLATE, functions={"rate": lambda t: 3 * UM / HOUR * (t / (10 * HOUR))}) as sim:
            sim.run_to(20 * HOUR)  # the integral of the speed is 60 um
            self.assertAlmostEqual(sim.volume_loss, 0.3, delta=2e-3)
        with pdcorr.Sim(PLATE, functions={"rate": lambda x: 3 * UM / HOUR if x > 190 * UM else 0.0}) as sim:
            sim.run_to(20 * HOUR)
            self.assertAlmostEqual(sim.volume_loss, 0.05, delta=0.03)

    def test_laws_of_several_metals(self):
        # two plates with fluid between them, each of which recedes by its own law of time and place
        other = "[shape b] box = 300 um .. 400 um  kind = solid  material = steel304\n[side x+] flow = mirror\n"
        scene = PLATE.replace("[side x-]", f"{other}[side x-]")
        laws = {"rate.mg4ag": lambda t, x: 2 * UM / HOUR * (t / (10 * HOUR)), "rate.steel304": lambda x: 1 * UM / HOUR}
        with pdcorr.Sim(scene, functions=laws) as sim:
            density = sim.field("density").copy()
            sim.run_to(20 * HOUR)
            gone = (density - sim.field("density")) * sim.h[0]
            at = sim.axes[0]
            self.assertAlmostEqual(gone[at < 250 * UM].sum() / density[0], 40 * UM, delta=0.5 * UM)
            self.assertAlmostEqual(gone[at > 250 * UM].sum() / density[-1], 20 * UM, delta=0.5 * UM)
            self.assertLess(sim.imbalance, 1e-12)
        for key, message in (("rate", "several metals, expected rate.NAME"), ("rate.zinc", "no solid is of that")):
            with self.assertRaisesRegex(pdcorr.Error, message):
                pdcorr.Sim(scene, functions={key: lambda: 1e-10})

    def test_what_enters_and_what_is_held(self):
        scene = PIN.replace("kind = solid   material = mg4ag", "kind = wall").replace("[dissolve]", "#")
        for old, new in (("1e-9 m2/s", "1e-9 m2/s  time = steady"), ("until = 4 h", ""), ("every = 1 h", "")):
            scene = scene.replace(old, new)
        with pdcorr.Sim(scene, functions={"x-.C": lambda y: 2.0 + 0 * y}) as sim:
            np.testing.assert_allclose(sim.field("C")[sim.field("kind") == pdcorr.Kind.FLUID], 2.0, rtol=1e-6)
        from math import erfc, sqrt

        with pdcorr.Sim(SLAB, functions={"x-.C": lambda t: sqrt(t)}) as sim:  # Carslaw and Jaeger, section 2.5
            sim.run_to(0.5)
            z = sim.axes[0] / sqrt(4 * 1e-9 * 0.5)
            exact = sqrt(0.5) * np.array([np.exp(-s * s) - sqrt(np.pi) * s * erfc(s) for s in z])
            self.assertLess(np.abs(sim.field("C") - exact).max(), 5e-3)
        with pdcorr.Sim(SLAB, functions={"x-.C": lambda: 3.0, "initial": lambda x: 3.0}) as sim:
            sim.run_to(1.0)
            np.testing.assert_allclose(sim.field("C"), 3.0, rtol=1e-12)

    def test_speed_of_an_inlet(self):
        scene = PIN.replace("[dissolve]", "#").replace("kind = solid   material = mg4ag", "kind = wall")
        with pdcorr.Sim(scene) as slow, pdcorr.Sim(scene, functions={"x-.mean": lambda t: 0.1}) as fast:
            self.assertAlmostEqual(fast.field("v")[0, 2].sum() / slow.field("v")[0, 2].sum(), 2.0, delta=1e-3)
        profile = scene.replace("profile = parabola   mean = 0.05 m/s", "profile = expression  vx = 1 m/s")
        with pdcorr.Sim(profile, functions={"x-.vx": lambda y: 0.075 * (1 - (y / 1e-4) ** 2)}) as sim, \
                pdcorr.Sim(scene) as slow:
            np.testing.assert_allclose(sim.field("v")[0, 2], slow.field("v")[0, 2], rtol=1e-6)

    def test_exceptions_come_out(self):
        calls = []

        def late(C, t):
            calls.append(t)
            if t > HOUR:
                raise ZeroDivisionError("of the law")
            return 3e-10

        sim = pdcorr.Sim(PIN, functions={"rate": late})
        with self.assertRaisesRegex(ZeroDivisionError, "of the law"):
            sim.run_to(4 * HOUR)
        with self.assertRaisesRegex(pdcorr.Error, "has failed: of the law"):
            sim.step()
        sim.close()
        self.assertEqual(sim.in_use, 0)
        with self.assertRaisesRegex(ZeroDivisionError, "of the law"):
            pdcorr.run(PIN, dry=True, functions={"rate": late})
        with self.assertRaises(TypeError):
            pdcorr.Sim(PIN, functions={"rate": lambda C: None}).step()
        with self.assertRaisesRegex(RuntimeError, "shown"):
            def show(_text):
                raise RuntimeError("shown")
            pdcorr.run(PIN, dry=True, progress=show)

    def test_what_is_refused(self):
        for key, fn, kind, message in (
                ("rate", lambda c: 1.0, ValueError, r"found parameters \(c\), expected some of C, t, x, y"),
                ("rate", lambda *a: 1.0, ValueError, "found parameters"), ("rate", 3, TypeError, "found int"),
                ("initial", lambda t: 1.0, ValueError, "expected some of x, y"),
                ("rat", lambda: 1.0, pdcorr.Error, "expected rate, initial, or a side"),
                ("rate.steel304", lambda: 1.0, pdcorr.Error, "no solid is of that material"),
                ("x+.C", lambda: 1.0, pdcorr.Error, "expected an inlet, or a wall"),
                ("x-.vx", lambda: 1.0, pdcorr.Error, "profile = expression"),
                ("y-.mean", lambda: 1.0, pdcorr.Error, "expected an inlet"),
                ("z-.C", lambda: 1.0, pdcorr.Error, "expected rate, initial")):
            with self.assertRaisesRegex(kind, message):
                pdcorr.Sim(PIN, functions={key: fn})
        with self.assertRaisesRegex(ValueError, "beside checkpoint"):
            pdcorr.run(PIN, functions={"rate": lambda: 1e-10}, checkpoint=0.0)

    def test_a_call_within_a_call(self):
        def rate(C):
            if sim is not None:
                sim.field("C")
            return 1e-10 * (1 + C)

        sim = None  # until it is built
        sim = pdcorr.Sim(PIN, functions={"rate": rate})
        with self.assertRaisesRegex(pdcorr.Error, "a call within a call"):
            sim.step()


COOLING = PLATE.replace("rate = 3 um/h", "rate = 3 um/h * T/(300 K)").replace("until = 20 h", "until = 2 h") \
    + "[cooling] k = 0.5 /h\n[side x+] T = 280 K + 1 K*t/(1 h)\n"


class Cooling(pdcorr.Physics):
    """A body that cools: T = start exp(-k t)."""

    section, meaning = "cooling", "a body that cools"
    keys = {"k": pdcorr.Key("1/s", "required", "rate of cooling"),
            "start": pdcorr.Key("K", "300 K", "temperature at the start"),
            "nothing": pdcorr.Key("m", "-", "may be left out")}
    fields = {"T": "K", "S": "K"}
    places = {"S": "metal"}
    max_step = 100.0

    def start(self):
        self.T[...] = self.value("start")
        self.S[...] = 2 * self.T

    def step(self, time, dt):
        self.T *= np.exp(-self.value("k") * dt)
        self.S[...] = 2 * self.T


class PhysicsOfPython(unittest.TestCase):
    """A physics that is a class."""

    def test_law_reads_the_field(self):
        k, step = 0.5 / HOUR, Cooling.max_step
        with pdcorr.Sim(COOLING, physics=[Cooling]) as sim:
            self.assertLessEqual({"T", "S"}, set(sim.fields))
            self.assertEqual(sim.label("T"), "T [K]")
            np.testing.assert_allclose(sim.field("T"), 300.0, rtol=0)
            sim.run_to(2 * HOUR)
            np.testing.assert_allclose(sim.field("T"), 300 * np.exp(-1.0), rtol=1e-12)
            np.testing.assert_allclose(sim.field("S")[0], 600 * np.exp(-1.0), rtol=1e-12)
            self.assertEqual(sim.field("S")[-1], 0.0)  # in fluid
            depth = 3 * UM / 0.5 * (1 - np.exp(-1.0)) * k * step / np.expm1(k * step)  # T at the end of each step
            self.assertAlmostEqual(sim.volume_loss * 200 * UM, depth, delta=1e-9 * depth)

    def test_sides_and_keys(self):
        seen = []

        class Looking(Cooling):
            def start(self):
                super().start()
                seen.append((self.prescribed(0, [0.0]), self.prescribed(1, [400 * UM], HOUR), self.value("nothing"), self.kind[0],
                             self.axes[0][0], self.h[0]))

        with pdcorr.Sim(COOLING, physics=[Looking]):
            left, right, nothing, kind, x, h = seen[0]
        self.assertIsNone(left)
        self.assertAlmostEqual(right, 281.0, delta=1e-9)
        self.assertTrue(np.isnan(nothing).all())
        self.assertEqual(kind, pdcorr.Kind.SOLID)
        self.assertAlmostEqual(x, 2.5 * UM, delta=1e-12)
        self.assertAlmostEqual(h, 5 * UM, delta=1e-12)

    def test_checkpoints(self):
        with tempfile.TemporaryDirectory() as folder:
            whole = pdcorr.run(COOLING, out=folder + "/whole", physics=[Cooling])
            calls = []
            first = pdcorr.run(COOLING, out=folder + "/parts", physics=[Cooling], checkpoint=0,
                               observe=lambda at: calls.append(at.time) or len(calls) == 30)
            self.assertTrue(first.stopped)
            rest = pdcorr.run(COOLING, out=folder + "/parts", physics=[Cooling], checkpoint=0, resume=True)
            self.assertEqual((rest.volume_loss, rest.time), (whole.volume_loss, whole.time))

    def test_what_it_raises_comes_out(self):
        class Failing(Cooling):
            def step(self, time, dt):
                if time > 1000:
                    raise RuntimeError("too cold")
                super().step(time, dt)

        class Unready(Cooling):
            def start(self):
                raise KeyError("start")

        with self.assertRaisesRegex(RuntimeError, "too cold"):
            pdcorr.run(COOLING, dry=True, physics=[Failing])
        with self.assertRaises(KeyError):
            pdcorr.Sim(COOLING, physics=[Unready])
        with self.assertRaisesRegex(pdcorr.Error, "found the section"):
            pdcorr.Sim(COOLING)
        with self.assertRaisesRegex(TypeError, "physics: found 3"):
            pdcorr.Sim(COOLING, physics=[3])
        with self.assertRaisesRegex(pdcorr.Error, "cooling. is registered"):
            pdcorr.Sim(COOLING, physics=[Cooling, Failing])


class Studies(unittest.TestCase):
    """Many runs of one scene."""

    # The loss of a plate that recedes at v is v t/L: a straight line through the points.
    POINTS = """hours,lost,sd
5,7.7,0.5
10,14.6,0.5
15,22.8,0.5
20,29.7,0.5
"""
    TO = "  time = hours in h  value = lost in %  standard_deviation = sd in %"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = self.folder / "plate.scene"
        self.scene.write_text(PLATE.replace("[dissolve]", "[constants] v = 2 um/h\n[dissolve]").replace("3 um/h", "v")
                              + "[measured points] file = points.csv" + self.TO + "\n", encoding="utf-8")
        (self.folder / "points.csv").write_text(self.POINTS, encoding="utf-8")

    def test_a_fit_is_the_regression(self):
        table = pdcorr.read_table(self.folder / "points.csv")
        t, lost, sd = table["hours"], table["lost"] / 100, table["sd"] / 100
        v = 200 * (t * lost).sum() / (t * t).sum()  # [um/h] least squares of lost = v t/(200 um)
        error = 200 * sd[0] / np.sqrt((t * t).sum())
        said = []
        found = pdcorr.fit(self.scene, {"constants.v": (1, 5, "um/h")}, progress=said.append)
        parameter = found["constants.v"]
        self.assertAlmostEqual(parameter.value, v, delta=2e-3 * v)
        self.assertAlmostEqual(parameter.error, error, delta=0.05 * error)
        self.assertLess(parameter.interval[0], v - error)
        self.assertGreater(parameter.interval[1], v + error)
        self.assertEqual((parameter.unit, parameter.range, parameter.bound), ("um/h", (1.0, 5.0), 0))
        self.assertEqual((found.points, found.freedom, found.figure, found.unit), (4, 3, "volume_loss", "%"))
        rest = (v * t / 200 - lost) / sd
        self.assertAlmostEqual(found.sum, (rest**2).sum(), delta=0.02 * (rest**2).sum())
        np.testing.assert_array_equal(found.correlation, [[1.0]])
        self.assertTrue(found.converged and said and found.line.startswith("result case=plate fit="))
        with pdcorr.Sim(self.scene, found.overrides) as sim:
            sim.run_to(10 * HOUR)
            self.assertAlmostEqual(sim.volume_loss, parameter.value * 10 / 200, delta=1e-6)
        bound = pdcorr.fit(self.scene, {"constants.v": "1..2 um/h"}, one_lattice=True)["constants.v"]
        self.assertEqual((bound.value, bound.bound), (2.0, 1))
        self.assertTrue(np.isnan(bound.error))

    def test_a_fit_to_points_of_the_caller(self):
        path = self.folder / "others.csv"
        path.write_text("hours,lost,sd\n10,20,1\n20,40,1\n", encoding="utf-8")
        found = pdcorr.fit(self.scene, {"constants.v": "1..9 um/h"}, to=f"{path}{self.TO}")
        self.assertAlmostEqual(found["constants.v"].value, 4.0, delta=0.01)

    def test_fits_that_are_refused(self):
        for ranges, kind, message in (
                ({}, pdcorr.Error, "found 0 parameters"), ({"constants.w": "1..2"}, pdcorr.Error, "constants.w|'w'"),
                ({"constants.v": "1"}, pdcorr.Error, "expected KEY=LOW..HIGH"),
                ({"constants.v": 3}, TypeError, "found 3"),
                ({"constants.v": (2, 1, "um/h")}, pdcorr.Error, "low bound below the high one"),
                ({"constants.v": (1, 2, "kg")}, pdcorr.Error, "kg|dimension")):
            with self.assertRaisesRegex(kind, message):
                pdcorr.fit(self.scene, ranges)
        with self.assertRaisesRegex(ValueError, "path of a scene file"):
            pdcorr.fit(PLATE, {"constants.v": "1..2 um/h"})
        with self.assertRaisesRegex(RuntimeError, "shown"):
            def show(_text):
                raise RuntimeError("shown")
            pdcorr.fit(self.scene, {"constants.v": "1..5 um/h"}, progress=show)
        with self.assertRaises(KeyError):
            pdcorr.fit(self.scene, {"constants.v": "1..5 um/h"}, one_lattice=True)["constants.w"]

    def test_a_sweep(self):
        said = []
        found = pdcorr.sweep(self.scene, {"constants.v": "1, 2, 4 um/h", "h": ["5 um", "10 um"]}, {"until": "10 h"},
                             out=self.folder / "out", progress=said.append)
        self.assertEqual((found.name, found.shape, len(found.runs)), ("plate", (3, 2), 6))
        np.testing.assert_array_equal(found["constants.v"], [1, 1, 2, 2, 4, 4])
        np.testing.assert_allclose(found["volume_loss"], found["constants.v"] * 10 / 200, atol=1e-9)
        self.assertEqual(list(found["h"]), ["5 um", "10 um"] * 3)
        self.assertEqual([run.status for run in found.runs], ["done"] * 6)
        self.assertEqual(sum(text.endswith(": done") for text in said), 6)
        self.assertTrue((found.folder / "sweep.png").exists())
        for run in found.runs:
            loss = pdcorr.read_table(run.folder / "diagnostics.csv")["volume_loss"][-1]
            self.assertAlmostEqual(run.figures["volume_loss"], loss, delta=1e-9)
        with self.assertRaisesRegex(KeyError, "constants.v"):
            found["w"]

    def test_sweeps_that_fail(self):
        with self.assertRaisesRegex(pdcorr.Error, "kg"):
            pdcorr.sweep(self.scene, {"constants.v": "1, 2 kg"}, out=self.folder / "out")
        with self.assertRaisesRegex(ValueError, "without a comma"):
            pdcorr.sweep(self.scene, {"constants.v": ["1, 2 um/h"]}, out=self.folder / "out")
        with self.assertRaisesRegex(pdcorr.Error, "found 0 sweeps"):
            pdcorr.sweep(self.scene, {}, out=self.folder / "out")
        (self.folder / "out").mkdir()
        (self.folder / "out" / "run002").write_text("no folder", encoding="utf-8")  # one run alone fails
        found = pdcorr.sweep(self.scene, {"constants.v": [1, 2, "3 um/h"]}, out=self.folder / "out")
        self.assertEqual([run.status for run in found.runs], ["done", "failed", "done"])
        self.assertIn("run002", found.runs[1].message)
        np.testing.assert_array_equal(np.isnan(found["volume_loss"]), [False, True, False])

    def test_ctrl_c_in_a_sweep(self):
        def second(text):
            if text.startswith("run001"):
                raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            pdcorr.sweep(self.scene, {"constants.v": "1, 2, 3 um/h"}, out=self.folder / "out", progress=second)
        rows = (self.folder / "out" / "sweep.csv").read_text(encoding="utf-8").splitlines()[1:]
        self.assertEqual([row.split(",")[2] for row in rows], ["done", "stopped", "stopped"])
        fine = {"h": "0.05 um", "until": "1 h"}
        begin = time.monotonic()
        for work in (lambda: pdcorr.sweep(self.scene, {"constants.v": "1, 2 um/h"}, fine, out=self.folder / "long"),
                     lambda: pdcorr.fit(self.scene, {"constants.v": "1..2 um/h"}, fine | {"until": "20 h"})):
            with self.assertRaises(KeyboardInterrupt):
                Interrupts.interrupt(self, work)
            self.assertLess(time.monotonic() - begin, 10.0)

    def test_errors_of_a_run(self):
        changes = {"until": "2 h"}
        done = pdcorr.run(PIN, changes, dry=True, estimate_error=True)
        self.assertEqual((done.estimate.coarser_runs, done.estimate.spacing), (1, None))
        self.assertIn("expected a multiple of 4", done.estimate.without)
        for name in ("volume_loss", "total.all.dissolved"):
            self.assertIn(name, done.estimate.figures)
        loss = done.estimate.figures["volume_loss"]
        self.assertAlmostEqual(loss.value, done.volume_loss, delta=1e-12)
        twice = pdcorr.run(PIN, changes | {"grid.h": "20 um"}, dry=True).volume_loss
        self.assertAlmostEqual(loss.coarser[0], twice, delta=2e-2 * twice)
        self.assertGreater(loss.error, 0.0)
        self.assertGreaterEqual(done.estimate.error, loss.error if not loss.minor else 0.0)
        self.assertIsNone(pdcorr.run(PIN, changes, dry=True).estimate)
        wanted = pdcorr.run(PIN, changes, dry=True, accuracy=0.01)
        self.assertTrue(wanted.notes[0].startswith("accuracy 1 %"), wanted.notes)
        self.assertTrue(0 < wanted.estimate.spacing[0] < 10 * UM and len(wanted.estimate.spacing) == 2)
        with self.assertRaisesRegex(pdcorr.Error, "accuracy"):
            pdcorr.run(PIN, changes, dry=True, accuracy=2.0)
        impossible = pdcorr.run(PIN, changes, dry=True, estimate_error=True, h="20 um")
        self.assertIsNone(impossible.estimate)
        self.assertIn("no error estimate", impossible.notes[-1])
        alone = pdcorr.run(PIN, changes, dry=True, estimate_error=True, observe=lambda at: at.when == "step")
        self.assertTrue(alone.stopped and alone.estimate is None)
        law = {"rate": lambda C: 1.21 * UM / 3600 * (1 - C / 56.1)}
        called = pdcorr.run(PIN, changes, dry=True, estimate_error=True, functions=law)
        self.assertAlmostEqual(called.estimate.figures["volume_loss"].coarser[0], loss.coarser[0], delta=1e-9)


class Packages(unittest.TestCase):
    """What backend.py builds."""

    @unittest.skipUnless(has("pip"), "pip is not installed")
    def test_an_sdist_installs_without_a_network(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            names = [subprocess.run([sys.executable, HERE / "backend.py", folder], check=True, capture_output=True,
                                    text=True).stdout.strip() for _ in range(2)]
            self.assertEqual(names, [f"pdcorr-{pdcorr.__version__}.tar.gz"] * 2)
            with tarfile.open(folder / names[0]) as archive:
                top = names[0][: -len(".tar.gz")]
                headers = {n: archive.extractfile(f"{top}/{n}").read() for n in ("pdcorr.h", "pdcorr_app.h")}
                about = archive.extractfile(f"{top}/PKG-INFO").read().decode()
            self.assertEqual(headers, {n: (ROOT / n).read_bytes() for n in headers})
            self.assertIn(f"Version: {pdcorr.__version__}\n", about)
            compiler = folder / "cc"  # what is optimised least is compiled soonest
            compiler.write_text(f'#!/bin/sh\nexec {os.environ.get("CC", "cc")} "$@" -O0\n', encoding="utf-8")
            compiler.chmod(0o755)
            clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PDCORR", "PIP_"))}
            clean |= {"CC": str(compiler), "TMPDIR": name, "HOME": name}
            command = [sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--no-cache-dir", "--target",
                       folder / "site", folder / names[0]]
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=clean, cwd=name)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            program = f"import pdcorr; print(pdcorr.__file__, pdcorr.Sim({PLATE!r}).run_to(36000).volume_loss)"
            said = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True, cwd=name,
                                  env=clean | {"PYTHONPATH": str(folder / "site")}).stdout.split()
            self.assertTrue(said[0].startswith(str(folder / "site")), said)
            self.assertAlmostEqual(float(said[1]), 0.15, delta=1e-9)


class Interrupts(unittest.TestCase):
    """Ctrl-C in the middle of a step."""

    FINE = {"h": "1 um", "until": "1 h"}  # its first flow takes longer than any patience

    def interrupt(self, work) -> float:
        """Seconds from a SIGINT until work() ends."""
        sent = []

        def send():
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(0.7, send)
        timer.start()
        try:
            work()
        finally:
            timer.join()
        return time.monotonic() - sent[0]

    def test_ctrl_c(self):
        handler = signal.getsignal(signal.SIGINT)
        for work in (lambda: pdcorr.Sim(PIN, self.FINE), lambda: pdcorr.run(PIN, self.FINE, dry=True)):
            begin = time.monotonic()
            with self.assertRaises(KeyboardInterrupt):
                self.interrupt(work)
            self.assertLess(time.monotonic() - begin, 0.7 + 1.0 + 1.0)  # the machine may be busy
            self.assertIs(signal.getsignal(signal.SIGINT), handler)

    def test_a_step_can_be_made_again(self):
        with pdcorr.Sim(PIN) as sim, pdcorr.Sim(PIN) as other:
            sim._context.guard.raised = KeyboardInterrupt()
            with self.assertRaises(KeyboardInterrupt):
                sim.step()
            self.assertEqual(sim.steps, 0)
            self.assertEqual(sim.step(), other.step())
            np.testing.assert_array_equal(sim.field("C"), other.field("C"))

    def test_handlers_of_the_program(self):
        heard = []
        handler = signal.signal(signal.SIGINT, lambda *_: heard.append(1))
        try:
            with pdcorr.Sim(PIN, h="4 um") as sim:
                def steps():
                    begin = time.monotonic()
                    while time.monotonic() - begin < 1.0:
                        sim.step(sim.time + 0.2 * HOUR)
                self.interrupt(steps)
        finally:
            signal.signal(signal.SIGINT, handler)
        self.assertEqual(heard, [1])

    def test_other_threads(self):
        found = []
        thread = threading.Thread(target=lambda: found.append(pdcorr.run(PIN, dry=True, h="20 um").volume_loss))
        thread.start()
        thread.join()
        self.assertEqual(found, [pdcorr.run(PIN, dry=True, h="20 um").volume_loss])


class Kernels(unittest.TestCase):
    """Lattice, operators and their matrices."""

    def lattice(self, dim=2, **more):
        periodic = {axis + end: "periodic" for axis in "xyz"[:dim] for end in "-+"}
        h = [1e-6, 2e-6, 1e-6][:dim]
        box = [(0, n * d) for n, d in zip((16, 12, 8), h)]
        return pdcorr.Lattice(h, box, sides=more.pop("sides", periodic), **more)

    def test_laplacian_against_the_stencil(self):
        for dim in (1, 2, 3):
            lattice = self.lattice(dim)
            s = lattice.stencil
            np.testing.assert_allclose(s.xi, s.offset * np.array([1e-6, 2e-6, 1e-6][:dim]), rtol=1e-15)
            rng = np.random.default_rng(1)
            f = lattice.zeros()
            f[lattice.inside] = rng.standard_normal(lattice.cells)
            inner = f[lattice.inside].copy()
            expected = sum(w * (np.roll(inner, tuple(-n), tuple(range(dim))) - inner) for n, w in zip(s.offset, s.lap))
            scale = s.lap.sum() * np.abs(inner).max()
            np.testing.assert_allclose(lattice.laplacian(f)[lattice.inside], expected, atol=1e-14 * scale)
            wave = 2 * np.pi / (16e-6)
            f[...] = np.cos(wave * lattice.axes[0]).reshape(-1, *[1] * (dim - 1))
            symbol = (s.lap * (np.cos(wave * s.xi[:, 0]) - 1)).sum()
            lap = lattice.laplacian(f)
            np.testing.assert_allclose(lap[lattice.inside], symbol * f[lattice.inside], atol=1e-13 * scale)

    def test_quadratics(self):
        lattice = pdcorr.Lattice((1.0, 0.5), ((-8, 8), (-4, 4)), m=2)
        x, y = np.meshgrid(*lattice.axes, indexing="ij")
        f, u = lattice.zeros(), lattice.zeros(2)
        f[...] = 1 + x - y + x * x + 3 * y * y - x * y
        u[0], u[1] = x * x, x * y
        whole = lattice.whole
        self.assertGreater(whole.sum(), 50)
        np.testing.assert_allclose(lattice.laplacian(f)[whole], 8.0, rtol=1e-12)
        gradient = lattice.gradient(f)
        np.testing.assert_allclose(gradient[0][whole], (1 + 2 * x - y)[whole], atol=1e-12)
        np.testing.assert_allclose(gradient[1][whole], (-1 + 6 * y - x)[whole], atol=1e-12)
        np.testing.assert_allclose(lattice.divergence(u)[whole], 3 * x[whole], atol=1e-12)
        diffusivity = lattice.zeros()
        diffusivity[...] = 2.0
        np.testing.assert_allclose(lattice.diffuse(diffusivity, f)[whole], 16.0, rtol=1e-12)

    @unittest.skipUnless(has("scipy"), "scipy is not installed")
    def test_matrices_against_operators(self):
        hole = pdcorr.difference(pdcorr.ball((8e-6, 12e-6), 4e-6), pdcorr.half_space((8e-6, 12e-6), (1, 0)))
        walled = self.lattice(sides={"y-": "mirror"}, wall=hole, m=2)
        ports = self.lattice(sides={"x-": "inlet", "x+": "outlet"}, solid=pdcorr.box((4e-6, 8e-6), (8e-6, 16e-6)))
        rng = np.random.default_rng(2)
        for lattice in (walled, ports, self.lattice(3), self.lattice(1)):
            f, d = lattice.zeros(), lattice.zeros()
            f[...] = rng.standard_normal(lattice.shape)
            d[...] = 1e-9 * (1 + rng.random(lattice.shape))
            lattice.fill_ghosts(d)
            for operator, value in (("laplacian", lattice.laplacian(f)), ("diffuse", lattice.diffuse(d, f)),
                                    ("gradient", lattice.gradient(f)[0] if lattice.dim > 1 else lattice.gradient(f))):
                csr = lattice.csr(operator, diffusivity=d)
                flat = f.ravel(order="F")
                found = csr.matrix() @ flat[csr.node] + csr.given_matrix(lattice.total) @ flat
                wanted = value.ravel(order="F")[csr.node]
                size = abs(csr.matrix()).sum(axis=1).max() * np.abs(flat).max()
                np.testing.assert_allclose(found, wanted, atol=1e-14 * size, err_msg=f"{operator} {lattice}")
            laplacian = lattice.csr().matrix()
            self.assertLess(abs(laplacian - laplacian.T).max(), 1e-14 * abs(laplacian).max())
            self.assertEqual(laplacian.shape[0], (lattice.kind == pdcorr.Kind.FLUID)[lattice.inside].sum())
        some = ports.kind == pdcorr.Kind.FLUID
        some[ports.axes[0] > 8e-6] = False
        self.assertEqual(len(ports.csr(mask=some).node), some[ports.inside].sum())

    def test_kinds(self):
        beyond = pdcorr.complement(pdcorr.half_space((14e-6, 0), (1, 0)))
        lattice = self.lattice(
            solid=pdcorr.union(pdcorr.box((0, 0), (2e-6, 24e-6)), pdcorr.ball((10e-6, 12e-6), 1.1e-6)),
            wall=pdcorr.intersect(beyond, pdcorr.cylinder(2, (15e-6, 6e-6), 5e-6)))
        kind = lattice.kind[lattice.inside]
        x, y = np.meshgrid(lattice.axes[0][lattice.inside[0]], lattice.axes[1][lattice.inside[1]], indexing="ij")
        solid = (x < 2e-6) | (np.hypot(x - 10e-6, y - 12e-6) < 1.1e-6)
        wall = (x > 14e-6) & (np.hypot(x - 15e-6, y - 6e-6) < 5e-6)
        np.testing.assert_array_equal(kind == pdcorr.Kind.SOLID, solid & ~wall)
        np.testing.assert_array_equal(kind == pdcorr.Kind.WALL, wall)
        self.assertTrue(solid.any() and wall.any())

    def test_what_is_refused(self):
        lattice = self.lattice()
        f = lattice.zeros()
        frozen = lattice.zeros()
        frozen.flags.writeable = False
        for wrong, kind, message in (
                (f.astype(np.float32), ValueError, "found float32"),
                (f.copy(order="C"), ValueError, "axis x the fastest"),
                (f[1:], ValueError, r"found float64 \[21, 18\]"),
                (lattice.zeros(2), ValueError, r"found float64 \[2, 22, 18\]"),
                (f.tolist(), TypeError, "found list"), (frozen, ValueError, "cannot be written")):
            with self.assertRaisesRegex(kind, message):
                lattice.laplacian(wrong)
        with self.assertRaisesRegex(ValueError, "out: found the memory"):
            lattice.laplacian(f, f)
        with self.assertRaisesRegex(ValueError, "u: found|f: found"):
            lattice.divergence(f)
        with self.assertRaisesRegex(ValueError, "operator: found 'curl'"):
            lattice.csr("curl")
        with self.assertRaisesRegex(ValueError, "mask: found int64"):
            lattice.csr(mask=np.zeros(lattice.shape, dtype=np.int64))
        with self.assertRaisesRegex(pdcorr.Error, "diffusivity"):
            lattice.csr("diffuse")
        with self.assertRaisesRegex(ValueError, "sides: found 'z-'"):
            self.lattice(sides={"z-": "mirror"})
        with self.assertRaisesRegex(pdcorr.Error, "cells"):
            pdcorr.Lattice((1.0,), ((0, 9.5),))
        with self.assertRaisesRegex(ValueError, "coordinates in 2D"):
            self.lattice(solid=pdcorr.ball((0, 0, 0), 1e-6))
        with self.assertRaisesRegex(ValueError, "8 at most"):
            self.lattice(solid=pdcorr.union(*[pdcorr.ball((0, 0), 1e-6)] * 9))

    def test_memory(self):
        lattice = self.lattice(solid=pdcorr.ball((8e-6, 12e-6), 4e-6))
        context = lattice._context
        csr, kind = lattice.csr(), lattice.kind
        total = csr.weight.sum()
        del lattice
        gc.collect()
        self.assertEqual(csr.weight.sum(), total)  # they hold what they look at
        self.assertEqual((kind == pdcorr.Kind.SOLID).sum(), np.count_nonzero(kind == 2))
        del csr, kind
        gc.collect()
        self.assertEqual(context.in_use, 0)


if __name__ == "__main__":
    unittest.main()
