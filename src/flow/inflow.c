/* inflow: see inflow.h */
#include "flow/inflow.h"
#include <math.h>

#define PDI_INFLOW_ROUNDING 1e-9 /* [-] sum of bond weights over their sizes that counts as zero */

/* 1: the gradient weights of the open bonds of row r to inlets do not balance along the side: their sum along an axis
 * not in `across` exceeds 1e-9 of the sum of their sizes. across: bits of the axes that the ghost is behind. */
static int pdi_inflow_has_tangential_weight(const pd_bonds *bonds, int32_t r, int across)
{
    const pd_stencil *s = bonds->stencil;
    double sum[PD_DIM], size = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum[d] = 0.0;
    for (int k = 0; k < s->count; k++) {
        int32_t far = bonds->node[r] + bonds->paths.shift[k];
        if (bonds->grid->kind[far] != PD_INLET || !pdi_bond_is_open(bonds, r, k)) continue;
        for (int d = 0; d < PD_DIM; d++) {
            sum[d] += s->gradient_weight[k * PD_DIM + d];
            size += fabs(s->gradient_weight[k * PD_DIM + d]);
        }
    }
    for (int d = 0; d < PD_DIM; d++)
        if (!(across >> d & 1) && fabs(sum[d]) > PDI_INFLOW_ROUNDING * size) return 1;
    return 0;
}

PDI_FN double pdi_inflow_compute_flux_weight(const pd_bonds *bonds, int32_t i, int axis, int up)
{
    const pd_stencil *s = bonds->stencil;
    const pd_grid *grid = bonds->grid;
    int32_t r = bonds->row_of_node[i];
    double sum = 0.0;
    if (grid->kind[i] != PD_FLUID || r < 0) return 0.0;
    for (int k = 0; k < s->count; k++) {
        int32_t far = i + bonds->paths.shift[k];
        int at = pdi_grid_index_along(grid, far, axis);
        if (grid->kind[far] != PD_INLET || (up ? at < grid->n[axis] : at >= 0) || !pdi_bond_is_open(bonds, r, k))
            continue;
        sum += fabs(s->gradient_weight[k * PD_DIM + axis]) * pdi_bond_get_flux_factor(bonds, i, k);
    }
    return sum * s->volume * pd_grid_circumference(grid, i);
}

/* Mean normal speed of ghost g and its source over that on the side [-], with which the bonds of all nodes in front of
 * a face together carry what passes the face: face area over the sum of their flux weights. 0: the cell at the side is
 * not fluid, or no bond passes. Of several axes that the ghost is behind the first counts. */
static double pdi_inflow_compute_speed_ratio(const pd_bonds *bonds, int32_t g)
{
    const pd_ghosts *ghosts = &bonds->ghosts;
    const pd_grid *grid = bonds->grid;
    int axis = 0, first[PD_DIM];
    while (!(ghosts->normal_axis[g] >> axis & 1)) axis++;
    int up = pdi_grid_index_along(grid, ghosts->node[g], axis) >= grid->n[axis];
    double half = up ? 0.5 * grid->h[axis] : -0.5 * grid->h[axis], have = 0.0;
    pd_grid_index(grid, ghosts->source[g], first);
    first[axis] = up ? grid->n[axis] - 1 : 0;
    int32_t node = pd_grid_node(grid, first), step = up ? -grid->stride[axis] : grid->stride[axis];
    if (grid->kind[node] != PD_FLUID) return 0.0;
    for (int depth = 0; depth < bonds->stencil->reach && depth < grid->n[axis]; depth++)
        have += 2.0 * pdi_inflow_compute_flux_weight(bonds, node + depth * step, axis, up);
    double face =
        pdi_grid_circumference_at(grid, node, axis < PD_DIM - 1 ? 0.0 : half) * bonds->stencil->volume / grid->h[axis];
    return have > 0.0 ? face / have : 0.0;
}

/* 1: ghost g is behind a side with developed flow. */
static int pdi_inflow_is_developed(const pd_bonds *bonds, int32_t g, int developed)
{
    const pd_ghosts *ghosts = &bonds->ghosts;
    int axis = 0;
    while (!(ghosts->normal_axis[g] >> axis & 1)) axis++;
    return developed >>
               (2 * axis + (pdi_grid_index_along(bonds->grid, ghosts->node[g], axis) >= bonds->grid->n[axis])) &
           1;
}

PDI_FN void pdi_inflow_compute_ratios(const pd_bonds *bonds, int developed, uint8_t *sided, double *ratio)
{
    const pd_ghosts *ghosts = &bonds->ghosts;
    for (int32_t g = ghosts->outlets_end; g < ghosts->inlets_end; g++) {
        int32_t at = g - ghosts->outlets_end, source = ghosts->source[g], r = bonds->row_of_node[source];
        int fluid = bonds->grid->kind[source] == PD_FLUID && r >= 0;
        /* rings of unequal lengths never balance */
        sided[at] = (uint8_t)(fluid && (bonds->grid->circumference ||
                                        pdi_inflow_has_tangential_weight(bonds, r, ghosts->normal_axis[g])));
        /* developed flow passes bonds through the side as it does further on. Where inlets end beside outlets not all
         * bonds have their mirror image */
        int whole = fluid && !bonds->grid->mixed_sides && !pdi_inflow_is_developed(bonds, g, developed);
        ratio[at] = whole ? pdi_inflow_compute_speed_ratio(bonds, g) : -1.0;
    }
}

/* Component d of v at the source of ghost g, with the sign that it has in front of the ghost (mirror sides flip it). */
static double pdi_inflow_get_source_value(const pd_ghosts *ghosts, int32_t g, int d, const double *v)
{
    double there = v[d * (int64_t)ghosts->grid->total + ghosts->source[g]];
    return (ghosts->sign_flips[g] ^ ghosts->normal_axis[g]) >> d & 1 ? -there : there;
}

/* 1: the source of ghost g is fluid. Other ghosts hold the velocity of the side itself. */
static int pdi_inflow_has_fluid_source(const pd_bonds *bonds, int32_t g)
{
    int32_t source = bonds->ghosts.source[g];
    return bonds->grid->kind[source] == PD_FLUID && bonds->row_of_node[source] >= 0;
}

PDI_FN void pdi_inflow_set_doubled_velocity(const pd_bonds *bonds, double *v)
{
    const pd_ghosts *ghosts = &bonds->ghosts;
    for (int32_t g = ghosts->outlets_end; g < ghosts->inlets_end; g++)
        for (int d = 0; d < PD_DIM && pdi_inflow_has_fluid_source(bonds, g); d++)
            v[d * (int64_t)ghosts->grid->total + ghosts->node[g]] += pdi_inflow_get_source_value(ghosts, g, d, v);
}

/* Flux [m^d/s over the cell volume], positive into the box, of the inlet faces at the end `up` (0 or 1) of the radius.
 * v [PD_DIM][total] [m/s]: doubled at ghosts. */
static double pdi_inflow_integrate_radial_faces(const pd_bonds *bonds, int up, const double *v)
{
    const pd_grid *grid = bonds->grid;
    int axis = PD_DIM - 1;
    double sum = 0.0, half = 0.5 * grid->h[axis];
    int64_t stride = grid->stride[axis], first = (up ? grid->n[axis] - 1 : 0) + (int64_t)grid->ghost;
    for (int64_t i = first * stride; i < (first + 1) * stride; i++) {
        int64_t ghost = up ? i + stride : i - stride;
        if (grid->kind[i] != PD_FLUID || grid->kind[ghost] != PD_INLET) continue;
        sum += 0.5 * v[axis * (int64_t)grid->total + ghost] *
               pdi_grid_circumference_at(grid, (int32_t)i, up ? half : -half);
    }
    return (up ? -1.0 : 1.0) * sum / grid->h[axis];
}

/* Flux, positive into the box, that bonds carry through the inlet at the end `up` of the radius, in the unit of
 * pdi_inflow_integrate_radial_faces; *weight: its derivative by the radial speed of all ghosts. */
static double pdi_inflow_integrate_radial_bonds(const pd_bonds *bonds, int up, const double *v, double *weight)
{
    const pd_stencil *s = bonds->stencil;
    const pd_grid *grid = bonds->grid;
    int64_t total = grid->total;
    int axis = PD_DIM - 1, least = up && grid->n[axis] > s->reach ? grid->n[axis] - s->reach : 0;
    double sum = 0.0;
    *weight = 0.0;
    for (int depth = least; depth < (up ? grid->n[axis] : s->reach) && depth < grid->n[axis]; depth++)
        for (int64_t n = 0; n < grid->stride[axis]; n++) {
            int32_t i = (int32_t)((depth + grid->ghost) * (int64_t)grid->stride[axis] + n), r = bonds->row_of_node[i];
            if (grid->kind[i] != PD_FLUID || r < 0) continue;
            double around = pd_grid_circumference(grid, i);
            for (int k = 0; k < s->count; k++) {
                int32_t far = i + bonds->paths.shift[k];
                int at = pdi_grid_index_along(grid, far, axis);
                if (grid->kind[far] != PD_INLET || (up ? at < grid->n[axis] : at >= 0) ||
                    !pdi_bond_is_open(bonds, r, k))
                    continue;
                double share = around * pdi_bond_get_flux_factor(bonds, i, k);
                for (int d = 0; d < PD_DIM; d++)
                    sum -= share * s->gradient_weight[k * PD_DIM + d] * (v[d * total + i] + v[d * total + far]);
                *weight -= share * s->gradient_weight[k * PD_DIM + axis];
            }
        }
    return sum;
}

/* 1: ghost g is behind the end `up` of the radius. */
static int pdi_inflow_is_radial_ghost(const pd_bonds *bonds, int32_t g, int up)
{
    int at = pdi_grid_index_along(bonds->grid, bonds->ghosts.node[g], PD_DIM - 1);
    return up ? at >= bonds->grid->n[PD_DIM - 1] : at < 0;
}

/* Adds the same radial speed to all inlet ghosts at the end `up` of the radius, so that bonds carry the flux `pushed`;
 * nothing if no bond does. Bonds between rings have unequal weights in both directions, so the ghosts cannot balance
 * one by one. */
static void pdi_inflow_update_radial_ghosts(const pd_bonds *bonds, int up, double pushed, double *v)
{
    const pd_ghosts *ghosts = &bonds->ghosts;
    double weight, carried = pdi_inflow_integrate_radial_bonds(bonds, up, v, &weight);
    double *w = v + (PD_DIM - 1) * (int64_t)bonds->grid->total;
    for (int32_t g = ghosts->outlets_end; g < ghosts->inlets_end && fabs(weight) > 0.0; g++)
        if (pdi_inflow_is_radial_ghost(bonds, g, up)) w[ghosts->node[g]] += (pushed - carried) / weight;
}

PDI_FN int pdi_inflow_has_radial_balance(const pd_bonds *bonds)
{
    return bonds->grid->circumference && !bonds->grid->mixed_sides && bonds->stencil->reach > 1;
}

PDI_FN void pdi_inflow_set_advecting_velocity(const pd_bonds *bonds, const uint8_t *sided, const double *ratio,
                                              int even, double *v)
{
    const pd_ghosts *ghosts = &bonds->ghosts;
    int64_t total = ghosts->grid->total;
    int rings = pdi_inflow_has_radial_balance(bonds);
    double pushed[2] = {0.0, 0.0};
    for (int up = 0; up < 2 && rings; up++) pushed[up] = pdi_inflow_integrate_radial_faces(bonds, up, v);
    for (int32_t g = ghosts->outlets_end; g < ghosts->inlets_end; g++) {
        if (!pdi_inflow_has_fluid_source(bonds, g)) continue;
        int32_t r = bonds->row_of_node[ghosts->source[g]];
        int turned = ghosts->sign_flips[g] ^ ghosts->normal_axis[g], plain = even && bonds->near_smooth_surface[r];
        const double *tensor = bonds->flux_correction + (int64_t)r * PD_DIM * PD_DIM;
        double twice[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) twice[d] = v[d * total + ghosts->node[g]];
        for (int a = 0; a < PD_DIM; a++) {
            double sum = 0.0, front = pdi_inflow_get_source_value(ghosts, g, a, v);
            for (int b = 0; b < PD_DIM; b++) {
                double part = plain ? (a == b ? twice[b] : 0.0) : tensor[a * PD_DIM + b] * twice[b];
                sum += ((turned >> a ^ turned >> b) & 1) ? -part : part;
            }
            int across = ghosts->normal_axis[g] >> a & 1, at = g - ghosts->outlets_end;
            if (across && ratio[at] >= 0.0) sum = ratio[at] * twice[a];
            v[a * total + ghosts->node[g]] = !across && sided[at] ? front : sum - front;
        }
    }
    for (int up = 0; up < 2 && rings; up++) pdi_inflow_update_radial_ghosts(bonds, up, pushed[up], v);
}
