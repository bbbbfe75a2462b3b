# A beam in plane strain, of bricks that are held across; the argument is n:kind, n elements through the depth.
import os, sys
sys.path.insert(0, os.environ["CASE"] + "/..")
import calculix

n, kind = int(sys.argv[1].split(":")[0]), sys.argv[1].split(":")[1]
h = 0.016 / n
block = calculix.Block(kind, [k * h for k in range(5 * n + 1)], [k * h - 0.008 for k in range(n + 1)], [0.0, h])
shear = lambda y: 1e6 * (1 - (y / 0.008)**2)
forces = block.load(lambda x, y, z: (0, shear(y), 0))
forces += block.load(lambda x, y, z: (2.5e9 * y, -shear(y), 0), end=0)
middle = [k for k in block.nodes(x=0) if k in block.nodes(y=n // 2)]
end = [k for k in block.nodes(x=-1) if k in block.nodes(y=n // 2)]
text = calculix.run(
    block.mesh() + calculix.node_set("LEFT", middle) + calculix.node_set("RIGHT", end) +
    ["*MATERIAL, NAME=M", "*ELASTIC", "7e10, 0.499", "*SOLID SECTION, ELSET=BODY, MATERIAL=M",
     "*BOUNDARY", "ALL, 3, 3", "LEFT, 1, 2", "RIGHT, 2, 2", "*STEP", "*STATIC"] + calculix.loads(forces) +
    ["*EL PRINT, ELSET=BODY, TOTALS=ONLY", "ELSE", "*END STEP"])
print("peer energy=%.12g" % (calculix.tables(text, "total internal energy")[0][0][0] / h))
