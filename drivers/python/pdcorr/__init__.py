"""pdcorr: how a metal dissolves in a flowing liquid, by peridynamics, in 1D, 2D and 3D.

Sim: a scene step by step. run: a scene to its end, with its files. fit, sweep: many runs. read_table: the tables of a
run. speciate: the equilibrium of an electrolyte. Lattice: nodes, bonds and operators alone. All numbers are SI.
"""
from ._declared import PD_VERSION_MAJOR, PD_VERSION_MINOR, PD_VERSION_PATCH
from ._library import Error, Status
from .chemistry import Speciation, speciate
from .lattice import (Csr, Kind, Lattice, Shape, Stencil, ball, box, complement, cylinder, difference, half_space,
                      intersect, union)
from .physics import Key, Physics
from .sim import Estimate, Estimated, Frame, Instant, Ledger, Result, Sim, run
from .study import Fit, Parameter, Sweep, SweepRun, fit, sweep
from .table import Table, read_table

__version__ = f"{PD_VERSION_MAJOR}.{PD_VERSION_MINOR}.{PD_VERSION_PATCH}"

__all__ = [
    "Csr", "Error", "Estimate", "Estimated", "Fit", "Frame", "Instant", "Key", "Kind", "Lattice", "Ledger", "Parameter",
    "Physics", "Result", "Shape", "Sim", "Speciation", "Status", "Stencil", "Sweep", "SweepRun", "Table", "ball", "box",
    "complement", "cylinder", "difference", "fit", "half_space", "intersect", "read_table", "run", "speciate", "sweep",
    "union",
]
