/* deformed_plot: see deformed_plot.h */
#include "io/deformed_plot.h"
#include <math.h>
#include <string.h>

/* Maximum displacement over the size of the picture. */
#define PDI_DEFORMED_PLOT_MAX_DISPLACEMENT 10.0
/* Tolerance [pixel] by which cells are enlarged, so that rounding leaves no gap between them. */
#define PDI_DEFORMED_PLOT_EDGE_TOLERANCE 1e-6

/* The raster that deformed cells are drawn into: square pixels. */
typedef struct pdi_deformed_plot_raster {
    double lo[2], size; /* [m] corner, width of a pixel */
    int n[2];
    double *value;      /* [n[0] * n[1]] [-] */
    uint8_t *paint;     /* [n[0] * n[1]] */
} pdi_deformed_plot_raster;

/* Position[2] [m] of the displaced corner of the cell (i, j) at its right (s 1) or left, upper (t 1) or lower end: it
 * moves by the mean displacement of this cell and of those that meet there and are connected with it, directly or
 * through others. Cells outside the grid or of NaN do not count. */
static void pdi_deformed_plot_displace_corner(const pdi_deformed_plot *w, int i, int j, int s, int t, double *position)
{
    const pd_field_plot *p = w->undeformed;
    int cell[4], in[4] = {1, 0, 0, 0}, count = 0;
    size_t cells = (size_t)p->nx * (size_t)p->ny;
    double sum[2] = {0.0, 0.0};
    for (int k = 0; k < 4; k++) {
        int column = i + (k & 1) * (2 * s - 1), row = j + (k >> 1) * (2 * t - 1);
        cell[k] = column >= 0 && column < p->nx && row >= 0 && row < p->ny ? row * p->nx + column : -1;
        if (cell[k] >= 0 && isnan(w->displacement[cell[k]])) cell[k] = -1;
    }
    for (int round = 0; round < 3; round++)
        for (int a = 0; a < 4; a++)
            for (int b = 0; b < 4; b++)
                if (in[a] && !in[b] && cell[b] >= 0) in[b] = w->is_connected(w->user, cell[a], cell[b]);
    for (int k = 0; k < 4; k++) {
        if (!in[k]) continue;
        for (int d = 0; d < 2; d++) sum[d] += w->displacement[(size_t)d * cells + (size_t)cell[k]];
        count++;
    }
    position[0] = p->lo[0] + (i + s) * (p->hi[0] - p->lo[0]) / p->nx + sum[0] / count;
    position[1] = p->lo[1] + (j + t) * (p->hi[1] - p->lo[1]) / p->ny + sum[1] / count;
}

/* Displaced corners at[4][2] [m] of a cell, counterclockwise from the lower left one. */
static void pdi_deformed_plot_displace_cell(const pdi_deformed_plot *w, int cell, double (*at)[2])
{
    for (int k = 0; k < 4; k++)
        pdi_deformed_plot_displace_corner(w, cell % w->undeformed->nx, cell / w->undeformed->nx, k == 1 || k == 2,
                                          k >> 1, at[k]);
}

PDI_FN pd_status pdi_deformed_plot_extend_range(pd_ctx *ctx, const pdi_deformed_plot *w, double *lo, double *hi)
{
    const pd_field_plot *p = w->undeformed;
    double at[4][2];
    for (int d = 0; d < 2; d++) {
        lo[d] = pd_min(lo[d], p->lo[d]);
        hi[d] = pd_max(hi[d], p->hi[d]);
    }
    for (int cell = 0; cell < p->nx * p->ny; cell++) {
        if (isnan(w->displacement[cell])) continue;
        pdi_deformed_plot_displace_cell(w, cell, at);
        for (int k = 0; k < 8; k++) {
            double x = at[k / 2][k % 2], size = p->hi[k % 2] - p->lo[k % 2];
            if (!(fabs(x - p->lo[k % 2]) <= PDI_DEFORMED_PLOT_MAX_DISPLACEMENT * size))
                return pd_fail(ctx, PD_ERR_ARGUMENT, "deformed_plot",
                               "displacements of %g m as they are drawn in a picture of "
                               "%g m, expected at most ten times as much: choose a smaller factor",
                               x - p->lo[k % 2], size);
            lo[k % 2] = pd_min(lo[k % 2], x);
            hi[k % 2] = pd_max(hi[k % 2], x);
        }
    }
    return PD_OK;
}

/* Set corner, pixel width and size of the raster for the extent lo[2] .. hi[2] [m]: square pixels, as few metres each
 * as the width of the picture and a height of PD_FIELD_PLOT_MAX_ASPECT times that allow; at least one along each axis.
 * Its arrays are not allocated. */
static void pdi_deformed_plot_init_raster(const pdi_deformed_plot *w, const double *lo, const double *hi,
                                          pdi_deformed_plot_raster *raster)
{
    double wide[2], width = w->undeformed->width ? w->undeformed->width : PD_FIELD_PLOT_WIDTH; /* [pixel] */
    for (int d = 0; d < 2; d++) {
        raster->lo[d] = lo[d];
        wide[d] = hi[d] - lo[d];
    }
    raster->size = pd_max(wide[0] / width, wide[1] / (PD_FIELD_PLOT_MAX_ASPECT * width));
    for (int d = 0; d < 2; d++) raster->n[d] = (int)pd_max(1.0, ceil(wide[d] / raster->size - 1e-6));
}

/* Set the paint of all pixels: background outside of the picture and where cells have displacements; the others are
 * drawn in place, with their values. */
static void pdi_deformed_plot_draw_undisplaced(const pdi_deformed_plot *w, pdi_deformed_plot_raster *raster)
{
    const pd_field_plot *p = w->undeformed;
    for (int y = 0; y < raster->n[1]; y++)
        for (int x = 0; x < raster->n[0]; x++) {
            size_t to = (size_t)y * (size_t)raster->n[0] + (size_t)x;
            double column = (raster->lo[0] + (x + 0.5) * raster->size - p->lo[0]) / (p->hi[0] - p->lo[0]) * p->nx;
            double row = (raster->lo[1] + (y + 0.5) * raster->size - p->lo[1]) / (p->hi[1] - p->lo[1]) * p->ny;
            raster->paint[to] = PD_PAINT_OUTSIDE;
            if (!(column >= 0.0 && column < p->nx && row >= 0.0 && row < p->ny)) continue;
            size_t cell = (size_t)row * (size_t)p->nx + (size_t)column;
            if (!isnan(w->displacement[cell])) continue;
            raster->value[to] = p->values[cell];
            raster->paint[to] = p->cell_paint ? p->cell_paint[cell] : (uint8_t)PD_PAINT_FIELD;
        }
}

/* Returns 1 when the triangle a, b, c [pixel] contains the point x, with a tolerance at its sides; the triangle may
 * have either orientation. */
static int pdi_deformed_plot_is_in_triangle(const double *a, const double *b, const double *c, const double *x)
{
    const double *corner[4] = {a, b, c, a};
    int left = 1, right = 1;
    for (int k = 0; k < 3; k++) {
        const double *p = corner[k], *q = corner[k + 1];
        double turn = (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0]);
        double rounding = PDI_DEFORMED_PLOT_EDGE_TOLERANCE * (fabs(q[0] - p[0]) + fabs(q[1] - p[1]));
        left = left && turn >= -rounding;
        right = right && turn <= rounding;
    }
    return left || right;
}

/* Draw a displaced cell over those before it: all pixels whose centres lie in it. */
static void pdi_deformed_plot_draw_cell(const pdi_deformed_plot *w, int cell, pdi_deformed_plot_raster *raster)
{
    double at[4][2], lo[2] = {HUGE_VAL, HUGE_VAL}, hi[2] = {-HUGE_VAL, -HUGE_VAL};
    int first[2], last[2];
    pdi_deformed_plot_displace_cell(w, cell, at);
    for (int k = 0; k < 8; k++) { /* in pixels */
        double *x = &at[k / 2][k % 2];
        *x = (*x - raster->lo[k % 2]) / raster->size;
        lo[k % 2] = pd_min(lo[k % 2], *x);
        hi[k % 2] = pd_max(hi[k % 2], *x);
    }
    for (int d = 0; d < 2; d++) {
        first[d] = (int)pd_max(0.0, floor(lo[d] - 0.5));
        last[d] = (int)pd_min(raster->n[d] - 1.0, ceil(hi[d]));
    }
    for (int y = first[1]; y <= last[1]; y++)
        for (int x = first[0]; x <= last[0]; x++) {
            double middle[2] = {x + 0.5, y + 0.5};
            size_t to = (size_t)y * (size_t)raster->n[0] + (size_t)x;
            if (!pdi_deformed_plot_is_in_triangle(at[0], at[1], at[2], middle) &&
                !pdi_deformed_plot_is_in_triangle(at[0], at[2], at[3], middle))
                continue;
            raster->value[to] = w->undeformed->values[cell];
            raster->paint[to] = w->undeformed->cell_paint ? w->undeformed->cell_paint[cell] : (uint8_t)PD_PAINT_FIELD;
        }
}

/* Draw all cells into the raster, then its picture into the image, or into the file `path` where image is NULL. The
 * picture has a cell for each pixel: magnification 1, not smooth. Allocates the arrays of the raster, which the caller
 * frees, also on failure. */
static pd_status pdi_deformed_plot_draw_raster(pd_ctx *ctx, const pdi_deformed_plot *w,
                                               pdi_deformed_plot_raster *raster, const char *path, pd_image *image)
{
    pd_field_plot picture = *w->undeformed;
    int64_t pixels = (int64_t)raster->n[0] * raster->n[1];
    PD_TRY(PD_NEW(ctx, "deformed_plot", pixels, raster->value));
    PD_TRY(PD_NEW(ctx, "deformed_plot", pixels, raster->paint));
    pdi_deformed_plot_draw_undisplaced(w, raster);
    for (int cell = 0; cell < w->undeformed->nx * w->undeformed->ny; cell++)
        if (!isnan(w->displacement[cell])) pdi_deformed_plot_draw_cell(w, cell, raster);
    picture.nx = raster->n[0];
    picture.ny = raster->n[1];
    picture.values = raster->value;
    picture.cell_paint = raster->paint;
    picture.magnification = 1;
    picture.smooth = 0;
    for (int d = 0; d < 2; d++) {
        picture.lo[d] = raster->lo[d];
        picture.hi[d] = raster->lo[d] + raster->n[d] * raster->size;
    }
    return image ? pd_field_plot_draw_image(ctx, &picture, image) : pd_field_plot_write(ctx, path, &picture);
}

/* Determine the extent and draw into the image, or into the file `path` where image is NULL. The given extent counts
 * where lo < hi along both axes, else that of all displaced cells. */
static pd_status pdi_deformed_plot_draw_or_write(pd_ctx *ctx, const pdi_deformed_plot *w, const char *path,
                                                 pd_image *image)
{
    pdi_deformed_plot_raster raster;
    double lo[2], hi[2];
    int given = w->lo[0] < w->hi[0] && w->lo[1] < w->hi[1];
    memset(&raster, 0, sizeof raster);
    for (int d = 0; d < 2; d++) {
        lo[d] = given ? w->lo[d] : HUGE_VAL;
        hi[d] = given ? w->hi[d] : -HUGE_VAL;
    }
    if (!given) PD_TRY(pdi_deformed_plot_extend_range(ctx, w, lo, hi));
    pdi_deformed_plot_init_raster(w, lo, hi, &raster);
    pd_status status = pdi_deformed_plot_draw_raster(ctx, w, &raster, path, image);
    PD_DELETE(ctx, (int64_t)raster.n[0] * raster.n[1], raster.value);
    PD_DELETE(ctx, (int64_t)raster.n[0] * raster.n[1], raster.paint);
    return status;
}

PDI_FN pd_status pdi_deformed_plot_draw_image(pd_ctx *ctx, const pdi_deformed_plot *w, pd_image *image)
{
    memset(image, 0, sizeof *image);
    return pdi_deformed_plot_draw_or_write(ctx, w, NULL, image);
}

PDI_FN pd_status pdi_deformed_plot_write(pd_ctx *ctx, const char *path, const pdi_deformed_plot *w)
{
    return pdi_deformed_plot_draw_or_write(ctx, w, path, NULL);
}

#undef PDI_DEFORMED_PLOT_MAX_DISPLACEMENT
#undef PDI_DEFORMED_PLOT_EDGE_TOLERANCE
