"""off.py N FILE: what one turn does to the cone, from the cells of a VTK file of pdcorr."""
import array, math, sys
n = int(sys.argv[1])
with open(sys.argv[2], "rb") as f:
    data = f.read()
# Behind the mark stands the number of bytes, then the cells, x fastest.
at = data.index(b"_", data.index(b"<AppendedData")) + 9
c = array.array("f", data[at:at + 4 * n * n])
off = size = 0.0
for k, v in enumerate(c):
    x, y = (k % n + 0.5) / n, (k // n + 0.5) / n
    cone = max(1.0 - math.hypot(x - 0.5, y - 0.25) / 0.15, 0.0)
    off, size = off + abs(v - cone), size + cone
print("peer l1=%.8g peak=%.8g" % (off / size, max(c)))
