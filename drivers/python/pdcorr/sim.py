"""Scenes: step by step (Sim), or as whole runs with their files (run)."""
from __future__ import annotations

import math
import os
import re
import sys
import weakref
from ctypes import CFUNCTYPE, c_char_p, c_double, c_int, c_void_p, create_string_buffer, pointer, sizeof
from dataclasses import dataclass, field as member
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, NamedTuple, Sequence

import numpy as np

from . import _declared
from ._library import Context, Error, Status, view
from .physics import Physics, register
from .table import Table, read_table

Functions = Mapping[str, Callable[..., float]]


class Ledger(NamedTuple):
    """Amounts of an element, in its unit, per m of depth in planar 2D, per m2 in 1D. See pd_mass_balance in pdcorr.h.

    imbalance = solid + dissolved + carry + out - in_ - start; relative is its size over the solid at the start.
    """

    start: float
    solid_start: float
    solid: float
    volume_start: float
    volume: float
    dissolved: float
    carry: float
    out: float
    in_: float
    imbalance: float
    relative: float


# ---- scenes ----


def _is_text(scene: str | os.PathLike) -> bool:
    return isinstance(scene, str) and "\n" in scene


def _override(key: str, value: Any) -> str:
    """key=value as on the command line."""
    if isinstance(value, (bool, np.bool_)):
        return f"{key}={'yes' if value else 'no'}"
    if isinstance(value, (list, tuple)):
        return f"{key}={', '.join(map(str, value))}"
    if not isinstance(value, (str, int, float, np.number)):
        raise TypeError(f"{key}: found {type(value).__name__}, expected a text such as '10 um', a number or a list of"
                        " them")
    return f"{key}={value}"


def _dimension(scene: str | os.PathLike, overrides: Mapping[str, Any]) -> int:
    """How many axes a scene has: the ranges of its box."""
    box = overrides.get("grid.box", overrides.get("box"))
    if box is None:
        text = scene if _is_text(scene) else Path(scene).read_text(encoding="utf-8", errors="replace")
        text = re.sub(r"#.*", "", text)
        grid = re.search(r"\[grid\](.*?)(\[\s*[A-Za-z]|\Z)", text, re.DOTALL)
        found = re.search(r"\bbox\s*=(.*?)([A-Za-z_]\w*\s*=|\Z)", grid.group(1), re.DOTALL) if grid else None
        box = found.group(1) if found else ""
    ranges = _override("box", box).count("..")
    if ranges not in (1, 2, 3):
        raise ValueError("dim: the scene has no [grid] with a box that tells it, expected dim=1, 2 or 3")
    return ranges


class _Scene:
    """A scene that was read, with functions put into it. The setup belongs to the struct that has it as a member."""

    def __init__(self, scene: str | os.PathLike, overrides: Mapping[str, Any] | None, values: Mapping[str, Any],
                 dim: int | None, functions: Functions | None, threads: int, memory_limit: float,
                 physics: Sequence[type[Physics]] = ()):
        changes = {**(overrides or {}), **values}
        if not _is_text(scene) and not os.path.exists(scene):
            raise Error(Status.PD_ERR_FILE, f"{os.fspath(scene)}: there is no such file")
        self.context = Context(_dimension(scene, changes) if dim is None else dim, threads, memory_limit)
        register(self.context, physics)
        self.scene = scene
        self.changes = [_override(key, value).encode() for key, value in changes.items()]
        self.functions = dict(functions or {})
        self.callbacks: list[Any] = []  # the library has their addresses

    def read(self, setup: Any) -> None:
        """Read into the setup. On failure it holds nothing."""
        overrides = (c_char_p * max(len(self.changes), 1))(*self.changes)
        if _is_text(self.scene):
            self.context.call("pd_scene_parse", b"scene", self.scene.encode(), overrides, len(self.changes), setup)
        else:
            self.context.call("pd_scene_read", os.fsencode(self.scene), overrides, len(self.changes), setup)
        for key, fn in self.functions.items():
            self.put(setup, key, fn)

    def put(self, setup: Any, key: str, fn: Callable[..., float]) -> None:
        place = ["x", "y", "z"][: self.context.library.dim]
        names = place if key == "initial" else [*place, "t"]
        if key.split(".")[0] == "rate":
            names = ["C", "t", *place, "grain"]
        # the library knows the keys: it is asked before the parameters are looked at
        self.context.call("pd_setup_set_function", setup, key.encode(), self.context.types.pd_expr_fn(), None, 0)
        function, uses = self.context.function(fn, names, key)
        self.callbacks.append(function)
        self.context.call("pd_setup_set_function", setup, key.encode(), function, None, uses)


class _Line:
    """A line of progress that replaces itself, on a terminal alone."""

    def __init__(self) -> None:
        self.open = False

    def show(self, text: str) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{text}\033[K")
            sys.stderr.flush()
            self.open = True

    def end(self) -> None:
        if self.open:
            sys.stderr.write("\n")
        self.open = False


_STOP = CFUNCTYPE(c_int, c_void_p)


class _Printer:
    """What the library prints: texts by kind, and lines of progress on a terminal or to a function.

    every: all lines are lines of progress.
    """

    def __init__(self, context: Context, progress: bool | Callable[[str], None] | None, every: bool = False):
        self.texts: dict[int, list[str]] = {kind: [] for kind in _declared.ENUMS["pd_print_kind"].values()}
        self.function = context.types.pd_print_fn(self._show)
        self.stop = _STOP(lambda _user: self._guard.raised is not None)
        self._guard, self._progress, self._every, self._line = context.guard, progress, every, _Line()

    def say(self, text: str) -> None:
        """A line of progress."""
        if callable(self._progress):
            self._progress(text)
        elif self._progress:
            self._line.show(text)

    def _show(self, _user: Any, kind: int, text: bytes) -> None:
        try:
            said = text.decode("utf-8", "replace")
            if kind != _declared.PD_PRINT_PROGRESS:
                self.texts[kind].append(said)
            if self._every or kind == _declared.PD_PRINT_PROGRESS:
                self.say(said)
        except BaseException as raised:  # pylint: disable=broad-except
            self._guard.raised = raised

    def end(self) -> None:
        self._line.end()


# ---- step by step ----


@dataclass(frozen=True)
class Frame:
    """A simulation at an instant."""

    sim: "Sim" = member(repr=False)
    time: float  # [s]
    steps: int
    volume_loss: float  # [-]
    kept: Mapping[str, np.ndarray] = member(repr=False, default_factory=dict)

    def field(self, name: str) -> np.ndarray:
        """The field at the time of the frame, see Sim.field. Once the simulation has moved on, those that the frame
        kept are known."""
        if name in self.kept:
            return self.kept[name]
        if self.sim.steps != self.steps:
            raise ValueError(f"the frame at {self.time:g} s has not kept {name!r} and the simulation has moved on:"
                             f" ask for it before, or iterate over sim.frames(fields=[{name!r}])")
        return self.sim.field(name)


class Sim:
    """A scene, step by step. Writes no files.

        with pdcorr.Sim("pin.scene", h="10 um") as sim:
            for frame in sim:
                print(frame.time, frame.volume_loss, frame.field("C").max())

    scene: the path of a scene file, or its text, which has a newline in it. overrides, values: values in the place of
    those of the scene, by key or "section.key". dim: 1, 2 or 3; None: that of the box of the scene. functions: Python
    functions in the place of values of the scene, see the guide; their parameters are variables by name, all in SI.
    threads: 0: all. memory_limit [byte]: 0: none. physics: classes that inherit Physics. progress: True: a line on a terminal; or a function that is called
    with the simulation after each step.

    Building solves the flow: fields are there. Raises Error with the message of the library.
    """

    def __init__(self, scene: str | os.PathLike, overrides: Mapping[str, Any] | None = None, *, dim: int | None = None,
                 functions: Functions | None = None, threads: int = 0, memory_limit: float = 0,
                 progress: bool | Callable[["Sim"], None] | None = None, physics: Sequence[type[Physics]] = (),
                 **values: Any):
        self._scene = _Scene(scene, overrides, values, dim, functions, threads, memory_limit, physics)
        self._context = self._scene.context
        self._sim = self._context.types.pd_sim()
        # callbacks live as long as the model that calls them
        self._close = weakref.finalize(self, _close, self._context, self._sim, self._scene.callbacks)
        self._progress = progress
        self._failure = ""
        self._labels: dict[str, str] = {}
        self._scene.read(self._sim.setup)
        if threads == 0 and self._sim.setup.threads > 0:
            self._context.struct.threads = self._sim.setup.threads
        self._context.call("pd_sim_start", self._sim)

    # -- what it is

    @property
    def dim(self) -> int:
        """Space dimension."""
        return self._context.library.dim

    @property
    def name(self) -> str:
        """Of the scene: its file without folder and ending."""
        return self._open().setup.name.decode("utf-8", "replace")

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells of the box along x, y, z."""
        return tuple(self._open().model.grid.n)

    @property
    def h(self) -> tuple[float, ...]:
        """Spacings [m]."""
        return tuple(self._open().model.grid.h)

    @property
    def box(self) -> tuple[tuple[float, float], ...]:
        """Low and high end [m] of the box along each axis."""
        grid = self._open().model.grid
        return tuple(zip(grid.lo, grid.hi))

    @property
    def axes(self) -> tuple[np.ndarray, ...]:
        """Places [m] of the nodes, the middles of the cells, along each axis."""
        grid = self._open().model.grid
        return tuple(grid.lo[d] + (np.arange(grid.n[d]) + 0.5) * grid.h[d] for d in range(self.dim))

    # -- where it stands

    @property
    def time(self) -> float:
        """[s]"""
        return self._open().time

    @property
    def until(self) -> float:
        """End [s] that the scene asks for."""
        return self._open().end_time

    @property
    def every(self) -> float:
        """Time [s] between outputs that the scene asks for; 0: none on the way."""
        return self._open().setup.output_interval

    @property
    def steps(self) -> int:
        """Steps so far."""
        return self._open().steps

    @property
    def unsolved(self) -> int:
        """Steps, and the start, in which a solver missed its tolerance. The next step adds what transport and species left."""
        return self._open().model.time_loop.unsolved

    @property
    def volume_loss(self) -> float:
        """Share [-] of the volume of metal at the start that is gone."""
        return self._context.library.pd_time_loop_volume_loss(self._open().model.time_loop)

    @property
    def ledgers(self) -> dict[str, Ledger]:
        """Amounts now, by element: "metal", "mass", ..."""
        couple = self._open().model.time_loop
        return {couple.element[k].name.decode(): Ledger(*(getattr(couple.ledger[k], name)
                                                          for name, _ in couple.ledger[k]._fields_))
                for k in range(couple.elements)}

    @property
    def imbalance(self) -> float:
        """Worst relative imbalance [-] of all ledgers."""
        return self._context.library.pd_time_loop_imbalance(self._open().model.time_loop)

    @property
    def in_use(self) -> int:
        """Memory [byte] that the library holds for this simulation and its fields. 0: all of it is free again."""
        return self._context.in_use

    @property
    def fields(self) -> list[str]:
        """Names of all output fields that the scene has: what field takes."""
        setup, found, names = self._open().setup, self._context.types.pd_field_info(), []
        while self._context.library.pd_field_info_get(setup, len(names), found):
            names.append(found.name.decode())
        return names

    def field(self, name: str) -> np.ndarray:
        """An output field, one of fields, as it is now.

        [nx, ny, nz] [unit of label(name)], as many axes as the scene has: field[i, j] is the cell i along x and j along
        y. v is [dim, nx, ny, nz]; of displacements, u, it is the length. Axis x is the fastest in memory. The array is
        over memory of the library, without a copy; it is the caller's own: later steps and close() leave it as it is.
        """
        sim, found = self._open(), self._context.types.pd_field_view()
        self._context.call("pd_sim_field", sim, name.encode(), found)
        self._context.library.pd_sim_detach_view(sim, found)
        self._labels[name] = found.label.decode()
        shape, strides = list(found.n), list(found.stride)
        if found.components > 1:
            shape, strides = [found.components, *shape], [found.component_stride, *strides]
        context = self._context
        return view(found.data, shape, context, strides=strides, writeable=True,
                    finalize=lambda: context.free("pd_sim_free_view", found))

    def label(self, name: str) -> str:
        """Name and unit of a field, such as "C [mol/m3]"."""
        if name not in self._labels:
            self.field(name)
        return self._labels[name]

    # -- steps

    def step(self, limit: float | None = None) -> float:
        """One step, as long as its error allows, that does not pass the time `limit` [s]; None: until. The time [s]
        then."""
        sim = self._open()
        if self._failure:
            raise Error(Status.PD_ERR_STATE, f"the step before this one has failed: {self._failure}")
        try:
            self._context.call("pd_sim_step", sim, sim.end_time if limit is None else limit)
        except BaseException as raised:
            spoilt = isinstance(raised, Error) and raised.status not in (Status.PD_ERR_ARGUMENT, Status.PD_CANCELLED)
            if spoilt or self._context.guard.failed:
                self._failure = str(raised) or type(raised).__name__
            raise
        if callable(self._progress):
            self._progress(self)
        return sim.time

    def run_to(self, time: float) -> "Sim":
        """Steps up to the time [s]."""
        for _ in self.frames([time]):
            pass
        return self

    def frames(self, times: Iterable[float] | None = None, *, fields: Sequence[str] = ()) -> Iterator[Frame]:
        """Steps, with a Frame at each of the rising times [s], which keeps `fields`.

        None: now if no step has been made, then at multiples of `every`, and at `until`, as a run of the scene writes
        them.
        """
        line = _Line()
        try:
            if times is None and self.steps == 0:
                yield self._frame(fields)
            for limit in self._outputs() if times is None else times:
                if limit < self.time:
                    raise ValueError(f"times: found {limit:g} s, the simulation is at {self.time:g} s")
                while self.time < limit:
                    self.step(limit)
                    if self._progress is True and self.until > 0.0:
                        line.show(f"{self.name}: {self.time:.6g} s of {self.until:.6g} s,"
                                  f" {100.0 * self.volume_loss:.3g} % lost")
                yield self._frame(fields)
        finally:
            line.end()

    def __iter__(self) -> Iterator[Frame]:
        return self.frames()

    def _outputs(self) -> Iterator[float]:
        """Times [s] of outputs from now on, the bits of those of a run."""
        while self.time < self.until:
            limit = self.until
            if self.every > 0.0:
                limit = (math.floor(self.time / self.every * (1.0 + 1e-12)) + 1.0) * self.every
                if limit > self.until * (1.0 - 1e-12):
                    limit = self.until
            yield limit

    def _frame(self, fields: Sequence[str]) -> Frame:
        return Frame(self, self.time, self.steps, self.volume_loss, {name: self.field(name) for name in fields})

    # -- the end

    def close(self) -> None:
        """Free the model. Fields that were asked for stay. Allowed more than once; also done when the last reference
        goes."""
        self._close()

    def _open(self) -> Any:
        if not self._close.alive:
            raise ValueError("the simulation is closed")
        return self._sim

    def __enter__(self) -> "Sim":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        if not self._close.alive:
            return "<Sim: closed>"
        return f"<Sim {self.name!r}: {self.dim}D, {'x'.join(map(str, self.shape))} cells, at {self.time:g} s>"


def _close(context: Context, sim: Any, callbacks: list) -> None:
    context.free("pd_sim_close", sim)
    callbacks.clear()


# ---- whole runs ----


def _figure(figure: Any) -> str:
    """"volume_loss", "probe.a.C" """
    parts = (figure.section, figure.name, figure.key)
    return ".".join(part.decode() for part in parts if part and part != b"scene")


class Instant:
    """A run at an instant, for its observer, until that returns."""

    def __init__(self, context: Context, at: Any):
        self.context = context
        self.at: Any = at

    def _now(self) -> Any:
        if self.at is None:
            raise ValueError("the instant is over: keep copies of what is wanted later")
        return self.at.contents

    def _ask(self, name: str, *arguments: Any) -> None:
        """A call within that of the run."""
        self._now()
        status = getattr(self.context.library, name)(self.context.struct, self.at, *arguments)
        if status < 0:
            raise Error(status, self.context.struct.message.decode("utf-8", "replace"))

    @property
    def when(self) -> str:
        """"start", "step" or "end"."""
        return ("start", "step", "end")[self._now().stage]

    @property
    def time(self) -> float:
        """[s]"""
        return self._now().time

    @property
    def dt(self) -> float:
        """[s] of the last step"""
        return self._now().dt

    @property
    def until(self) -> float:
        """End [s] of the run."""
        return self._now().end_time

    @property
    def steps(self) -> int:
        """Steps so far."""
        return self._now().steps

    @property
    def volume_loss(self) -> float:
        """Share [-] of the volume of metal at the start that is gone."""
        return self._now().diagnostics.contents.volume_loss

    def field(self, name: str) -> np.ndarray:
        """A copy of an output field, see Sim.field."""
        found = self.context.types.pd_field_view()
        self._ask("pd_snapshot_get_field", name.encode(), found)
        shape, strides = list(found.n), [8 * stride for stride in found.stride]
        if found.components > 1:
            shape, strides = [found.components, *shape], [8 * found.component_stride, *strides]
        values = np.ctypeslib.as_array(found.data, (found.components * found.component_stride,))
        return np.lib.stride_tricks.as_strided(values, shape, strides).copy(order="K")

    @property
    def figures(self) -> dict[str, float]:
        """All that the run watches, in SI: "volume_loss", "probe.a.C", "total.all.dissolved" and so on."""
        list_ = self.context.types.pd_scalar_outputs()
        try:
            self._ask("pd_snapshot_get_outputs", list_)
            return {_figure(f): f.value for f in list_.list[: list_.count]}
        finally:
            self.context.free("pd_scalar_outputs_free", list_)


@dataclass(frozen=True)
class Estimated:
    """A figure of a run and its error, from runs on coarser lattices."""

    value: float  # [unit]
    unit: str
    coarser: tuple[float, float]  # [unit] at 2 h and 4 h; NaN: none
    order: float  # [-] of convergence
    assumed: bool  # the order is that of the method
    error: float  # [-] of the value, over its size; NaN: unknown
    minor: bool  # too small among figures of its sort for its relative error to say much


@dataclass(frozen=True)
class Estimate:
    """Errors of the figures of a run, by Richardson's extrapolation."""

    figures: dict[str, Estimated]  # by names as those of Instant.figures
    coarser_runs: int  # runs it rests on, 1 or 2
    without: str  # why there is no second one; "": there is
    worst: str | None  # name of the figure with the largest error, but for minor ones
    spacing: tuple[float, ...] | None  # [m] largest h for the wanted accuracy; None: none was wanted

    @property
    def error(self) -> float:
        """The largest error [-], but for minor figures; NaN: unknown."""
        return math.nan if self.worst is None else self.figures[self.worst].error


def _estimate(context: Context, setup: Any, desc: Any, figures: Any, accuracy: float | None) -> Estimate:
    """The coarser runs of one that is done."""
    found = context.types.pd_richardson()
    context.call("pd_richardson_run", setup, desc, figures, found)
    try:
        spacing = None
        if accuracy is not None:
            h = (c_double * context.library.dim)()
            context.library.pd_richardson_suggest_spacing(found, accuracy, h)
            spacing = tuple(h)
        list_ = found.list[: found.count]
        return Estimate(
            figures={_figure(e.figure): Estimated(e.figure.value, e.figure.unit.decode(), tuple(e.coarser), e.order,
                                                  bool(e.is_formal_order), e.error, bool(e.is_minor)) for e in list_},
            coarser_runs=found.coarser_runs, without=found.missing_reason.decode("utf-8", "replace"),
            worst=_figure(list_[found.worst_output].figure) if found.worst_output >= 0 else None, spacing=spacing)
    finally:
        context.free("pd_richardson_free", found)


@dataclass(frozen=True)
class Result:
    """What a run has come to."""

    name: str
    folder: Path
    stopped: bool
    time: float  # [s] reached
    steps: int
    h: float  # [m] along x
    m: float  # [-]
    volume_loss: float  # [-]
    ledger: float  # [-] worst imbalance
    residual: float  # [-] of the last flow solve
    front: float | None  # [m] bond-based corrosion: how far metal has turned fluid
    flux: float | None  # [-] worst deviation of the flow far downstream from that far upstream
    unknowns: int
    unsolved: int  # steps, and the start, in which a solver missed its tolerance
    bytes_per_node: float
    line: str  # for scripts, as pd2d prints it
    estimate: Estimate | None = member(repr=False)  # of the errors; None: not asked for, or impossible, see notes
    summary: list[str] = member(repr=False)  # what is modelled
    notes: list[str] = member(repr=False)  # what the user should know

    @property
    def tables(self) -> dict[str, Table]:
        """The tables in the folder by their names without .csv, read now."""
        return {path.stem: read_table(path) for path in sorted(self.folder.glob("*.csv"))}


def run(scene: str | os.PathLike, overrides: Mapping[str, Any] | None = None, *, out: str | os.PathLike | None = None,
        dim: int | None = None, functions: Functions | None = None, threads: int = 0, memory_limit: float = 0,
        progress: bool | Callable[[str], None] | None = None, dry: bool = False, checkpoint: float | None = None,
        resume: bool = False, observe: Callable[[Instant], Any] | None = None, estimate_error: bool = False,
        accuracy: float | None = None, physics: Sequence[type[Physics]] = (), **values: Any) -> Result:
    """Run a scene to its end and write its files, as pd2d does.

    out: folder; None: that of the scene. progress: True: a line on a terminal; or a function that is called with such
    lines. dry: write nothing. checkpoint: wall time [s] between checkpoints, 0: after each step; None: none. resume: go
    on from the checkpoint in the folder. observe: a function that is called with an Instant at the start, after each
    step and at the end; what is true ends the run, with complete files. estimate_error: run the scene with two and four
    times h, too, for an Estimate. accuracy: relative, such as 0.01: pick settings of the scene for it, and estimate.
    The other parameters are those of Sim.

    Ctrl-C ends it with KeyboardInterrupt, and with a checkpoint where there are some.
    """
    if functions and (checkpoint is not None or resume):
        raise ValueError("functions: found beside checkpoint or resume, which do not know functions")
    read = _Scene(scene, overrides, values, dim, functions, threads, memory_limit, physics)
    context, types = read.context, read.context.types
    setup, desc, result = types.pd_setup(), types.pd_run_desc(), types.pd_run_result()
    figures, printer, estimate = types.pd_scalar_outputs(), _Printer(context, progress), None
    notes = printer.texts[_declared.PD_PRINT_NOTE]

    def look(_user: Any, _context: Any, at: Any) -> int:
        instant = Instant(context, at)
        try:
            return 1 if observe(instant) else 0
        except BaseException as raised:  # pylint: disable=broad-except
            context.guard.raised = raised
            return 1
        finally:
            instant.at = None

    desc.print, desc.stop = printer.function, printer.stop
    if estimate_error or accuracy is not None:
        desc.figures = pointer(figures)
    if observe is not None:
        desc.observe = types.pd_snapshot_fn(look)
    desc.no_files = dry
    desc.checkpoints = checkpoint is not None or resume
    desc.checkpoint_every = 600.0 if checkpoint is None else checkpoint
    desc.resume = resume
    if out is not None:
        desc.folder = os.fsencode(out)
    try:
        read.read(setup)
        if accuracy is not None:
            said = create_string_buffer(640)
            context.call("pd_tolerance_presets_apply", accuracy, setup, said, sizeof(said))
            notes.append(said.value.decode("utf-8", "replace"))
        context.call("pd_run", setup, desc, result)
        folder = Path(os.fsdecode(setup.folder)) if out is None else Path(out)
        if desc.figures and not figures.count:
            notes.append("no error estimate: the scene watches nothing: add a [probe NAME] or another section of that"
                         " sort")
        elif desc.figures and not result.stopped:
            try:
                estimate = _estimate(context, setup, desc, figures, accuracy)
            except Error as failure:
                notes.append(f"no error estimate: {failure}")
    finally:
        printer.end()
        context.free("pd_scalar_outputs_free", figures)
        context.free("pd_setup_free", setup)
    text = create_string_buffer(1024)
    context.library.pd_run_format_result(result, text, sizeof(text))
    plain = ("time", "steps", "h", "m", "volume_loss", "residual", "unknowns", "bytes_per_node")
    return Result(
        name=result.name.decode("utf-8", "replace"), folder=folder, stopped=bool(result.stopped),
        front=result.corrosion_depth if result.has_front else None, flux=result.flux_error if result.has_flux else None,
        ledger=result.mass_balance_error, unsolved=result.unconverged_steps, line=text.value.decode(), estimate=estimate,
        summary=printer.texts[_declared.PD_PRINT_SUMMARY], notes=notes,
        **{name: getattr(result, name) for name in plain})
