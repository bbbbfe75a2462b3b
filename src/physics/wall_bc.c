/* wall_bc: see wall_bc.h */
#include "physics/wall_bc.h"
#include <math.h>
#include <string.h>

/* [cells] Distance within which a point lies on a side: rounding. */
#define PDI_WALL_BC_SIDE_TOLERANCE 1e-6

/* Does x [m] lie on a side of the box that is a wall, within 1e-6 cells of its plane? 1 or 0. */
static int pdi_wall_bc_is_on_side(const pd_setup *setup, int side, const double *x)
{
    int d = side / 2;
    double edge = side % 2 ? setup->hi[d] : setup->lo[d];
    return setup->side[side].kind == PD_SIDE_WALL && fabs(x[d] - edge) < PDI_WALL_BC_SIDE_TOLERANCE * setup->h[d];
}

PDI_FN int pdi_wall_bc_has_motion(const pd_setup *setup)
{
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (setup->side[s].has_wall_velocity) return 1;
    return 0;
}

PDI_FN int pdi_wall_bc_has_concentration(const pd_setup *setup)
{
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (setup->side[s].has_fixed_c) return 1;
    for (int k = 0; k < setup->wall_count; k++)
        if (setup->wall_shape[k].has_fixed_c) return 1;
    return 0;
}

PDI_FN void pdi_wall_bc_get_velocity(void *user, const double *x, double *v)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    const pd_setup *u = inlet->setup;
    int met = 0, flip;
    double at[PD_DIM];
    memcpy(at, x, sizeof at);
    flip = pdi_grid_fold_position_images(inlet->grid, at);
    for (int d = 0; d < PD_DIM; d++) v[d] = 0.0;
    for (int s = 0; s < 2 * PD_DIM; s++) {
        if (!pdi_wall_bc_is_on_side(u, s, at)) continue;
        met++;
        for (int d = 0; d < PD_DIM && u->side[s].has_wall_velocity; d++)
            v[d] += pdi_setup_eval_expr(&u->side[s].wall_velocity[d], at, inlet->time);
    }
    for (int d = 0; d < PD_DIM; d++) {
        if (met > 1) v[d] /= met;
        if (flip >> d & 1) v[d] = -v[d];
    }
}

/* Prescribed concentration [mol/m3] at x [m] and time t [s]; -HUGE_VAL, which is refused as negative, where the
 * expression is NaN. */
static double pdi_wall_bc_compute_concentration(const pd_expr *held, const double *x, double t)
{
    double c = pdi_setup_eval_expr(held, x, t);
    return isnan(c) ? -HUGE_VAL : c;
}

/* Prescribed concentration [mol/m3] of the nearest wall shape, by the distance of its surface, nearer than the largest
 * spacing to x [m]; of equally near ones the first. NaN: there is none, it prescribes none, or solid is as near or
 * nearer. */
static double pdi_wall_bc_shape_concentration(const pd_setup *setup, const double *x, double t)
{
    const pd_setup_wall *found = NULL;
    double nearest = 0.0;
    for (int d = 0; d < PD_DIM; d++) nearest = pd_max(nearest, setup->h[d]);
    if (setup->solid >= 0) nearest = pd_min(nearest, fabs(pd_shape_distance(setup->shape, setup->solid, x)));
    for (int k = 0; k < setup->wall_count; k++) {
        double distance = fabs(pd_shape_distance(setup->shape, setup->wall_shape[k].shape, x));
        if (!(distance < nearest - pd_shape_surface_tolerance(setup->h, x))) continue; /* of several, the first one */
        nearest = distance;
        found = &setup->wall_shape[k];
    }
    return found && found->has_fixed_c ? pdi_wall_bc_compute_concentration(&found->fixed_c, x, t) : (double)NAN;
}

PDI_FN double pdi_wall_bc_get_concentration(void *user, const double *x)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    const pd_setup *u = inlet->setup;
    double sum = 0.0;
    int side = 0, hold = 0;
    for (int s = 0; s < 2 * PD_DIM; s++) {
        if (!pdi_wall_bc_is_on_side(u, s, x)) continue;
        side = 1;
        if (!u->side[s].has_fixed_c) continue;
        sum += pdi_wall_bc_compute_concentration(&u->side[s].fixed_c, x, inlet->time);
        hold++;
    }
    if (hold) return sum / hold; /* where two sides meet, the mean: neither comes first */
    return side ? (double)NAN : pdi_wall_bc_shape_concentration(u, x, inlet->time);
}

PDI_FN double pdi_wall_bc_is_dirichlet_species(void *user, const double *x)
{
    const pd_setup *u = ((const pd_inlet *)user)->setup;
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (u->side[s].has_fixed_species && pdi_wall_bc_is_on_side(u, s, x)) return 1.0;
    return (double)NAN;
}

#undef PDI_WALL_BC_SIDE_TOLERANCE
