"""Kernels: a lattice, its operators on numpy arrays, and their sparse matrices."""
from __future__ import annotations

import enum
import weakref
from ctypes import POINTER, c_double, c_uint8, cast
from dataclasses import dataclass
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np

from . import _declared
from ._library import Context, view

Kind = enum.IntEnum("Kind", {name[3:]: value for name, value in _declared.ENUMS["pd_kind"].items()})
Kind.__doc__ = "What a node is: INACTIVE, FLUID, SOLID, WALL, or a ghost: INLET, OUTLET, IMAGE."

_SIDES = {name[8:].lower(): value for name, value in _declared.ENUMS["pd_side"].items()}
_OPERATORS = {name[7:].lower(): value for name, value in _declared.ENUMS["pd_csr_operator"].items()}


# ---- shapes ----


@dataclass(frozen=True)
class Shape:
    """A shape by its signed distance, negative inside. Made by ball, box, cylinder, half_space and set operations."""

    kind: int
    a: tuple[float, ...] = ()
    b: tuple[float, ...] = ()
    r: float = 0.0
    axis: int = 0
    children: tuple["Shape", ...] = ()

    def flatten(self, dim: int, into: list["Shape"]) -> int:
        """Append the shape behind its children; its place."""
        if any(len(point) not in (0, dim) for point in (self.a, self.b)):
            raise ValueError(f"shape: found a place with {len(self.a)} coordinates in {dim}D")
        for child in self.children:
            child.flatten(dim, into)
        into.append(self)
        return len(into) - 1


def ball(centre: Sequence[float], radius: float) -> Shape:
    """A ball, a disc in 2D [m]."""
    return Shape(_declared.PD_SHAPE_BALL, tuple(centre), r=float(radius))


def box(lo: Sequence[float], hi: Sequence[float]) -> Shape:
    """A box between two corners [m]."""
    return Shape(_declared.PD_SHAPE_BOX, tuple(lo), tuple(hi))


def cylinder(axis: int, point: Sequence[float], radius: float) -> Shape:
    """An unbounded cylinder around axis 0, 1 or 2 through a point [m]; planar 2D: its section."""
    return Shape(_declared.PD_SHAPE_CYLINDER, tuple(point), r=float(radius), axis=axis)


def half_space(point: Sequence[float], normal: Sequence[float]) -> Shape:
    """All places x with (x - point) . normal < 0 [m]."""
    return Shape(_declared.PD_SHAPE_HALF_SPACE, tuple(point), tuple(normal))


def union(*shapes: Shape) -> Shape:
    """What is in any of them, 8 at most."""
    return Shape(_declared.PD_SHAPE_UNION, children=shapes)


def intersect(*shapes: Shape) -> Shape:
    """What is in all of them, 8 at most."""
    return Shape(_declared.PD_SHAPE_INTERSECT, children=shapes)


def difference(shape: Shape, *others: Shape) -> Shape:
    """The first without the others, 8 in all at most."""
    return Shape(_declared.PD_SHAPE_DIFFERENCE, children=(shape, *others))


def complement(shape: Shape) -> Shape:
    """All that is not in it."""
    return Shape(_declared.PD_SHAPE_COMPLEMENT, children=(shape,))


def _shapes(types: Any, dim: int, wanted: Sequence[Shape | None]) -> tuple[Any, list[int | None]]:
    """An array of pd_shape that holds those that are wanted, and their places."""
    flat: list[Shape] = []
    places = [None if shape is None else shape.flatten(dim, flat) for shape in wanted]
    array = (types.pd_shape * max(len(flat), 1))()
    for k, shape in enumerate(flat):
        if len(shape.children) > len(array[k].child):
            raise ValueError(f"shape: found {len(shape.children)} parts, expected {len(array[k].child)} at most")
        array[k].type, array[k].radius, array[k].axis = shape.kind, shape.r, shape.axis
        array[k].child_count = len(shape.children)
        for d in range(dim):
            array[k].a[d] = shape.a[d] if shape.a else 0.0
            array[k].b[d] = shape.b[d] if shape.b else 0.0
        place = k  # children stand before it, each behind its own
        for n in reversed(range(len(shape.children))):
            place -= 1
            array[k].child[n] = place
            place -= _size(shape.children[n]) - 1
    return array, places


def _size(shape: Shape) -> int:
    return 1 + sum(map(_size, shape.children))


# ---- the lattice ----


class Stencil(NamedTuple):
    """The bonds of a whole family. lap f = sum lap (f_j - f_i), grad f = sum grad (f_j - f_i)."""

    offset: np.ndarray  # [count, dim] in cells
    xi: np.ndarray  # [count, dim] [m]
    lap: np.ndarray  # [count] [1/m2]
    grad: np.ndarray  # [count, dim] [1/m]
    m: float  # [-] horizon over the spacing


class Csr(NamedTuple):
    """An operator on a set of nodes as a sparse matrix by rows, over memory of the library. See pd_csr in pdcorr.h.

    (operator f)[node] = matrix f[node] + given part. Nodes are indices into a flat field, f.ravel(order="F").
    """

    node: np.ndarray  # [rows]
    row: np.ndarray  # [rows + 1]
    column: np.ndarray  # [row[-1]]
    weight: np.ndarray  # [row[-1]] [unit of the operator]
    given_row: np.ndarray  # [rows + 1]
    given: np.ndarray  # [given_row[-1]] nodes outside of the set
    given_weight: np.ndarray  # [given_row[-1]] [unit of the operator]

    def matrix(self) -> Any:
        """The matrix [rows, rows] as a scipy.sparse.csr_matrix."""
        from scipy.sparse import csr_matrix  # pylint: disable=import-outside-toplevel

        return csr_matrix((self.weight, self.column, self.row), shape=(len(self.node),) * 2)

    def given_matrix(self, total: int) -> Any:
        """The given part as a scipy.sparse.csr_matrix [rows, total]; total: nodes of the lattice."""
        from scipy.sparse import csr_matrix  # pylint: disable=import-outside-toplevel

        return csr_matrix((self.given_weight, self.given, self.given_row), shape=(len(self.node), total))


class Lattice:
    """Stencil, nodes and bonds of a box, for programs that use the operators alone.

        lattice = pdcorr.Lattice(h=(1e-6, 1e-6), box=((0, 100e-6), (0, 50e-6)))
        f = lattice.zeros()
        f[lattice.inside] = ...
        lap = lattice.laplacian(f)

    h: spacings [m], one for each axis. box: low and high end [m] along each axis. m: horizon over the spacing. sides:
    what closes the box, such as {"x-": "periodic", "x+": "periodic"}: wall (default), inlet, outlet, periodic, mirror.
    solid, wall: shapes. axisymmetric: 2D, x is the axis and y the distance from it. threads: 0: all.

    Fields run over all nodes, with ghosts around the box: scalars [np0, np1, ...], vectors [dim, np0, np1, ...], axis 0
    the fastest in memory, as `zeros` makes them.
    """

    def __init__(self, h: Sequence[float], box: Sequence[Sequence[float]], *, m: float = 3.0,  # pylint: disable=W0621
                 sides: Mapping[str, str] | None = None, solid: Shape | None = None, wall: Shape | None = None,
                 axisymmetric: bool = False, threads: int = 0):
        if len(h) != len(box) or any(len(ends) != 2 for ends in box):
            raise ValueError(f"box: found {len(box)} ranges, expected a low and a high end for each of {len(h)}"
                             " spacings")
        self._context = Context(len(h), threads)
        self.dim = len(h)
        types = self._context.types
        self._lattice, desc = types.pd_lattice(), types.pd_lattice_desc()
        self._shapes, places = _shapes(types, self.dim, (solid, wall))
        desc.stencil.m = m
        for d in range(self.dim):
            desc.stencil.h[d], (desc.grid.lo[d], desc.grid.hi[d]) = h[d], box[d]
        for side, kind in (sides or {}).items():
            names = [axis + end for axis in "xyz"[: self.dim] for end in "-+"]
            if side not in names or kind not in _SIDES:
                raise ValueError(f"sides: found {side!r}: {kind!r}, expected one of {', '.join(names)} and one of"
                                 f" {', '.join(_SIDES)}")
            desc.grid.side[names.index(side)] = _SIDES[kind]
        pointer = POINTER(types.pd_shape)
        desc.grid.shapes = self._shapes if solid or wall else pointer()
        for name, place in zip(("solid", "wall"), places):
            if place is not None:
                setattr(desc.grid, name, pointer(self._shapes[place]))
        desc.grid.axisymmetric = axisymmetric
        # the shapes live as long as the grid, which borrows them
        weakref.finalize(self, _free_lattice, self._context, self._lattice, self._shapes)
        self._context.call("pd_lattice_build", desc, self._lattice)
        grid = self._lattice.grid
        self.cells = tuple(grid.n)  # of the box
        self.shape = tuple(grid.padded)  # with ghosts
        self.ghost = grid.ghost  # layers around the box
        self.inside = tuple(slice(self.ghost, self.ghost + n) for n in self.cells)  # of a scalar: the box

    @property
    def total(self) -> int:
        """Nodes, with ghosts."""
        return self._lattice.grid.total

    @property
    def in_use(self) -> int:
        """Memory [byte] that the library holds for the lattice and its matrices."""
        return self._context.in_use

    @property
    def kind(self) -> np.ndarray:
        """[np0, np1, ...] Kind of every node."""
        return view(self._lattice.grid.kind, self.shape, self, strides=self._lattice.grid.stride)

    @property
    def whole(self) -> np.ndarray:
        """[np0, np1, ...] 1 where a fluid node has all bonds of its family."""
        row = view(self._lattice.bonds.row_of_node, self.shape, self, strides=self._lattice.grid.stride)
        return (self.kind == Kind.FLUID) & (row < 0)

    @property
    def axes(self) -> tuple[np.ndarray, ...]:
        """Places [m] of the nodes along each axis, with ghosts."""
        grid = self._lattice.grid
        return tuple(grid.lo[d] + (np.arange(grid.padded[d]) - grid.ghost + 0.5) * grid.h[d] for d in range(self.dim))

    @property
    def stencil(self) -> Stencil:
        """Bonds and weights of a whole family."""
        s = self._lattice.stencil
        wide = (s.count, self.dim)
        return Stencil(view(s.offset, wide, self), view(s.xi, wide, self), view(s.laplacian_weight, wide[:1], self),
                       view(s.gradient_weight, wide, self), s.m)

    def zeros(self, components: int = 1) -> np.ndarray:
        """A field of zeros: a scalar, or a vector of dim components."""
        if components not in (1, self.dim):
            raise ValueError(f"components: found {components}, expected 1 or {self.dim}")
        shape = self.shape if components == 1 else (*self.shape, components)
        array = np.zeros(shape, order="F")
        return array if components == 1 else np.moveaxis(array, -1, 0)

    def _field(self, array: Any, name: str, vector: bool) -> Any:
        """The address of a field that is one."""
        vector = vector and self.dim > 1
        shape = (self.dim, *self.shape) if vector else self.shape
        expected = f"expected float64 {list(shape)} with axis x the fastest in memory, as zeros() makes it"
        if not isinstance(array, np.ndarray):
            raise TypeError(f"{name}: found {type(array).__name__}, {expected}")
        flat = np.moveaxis(array, 0, -1) if vector and array.ndim == len(shape) else array
        if array.dtype != np.float64 or array.shape != shape or not flat.flags.f_contiguous or not array.flags.aligned:
            raise ValueError(f"{name}: found {array.dtype} {list(array.shape)} with strides {array.strides},"
                             f" {expected}")
        if not array.flags.writeable:
            raise ValueError(f"{name}: found a field that cannot be written, expected one that can: ghosts are filled")
        return cast(array.ctypes.data, POINTER(c_double))

    def _result(self, out: np.ndarray | None, vector: bool, source: np.ndarray) -> np.ndarray:
        out = self.zeros(self.dim if vector else 1) if out is None else out
        if np.may_share_memory(out, source):
            raise ValueError("out: found the memory of the field itself, expected another one")
        return out

    def fill_ghosts(self, f: np.ndarray) -> np.ndarray:
        """Ghosts behind periodic and mirror sides get what they stand for; those of a vector behind outlets, too."""
        self._filled(f, "f", self.dim > 1 and np.ndim(f) > self.dim)
        return f

    def laplacian(self, f: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Laplacian [unit of f / m2] of a scalar at fluid nodes; others of `out` stay as they are.

        The ghosts of f behind periodic and mirror sides are filled; those of inlets and outlets hold what the caller
        put there. See pd_op_laplacian in pdcorr.h, also for what it is at surfaces.
        """
        out = self._result(out, False, f)
        self._operate("pd_op_laplacian", f, out)
        return out

    def gradient(self, f: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Gradient [dim, ...] [unit of f / m] of a scalar at fluid nodes; ghosts as for the laplacian."""
        out = self._result(out, True, f)
        self._operate("pd_op_gradient", f, out, to_vector=True)
        return out

    def divergence(self, u: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Divergence [unit of u / m] of a vector at fluid nodes; ghosts as for the laplacian."""
        out = self._result(out, False, u)
        self._operate("pd_op_divergence", u, out, of_vector=True)
        return out

    def diffuse(self, diffusivity: np.ndarray, f: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """div(D grad f) [unit of f / s] with the diffusivity D [m2/s] at nodes; ghosts of both as for the laplacian."""
        out = self._result(out, False, f)
        self._operate("pd_op_diffusion", f, out, self._filled(diffusivity, "diffusivity"))
        return out

    def csr(self, operator: str = "laplacian", *, axis: int = 0, diffusivity: np.ndarray | None = None,
            mask: np.ndarray | None = None) -> Csr:
        """An operator as a sparse matrix: laplacian, diffuse (with `diffusivity`), gradient or divergence (of `axis`).

        mask: [np0, np1, ...] bool, the nodes of the set as far as they are fluid; None: all fluid nodes.
        """
        if operator not in _OPERATORS:
            raise ValueError(f"operator: found {operator!r}, expected one of {', '.join(_OPERATORS)}")
        types = self._context.types
        desc, csr = types.pd_csr_desc(), types.pd_csr()
        desc.op, desc.axis = _OPERATORS[operator], axis
        if diffusivity is not None:
            desc.diffusivity = self._filled(diffusivity, "diffusivity")
        if mask is not None:
            if np.shape(mask) != self.shape or np.asarray(mask).dtype != np.bool_:
                raise ValueError(f"mask: found {np.asarray(mask).dtype} {list(np.shape(mask))}, expected bool"
                                 f" {list(self.shape)}")
            flat = np.asarray(mask).ravel(order="F").astype(np.uint8)
            desc.mask = cast(flat.ctypes.data, POINTER(c_uint8))
        owner = _Owner(self)
        weakref.finalize(owner, self._context.free, "pd_csr_free", csr)
        self._context.call("pd_csr_build", self._lattice.bonds, desc, csr)
        row = view(csr.row_begin, [csr.rows + 1], owner)
        given_row = view(csr.prescribed_begin, [csr.rows + 1], owner)
        entries, given = [int(row[-1])], [int(given_row[-1])]
        return Csr(view(csr.node, [csr.rows], owner), row, view(csr.column, entries, owner),
                   view(csr.weight, entries, owner), given_row, view(csr.prescribed, given, owner),
                   view(csr.prescribed_weight, given, owner))

    def _filled(self, array: np.ndarray, name: str, vector: bool = False) -> Any:
        """The address of a field whose ghosts are filled."""
        pointer = self._field(array, name, vector)
        fill = "pd_ghosts_set_vector" if vector else "pd_ghosts_set_scalar"
        getattr(self._context.library, fill)(self._lattice.bonds.ghosts, pointer)
        return pointer

    def _operate(self, name: str, f: np.ndarray, out: np.ndarray, *more: Any, of_vector: bool = False,
                 to_vector: bool = False) -> None:
        result = self._field(out, "out", to_vector)
        self._context.call(name, self._lattice.bonds, *more, self._filled(f, "f", of_vector), result)

    def __repr__(self) -> str:
        return f"<Lattice: {self.dim}D, {'x'.join(map(str, self.cells))} cells>"


class _Owner:
    """Of a matrix; keeps its lattice."""

    def __init__(self, lattice: Lattice):
        self.lattice = lattice


def _free_lattice(context: Context, lattice: Any, _shapes_of_grid: Any) -> None:
    context.free("pd_lattice_free", lattice)
