/* shade: see shade.h */
#include "io/shade.h"
#include "io/canvas.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PDI_SHADE_HIGH 0.9 /* maximum height of the image over its width */
#define PDI_SHADE_MARGIN 26.0 /* [pixel] around the box */
#define PDI_SHADE_LINE 1.4 /* [pixel] width of the edges of the box */
#define PDI_SHADE_LIFT 1.5 /* [pixel] depth offset towards the eye, so that adjacent faces do not hide edges */

/* The z-buffer for one sample of each pixel. */
typedef struct pdi_shade_sample {
    float *depth;      /* [width * height] [pixel] depth of the nearest face so far */
    float *value;      /* [width * height] its value */
    uint8_t *light;    /* [width * height] its brightness, 1/255 */
    double shift[2];   /* [pixel] offset of the sample in its pixel */
} pdi_shade_sample;

/* A corner of a triangle: projected position and depth, unit normal, value. */
typedef struct pdi_shade_corner {
    double at[3], normal[3], value;
} pdi_shade_corner;

/* Dot product of two vectors [3]. */
static double pdi_shade_dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Cross product c = a x b. */
static void pdi_shade_cross(const double *a, const double *b, double *c)
{
    for (int d = 0; d < 3; d++) c[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
}

/* Normalise a vector [3]; a zero vector stays. */
static void pdi_shade_unit(double *v)
{
    double length = sqrt(pdi_shade_dot(v, v));
    for (int d = 0; d < 3 && length > 0.0; d++) v[d] /= length;
}

/* ---- the view ---- */

PDI_FN void pdi_shade_size(const double *lo, const double *hi, const double *direction, int width, pd_shade *s)
{
    double least[2] = {HUGE_VAL, HUGE_VAL}, most[2] = {-HUGE_VAL, -HUGE_VAL}, above[3] = {0.0, 0.0, 1.0};
    memset(s, 0, sizeof *s);
    memcpy(s->lo, lo, sizeof s->lo);
    memcpy(s->hi, hi, sizeof s->hi);
    memcpy(s->eye, direction, sizeof s->eye);
    pdi_shade_unit(s->eye);
    if (fabs(s->eye[2]) > 1.0 - 1e-6) { /* along z: y is above */
        above[1] = 1.0;
        above[2] = 0.0;
    }
    pdi_shade_cross(above, s->eye, s->right);
    pdi_shade_unit(s->right);
    pdi_shade_cross(s->eye, s->right, s->up);
    for (int k = 0; k < 8; k++) {
        double x[3] = {k & 1 ? hi[0] : lo[0], k & 2 ? hi[1] : lo[1], k & 4 ? hi[2] : lo[2]};
        double at[2] = {pdi_shade_dot(x, s->right), pdi_shade_dot(x, s->up)};
        for (int d = 0; d < 2; d++) {
            least[d] = pdi_min(least[d], at[d]);
            most[d] = pdi_max(most[d], at[d]);
        }
    }
    double room = 2.0 * PDI_SHADE_MARGIN;
    s->size = pdi_max((most[0] - least[0]) / (width - room), (most[1] - least[1]) / (PDI_SHADE_HIGH * width - room));
    s->width = (int)ceil((most[0] - least[0]) / s->size + room - 1e-6);
    s->height = (int)ceil((most[1] - least[1]) / s->size + room - 1e-6);
    for (int d = 0; d < 2; d++) s->corner[d] = least[d] - PDI_SHADE_MARGIN * s->size;
}

PDI_FN pd_status pdi_shade_build(pd_ctx *ctx, const double *lo, const double *hi, const double *direction, int width,
                                 pd_shade *s)
{
    pdi_shade_size(lo, hi, direction, width, s);
    int64_t pixels = (int64_t)s->width * s->height;
    PDI_TRY(PDI_NEW(ctx, "shade", pixels, s->value));
    PDI_TRY(PDI_NEW(ctx, "shade", pixels, s->light));
    PDI_TRY(PDI_NEW(ctx, "shade", pixels, s->cover));
    return PDI_NEW(ctx, "shade", pixels, s->edge);
}

PDI_FN void pdi_shade_free(pd_ctx *ctx, pd_shade *s)
{
    int64_t pixels = (int64_t)s->width * s->height;
    PDI_DELETE(ctx, pixels, s->value);
    PDI_DELETE(ctx, pixels, s->light);
    PDI_DELETE(ctx, pixels, s->cover);
    PDI_DELETE(ctx, pixels, s->edge);
    memset(s, 0, sizeof *s);
}

PDI_FN void pdi_shade_project(const pd_shade *s, const double *x, double *position)
{
    position[0] = (pdi_shade_dot(x, s->right) - s->corner[0]) / s->size;
    position[1] = s->height - (pdi_shade_dot(x, s->up) - s->corner[1]) / s->size;
    position[2] = pdi_shade_dot(x, s->eye) - pdi_shade_dot(s->lo, s->eye);
}

PDI_FN double pdi_shade_light(const pd_shade *s, const double *normal)
{
    static const double from[3] = {-0.3, 0.4, 0.866}; /* to the right, up, towards the eye */
    double along = from[0] * pdi_shade_dot(normal, s->right) + from[1] * pdi_shade_dot(normal, s->up) +
                   from[2] * pdi_shade_dot(normal, s->eye);
    double length = sqrt(pdi_shade_dot(from, from));
    return PDI_SHADE_AROUND + (1.0 - PDI_SHADE_AROUND) * pdi_min(pdi_max(along / length, 0.0), 1.0);
}

/* ---- faces ---- */

/* Edge function: twice the signed area of the triangle a, b, (x, y). */
static double pdi_shade_turn(const double *a, const double *b, double x, double y)
{
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

/* Rasterise a triangle into the z-buffer, front faces alone. flat 1: one `value`; 0: values interpolated between
 * corners. */
static void pdi_shade_triangle(const pd_shade *s, const pdi_shade_corner *const *c, int flat, double value,
                               pdi_shade_sample *p)
{
    double area = pdi_shade_turn(c[0]->at, c[1]->at, c[2]->at[0], c[2]->at[1]), lo[2], hi[2];
    int first[2], last[2], last_pixel[2] = {s->width - 1, s->height - 1};
    if (!(area < 0.0)) return;
    for (int d = 0; d < 2; d++) {
        lo[d] = pdi_min(c[0]->at[d], pdi_min(c[1]->at[d], c[2]->at[d])) - p->shift[d];
        hi[d] = pdi_max(c[0]->at[d], pdi_max(c[1]->at[d], c[2]->at[d])) - p->shift[d];
        first[d] = (int)pdi_max(0.0, ceil(lo[d]));
        last[d] = (int)pdi_min(floor(hi[d]), last_pixel[d]);
    }
    for (int y = first[1]; y <= last[1]; y++)
        for (int x = first[0]; x <= last[0]; x++) {
            double weight[3], depth = 0.0, normal[3] = {0.0, 0.0, 0.0}, mean = 0.0;
            int in = 1;
            for (int k = 0; k < 3; k++) {
                weight[k] = pdi_shade_turn(c[(k + 1) % 3]->at, c[(k + 2) % 3]->at, x + p->shift[0], y + p->shift[1]);
                weight[k] /= area;
                in = in && weight[k] >= 0.0;
            }
            if (!in) continue;
            for (int k = 0; k < 3; k++) depth += weight[k] * c[k]->at[2];
            size_t to = (size_t)y * (size_t)s->width + (size_t)x;
            if (!((float)(depth / s->size) > p->depth[to])) continue;
            for (int k = 0; k < 3; k++) {
                for (int d = 0; d < 3; d++) normal[d] += weight[k] * c[k]->normal[d];
                mean += weight[k] * c[k]->value;
            }
            pdi_shade_unit(normal);
            p->depth[to] = (float)(depth / s->size);
            p->value[to] = (float)(flat ? value : mean);
            p->light[to] = (uint8_t)(255.0 * pdi_shade_light(s, normal) + 0.5);
        }
}

/* Rasterise all faces of the mesh, each as two triangles along its shorter diagonal. */
static void pdi_shade_faces(const pd_shade *s, const pdi_shell *shell, int labels, pdi_shade_sample *p)
{
    for (int64_t f = 0; f < shell->faces; f++) {
        pdi_shade_corner c[4];
        const pdi_shade_corner *one[3], *other[3];
        for (int k = 0; k < 4; k++) {
            int64_t n = shell->corner[4 * f + k];
            pdi_shade_project(s, &shell->x[3 * n], c[k].at);
            for (int d = 0; d < 3; d++) c[k].normal[d] = (double)shell->normal[12 * f + 3 * k + d];
            c[k].value = shell->mean[n];
        }
        /* along the shorter diagonal */
        int by = pdi_canvas_length(c[0].at[0] - c[2].at[0], c[0].at[1] - c[2].at[1]) >
                 pdi_canvas_length(c[1].at[0] - c[3].at[0], c[1].at[1] - c[3].at[1]);
        for (int k = 0; k < 3; k++) {
            one[k] = &c[(by + k) % 4];
            other[k] = &c[(by + 2 + k) % 4];
        }
        int flat = labels || isnan(shell->value[f]);
        pdi_shade_triangle(s, one, flat, shell->value[f], p);
        pdi_shade_triangle(s, other, flat, shell->value[f], p);
    }
}

/* ---- edges of the box ---- */

PDI_FN void pdi_shade_ends(const pd_shade *s, int d, int k, double *a, double *b)
{
    int e = (d + 1) % 3, g = (d + 2) % 3;
    double x[3];
    x[e] = k & 1 ? s->hi[e] : s->lo[e];
    x[g] = k & 2 ? s->hi[g] : s->lo[g];
    x[d] = s->lo[d];
    pdi_shade_project(s, x, a);
    x[d] = s->hi[d];
    pdi_shade_project(s, x, b);
}

/* Count a sample for each pixel on the line a-b that no face hides. */
static void pdi_shade_edge(pd_shade *s, const pdi_shade_sample *p, const double *a, const double *b)
{
    double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    int steep = fabs(dy) > fabs(dx), along = steep ? 1 : 0;
    if (!(square > 0.0)) return;
    int first = (int)floor(pdi_min(a[along], b[along]) - 1.0), last = (int)ceil(pdi_max(a[along], b[along]));
    for (int i = first; i <= last; i++) {
        double fraction = pdi_min(1.0, pdi_max(0.0, (i + p->shift[along] - a[along]) / (b[along] - a[along])));
        int middle = (int)floor(a[1 - along] + fraction * (b[1 - along] - a[1 - along]));
        for (int j = middle - 1; j <= middle + 1; j++) {
            int x = steep ? j : i, y = steep ? i : j;
            double px = x + p->shift[0] - a[0], py = y + p->shift[1] - a[1];
            double along_edge = pdi_min(1.0, pdi_max(0.0, (px * dx + py * dy) / square));
            if (pdi_canvas_length(px - along_edge * dx, py - along_edge * dy) > 0.5 * PDI_SHADE_LINE) continue;
            size_t to = (size_t)y * (size_t)s->width + (size_t)x;
            double depth = (a[2] + along_edge * (b[2] - a[2])) / s->size + PDI_SHADE_LIFT;
            if (depth > (double)p->depth[to] && s->edge[to] < PDI_SHADE_SIDE * PDI_SHADE_SIDE) s->edge[to]++;
        }
    }
}

/* Draw the edges of the box, but those between two sides that face the eye, which would lie over the body. */
static void pdi_shade_edges(pd_shade *s, const pdi_shade_sample *p)
{
    for (int d = 0; d < 3; d++)
        for (int k = 0; k < 4; k++) {
            int e = (d + 1) % 3, g = (d + 2) % 3;
            double a[3], b[3];
            if ((k & 1 ? s->eye[e] : -s->eye[e]) > 0.0 && (k & 2 ? s->eye[g] : -s->eye[g]) > 0.0) continue;
            pdi_shade_ends(s, d, k, a, b);
            pdi_shade_edge(s, p, a, b);
        }
}

/* ---- samples ---- */

/* Sums over the samples of each pixel. */
typedef struct pdi_shade_sums {
    double *value;
    uint16_t *light;
    uint8_t *valued; /* [width * height] number of samples with a value */
} pdi_shade_sums;

/* Add one sample of each pixel to the sums; labels 1: the first value counts, since means of labels mean nothing. */
static void pdi_shade_add(pd_shade *s, const pdi_shade_sample *p, int labels, pdi_shade_sums *sums)
{
    for (size_t k = 0; k < (size_t)s->width * (size_t)s->height; k++) {
        if (!(p->depth[k] > -FLT_MAX)) continue;
        s->cover[k]++;
        sums->light[k] = (uint16_t)(sums->light[k] + p->light[k]);
        if (isnan(p->value[k]) || (labels && sums->valued[k])) continue;
        sums->value[k] += (double)p->value[k];
        sums->valued[k]++;
    }
}

/* Render all samples of the pixels and average them. */
static void pdi_shade_samples(pd_shade *s, const pdi_shell *shell, int labels, pdi_shade_sample *p,
                              pdi_shade_sums *sums)
{
    size_t pixels = (size_t)s->width * (size_t)s->height;
    memset(s->cover, 0, pixels);
    memset(s->edge, 0, pixels);
    for (int n = 0; n < PDI_SHADE_SIDE * PDI_SHADE_SIDE; n++) {
        p->shift[0] = (n % PDI_SHADE_SIDE + 0.5) / PDI_SHADE_SIDE;
        p->shift[1] = (n / PDI_SHADE_SIDE + 0.5) / PDI_SHADE_SIDE;
        for (size_t k = 0; k < pixels; k++) p->depth[k] = -FLT_MAX;
        pdi_shade_faces(s, shell, labels, p);
        pdi_shade_edges(s, p);
        pdi_shade_add(s, p, labels, sums);
    }
    for (size_t k = 0; k < pixels; k++) {
        unsigned cover = s->cover[k];
        s->light[k] = (uint8_t)(cover ? (sums->light[k] + cover / 2) / cover : 0u);
        s->value[k] = sums->valued[k] ? (float)(sums->value[k] / sums->valued[k]) : (float)NAN;
    }
}

PDI_FN pd_status pdi_shade_draw(pd_ctx *ctx, const pdi_shell *shell, int labels, pd_shade *s)
{
    pdi_shade_sample p;
    pdi_shade_sums sums;
    int64_t pixels = (int64_t)s->width * s->height;
    memset(&p, 0, sizeof p);
    memset(&sums, 0, sizeof sums);
    pd_status status = PDI_NEW(ctx, "shade", pixels, p.depth);
    if (status == PD_OK) status = PDI_NEW(ctx, "shade", pixels, p.value);
    if (status == PD_OK) status = PDI_NEW(ctx, "shade", pixels, p.light);
    if (status == PD_OK) status = PDI_NEW(ctx, "shade", pixels, sums.value);
    if (status == PD_OK) status = PDI_NEW(ctx, "shade", pixels, sums.light);
    if (status == PD_OK) status = PDI_NEW(ctx, "shade", pixels, sums.valued);
    if (status == PD_OK) pdi_shade_samples(s, shell, labels, &p, &sums);
    PDI_DELETE(ctx, pixels, p.depth);
    PDI_DELETE(ctx, pixels, p.value);
    PDI_DELETE(ctx, pixels, p.light);
    PDI_DELETE(ctx, pixels, sums.value);
    PDI_DELETE(ctx, pixels, sums.light);
    PDI_DELETE(ctx, pixels, sums.valued);
    return status;
}

#undef PDI_SHADE_HIGH
#undef PDI_SHADE_MARGIN
#undef PDI_SHADE_LINE
#undef PDI_SHADE_LIFT
