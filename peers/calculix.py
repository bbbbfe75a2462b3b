"""For the CalculiX files of all cases: bricks of a block, its input file, and what it prints.

    import os, sys; sys.path.insert(0, os.environ["CASE"] + "/.."); import calculix
"""
import re, subprocess

# Corners and middles of edges of a brick, as CalculiX numbers them, in halves of an element.
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
EDGES = [(1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
         (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]


class Block:
    """Bricks between the planes of x, y, z; kind: C3D8, C3D8I, C3D20, C3D20R."""

    def __init__(self, kind, x, y, z):
        self.kind, self.planes, self.node, self.elements = kind, (x, y, z), {}, []
        self.quadratic = kind.startswith("C3D20")
        shape = CORNERS + EDGES if self.quadratic else CORNERS
        for k in range(len(z) - 1):
            for j in range(len(y) - 1):
                for i in range(len(x) - 1):
                    self.elements.append([self.number(2 * i + a, 2 * j + b, 2 * k + c) for a, b, c in shape])

    def number(self, *at):
        return self.node.setdefault(at, len(self.node) + 1)

    def place(self, at):
        """Coordinates of the node `at`, in halves of elements."""
        return [0.5 * (p[a // 2] + p[(a + 1) // 2]) for a, p in zip(at, self.planes)]

    def nodes(self, **planes):
        """Numbers of the nodes on planes: x=0 is the first plane, x=-1 the last one."""
        ends = {k: 2 * (len(self.planes["xyz".index(k)]) - 1) if v < 0 else 2 * v for k, v in planes.items()}
        return [n for at, n in self.node.items() if all(at["xyz".index(k)] == v for k, v in ends.items())]

    def load(self, traction, end=-1):
        """Forces (node, axis, force) of a traction (x, y, z) -> 3 numbers on the face x = end; Simpson's rule for
        quadratic elements, of bilinear ones the mean at corners."""
        at_x = 0 if end == 0 else 2 * (len(self.planes[0]) - 1)
        y, z, force = self.planes[1], self.planes[2], {}
        for k in range(len(z) - 1):
            for j in range(len(y) - 1):
                area = (y[j + 1] - y[j]) * (z[k + 1] - z[k])
                shape = [(0, 0), (2, 0), (2, 2), (0, 2)] + ([(1, 0), (2, 1), (1, 2), (0, 1)] if self.quadratic else [])
                # Points of Gauss in both directions, with the shapes of the face there.
                for r in (-0.7745966692414834, 0.0, 0.7745966692414834):
                    for s in (-0.7745966692414834, 0.0, 0.7745966692414834):
                        weight = (5 if r else 8) * (5 if s else 8) / 81.0 * area / 4
                        t = traction(self.place((at_x, 0, 0))[0], y[j] + (r + 1) / 2 * (y[j + 1] - y[j]),
                                     z[k] + (s + 1) / 2 * (z[k + 1] - z[k]))
                        for b, c in shape:
                            p, q = b - 1, c - 1
                            if not self.quadratic:
                                value = (1 + p * r) * (1 + q * s) / 4
                            elif p and q:
                                value = (1 + p * r) * (1 + q * s) * (p * r + q * s - 1) / 4
                            elif p:
                                value = (1 + p * r) * (1 - s * s) / 2
                            else:
                                value = (1 - r * r) * (1 + q * s) / 2
                            n = self.number(at_x, 2 * j + b, 2 * k + c)
                            for axis in range(3):
                                if t[axis]:
                                    force[n, axis + 1] = force.get((n, axis + 1), 0.0) + weight * value * t[axis]
        return [(n, axis, f) for (n, axis), f in force.items()]

    def mesh(self):
        lines = ["*NODE, NSET=ALL"]
        for at, n in self.node.items():
            lines.append("%d, %.12g, %.12g, %.12g" % ((n,) + tuple(self.place(at))))
        lines.append("*ELEMENT, TYPE=%s, ELSET=BODY" % self.kind)
        for e, of in enumerate(self.elements, 1):
            words = [str(e)] + [str(n) for n in of]
            lines += [", ".join(words[k:k + 15]) + ("," if k + 15 < len(words) else "")
                      for k in range(0, len(words), 15)]
        return lines


def node_set(name, numbers):
    return ["*NSET, NSET=" + name] + ["%d," % n for n in numbers]


def loads(forces):
    return ["*CLOAD"] + ["%d, %d, %.14g" % f for f in forces]


def run(lines, name="job"):
    """Run CalculiX on the lines; the text of NAME.dat."""
    with open(name + ".inp", "w") as f:
        f.write("\n".join(lines) + "\n")
    done = subprocess.run(["ccx", name], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode or "*ERROR" in done.stdout:
        raise SystemExit(done.stdout[-2000:])
    with open(name + ".dat") as f:
        return f.read()


def tables(text, head):
    """Rows of numbers of all tables whose title begins with head, a table an increment."""
    found = []
    for part in re.split(r"\n\s*(?=[a-z][^\n]*\n)", text):
        title, _, rest = part.strip().partition("\n")
        if title.startswith(head):
            found.append([[float(w) for w in line.split()] for line in rest.splitlines() if line.strip()])
    return found
