"""The shared libraries, and calls into them: errors, interrupts and exceptions of callbacks."""
from __future__ import annotations

import ctypes
import enum
import inspect
import math
import os
import signal
import threading
import weakref
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

import numpy as np

from . import _declared

Status = enum.IntEnum("Status", _declared.ENUMS["pd_status"])
Status.__doc__ = "What a function of the library returns: 0 done, negative failed, positive see the library."

# How threads wait, read by OpenMP when it is loaded: a busy wait loses against other programs.
_OPENMP = {name: getattr(_declared, "PD_" + name) for name in ("OMP_WAIT_POLICY", "GOMP_SPINCOUNT")}


class Error(Exception):
    """A call that the library refused or that failed, with its message.

    status: the Status of the call.
    """

    def __init__(self, status: int, message: str):
        super().__init__(message)
        self.status = Status(status)

    def __reduce__(self):
        return Error, (int(self.status), str(self))


class Library:
    """A shared library of one dimension. `types` has the structures of pdcorr.h, functions are attributes."""

    def __init__(self, dim: int):
        folders = [Path(__file__).parent]
        if os.environ.get("PDCORR_LIBRARY"):
            folders.insert(0, Path(os.environ["PDCORR_LIBRARY"]))
        paths = [folder / f"libpdcorr{dim}d.so" for folder in folders]
        path = next((p for p in paths if p.exists()), None)
        if path is None:
            raise ImportError(f"no libpdcorr{dim}d.so in {' or '.join(map(str, folders))}: `make python` builds it")
        self.dim = dim
        self.types = _declared.declare(dim)
        added = {name: value for name, value in _OPENMP.items() if name not in os.environ}
        os.environ.update(added)
        try:
            self._dll = ctypes.CDLL(str(path))
        finally:
            for name in added:
                del os.environ[name]

    def __getattr__(self, name: str) -> Any:
        """A public function by its name without the dimension."""
        if name.startswith("_") or name not in self.types.functions:
            raise AttributeError(name)
        result, arguments = self.types.functions[name]
        function = getattr(self._dll, f"{name}_{self.dim}d")
        function.restype, function.argtypes = result, arguments
        setattr(self, name, function)
        return function


@lru_cache(maxsize=None)
def load(dim: int) -> Library:
    """The library of a dimension, loaded once."""
    if dim not in (1, 2, 3):
        raise ValueError(f"dim: found {dim!r}, expected 1, 2 or 3")
    return Library(dim)


class _Guard:
    """What Python code has raised while the library was running. Asked between iterations by the library."""

    def __init__(self) -> None:
        self.raised: BaseException | None = None
        self.failed = False  # in a function that the library takes values from

    def poll(self, _user, _doing, _count) -> int:
        return self.raised is not None

    @contextmanager
    def interrupts(self) -> Iterator[None]:
        """Handlers of SIGINT run while the library does; what they raise stops it.

        The handler is wrapped, because Python drops what is raised at the entry of a callback.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        previous = signal.getsignal(signal.SIGINT)
        if not callable(previous):
            yield
            return

        def handler(number, frame):
            try:
                previous(number, frame)
            except BaseException as raised:  # pylint: disable=broad-except
                self.raised = raised

        signal.signal(signal.SIGINT, handler)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, previous)

    def take(self) -> BaseException | None:
        raised, self.raised = self.raised, None
        return raised


class Context:
    """A pd_ctx and the calls that go by it, one at a time.

    All that the library allocates lives in a context. Objects hold theirs, so that it goes with the last of them.
    """

    def __init__(self, dim: int, threads: int = 0, memory_limit: float = 0):
        self.library = load(dim)
        self.types = self.library.types
        self.struct = self.types.pd_ctx()
        self.library.pd_ctx_init(self.struct)
        self.struct.threads = _whole("threads", threads, 0, 1024)
        if not 0 <= memory_limit < 2**63:
            raise ValueError(f"memory_limit: found {memory_limit!r}, expected bytes")
        self.struct.alloc.limit = int(memory_limit)
        self.guard = _Guard()
        self.struct.cancel = self.types.pd_cancel_fn(self.guard.poll)
        self.physics: list[Any] = []  # of Python, which the struct points at
        self._lock = threading.Lock()
        self._garbage: list[tuple[Callable, tuple]] = []

    @property
    def in_use(self) -> int:
        """Memory [byte] that objects of this context hold."""
        return self.struct.in_use

    def call(self, name: str, *arguments) -> Status:
        """Call a function whose first argument is the context. Raises what it fails with, or what Python code in it
        raised."""
        function = getattr(self.library, name)
        with self.guard.interrupts():  # around the lock, which no interrupt leaves locked
            if not self._lock.acquire(blocking=False):
                raise Error(Status.PD_ERR_ARGUMENT, f"{name}: found a call within a call or of another thread, expected"
                                                    " one after the other for each simulation or lattice")
            try:
                status = function(self.struct, *arguments)
            finally:
                self._lock.release()
        raised = self.guard.take()
        self.collect()
        if raised is not None:
            raise raised
        if status is not None and status < 0:
            raise Error(status, self.struct.message.decode("utf-8", "replace"))
        return Status(status or 0)

    def free(self, name: str, *arguments) -> None:
        """Call a function that frees, at once or as soon as the call that is running has ended."""
        self._garbage.append((getattr(self.library, name), arguments))
        self.collect()

    def collect(self) -> None:
        while self._garbage and self._lock.acquire(blocking=False):
            try:
                while self._garbage:
                    function, arguments = self._garbage.pop()
                    function(self.struct, *arguments)
            finally:
                self._lock.release()

    def function(self, fn: Callable[..., float], names: Sequence[str], what: str) -> tuple[Any, int]:
        """A pd_expr_fn that calls fn with those of the variables `names` that it has as parameters, and its `uses`."""
        if not callable(fn):
            raise TypeError(f"a function for {what!r}: found {type(fn).__name__}")
        parameters = list(inspect.signature(fn).parameters.values())
        unknown = [p.name for p in parameters if p.name not in names and p.default is p.empty]
        if unknown or any(p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD) for p in parameters):
            found = ", ".join(str(p) for p in parameters)
            raise ValueError(f"a function for {what!r}: found parameters ({found}), expected some of"
                             f" {', '.join(names)}")
        places = [(p.name, names.index(p.name)) for p in parameters if p.name in names]
        guard = self.guard

        def value(_user, variables) -> float:
            if guard.raised is not None:
                return math.nan
            try:
                return float(fn(**{name: variables[k] for name, k in places}))
            except BaseException as raised:  # pylint: disable=broad-except
                guard.raised, guard.failed = raised, True
                return math.nan

        return self.types.pd_expr_fn(value), sum(1 << k for _, k in places)


def _whole(name: str, value: Any, low: int, high: int) -> int:
    """value as an int within the bounds."""
    if isinstance(value, bool) or int(value) != value or not low <= value <= high:
        raise ValueError(f"{name}: found {value!r}, expected a whole number from {low} to {high}")
    return int(value)


class _Memory:
    """Memory of the library as numpy sees it; holds its owner."""

    def __init__(self, address: int, shape: Sequence[int], strides: Sequence[int], dtype, writeable: bool, owner: Any):
        self.owner = owner
        self.__array_interface__ = {
            "data": (address, not writeable), "shape": tuple(shape), "strides": tuple(strides),
            "typestr": np.dtype(dtype).str, "version": 3,
        }


def view(pointer: Any, shape: Sequence[int], owner: Any, *, dtype=None, strides: Sequence[int] | None = None,
         writeable: bool = False, finalize: Callable[[], None] | None = None) -> np.ndarray:
    """An array over memory of the library, without a copy. It keeps `owner` alive, and calls finalize when it goes.

    pointer: a ctypes pointer or array. strides [elements]; None: axis 0 is the slowest.
    """
    element = pointer._type_
    if strides is None:
        strides = [int(np.prod(shape[k + 1:], dtype=np.int64)) for k in range(len(shape))]
    size = ctypes.sizeof(element)
    memory = _Memory(ctypes.addressof(pointer.contents), shape, [size * s for s in strides],
                     np.dtype(element) if dtype is None else dtype, writeable, owner)
    if finalize is not None:
        weakref.finalize(memory, finalize)
    return np.asarray(memory)
