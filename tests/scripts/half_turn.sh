#!/bin/sh
# What `validate2d smith_hutton` is held against: the problem of Smith and Hutton by finite elements of high order on a
# lattice that is graded towards the end of the inlet (Debian: python3-scipy). Galerkin's method without upwinding.
. tests/lib/script.sh
find_python 'import scipy'
[ "$python" ] || skip_all "scipy for Python is not installed"
cat > "$dir/half_turn.py" << 'END'
import re, sys
import numpy as np
import scipy.sparse as sparse
from numpy.polynomial import legendre
from scipy.sparse.linalg import spsolve


def lobatto(order):
    """Points of Gauss and Lobatto, and the matrix of derivatives there."""
    top = np.zeros(order + 1)
    top[order] = 1.0
    x = np.sort(np.concatenate(([-1.0], np.real(legendre.legroots(legendre.legder(top))), [1.0])))
    value = legendre.legval(x, top)
    d = np.array([[value[i] / (value[j] * (x[i] - x[j])) if i != j else 0.0 for j in range(order + 1)]
                  for i in range(order + 1)])
    d[0, 0] = -order * (order + 1) / 4.0
    d[order, order] = -d[0, 0]
    return x, d


def outlet(peclet, order, steps, ratio, places):
    """c at `places` of the outlet. The elements along an axis end at multiples of 0.05 or 0.1, and at 0.1 ratio^k."""
    plain = [0.05 * k for k in range(2, 21)] if peclet > 1e3 else [0.1 * k for k in range(1, 10)] + [0.97, 1.0]
    ahead = np.array(sorted([0.1 * ratio**k for k in range(1, steps + 1)] + plain))
    ends = np.concatenate((-ahead[::-1], [0.0], ahead)), np.concatenate(([0.0], ahead))
    x, d = lobatto(order)
    points, weights = legendre.leggauss(order + 3)
    at = legendre.legvander(points, order) @ np.linalg.inv(legendre.legvander(x, order))
    slope = at @ d
    nodes = [np.array([e[k] + (z + 1) / 2 * (e[k + 1] - e[k]) for k in range(len(e) - 1) for z in x[:-1]] + [e[-1]])
             for e in ends]

    def matrix(axis, left, right, factor):
        """Integral of factor(x) left right: 0 the value of a shape function, 1 its derivative."""
        e, size = ends[axis], len(nodes[axis])
        full = sparse.lil_matrix((size, size))
        for k in range(len(e) - 1):
            h = e[k + 1] - e[k]
            w = weights * h / 2 * factor(e[k] + (points + 1) / 2 * h)
            a, b = (slope * 2 / h if of else at for of in (left, right))
            full[k * order:k * order + order + 1, k * order:k * order + order + 1] += a.T @ (w[:, None] * b)
        return full.tocsr()

    def one(s):
        return np.ones_like(s)

    system = sparse.kron(matrix(0, 1, 1, one), matrix(1, 0, 0, one))
    system = (system + sparse.kron(matrix(0, 0, 0, one), matrix(1, 1, 1, one))) / peclet
    system = system + sparse.kron(matrix(0, 0, 1, lambda s: 1 - s * s), matrix(1, 0, 0, lambda s: 2 * s))
    system = (system + sparse.kron(matrix(0, 0, 0, lambda s: -2 * s), matrix(1, 0, 1, lambda s: 1 - s * s))).tocsr()
    px, py = (grid.ravel() for grid in np.meshgrid(*nodes, indexing="ij"))
    inlet = (py < 1e-14) & (px < 1e-14)
    given = inlet | (abs(px) > 1 - 1e-12) | (py > 1 - 1e-12)
    c = np.where(inlet, 1 + np.tanh(10 * (2 * px + 1)), 1 - np.tanh(10.0)) * given
    c[~given] = spsolve(system[~given][:, ~given].tocsc(), -(system @ c)[~given])
    row = c.reshape(len(nodes[0]), -1)[:, 0]
    found = []
    for place in places:
        k = min(max(np.searchsorted(ends[0], place - 1e-12) - 1, 0), len(ends[0]) - 2)
        z = 2 * (place - ends[0][k]) / (ends[0][k + 1] - ends[0][k]) - 1
        shape = np.linalg.solve(legendre.legvander(x, order), row[k * order:k * order + order + 1])
        found.append(legendre.legval(z, shape))
    return np.array(found)


text = open("cases/validate/turn_table.h").read()
text = text[text.index("turn_tables[3]"):]
kept = [np.array(re.findall(r"\d+\.\d{6}", one), float) for one in text.split("}}")[:3]]
places = np.arange(81) / 80
for peclet, values, order, steps, ratio, bound in ((10.0, kept[0], 6, 9, 0.25, 2e-6),
                                                   (100.0, kept[1], 6, 7, 0.25, 2e-6),
                                                   (1e6, kept[2], 7, 3, 0.3, 3e-6)):
    c = outlet(peclet, order, steps, ratio, places)
    worst = abs(c - values)[8:].max()
    print("Peclet number %g: off by %.1e" % (peclet, worst))
    if not worst < bound:
        sys.exit(1)
    # the table of the paper
    paper = {10.0: (1.402, 1.146, 0.946, 0.775, 0.621, 0.480, 0.349, 0.227, 0.111, 0.0),
             100.0: (1.940, 1.836, 1.627, 1.288, 0.869, 0.480, 0.209, 0.070, 0.017, 0.0),
             1e6: (2.0, 2.0, 1.999, 1.964, 1.0, 0.036, 0.001, 0.0, 0.0, 0.0)}[peclet]
    if not abs(c[8::8] - paper).max() < 5e-3:
        sys.exit(1)
END
"$python" "$dir/half_turn.py" > "$dir/log" 2>&1
verdict "the table of the outlet, and that of the paper"
score
