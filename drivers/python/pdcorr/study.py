"""Many runs of one scene: fits to measured points, and sweeps over values."""
from __future__ import annotations

import csv
import math
import os
from ctypes import byref, c_char_p, create_string_buffer, sizeof
from dataclasses import dataclass, field as member
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np

from ._library import Error
from .sim import _is_text, _override, _Printer, _Scene

Range = Union[str, Sequence[Any]]


def _of_file(scene: str | os.PathLike, overrides: Mapping[str, Any] | None, values: Mapping[str, Any], dim: int | None,
             threads: int, memory_limit: float) -> _Scene:
    """A scene that the library reads anew for each run."""
    if _is_text(scene):
        raise ValueError("scene: found a text, expected the path of a scene file")
    return _Scene(scene, overrides, values, dim, None, threads, memory_limit)


def _texts(texts: Sequence[bytes]) -> Any:
    return (c_char_p * max(len(texts), 1))(*texts)


def _ask(desc: Any, scene: str | os.PathLike, read: _Scene, asked: Sequence[bytes]) -> Any:
    """Fill in what fits and sweeps have in common; what is asked, as C texts."""
    desc.scene = os.fsencode(scene)
    desc.overrides, desc.count = _texts(read.changes), len(read.changes)
    return _texts(asked)


# ---- fits ----


@dataclass(frozen=True)
class Parameter:
    """A value that a fit has found, in `unit`, "" without one."""

    key: str
    unit: str
    value: float
    error: float  # standard error; NaN on a bound, or with too few points
    interval: tuple[float, float]  # ends of the 95 % interval
    range: tuple[float, float]  # in which it was looked for
    bound: int  # -1, 1: it lies on the low, high bound and wants to pass it


@dataclass(frozen=True)
class Fit:
    """What a fit has come to."""

    name: str
    parameters: list[Parameter]
    correlation: np.ndarray = member(repr=False)  # [parameters, parameters] [-]
    points: int  # that count
    freedom: int  # points less parameters inside their bounds
    rms: float  # [unit]; with points of several sections [-], of differences over spreads
    figure: str  # of the first section of points
    unit: str
    sum: float  # [-] of the squared residuals; of differences over spreads where these are known
    known: bool  # the points have a spread
    noise: float  # [-] of a residual: what two runs differ by for no reason
    converged: bool
    evaluations: int  # runs on all lattices
    h: float  # [m] along x
    overrides: dict[str, str]  # what a run at the result takes, with all digits
    line: str  # for scripts, as pd2d prints it

    def __getitem__(self, key: str) -> Parameter:
        for parameter in self.parameters:
            if parameter.key == key:
                return parameter
        known = ", ".join(parameter.key for parameter in self.parameters)
        raise KeyError(f"found no parameter {key!r}, expected one of {known}")


def _range(key: str, value: Range) -> bytes:
    """KEY=LOW..HIGH UNIT"""
    if isinstance(value, str):
        return f"{key}={value}".encode()
    if not isinstance(value, Sequence) or len(value) not in (2, 3):
        raise TypeError(f"{key}: found {value!r}, expected a text such as '1..3 um/h', (low, high) or (low, high,"
                        " unit)")
    low, high = (f"{float(v):.17g}" for v in value[:2])
    return f"{key}={low}..{high} {value[2] if len(value) == 3 else ''}".strip().encode()


def fit(scene: str | os.PathLike, ranges: Mapping[str, Range], overrides: Mapping[str, Any] | None = None, *,
        to: str | None = None, one_lattice: bool = False, dim: int | None = None, threads: int = 0,
        memory_limit: float = 0, progress: bool | Callable[[str], None] | None = None, **values: Any) -> Fit:
    """Which values of a scene file match measured points: bounded least squares over runs, as pd2d --fit.

        found = pdcorr.fit("wire.scene", {"constants.v": "1..3 um/h", "constants.tau": (0.5, 4, "h")})
        found["constants.v"].value, found["constants.v"].error
        pdcorr.run("wire.scene", found.overrides)

    ranges: for up to 8 keys "LOW..HIGH UNIT", (low, high) or (low, high, unit). to: points in the place of those of the
    scene, "wire.csv time = hours in h value = lost in %", see --to. one_lattice: without coarser lattices before that
    of the scene. progress: True: a line on a terminal; or a function that is called with a line after each step. The other
    parameters are those of run. Writes no files.

    Raises Error: a range or a key that cannot be, too few points, a parameter without effect, or a run that fails, with
    the values of that run.
    """
    read = _of_file(scene, overrides, values, dim, threads, memory_limit)
    context, types = read.context, read.context.types
    desc, found, printer = types.pd_fit_desc(), types.pd_fit(), _Printer(context, progress, every=True)
    asked = [_range(key, value) for key, value in ranges.items()]
    desc.range, desc.ranges = _ask(desc, scene, read, asked), len(asked)
    desc.measured = None if to is None else os.fsencode(to)
    desc.skips_coarser = one_lattice
    desc.print, desc.stop = printer.function, printer.stop
    try:
        context.call("pd_fit_run", desc, found)
    finally:
        printer.end()
    text = create_string_buffer(8192)
    context.library.pd_fit_format_result(found, text, sizeof(text))
    squares, count = found.result, found.parameters
    parameters = [Parameter(key=p.key.decode(), unit=p.unit.decode(), value=squares.value[k], error=squares.standard_error[k],
                            interval=(squares.low[k], squares.high[k]), range=(p.low, p.high), bound=squares.active_bound[k])
                  for k, p in enumerate(found.parameter[:count])]
    pairs = (bytes(found.override[k]).split(b"\0", 1)[0].decode().split("=", 1) for k in range(count))
    return Fit(name=found.name.decode("utf-8", "replace"), parameters=parameters,
               correlation=np.array([list(row)[:count] for row in squares.correlation][:count]), points=found.points,
               freedom=squares.degrees_of_freedom, rms=found.rms, figure=found.output.decode(), unit=found.unit.decode(),
               sum=squares.sum, known=bool(found.has_spread), noise=squares.noise, converged=bool(squares.converged),
               evaluations=found.evaluations, h=found.h, overrides=dict(pairs), line=text.value.decode())


# ---- sweeps ----


@dataclass(frozen=True)
class SweepRun:
    """A run of a sweep."""

    folder: Path
    label: str  # "run003 mean=0.2 m/s h=10 um"
    status: str  # "done", "failed" or "stopped"
    values: dict[str, str]  # of the axes, as in the table
    figures: dict[str, float]  # of its result line
    message: str  # of a run that failed


@dataclass(frozen=True)
class Sweep:
    """What a sweep has come to. sweep["volume_loss"]: a figure, or the values of an axis, of all runs."""

    name: str
    folder: Path  # of sweep.csv and sweep.png; runs are below it
    shape: tuple[int, ...]  # values of each axis; the last one changes fastest over the runs
    axes: list[str]  # with the unit in brackets where all values share one
    runs: list[SweepRun] = member(repr=False)

    def __getitem__(self, key: str) -> np.ndarray:
        """[runs] in the unit of the axis, or texts where units differ; figures in SI, NaN where a run has none."""
        axis = next((name for name in self.axes if key in (name, name.split(" [")[0])), None)
        if axis is not None:
            try:
                return np.array([float(run.values[axis]) for run in self.runs])
            except ValueError:
                return np.array([run.values[axis] for run in self.runs])
        if not any(key in run.figures for run in self.runs):
            known = dict.fromkeys(name for run in self.runs for name in run.figures)
            raise KeyError(f"found no {key!r}, expected one of {', '.join([*self.axes, *known])}")
        return np.array([run.figures.get(key, math.nan) for run in self.runs])


def _axis(key: str, values: Any) -> bytes:
    """key=value, value, ..."""
    if isinstance(values, str):
        return f"{key}={values}".encode()
    texts = [_override(key, value).split("=", 1)[1] for value in values]
    wrong = next((text for text in texts if "," in text), None)
    if wrong is not None:
        raise ValueError(f"{key}: found {wrong!r}, expected values without a comma")
    return f"{key}={', '.join(texts)}".encode()


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _sweep_table(path: Path, axes: int) -> list[dict[str, Any]]:
    with open(path, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    found = []
    for row in rows:
        cells = [(name[len("result_"):], _number(text)) for name, text in zip(head[axes + 2:-1], row[axes + 2:-1])]
        found.append({"values": dict(zip(head[1:axes + 1], row[1:axes + 1])), "status": row[axes + 1],
                      "figures": {name: value for name, value in cells if value is not None}, "message": row[-1]})
    return found


def sweep(scene: str | os.PathLike, axes: Mapping[str, Any], overrides: Mapping[str, Any] | None = None, *,
          out: str | os.PathLike | None = None, dim: int | None = None, threads: int = 0, memory_limit: float = 0,
          progress: bool | Callable[[str], None] | None = None, **values: Any) -> Sweep:
    """Run a scene file for every combination of a few values, as pd2d --sweep: a folder for each run, one table and one
    plot for all. Runs go one after the other, each with all threads.

        found = pdcorr.sweep("pin.scene", {"mean": "0.01, 0.05, 0.2 m/s", "h": ["10 um", "20 um"]}, out="out/pins")
        found["mean"], found["volume_loss"], found.runs[0].folder

    axes: for up to 8 keys a text or values; the last unit counts for numbers without. out: folder; None: that of the
    scene. progress: True: a line on a terminal; or a function that is called with its lines and with one for each run
    that has ended. The other parameters are those of run.

    A value that the scene refuses raises Error before the first run. A run that fails does not end the sweep: its
    message is in `runs`. Ctrl-C does, with KeyboardInterrupt and a table of what was done.
    """
    read = _of_file(scene, overrides, values, dim, threads, memory_limit)
    context, types = read.context, read.context.types
    desc, all_, run, count = types.pd_parameter_sweep_desc(), types.pd_parameter_sweep(), types.pd_run_desc(), types.pd_parameter_sweep_count()
    printer = _Printer(context, progress)
    asked = [_axis(key, value) for key, value in axes.items()]
    desc.axes, desc.axis_count = _ask(desc, scene, read, asked), len(asked)
    desc.folder = None if out is None else os.fsencode(out)
    run.print, run.stop = printer.function, printer.stop
    label = create_string_buffer(8192)
    labels, failures = [], {}
    context.call("pd_parameter_sweep_build", desc, all_)
    try:
        for index in range(all_.runs):
            context.library.pd_parameter_sweep_label(all_, index, label, sizeof(label))
            labels.append(label.value.decode("utf-8", "replace"))
        try:
            for index, text in enumerate(labels):
                try:
                    context.call("pd_parameter_sweep_run", all_, index, run)
                    printer.say(f"{text}: done")
                except Error as failure:
                    failures[index] = str(failure)
                    printer.say(f"{text}: {failure}")
        finally:
            printer.end()
            context.call("pd_parameter_sweep_write", all_, byref(count))
        folder, size = Path(os.fsdecode(all_.folder)), all_.axes
        shape = tuple(axis.count for axis in all_.axis[:size])
        names = [axis.name.decode("utf-8", "replace") for axis in all_.axis[:size]]
        name = all_.name.decode("utf-8", "replace")
    finally:
        context.free("pd_parameter_sweep_free", all_)
    rows = _sweep_table(folder / "sweep.csv", size)
    for index, message in failures.items():  # a run without its folder has left nothing for the table
        rows[index].update(status="failed", message=message)
    return Sweep(name=name, folder=folder, shape=shape, axes=names,
                 runs=[SweepRun(folder=folder / text.split(" ")[0], label=text, **row)
                       for text, row in zip(labels, rows)])
