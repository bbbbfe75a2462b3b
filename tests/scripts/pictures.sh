#!/bin/sh
# Pictures of runs against other readers: a film with PIL, which knows APNG, vectors with xmllint and rsvg-convert. One
# range and one size for all frames; colours against the values of a probe.
. tests/lib/script.sh
find_python 'import PIL'
[ "$python" ] || skip_all "PIL for Python is not installed (Debian: python3-pil)"
cd "$dir" || exit 1

# A closed box with a hot spot that spreads: the largest value falls, and frames of their own would show the same.
cat > box.scene << 'END'
[grid]      h = 10 um   m = 3   box = 0 .. 300 um, 0 .. 200 um
[side x-]   C = 40 mol/m3
[transport] D = 1e-9 m2/s   initial = 400 mol/m3 * exp(-((x - 150 um)^2 + (y - 100 um)^2) / (40 um)^2)
[run]       until = 1 s
[output]    every = 0.25 s   fields = none   images = C, kind
[probe a]   at = 155 um, 105 um
END
cat > rod.scene << 'END'
[grid]      h = 1 um   m = 3   box = 0 .. 40 um
[side x-]   C = 2 mol/m3
[transport] D = 1e-9 m2/s
[run]       until = 1 s
[output]    every = 0.25 s   fields = none   images = C   animate = yes
END

# pd DIM SCENE OUT ARGUMENT...
pd() {
    program=$programs/pd$1d scene=$2 out=$3
    shift 3
    "$program" "$scene" --out "$out" --quiet --threads 1 "$@" > log 2>&1
}

pd 2 box.scene box output.animate=yes
verdict "a run with a film"
[ ! -e box/pictures.bin ]
verdict "what frames show is gone in the end"

cat > films.py << 'END'
import glob, sys
from PIL import Image, ImageChops
folder, field, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
film = Image.open('%s/%s_film.png' % (folder, field))
names = sorted(glob.glob('%s/%s_0*.png' % (folder, field)))
assert film.is_animated and film.n_frames == count == len(names), (film.n_frames, names)
assert film.info.get('loop', 0) == 0
sizes = {Image.open(name).size for name in names}
assert sizes == {film.size}, sizes
shown = []
for k, name in enumerate(names):
    film.seek(k)
    assert film.info['duration'] == (100 if k + 1 < count else 1000), film.info
    frame = film.convert('RGB')
    assert ImageChops.difference(frame, Image.open(name).convert('RGB')).getbbox() is None, name
    shown.append(frame.tobytes())
assert len(set(shown)) == count
END
$python films.py box C 5 > log 2>&1
verdict "a film shows the pictures of C, one after the other"
$python films.py box kind 5 > log 2>&1
verdict "a film shows the pictures of kind"

# a reader that knows no films sees the first frame
cat > first.py << 'END'
import struct, zlib
def rows(path):
    data, at, packed = open(path, 'rb').read(), 8, b''
    while at < len(data):
        size, kind = struct.unpack('>I4s', data[at:at + 8])
        if kind == b'IDAT': packed += data[at + 8:at + 8 + size]
        assert struct.unpack('>I', data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(data[at + 4:at + 8 + size])
        at += 12 + size
    assert at == len(data) and kind == b'IEND'
    return zlib.decompress(packed)
assert rows('box/C_film.png') == rows('box/C_000000_t0.0s.png')
END
$python first.py > log 2>&1
verdict "the first frame of a film is an image of its own"

# The range of the series: that of the largest value of all frames, which is the first one; all colours are as with this
# range given, and the probe has the colour of its value.
cat > colours.py << 'END'
import csv, glob, sys
from PIL import Image
folder, low, high = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
rows = list(csv.reader(line for line in open(folder + '/probes.csv') if line[0] != '#'))
series = [(float(r[0]), float(r[1])) for r in rows[1:]]
names, worst = sorted(glob.glob(folder + '/C_0*.png')), 0
for name in names:
    image = Image.open(name).convert('RGB')
    time = float(name.split('_t')[1][:-5])
    value = min(series, key=lambda s: abs(s[0] - time))[1]
    ink = (0x20, 0x21, 0x24)
    dark = [sum(image.getpixel((x, y)) == ink for y in range(image.height)) for x in range(image.width)]
    frames = [x for x in range(image.width) if dark[x] > 0.7 * max(dark)] # field and bar: left and right each
    left, right, bar = frames[0] + 1, frames[1], frames[2] + 1
    column = [y for y in range(image.height) if image.getpixel((left - 1, y)) == ink]
    top = column[0] + 1
    bottom = next(y for y in range(top, image.height) if y + 1 not in column)
    shown = image.getpixel((left + (right - left) * 155 // 300, bottom - (bottom - top) * 105 // 200 - 1))
    scale = [image.getpixel((bar + 3, y)) for y in range(bottom - 1, top - 1, -1)]
    distance = [sum((a - b) ** 2 for a, b in zip(shown, c)) for c in scale]
    found = low + (high - low) * distance.index(min(distance)) / (len(scale) - 1.0)
    if time > 0: worst = max(worst, abs(found - value) / (high - low)) # a probe has no row at the start
assert len(names) == 5 and worst < 0.01, worst
END
top=$(awk -v h=10e-6 'BEGIN { r = 5e-6; print 400 * exp(-2 * r * r / (40e-6 * 40e-6)) }')
pd 2 box.scene given "output.range=C 0 .. $top mol/m3"
verdict "a run with a range"
$python colours.py given 0 "$top" > log 2>&1
verdict "colours are those of the values"
cat > alike.py << 'END'
import glob, os, sys
from PIL import Image, ImageChops
for name in sorted(glob.glob(sys.argv[1] + '/C_0*.png')):
    a, b = (Image.open(os.path.join(f, os.path.basename(name))).convert('RGB') for f in sys.argv[1:3])
    assert a.size == b.size, (a.size, b.size)
    most = max(high for low, high in ImageChops.difference(a, b).getextrema())
    assert most <= int(sys.argv[3]), (name, most)
END
# the smallest value of all frames is that of the corners at the start, next to nothing
$python alike.py box given 6 > log 2>&1
verdict "the range of a series is that of all frames"
grep -q '^pictures.bin$' box/pdcorr.files && ! grep -q '^pictures.bin$' given/pdcorr.files
verdict "a given range needs no second drawing"

# 90 % of the values of a frame count: from the fields in the VTK files, as numpy has it
cat > share.py << 'END'
import glob, struct
low, high = 1e99, -1e99
for name in glob.glob('share/*.vti'):
    data = open(name, 'rb').read()
    at = data.index(b'_', data.index(b'<AppendedData')) + 1
    size = struct.unpack('<Q', data[at:at + 8])[0]
    values = sorted(struct.unpack('<%df' % (size // 4), data[at + 8:at + 8 + size]))
    def rank(place):
        k = min(int(place), len(values) - 2)
        return values[k] + (place - k) * (values[k + 1] - values[k])
    assert len(values) == 600
    low, high = min(low, rank(0.05 * 599)), max(high, rank(0.95 * 599))
print('%.9g %.9g' % (low, high))
END
pd 2 box.scene share "output.percentile=90 %" output.fields=C
verdict "a run with percentiles"
$python share.py > ends 2> log
verdict "the ends of 90 %"
read -r low high < ends
pd 2 box.scene ends_given "output.range=C $low mol/m3 .. $high mol/m3" && $python alike.py share ends_given 3 > log 2>&1
verdict "percentiles are those of all frames"

# the same with vectors
pd 2 box.scene vectors "output.format=png, svg" "output.images=C"
verdict "a run with vectors"
if command -v xmllint > /dev/null; then
    [ "$(ls vectors/C_0*.svg | wc -l)" = 5 ] && xmllint --noout --nonet vectors/*.svg > log 2>&1
    verdict "vectors are XML"
else
    echo "skipped: xmllint is not installed (Debian: libxml2-utils)"
    skipped=$((skipped + 1))
fi
if command -v rsvg-convert > /dev/null; then
    rsvg-convert vectors/C_000003_t0.75s.svg -o drawn.png > log 2>&1
    cat > drawn.py << 'END'
from PIL import Image
a, b = (Image.open(f).convert('RGB') for f in ('drawn.png', 'vectors/C_000003_t0.75s.png'))
assert a.size == b.size, (a.size, b.size)
# the field is the same, pixel by pixel; letters are of another font
ink = (0x20, 0x21, 0x24)
x = a.width // 3
column = [y for y in range(b.height) if b.getpixel((x, y)) == ink]
wrong = sum(max(abs(p - q) for p, q in zip(a.getpixel((i, j)), b.getpixel((i, j)))) > 2
            for i in range(x, 2 * x, 7) for j in range(column[0] + 4, column[-1] - 60, 7))
assert wrong == 0, wrong
letters = sum(a.getpixel((i, j)) != (255, 255, 255) for i in range(a.width) for j in range(column[0] - 2))
assert letters > 200, letters
END
    $python drawn.py >> log 2>&1
    verdict "vectors are drawn as pixels are"
else
    echo "skipped: rsvg-convert is not installed (Debian: librsvg2-bin)"
    skipped=$((skipped + 1))
fi

# The flow: a stream around a block whose speed doubles. The longest arrow belongs to the last frame, so the others are
# drawn again, and show the same as with --live, whose last picture is the last one.
cat > stream.scene << 'END'
[grid]        h = 10 um   box = 0 .. 300 um, 0 .. 200 um
[shape block] box = 100 um .. 160 um, 60 um .. 140 um   kind = wall
[side x-]     flow = inlet   profile = uniform   mean = 1 mm/s * (1 + t / 1 s)
[side x+]     flow = outlet
[flow]        rho = 1000 kg/m3   mu = 1e-3 Pa s
[transport]   D = 1e-9 m2/s
[run]         until = 1 s
[output]      every = 0.5 s   fields = none   images = v, p   animate = yes   width = 400   streamlines = v
              range = p -1 Pa .. 1 Pa   vectors = p   format = png, svg
END
pd 2 stream.scene stream --live
verdict "a run with streamlines and arrows"
$python films.py stream v 3 > log 2>&1 && $python films.py stream p 3 >> log 2>&1
verdict "films show the flow"
for end in png svg; do
    cmp stream/latest_v.$end stream/v_000002_t1.0s.$end > log 2>&1 &&
        cmp stream/latest_p.$end stream/p_000002_t1.0s.$end
    verdict "the last $end of a flow"
done
for n in 1 2; do
    OMP_NUM_THREADS=$n "$programs/pd2d" stream.scene --out "threads$n" --quiet --threads $n > log 2>&1
done
cmp threads1/v_film.png threads2/v_film.png > log 2>&1 && cmp threads1/v_000001_t0.5s.svg threads2/v_000001_t0.5s.svg
verdict "the same lines with two threads"
cat > arrows.py << 'END'
import glob, re, sys
# lengths of arrows from the vectors: pieces between a move and the fan of the head
def longest(name):
    paths = re.findall(r'<path d="([^"]*)"', open(name).read())
    lines = re.findall(r'M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)M', paths[1])
    return max(abs(float(c) - float(a)) for a, b, c, d in lines)
first, last = longest('stream/p_000000_t0.0s.svg'), longest('stream/p_000002_t1.0s.svg')
assert 1.8 < last / first < 2.2, (first, last)
for name in sorted(glob.glob('stream/p_0*.svg')): # 1 mm/s has the same length in all
    assert re.search('>[125] mm/s<', open(name).read()), name
END
$python arrows.py > log 2>&1
verdict "arrows are twice as long in a flow that is twice as fast"
if command -v xmllint > /dev/null; then
    xmllint --noout --nonet stream/*.svg > log 2>&1
    verdict "the vectors of a flow are XML"
fi

# 3D: the surface of metal that goes, in the colours of a field whose range grows, and in that of metal
cat > cube.scene << 'END'
[grid]      h = 1 um   m = 2   box = 0 .. 16 um, 0 .. 16 um, 0 .. 16 um
[shape cube] box = 0 .. 8 um, 0 .. 8 um, 0 .. 8 um   kind = solid   material = mg4ag
[transport] D = 1e-9 m2/s
[dissolve]  rate = 2 um/s
[run]       until = 2 s
[output]    every = 1 s   fields = none   surface = C   animate = yes   width = 300   format = png, svg
END
pd 3 cube.scene cube --live
verdict "a run with its surface"
$python films.py cube surface 3 > log 2>&1
verdict "a film shows the surface"
cmp cube/latest_surface.png cube/surface_000002_t2.0s.png > log 2>&1
verdict "the last surface"
pd 3 cube.scene plain output.surface=yes output.format=png output.animate=no
[ ! -e plain/pictures.bin ] && ! grep -q '^pictures.bin$' plain/pdcorr.files
verdict "a surface without a range is drawn once"
cat > shrinks.py << 'END'
import glob
from PIL import Image
# what is neither paper nor edge nor letter: the metal
seen = []
for name in sorted(glob.glob('plain/surface_0*.png')):
    image = Image.open(name).convert('RGB').crop((24, 52, 320, 340))
    seen.append(sum(n for n, (r, g, b) in image.getcolors(1 << 20) if 0 < b - r < 24 and b < 215 and r > 60))
assert len(seen) == 3 and seen[0] > seen[1] > seen[2] > 0, seen
left = 1.0 - float(open('plain/diagnostics.csv').read().split('\n')[-2].split(',')[1])
assert abs(seen[2] / seen[0] - left ** (2 / 3.0)) < 0.1, (seen, left) # the same shape, of which `left` is there
END
$python shrinks.py > log 2>&1
verdict "the surface shrinks as the metal goes"

# The same metal in grains: the legend has the smallest and the largest number of those that are seen.
sed 's/mg4ag/mg4ag   grain_size = 5 um/' cube.scene > grains.scene
pd 3 grains.scene grains output.surface=grain output.format=svg output.animate=no output.fields=grain "until=1 s"
cat > legend.py << 'END'
import glob, re, struct
data = open(sorted(glob.glob('grains/*.vti'))[0], 'rb').read()
at = data.index(b'_', data.index(b'<AppendedData')) + 1
size = struct.unpack('<Q', data[at:at + 8])[0]
grain = struct.unpack('<4096i', data[at + 8:at + 8 + 4 * 4096])
assert size == 4 * 4096, size
# the faces of the cube of 8^3 cells, in a box of 16^3; as it shrinks, others show that lie below these
outer = {grain[x + 16 * (y + 16 * z)] for x in range(8) for y in range(8) for z in range(8)
         if {x, y, z} & {0, 6, 7}}
svg = open(sorted(glob.glob('grains/surface_0*.svg'))[0]).read()
low, high = map(int, re.search('>([0-9]+) to ([0-9]+)<', svg).groups())
assert low < high and {low, high} <= outer, (low, high, sorted(outer))
END
$python legend.py > log 2>&1
verdict "grains of a surface have a legend"

# Percentiles of a surface: C grows along a face, and with 80 % its last tenth has one colour, that of the end.
cat > ends.scene << 'END'
[grid]      h = 1 um   m = 2   box = 0 .. 32 um, 0 .. 16 um, 0 .. 16 um
[shape bar] box = 0 .. 32 um, 0 .. 8 um, 0 .. 8 um   kind = solid   material = mg4ag
[transport] D = 1e-15 m2/s   initial = 100 mol/m3 * (x / 32 um)^4
[dissolve]  rate = 1e-9 um/s
[run]       until = 1e-6 s
[output]    every = 1e-6 s   fields = none   surface = C   width = 300   view = 0, 1, 0
END
pd 3 ends.scene whole
pd 3 ends.scene less output.percentile="80 %"
pd 3 ends.scene none output.images=none
[ -e none/diagnostics.csv ] && [ -z "$(ls none | grep surface)" ]
verdict "no surface with images = none"
cat > saturated.py << 'END'
import glob
from PIL import Image
def share(folder):
    image = Image.open(sorted(glob.glob(folder + '/surface_0*.png'))[0]).convert('RGB')
    rows = [[image.getpixel((x, y)) for x in range(26, 322)] for y in range(54, image.height - 50)]
    coloured = [[k for k, c in enumerate(row) if max(c) - min(c) > 20] for row in rows]
    best = max(range(len(rows)), key=lambda y: len(coloured[y]))
    row, columns = rows[best], coloured[best]
    runs = [] # of one colour from either end, since the view may be from the other side
    for way in (columns, columns[::-1]):
        first = row[way[3]]
        runs.append(next(k for k, x in enumerate(way) if k > 3 and max(abs(a - b) for a, b in zip(row[x], first)) > 2))
    return [run / float(len(columns)) for run in runs]
whole, less = share('whole'), share('less')
# a cell is a thirty-second; the other end of the fourth power is flat
assert min(whole) < 0.05 and 0.07 < min(less) < 0.14, (whole, less)
END
$python saturated.py > log 2>&1
verdict "percentiles of a surface"

# 3D: a contour in a slice. C is 80 mol/m3 on a sphere of 17.889 um, cut in a circle by the cells at z = 27 um.
cat > sphere.scene << 'END'
[grid]      h = 2 um   m = 2   box = 0 .. 40 um, 0 .. 40 um, 0 .. 40 um
[transport] D = 1e-15 m2/s
            initial = 100 mol/m3 * (1 - ((x - 20 um)^2 + (y - 20 um)^2 + (z - 20 um)^2) / (40 um)^2)
[run]       until = 1e-6 s
[output]    every = 1e-6 s   fields = none   images = C   slice = z 27 um   range = C 0 .. 100 mol/m3
            contours = C at 80 mol/m3
END
pd 3 sphere.scene circle && sed '/contours/d' sphere.scene > bare.scene && pd 3 bare.scene bare
verdict "slices with and without a contour"
cat > circle.py << 'END'
import glob, math
from PIL import Image
a, b = (Image.open(sorted(glob.glob(f + '/C_0*.png'))[0]).convert('RGB') for f in ('circle', 'bare'))
assert a.size == b.size, (a.size, b.size)
ink = (0x20, 0x21, 0x24)
dark = [sum(b.getpixel((x, y)) == ink for y in range(b.height)) for x in range(b.width)]
frames = [x for x in range(b.width) if dark[x] > 0.7 * max(dark)]
left, right = frames[0] + 1, frames[1]
column = [y for y in range(b.height) if b.getpixel((left - 1, y)) == ink]
top = column[0] + 1
bottom = next(y for y in range(top, b.height) if y + 1 not in column)
um = 40.0 / (right - left)
line = [((x + 0.5 - left) * um - 20, (bottom - y - 0.5) * um - 20) for x in range(left, right)
        for y in range(top, bottom) if sum(abs(p - q) for p, q in zip(a.getpixel((x, y)), b.getpixel((x, y)))) > 60]
radii = [math.hypot(*p) for p in line]
expected = math.sqrt(0.2 * 40 ** 2 - 7 ** 2)
mean = sum(radii) / len(radii)
ways = {int((math.atan2(y, x) + math.pi) / (2 * math.pi) * 72) % 72 for x, y in line}
assert abs(mean - expected) < 0.06, (mean, expected)
assert max(abs(r - expected) for r in radii) < 0.25, (min(radii), max(radii))
assert len(ways) == 72, len(ways)
END
$python circle.py > log 2>&1
verdict "a contour in a slice of a sphere is a circle"

# 1D: curves with one axis
pd 1 rod.scene rod
verdict "a film of curves"
$python films.py rod C 5 > log 2>&1
verdict "a film shows curves"
score
