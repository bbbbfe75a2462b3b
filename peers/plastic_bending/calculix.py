# A beam in plane strain, of bricks that are held across; the argument is n:kind:steps, n elements through the depth.
import os, re, sys
sys.path.insert(0, os.environ["CASE"] + "/..")
import calculix

words = sys.argv[1].split(":")
n, kind, steps = int(words[0]), words[1], int(words[2])
h = 0.016 / n
block = calculix.Block(kind, [k * h - 0.024 for k in range(3 * n + 1)], [k * h - 0.008 for k in range(n + 1)], [0.0, h])
place = {number: at for at, number in block.node.items()}
height = {number: block.place(at)[1] for at, number in block.node.items()}
held = ["%d, 1, 1, %.12g" % (k, side * 0.5 * 0.024 * height[k])
        for side, end in ((-1, 0), (1, -1)) for k in block.nodes(x=end)]
text = calculix.run(
    block.mesh() + calculix.node_set("FOOT", block.nodes(x=3 * n // 2, y=n // 2)) +
    calculix.node_set("ENDS", block.nodes(x=0) + block.nodes(x=-1)) +
    ["*MATERIAL, NAME=M", "*ELASTIC", "2e11, 0.3", "*PLASTIC", "2e8, 0", "*SOLID SECTION, ELSET=BODY, MATERIAL=M",
     "*BOUNDARY", "ALL, 3, 3", "FOOT, 2, 2", "*STEP, INC=10000", "*STATIC", "%g, 1, 1e-6, %g" % (1 / steps, 1 / steps),
     "*BOUNDARY"] + held + ["*NODE PRINT, NSET=ENDS", "RF", "*END STEP"])
# Work of the ends, whose displacements grow in proportion to the time.
work = time = force = 0.0
for now, table in zip(re.findall(r"forces .* time +(\S+)", text), calculix.tables(text, "forces")):
    last, force = force, sum(r[1] * 0.5 * block.place(place[int(r[0])])[0] * height[int(r[0])] for r in table)
    work += 0.5 * (force + last) * (float(now) - time)
    time = float(now)
print("peer work=%.12g" % (work / h))
