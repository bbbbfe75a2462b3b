# A bar of bricks with nu = 0; the argument is n:kind:steps, n elements, steps of 300 us / steps.
import math, os, subprocess, sys
sys.path.insert(0, os.environ["CASE"] + "/..")
import calculix

words = sys.argv[1].split(":")
n, kind, steps = int(words[0]), words[1], int(words[2])
h = 1.0 / n
block = calculix.Block(kind, [k * h for k in range(n + 1)], [0.0, h], [0.0, h])
pulse = ["%.10g, %.10g" % (k * 4e-7, math.sin(math.pi * k / 100)**2) for k in range(101)] + ["1, 0"]
force = block.load(lambda x, y, z: (1e6, 0, 0))
text = calculix.run(
    block.mesh() + calculix.node_set("LINE", block.nodes(y=0, z=0)) +
    ["*MATERIAL, NAME=M", "*ELASTIC", "2e11, 0", "*DENSITY", "8000", "*SOLID SECTION, ELSET=BODY, MATERIAL=M",
     "*AMPLITUDE, NAME=PULSE"] + pulse +
    ["*BOUNDARY", "ALL, 2, 3", "*STEP, INC=100000", "*DYNAMIC, DIRECT, ALPHA=0", "%.12g, 3e-4" % (3e-4 / steps),
     "*CLOAD, AMPLITUDE=PULSE"] + ["%d, %d, %.14g" % f for f in force] +
    ["*NODE PRINT, NSET=LINE, FREQUENCY=%d" % steps, "U", "*END STEP"])
place = {number: block.place(at)[0] for at, number in block.node.items()}
rows = ["%.12g %.12g" % (place[int(r[0])], r[1]) for r in calculix.tables(text, "displacements")[-1]]
subprocess.run(["sh", os.environ["CASE"] + "/error.sh"], input="\n".join(rows) + "\n", text=True)
