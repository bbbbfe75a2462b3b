#!/usr/bin/python3
"""Reference of the disc that dissolves, and with the argument 2 of the sphere: the problem along the radius by
Chebyshev collocation and Radau IIA of order 5.

Lengths in 50 um, times in s, C over its saturation. r = a + (R - a) s maps a(t) < r < R onto 0 < s < 1, so that
    dC/dt = D (C'' + p C'/r) + C' (1 - s) da/dt,   da/dt = -k (1 - C(a)),   -D C'(a) = (q - C(a)) k (1 - C(a)),
    C(R) = 0
with p = 1 (disc) or 2 (sphere) and q the content of the metal over the saturation. The start has a layer that grows as
the root of the time: steps are equal in that root. Prints the share lost with more and more nodes and steps.
"""
import sys

import numpy as np

P = int(sys.argv[1]) if len(sys.argv) > 1 else 1
D, K, Q, R, END = 1e-9 / 2.5e-9, 0.2, 10.0, 3.0, 10.0
ROOT = np.sqrt(6.0)
C = np.array([(4.0 - ROOT) / 10.0, (4.0 + ROOT) / 10.0, 1.0])
A = np.array([[(88 - 7 * ROOT) / 360, (296 - 169 * ROOT) / 1800, (-2 + 3 * ROOT) / 225],
              [(296 + 169 * ROOT) / 1800, (88 + 7 * ROOT) / 360, (-2 - 3 * ROOT) / 225],
              [(16 - ROOT) / 36, (16 + ROOT) / 36, 1.0 / 9.0]])


def chebyshev(n):
    """Nodes 0 = s_0 < ... < s_n = 1 and the matrix of the first derivative."""
    x = -np.cos(np.pi * np.arange(n + 1) / n)
    c = np.array([2.0] + [1.0] * (n - 1) + [2.0]) * (-1.0) ** np.arange(n + 1)
    d = np.outer(c, 1.0 / c) / (x[:, None] - x[None, :] + np.eye(n + 1))
    d -= np.diag(d.sum(axis=1))
    return (x + 1.0) / 2.0, 2.0 * d


def loss(nodes, steps):
    s, d = chebyshev(nodes)
    free = np.ones(nodes + 1) # 0: the row of the surface has no derivative in time
    free[0] = 0.0

    def rates(y):
        """y: C at all nodes but the rim, then the radius."""
        c, a = np.append(y[:-1], 0.0), y[-1]
        slope = d @ c / (R - a)
        speed = K * (1.0 - c[0])
        f = D * (d @ slope / (R - a) + P * slope / (a + (R - a) * s)) - slope * (1.0 - s) * speed
        f[0] = D * slope[0] + (Q - c[0]) * speed
        return np.append(f[:-1], -speed)

    y, size = np.append(np.zeros(nodes), 1.0), nodes + 1
    for k in range(steps):
        # t = END x^2: dy/dx = 2 END x dy/dt
        h = 1.0 / steps
        weight = 2.0 * END * (k + C) * h
        stage = np.tile(y, (3, 1))
        for _ in range(20):
            f = np.array([w * rates(z) for w, z in zip(weight, stage)])
            rest = free * (stage - y) - h * A @ f
            # The surface has no derivative: its equation itself.
            rest[:, 0] = f[:, 0] / weight
            matrix = np.zeros((3, size, 3, size))
            for j in range(3):
                slopes = np.empty((size, size))
                for i in range(size):
                    moved = stage[j].copy()
                    moved[i] += 1e-7
                    slopes[:, i] = (rates(moved) - f[j] / weight[j]) / 1e-7
                for i in range(3):
                    matrix[i, :, j, :] = -h * A[i, j] * weight[j] * slopes
                    matrix[i, 0, j, :] = slopes[0] if i == j else 0.0
                matrix[j, :, j, :] += np.diag(free)
            change = np.linalg.solve(matrix.reshape(3 * size, 3 * size), -rest.ravel()).reshape(3, size)
            stage += change
            if np.abs(change).max() < 1e-11:
                break
        else:
            raise SystemExit("Newton's method has not converged")
        y = stage[2]
    return 1.0 - y[-1] ** (P + 1)


for nodes, steps in ((16, 20), (24, 40), (32, 80), (40, 120)):
    print("%d nodes, %d steps: %.9f" % (nodes, steps, loss(nodes, steps)), flush=True)
