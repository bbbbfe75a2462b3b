"""A physics in Python: a section of scenes, fields that the rest of the scene sees, and how they step."""
from __future__ import annotations

import math
from ctypes import CFUNCTYPE, byref, c_double, c_int, c_void_p, cast
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np

from . import _declared
from ._library import Context, Status


class Key(NamedTuple):
    """A key of the section: unit of the SI ("-": none), default ("required", or "-": it may be left out), meaning.

    bounds: (low, high) [SI] of a value that is constant. choices: words, such as "slow, fast"; the value is the number
    of the one that the scene has, from 0 on.
    """

    unit: str
    default: str
    meaning: str
    bounds: tuple[float, float] | None = None
    choices: str = ""


class Physics:
    """A physics that a scene has when it has its section; pdcorr.Sim and pdcorr.run take such classes.

        class Cooling(pdcorr.Physics):
            section, meaning = "cooling", "a body that cools"
            keys = {"k": pdcorr.Key("1/s", "required", "rate"), "start": pdcorr.Key("K", "300 K", "at the start")}
            fields = {"T": "K"}

            def start(self):
                self.T[...] = self.value("start")

            def step(self, time, dt):
                self.T *= np.exp(-self.value("k") * dt)

    fields: names and units; each is an array [nx, ny, nz] of the cells, as an attribute: change it in place. places:
    "fluid", "metal", "both" (default) or "all", by field. max_step: longest step [s] of the scene. Checkpoints keep the
    fields. What a method raises stops the run and comes out.
    """

    section = ""
    meaning = ""
    keys: Mapping[str, Sequence[Any]] = {}
    fields: Mapping[str, str] = {}
    places: Mapping[str, str] = {}
    max_step = math.inf

    def __init__(self, view: Any):
        grid = view.contents.grid.contents
        dim = len(grid.n)
        self._view = view
        self._arrays = {name: np.zeros(grid.total) for name in self.fields}
        kinds = np.ctypeslib.as_array(grid.kind, (grid.total,))
        first = sum(grid.ghost * grid.stride[d] for d in range(dim))

        def cells(flat: np.ndarray) -> np.ndarray:
            strides = [grid.stride[d] * flat.itemsize for d in range(dim)]
            return np.lib.stride_tricks.as_strided(flat[first:], list(grid.n), strides)

        self.kind = cells(kinds)  # see Kind
        self.h = tuple(grid.h)  # [m]
        self.axes = tuple(grid.lo[d] + (np.arange(grid.n[d]) + 0.5) * grid.h[d] for d in range(dim))  # [m]
        self.time = 0.0  # [s]
        for name, flat in self._arrays.items():
            setattr(self, name, cells(flat))

    def start(self) -> None:
        """Set the fields at the start."""

    def step(self, time: float, dt: float) -> None:
        """Advance the fields from `time` [s] by dt [s]."""
        raise NotImplementedError

    def value(self, key: str, t: float | None = None) -> np.ndarray:
        """Value [SI] of a key in the cells at t [s], by default now; NaN: it is not given."""
        index, found = list(self.keys).index(key), np.empty([len(a) for a in self.axes])
        for at in np.ndindex(*found.shape):
            x = (c_double * len(self.axes))(*(a[k] for a, k in zip(self.axes, at)))
            found[at] = self._view.contents.value(self._view, index, x, self.time if t is None else t)
        return found

    def prescribed(self, side: int, x: Sequence[float], t: float | None = None) -> float | None:
        """Value [SI] at x [m] that side 0, 1, 2, ... (x-, x+, y-, ...) prescribes of the first field; None: none."""
        found, place = c_double(), (c_double * len(self.axes))(*x)
        time = self.time if t is None else t
        return found.value if self._view.contents.prescribed(self._view, side, place, time, byref(found)) else None


class _Registered:
    """A class of physics in a context: the struct that the library has, and the objects that it has built."""

    def __init__(self, context: Context, kind: type[Physics]):
        types = context.types
        self._guard, self._kind, self._states = context.guard, kind, {}
        place = {"fluid": 0, "metal": 1, "both": 2, "all": 3}
        keys = (types.pd_key * max(len(kind.keys), 1))()
        for row, (name, key) in zip(keys, kind.keys.items()):
            row.keys, (row.unit, row.default_text, row.meaning) = name.encode(), (text.encode() for text in key[:3])
            key = Key(*key)
            if key.bounds:
                row.low, row.high = key.bounds
            if key.choices:
                row.type, row.choices = _declared.PD_KEY_CHOICE, key.choices.encode()
        fields = (types.pd_physics_field * max(len(kind.fields), 1))()
        for row, (name, unit) in zip(fields, kind.fields.items()):
            row.name, row.unit = name.encode(), unit.encode()
            row.place = place[kind.places.get(name, "both")]
        self._kept: list[Any] = [keys, fields]
        self._name = kind.section.encode()
        self.struct = types.pd_physics_type()
        self.struct.section = types.pd_key_section(kind.section.encode(), b"", kind.meaning.encode(), keys,
                                                   len(kind.keys))
        self.struct.field, self.struct.fields = fields, len(kind.fields)
        self.struct.bytes_per_node = 8.0 * len(kind.fields)
        slots = dict(types.pd_physics_type._fields_)
        for name in ("build", "free", "set_process"):
            setattr(self.struct, name, slots[name](getattr(self, "_" + name)))
        values = CFUNCTYPE(c_void_p, c_void_p, c_int)(self._values)  # callbacks return no pointers of a type
        self._kept.append(values)
        self.struct.values = cast(values, slots["values"])
        slots = dict(types.pd_physics._fields_)
        self._callbacks = {name: slots[name](getattr(self, "_" + name)) for name in ("max_run_step", "attempt",
                                                                                     "checkpoint")}

    def _try(self, work: Any) -> int:
        """Status of work(); what it raises is kept for the caller of the library."""
        try:
            return int(work() or 0)
        except BaseException as raised:  # pylint: disable=broad-except
            self._guard.raised = raised
            return int(Status.PD_CANCELLED)

    def _build(self, _ctx: Any, view: Any, state: Any) -> int:
        def work() -> None:
            own = self._kind(type(view)(view.contents))
            own.start()
            number = max(self._states, default=0) + 1
            self._states[number] = own
            state[0] = number
        return self._try(work)

    def _free(self, _ctx: Any, state: int) -> None:
        self._states.pop(state, None)

    def _set_process(self, state: int, process: Any) -> None:
        process.contents.name = self._name
        process.contents.self = state
        process.contents.has_substeps = 1
        for name, callback in self._callbacks.items():
            setattr(process.contents, name, callback)

    def _values(self, state: int, field: int) -> int:
        flat = list(self._states[state]._arrays.values())[field]
        return flat.ctypes.data

    def _max_run_step(self, _ctx: Any, state: int, step: Any) -> int:
        def work() -> None:
            step.contents.dt = min(step.contents.dt, float(self._states[state].max_step))
        return self._try(work)

    def _attempt(self, _ctx: Any, state: int, step: Any) -> int:
        def work() -> None:
            own = self._states[state]
            own.step(step.contents.time, step.contents.end - step.contents.time)
            own.time = step.contents.end
        return self._try(work)

    def _checkpoint(self, ctx: Any, state: int, archive: Any) -> int:
        def work() -> int:
            own, to = self._states[state], archive.contents
            time = c_double(own.time)
            status = to.transfer(ctx, to.user, f"{own.section}.time".encode(), cast(byref(time), c_void_p), 8, 1)
            own.time = time.value
            for name, flat in own._arrays.items():
                if status == 0:
                    status = to.transfer(ctx, to.user, f"{own.section}.{name}".encode(), flat.ctypes.data,
                                         flat.itemsize, flat.size)
            return status
        return self._try(work)


def register(context: Context, kinds: Sequence[type[Physics]]) -> None:
    """Make the physics known to the scenes of a context."""
    for kind in kinds:
        if not (isinstance(kind, type) and issubclass(kind, Physics)):
            raise TypeError(f"physics: found {kind!r}, expected classes that inherit pdcorr.Physics")
        own = _Registered(context, kind)
        context.physics.append(own)  # the library has its address
        context.call("pd_physics_type_register", own.struct)
