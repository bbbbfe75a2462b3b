/* isotropic_stencil: see isotropic_stencil.h */
#include "flow/isotropic_stencil.h"
#include "lattice/reconstruct.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Cell Reynolds number at which half of the correction is left: from 2 on central differences of convection
 * oscillate. */
#define PDI_ISOTROPIC_STENCIL_HALF_CELL_REYNOLDS 2.0

/* Mixed second difference [1/m2 times f] of component f over those bonds of a square that are open, to be taken off
 * where one of its three bonds is closed (eq. 3.15); 0: all three are open. */
static double pdi_isotropic_stencil_compute_incomplete_square(const pd_bonds *bonds, const pd_isotropic_square *square,
                                                              int32_t r, const double *f)
{
    int32_t node = bonds->node[r];
    int across = pdi_bond_is_open(bonds, r, square->diagonal), open[2];
    double sum = across ? f[node + bonds->paths.shift[square->diagonal]] - f[node] : 0.0;
    for (int s = 0; s < 2; s++) {
        open[s] = pdi_bond_is_open(bonds, r, square->legs[s]);
        if (open[s]) sum -= f[node + bonds->paths.shift[square->legs[s]]] - f[node];
    }
    return across && open[0] && open[1] ? 0.0 : square->weight_excess * sum;
}

PDI_FN double pdi_isotropic_stencil_compute_row_correction(const pd_isotropic_stencil *isotropic, int32_t r,
                                                           const double *f)
{
    double lap = 0.0;
    for (int s = 0; s < isotropic->squares; s++)
        lap += pdi_isotropic_stencil_compute_incomplete_square(isotropic->bonds, &isotropic->square[s], r, f);
    return lap;
}

PDI_FN void pdi_isotropic_stencil_add_row_corrections(const pd_ctx *ctx, const pd_isotropic_stencil *isotropic,
                                                      double nu, const double *u, double *ru)
{
    const pd_bonds *bonds = isotropic->bonds;
    if (!bonds) return;
    int64_t total = bonds->grid->total;
    int nt = pd_par_threads(ctx, (int64_t)bonds->rows * isotropic->squares * PD_DIM * 8);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++)
        for (int d = 0; d < PD_DIM; d++)
            ru[d * total + bonds->node[r]] +=
                nu * pdi_isotropic_stencil_compute_row_correction(isotropic, r, u + d * total);
}

PDI_FN void pdi_isotropic_stencil_add_velocity_correction(const pd_ctx *ctx, const pd_isotropic_stencil *isotropic,
                                                          const double *v, double *advecting)
{
    const pd_bonds *bonds = isotropic->bonds;
    if (!bonds) return;
    const uint8_t *kind = bonds->grid->kind;
    int32_t total = bonds->grid->total;
    int nt = pd_par_threads(ctx, (int64_t)total * PD_DIM * 4);
    (void)nt;
    for (int d = 0; d < PD_DIM; d++) {
        const double *f = v + (int64_t)d * total;
        double *w = advecting + (int64_t)d * total, bend = isotropic->third_moment[d];
        int32_t stride = bonds->grid->stride[d];
        PD_PARALLEL_FOR(nt)
        for (int32_t i = stride; i < total - stride; i++)
            w[i] -= kind[i] == PD_FLUID ? bend * ((f[i + stride] - f[i]) - (f[i] - f[i - stride])) : 0.0;
        PD_PARALLEL_FOR(nt)
        for (int32_t r = 0; r < bonds->rows; r++) {
            const double *leg = bonds->neighbour_distance + ((int64_t)r * PD_DIM + d) * 2;
            if (leg[0] <= 0.0 || leg[1] <= 0.0) w[bonds->node[r]] = f[bonds->node[r]];
        }
    }
}

/* 1: the neighbour of row r at `stride` along axis d is fluid, and the node behind it, on side 0 or 1, is not cut off
 * by a surface. */
static int pdi_isotropic_stencil_is_open_behind(const pd_bonds *bonds, int32_t r, int d, int side, int32_t stride)
{
    int32_t j = bonds->node[r] + stride;
    if (bonds->grid->kind[j] != PD_FLUID) return 0;
    return bonds->row_of_node[j] < 0 ||
           bonds->neighbour_distance[((int64_t)bonds->row_of_node[j] * PD_DIM + d) * 2 + side] > 0.0;
}

PDI_FN double pdi_isotropic_stencil_compute_derivative(const pdi_isotropic_stencil_place *place, int d, const double *u)
{
    const pd_bonds *bonds = place->bonds;
    const pd_grid *grid = bonds->grid;
    const double *leg = bonds->neighbour_distance + ((int64_t)place->row * PD_DIM + d) * 2;
    int32_t node = bonds->node[place->row], stride = grid->stride[d];
    const double *v = u + (int64_t)d * grid->total + node;
    double at[2], size[2];
    for (int side = 0; side < 2; side++) {
        double x[PD_DIM], w[PD_DIM];
        size[side] = fabs(leg[side]);
        at[side] = leg[side] > 0.0 ? v[side ? stride : -stride] : 0.0;
        if (leg[side] > 0.0 || !place->wall) continue;
        pd_grid_position(grid, node, x);
        x[d] += (side ? size[side] : -size[side]) * grid->h[d];
        place->wall(place->wall_user, x, w);
        at[side] = w[d];
    }
    double slope = pdi_reconstruct_parabola_derivative(size[0], size[1], at[0], v[0], at[1]);
    if (PD_DIM == 3 || bonds->stencil->reach > 1) return slope / grid->h[d];
    int free = leg[1] > 0.0; /* the side whose neighbour comes before the surface */
    int32_t step = free ? stride : -stride;
    if ((leg[0] > 0.0) != (leg[1] > 0.0) && pdi_isotropic_stencil_is_open_behind(bonds, place->row, d, free, step)) {
        double t = size[1 - free], near = at[free] - v[0]; /* divided differences, from the surface inwards */
        double inner = 0.5 * ((v[2 * step] - at[free]) - near), outer = (near - (v[0] - at[1 - free]) / t) / (1.0 + t);
        double cubic = t * (inner - outer) / (2.0 + t);
        slope -= free ? cubic : -cubic;
    }
    return slope / grid->h[d];
}

PDI_COLD_BEGIN
PDI_FN double pdi_isotropic_stencil_compute_blending(const pd_isotropic_stencil *isotropic, double rate)
{
    double longest = 0.0;
    if (!isotropic->bonds) return 0.0;
    for (int d = 0; d < PD_DIM; d++) longest = pd_max(longest, isotropic->bonds->stencil->h[d]);
    double times = rate * longest / PDI_ISOTROPIC_STENCIL_HALF_CELL_REYNOLDS;
    return 1.0 / (1.0 + times * times);
}

/* Bond with the offset n; -1: none. */
static int pdi_isotropic_stencil_find_bond(const pd_stencil *s, const int *n)
{
    for (int k = 0; k < s->count; k++)
        if (!memcmp(s->offset + k * PD_DIM, n, PD_DIM * sizeof *n)) return k;
    return -1;
}

/* Adds the four squares around a node in the plane of axes a and b, and their weights to weight_excess. 1: done; 0: the
 * family has no diagonal bonds. */
static int pdi_isotropic_stencil_build_plane(const pd_stencil *s, int a, int b, pd_isotropic_stencil *isotropic)
{
    double wanted = (1.0 / (s->h[a] * s->h[a]) + 1.0 / (s->h[b] * s->h[b])) / 12.0;
    for (int which = 0; which < 4; which++) {
        pd_isotropic_square *square = &isotropic->square[isotropic->squares++];
        int n[PD_DIM];
        memset(n, 0, sizeof n);
        n[a] = which & 1 ? 1 : -1;
        square->legs[0] = pdi_isotropic_stencil_find_bond(s, n);
        n[b] = which & 2 ? 1 : -1;
        square->diagonal = pdi_isotropic_stencil_find_bond(s, n);
        n[a] = 0;
        square->legs[1] = pdi_isotropic_stencil_find_bond(s, n);
        if (square->diagonal < 0) return 0;
        square->weight_excess = wanted - s->laplacian_weight[square->diagonal];
        isotropic->weight_excess[square->diagonal] += square->weight_excess;
        for (int side = 0; side < 2; side++) isotropic->weight_excess[square->legs[side]] -= square->weight_excess;
    }
    return 1;
}

/* Third moment [-] of the gradient along axis d: M_dd/6 less the mean of M_bd/2 over the other axes (eq. 3.6). */
static double pdi_isotropic_stencil_compute_third_moment(const pd_stencil *s, int d)
{
    double bend = 0.0;
    for (int k = 0; k < s->count; k++) {
        double n = s->offset[k * PD_DIM + d];
        for (int b = 0; b < PD_DIM; b++)
            bend += (b == d        ? 1.0 / 6.0
                     : PD_DIM == 3 ? -0.25
                                   : -0.5) *
                    n * n * s->gradient_weight[k * PD_DIM + b] * s->xi[k * PD_DIM + b];
    }
    return bend;
}

PDI_FN void pdi_isotropic_stencil_build(const pd_bonds *bonds, pd_isotropic_stencil *isotropic)
{
    const pd_stencil *s = bonds->stencil;
    memset(isotropic, 0, sizeof *isotropic);
    if (PD_DIM == 1 || s->reach > 1 || s->count != 2 * PD_DIM * PD_DIM || bonds->grid->circumference) return;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = a + 1; b < PD_DIM; b++)
            if (!pdi_isotropic_stencil_build_plane(s, a, b, isotropic)) return;
    for (int d = 0; d < PD_DIM; d++) isotropic->third_moment[d] = pdi_isotropic_stencil_compute_third_moment(s, d);
    isotropic->bonds = bonds;
}
PDI_COLD_END
