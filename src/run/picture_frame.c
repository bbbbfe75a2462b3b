/* picture_frame: see picture_frame.h */
#include "run/picture_frame.h"
#include "solid/body_bonds.h"
#include "setup/fields.h"
#include "io/canvas.h"
#include "physics/sample.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PDI_PICTURE_FRAME_FLOAT_CHUNK 1024 /* floats that are converted at a time */

PDI_FN int pdi_picture_frame_is_deformed(const pd_output_pictures *im, pd_field field)
{
    return im->displacement && field < PD_FIELD_COUNT && pd_fields_is_in_metal(im->model->setup, field);
}

PDI_FN int pdi_picture_frame_is_drawn(const pd_output_pictures *im, pd_field field)
{
    if (field == PD_PICTURES_SURFACE) return pdi_surface_view_is_requested(im->model->setup);
    return (int)(im->model->setup->images >> field & 1u);
}

PDI_FN pd_field pdi_picture_frame_get_colour_field(const pd_output_pictures *im, pd_field field)
{
    return field == PD_PICTURES_SURFACE ? pdi_surface_view_get_colour_field(im->model->setup) : field;
}

PDI_FN const char *pdi_picture_frame_get_field_name(const pd_output_pictures *im, pd_field field)
{
    return field == PD_PICTURES_SURFACE ? "surface" : pd_fields_get_name(im->model->setup, field);
}

PDI_FN int pdi_picture_frame_has_flow_overlay(const pd_output_pictures *im, pd_field field)
{
    const pd_setup_image_options *drawing = &im->model->setup->drawing;
    return field < PD_FIELD_COUNT && (drawing->streamlines[field] || drawing->vectors[field]);
}

PDI_FN int pdi_picture_frame_is_log_scale(const pd_output_pictures *im, pd_field field)
{
    pd_field of = pdi_picture_frame_get_colour_field(im, field);
    return of < PD_FIELD_COUNT && (int)(im->model->setup->drawing.log >> of & 1u);
}

/* How the cell of a node is painted. A field of all cells: by its value. Else walls and inactive nodes as wall; solid
 * by the value of a field of the metal, else as solid; fluid by the value, but blank where the value is undefined (just
 * converted) or the field is of the metal alone. */
static pd_paint pdi_picture_frame_get_cell_kind(const pd_model *m, pd_field field, int32_t node)
{
    uint8_t kind = m->grid.kind[node];
    int solid = pd_fields_is_in_metal(m->setup, field);
    if (pd_fields_get_place(m->setup, field) == PD_FIELD_IN_ALL) return PD_PAINT_FIELD;
    if (kind == PD_WALL || kind == PD_INACTIVE) return PD_PAINT_WALL;
    if (kind == PD_SOLID) return solid ? PD_PAINT_FIELD : PD_PAINT_SOLID;
    if (pd_model_is_undefined(m, field, node)) return PD_PAINT_OUTSIDE;
    return pd_fields_get_place(m->setup, field) == PD_FIELD_IN_METAL ? PD_PAINT_OUTSIDE : PD_PAINT_FIELD;
}

/* Node that a cell of the drawn plane shows. In 3D the plane is the layer of cells that holds slice_at, within the box;
 * with mirrored rows those below the axis show the node above it. */
static int32_t pdi_picture_frame_get_node(const pd_output_pictures *im, int64_t cell)
{
    const pd_model *m = im->model;
    int row = (int)(cell / im->nx), i[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        double slice = floor((m->setup->slice_at - m->grid.lo[d]) / m->grid.h[d] + PD_SHAPE_TOLERANCE);
        i[d] = (int)pd_max(0.0, pd_min(slice, m->grid.n[d] - 1.0));
    }
    i[im->up] = row < im->mirrored_rows ? im->mirrored_rows - 1 - row : row - im->mirrored_rows;
    i[im->right] = (int)(cell % im->nx); /* 1D: one row */
    return pd_grid_node(&m->grid, i);
}

/* Round to float, as the file of frames stores it, so that a frame drawn again is the same. Larger values become
 * +-FLT_MAX; NaN stays. */
static double pdi_picture_frame_round_to_float(double value)
{
    if (value > (double)FLT_MAX) return (double)FLT_MAX;
    if (value < -(double)FLT_MAX) return -(double)FLT_MAX;
    return (double)(float)value;
}

/* 1: an unbroken bond joins the metal of two cells; 0: it is broken, or there is none. Both cells must be points of the
 * body. */
static int pdi_picture_frame_has_bond(const pd_output_pictures *im, int64_t cell, int64_t other)
{
    const pd_solid_coupling *s = &im->model->solid;
    int32_t i = s->point[pdi_picture_frame_get_node(im, cell)], j = s->point[pdi_picture_frame_get_node(im, other)];
    for (pd_bond_iterator f = pd_body_bonds_begin(&s->body, i); pd_body_bonds_next(&f);)
        if (f.neighbour == j) return !pd_body_bond_is_broken(&f);
    return 0;
}

/* Offsets (column, row) of the four neighbours to the right and above. */
static const int pdi_picture_frame_neighbour_offset[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};

/* Set bonded[cells]: bit k: the metal of the cell has an unbroken bond to that of neighbour k (right, above, both
 * diagonals above), so that cracks open in deformed pictures. Cells without displacement have none. In an intact body
 * all neighbours count. */
static void pdi_picture_frame_mark_bonded_neighbours(pd_output_pictures *im)
{
    int whole = pd_body_is_intact(&im->model->solid.body);
    for (int64_t k = 0; k < im->cells; k++) {
        int x = (int)(k % im->nx), y = (int)(k / im->nx);
        im->bonded[k] = 0;
        for (int b = 0; b < 4; b++) {
            int column = x + pdi_picture_frame_neighbour_offset[b][0],
                row = y + pdi_picture_frame_neighbour_offset[b][1];
            int64_t other = (int64_t)row * im->nx + column;
            if (column < 0 || column >= im->nx || row >= im->ny || isnan(im->displacement[k]) ||
                isnan(im->displacement[other]))
                continue;
            if (whole || pdi_picture_frame_has_bond(im, k, other)) im->bonded[k] |= (uint8_t)(1 << b);
        }
    }
}

PDI_FN void pdi_picture_frame_compute_displacements(pd_output_pictures *im)
{
    const pd_model *m = im->model;
    for (int64_t k = 0; k < im->cells; k++) {
        int32_t node = pdi_picture_frame_get_node(im, k), point = m->solid.point[node];
        const double *u = pd_solid_coupling_displacements(&m->solid) + (int64_t)(point < 0 ? 0 : point) * PD_DIM;
        int metal = point >= 0 && m->grid.kind[node] == PD_SOLID;
        im->displacement[k] =
            metal ? pdi_picture_frame_round_to_float(m->setup->displacement_scale * u[im->right]) : (double)NAN;
        im->displacement[im->cells + k] =
            metal ? pdi_picture_frame_round_to_float(m->setup->displacement_scale * u[im->up]) : (double)NAN;
    }
    pdi_picture_frame_mark_bonded_neighbours(im);
}

PDI_FN int pdi_picture_frame_are_bonded(const void *user, int cell, int other)
{
    const pd_output_pictures *im = (const pd_output_pictures *)user;
    int low = cell < other ? cell : other, high = cell < other ? other : cell;
    int x = high % im->nx - low % im->nx, y = high / im->nx - low / im->nx;
    for (int b = 0; b < 4; b++)
        if (pdi_picture_frame_neighbour_offset[b][0] == x && pdi_picture_frame_neighbour_offset[b][1] == y)
            return im->bonded[low] >> b & 1;
    return 0;
}

PDI_FN void pdi_picture_frame_compute_velocities(pd_output_pictures *im)
{
    const pd_model *m = im->model;
    const double *right = pd_model_velocity(m) + (int64_t)im->right * m->grid.total;
    const double *up = pd_model_velocity(m) + (int64_t)im->up * m->grid.total;
    for (int64_t k = 0; k < im->cells; k++) {
        int32_t node = pdi_picture_frame_get_node(im, k);
        int fluid = m->grid.kind[node] == PD_FLUID, mirrored = k / im->nx < im->mirrored_rows;
        im->velocity[k] = fluid ? pdi_picture_frame_round_to_float(right[node]) : (double)NAN;
        im->velocity[im->cells + k] =
            fluid ? pdi_picture_frame_round_to_float(mirrored ? -up[node] : up[node]) : (double)NAN;
    }
}

PDI_FN void pdi_picture_frame_compute_cells(pd_output_pictures *im, pd_field field)
{
    int32_t node = 0, step = im->model->grid.stride[im->right];
    for (int64_t k = 0; k < im->cells; k++, node += step) {
        if (k % im->nx == 0) node = pdi_picture_frame_get_node(im, k);
        im->cell[k] = pdi_picture_frame_round_to_float(pd_sample_get_node(im->model, field, node));
        im->paint[k] = (uint8_t)pdi_picture_frame_get_cell_kind(im->model, field, node);
    }
}

/* Comparison of two doubles for qsort. */
static int pdi_picture_frame_compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Value at fractional rank `at`, 0 to count - 1, of sorted[count], linear between two: a percentile. */
static double pdi_picture_frame_interpolate_sorted(const double *sorted, int64_t count, double at)
{
    int64_t below = (int64_t)pd_min(floor(at), (double)count - 1.0), above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (at - (double)below) * (sorted[above] - sorted[below]);
}

/* Number of values of a frame: cells, or pixels of the rendered surface. */
static int64_t pdi_picture_frame_count_values(const pd_output_pictures *im, pd_field field)
{
    return field == PD_PICTURES_SURFACE ? (int64_t)im->surface_view.width * im->surface_view.height : im->cells;
}

/* Smallest and largest value of this frame that is painted by the field, without NaN and (log) values <= 0. With
 * im->sorted, which is work, the bounds of the central fraction drawing.percentile of them. *lo > *hi: there are
 * none. */
static void pdi_picture_frame_find_range(pd_output_pictures *im, pd_field field, double *lo, double *hi)
{
    int64_t count = 0, values = pdi_picture_frame_count_values(im, field);
    int surface = field == PD_PICTURES_SURFACE;
    *lo = HUGE_VAL;
    *hi = -HUGE_VAL;
    for (int64_t k = 0; k < values; k++) {
        double value = surface ? (double)im->surface_view.value[k] : im->cell[k];
        if (!surface && im->paint[k] != PD_PAINT_FIELD) continue;
        if (isnan(value) || (pdi_picture_frame_is_log_scale(im, field) && !(value > 0.0))) continue;
        if (value < *lo) *lo = value;
        if (value > *hi) *hi = value;
        if (im->sorted) im->sorted[count] = value;
        count++;
    }
    if (!im->sorted || count == 0) return;
    double cut = 0.5 * (1.0 - im->model->setup->drawing.percentile) * (double)(count - 1);
    qsort(im->sorted, (size_t)count, sizeof *im->sorted, pdi_picture_frame_compare_doubles);
    *lo = pdi_picture_frame_interpolate_sorted(im->sorted, count, cut);
    *hi = pdi_picture_frame_interpolate_sorted(im->sorted, count, (double)(count - 1) - cut);
}

PDI_FN int pdi_picture_frame_is_range_fixed(const pd_setup *setup, pd_field field)
{
    if (field == PD_FIELD_COUNT) return 1; /* nothing gives it colours */
    const double *range = setup->drawing.range[field];
    int shares = pd_fields_get_scale(field) == PD_FIELD_SCALE_FRACTION;
    return range[0] < range[1] || (shares && !(setup->drawing.log >> field & 1u)) || field == PD_FIELD_KIND ||
           field == PD_FIELD_PHASE;
}

PDI_FN pd_status pdi_picture_frame_update_range(pd_ctx *ctx, pd_output_pictures *im, pd_field field,
                                                const pdi_deformed_plot *warp)
{
    pd_picture_range *view = &im->view[field];
    double lo, hi;
    if (pdi_picture_frame_is_deformed(im, field))
        PD_TRY(pdi_deformed_plot_extend_range(ctx, warp, view->extent_min, view->extent_max));
    for (int64_t k = 0; pdi_picture_frame_has_flow_overlay(im, field) && k < im->cells; k++)
        view->max_speed = pd_max(view->max_speed, pdi_canvas_hypot(im->velocity[k], im->velocity[im->cells + k]));
    if (pdi_picture_frame_is_range_fixed(im->model->setup, pdi_picture_frame_get_colour_field(im, field))) return PD_OK;
    pdi_picture_frame_find_range(im, field, &lo, &hi);
    view->min = pd_min(view->min, lo);
    view->max = pd_max(view->max, hi);
    return PD_OK;
}

PDI_FN int64_t pdi_picture_frame_count_max_values(const pd_output_pictures *im)
{
    int64_t pixels = pdi_picture_frame_count_values(im, PD_PICTURES_SURFACE);
    return pixels > im->cells ? pixels : im->cells;
}

/* Write numbers to the file as floats, or read them (reading: 1). PD_ERR_FILE: it ends early. */
static pd_status pdi_picture_frame_store_floats(pd_ctx *ctx, pd_file *file, int reading, double *values, int64_t count)
{
    float piece[PDI_PICTURE_FRAME_FLOAT_CHUNK];
    size_t got;
    for (int64_t at = 0; at < count; at += PDI_PICTURE_FRAME_FLOAT_CHUNK) {
        size_t n = (size_t)(count - at < PDI_PICTURE_FRAME_FLOAT_CHUNK ? count - at : PDI_PICTURE_FRAME_FLOAT_CHUNK);
        if (reading) {
            PD_TRY(pdi_file_read_bytes(ctx, file, piece, n * sizeof *piece, &got));
            if (got != n * sizeof *piece) return pd_fail(ctx, PD_ERR_FILE, "images", "'%s' ends early", file->path);
            for (size_t k = 0; k < n; k++) values[(size_t)at + k] = (double)piece[k];
        } else {
            for (size_t k = 0; k < n; k++) piece[k] = (float)values[(size_t)at + k];
            PD_TRY(pdi_file_write(ctx, file, piece, n * sizeof *piece));
        }
    }
    return PD_OK;
}

/* Write bytes to the file, or read them. PD_ERR_FILE: it ends early. */
static pd_status pdi_picture_frame_store_bytes(pd_ctx *ctx, pd_file *file, int reading, void *data, size_t size)
{
    size_t got;
    if (!reading) return pdi_file_write(ctx, file, data, size);
    PD_TRY(pdi_file_read_bytes(ctx, file, data, size, &got));
    return got == size ? PD_OK : pd_fail(ctx, PD_ERR_FILE, "images", "'%s' ends early", file->path);
}

/* Write or read the pixels of the rendered surface. */
static pd_status pdi_picture_frame_store_surface(pd_ctx *ctx, pd_output_pictures *im, pd_file *file, int reading)
{
    size_t pixels = (size_t)im->surface_view.width * (size_t)im->surface_view.height;
    PD_TRY(pdi_picture_frame_store_bytes(ctx, file, reading, im->surface_view.value,
                                         pixels * sizeof *im->surface_view.value));
    PD_TRY(pdi_picture_frame_store_bytes(ctx, file, reading, im->surface_view.brightness, pixels));
    PD_TRY(pdi_picture_frame_store_bytes(ctx, file, reading, im->surface_view.coverage, pixels));
    return pdi_picture_frame_store_bytes(ctx, file, reading, im->surface_view.edge, pixels);
}

PDI_FN pd_status pdi_picture_frame_store(pd_ctx *ctx, pd_output_pictures *im, pd_field field, pd_file *file,
                                         int reading)
{
    char end = '\n';
    if (field == PD_PICTURES_SURFACE) PD_TRY(pdi_picture_frame_store_surface(ctx, im, file, reading));
    else {
        PD_TRY(pdi_picture_frame_store_floats(ctx, file, reading, im->cell, im->cells));
        PD_TRY(pdi_picture_frame_store_bytes(ctx, file, reading, im->paint, (size_t)im->cells));
    }
    if (pdi_picture_frame_is_deformed(im, field)) {
        PD_TRY(pdi_picture_frame_store_floats(ctx, file, reading, im->displacement, 2 * im->cells));
        PD_TRY(pdi_picture_frame_store_bytes(ctx, file, reading, im->bonded, (size_t)im->cells));
    }
    if (pdi_picture_frame_has_flow_overlay(im, field))
        PD_TRY(pdi_picture_frame_store_floats(ctx, file, reading, im->velocity, 2 * im->cells));
    return pdi_picture_frame_store_bytes(ctx, file, reading, &end, 1);
}

PDI_FN int64_t pdi_picture_frame_count_bytes(const pd_output_pictures *im, pd_field field)
{
    if (field == PD_PICTURES_SURFACE) return 7 * (int64_t)im->surface_view.width * im->surface_view.height + 1;
    int overlay = pdi_picture_frame_has_flow_overlay(im, field) ? 8 : 0;
    return im->cells * ((pdi_picture_frame_is_deformed(im, field) ? 14 : 5) + overlay) + 1;
}

#undef PDI_PICTURE_FRAME_FLOAT_CHUNK
