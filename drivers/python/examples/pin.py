"""A magnesium pin in a stream: the law of the scene, and one in Python, by which a film slows the metal down.

    python3 drivers/python/examples/pin.py [--quick]        writes out/python/pin.png
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pdcorr

HOUR, UM = 3600.0, 1e-6
SCENE = Path(__file__).resolve().parents[3] / "examples" / "scenes" / "mg_pin_2d.scene"
CHANGES = {"h": "20 um" if "--quick" in sys.argv else "10 um", "output.every": "1 h"}


def film(C, t):
    """Recession speed [m/s] at the concentration C [mol/m3] and the time t [s]: it halves every three hours."""
    return 1.21 * UM / HOUR * (1.0 - C / 56.1) * 0.5 ** (t / (3.0 * HOUR))


figure, (left, right) = plt.subplots(2, 1, figsize=(9, 7), constrained_layout=True)
for name, functions in (("law of the scene", {}), ("with a film, in Python", {"rate": film})):
    with pdcorr.Sim(SCENE, CHANGES, functions=functions, progress=True) as sim:
        loss = [(frame.time, frame.volume_loss) for frame in sim]
        print(f"{name}: {sim.steps} steps, {100 * sim.volume_loss:.1f} % lost, imbalance {sim.imbalance:.0e}")
        if not functions:
            c, kind, (x, y) = sim.field("C"), sim.field("kind"), sim.axes
            label = sim.label("C")
    time, share = np.array(loss).T
    right.plot(time / HOUR, 100 * share, "o-", label=name)

fluid = np.where(kind == pdcorr.Kind.FLUID, c, np.nan)
image = left.pcolormesh(x * 1e6, y * 1e6, fluid.T, shading="nearest", cmap="viridis")
figure.colorbar(image, ax=left, label=label, shrink=0.5)
left.set(aspect="equal", xlabel="x [um]", ylabel="y [um]", title="dissolved magnesium after nine hours, metal in white")
plane = 1.21 * UM / HOUR  # a slab that recedes on both faces and at both ends, without film
exact = [1 - max(0.0, 1 - plane * t / (40 * UM)) * (1 - 2 * plane * t / (400 * UM)) for t in time]
right.plot(time / HOUR, 100 * np.array(exact), "k:", label="a rectangle that recedes at 1.21 um/h, no grains")
right.set(xlabel="time [h]", ylabel="volume lost [%]")
right.legend()
out = Path("out/python")
out.mkdir(parents=True, exist_ok=True)
figure.savefig(out / "pin.png", dpi=110)
