/* renderer: surfaces of cells and their views against closed forms. */
/* dims: 2 */
#include "io/canvas.h"
#include "io/surface_plot.h"
#include "test.h"
#include <string.h>

static const double pi = 3.14159265358979323846;

/* ---- a mesh that is known ---- */

enum { AROUND = 160, ALONG = 80 };

/* A sphere of radius r about the middle m, of rings of faces, with its true normals and the value z. */
static void globe(pd_ctx *ctx, const double *m, double r, pdi_surface_nets_mesh *s)
{
    memset(s, 0, sizeof *s);
    s->vertex_count = s->vertex_capacity = (ALONG + 1) * AROUND;
    s->face_count = s->face_capacity = s->value_capacity = ALONG * AROUND;
    CHECK_OK(ctx, PD_NEW(ctx, "test", 3 * s->vertex_count, s->x));
    CHECK_OK(ctx, PD_NEW(ctx, "test", s->vertex_count, s->vertex_value));
    CHECK_OK(ctx, PD_NEW(ctx, "test", 4 * s->face_count, s->face_vertex));
    CHECK_OK(ctx, PD_NEW(ctx, "test", s->face_count, s->face_value));
    CHECK_OK(ctx, PD_NEW(ctx, "test", 12 * s->face_count, s->corner_normal));
    for (int k = 0; k < s->vertex_count; k++) {
        double b = pi * (k / AROUND) / ALONG, a = 2 * pi * (k % AROUND) / AROUND;
        double n[3] = {sin(b) * cos(a), sin(b) * sin(a), cos(b)};
        for (int d = 0; d < 3; d++) s->x[3 * k + d] = m[d] + r * n[d];
        s->vertex_value[k] = s->x[3 * k + 2];
    }
    for (int f = 0; f < s->face_count; f++) {
        int row = f / AROUND, at = f % AROUND, next = (at + 1) % AROUND;
        int corner[4] = {row * AROUND + at, (row + 1) * AROUND + at, (row + 1) * AROUND + next, row * AROUND + next};
        for (int k = 0; k < 4; k++) {
            s->face_vertex[4 * f + k] = corner[k];
            for (int d = 0; d < 3; d++)
                s->corner_normal[12 * f + 3 * k + d] = (float)((s->x[3 * corner[k] + d] - m[d]) / r);
        }
    }
}

static const double low[3] = {0, 0, 0}, high[3] = {2, 3, 4};

static size_t pixel(const pd_rendering *s, double x, double y) { return (size_t)y * (size_t)s->width + (size_t)x; }

/* Area of the body on paper, and its middle [pixel]. */
static double silhouette(const pd_rendering *s, double *middle)
{
    double area = 0;
    middle[0] = middle[1] = 0;
    for (int k = 0; k < s->width * s->height; k++) {
        double share = s->coverage[k] / (double)(PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE);
        area += share;
        middle[0] += share * (k % s->width + 0.5);
        middle[1] += share * (k / s->width + 0.5);
    }
    middle[0] /= area;
    middle[1] /= area;
    return area;
}

/* Seen from any direction a sphere is a disc of its radius about its middle, and as bright as n.l says. */
TEST(a_sphere_has_its_silhouette_and_light)
{
    static const double ways[4][3] = {{1, -1, 1}, {0, 0, 1}, {-3, 1, -0.5}, {0, -2, 0}};
    const double m[3] = {0.9, 1.6, 2.2}, r = 0.8;
    pd_ctx ctx;
    pdi_surface_nets_mesh shell;
    pd_ctx_init(&ctx);
    globe(&ctx, m, r, &shell);
    for (int w = 0; w < 4; w++) {
        pd_rendering s;
        double middle[2], at[3], worst = 0, off = 0;
        if (!CHECK_OK(&ctx, pdi_renderer_build(&ctx, low, high, ways[w], 500, &s))) return;
        if (!CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &shell, 0, &s))) return;
        CHECK(s.width <= 500 && s.height <= 450 && (s.width == 500 || s.height == 450));
        CHECK_REL(silhouette(&s, middle), pi * r * r / s.pixel_size / s.pixel_size, 2e-3);
        pdi_renderer_project_point(&s, m, at);
        CHECK_NEAR(middle[0], at[0], 0.05);
        CHECK_NEAR(middle[1], at[1], 0.05);
        double light[3] = {-0.3, 0.4, 0.866}, length = sqrt(0.09 + 0.16 + 0.866 * 0.866);
        for (int k = 0; k < s.width * s.height; k++) {
            double x = (k % s.width + 0.5 - at[0]) * s.pixel_size / r,
                   y = (at[1] - k / s.width - 0.5) * s.pixel_size / r;
            if (x * x + y * y > 0.8) continue;
            double z = sqrt(1 - x * x - y * y), shine = (light[0] * x + light[1] * y + light[2] * z) / length;
            double want = PDI_RENDERER_AMBIENT_LIGHT + (1 - PDI_RENDERER_AMBIENT_LIGHT) * fmax(0, shine);
            worst = fmax(worst, fabs(s.brightness[k] / 255.0 - want));
            double place = m[2] + r * (x * s.right[2] + y * s.up[2] + z * s.eye[2]); /* the value is z */
            off = fmax(off, fabs((double)s.value[k] - place));
        }
        CHECK_LE(worst, 0.01);
        CHECK_LE(off, 4e-3);
        pdi_renderer_free(&ctx, &s);
    }
    pdi_surface_nets_free(&ctx, &shell);
    CHECK_INT(ctx.in_use, 0);
}

/* ---- surfaces of cells ---- */

typedef struct body {
    int n[3];
    int form;      /* 0: ball, 1: block, 2: all of it, 3: two plates, 4: half a space */
    double r;
} body;

static double share(const void *user, const int *i)
{
    const body *b = (const body *)user;
    double square = 0;
    for (int d = 0; d < 3; d++) square += pow(i[d] + 0.5 - 0.5 * b->n[d], 2);
    switch (b->form) {
    case 0: return square < b->r * b->r;
    case 1: return i[0] >= 10 && i[0] < 40 && i[1] >= 15 && i[1] < 45 && i[2] >= 20 && i[2] < 50;
    case 2: return 1;
    case 3: return i[2] == 10 || (i[2] == 40 && i[0] < 30);
    default: return i[2] < 20 ? 1 : i[2] == 20 ? b->r : 0;
    }
}

static double height(const void *user, const int *in, const int *out)
{
    (void)user;
    (void)out;
    return in[2];
}

static void build(pd_ctx *ctx, const body *b, pdi_surface_nets_mesh *s)
{
    pdi_surface_nets_desc desc;
    memset(&desc, 0, sizeof desc);
    for (int d = 0; d < 3; d++) {
        desc.n[d] = b->n[d];
        desc.h[d] = 1;
    }
    desc.fraction = share;
    desc.value = height;
    desc.user = b;
    CHECK_OK(ctx, pdi_surface_nets_build(ctx, &desc, s));
}

/* Volume within the surface, by the divergence theorem; each edge has to belong to two faces. */
static double volume(const pdi_surface_nets_mesh *s)
{
    double sum = 0;
    for (int64_t f = 0; f < s->face_count; f++)
        for (int half = 0; half < 2; half++) {
            const double *a = &s->x[3 * s->face_vertex[4 * f]], *b = &s->x[3 * s->face_vertex[4 * f + 1 + half]];
            const double *c = &s->x[3 * s->face_vertex[4 * f + 2 + half]];
            for (int d = 0; d < 3; d++) {
                int e = (d + 1) % 3, g = (d + 2) % 3;
                sum += a[d] * (b[e] * c[g] - b[g] * c[e]) / 6;
            }
        }
    return sum;
}

/* A ball of cells: volume, places and normals of the true sphere, light of its pixels. */
TEST(a_ball_of_cells_is_a_sphere)
{
    body b = {{60, 60, 60}, 0, 24};
    const double way[3] = {1, -1, 1}, lo[3] = {0, 0, 0}, hi[3] = {60, 60, 60};
    pd_ctx ctx;
    pdi_surface_nets_mesh s;
    pd_rendering shade;
    double far = 0, turned = 0, mean = 0, middle[2], cells = 0;
    pd_ctx_init(&ctx);
    build(&ctx, &b, &s);
    for (int i[3] = {0, 0, 0}; i[2] < 60; i[0]++) {
        if (i[0] == 60) i[0] = 0, i[1]++;
        if (i[1] == 60) i[1] = 0, i[2]++;
        cells += i[2] < 60 ? share(&b, i) : 0;
    }
    CHECK_REL(volume(&s), cells, 0.02);
    for (int64_t k = 0; k < s.vertex_count; k++) {
        double r = 0;
        for (int d = 0; d < 3; d++) r += pow(s.x[3 * k + d] - 30, 2);
        far = fmax(far, fabs(sqrt(r) - 24));
    }
    CHECK_LE(far, 0.75);
    for (int64_t k = 0; k < 4 * s.face_count; k++) {
        const double *x = &s.x[3 * s.face_vertex[k]];
        double along = 0, r = 0;
        for (int d = 0; d < 3; d++) {
            along += (double)s.corner_normal[3 * k + d] * (x[d] - 30);
            r += pow(x[d] - 30, 2);
        }
        double angle = acos(fmin(1, along / sqrt(r)));
        turned = fmax(turned, angle);
        mean += angle / (4.0 * (double)s.face_count);
    }
    CHECK_LE(mean, 4 * pi / 180);
    CHECK_LE(turned, 16 * pi / 180);
    CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way, 400, &shade));
    CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &s, 0, &shade));
    CHECK_REL(silhouette(&shade, middle), pi * 24 * 24 / shade.pixel_size / shade.pixel_size, 0.02);
    double square = 0, count = 0, at[3], m[3] = {30, 30, 30};
    pdi_renderer_project_point(&shade, m, at);
    for (int k = 0; k < shade.width * shade.height; k++) {
        double n[3], x = (k % shade.width + 0.5 - at[0]) * shade.pixel_size / 24;
        double y = (at[1] - k / shade.width - 0.5) * shade.pixel_size / 24;
        if (x * x + y * y > 0.8) continue;
        for (int d = 0; d < 3; d++)
            n[d] = x * shade.right[d] + y * shade.up[d] + sqrt(1 - x * x - y * y) * shade.eye[d];
        square += pow(shade.brightness[k] / 255.0 - pdi_renderer_compute_brightness(&shade, n), 2);
        count++;
    }
    CHECK_LE(sqrt(square / count), 0.04);
    pdi_renderer_free(&ctx, &shade);
    pdi_surface_nets_free(&ctx, &s);
    CHECK_INT(ctx.in_use, 0);
}

/* Each of the three faces of a block that are seen has one light, its own, away from edges; values are those in
 * front. */
TEST(a_block_shows_three_faces)
{
    body b = {{60, 60, 60}, 1, 0};
    const double way[3] = {1, -1, 1}, lo[3] = {0, 0, 0}, hi[3] = {60, 60, 60};
    static const double middle[3][3] = {{40, 30, 35}, {25, 15, 35}, {25, 30, 50}};
    pd_ctx ctx;
    pdi_surface_nets_mesh s;
    pd_rendering shade;
    pd_ctx_init(&ctx);
    build(&ctx, &b, &s);
    CHECK_REL(volume(&s), 27000, 0.03);
    CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way, 400, &shade));
    CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &s, 0, &shade));
    for (int f = 0; f < 3; f++)
        for (int i = -8; i <= 8; i += 4)
            for (int j = -8; j <= 8; j += 4) {
                double x[3] = {middle[f][0], middle[f][1], middle[f][2]}, at[3], n[3] = {0, 0, 0};
                n[f] = f == 1 ? -1 : 1;
                x[(f + 1) % 3] += i;
                x[(f + 2) % 3] += j;
                pdi_renderer_project_point(&shade, x, at);
                size_t k = pixel(&shade, at[0], at[1]);
                CHECK_INT(shade.coverage[k], PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE);
                CHECK_NEAR(shade.brightness[k] / 255.0, pdi_renderer_compute_brightness(&shade, n), 0.01);
                CHECK_NEAR((double)shade.value[k], f == 2 ? 49 : x[2], f == 2 ? 1e-6 : 1.0);
            }
    /* the face towards z+ is the brightest, that towards x+ in the shade */
    double x[3] = {1, 0, 0}, y[3] = {0, -1, 0}, z[3] = {0, 0, 1};
    CHECK_LE(pdi_renderer_compute_brightness(&shade, y) + 0.1, pdi_renderer_compute_brightness(&shade, z));
    CHECK_LE(pdi_renderer_compute_brightness(&shade, x) + 0.1, pdi_renderer_compute_brightness(&shade, y));
    pdi_renderer_free(&ctx, &shade);
    pdi_surface_nets_free(&ctx, &s);
}

/* What fills the lattice ends in its sides: planes, exactly, with all edges; a part of a layer stands where its share
 * says. */
TEST(sides_cut_the_body)
{
    body all = {{20, 10, 15}, 2, 0}, half = {{12, 14, 30}, 4, 0.8};
    pd_ctx ctx;
    pdi_surface_nets_mesh s;
    double off = 0, level = 0;
    int tops = 0;
    pd_ctx_init(&ctx);
    build(&ctx, &all, &s);
    CHECK_REL(volume(&s), 20 * 10 * 15, 1e-12);
    CHECK_INT(s.face_count, 2 * (20 * 10 + 10 * 15 + 15 * 20));
    for (int64_t k = 0; k < 4 * s.face_count; k++) {
        double most = 0;
        for (int d = 0; d < 3; d++) most = fmax(most, fabs((double)s.corner_normal[3 * k + d]));
        off = fmax(off, 1 - most); /* along an axis */
    }
    CHECK_LE(off, 1e-6);
    pdi_surface_nets_free(&ctx, &s);
    build(&ctx, &half, &s);
    for (int64_t f = 0; f < s.face_count; f++) {
        if (!((double)s.corner_normal[12 * f + 2] > 0.9)) continue;
        for (int k = 0; k < 4; k++) level = fmax(level, fabs(s.x[3 * s.face_vertex[4 * f + k] + 2] - 20.8));
        tops++;
    }
    CHECK_INT(tops, 12 * 14);
    CHECK_LE(level, 1e-12);
    CHECK_REL(volume(&s), 12 * 14 * 20.8, 1e-12);
    pdi_surface_nets_free(&ctx, &s);
    body none = {{8, 8, 8}, 0, 0.1};
    build(&ctx, &none, &s);
    CHECK_INT(s.face_count, 0);
    pdi_surface_nets_free(&ctx, &s);
    CHECK_INT(ctx.in_use, 0);
}

/* The upper plate hides the lower one. From below it is the other way round. */
TEST(what_is_nearer_hides)
{
    body b = {{60, 60, 60}, 3, 0};
    const double lo[3] = {0, 0, 0}, hi[3] = {60, 60, 60};
    pd_ctx ctx;
    pdi_surface_nets_mesh s;
    pd_ctx_init(&ctx);
    build(&ctx, &b, &s);
    for (int below = 0; below < 2; below++) {
        double way[3] = {0.1, 0.2, below ? -1 : 1};
        pd_rendering shade;
        CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way, 300, &shade));
        CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &s, 0, &shade));
        for (int side = 0; side < 2; side++) {
            double x[3] = {side ? 45 : 15, 30, !side && !below ? 40.5 : 10.5}, at[3];
            pdi_renderer_project_point(&shade, x, at);
            CHECK_NEAR((double)shade.value[pixel(&shade, at[0], at[1])], !side && !below ? 40 : 10, 1e-6);
        }
        pdi_renderer_free(&ctx, &shade);
    }
    pdi_surface_nets_free(&ctx, &s);
}

/* Edges of the box that have a face away from the eye are drawn, 1.4 pixels wide, each once; the body hides those
 * behind it. */
TEST(edges_of_the_box)
{
    static const double ways[3][3] = {{1, -2, 1.5}, {-1.2, 0.7, 2}, {0.6, 1.1, -0.8}};
    for (int w = 0; w < 3; w++)
        for (int full = 0; full < 2; full++) {
            body b = {{10, 15, 20}, full ? 2 : 0, 0.1};
            const double lo[3] = {0, 0, 0}, hi[3] = {10, 15, 20};
            double ink = 0, wanted = 0;
            int drawn = 0;
            pd_ctx ctx;
            pdi_surface_nets_mesh shell;
            pd_rendering s;
            pd_ctx_init(&ctx);
            build(&ctx, &b, &shell);
            CHECK_INT(shell.face_count > 0, full);
            CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, ways[w], 500, &s));
            CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &shell, 0, &s));
            for (int corner = 0; corner < 8; corner++)
                for (int d = 0; d < 3; d++) {
                    double a[3], c[3], x[3], at[3];
                    int away = 0;
                    if (corner >> d & 1) continue; /* the edge from there along axis d */
                    for (int e = 0; e < 3; e++) {
                        x[e] = corner >> e & 1 ? hi[e] : lo[e];
                        if (e != d) away += (corner >> e & 1) == (ways[w][e] < 0);
                    }
                    pdi_renderer_project_point(&s, x, a);
                    x[d] = hi[d];
                    pdi_renderer_project_point(&s, x, c);
                    x[d] = 0.45 * hi[d]; /* where no other edge passes */
                    pdi_renderer_project_point(&s, x, at);
                    int seen = full ? away == 1 : away > 0;
                    int share = s.edge[pixel(&s, at[0], at[1])];
                    if (seen)
                        CHECK(share > PDI_RENDERER_SAMPLES_PER_SIDE &&
                              share <= PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE);
                    else CHECK_INT(share, 0);
                    drawn += seen;
                    wanted += seen ? 1.4 * hypot(c[0] - a[0], c[1] - a[1]) + 0.49 * pi : 0;
                }
            for (int k = 0; k < s.width * s.height; k++)
                ink += s.edge[k] / (double)(PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE);
            CHECK_INT(drawn, full ? 6 : 9);
            CHECK_REL(ink, wanted, 0.05); /* nine samples of a pixel */
            pdi_renderer_free(&ctx, &s);
            pdi_surface_nets_free(&ctx, &shell);
            CHECK_INT(ctx.in_use, 0);
        }
}

/* Twice the same is the same, bit for bit, whatever the number of threads. */
TEST(views_are_reproducible)
{
    body b = {{30, 30, 30}, 0, 11.3};
    const double way[3] = {1, -1, 1}, lo[3] = {0, 0, 0}, hi[3] = {30, 30, 30};
    pd_rendering shade[2];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int k = 0; k < 2; k++) {
        pdi_surface_nets_mesh s;
        ctx.threads = k ? 2 : 1;
        build(&ctx, &b, &s);
        CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way, 200, &shade[k]));
        CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &s, 0, &shade[k]));
        pdi_surface_nets_free(&ctx, &s);
    }
    size_t pixels = (size_t)shade[0].width * (size_t)shade[0].height;
    CHECK(memcmp(shade[0].value, shade[1].value, pixels * sizeof(float)) == 0);
    CHECK(memcmp(shade[0].brightness, shade[1].brightness, pixels) == 0);
    CHECK(memcmp(shade[0].coverage, shade[1].coverage, pixels) == 0);
    CHECK(memcmp(shade[0].edge, shade[1].edge, pixels) == 0);
    for (int k = 0; k < 2; k++) pdi_renderer_free(&ctx, &shade[k]);
}

/* ---- pictures ---- */

/* Colours of the paper, of the metal in its light, and of values; the scale has its length. */
TEST(a_relief_has_its_colours)
{
    body b = {{60, 60, 60}, 1, 0};
    const double way[3] = {1, -1, 1}, lo[3] = {0, 0, 0}, hi[3] = {60, 60, 60}, top[3] = {25, 30, 50};
    pd_ctx ctx;
    pdi_surface_nets_mesh s;
    pd_rendering shade;
    pd_image image;
    pdi_surface_plot r;
    double at[3];
    pd_ctx_init(&ctx);
    build(&ctx, &b, &s);
    CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way, 400, &shade));
    CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &s, 0, &shade));
    pdi_surface_nets_free(&ctx, &s);
    memset(&r, 0, sizeof r);
    r.rendering = &shade;
    r.title = "block";
    for (int coloured = 0; coloured < 2; coloured++) {
        uint32_t table[PDI_COLOUR_TABLE_SIZE];
        r.use_values = coloured;
        r.map = PD_COLOUR_MAP_VIRIDIS;
        r.lo = 19;
        r.hi = 49;
        if (!CHECK_OK(&ctx, pdi_surface_plot_draw_image(&ctx, &r, &image))) return;
        pdi_renderer_project_point(&shade, top, at);
        size_t k = pixel(&shade, at[0], at[1]);
        size_t to = (size_t)(52 + (int)at[1]) * (size_t)image.width + (size_t)(24 + (int)at[0]);
        const uint8_t *p = image.pixels + 3 * to;
        pdi_colour_fill_table(PD_COLOUR_MAP_VIRIDIS, table);
        uint32_t base = coloured ? table[PDI_COLOUR_TABLE_SIZE - 1] : 0xC9CED6u;
        for (int c = 0; c < 3; c++)
            CHECK_NEAR(p[c], (double)(base >> (16 - 8 * c) & 255) * shade.brightness[k] / 255, 1);
        /* the scale: a dark run below the view, a tenth to a quarter of its width, of a round length */
        int run = 0;
        for (int x = 0; x < image.width; x++) {
            to = (size_t)(52 + shade.height + 14 + 7) * (size_t)image.width + (size_t)x;
            const uint8_t *q = image.pixels + 3 * to;
            if (q[0] < 80 && x >= 24 && x == 24 + run) run++;
        }
        CHECK_NEAR(run * shade.pixel_size, 20, shade.pixel_size);
        pd_image_free(&ctx, &image);
    }
    pdi_renderer_free(&ctx, &shade);
    CHECK_INT(ctx.in_use, 0);
}

/* Pixels of a colour from column `from` on, and the first row that has one. */
static int marked(const pd_image *image, int from, uint32_t colour, int *top)
{
    int count = 0;
    for (int y = 0; y < image->height; y++)
        for (int x = from; x < image->width; x++) {
            const uint8_t *p = image->pixels + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
            if ((((uint32_t)p[0] << 16) | ((uint32_t)p[1] << 8) | p[2]) != colour) continue;
            if (!count++) *top = y;
        }
    return count;
}

/* Letters of the axes stand outside, beside the middle of an edge of the outline along that axis: of x and y the lower
 * one, of z the left one. way[k]: towards the eye; edge[k][d]: the ends of these edges on the other two axes. */
TEST(axes_have_their_letters)
{
    static const double way[2][3] = {{1, -1, 1}, {-1, -2, 0.5}}, lo[3] = {0, 10, -20}, hi[3] = {60, 40, 25};
    static const int upper[2][3][3] = {{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}}};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int k = 0; k < 2; k++) {
        pd_rendering shade;
        pd_image image;
        pdi_surface_plot r;
        double x[3], middle[3];
        memset(&r, 0, sizeof r);
        r.rendering = &shade;
        if (!CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way[k], 400, &shade))) return;
        if (!CHECK_OK(&ctx, pdi_surface_plot_draw_image(&ctx, &r, &image))) return;
        for (int d = 0; d < 3; d++) x[d] = 0.5 * (lo[d] + hi[d]);
        pdi_renderer_project_point(&shade, x, middle);
        for (int d = 0; d < 3; d++) {
            double a[3], b[3], at[2], out[2];
            char letter[2] = {"xyz"[d], '\0'};
            pdi_canvas alone;
            for (int e = 0; e < 3; e++) x[e] = upper[k][d][e] ? hi[e] : lo[e];
            pdi_renderer_project_point(&shade, x, a);
            x[d] = hi[d];
            pdi_renderer_project_point(&shade, x, b);
            for (int c = 0; c < 2; c++) at[c] = 0.5 * (a[c] + b[c]);
            double length = hypot(b[0] - a[0], b[1] - a[1]), side;
            out[0] = (b[1] - a[1]) / length;
            out[1] = (a[0] - b[0]) / length;
            side = out[0] * (at[0] - middle[0]) + out[1] * (at[1] - middle[1]) < 0 ? -15 : 15;
            int left = 24 + (int)(at[0] + side * out[0]);
            int top = 52 + (int)(at[1] + side * out[1]) - PDI_CANVAS_CAPITAL_HEIGHT / 2;
            if (!CHECK_OK(&ctx, pdi_canvas_build_image(&ctx, image.width, image.height, &alone))) return;
            pdi_canvas_draw_text(&alone, left, top, PDI_ALIGN_CENTRE, PDI_CANVAS_TEXT_COLOUR, letter);
            int ink = 0, unlike = 0;
            for (int v = top; v < top + PDI_CANVAS_CAPITAL_HEIGHT; v++)
                for (int u = left - 4; u <= left + 4; u++) {
                    size_t to = 3 * ((size_t)v * (size_t)image.width + (size_t)u);
                    ink += alone.image.pixels[to] < 128;
                    unlike += alone.image.pixels[to] != image.pixels[to];
                }
            CHECK(ink >= 8);
            CHECK_INT(unlike, 0);
            pd_image_free(&ctx, &alone.image);
        }
        pd_image_free(&ctx, &image);
        pdi_renderer_free(&ctx, &shade);
    }
    CHECK_INT(ctx.in_use, 0);
}

/* The legend of a surface has a row with a mark for each label that is seen, one below the other, and for no other. */
TEST(labels_of_a_relief_have_rows)
{
    body b = {{60, 60, 60}, 1, 0};
    const double way[3] = {1, -1, 1}, lo[3] = {0, 0, 0}, hi[3] = {60, 60, 60};
    pd_ctx ctx;
    pdi_surface_nets_mesh s;
    pd_rendering shade;
    pd_image image;
    pdi_surface_plot r;
    int top[6] = {0};
    pd_ctx_init(&ctx);
    build(&ctx, &b, &s);
    CHECK_OK(&ctx, pdi_renderer_build(&ctx, lo, hi, way, 400, &shade));
    CHECK_OK(&ctx, pdi_renderer_draw_surface(&ctx, &s, 0, &shade));
    pdi_surface_nets_free(&ctx, &s);
    for (int k = 0; k < shade.width * shade.height; k++)
        shade.value[k] = k % shade.width < shade.width / 2 ? 1.0f : 4.0f;
    memset(&r, 0, sizeof r);
    r.rendering = &shade;
    r.use_values = 1;
    r.map = PD_COLOUR_MAP_LABELS;
    r.hi = 5;
    if (CHECK_OK(&ctx, pdi_surface_plot_draw_image(&ctx, &r, &image))) {
        for (int k = 0; k < 6; k++)
            CHECK_INT(marked(&image, 24 + shade.width + 16, pdi_colour_get_label_colour(k), &top[k]),
                      k == 1 || k == 4 ? 256 : 0);
        CHECK(top[1] > 0 && top[4] >= top[1] + 16);
        pd_image_free(&ctx, &image);
    }
    pdi_renderer_free(&ctx, &shade);
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(a_sphere_has_its_silhouette_and_light) ENTRY(a_ball_of_cells_is_a_sphere)
          ENTRY(a_block_shows_three_faces) ENTRY(sides_cut_the_body) ENTRY(what_is_nearer_hides)
          ENTRY(edges_of_the_box)
          ENTRY(views_are_reproducible) ENTRY(a_relief_has_its_colours) ENTRY(axes_have_their_letters)
          ENTRY(labels_of_a_relief_have_rows))
