#!/bin/sh
# slow: yes
# PNG files against an independent decoder and encoder: Python's zlib and struct. What pdcorr writes is decoded by
# Python, and images of every supported kind packed by Python are read by pdcorr. Skipped without python3.
. tests/lib/script.sh
CC=${CC:-cc}
python3 -c 'import zlib, struct' 2> /dev/null || skip_all "python3 with zlib is not installed"
cd "$dir" || exit 1

# `program write`: five PNGs and their pixels as raw files. `program read FILE OUT`: the reverse.
cat > program.c <<'END'
#include "pdcorr_app.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int fail(const pd_ctx *ctx)
{
    printf("%s\n", ctx->message);
    return 1;
}

static int dump(const char *path, const pd_image *image)
{
    size_t size = (size_t)image->width * (size_t)image->height * (size_t)image->channels;
    FILE *f = fopen(path, "wb");
    if (!f) return 1;
    fprintf(f, "%d %d %d\n", image->width, image->height, image->channels);
    return fwrite(image->pixels, 1, size, f) != size || fclose(f) != 0;
}

static int save(pd_ctx *ctx, const char *name, pd_image *image)
{
    char path[64];
    snprintf(path, sizeof path, "%s.png", name);
    if (pd_png_write(ctx, path, image) != PD_OK) return fail(ctx);
    snprintf(path, sizeof path, "%s.raw", name);
    return dump(path, image);
}

static int write_all(pd_ctx *ctx)
{
    static uint8_t pixels[3 * 257 * 131];
    static double values[90 * 60], x[50], y[50];
    uint32_t noise = 1;
    for (size_t i = 0; i < sizeof pixels; i++) {
        noise = noise * 1664525u + 1013904223u;
        pixels[i] = (uint8_t)(i < sizeof pixels / 2 ? noise >> 24 : i / 3 % 257 + i / 771);
    }
    pd_image gray = {257, 131, 1, pixels}, rgb = {257, 131, 3, pixels}, dot = {1, 1, 3, pixels}, drawn;
    if (save(ctx, "gray", &gray) || save(ctx, "rgb", &rgb) || save(ctx, "dot", &dot)) return 1;
    pd_field_plot picture;
    memset(&picture, 0, sizeof picture);
    for (int k = 0; k < 90 * 60; k++) values[k] = sin(k % 90 * 0.1) * cos(k / 90 * 0.1);
    picture.nx = 90;
    picture.ny = 60;
    picture.values = values;
    picture.hi[0] = 90e-6;
    picture.hi[1] = 60e-6;
    picture.map = PD_COLOUR_MAP_DIVERGING;
    picture.title = "title";
    picture.label = "v_x [m/s]";
    if (pd_field_plot_draw_image(ctx, &picture, &drawn) != PD_OK) return fail(ctx);
    if (save(ctx, "picture", &drawn)) return 1;
    pd_image_free(ctx, &drawn);
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    for (int k = 0; k < 50; k++) y[k] = sqrt(x[k] = k);
    plot.count = 1;
    plot.series[0].name = "root";
    plot.series[0].x = x;
    plot.series[0].y = y;
    plot.series[0].count = 50;
    if (pd_plot_draw_image(ctx, &plot, &drawn) != PD_OK) return fail(ctx);
    if (save(ctx, "plot", &drawn)) return 1;
    pd_image_free(ctx, &drawn);
    return ctx->in_use != 0;
}

int main(int argc, char **argv)
{
    pd_ctx ctx;
    pd_image image;
    pd_ctx_init(&ctx);
    if (argc == 2) return write_all(&ctx);
    if (argc != 4) return 2;
    if (pd_png_read(&ctx, argv[2], &image) != PD_OK) return fail(&ctx);
    int status = dump(argv[3], &image);
    pd_image_free(&ctx, &image);
    return status;
}
END

cat > check.py <<'END'
import random, struct, subprocess, sys, zlib

passed = failed = 0

def check(name, condition, detail=''):
    global passed, failed
    if condition: passed += 1
    else:
        failed += 1
        print('%s: failed %s' % (name, detail))

def predict(kind, a, b, c):
    if kind == 4:
        p = a + b - c
        return min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
    return (0, a, b, (a + b) // 2)[kind]

def decode(path):
    data = open(path, 'rb').read()
    assert data[:8] == b'\x89PNG\r\n\x1a\n'
    at, packed, head, ended = 8, b'', None, False
    while at < len(data):
        size, kind = struct.unpack('>I4s', data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        assert struct.unpack('>I', data[at + 8 + size:at + 12 + size])[0] == zlib.crc32(kind + body)
        if kind == b'IHDR': head = struct.unpack('>IIBBBBB', body)
        if kind == b'IDAT': packed += body
        ended = kind == b'IEND'
        at += 12 + size
    assert ended
    width, height, depth, colour, _, _, interlaced = head
    assert depth == 8 and colour in (0, 2) and not interlaced
    n = 3 if colour == 2 else 1
    raw, stride, above, out = zlib.decompress(packed), width * n, bytes(width * n), bytearray()
    assert len(raw) == height * (stride + 1)
    for r in range(height):
        kind, row = raw[r * (stride + 1)], bytearray(raw[r * (stride + 1) + 1:(r + 1) * (stride + 1)])
        if kind == 2: row = bytearray((x + y) & 255 for x, y in zip(row, above))
        elif kind:
            for i in range(stride):
                a, c = (row[i - n], above[i - n]) if i >= n else (0, 0)
                row[i] = (row[i] + predict(kind, a, above[i], c)) & 255
        out += row
        above = row
    return b'%d %d %d\n' % (width, height, n) + bytes(out)

def encode(path, width, height, depth, colour, samples, chunks, level, cuts, filters):
    """samples: rows of stored sample values. Filters are taken in turn, the stream is cut into several chunks."""
    per_pixel = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    step, raw, above = max(1, per_pixel * depth // 8), bytearray(), None
    for r, values in enumerate(samples):
        bits = ''.join(format(v, '0%db' % depth) for v in values)
        bits += '0' * (-len(bits) % 8)
        row = bytes(int(bits[i:i + 8], 2) for i in range(0, len(bits), 8))
        up = above or bytes(len(row))
        kind = filters[r % len(filters)]
        raw.append(kind)
        for i, v in enumerate(row):
            a, c = (row[i - step], up[i - step]) if i >= step else (0, 0)
            raw.append((v - predict(kind, a, up[i], c)) & 255)
        above = row
    packed = zlib.compress(bytes(raw), level)
    size = -(-len(packed) // cuts)
    body = [(b'IHDR', struct.pack('>IIBBBBB', width, height, depth, colour, 0, 0, 0)), (b'tEXt', b'note\0any')]
    body += chunks + [(b'IDAT', packed[i:i + size]) for i in range(0, len(packed), size)] + [(b'IEND', b'')]
    with open(path, 'wb') as f:
        f.write(b'\x89PNG\r\n\x1a\n')
        for kind, data in body:
            f.write(struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data)))

for name in ('gray', 'rgb', 'dot', 'picture', 'plot'):
    check('written ' + name, decode(name + '.png') == open(name + '.raw', 'rb').read())

random.seed(5)
kinds = [(d, c) for c in (0, 3) for d in (1, 2, 4, 8)] + [(8, 2), (8, 4), (8, 6)]
for depth, colour in kinds:
    for transparent in (False, True) if colour == 3 else (False,):
        for level, cuts in ((9, 1), (1, 5), (0, 3)):
            width, height = random.choice(((1, 1), (37, 21), (8, 64), (255, 3)))
            n = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
            top = (1 << depth) - 1
            samples = [[random.choice((0, top, random.randint(0, top))) for _ in range(width * n)]
                       for _ in range(height)]
            palette = bytes(random.randint(0, 255) for _ in range(3 * (top + 1)))
            alpha = bytes(random.randint(0, 255) for _ in range((top + 1) // 2)) # the rest is opaque
            chunks = [(b'PLTE', palette)] if colour == 3 else []
            if transparent: chunks.append((b'tRNS', alpha))
            encode('in.png', width, height, depth, colour, samples, chunks, level, cuts, random.sample(range(5), 5))
            want, channels = bytearray(), 4 if transparent else 3 if colour == 3 else n
            for v in (v for row in samples for v in row):
                if colour == 0: want.append(v * 255 // top)
                elif colour != 3: want.append(v)
                else:
                    want += palette[3 * v:3 * v + 3]
                    if transparent: want.append(alpha[v] if v < len(alpha) else 255)
            done = subprocess.run(['./program', 'read', 'in.png', 'out.raw'], stdout=subprocess.PIPE)
            ok = done.returncode == 0 and open('out.raw', 'rb').read() == \
                b'%d %d %d\n' % (width, height, channels) + bytes(want)
            check('read depth %d colour %d level %d' % (depth, colour, level), ok, done.stdout.decode())

print('%d passed, %d failed, 0 skipped' % (passed, failed))
sys.exit(failed > 0)
END

linked 2
# shellcheck disable=SC2086
$CC -std=c99 -O1 -DPD_DIM=2 -DPDI_SPLIT ${OMP:-} -I"$root" program.c $library -o program -lm \
    > log 2>&1 && ./program write >> log 2>&1
verdict "the program that writes the images"
[ "$failed" = 0 ] || { score; exit 1; }
python3 check.py
