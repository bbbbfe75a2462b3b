"""A pit under a small opening of a passive film: how deep it grows, and what stands in it.

    python3 drivers/python/examples/pit.py [--quick]        writes out/python/pit.png
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pdcorr

SCENE = Path(__file__).resolve().parents[3] / "examples" / "scenes" / "pit_304_2d.scene"
CHANGES = {"run.until": "20 s"} if "--quick" in sys.argv else {}


def depth(sim):
    """Depth [m] of the pit on its axis: fluid below y = 0, and the part of the first metal node that is gone."""
    x, y = sim.axes
    column = np.argmin(np.abs(x))
    below = y < 0
    metal = sim.field("density")[column, below]
    return (1.0 - metal / metal.max()).sum() * sim.h[1]


with pdcorr.Sim(SCENE, CHANGES, progress=True) as sim:
    grown = [(frame.time, depth(sim)) for frame in sim.frames(np.linspace(0.0, sim.until, 21))]
    c, kind, (x, y) = sim.field("C"), sim.field("kind"), sim.axes
    label, end = sim.label("C"), sim.time
    print(f"{sim.steps} steps, {depth(sim) * 1e6:.1f} um deep after {end:g} s, imbalance {sim.imbalance:.0e}")

figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), constrained_layout=True)
fluid = np.where(kind == pdcorr.Kind.FLUID, c, np.nan)
image = left.pcolormesh(x * 1e6, y * 1e6, fluid.T, shading="nearest", cmap="magma")
film = np.where(kind == pdcorr.Kind.WALL, 0.5, np.nan)
left.pcolormesh(x * 1e6, y * 1e6, film.T, shading="nearest", cmap="cool", vmin=0.0, vmax=1.0)
figure.colorbar(image, ax=left, label=label)
left.set(aspect="equal", xlabel="x [um]", ylabel="y [um]", title=f"{end:g} s; the film in violet, metal in white")
time, deep = np.array(grown).T
right.plot(time, deep * 1e6, "o-", label="computed")
fine = np.linspace(0.0, end, 200)
right.plot(fine, deep[-1] * 1e6 * np.sqrt(fine / end), "k:", label="square root of time through the last point")
right.set(xlabel="time [s]", ylabel="depth on the axis [um]")
right.legend()
out = Path("out/python")
out.mkdir(parents=True, exist_ok=True)
figure.savefig(out / "pit.png", dpi=110)
