/* integral_diagnostics: see integral_diagnostics.h */
#include "couple/integral_diagnostics.h"
#include "core/par.h"
#include "lattice/surface.h"
#include "transport/amount.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* 1: the centre of a node lies in the box from lo to hi [m]. */
static int pdi_integral_diagnostics_is_inside(const pd_grid *grid, int32_t node, const double *lo, const double *hi)
{
    double x[PD_DIM];
    pd_grid_position(grid, node, x);
    return pd_grid_is_between(grid, lo, hi, x);
}

/* ---- plane ---- */

/* Sets area, mean_concentration, mixed_concentration and pressure of *r from the faces between two fluid cells of a
 * plane. The value on a face is the mean of both cells; means are weighted by the area of the face, which on rings
 * follows the circumference. All means are NaN without such faces, the mixed one also where the fluxes add up to 0.
 * Without flow pressure is 0 and mixed_concentration NaN; without transport the concentrations of the cells count as
 * 0. */
static void pdi_integral_diagnostics_plane_means(const pd_bonds *bonds, const pd_flow *flow,
                                                 const pd_transport *transport, int axis, int index,
                                                 pd_diagnostics_plane_result *r)
{
    const pd_grid *grid = bonds->grid;
    pdi_compensated_sum pressure = {0.0, 0.0}, mean = {0.0, 0.0}, stream = {0.0, 0.0}, carried = {0.0, 0.0};
    double faces = 0.0;
    for (int32_t node = 0; node < grid->total; node++) {
        int32_t before = node - grid->stride[axis];
        if (grid->kind[node] != PD_FLUID || pdi_grid_index_along(grid, node, axis) != index) continue;
        if (grid->kind[before] != PD_FLUID) continue;
        double c = transport ? 0.5 * (transport->c[before] + transport->c[node]) : 0.0;
        double face = 0.5 * (pd_grid_circumference(grid, before) + pd_grid_circumference(grid, node));
        faces += face;
        pdi_compensated_sum_add(&mean, face * c);
        if (!flow) continue;
        const double *u = flow->u + (int64_t)axis * grid->total;
        pdi_compensated_sum_add(&pressure, face * 0.5 * (flow->p[before] + flow->p[node]));
        pdi_compensated_sum_add(&stream, face * 0.5 * (u[before] + u[node]));
        pdi_compensated_sum_add(&carried, face * 0.5 * (u[before] + u[node]) * c);
    }
    r->area = faces * bonds->stencil->volume / grid->h[axis];
    r->mean_concentration = pdi_compensated_sum_total(&mean) / faces;
    r->mixed_concentration = pdi_compensated_sum_total(&carried) / pdi_compensated_sum_total(&stream);
    r->pressure = flow ? flow->rho * pdi_compensated_sum_total(&pressure) / faces : 0.0;
}

void pd_diagnostics_plane(pd_ctx *ctx, const pd_bonds *bonds, pd_flow *flow, pd_transport *transport, int axis,
                          int index, pd_diagnostics_plane_result *r)
{
    memset(r, 0, sizeof *r);
    pdi_integral_diagnostics_plane_means(bonds, flow, transport, axis, index, r);
    if (flow) r->flow = pd_flow_integrate_section(ctx, flow, axis, index);
    if (transport) r->species_flux = pdi_amount_section(ctx, transport, axis, index);
    r->speed = r->flow / r->area;
}

/* ---- exchange ---- */

/* 1: the surface that bond k of a node hits is metal (only with `dissolve`), or a wall at which the transport
 * prescribes a concentration of at least 0 (desc.held; NaN: none). */
static int pdi_integral_diagnostics_is_source(const pd_bond_paths *paths, const pd_transport *t,
                                              const pd_dissolve *dissolve, int32_t node, int k)
{
    double x[PD_DIM];
    int all;
    if (dissolve && pdi_bond_path_has_metal(paths, node, pdi_bond_path_find_closed_group(paths, node, k), &all))
        return 1;
    if (!t->desc.held) return 0;
    pdi_bond_find_cut_fraction(paths, node, k, x);
    pdi_grid_fold_position_images(t->grid, x);
    return t->desc.held(t->desc.user, x) >= 0.0;
}

/* 1: the position of a node, which is open now, lies inside the initial smooth shape of the metal or within the
 * tolerance of its surface, so that the node has dissolved. */
static int pdi_integral_diagnostics_is_dissolved(const pd_grid *grid, int32_t node)
{
    double x[PD_DIM];
    pd_grid_position(grid, node, x);
    return pdi_grid_signed_distance(grid, grid->solid, x) <= pd_shape_surface_tolerance(grid->h, x);
}

/* 1: all surfaces in the family of a node are sides of the box or smooth shapes that have not receded. 0: an end of a
 * bond is closed and lies behind neither, or, with `dissolve` and smooth metal, the node or an open end lies where the
 * metal was at the start. */
static int pdi_integral_diagnostics_is_smooth(const pd_bond_paths *paths, const pd_dissolve *dissolve, int32_t node)
{
    const pd_grid *grid = paths->grid;
    int recedes = dissolve && grid->solid >= 0 && pd_shape_is_smooth(grid->shapes, grid->solid);
    if (recedes && pdi_integral_diagnostics_is_dissolved(grid, node)) return 0;
    for (int k = 0; k < paths->stencil->count; k++) {
        int32_t end = node + paths->shift[k];
        if (pdi_grid_is_open(grid->kind[end])) {
            if (recedes && pdi_integral_diagnostics_is_dissolved(grid, end)) return 0;
            continue;
        }
        int walled = pdi_grid_is_behind_wall(grid, end);
        if (!walled && pdi_bond_find_surface_shape(grid, end, 0) < 0) return 0;
    }
    return 1;
}

/* 1: all ends of the bonds of a node are open, so that its family meets no surface. */
static int pdi_integral_diagnostics_is_interior(const pd_bond_paths *paths, int32_t node)
{
    for (int k = 0; k < paths->stencil->count; k++)
        if (!pdi_grid_is_open(paths->grid->kind[node + paths->shift[k]])) return 0;
    return 1;
}

/* Area [m^(d-1)] of dissolving or prescribed surfaces at a fluid node, on rings of the whole ring; 0 in the interior.
 * Where all surfaces are smooth and have not receded: of its closed faces, met by bonds of one step along an axis.
 * Otherwise: the area weights times cell volume of its closed bonds with a positive weight. Surfaces that are no source
 * are left out. */
static double pdi_integral_diagnostics_node_area(const pd_bond_paths *paths, const pd_transport *t,
                                                 const pd_dissolve *dissolve, int32_t node)
{
    const pd_stencil *s = paths->stencil;
    double sum = 0.0;
    if (pdi_integral_diagnostics_is_interior(paths, node)) return 0.0;
    int smooth = pdi_integral_diagnostics_is_smooth(paths, dissolve, node);
    for (int k = 0; k < s->count; k++) {
        int axis = -1, steps = 0;
        if (pdi_grid_is_open(t->grid->kind[node + paths->shift[k]])) continue;
        for (int d = 0; d < PD_DIM; d++) {
            if (s->offset[k * PD_DIM + d] != 0) axis = d;
            steps += abs(s->offset[k * PD_DIM + d]);
        }
        if (smooth ? steps > 1 : !(s->area_weight[k] > 0.0)) continue;
        if (!pdi_integral_diagnostics_is_source(paths, t, dissolve, node, k)) continue;
        if (smooth) sum += pdi_surface_compute_face_area(t->grid, node, axis, s->offset[k * PD_DIM + axis] > 0);
        else
            sum += s->area_weight[k] * s->volume *
                   pdi_grid_circumference_at(t->grid, node, 0.5 * s->xi[(k + 1) * PD_DIM - 1]);
    }
    return sum;
}

void pd_diagnostics_surface_flux(pd_ctx *ctx, const pd_bond_paths *paths, const pd_transport *t,
                                 const pd_dissolve *dissolve, const double *lo, const double *hi, int axis,
                                 double *flux, double *area)
{
    const pd_grid *grid = t->grid;
    int layers = axis < 0 ? 1 : grid->n[axis];
    (void)ctx;
    for (int k = 0; k < layers; k++) flux[k] = area[k] = 0.0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID || !pdi_integral_diagnostics_is_inside(grid, node, lo, hi)) continue;
        pd_grid_index(grid, node, i);
        int k = axis < 0 ? 0 : i[axis];
        area[k] += pdi_integral_diagnostics_node_area(paths, t, dissolve, node);
        double gain = t->source[node] - t->absorb[node] * t->c[node];
        if (t->bonds->row_of_node[node] >= 0)
            gain += pdi_diffusion_gain(&t->diffusion, node, t->c[node], t->rest ? t->rest[node] : 0.0);
        flux[k] += gain * paths->stencil->volume * pd_grid_circumference(grid, node);
    }
}

/* ---- box ---- */

void pd_diagnostics_box(pd_ctx *ctx, const pd_stencil *stencil, const pd_grid *grid, const pd_flow *flow,
                        const double *c, const double *metal, const double *lo, const double *hi,
                        pd_diagnostics_box_result *r)
{
    pdi_compensated_sum energy = {0.0, 0.0}, dissolved = {0.0, 0.0}, solid = {0.0, 0.0}, momentum[PD_DIM];
    double nodes = 0.0, volume = stencil->volume;
    (void)ctx;
    memset(r, 0, sizeof *r);
    memset(momentum, 0, sizeof momentum);
    r->min_concentration = r->max_concentration = (double)NAN;
    for (int32_t i = 0; i < grid->total; i++) {
        int fluid = grid->kind[i] == PD_FLUID;
        if ((!fluid && grid->kind[i] != PD_SOLID) || !pdi_integral_diagnostics_is_inside(grid, i, lo, hi)) continue;
        double around = pd_grid_circumference(grid, i);
        if (!fluid && metal) pdi_compensated_sum_add(&solid, around * metal[i]);
        if (!fluid) continue;
        nodes += around;
        for (int d = 0; d < PD_DIM && flow; d++) {
            double u = flow->u[(int64_t)d * grid->total + i];
            /* radial ones cancel */
            if (!grid->circumference || d < PD_DIM - 1) pdi_compensated_sum_add(&momentum[d], around * u);
            pdi_compensated_sum_add(&energy, 0.5 * around * u * u);
        }
        if (!c) continue;
        pdi_compensated_sum_add(&dissolved, around * c[i]);
        r->min_concentration = pd_min(r->min_concentration, c[i]);
        r->max_concentration = pd_max(r->max_concentration, c[i]);
    }
    r->volume = nodes * volume;
    r->dissolved = pdi_compensated_sum_total(&dissolved) * volume;
    r->solid = pdi_compensated_sum_total(&solid) * volume;
    r->energy = flow ? flow->rho * volume * pdi_compensated_sum_total(&energy) : 0.0;
    for (int d = 0; d < PD_DIM; d++)
        r->momentum[d] = flow ? flow->rho * volume * pdi_compensated_sum_total(&momentum[d]) : 0.0;
}
