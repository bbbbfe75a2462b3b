/* points: see points.h */
#include "lattice/points.h"
#include <math.h>
#include <string.h>

/* Minimum volume of a cell over its extent to the power of its dimension. */
#define PDI_POINTS_MIN_CELL_VOLUME 1e-12
/* Tolerance for coordinates beyond the dimension of the program to be equal, over the extent of the mesh. */
#define PDI_POINTS_PLANE_TOLERANCE 1e-9

enum { PDI_POINTS_BOX_CORNERS = 1 << PD_DIM }; /* corners of a line, a quad, a hexahedron */

void pd_points_free(pd_ctx *ctx, pd_points *p)
{
    PD_DELETE(ctx, (int64_t)p->capacity * PD_DIM, p->position);
    PD_DELETE(ctx, p->capacity, p->volume);
    PD_DELETE(ctx, p->capacity, p->tag);
    PD_DELETE(ctx, (int64_t)p->capacity * PD_DIM, p->boundary_area);
    PD_DELETE(ctx, p->face_count * PD_DIM * PD_DIM, p->face_corner);
    memset(p, 0, sizeof *p);
}

/* Reallocate the arrays of points for this capacity, at least their number; contents and faces are kept. On failure
 * nothing changes. */
static pd_status pdi_points_resize(pd_ctx *ctx, pd_points *p, int32_t capacity)
{
    pd_points larger;
    memset(&larger, 0, sizeof larger);
    larger.capacity = capacity;
    larger.count = p->count;
    pd_status status = PD_NEW(ctx, "points", (int64_t)capacity * PD_DIM, larger.position);
    if (status == PD_OK) status = PD_NEW(ctx, "points", capacity, larger.volume);
    if (status == PD_OK) status = PD_NEW(ctx, "points", capacity, larger.tag);
    if (status == PD_OK) status = PD_NEW(ctx, "points", (int64_t)capacity * PD_DIM, larger.boundary_area);
    if (status != PD_OK) {
        pd_points_free(ctx, &larger);
        return status;
    }
    if (p->count) {
        memcpy(larger.position, p->position, (size_t)p->count * PD_DIM * sizeof *p->position);
        memcpy(larger.volume, p->volume, (size_t)p->count * sizeof *p->volume);
        memcpy(larger.tag, p->tag, (size_t)p->count * sizeof *p->tag);
        memcpy(larger.boundary_area, p->boundary_area, (size_t)p->count * PD_DIM * sizeof *p->boundary_area);
    }
    larger.face_count = p->face_count;
    larger.face_corner = p->face_corner;
    larger.coincident_faces = p->coincident_faces;
    larger.coincident_nodes = p->coincident_nodes;
    p->face_corner = NULL;
    pd_points_free(ctx, p);
    *p = larger;
    return PD_OK;
}

PDI_FN pd_status pdi_points_reserve_faces(pd_ctx *ctx, pd_points *p, int64_t faces)
{
    PD_TRY(PD_NEW(ctx, "points", faces * PD_DIM * PD_DIM, p->face_corner));
    p->face_count = faces;
    return PD_OK;
}

pd_status pd_points_add(pd_ctx *ctx, pd_points *p, const double *position, double volume, int32_t tag)
{
    if (p->count == p->capacity) {
        if (p->capacity > INT32_MAX / 2 - 64)
            return pd_fail(ctx, PD_ERR_SIZE, "points", "more than %d points", p->capacity);
        PD_TRY(pdi_points_resize(ctx, p, 2 * p->capacity + 64));
    }
    for (int d = 0; d < PD_DIM; d++) p->position[(int64_t)p->count * PD_DIM + d] = position[d];
    p->volume[p->count] = volume;
    p->tag[p->count++] = tag;
    return PD_OK;
}

pd_status pd_points_shrink(pd_ctx *ctx, pd_points *p) { return pdi_points_resize(ctx, p, p->count); }

/* ---- cells ---- */

int pd_points_count_corners(pd_points_cell_type form)
{
    static const int corners[8] = {0, 2, 3, 4, 4, 8, 6, 5};
    return corners[form];
}

/* Corner of the cell at corner k of the line, quad or hexahedron that it is a degenerate case of. Bit d of k: upper end
 * along axis d of the reference cube. */
static int pdi_points_get_box_corner(pd_points_cell_type form, int k)
{
    static const int8_t of[8][8] = {{0, 0, 0, 0, 0, 0, 0, 0}, {0, 1, 0, 0, 0, 0, 0, 0}, {0, 1, 2, 2, 0, 0, 0, 0},
                                    {0, 1, 3, 2, 0, 0, 0, 0}, {0, 1, 2, 2, 3, 3, 3, 3}, {0, 1, 3, 2, 4, 5, 7, 6},
                                    {0, 1, 2, 2, 3, 4, 5, 5}, {0, 1, 3, 2, 4, 4, 4, 4}};
    return of[form][k];
}

/* Determinant of a PD_DIM x PD_DIM matrix. */
static double pdi_points_determinant(const double *j)
{
    if (PD_DIM == 1) return j[0];
    if (PD_DIM == 2) return j[0] * j[3] - j[1] * j[2];
    return j[0] * (j[4] * j[8] - j[5] * j[7]) - j[1] * (j[3] * j[8] - j[5] * j[6]) +
           j[2] * (j[3] * j[7] - j[4] * j[6]);
}

/* Signed volume of Gauss point g (weight times Jacobian determinant) of a cell with the corners x
 * [PDI_POINTS_BOX_CORNERS][PD_DIM], and its position[PD_DIM], in the unit of x. */
static double pdi_points_compute_gauss_point(const double *x, int g, double *position)
{
    const double at = 0.5 / sqrt(3.0);
    double jacobian[9] = {0.0}; /* of the unit cube */
    for (int d = 0; d < PD_DIM; d++) position[d] = 0.0;
    for (int k = 0; k < PDI_POINTS_BOX_CORNERS; k++) {
        double axis_shape[PD_DIM], shape = 1.0;
        for (int d = 0; d < PD_DIM; d++) {
            axis_shape[d] = ((g ^ k) >> d) & 1 ? 0.5 - at : 0.5 + at;
            shape *= axis_shape[d];
        }
        for (int d = 0; d < PD_DIM; d++) {
            double derivative = k >> d & 1 ? 1.0 : -1.0;
            for (int e = 0; e < PD_DIM; e++) derivative *= e == d ? 1.0 : axis_shape[e];
            for (int e = 0; e < PD_DIM; e++) jacobian[e * PD_DIM + d] += derivative * x[k * PD_DIM + e];
        }
        for (int d = 0; d < PD_DIM; d++) position[d] += shape * x[k * PD_DIM + d];
    }
    return pdi_points_determinant(jacobian) / (double)PDI_POINTS_BOX_CORNERS;
}

/* Signed volume of a cell by Gauss quadrature, and its centroid centre [PD_DIM], in the unit of the corners. 0: the
 * Jacobian is not of one sign at all Gauss points (folded), or |volume| is at most PDI_POINTS_MIN_CELL_VOLUME times the
 * largest extent to the power PD_DIM; `centre` has no meaning then. */
static double pdi_points_integrate_cell(pd_points_cell_type form, const double *const *corner, double *centre)
{
    double x[PDI_POINTS_BOX_CORNERS * PD_DIM], volume = 0.0, size = 0.0, first = 0.0, whole = 1.0;
    for (int d = 0; d < PD_DIM; d++) centre[d] = 0.0;
    for (int k = 0; k < PDI_POINTS_BOX_CORNERS; k++)
        for (int d = 0; d < PD_DIM; d++) { /* relative to the first corner, against cancellation */
            x[k * PD_DIM + d] = corner[pdi_points_get_box_corner(form, k)][d] - corner[0][d];
            size = pd_max(size, fabs(x[k * PD_DIM + d]));
        }
    for (int d = 0; d < PD_DIM; d++) whole *= size;
    for (int g = 0; g < PDI_POINTS_BOX_CORNERS; g++) {
        double position[PD_DIM], part_volume = pdi_points_compute_gauss_point(x, g, position);
        if (g == 0) first = part_volume;
        if (!(part_volume / first > 0.0)) return 0.0;
        volume += part_volume;
        for (int d = 0; d < PD_DIM; d++) centre[d] += part_volume * position[d];
    }
    if (!(fabs(volume) > PDI_POINTS_MIN_CELL_VOLUME * whole)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) centre[d] = corner[0][d] + centre[d] / volume;
    return volume;
}

pd_status pd_points_add_cell(pd_ctx *ctx, pd_points_converter *cells, pd_points_cell_type form,
                                     const double *const *corner, int mirrored, int32_t tag, const char **fault)
{
    double centre[PD_DIM], scale = 1.0;
    *fault = NULL;
    if (!cells->has_plane) memcpy(cells->plane, corner[0], sizeof cells->plane);
    cells->has_plane = 1;
    for (int k = 0; k < pd_points_count_corners(form); k++)
        for (int d = PD_DIM; d < 3; d++)
            if (fabs(corner[k][d] - cells->plane[d]) > PDI_POINTS_PLANE_TOLERANCE * cells->extent)
                *fault = PD_DIM == 1 ? "a cell off the line y, z = constant" : "a cell off the plane z = constant";
    double volume = pdi_points_integrate_cell(form, corner, centre), sign = volume > 0.0 ? 1.0 : -1.0;
    if (*fault) return PD_OK;
    if (!(fabs(volume) > 0.0)) *fault = "a cell without volume, or folded";
    else if (!mirrored && sign * cells->orientation < 0.0)
        *fault = PD_DIM == 3 ? "a cell turned inside out, other than those before it"
                             : "a cell that turns the other way than those before it";
    if (*fault) return PD_OK;
    if (!mirrored) cells->orientation = sign;
    for (int d = 0; d < PD_DIM; d++) {
        centre[d] *= cells->scale;
        scale *= cells->scale;
    }
    volume = fabs(volume) * scale;
    if (!(volume > 0.0) || !(volume < 1e100)) *fault = "a cell whose volume is out of range";
    return *fault ? PD_OK : pd_points_add(ctx, cells->points, centre, volume, tag);
}

#undef PDI_POINTS_MIN_CELL_VOLUME
#undef PDI_POINTS_PLANE_TOLERANCE
