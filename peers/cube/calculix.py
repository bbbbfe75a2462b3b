# A clamped cube; the argument is n:kind:power: n elements along an edge, graded towards edges by the power.
import os, sys
sys.path.insert(0, os.environ["CASE"] + "/..")
import calculix

words = sys.argv[1].split(":")
n, kind, power = int(words[0]), words[1], float(words[2])
along = [(k / n)**power for k in range(n + 1)]
across = [0.5 * (2 * k / n)**power if 2 * k < n else 1 - 0.5 * (2 - 2 * k / n)**power for k in range(n + 1)]
block = calculix.Block(kind, along, across, across)
text = calculix.run(
    block.mesh() + calculix.node_set("CLAMPED", block.nodes(x=0)) +
    ["*MATERIAL, NAME=M", "*ELASTIC", "1e5, 0.3", "*SOLID SECTION, ELSET=BODY, MATERIAL=M",
     "*BOUNDARY", "CLAMPED, 1, 3", "*STEP", "*STATIC"] +
    calculix.loads(block.load(lambda x, y, z: (0, 100, 0))) +
    ["*EL PRINT, ELSET=BODY, TOTALS=ONLY", "ELSE", "*END STEP"])
print("peer energy=%.12g" % calculix.tables(text, "total internal energy")[0][0][0])
