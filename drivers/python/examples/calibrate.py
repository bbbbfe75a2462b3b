"""Two constants of a law from nine scans of a dissolving wire, and whether a law with one of them would do.

The law of the scene is v (1 - exp(-t/tau)) (1 - C/Csat). fit finds v and tau by least squares, weighted by the spread of
the scans, with standard errors, as pd2d --fit does. The other law is v (1 - C/Csat).

    python3 drivers/python/examples/calibrate.py [--quick]  writes out/python/calibrate.png
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pdcorr

HOUR = 3600.0
SCENE = Path(__file__).resolve().parents[3] / "examples" / "scenes" / "mg_wire.scene"
H = "20 um" if "--quick" in sys.argv else "10 um"
V, TAU = (1, 3, "um/h"), (0.5, 4, "h")  # where values are looked for
LAWS = {
    "constant speed": ({"dissolve.rate": "v * (1 - C/Csat)"}, {"constants.v": V}),
    "speed that rises": ({}, {"constants.v": V, "constants.tau": TAU}),
}

scans = pdcorr.read_table(SCENE.with_name("mg4ag_wire.csv"))
time = scans["time_h"] - scans["time_h"][0]  # [h] the run begins with the first scan
figure, axes = plt.subplots(figsize=(7, 4.5), constrained_layout=True)
axes.errorbar(time, scans["lost_pct"], scans["spread_pct"], fmt="ks", capsize=3, label="scans (Reimers et al. 2023)")
for name, (law, ranges) in LAWS.items():
    found = pdcorr.fit(SCENE, ranges, law, h=H, one_lattice=True)
    values = [f"{p.key.split('.')[1]} = {p.value:.2f} +- {p.error:.2f} {p.unit}" for p in found.parameters]
    print(f"{name}: {', '.join(values)}; rms {found.rms:.2f} {found.unit} of {found.points} points")
    with pdcorr.Sim(SCENE, {**law, **found.overrides}, h=H) as sim:
        at = np.linspace(0.0, time[-1], 30)[1:]
        loss = [100 * frame.volume_loss for frame in sim.frames(at * HOUR)]
    axes.plot(at, loss, label=f"{name}: {', '.join(values)}")
axes.set(xlabel="time since the first scan [h]", ylabel="volume lost [%]")
axes.legend()
out = Path("out/python")
out.mkdir(parents=True, exist_ok=True)
figure.savefig(out / "calibrate.png", dpi=110)
