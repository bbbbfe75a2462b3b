/* stencil: see stencil.h */
#include "lattice/stencil.h"
#include "core/array_registry.h"
#include "core/vec.h"
#include "lattice/area_weights.h"
#include <math.h>
#include <string.h>

#define PDI_STENCIL_MAX_M 12 /* largest horizon ratio */

/* |n| of an offset [cells]. */
static double pdi_stencil_lattice_length(const int *n)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += (double)n[d] * (double)n[d];
    return sqrt(sum);
}

/* Moves n to the next offset of the cube [-reach, reach]^d in lexicographic order, axis 0 fastest. Returns 1; 0: n was
 * the last one, and is the first one again. */
static int pdi_stencil_next_offset(int *n, int reach)
{
    for (int d = 0; d < PD_DIM; d++) {
        if (++n[d] <= reach) return 1;
        n[d] = -reach;
    }
    return 0;
}

/* Partial volume beta of the cell at offset n (eq. 1.1) [-]: m + 1/2 - |n|, at most 1; PD_FAMILY_FULL_CELLS: 1 for |n|
 * <= m. 0: not in the family, as is n = 0. The tolerance of 1e-12 keeps the rounding of sqrt from deciding on
 * membership. */
static double pdi_stencil_partial_volume(const int *n, double m, pd_family family)
{
    double length = pdi_stencil_lattice_length(n), limit = family == PD_FAMILY_FULL_CELLS ? m + 1e-12 : m + 0.5 - 1e-12;
    if (!(length > 0.0) || !(length < limit)) return 0.0;
    return family == PD_FAMILY_FULL_CELLS ? 1.0 : pd_min(m + 0.5 - length, 1.0);
}

/* Describes the arrays by bonds and grid lines to the array registry. */
static void pdi_stencil_list_arrays(pdi_array_visitor *owner, void *object)
{
    pd_stencil *stencil = (pd_stencil *)object;
    int64_t count = stencil->count, width = stencil->reach + 1;
    PDI_ARRAY(owner, stencil, offset, count * PD_DIM, "1");
    PDI_ARRAY(owner, stencil, xi, count * PD_DIM, "m");
    PDI_ARRAY(owner, stencil, partial_volume, count, "1");
    PDI_ARRAY(owner, stencil, laplacian_weight, count, "1/m2");
    PDI_ARRAY(owner, stencil, gradient_weight, count * PD_DIM, "1/m");
    PDI_ARRAY(owner, stencil, base_weight, count, "1");
    PDI_ARRAY(owner, stencil, area_weight, count, "1/m");
    PDI_ARRAY(owner, stencil, line_first, count + 1, "1");
    PDI_ARRAY(owner, stencil, line, count * PD_DIM, "1");
    PDI_ARRAY(owner, stencil, line_reach, count, "1");
    PDI_ARRAY(owner, stencil, line_lap, count * width, "1/m2");
    PDI_ARRAY(owner, stencil, layer_lap, width, "1/m2");
}

/* Describes the arrays of crossed cells to the array registry, once their number is known. */
static void pdi_stencil_list_path_arrays(pdi_array_visitor *owner, void *object)
{
    pd_stencil *stencil = (pd_stencil *)object;
    PDI_ARRAY(owner, stencil, group_first, stencil->count + 1, "1");
    PDI_ARRAY(owner, stencil, group_cell, stencil->groups + 1, "1");
    PDI_ARRAY(owner, stencil, group_entry, stencil->groups, "1");
    PDI_ARRAY(owner, stencil, group_axes, stencil->groups, "1");
    PDI_ARRAY(owner, stencil, cell, stencil->cells * PD_DIM, "1");
}

/* Sets count and reach of the family, allocates the arrays by bonds and grid lines, and fills offset, xi,
 * partial_volume and base_weight w(n) (eq. 1.2). m, h and volume are set. */
static pd_status pdi_stencil_build_family(pd_ctx *ctx, pd_family family, pd_stencil *s)
{
    int limit = (int)(s->m + 0.5), n[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) n[d] = -limit;
    do {
        if (!(pdi_stencil_partial_volume(n, s->m, family) > 0.0)) continue;
        for (int d = 0; d < PD_DIM; d++)
            if (n[d] > s->reach) s->reach = n[d];
        s->count++;
    } while (pdi_stencil_next_offset(n, limit));
    PD_TRY(pdi_array_registry_build(ctx, pdi_stencil_list_arrays, s));
    int k = 0;
    for (int d = 0; d < PD_DIM; d++) n[d] = -limit;
    do {
        double beta = pdi_stencil_partial_volume(n, s->m, family);
        if (!(beta > 0.0)) continue;
        for (int d = 0; d < PD_DIM; d++) {
            s->offset[k * PD_DIM + d] = n[d];
            s->xi[k * PD_DIM + d] = (double)n[d] * s->h[d];
        }
        double length = pdi_stencil_lattice_length(n);
        s->partial_volume[k] = beta;
        /* w(n) = beta V |n|^d / |xi|^(d+2): on equal spacings beta V / |xi|^2 up to a constant (eq. 1.2) */
        double xi2 = pdi_vec_dot(s->xi + k * PD_DIM, s->xi + k * PD_DIM);
        s->base_weight[k] = s->partial_volume[k] * s->volume * pow(length / sqrt(xi2), PD_DIM) / xi2;
        k++;
    } while (pdi_stencil_next_offset(n, limit));
    return PD_OK;
}

/* Sets laplacian_weight and gradient_weight to the coefficients of the continuum as published: lap f = k_L sum
 * df/|xi|^2 V beta, with k_L = 1, 4/pi, 9/(2 pi) over delta_theta^d in 1D, 2D, 3D; grad f = (d/V_H) sum df e/|xi| V
 * beta. Elliptical horizons: delta_theta = m |xi|/|n| in place of delta (Jafarzadeh et al. 2022, eq. 16, corrected). */
static void pdi_stencil_set_published_weights(pd_stencil *s)
{
    double horizon_volume = PD_DIM == 1 ? 2.0 : PD_DIM == 2 ? PD_PI : 4.0 * PD_PI / 3.0;
    double lap_scale = PD_DIM == 1 ? 1.0 : PD_DIM == 2 ? 4.0 / PD_PI : 9.0 / (2.0 * PD_PI);
    for (int d = 0; d < PD_DIM; d++) horizon_volume *= s->m * s->h[d];
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double length = pdi_vec_norm(xi);
        double delta = s->m * length / pdi_stencil_lattice_length(s->offset + k * PD_DIM);
        s->laplacian_weight[k] = lap_scale / pow(delta, PD_DIM) * s->partial_volume[k] * s->volume / (length * length);
        for (int d = 0; d < PD_DIM; d++)
            s->gradient_weight[k * PD_DIM + d] =
                (double)PD_DIM / horizon_volume * xi[d] / (length * length) * s->partial_volume[k] * s->volume;
    }
}

/* Adds the weights w(n) sum_b s_b e_b^2 with s = scale [PD_DIM] to laplacian_weight. residual [PD_DIM]: what is now
 * missing of sum_n a(n) xi_a^2 = 2, over h_a^2. */
static void pdi_stencil_add_weights(pd_stencil *s, const double *scale, double *residual)
{
    for (int a = 0; a < PD_DIM; a++) residual[a] = 2.0 / (s->h[a] * s->h[a]);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double xi2 = pdi_vec_dot(xi, xi), factor = 0.0;
        for (int b = 0; b < PD_DIM; b++) factor += scale[b] * xi[b] * xi[b] / xi2;
        s->laplacian_weight[k] += s->base_weight[k] * factor;
        for (int a = 0; a < PD_DIM; a++) residual[a] -= s->laplacian_weight[k] * (xi[a] / s->h[a]) * (xi[a] / s->h[a]);
    }
}

/* Sets laplacian_weight, zero before, and gradient_weight by discrete moments: a(n) = w(n) sum_b s_b e_b^2 with sum_n
 * a(n) xi_a^2 = 2 for every axis (eq. 1.3), and g(n) = w(n) xi / sum w xi_a^2 (eq. 1.4). PD_ERR_GEOMETRY: the moments
 * are singular, or a weight a(n) is not positive (spacings too different). */
static pd_status pdi_stencil_calibrate_weights(pd_ctx *ctx, pd_stencil *s)
{
    double matrix[PD_DIM * PD_DIM], residual[PD_DIM], scale[PD_DIM], moment[PD_DIM];
    memset(matrix, 0, sizeof matrix);
    memset(moment, 0, sizeof moment);
    memset(scale, 0, sizeof scale);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double xi2 = pdi_vec_dot(xi, xi);
        for (int a = 0; a < PD_DIM; a++) {
            moment[a] += s->base_weight[k] * xi[a] * xi[a];
            /* row a divided by h_a^2 keeps the system well scaled for any spacing */
            for (int b = 0; b < PD_DIM; b++)
                matrix[a * PD_DIM + b] +=
                    s->base_weight[k] * (xi[a] / s->h[a]) * (xi[a] / s->h[a]) * xi[b] * xi[b] / xi2;
        }
    }
    pdi_stencil_add_weights(s, scale, residual);
    /* the second pass removes the rounding of the first: spacings of 1 : 10 : 100 cost three digits */
    for (int pass = 0; pass < 2; pass++) {
        if (!(pdi_vec_solve(matrix, residual, scale) > 0.0))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "stencil", "the moments of the family are singular (m = %g)", s->m);
        pdi_stencil_add_weights(s, scale, residual);
    }
    for (int k = 0; k < s->count; k++) {
        if (s->partial_volume[k] > 0.0 && !(s->laplacian_weight[k] > 0.0))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "stencil",
                           "a calibrated Laplacian weight is %g, expected a positive one: the spacings differ too "
                           "much for m = %g",
                           s->laplacian_weight[k], s->m);
        for (int a = 0; a < PD_DIM; a++)
            s->gradient_weight[k * PD_DIM + a] = s->base_weight[k] * s->xi[k * PD_DIM + a] / moment[a];
    }
    return PD_OK;
}

/* A face between two cells that a bond crosses: face number k normal to `axis` is crossed at the fraction
 * numerator/denominator = (2 k + 1) / (2 |n_axis|) of the bond. */
typedef struct pdi_stencil_face_crossing {
    int axis, numerator, denominator;
} pdi_stencil_face_crossing;

/* 1: the bond crosses face a before face b (exact, in integers). */
static int pdi_stencil_is_earlier(const pdi_stencil_face_crossing *a, const pdi_stencil_face_crossing *b)
{
    return a->numerator * b->denominator < b->numerator * a->denominator;
}

/* Appends one group of alternative cells: `from` plus one step along the axes of each subset of the bit set `axes` for
 * which bit `subset` of `members` is set. Groups and cells grow; while their arrays are NULL they are only counted.
 * entry: fraction of the bond. */
static void pdi_stencil_add_cell_group(pd_stencil *s, const int *from, const int *sign, int axes, int members,
                                       double entry)
{
    if (s->group_cell) {
        s->group_cell[s->groups] = s->cells;
        s->group_entry[s->groups] = entry;
        s->group_axes[s->groups] = (uint8_t)axes;
    }
    for (int subset = 1; subset <= axes; subset++) {
        if (!((members >> subset) & 1)) continue;
        if (s->cell)
            for (int d = 0; d < PD_DIM; d++)
                s->cell[s->cells * PD_DIM + d] = from[d] + ((subset >> d) & 1) * sign[d];
        s->cells++;
    }
    s->groups++;
}

/* Appends the groups of a bond that passes through a cell edge (two axes) or a corner (three). The passage is blocked
 * when no path from face to face leads around it: both cells beside the edge are closed, or a cut of the ring of six
 * cells around the corner (the cells after one face, those after two, or all but one cell and the opposite one). */
static void pdi_stencil_add_edge_groups(pd_stencil *s, const int *from, const int *sign, int axes, double entry)
{
    int single = 0, twofold = 0;
    for (int subset = 1; subset < axes; subset++) {
        if ((subset & axes) != subset) continue;
        if (subset & (subset - 1)) twofold |= 1 << subset;
        else single |= 1 << subset;
    }
    pdi_stencil_add_cell_group(s, from, sign, axes, single, entry);
    if (!twofold) return;
    pdi_stencil_add_cell_group(s, from, sign, axes, twofold, entry);
    for (int axis = 1; axis < axes; axis *= 2)
        pdi_stencil_add_cell_group(s, from, sign, axes, (single | twofold) & ~(1 << axis) & ~(1 << (axes ^ axis)),
                                   entry);
}

/* Appends the groups of cells that the straight bond n crosses, cell by cell. Where it passes through an edge or a
 * corner the cells beside the passage are alternatives, so that a solid without a path from face to face through it
 * blocks all bonds, however thin it is. */
static void pdi_stencil_add_bond_path(pd_stencil *s, const int *n)
{
    pdi_stencil_face_crossing list[PD_DIM * (PDI_STENCIL_MAX_M + 1)];
    int sign[PD_DIM], at[PD_DIM], count = 0;
    for (int d = 0; d < PD_DIM; d++) {
        int steps = n[d] < 0 ? -n[d] : n[d];
        sign[d] = n[d] < 0 ? -1 : 1;
        at[d] = 0;
        for (int k = 0; k < steps; k++) {
            pdi_stencil_face_crossing c;
            c.axis = d;
            c.numerator = 2 * k + 1;
            c.denominator = 2 * steps;
            int place = count++;
            for (; place > 0 && pdi_stencil_is_earlier(&c, &list[place - 1]); place--) list[place] = list[place - 1];
            list[place] = c;
        }
    }
    for (int k = 0; k < count;) {
        int axes = 0, first = k;
        do axes |= 1 << list[k++].axis;
        while (k < count && !pdi_stencil_is_earlier(&list[first], &list[k]));
        double entry = (double)list[first].numerator / (double)list[first].denominator;
        if (axes & (axes - 1)) pdi_stencil_add_edge_groups(s, at, sign, axes, entry);
        pdi_stencil_add_cell_group(s, at, sign, axes, 1 << axes, entry);
        for (int d = 0; d < PD_DIM; d++) at[d] += ((axes >> d) & 1) * sign[d];
    }
}

/* Counts the crossed cells of all bonds, allocates their arrays and fills them. */
static pd_status pdi_stencil_build_bond_paths(pd_ctx *ctx, pd_stencil *s)
{
    for (int k = 0; k < s->count; k++) pdi_stencil_add_bond_path(s, s->offset + k * PD_DIM);
    PD_TRY(pdi_array_registry_build(ctx, pdi_stencil_list_path_arrays, s));
    s->groups = s->cells = 0;
    for (int k = 0; k < s->count; k++) {
        s->group_first[k] = s->groups;
        pdi_stencil_add_bond_path(s, s->offset + k * PD_DIM);
    }
    s->group_first[s->count] = s->groups;
    s->group_cell[s->groups] = s->cells;
    return PD_OK;
}

/* [-] Weights that differ by less than this fraction are equal to rounding. */
#define PDI_STENCIL_WEIGHT_TOLERANCE 1e-13

/* Weight a(n) [1/m2] of the bond that ends on the grid line through `line` at n_0 = n0; 0: there is no such bond. */
static double pdi_stencil_get_line_weight(const pd_stencil *s, const int *line, int n0)
{
    for (int k = 0; k < s->count; k++) {
        int same = s->offset[k * PD_DIM] == n0;
        for (int d = 1; d < PD_DIM; d++) same = same && s->offset[k * PD_DIM + d] == line[d];
        if (same) return s->laplacian_weight[k];
    }
    return 0.0;
}

/* 1: the grid lines through the bonds k and j have the same weights a(n) at each |n_0|, within
 * PDI_STENCIL_WEIGHT_TOLERANCE of them. */
static int pdi_stencil_is_same_line_kind(const pd_stencil *s, int k, int j)
{
    for (int n0 = 0; n0 <= s->reach; n0++) {
        double a = pdi_stencil_get_line_weight(s, s->offset + k * PD_DIM, n0);
        double b = pdi_stencil_get_line_weight(s, s->offset + j * PD_DIM, n0);
        if (!(fabs(a - b) <= PDI_STENCIL_WEIGHT_TOLERANCE * fabs(a))) return 0;
    }
    return 1;
}

/* Largest n_0 >= 0 of the bonds that end on the grid line through the end of bond k. */
static int pdi_stencil_find_line_reach(const pd_stencil *s, int k)
{
    int reach = s->reach;
    while (reach > 0 && !(pdi_stencil_get_line_weight(s, s->offset + k * PD_DIM, reach) > 0.0)) reach--;
    return reach;
}

/* Sets layer_lap, line_kinds and the line arrays: sorts the family into grid lines along axis 0 by kinds of equal
 * weights, those with the largest reach first (used by lattice/line_laplacian). A line is represented by its bond with
 * n_0 = 0. */
static void pdi_stencil_build_grid_lines(pd_stencil *s)
{
    int width = s->reach + 1;
    for (int k = 0; k < s->count; k++)
        if (s->offset[k * PD_DIM] > 0) s->layer_lap[s->offset[k * PD_DIM]] += s->laplacian_weight[k];
    for (int reach = s->reach, used = 0; reach >= 0; reach--)
        for (int k = 0; k < s->count; k++) {
            int seen = s->offset[k * PD_DIM] != 0 || pdi_stencil_find_line_reach(s, k) != reach;
            for (int j = 0; j < k && !seen; j++)
                seen = s->offset[j * PD_DIM] == 0 && pdi_stencil_is_same_line_kind(s, j, k);
            if (seen) continue;
            for (int n0 = 0; n0 < width; n0++)
                s->line_lap[s->line_kinds * width + n0] = pdi_stencil_get_line_weight(s, s->offset + k * PD_DIM, n0);
            s->line_reach[s->line_kinds] = reach;
            for (int j = k; j < s->count; j++) {
                if (s->offset[j * PD_DIM] != 0 || !pdi_stencil_is_same_line_kind(s, k, j)) continue;
                memcpy(s->line + used++ * PD_DIM, s->offset + j * PD_DIM, PD_DIM * sizeof *s->line);
            }
            s->line_first[++s->line_kinds] = used;
        }
}

/* Does the work of pd_stencil_build on an overwritten stencil; on failure the caller frees what it has allocated. */
static pd_status pdi_stencil_build_inner(pd_ctx *ctx, const pd_stencil_desc *desc, pd_stencil *stencil)
{
    memset(stencil, 0, sizeof *stencil);
    stencil->m = desc->m > 0.0 ? desc->m : 3.0;
    if (!(desc->m >= 0.0) || stencil->m < 1.0 || stencil->m > PDI_STENCIL_MAX_M)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "stencil", "the horizon ratio m is %g, expected 1 to %d", desc->m,
                       PDI_STENCIL_MAX_M);
    stencil->volume = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        if (!(desc->h[d] > 0.0) || !(desc->h[d] < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "stencil",
                           "the spacing of axis %d is %g m, expected a positive one", d, desc->h[d]);
        stencil->h[d] = desc->h[d];
        stencil->volume *= desc->h[d];
    }
    PD_TRY(pdi_stencil_build_family(ctx, desc->family, stencil));
    if (desc->weights == PD_WEIGHTS_PUBLISHED) pdi_stencil_set_published_weights(stencil);
    else PD_TRY(pdi_stencil_calibrate_weights(ctx, stencil));
    for (int k = 0; k < stencil->count; k++) stencil->lap_sum += stencil->laplacian_weight[k];
    PD_TRY(pdi_area_weights_compute(ctx, stencil->count, stencil->xi, stencil->partial_volume, stencil->m, stencil->h,
                                    stencil->area_weight, &stencil->anisotropy));
    pdi_stencil_build_grid_lines(stencil);
    return pdi_stencil_build_bond_paths(ctx, stencil);
}

pd_status pd_stencil_build(pd_ctx *ctx, const pd_stencil_desc *desc, pd_stencil *stencil)
{
    pd_status status = pdi_stencil_build_inner(ctx, desc, stencil);
    if (status < 0) pd_stencil_free(ctx, stencil);
    return status;
}

void pd_stencil_free(pd_ctx *ctx, pd_stencil *s)
{
    pdi_array_registry_free(ctx, pdi_stencil_list_arrays, s);
    pdi_array_registry_free(ctx, pdi_stencil_list_path_arrays, s);
    memset(s, 0, sizeof *s);
}
