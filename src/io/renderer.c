/* renderer: see renderer.h */
#include "io/renderer.h"
#include "io/canvas.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PDI_RENDERER_MAX_ASPECT 0.9 /* maximum height of the image over its width */
#define PDI_RENDERER_MARGIN 26.0    /* [pixel] around the box */
#define PDI_RENDERER_EDGE_WIDTH 1.4 /* [pixel] width of the edges of the box */
/* [pixel] depth offset towards the eye, so that adjacent faces do not hide edges */
#define PDI_RENDERER_EDGE_DEPTH_OFFSET 1.5

/* The z-buffer for one sample of each pixel. */
typedef struct pdi_renderer_zbuffer {
    float *depth;      /* [width * height] [pixel] depth of the nearest face so far */
    float *value;      /* [width * height] its value */
    uint8_t *light;    /* [width * height] its brightness, 1/255 */
    double offset[2];  /* [pixel] offset of the sample in its pixel */
} pdi_renderer_zbuffer;

/* A corner of a triangle: projected position and depth, unit normal, value. */
typedef struct pdi_renderer_corner {
    double position[3], normal[3], value;
} pdi_renderer_corner;

/* Dot product of two vectors [3]. */
static double pdi_renderer_dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Cross product c = a x b. */
static void pdi_renderer_cross(const double *a, const double *b, double *c)
{
    for (int d = 0; d < 3; d++) c[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
}

/* Normalise a vector [3]; a zero vector stays. */
static void pdi_renderer_normalise(double *v)
{
    double length = sqrt(pdi_renderer_dot(v, v));
    for (int d = 0; d < 3 && length > 0.0; d++) v[d] /= length;
}

/* ---- the view ---- */

PDI_FN void pdi_renderer_init_view(const double *lo, const double *hi, const double *direction, int width,
                                   pd_rendering *s)
{
    double least[2] = {HUGE_VAL, HUGE_VAL}, most[2] = {-HUGE_VAL, -HUGE_VAL}, above[3] = {0.0, 0.0, 1.0};
    memset(s, 0, sizeof *s);
    memcpy(s->lo, lo, sizeof s->lo);
    memcpy(s->hi, hi, sizeof s->hi);
    memcpy(s->eye, direction, sizeof s->eye);
    pdi_renderer_normalise(s->eye);
    if (fabs(s->eye[2]) > 1.0 - 1e-6) { /* along z: y is above */
        above[1] = 1.0;
        above[2] = 0.0;
    }
    pdi_renderer_cross(above, s->eye, s->right);
    pdi_renderer_normalise(s->right);
    pdi_renderer_cross(s->eye, s->right, s->up);
    for (int k = 0; k < 8; k++) {
        double x[3] = {k & 1 ? hi[0] : lo[0], k & 2 ? hi[1] : lo[1], k & 4 ? hi[2] : lo[2]};
        double at[2] = {pdi_renderer_dot(x, s->right), pdi_renderer_dot(x, s->up)};
        for (int d = 0; d < 2; d++) {
            least[d] = pd_min(least[d], at[d]);
            most[d] = pd_max(most[d], at[d]);
        }
    }
    double room = 2.0 * PDI_RENDERER_MARGIN;
    s->pixel_size =
        pd_max((most[0] - least[0]) / (width - room), (most[1] - least[1]) / (PDI_RENDERER_MAX_ASPECT * width - room));
    s->width = (int)ceil((most[0] - least[0]) / s->pixel_size + room - 1e-6);
    s->height = (int)ceil((most[1] - least[1]) / s->pixel_size + room - 1e-6);
    for (int d = 0; d < 2; d++) s->corner[d] = least[d] - PDI_RENDERER_MARGIN * s->pixel_size;
}

PDI_FN pd_status pdi_renderer_build(pd_ctx *ctx, const double *lo, const double *hi, const double *direction, int width,
                                    pd_rendering *s)
{
    pdi_renderer_init_view(lo, hi, direction, width, s);
    int64_t pixels = (int64_t)s->width * s->height;
    PD_TRY(PD_NEW(ctx, "shade", pixels, s->value));
    PD_TRY(PD_NEW(ctx, "shade", pixels, s->brightness));
    PD_TRY(PD_NEW(ctx, "shade", pixels, s->coverage));
    return PD_NEW(ctx, "shade", pixels, s->edge);
}

PDI_FN void pdi_renderer_free(pd_ctx *ctx, pd_rendering *s)
{
    int64_t pixels = (int64_t)s->width * s->height;
    PD_DELETE(ctx, pixels, s->value);
    PD_DELETE(ctx, pixels, s->brightness);
    PD_DELETE(ctx, pixels, s->coverage);
    PD_DELETE(ctx, pixels, s->edge);
    memset(s, 0, sizeof *s);
}

PDI_FN void pdi_renderer_project_point(const pd_rendering *s, const double *x, double *position)
{
    position[0] = (pdi_renderer_dot(x, s->right) - s->corner[0]) / s->pixel_size;
    position[1] = s->height - (pdi_renderer_dot(x, s->up) - s->corner[1]) / s->pixel_size;
    position[2] = pdi_renderer_dot(x, s->eye) - pdi_renderer_dot(s->lo, s->eye);
}

PDI_FN double pdi_renderer_compute_brightness(const pd_rendering *s, const double *normal)
{
    static const double from[3] = {-0.3, 0.4, 0.866}; /* to the right, up, towards the eye */
    double along = from[0] * pdi_renderer_dot(normal, s->right) + from[1] * pdi_renderer_dot(normal, s->up) +
                   from[2] * pdi_renderer_dot(normal, s->eye);
    double length = sqrt(pdi_renderer_dot(from, from));
    return PDI_RENDERER_AMBIENT_LIGHT + (1.0 - PDI_RENDERER_AMBIENT_LIGHT) * pd_min(pd_max(along / length, 0.0), 1.0);
}

/* ---- faces ---- */

/* Edge function: twice the signed area [pixel^2] of the triangle a, b, (x, y); y is down, so front faces are
 * negative. */
static double pdi_renderer_edge_function(const double *a, const double *b, double x, double y)
{
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

/* Rasterise a triangle c[3] into the z-buffer, clipped to the image, where it is nearer to the eye than what is there.
 * Front faces alone: other ones, and such without area, are skipped. flat 1: one `value`; 0: values interpolated
 * between corners. */
static void pdi_renderer_draw_triangle(const pd_rendering *s, const pdi_renderer_corner *const *c, int flat,
                                       double value, pdi_renderer_zbuffer *p)
{
    double area = pdi_renderer_edge_function(c[0]->position, c[1]->position, c[2]->position[0], c[2]->position[1]),
           lo[2], hi[2];
    int first[2], last[2], last_pixel[2] = {s->width - 1, s->height - 1};
    if (!(area < 0.0)) return;
    for (int d = 0; d < 2; d++) {
        lo[d] = pd_min(c[0]->position[d], pd_min(c[1]->position[d], c[2]->position[d])) - p->offset[d];
        hi[d] = pd_max(c[0]->position[d], pd_max(c[1]->position[d], c[2]->position[d])) - p->offset[d];
        first[d] = (int)pd_max(0.0, ceil(lo[d]));
        last[d] = (int)pd_min(floor(hi[d]), last_pixel[d]);
    }
    for (int y = first[1]; y <= last[1]; y++)
        for (int x = first[0]; x <= last[0]; x++) {
            double weight[3], depth = 0.0, normal[3] = {0.0, 0.0, 0.0}, mean = 0.0;
            int in = 1;
            for (int k = 0; k < 3; k++) {
                weight[k] = pdi_renderer_edge_function(c[(k + 1) % 3]->position, c[(k + 2) % 3]->position,
                                                       x + p->offset[0], y + p->offset[1]);
                weight[k] /= area;
                in = in && weight[k] >= 0.0;
            }
            if (!in) continue;
            for (int k = 0; k < 3; k++) depth += weight[k] * c[k]->position[2];
            size_t to = (size_t)y * (size_t)s->width + (size_t)x;
            if (!((float)(depth / s->pixel_size) > p->depth[to])) continue;
            for (int k = 0; k < 3; k++) {
                for (int d = 0; d < 3; d++) normal[d] += weight[k] * c[k]->normal[d];
                mean += weight[k] * c[k]->value;
            }
            pdi_renderer_normalise(normal);
            p->depth[to] = (float)(depth / s->pixel_size);
            p->value[to] = (float)(flat ? value : mean);
            p->light[to] = (uint8_t)(255.0 * pdi_renderer_compute_brightness(s, normal) + 0.5);
        }
}

/* Rasterise all faces of the mesh, each as two triangles along its shorter diagonal in the image. A face has one value
 * where labels is 1 or it has none (NaN), else that interpolated between its vertices. */
static void pdi_renderer_draw_faces(const pd_rendering *s, const pdi_surface_nets_mesh *shell, int labels,
                                    pdi_renderer_zbuffer *p)
{
    for (int64_t f = 0; f < shell->face_count; f++) {
        pdi_renderer_corner c[4];
        const pdi_renderer_corner *one[3], *other[3];
        for (int k = 0; k < 4; k++) {
            int64_t n = shell->face_vertex[4 * f + k];
            pdi_renderer_project_point(s, &shell->x[3 * n], c[k].position);
            for (int d = 0; d < 3; d++) c[k].normal[d] = (double)shell->corner_normal[12 * f + 3 * k + d];
            c[k].value = shell->vertex_value[n];
        }
        /* along the shorter diagonal */
        int by = pdi_canvas_hypot(c[0].position[0] - c[2].position[0], c[0].position[1] - c[2].position[1]) >
                 pdi_canvas_hypot(c[1].position[0] - c[3].position[0], c[1].position[1] - c[3].position[1]);
        for (int k = 0; k < 3; k++) {
            one[k] = &c[(by + k) % 4];
            other[k] = &c[(by + 2 + k) % 4];
        }
        int flat = labels || isnan(shell->face_value[f]);
        pdi_renderer_draw_triangle(s, one, flat, shell->face_value[f], p);
        pdi_renderer_draw_triangle(s, other, flat, shell->face_value[f], p);
    }
}

/* ---- edges of the box ---- */

PDI_FN void pdi_renderer_project_box_edge(const pd_rendering *s, int d, int k, double *a, double *b)
{
    int e = (d + 1) % 3, g = (d + 2) % 3;
    double x[3];
    x[e] = k & 1 ? s->hi[e] : s->lo[e];
    x[g] = k & 2 ? s->hi[g] : s->lo[g];
    x[d] = s->lo[d];
    pdi_renderer_project_point(s, x, a);
    x[d] = s->hi[d];
    pdi_renderer_project_point(s, x, b);
}

/* Count a sample in `edge` for each pixel whose sample lies within half the edge width of the line a-b, and which no
 * face hides (depth offset towards the eye); nothing where a and b are one pixel position. The line lies inside the
 * image. */
static void pdi_renderer_draw_edge(pd_rendering *s, const pdi_renderer_zbuffer *p, const double *a, const double *b)
{
    double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
    int steep = fabs(dy) > fabs(dx), along = steep ? 1 : 0;
    if (!(square > 0.0)) return;
    int first = (int)floor(pd_min(a[along], b[along]) - 1.0), last = (int)ceil(pd_max(a[along], b[along]));
    for (int i = first; i <= last; i++) {
        double fraction = pd_min(1.0, pd_max(0.0, (i + p->offset[along] - a[along]) / (b[along] - a[along])));
        int middle = (int)floor(a[1 - along] + fraction * (b[1 - along] - a[1 - along]));
        for (int j = middle - 1; j <= middle + 1; j++) {
            int x = steep ? j : i, y = steep ? i : j;
            double px = x + p->offset[0] - a[0], py = y + p->offset[1] - a[1];
            double along_edge = pd_min(1.0, pd_max(0.0, (px * dx + py * dy) / square));
            if (pdi_canvas_hypot(px - along_edge * dx, py - along_edge * dy) > 0.5 * PDI_RENDERER_EDGE_WIDTH) continue;
            size_t to = (size_t)y * (size_t)s->width + (size_t)x;
            double depth = (a[2] + along_edge * (b[2] - a[2])) / s->pixel_size + PDI_RENDERER_EDGE_DEPTH_OFFSET;
            if (depth > (double)p->depth[to] &&
                s->edge[to] < PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE)
                s->edge[to]++;
        }
    }
}

/* Draw the edges of the box, but those between two sides that face the eye, which would lie over the body. */
static void pdi_renderer_draw_box_edges(pd_rendering *s, const pdi_renderer_zbuffer *p)
{
    for (int d = 0; d < 3; d++)
        for (int k = 0; k < 4; k++) {
            int e = (d + 1) % 3, g = (d + 2) % 3;
            double a[3], b[3];
            if ((k & 1 ? s->eye[e] : -s->eye[e]) > 0.0 && (k & 2 ? s->eye[g] : -s->eye[g]) > 0.0) continue;
            pdi_renderer_project_box_edge(s, d, k, a, b);
            pdi_renderer_draw_edge(s, p, a, b);
        }
}

/* ---- samples ---- */

/* Sums over the samples of each pixel. */
typedef struct pdi_renderer_sums {
    double *value;
    uint16_t *light;
    uint8_t *value_count; /* [width * height] number of samples with a value */
} pdi_renderer_sums;

/* Add one sample of each pixel that the body covers to the sums and to the coverage; labels 1: the first value counts,
 * since means of labels mean nothing. */
static void pdi_renderer_add_sample(pd_rendering *s, const pdi_renderer_zbuffer *p, int labels, pdi_renderer_sums *sums)
{
    for (size_t k = 0; k < (size_t)s->width * (size_t)s->height; k++) {
        if (!(p->depth[k] > -FLT_MAX)) continue;
        s->coverage[k]++;
        sums->light[k] = (uint16_t)(sums->light[k] + p->light[k]);
        if (isnan(p->value[k]) || (labels && sums->value_count[k])) continue;
        sums->value[k] += (double)p->value[k];
        sums->value_count[k]++;
    }
}

/* Render all samples of the pixels and average them into value (of samples that have one, NaN without), brightness (of
 * samples on the body, 0 without), coverage and edge, which are numbers of samples. The sums start at 0. */
static void pdi_renderer_draw_samples(pd_rendering *s, const pdi_surface_nets_mesh *shell, int labels,
                                      pdi_renderer_zbuffer *p, pdi_renderer_sums *sums)
{
    size_t pixels = (size_t)s->width * (size_t)s->height;
    memset(s->coverage, 0, pixels);
    memset(s->edge, 0, pixels);
    for (int n = 0; n < PDI_RENDERER_SAMPLES_PER_SIDE * PDI_RENDERER_SAMPLES_PER_SIDE; n++) {
        p->offset[0] = (n % PDI_RENDERER_SAMPLES_PER_SIDE + 0.5) / PDI_RENDERER_SAMPLES_PER_SIDE;
        p->offset[1] = (n / PDI_RENDERER_SAMPLES_PER_SIDE + 0.5) / PDI_RENDERER_SAMPLES_PER_SIDE;
        for (size_t k = 0; k < pixels; k++) p->depth[k] = -FLT_MAX;
        pdi_renderer_draw_faces(s, shell, labels, p);
        pdi_renderer_draw_box_edges(s, p);
        pdi_renderer_add_sample(s, p, labels, sums);
    }
    for (size_t k = 0; k < pixels; k++) {
        unsigned cover = s->coverage[k];
        s->brightness[k] = (uint8_t)(cover ? (sums->light[k] + cover / 2) / cover : 0u);
        s->value[k] = sums->value_count[k] ? (float)(sums->value[k] / sums->value_count[k]) : (float)NAN;
    }
}

PDI_FN pd_status pdi_renderer_draw_surface(pd_ctx *ctx, const pdi_surface_nets_mesh *shell, int labels, pd_rendering *s)
{
    pdi_renderer_zbuffer p;
    pdi_renderer_sums sums;
    int64_t pixels = (int64_t)s->width * s->height;
    memset(&p, 0, sizeof p);
    memset(&sums, 0, sizeof sums);
    pd_status status = PD_NEW(ctx, "shade", pixels, p.depth);
    if (status == PD_OK) status = PD_NEW(ctx, "shade", pixels, p.value);
    if (status == PD_OK) status = PD_NEW(ctx, "shade", pixels, p.light);
    if (status == PD_OK) status = PD_NEW(ctx, "shade", pixels, sums.value);
    if (status == PD_OK) status = PD_NEW(ctx, "shade", pixels, sums.light);
    if (status == PD_OK) status = PD_NEW(ctx, "shade", pixels, sums.value_count);
    if (status == PD_OK) pdi_renderer_draw_samples(s, shell, labels, &p, &sums);
    PD_DELETE(ctx, pixels, p.depth);
    PD_DELETE(ctx, pixels, p.value);
    PD_DELETE(ctx, pixels, p.light);
    PD_DELETE(ctx, pixels, sums.value);
    PD_DELETE(ctx, pixels, sums.light);
    PD_DELETE(ctx, pixels, sums.value_count);
    return status;
}

#undef PDI_RENDERER_MAX_ASPECT
#undef PDI_RENDERER_MARGIN
#undef PDI_RENDERER_EDGE_WIDTH
#undef PDI_RENDERER_EDGE_DEPTH_OFFSET
