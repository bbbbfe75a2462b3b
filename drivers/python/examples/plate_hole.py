"""A plate with a hole under tension: its stress, and how it falls from the edge of the hole beside Kirsch's formula.

    python3 drivers/python/examples/plate_hole.py [--quick] writes out/python/plate_hole.png
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pdcorr

SCENE = Path(__file__).resolve().parents[3] / "examples" / "scenes" / "plate_hole_2d.scene"
SPACINGS = [0.5] if "--quick" in sys.argv else [0.5, 0.25]  # [mm]
PULL, RADIUS, CENTRE = 50e6, 4e-3, (40e-3, 20e-3)  # [Pa], [m], [m]

figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.5), constrained_layout=True,
                                     gridspec_kw={"width_ratios": [3, 2]})
for h in SPACINGS:
    with pdcorr.Sim(SCENE, {"grid.h": f"{h} mm"}) as sim:
        (x, y), along, mises, kind = sim.axes, sim.field("sigma_xx"), sim.field("mises"), sim.field("kind")
        label = sim.label("mises")
    # the columns of nodes on both sides of the axis, above the hole
    beside = np.abs(x - CENTRE[0]) < 0.6e-3 * h
    above = y - CENTRE[1] > RADIUS
    stress = along[beside][:, above].mean(axis=0)
    right.plot((y[above] - CENTRE[1]) / RADIUS, stress / PULL, "o", ms=3, label=f"h = {h:g} mm")
    print(f"h = {h:g} mm: the largest stress of a node is {along.max() / PULL:.2f} times the pull")

metal = np.where(kind == pdcorr.Kind.SOLID, mises, np.nan)
image = left.pcolormesh(x * 1e3, y * 1e3, metal.T / 1e6, shading="nearest", cmap="inferno")
figure.colorbar(image, ax=left, label=label.replace("[Pa]", "[MPa]"), shrink=0.7)
left.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", title="50 MPa along x")
s = np.linspace(1.0, 5.0, 200)
right.plot(s, 1 + 0.5 / s**2 + 1.5 / s**4, "k:", label="infinite plate (Kirsch 1898)")
right.plot([1], [3.14], "ks", mfc="none", label="edge in a plate five holes wide (Howland 1930)")
right.set(xlabel="distance from the centre over the radius", ylabel="stress along the plate over the pull",
          ylim=(0.8, 4.2))
right.legend(loc="upper right")
out = Path("out/python")
out.mkdir(parents=True, exist_ok=True)
figure.savefig(out / "plate_hole.png", dpi=110)
