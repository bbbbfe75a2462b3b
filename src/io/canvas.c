/* canvas: see canvas.h */
#include "io/canvas.h"
#include <math.h>
#include <string.h>

#define PDI_CANVAS_GLYPH_COLUMNS 5 /* dots of a glyph across */
#define PDI_CANVAS_GLYPH_ROWS 9    /* dots of a glyph down: seven above the baseline, two below */

/* Bitmap font: glyphs of ASCII 32..126 and of four signs; bit 5 r + c is the dot in row r, column c. */
static const uint64_t pdi_canvas_glyphs[99] = {
    0x000000000000ULL, 0x000040108421ULL, 0x0000000014A5ULL, 0x000295F57D4AULL, 0x00011F4717C4ULL, 0x000674222173ULL,
    0x000593511526ULL, 0x000000000421ULL, 0x000104108444ULL, 0x000044421041ULL, 0x000009575480ULL, 0x0000084F9080ULL,
    0x02218C000000ULL, 0x000000078000ULL, 0x0000C6000000ULL, 0x000042222210ULL, 0x0003A318C62EULL, 0x0007C84214C4ULL,
    0x0007C444422EULL, 0x0003A304111FULL, 0x000211F4A988ULL, 0x0003A3083C3FULL, 0x0003A317844CULL, 0x00008422221FULL,
    0x0003A317462EULL, 0x0001910F462EULL, 0x000006300C60ULL, 0x00110C6018C0ULL, 0x000208208888ULL, 0x000001F07C00ULL,
    0x000044441041ULL, 0x00010044422EULL, 0x000783DAF62EULL, 0x000463F8C544ULL, 0x0003E317C62FULL, 0x0003A210862EULL,
    0x0003E318C62FULL, 0x0007C217843FULL, 0x00004217843FULL, 0x0007A31E862EULL, 0x0004631FC631ULL, 0x0001C4210847ULL,
    0x00019284211CULL, 0x000452519531ULL, 0x0007C2108421ULL, 0x0004631AD771ULL, 0x0004739ACE71ULL, 0x0003A318C62EULL,
    0x00004217C62FULL, 0x00059358C62EULL, 0x00045257C62FULL, 0x0003A307062EULL, 0x00010842109FULL, 0x0003A318C631ULL,
    0x000114A8C631ULL, 0x0004775AC631ULL, 0x000462A22A31ULL, 0x000108422A31ULL, 0x0007C222221FULL, 0x0001C2108427ULL,
    0x000420820821ULL, 0x0001C8421087ULL, 0x000000004544ULL, 0x00F800000000ULL, 0x000000000041ULL, 0x0007A3E83800ULL,
    0x0003E318BC21ULL, 0x00038210B800ULL, 0x0007A318FA10ULL, 0x000383F8B800ULL, 0x000084213C4CULL, 0x0E87A318F800ULL,
    0x00046318BC21ULL, 0x000042108401ULL, 0x032108421004ULL, 0x00024A32A421ULL, 0x000082108421ULL, 0x00056B5AAC00ULL,
    0x00046318BC00ULL, 0x0003A318B800ULL, 0x010BE318BC00ULL, 0x1087A318F800ULL, 0x00004211B400ULL, 0x0001D060B800ULL,
    0x000304213C42ULL, 0x0007A318C400ULL, 0x000114A8C400ULL, 0x0002AB5AC400ULL, 0x000454454400ULL, 0x0E87A318C400ULL,
    0x0007C4447C00ULL, 0x00030420884CULL, 0x000042108421ULL, 0x0000C8441083ULL, 0x00000006C800ULL, 0x010DF318C400ULL,
    0x000000318000ULL, 0x000000032526ULL, 0x000454454400ULL /* micro, middle dot, degree, times */
};

/* Characters beyond ASCII: index of the glyph + 32; superscripts are smaller. */
enum {
    PDI_CANVAS_MICRO = 127,
    PDI_CANVAS_DOT,
    PDI_CANVAS_DEGREE,
    PDI_CANVAS_TIMES,
    PDI_CANVAS_SUPERSCRIPT = 256 /* added to a character: superscript */
};

PDI_FN double pdi_canvas_hypot(double x, double y) { return sqrt(x * x + y * y); }

/* PD_ERR_SIZE: a canvas without pixels, or with more than PD_PNG_MAX_PIXELS. */
static pd_status pdi_canvas_check_size(pd_ctx *ctx, int width, int height)
{
    if (width >= 1 && height >= 1 && width <= PD_PNG_MAX_PIXELS / height) return PD_OK;
    return pd_fail(ctx, PD_ERR_SIZE, "picture", "%d x %d pixels, at most %d in all are possible", width, height,
                   PD_PNG_MAX_PIXELS);
}

PDI_FN pd_status pdi_canvas_build_svg(pd_ctx *ctx, int width, int height, pdi_svg *svg, pdi_canvas *canvas)
{
    memset(canvas, 0, sizeof *canvas);
    memset(svg, 0, sizeof *svg);
    PD_TRY(pdi_canvas_check_size(ctx, width, height));
    pdi_svg_begin(ctx, width, height, svg);
    canvas->svg = svg;
    canvas->image.width = width;
    canvas->image.height = height;
    pdi_canvas_reset_clip(canvas);
    return svg->status;
}

PDI_FN void pdi_canvas_draw_image(pdi_canvas *canvas, int left, int top, const pd_image *image)
{
    pdi_svg_add_image(canvas->svg, left, top, image);
}

/* Returns 1 when a path ends in ".svg" (lower case), else 0. */
static int pdi_canvas_is_svg_path(const char *path)
{
    size_t length = strlen(path);
    return length >= 4 && strcmp(path + length - 4, ".svg") == 0;
}

PDI_FN pd_status pdi_canvas_draw_to_image(pd_ctx *ctx, pdi_canvas_draw_fn draw, const void *what, pd_image *image)
{
    pdi_canvas canvas;
    pd_status status = draw(ctx, what, NULL, &canvas);
    if (status != PD_OK) pd_image_free(ctx, &canvas.image);
    *image = canvas.image;
    return status;
}

PDI_FN pd_status pdi_canvas_draw_to_file(pd_ctx *ctx, const char *path, pdi_canvas_draw_fn draw, const void *what)
{
    pd_image image;
    pdi_canvas canvas;
    pdi_svg svg;
    memset(&svg, 0, sizeof svg);
    if (pdi_canvas_is_svg_path(path)) {
        pd_status drawn = draw(ctx, what, &svg, &canvas);
        if (drawn == PD_OK) drawn = pdi_svg_write(&svg, path);
        pdi_svg_free(&svg);
        return drawn;
    }
    PD_TRY(pdi_canvas_draw_to_image(ctx, draw, what, &image));
    pd_status status = pd_png_write(ctx, path, &image);
    pd_image_free(ctx, &image);
    return status;
}

PDI_FN pd_status pdi_canvas_build_image(pd_ctx *ctx, int width, int height, pdi_canvas *canvas)
{
    memset(canvas, 0, sizeof *canvas);
    PD_TRY(pdi_canvas_check_size(ctx, width, height));
    size_t bytes = (size_t)width * (size_t)height * 3;
    PD_TRY(PD_NEW(ctx, "picture", bytes, canvas->image.pixels));
    memset(canvas->image.pixels, 0xff, bytes);
    canvas->image.width = width;
    canvas->image.height = height;
    canvas->image.channels = 3;
    pdi_canvas_reset_clip(canvas);
    return PD_OK;
}

PDI_FN void pdi_canvas_set_clip(pdi_canvas *canvas, int left, int top, int right, int bottom)
{
    canvas->clip_left = left > 0 ? left : 0;
    canvas->clip_top = top > 0 ? top : 0;
    canvas->clip_right = right < canvas->image.width ? right : canvas->image.width;
    canvas->clip_bottom = bottom < canvas->image.height ? bottom : canvas->image.height;
    if (!canvas->svg) return;
    int wide = canvas->clip_right - canvas->clip_left, high = canvas->clip_bottom - canvas->clip_top;
    if (wide == canvas->image.width && high == canvas->image.height) pdi_svg_end_clip(canvas->svg);
    else pdi_svg_set_clip(canvas->svg, canvas->clip_left, canvas->clip_top, wide, high);
}

PDI_FN void pdi_canvas_reset_clip(pdi_canvas *canvas)
{
    pdi_canvas_set_clip(canvas, 0, 0, canvas->image.width, canvas->image.height);
}

/* Blend a colour into a pixel of the image with an opacity 0..1; outside the clip rectangle nothing changes. */
static void pdi_canvas_blend_pixel(pdi_canvas *canvas, int x, int y, uint32_t colour, double opacity)
{
    if (x < canvas->clip_left || x >= canvas->clip_right || y < canvas->clip_top || y >= canvas->clip_bottom) return;
    uint8_t *p = canvas->image.pixels + 3 * ((size_t)y * (size_t)canvas->image.width + (size_t)x);
    for (int c = 0; c < 3; c++) {
        double ink = (double)(colour >> (16 - 8 * c) & 255);
        p[c] = (uint8_t)(p[c] + (ink - p[c]) * opacity + 0.5);
    }
}

PDI_FN void pdi_canvas_fill_rectangle(pdi_canvas *canvas, int left, int top, int right, int bottom, uint32_t colour)
{
    if (canvas->svg) {
        pdi_svg_add_rectangle(canvas->svg, left, top, right - left, bottom - top, colour);
        return;
    }
    left = left > canvas->clip_left ? left : canvas->clip_left;
    right = right < canvas->clip_right ? right : canvas->clip_right;
    top = top > canvas->clip_top ? top : canvas->clip_top;
    bottom = bottom < canvas->clip_bottom ? bottom : canvas->clip_bottom;
    if (left >= right || top >= bottom) return;
    size_t stride = 3 * (size_t)canvas->image.width, bytes = 3 * (size_t)(right - left);
    uint8_t *first = canvas->image.pixels + (size_t)top * stride + 3 * (size_t)left;
    for (size_t at = 0; at < bytes; at += 3)
        for (int c = 0; c < 3; c++) first[at + (size_t)c] = (uint8_t)(colour >> (16 - 8 * c));
    for (int y = top + 1; y < bottom; y++) memcpy(first + (size_t)(y - top) * stride, first, bytes);
}

PDI_FN void pdi_canvas_draw_frame(pdi_canvas *canvas, int left, int top, int right, int bottom, uint32_t colour)
{
    if (canvas->svg) {
        pdi_svg_add_frame(canvas->svg, left - 0.5, top - 0.5, right - left + 1.0, bottom - top + 1.0, colour);
        return;
    }
    pdi_canvas_fill_rectangle(canvas, left - 1, top - 1, right + 1, top, colour);
    pdi_canvas_fill_rectangle(canvas, left - 1, bottom, right + 1, bottom + 1, colour);
    pdi_canvas_fill_rectangle(canvas, left - 1, top, left, bottom, colour);
    pdi_canvas_fill_rectangle(canvas, right, top, right + 1, bottom, colour);
}

/* Distance of the point (x, y) from the segment that starts at (xa, ya) with the vector (dx, dy), not from its line; a
 * zero vector is a point. */
static double pdi_canvas_segment_distance(double x, double y, double xa, double ya, double dx, double dy)
{
    double length2 = dx * dx + dy * dy, s = length2 > 0 ? ((x - xa) * dx + (y - ya) * dy) / length2 : 0;
    s = s < 0 ? 0 : s > 1 ? 1 : s;
    return pdi_canvas_hypot(x - xa - s * dx, y - ya - s * dy);
}

/* Clip the segment (pa, qa)-(pb, qb) in place to lo <= p <= hi. Returns 1; 0: nothing is left, and nothing has
 * changed. */
static int pdi_canvas_clip_segment(double *pa, double *qa, double *pb, double *qb, double lo, double hi)
{
    if ((*pa < lo && *pb < lo) || (*pa > hi && *pb > hi)) return 0;
    double p = *pa, q = *qa, slope = *pb != *pa ? (*qb - *qa) / (*pb - *pa) : 0;
    for (int end = 0; end < 2; end++) {
        double *pe = end ? pb : pa, *qe = end ? qb : qa;
        double limit = *pe < lo ? lo : *pe > hi ? hi : *pe;
        if (limit == *pe) continue;
        *qe = q + slope * (limit - p);
        *pe = limit;
    }
    return 1;
}

/* Record that a stroke covers this fraction 0..1 of a pixel; the largest fraction of all strokes counts. Outside the
 * clip rectangle nothing changes. */
static void pdi_canvas_set_coverage(pdi_canvas *canvas, int x, int y, double fraction)
{
    if (x < canvas->clip_left || x >= canvas->clip_right || y < canvas->clip_top || y >= canvas->clip_bottom) return;
    uint8_t *cover = canvas->coverage + (size_t)y * (size_t)canvas->image.width + (size_t)x;
    uint8_t value = (uint8_t)(255.0 * fraction + 0.5);
    if (value > *cover) *cover = value;
}

PDI_FN void pdi_canvas_draw_line(pdi_canvas *canvas, double xa, double ya, double xb, double yb, double width,
                                 uint32_t colour)
{
    double reach = width / 2 + 1;
    if (!(fabs(xa) + fabs(ya) + fabs(xb) + fabs(yb) < 1e300)) return;
    /* Clip: far points would cost time and overflow an int. */
    if (!pdi_canvas_clip_segment(&xa, &ya, &xb, &yb, canvas->clip_left - reach, canvas->clip_right + reach) ||
        !pdi_canvas_clip_segment(&ya, &xa, &yb, &xb, canvas->clip_top - reach, canvas->clip_bottom + reach))
        return;
    if (canvas->svg) {
        if (canvas->strokes_open) pdi_svg_add_stroke(canvas->svg, xa, ya, xb, yb);
        else pdi_svg_add_line(canvas->svg, xa, ya, xb, yb, width, colour);
        return;
    }
    double dx = xb - xa, dy = yb - ya;
    int steep = fabs(dy) > fabs(dx);
    double from = steep ? pd_min(ya, yb) : pd_min(xa, xb), to = steep ? pd_max(ya, yb) : pd_max(xa, xb);
    /* Loop over pixels along the longer axis, and across the stroke; coverage from the distance to the segment. */
    double across = reach * 1.5;
    for (int i = (int)floor(from - reach); i <= (int)ceil(to + reach); i++) {
        double along = i + 0.5 < from ? from : i + 0.5 > to ? to : i + 0.5, centre;
        if (steep) centre = dy != 0 ? xa + (along - ya) * dx / dy : xa;
        else centre = dx != 0 ? ya + (along - xa) * dy / dx : ya;
        for (int j = (int)floor(centre - across); j <= (int)ceil(centre + across); j++) {
            int x = steep ? j : i, y = steep ? i : j;
            double cover = width / 2 + 0.5 - pdi_canvas_segment_distance(x + 0.5, y + 0.5, xa, ya, dx, dy);
            if (!(cover > 0)) continue;
            if (cover > 1.0) cover = 1.0;
            if (canvas->strokes_open) pdi_canvas_set_coverage(canvas, x, y, cover);
            else pdi_canvas_blend_pixel(canvas, x, y, colour, cover);
        }
    }
}

PDI_FN pd_status pdi_canvas_begin_strokes(pd_ctx *ctx, pdi_canvas *canvas, double width, uint32_t colour)
{
    size_t pixels = (size_t)canvas->image.width * (size_t)canvas->image.height;
    if (canvas->svg) pdi_svg_begin_path(canvas->svg);
    else PD_TRY(PD_NEW(ctx, "picture", pixels, canvas->coverage));
    canvas->strokes_open = 1;
    canvas->stroke_width = width;
    canvas->stroke_colour = colour;
    return PD_OK;
}

PDI_FN void pdi_canvas_add_stroke(pdi_canvas *canvas, double xa, double ya, double xb, double yb)
{
    pdi_canvas_draw_line(canvas, xa, ya, xb, yb, canvas->stroke_width, canvas->stroke_colour);
}

PDI_FN void pdi_canvas_end_strokes(pd_ctx *ctx, pdi_canvas *canvas)
{
    int width = canvas->image.width, height = canvas->image.height;
    if (!canvas->strokes_open) return;
    canvas->strokes_open = 0;
    if (canvas->svg) {
        pdi_svg_end_path(canvas->svg, canvas->stroke_width, canvas->stroke_colour);
        return;
    }
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            uint8_t cover = canvas->coverage[(size_t)y * (size_t)width + (size_t)x];
            if (cover) pdi_canvas_blend_pixel(canvas, x, y, canvas->stroke_colour, cover / 255.0);
        }
    PD_DELETE(ctx, (size_t)width * (size_t)height, canvas->coverage);
}

/* Text. A glyph is enlarged four times by the Scale2x rule, which rounds its diagonals, and averaged over 2 x 2 dots:
 * twice the size of the table, with smooth edges. Superscripts are averaged over 3 x 3 dots. */

/* size of the enlarged bitmap: four times the rows and columns of a glyph, with a margin */
#define PDI_CANVAS_BITMAP_SIZE 40

/* Dot of a glyph, 0 or 1; 0 outside. */
static int pdi_canvas_get_glyph_dot(uint64_t glyph, int column, int row)
{
    if (column < 0 || column >= PDI_CANVAS_GLYPH_COLUMNS || row < 0 || row >= PDI_CANVAS_GLYPH_ROWS) return 0;
    return (int)(glyph >> (PDI_CANVAS_GLYPH_COLUMNS * row + column) & 1);
}

/* Dot (x, y) of a bitmap of width x height dots, 0 or 1; 0 outside. */
static int pdi_canvas_get_bitmap_dot(uint8_t dots[PDI_CANVAS_BITMAP_SIZE][PDI_CANVAS_BITMAP_SIZE], int width,
                                     int height, int x, int y)
{
    return x < 0 || x >= width || y < 0 || y >= height ? 0 : dots[y][x];
}

/* Enlarge a bitmap of width x height dots in place to 2 width x 2 height by the Scale2x rule. square 1: each dot
 * becomes 2 x 2 equal ones, so that corners stay square. */
static void pdi_canvas_scale2x(uint8_t dots[PDI_CANVAS_BITMAP_SIZE][PDI_CANVAS_BITMAP_SIZE], int width, int height,
                               int square)
{
    uint8_t old[PDI_CANVAS_BITMAP_SIZE][PDI_CANVAS_BITMAP_SIZE];
    memcpy(old, dots, sizeof old);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int p = old[y][x];
            int up = pdi_canvas_get_bitmap_dot(old, width, height, x, y - 1),
                down = pdi_canvas_get_bitmap_dot(old, width, height, x, y + 1);
            int left = pdi_canvas_get_bitmap_dot(old, width, height, x - 1, y),
                right = pdi_canvas_get_bitmap_dot(old, width, height, x + 1, y);
            if (square) up = down = left = right = p;
            dots[2 * y][2 * x] = (uint8_t)(left == up && left != down && up != right ? up : p);
            dots[2 * y][2 * x + 1] = (uint8_t)(up == right && up != left && right != down ? right : p);
            dots[2 * y + 1][2 * x] = (uint8_t)(down == left && down != right && left != up ? left : p);
            dots[2 * y + 1][2 * x + 1] = (uint8_t)(right == down && right != up && down != left ? down : p);
        }
}

/* First column with ink of a character (as of pdi_canvas_find_character), and number of columns from there to the last
 * one. Digits, also superscript ones, take all columns so that numbers line up: first is 0. A space takes two. */
static void pdi_canvas_glyph_extent(int letter, int *first, int *columns)
{
    uint64_t glyph = pdi_canvas_glyphs[letter % PDI_CANVAS_SUPERSCRIPT - 32];
    int lo = PDI_CANVAS_GLYPH_COLUMNS, hi = -1;
    for (int c = 0; c < PDI_CANVAS_GLYPH_COLUMNS; c++)
        for (int r = 0; r < PDI_CANVAS_GLYPH_ROWS; r++)
            if (pdi_canvas_get_glyph_dot(glyph, c, r)) {
                if (c < lo) lo = c;
                hi = c;
            }
    int fixed = letter % PDI_CANVAS_SUPERSCRIPT >= '0' && letter % PDI_CANVAS_SUPERSCRIPT <= '9';
    *first = fixed || hi < 0 ? 0 : lo;
    *columns = fixed ? PDI_CANVAS_GLYPH_COLUMNS : hi < 0 ? 2 : hi - lo + 1;
}

/* Pixels from the start of this character to that of the next one. columns: those of its glyph. */
static int pdi_canvas_character_width(int letter, int columns)
{
    return letter < PDI_CANVAS_SUPERSCRIPT ? 2 * columns + 2 : (4 * columns + 2) / 3 + 1;
}

/* Character of a Unicode code point: ASCII, or one of the values above, PDI_CANVAS_SUPERSCRIPT added to superscripts;
 * '?' where the font has none. */
static int pdi_canvas_find_character(uint32_t code)
{
    switch (code) {
    case 0xB5: case 0x3BC: return PDI_CANVAS_MICRO;
    case 0xB7: case 0x22C5: return PDI_CANVAS_DOT;
    case 0xB0: return PDI_CANVAS_DEGREE;
    case 0xD7: return PDI_CANVAS_TIMES;
    case 0xB9: return PDI_CANVAS_SUPERSCRIPT + '1';
    case 0xB2:
    case 0xB3: return PDI_CANVAS_SUPERSCRIPT + '0' + (int)(code - 0xB0);
    case 0x207A: return PDI_CANVAS_SUPERSCRIPT + '+';
    case 0x207B: return PDI_CANVAS_SUPERSCRIPT + '-';
    case 0x2212: return '-';
    default: break;
    }
    if (code == 0x2070 || (code >= 0x2074 && code <= 0x2079))
        return PDI_CANVAS_SUPERSCRIPT + '0' + (int)(code - 0x2070);
    return code >= 32 && code < 127 ? (int)code : '?';
}

/* Read the next character of a UTF-8 text and move *text behind it. Returns it as pdi_canvas_find_character does, so
 * '?' for one that the font lacks; 0 at the end of the text, where *text stays. The encoding is not verified. */
static int pdi_canvas_read_character(const char **text)
{
    const unsigned char *p = (const unsigned char *)*text;
    uint32_t code = *p;
    if (!code) return 0;
    code &= code < 0x80 ? 0x7Fu : code < 0xE0 ? 0x1Fu : code < 0xF0 ? 0xFu : 7u;
    int wide = *p++ >= 0x80;
    for (; wide && (*p & 0xC0) == 0x80; p++) code = code << 6 | (*p & 0x3Fu);
    *text = (const char *)p;
    return pdi_canvas_find_character(code);
}

PDI_FN int pdi_canvas_compute_text_width(const char *text)
{
    int width = 0, first, columns;
    for (int letter; (letter = pdi_canvas_read_character(&text)) != 0;) {
        pdi_canvas_glyph_extent(letter, &first, &columns);
        width += pdi_canvas_character_width(letter, columns);
    }
    return width ? width - 2 : 0;
}

/* Fill dots[y][x] with the enlarged bitmap of a character, four times the size of its glyph, 0 beyond; a superscript is
 * not smaller here. */
static void pdi_canvas_build_glyph_bitmap(int letter, uint8_t dots[PDI_CANVAS_BITMAP_SIZE][PDI_CANVAS_BITMAP_SIZE])
{
    memset(dots, 0, sizeof(uint8_t) * PDI_CANVAS_BITMAP_SIZE * PDI_CANVAS_BITMAP_SIZE);
    for (int r = 0; r < PDI_CANVAS_GLYPH_ROWS; r++)
        for (int c = 0; c < PDI_CANVAS_GLYPH_COLUMNS; c++)
            dots[r][c] =
                (uint8_t)pdi_canvas_get_glyph_dot(pdi_canvas_glyphs[letter % PDI_CANVAS_SUPERSCRIPT - 32], c, r);
    int square = letter == '[' || letter == ']'; /* round ones would pass for parentheses */
    pdi_canvas_scale2x(dots, PDI_CANVAS_GLYPH_COLUMNS, PDI_CANVAS_GLYPH_ROWS, square);
    pdi_canvas_scale2x(dots, 2 * PDI_CANVAS_GLYPH_COLUMNS, 2 * PDI_CANVAS_GLYPH_ROWS, square);
}

/* Draw a text with the bitmap font into an image, blended by its coverage and clipped. (x, y): where it starts, at the
 * top of its capitals; it runs along +x, or along -y where upward is 1. Superscripts are smaller and raised by two
 * pixels. */
static void pdi_canvas_draw_bitmap_text(pdi_canvas *canvas, int x, int y, int upward, uint32_t colour, const char *text)
{
    uint8_t dots[PDI_CANVAS_BITMAP_SIZE][PDI_CANVAS_BITMAP_SIZE];
    int at = 0, first, columns;
    for (int letter; (letter = pdi_canvas_read_character(&text)) != 0;) {
        int by = letter < PDI_CANVAS_SUPERSCRIPT ? 2 : 3; /* dots that become a pixel, across and down */
        pdi_canvas_glyph_extent(letter, &first, &columns);
        pdi_canvas_build_glyph_bitmap(letter, dots);
        for (int v = 0; v * by < 4 * PDI_CANVAS_GLYPH_ROWS; v++)
            for (int u = 0; u * by < 4 * columns; u++) {
                int ink = 0;
                for (int k = 0; k < by * by; k++) {
                    int s = u * by + k % by, t = v * by + k / by;
                    if (s < 4 * columns && t < 4 * PDI_CANVAS_GLYPH_ROWS) ink += dots[t][s + 4 * first];
                }
                if (!ink) continue;
                int down = by > 2 ? v - 2 : v;
                pdi_canvas_blend_pixel(canvas, upward ? x + down : x + at + u, upward ? y - at - u : y + down, colour,
                                       (double)ink / (by * by));
            }
        at += pdi_canvas_character_width(letter, columns);
    }
}

/* Draw the text in SVG, which aligns it itself; (x, y) as of pdi_canvas_draw_text. Returns 1; 0: the canvas is an
 * image, and nothing is drawn. */
static int pdi_canvas_try_svg_text(pdi_canvas *canvas, int x, int y, pdi_align align, int upward, int bold,
                                   uint32_t colour, const char *text)
{
    static const char *const anchor[3] = {"start", "middle", "end"};
    if (!canvas->svg) return 0;
    pdi_svg_add_text(canvas->svg, upward ? x + PDI_CANVAS_CAPITAL_HEIGHT : x,
                     upward ? y : y + PDI_CANVAS_CAPITAL_HEIGHT, anchor[align], upward, bold, colour, text);
    return 1;
}

/* Pixels from the start of a text to its anchor, in the bitmap font: 0, half of its width or all of it, for start,
 * centre and end. */
static int pdi_canvas_alignment_shift(pdi_align align, const char *text)
{
    int width = align == PDI_ALIGN_START ? 0 : pdi_canvas_compute_text_width(text);
    return align == PDI_ALIGN_CENTRE ? width / 2 : width;
}

PDI_FN void pdi_canvas_draw_text(pdi_canvas *canvas, int x, int y, pdi_align align, uint32_t colour, const char *text)
{
    if (pdi_canvas_try_svg_text(canvas, x, y, align, 0, 0, colour, text)) return;
    pdi_canvas_draw_bitmap_text(canvas, x - pdi_canvas_alignment_shift(align, text), y, 0, colour, text);
}

PDI_FN void pdi_canvas_draw_text_upward(pdi_canvas *canvas, int x, int y, pdi_align align, uint32_t colour,
                                        const char *text)
{
    if (pdi_canvas_try_svg_text(canvas, x, y, align, 1, 0, colour, text)) return;
    pdi_canvas_draw_bitmap_text(canvas, x, y + pdi_canvas_alignment_shift(align, text), 1, colour, text);
}

PDI_FN void pdi_canvas_draw_bold_text(pdi_canvas *canvas, int x, int y, uint32_t colour, const char *text)
{
    if (pdi_canvas_try_svg_text(canvas, x, y, PDI_ALIGN_START, 0, 1, colour, text)) return;
    pdi_canvas_draw_bitmap_text(canvas, x, y, 0, colour, text);
    pdi_canvas_draw_bitmap_text(canvas, x + 1, y, 0, colour, text);
}
