"""Two constants of a law from nine scans of a dissolving wire: least squares by hand, with a run for each trial.

The law of the scene is v (1 - exp(-t/tau)) (1 - C/Csat). Gauss and Newton's method in the logarithms of v and tau,
derivatives by differences, weights from the spread of the scans. pd2d does the same with --fit.

    python3 drivers/python/examples/calibrate.py [--quick]  writes out/python/calibrate.png
"""
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import pdcorr

HOUR = 3600.0
SCENES = Path(__file__).resolve().parents[3] / "examples" / "scenes"
H = "20 um" if "--quick" in sys.argv else "10 um"

scans = pdcorr.read_table(SCENES / "mg4ag_wire.csv")
time = (scans["time_h"] - scans["time_h"][0])[1:] * HOUR  # [s] the run begins with the first scan
lost, spread = scans["lost_pct"][1:] / 100, scans["spread_pct"][1:] / 100


def computed(v, tau, times=time):
    """Share lost at `times` [s] with v [um/h] and tau [h]."""
    changes = {"grid.h": H, "constants.v": f"{v:.17g} um/h", "constants.tau": f"{tau:.17g} h"}
    with pdcorr.Sim(SCENES / "mg_wire.scene", changes) as sim:
        return np.array([frame.volume_loss for frame in sim.frames(times)])


log = np.log([1.3, 1.0])  # where the search begins: v = 1.3 um/h, tau = 1 h
for trial in range(12):
    here = computed(*np.exp(log))
    residual = (here - lost) / spread
    slopes = np.stack([(computed(*np.exp(log + 0.02 * unit)) - here) / (0.02 * spread) for unit in np.eye(2)], axis=1)
    step = -np.linalg.lstsq(slopes, residual, rcond=None)[0]
    rms = np.sqrt(np.mean(residual**2))
    print(f"v = {np.exp(log[0]):.3f} um/h, tau = {np.exp(log[1]):.3f} h: rms {rms:.3f} spreads")
    if np.abs(step).max() < 1e-3:
        break
    log = log + np.clip(step, -0.5, 0.5)
v, tau = np.exp(log)
covariance = np.linalg.inv(slopes.T @ slopes) * max(1.0, (residual**2).sum() / (len(time) - 2))
error = np.exp(log) * np.sqrt(np.diag(covariance))
print(f"v = {v:.2f} +- {error[0]:.2f} um/h, tau = {tau:.2f} +- {error[1]:.2f} h")

figure, axes = plt.subplots(figsize=(7, 4.5), constrained_layout=True)
fine = np.linspace(0.0, time[-1], 30)
axes.errorbar(time / HOUR, 100 * lost, 100 * spread, fmt="ks", capsize=3, label="scans (Reimers et al. 2023)")
axes.plot(fine / HOUR, 100 * computed(1.3, 1.0, fine), "--", label="start: v = 1.3 um/h, tau = 1 h")
axes.plot(fine / HOUR, 100 * computed(v, tau, fine), label=f"fitted: v = {v:.2f} um/h, tau = {tau:.2f} h")
axes.set(xlabel="time since the first scan [h]", ylabel="volume lost [%]")
axes.legend()
out = Path("out/python")
out.mkdir(parents=True, exist_ok=True)
figure.savefig(out / "calibrate.png", dpi=110)
