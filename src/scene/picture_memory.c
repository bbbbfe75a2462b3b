/* picture_memory: see picture_memory.h */
#include "scene/picture_memory.h"
#include "io/renderer.h"
#include "io/field_plot.h"
#include <math.h>

/* [byte] A plot: pixels, filtered rows, the compressed file and the state of the compressor. */
#define PDI_PICTURE_MEMORY_PLOT_BYTES 5.7e6
/* [byte] The state of the compressor alone. */
#define PDI_PICTURE_MEMORY_DEFLATE_BYTES 0.65e6

/* Pixels along an axis for a field of `cells` cells: whole ones a cell, about `wanted` in all, at least 120. With more
 * than `largest` cells several cells share a pixel, so that there are `largest` pixels at most. */
static double pdi_picture_memory_count_pixels(double cells, double wanted, double largest)
{
    double each = pd_max(1.0, floor(wanted / cells + 0.5));
    return cells > largest ? cells / ceil(cells / largest) : pd_max(cells * each, 120.0);
}

/* [byte] Memory of the rendered metal surface, its mesh taken as large as the surface of the box; 0 outside 3D and
 * where drawing.surface is 0. */
static double pdi_picture_memory_estimate_surface_view(const pd_setup *setup)
{
    pd_rendering s;
    double lo[3] = {0.0, 0.0, 0.0}, hi[3] = {1.0, 1.0, 1.0}, faces = 0.0;
    if (PD_DIM < 3 || !setup->drawing.surface) return 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        int e = (d + 1) % PD_DIM;
        lo[d] = setup->lo[d];
        hi[d] = setup->hi[d];
        faces += 2.0 * (setup->hi[d] - setup->lo[d]) / setup->h[d] * (setup->hi[e] - setup->lo[e]) / setup->h[e];
    }
    pdi_renderer_init_view(lo, hi, setup->drawing.view_direction,
                           setup->drawing.width ? setup->drawing.width : PD_FIELD_PLOT_WIDTH, &s);
    double pixels = (double)s.width * s.height, image = 6.0 * (s.width + 140.0) * (s.height + 110.0);
    double sorted = setup->drawing.percentile > 0.0 && setup->drawing.percentile < 1.0 ? 8.0 * pixels : 0.0;
    return 7.0 * pixels + sorted + pd_max(20.0 * pixels + 330.0 * faces, image + PDI_PICTURE_MEMORY_DEFLATE_BYTES);
}

PDI_FN double pdi_picture_memory_estimate(const pd_setup *u)
{
    int right = u->slice_axis == 0 && PD_DIM == 3 ? 1 : 0, up = u->slice_axis == 2 || PD_DIM < 3 ? 1 : 2;
    int lines = 0, flows = 0, plots = u->has_dissolve || (PD_DIM == 1 && u->images);
    double largest = 0.0, across = 0.0;
    for (int k = 0; k < u->monitors; k++) {
        const pd_setup_monitor *m = &u->monitor[k];
        plots = plots || (m->kind == PD_MONITOR_LINE && m->images) || (m->kind == PD_MONITOR_TRANSFER && m->axis >= 0);
    }
    if (plots) largest = PDI_PICTURE_MEMORY_PLOT_BYTES;
    largest = pd_max(largest, pdi_picture_memory_estimate_surface_view(u));
    if (PD_DIM == 1 || !u->images) return largest;
    double lx = u->hi[right] - u->lo[right], ly = u->hi[up] - u->lo[up];
    if (u->axisymmetric && !(u->lo[up] > 0.0)) ly *= 2.0; /* both halves are drawn */
    double wanted = u->drawing.width ? u->drawing.width : PD_FIELD_PLOT_WIDTH, cells = lx / u->h[right] * ly / u->h[up];
    double scale = pd_min(wanted / lx, PD_FIELD_PLOT_MAX_ASPECT * wanted / ly);
    double width = pdi_picture_memory_count_pixels(lx / u->h[right], scale * lx, 1.4 * wanted) + 230.0;
    double height = pdi_picture_memory_count_pixels(ly / u->h[up], scale * ly, 1.4 * wanted) + 140.0;
    double all = 6.0 * width * height + PDI_PICTURE_MEMORY_DEFLATE_BYTES;
    if (u->displacement_scale > 0.0) { /* drawn on paper of its own, which is gone as the image is packed */
        double pixels = scale * lx * scale * ly;
        width = scale * lx + 230.0;
        height = scale * ly + 140.0;
        all = pd_max(3.0 * width * height + 9.0 * pixels, 6.0 * width * height + PDI_PICTURE_MEMORY_DEFLATE_BYTES);
        all += 17.0 * cells;
    }
    for (int k = 0; k < PD_FIELD_COUNT; k++) {
        lines = lines || u->drawing.contours[k];
        flows = flows || u->drawing.streamlines[k] || u->drawing.vectors[k];
        across = pd_max(across, u->drawing.streamlines[k]);
    }
    if (flows) all = pd_max(all, 4.0 * width * height) + 16.0 * cells;
    /* points of streamlines, 12 of 80 bytes over the distance between lines */
    all = pd_max(all, 4.0 * width * height + 1000.0 * width * height * pow(across / wanted, 2.0));
    /* cover of a pixel, place on the bar of a cell */
    if (lines) all = pd_max(all, 4.0 * width * height + 8.0 * cells);
    if (u->drawing.percentile > 0.0 && u->drawing.percentile < 1.0) all += 8.0 * cells;
    return pd_max(largest, all) + 9.0 * cells;
}

#undef PDI_PICTURE_MEMORY_PLOT_BYTES
#undef PDI_PICTURE_MEMORY_DEFLATE_BYTES
