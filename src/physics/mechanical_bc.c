/* mechanical_bc: see mechanical_bc.h */
#include "physics/mechanical_bc.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Displacements below this size are set to 0: squares of them underflow. */
#define PDI_MECHANICAL_BC_MIN_DISPLACEMENT 1e-100 /* [m] */
/* Relative tolerance within which load weights add up to the loaded area (rounding): no rescaling then. */
#define PDI_MECHANICAL_BC_SUM_TOLERANCE 1e-9
/* Least part of the initial load weights that has to be left, else the traction is an error. */
#define PDI_MECHANICAL_BC_MIN_METAL_FRACTION 0.01

/* Fixed-point unit of sums of load weights: integers over 2^-56 of the area, so that the order of points plays no
 * part. */
#define PDI_MECHANICAL_BC_FIXED_POINT_SCALE 72057594037927936.0 /* 2^56 */

/* [cells] Moments along an axis are not matched where the loaded points extend by less (singular system). */
#define PDI_MECHANICAL_BC_MIN_EXTENT 0.1

/* Layer of point i from a side of the box, in cells: 0 beside the side. */
static int pdi_mechanical_bc_get_layer(const pd_mechanical_bc *g, int32_t i, int side)
{
    const pd_grid *grid = g->structure->grid;
    int at[PD_DIM];
    pd_grid_index(grid, g->structure->node[i], at);
    return side % 2 ? grid->n[side / 2] - 1 - at[side / 2] : at[side / 2];
}

/* Move place x [m] along the normal of a side of the box onto that side, in place. */
static void pdi_mechanical_bc_project_to_side(const pd_mechanical_bc *g, int side, double *x)
{
    x[side / 2] = side % 2 ? g->setup->hi[side / 2] : g->setup->lo[side / 2];
}

/* Was point i connected to a side by metal without a gap, along the normal of the side, at the start? 1 or 0. */
static int pdi_mechanical_bc_is_connected_to_side(const pd_mechanical_bc *g, int32_t i, int side)
{
    const pd_solid_coupling *s = g->structure;
    int at[PD_DIM], row = pdi_mechanical_bc_get_layer(g, i, side);
    pd_grid_index(s->grid, s->node[i], at);
    while (row-- > 0) {
        at[side / 2] += side % 2 ? 1 : -1;
        if (s->point[pd_grid_node(s->grid, at)] < 0) return 0;
    }
    return 1;
}

/* Applies to a side (layers that are connected to it) or to a shape. */
PDI_FN int pdi_mechanical_bc_is_held(const pd_mechanical_bc *g, int k, int32_t i)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    double x[PD_DIM];
    if (grip->side >= 0)
        return pdi_mechanical_bc_get_layer(g, i, grip->side) < g->held_layers[k] &&
               pdi_mechanical_bc_is_connected_to_side(g, i, grip->side);
    pd_grid_position(g->structure->grid, g->structure->node[i], x);
    return pdi_shape_contains(g->setup->shape, grip->shape, g->setup->h, x);
}

/* A family holds offsets shorter than m + 1/2 cells; its truncation is felt over two of them. */
PDI_FN int pdi_mechanical_bc_count_held_layers(const pd_mechanical_bc *g)
{
    return 2 * ((int)ceil(g->structure->desc.horizon_ratio + 0.5) - 1);
}

/* The point in the given layer from a side, on the lattice line of point i along the normal; -1: no metal with
 * stiffness is there. */
static int32_t pdi_mechanical_bc_find_point_in_layer(const pd_mechanical_bc *g, int32_t i, int side, int row)
{
    const pd_solid_coupling *s = g->structure;
    int at[PD_DIM];
    pd_grid_index(s->grid, s->node[i], at);
    at[side / 2] = side % 2 ? s->grid->n[side / 2] - 1 - row : row;
    if (!pd_grid_is_inside(s->grid, at)) return -1;
    int32_t inner = s->point[pd_grid_node(s->grid, at)];
    return inner >= 0 && s->stiffness_factor[inner] > 0.0 ? inner : -1;
}

/* 1: metal leads without a gap from point i to the first layer behind the held ones of condition k, and component d is
 * free there. */
static int pdi_mechanical_bc_has_free_layer(const pd_mechanical_bc *g, int k, int32_t i, int d)
{
    int side = g->setup->metal_body.mechanical_bc[k].side;
    for (int row = pdi_mechanical_bc_get_layer(g, i, side) + 1; row < g->held_layers[k]; row++)
        if (pdi_mechanical_bc_find_point_in_layer(g, i, side, row) < 0) return 0;
    int32_t first = pdi_mechanical_bc_find_point_in_layer(g, i, side, g->held_layers[k]);
    return first >= 0 && !g->structure->prescribed[(int64_t)first * PD_DIM + d];
}

/* Iterator over the held points whose first free layer point i is interpolated from (the nearest ones). */
typedef struct pdi_mechanical_bc_reference_points {
    int distance_squared; /* [cell^2] squared distance from point i of the nearest ones */
    int count;     /* 0: there are none */
    int positions, positions_per_axis; /* candidate positions around point i in all, and along one axis */
    int next;      /* index of the next candidate */
} pdi_mechanical_bc_reference_points;

/* Next point of the held layers around point i, in its layer and within as many cells as the side holds layers, no
 * farther off than any before, with a free layer behind it for component d; -1: none is left. Updates the iterator:
 * l->next, and count and distance of the nearest points met; a nearer one sets count to 1. */
static int32_t pdi_mechanical_bc_next_reference_point(const pd_mechanical_bc *g, int k, int32_t i, int d,
                                                      pdi_mechanical_bc_reference_points *l)
{
    const pd_solid_coupling *s = g->structure;
    int axis = g->setup->metal_body.mechanical_bc[k].side / 2;
    while (l->next < l->positions) {
        int square = 0, at[PD_DIM], rest = l->next++;
        pd_grid_index(s->grid, s->node[i], at);
        for (int a = 0; a < PD_DIM; a++) {
            if (a == axis) continue;
            int step = rest % l->positions_per_axis - g->held_layers[k];
            rest /= l->positions_per_axis;
            at[a] += step;
            square += step * step;
        }
        if (!pd_grid_is_inside(s->grid, at) || square > l->distance_squared) continue;
        int32_t other = s->point[pd_grid_node(s->grid, at)];
        if (other < 0 || !pdi_mechanical_bc_is_held(g, k, other) || !pdi_mechanical_bc_has_free_layer(g, k, other, d))
            continue;
        l->count = square < l->distance_squared ? 1 : l->count + 1;
        l->distance_squared = square;
        return other;
    }
    return -1;
}

/* Reference points of point i for component d: point i itself (positions 0), or, where the metal there is too thin for
 * a free layer, the nearest ones along the side within as many cells as the side holds layers, all that are equally
 * near. Returns an iterator with their count, 0: none; next is to be set to 0 to go through them. */
static pdi_mechanical_bc_reference_points pdi_mechanical_bc_find_reference_points(const pd_mechanical_bc *g, int k,
                                                                                  int32_t i, int d)
{
    pdi_mechanical_bc_reference_points l = {0, 1, 1, 2 * g->held_layers[k] + 1, 0};
    if (pdi_mechanical_bc_has_free_layer(g, k, i, d)) {
        l.next = l.positions = 0;
        return l;
    }
    for (int a = 1; a < PD_DIM; a++) l.positions *= l.positions_per_axis;
    l.distance_squared = PD_DIM * g->held_layers[k] * g->held_layers[k] + 1;
    l.count = 0;
    while (pdi_mechanical_bc_next_reference_point(g, k, i, d, &l) >= 0) {
    }
    return l;
}

/* Check that condition k has at least one point beside its side with a free layer behind the held ones on its lattice
 * line, for each component that the side prescribes. Shapes and bodies in dynamics need none. PD_ERR_GEOMETRY: there is
 * none. */
static pd_status pdi_mechanical_bc_check_free_layer(pd_ctx *ctx, const pd_mechanical_bc *g, int k)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    const pd_solid_coupling *s = g->structure;
    for (int d = 0; d < PD_DIM && grip->side >= 0 && !pd_solid_coupling_is_dynamic(s); d++) {
        int found = !grip->has_displacement[d];
        for (int32_t i = 0; i < s->count && !found; i++)
            found = pdi_mechanical_bc_get_layer(g, i, grip->side) == 0 && pdi_mechanical_bc_has_free_layer(g, k, i, d);
        if (!found)
            return pd_fail(ctx, PD_ERR_GEOMETRY, "grip",
                           "the side %s holds %d rows of nodes, two horizons, and no "
                           "line of metal has one more that is free behind them: choose a smaller h, or a grip",
                           pd_setup_side_name(grip->side), g->held_layers[k]);
    }
    return PD_OK;
}

/* The first connected run of metal along the lattice line of a point, from a side inward. */
typedef struct pdi_mechanical_bc_metal_run {
    int layer; /* layer of the point within the run */
    /* layers of the run, as far as they are counted; 0: the point is not loaded (deep, or behind a gap) */
    int layers;
    int spans_box;  /* 1: the run ends at the opposite side of the box */
    int has_mirror; /* 1: that side is a plane of symmetry */
    int thin;    /* 1: with its mirror image it is thinner than the surface layers of (14.5) of both faces together */
} pdi_mechanical_bc_metal_run;

/* Number of layers from a side in which points may carry a part of its traction. */
static int pdi_mechanical_bc_count_loaded_layers(const pd_mechanical_bc *g)
{
    return 2 * (int)ceil(g->structure->desc.horizon_ratio + 1.0);
}

/* The connected run of metal with stiffness that point i belongs to, from the side inward. layers is 0, and the point
 * carries no traction of that side, if it lies deeper than twice the loaded layers, has dissolved, was not connected to
 * the side at the start, or if metal is left between it and the side behind a gap. Layers are counted up to twice the
 * loaded ones. */
static pdi_mechanical_bc_metal_run pdi_mechanical_bc_find_metal_run(const pd_mechanical_bc *g, int32_t i, int side)
{
    pdi_mechanical_bc_metal_run run = {0, 0, 0, 0, 0};
    int row = pdi_mechanical_bc_get_layer(g, i, side), most = 2 * pdi_mechanical_bc_count_loaded_layers(g), first = row,
        last = row;
    if (row >= most || !(g->structure->stiffness_factor[i] > 0.0) ||
        !pdi_mechanical_bc_is_connected_to_side(g, i, side))
        return run;
    while (pdi_mechanical_bc_find_point_in_layer(g, i, side, first - 1) >= 0) first--;
    for (int front = first - 2; front >= 0; front--)
        if (pdi_mechanical_bc_find_point_in_layer(g, i, side, front) >= 0) return run;
    while (last + 1 - first < most && pdi_mechanical_bc_find_point_in_layer(g, i, side, last + 1) >= 0) last++;
    run.layer = row - first;
    run.layers = last - first + 1;
    run.spans_box = last == g->structure->grid->n[side / 2] - 1;
    run.has_mirror = run.spans_box && g->structure->desc.mirrors >> (side ^ 1) & 1;
    run.thin = (1 + run.has_mirror) * run.layers < 2 * pdi_mechanical_bc_count_held_layers(g);
    return run;
}

/* Correspondence and ordinary materials store c; for bond-based springs it is summed. */
PDI_FN double pdi_mechanical_bc_get_surface_coefficient(const pd_mechanical_bc *g, int32_t i, int side)
{
    const pd_solid_coupling *s = g->structure;
    double edge[PD_DIM];
    if (s->solid.surface_vector) memcpy(edge, s->solid.surface_vector + (int64_t)i * PD_DIM, sizeof edge);
    else pdi_microelastic_compute_edge(&s->bond_based, i, edge);
    return side % 2 ? -edge[side / 2] : edge[side / 2];
}

/* Load weights of a point for a traction on a side. */
typedef struct pdi_mechanical_bc_load_weights {
    double surface[PD_DIM];         /* [1/m] weight by c of (14.5) for each component: load density over traction */
    double takes_remainder[PD_DIM]; /* 1: the point takes part in the even distribution of the remaining load */
} pdi_mechanical_bc_load_weights;

/* Load weights of point i for the traction of condition k. Returns 1; 0: it carries none. In thick metal they are the c
 * of (14.5). In thinner metal the c of both faces overlap: if the opposite side holds a component, free layers carry
 * all of c, held layers the remainder; behind a plane of symmetry the image is the other part along the axis; else each
 * half carries its own c, and the remainder is spread evenly (theory: 14.9). */
static int pdi_mechanical_bc_compute_load_weights(const pd_mechanical_bc *g, int k, int32_t i,
                                                  pdi_mechanical_bc_load_weights *part)
{
    int side = g->setup->metal_body.mechanical_bc[k].side, axis = side / 2,
        depth = pdi_mechanical_bc_count_held_layers(g);
    pdi_mechanical_bc_metal_run run = pdi_mechanical_bc_find_metal_run(g, i, side);
    int rows = (1 + run.has_mirror) * run.layers, row = pdi_mechanical_bc_get_layer(g, i, side);
    int last = g->structure->grid->n[axis] - 1 - row < depth;
    double half = row >= pdi_mechanical_bc_count_loaded_layers(g) || 2 * run.layer >= rows ? 0.0
                  : 2 * run.layer + 1 == rows                                              ? 0.5
                                                                                           : 1.0;
    if (!run.layers || (!run.thin && !(half > 0.0))) return 0;
    double edge = pdi_mechanical_bc_get_surface_coefficient(g, i, side);
    for (int d = 0; d < PD_DIM; d++) {
        int held = run.thin && run.spans_box && g->opposite_held[k] >> d & 1;
        part->surface[d] = held ? (last ? 0.0 : edge) : half * edge;
        part->takes_remainder[d] = run.thin && (held ? last : !run.has_mirror || d != axis) ? 1.0 : 0.0;
    }
    return 1;
}

/* Sums over points for each component of the traction of condition k: bears [PD_DIM] [m^(d-1)], load weight times
 * volume, and spreads [PD_DIM] [m^d], the volume that takes the remainder. Fixed-point sums do not depend on the order
 * of points, so mirrored sides get the same bits. */
static void pdi_mechanical_bc_integrate_load_weights(const pd_mechanical_bc *g, int k, double *bears, double *spreads)
{
    int64_t units[PD_DIM] = {0}, points[PD_DIM] = {0};
    double cell = g->structure->body.volume[0];
    for (int32_t i = 0; i < g->structure->count; i++) {
        pdi_mechanical_bc_load_weights part;
        if (!pdi_mechanical_bc_compute_load_weights(g, k, i, &part)) continue;
        for (int d = 0; d < PD_DIM; d++) {
            units[d] +=
                (int64_t)llround(cell * part.surface[d] / g->initial_area[k] * PDI_MECHANICAL_BC_FIXED_POINT_SCALE);
            points[d] += part.takes_remainder[d] > 0.0;
        }
    }
    for (int d = 0; d < PD_DIM; d++) {
        bears[d] = (double)units[d] / PDI_MECHANICAL_BC_FIXED_POINT_SCALE * g->initial_area[k];
        spreads[d] = (double)points[d] * cell;
    }
}

/* Refuse metal too thin between a held and a loaded side for the ordinary (linear peridynamic solid) material in 2D and
 * 3D. PD_ERR_GEOMETRY: the run spans the box, the opposite side holds a component (under a pressure alone: the normal
 * one), and the run has fewer layers than 3/2 of the held ones and one more. PD_OK for all else. */
static pd_status pdi_mechanical_bc_check_thickness(pd_ctx *ctx, const pd_mechanical_bc *g, int k,
                                                   const pdi_mechanical_bc_metal_run *run)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    int side = grip->side, expected = 3 * pdi_mechanical_bc_count_held_layers(g) / 2 + 1;
    int both = grip->has_traction ? g->opposite_held[k] : g->opposite_held[k] & 1 << side / 2;
    if (PD_DIM == 1 || g->structure->desc.material != PD_SOLID_COUPLING_ORDINARY_STATE || !both || !run->spans_box ||
        run->layers >= expected)
        return PD_OK;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "grip",
                   "metal of %d cells between the side %s, which holds it, and %s, "
                   "which loads it, expected at least %d of the ordinary material: choose a smaller h, or another one",
                   run->layers, pd_setup_side_name(side ^ 1), pd_setup_side_name(side), expected);
}

/* Set opposite_held[k], the components that the opposite side holds, and weighted_area[k], the area that load weights
 * sum to at the start: the full area, or, where a run of metal is thin, that sum where it differs by more than 1e-9.
 * Without a traction or pressure only the full area is set. PD_ERR_GEOMETRY: metal too thin for the material. */
static pd_status pdi_mechanical_bc_set_initial_load_area(pd_ctx *ctx, pd_mechanical_bc *g, int k)
{
    const pd_setup_mechanics *b = &g->setup->metal_body;
    int side = b->mechanical_bc[k].side, thin = 0;
    double bears[PD_DIM], spreads[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) g->weighted_area[k][d] = g->initial_area[k];
    if (!b->mechanical_bc[k].has_traction && !b->mechanical_bc[k].has_pressure) return PD_OK;
    for (int other = 0; other < b->mechanical_bcs; other++)
        for (int d = 0; d < PD_DIM && b->mechanical_bc[other].side == (side ^ 1); d++)
            g->opposite_held[k] |= b->mechanical_bc[other].has_displacement[d] << d;
    for (int32_t i = 0; i < g->structure->count; i++) {
        if (pdi_mechanical_bc_get_layer(g, i, side) > 0) continue;
        pdi_mechanical_bc_metal_run run = pdi_mechanical_bc_find_metal_run(g, i, side);
        PD_TRY(pdi_mechanical_bc_check_thickness(ctx, g, k, &run));
        thin = thin || run.thin;
    }
    if (thin) pdi_mechanical_bc_integrate_load_weights(g, k, bears, spreads);
    for (int d = 0; d < PD_DIM && thin; d++)
        if (fabs(bears[d] - g->initial_area[k]) > PDI_MECHANICAL_BC_SUM_TOLERANCE * g->initial_area[k])
            g->weighted_area[k][d] = bears[d];
    return PD_OK;
}

/* How the load weights of a traction are scaled now, as metal has dissolved. */
typedef struct pdi_mechanical_bc_load_scaling {
    double scale[PD_DIM];  /* [-] factor on weights by c */
    double remainder[PD_DIM]; /* [1/m] weight of points that take the remainder */
    double total[PD_DIM];     /* [-] sum of all weights times volumes, over the area */
} pdi_mechanical_bc_load_scaling;

/* Scale load weights of condition k so that the total force is that on the initial area, into all of *shares.
 * PD_ERR_STATE: too little metal is left: for a component, at most 1 % of the initial weights, or, where these were at
 * most 1 % of the area, no point that takes the remainder. t [s] is for the message. */
static pd_status pdi_mechanical_bc_compute_load_scaling(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t,
                                                        pdi_mechanical_bc_load_scaling *shares)
{
    double bears[PD_DIM], spreads[PD_DIM], area = g->initial_area[k];
    memset(shares, 0, sizeof *shares);
    pdi_mechanical_bc_integrate_load_weights(g, k, bears, spreads);
    for (int d = 0; d < PD_DIM; d++) {
        double borne = g->weighted_area[k][d];
        int bearing = fabs(borne) > PDI_MECHANICAL_BC_MIN_METAL_FRACTION * area;
        if (bearing ? !(bears[d] / borne > PDI_MECHANICAL_BC_MIN_METAL_FRACTION) : !(spreads[d] > 0.0))
            return pd_fail(ctx, PD_ERR_STATE, "grip",
                           "too little metal is left at the side %s to bear its traction "
                           "at t = %g s",
                           pd_setup_side_name(g->setup->metal_body.mechanical_bc[k].side), t);
        shares->scale[d] =
            bearing && fabs(bears[d] - borne) > PDI_MECHANICAL_BC_SUM_TOLERANCE * area ? borne / bears[d] : 1.0;
        shares->remainder[d] = spreads[d] > 0.0 ? (area - borne) / spreads[d] : 0.0;
        shares->total[d] = spreads[d] > 0.0 ? 1.0 : borne / area;
    }
    return PD_OK;
}

/* [1/m] Scaled load weight of a point for component d: load density [N/m3] over traction [Pa]. */
static double pdi_mechanical_bc_get_load_weight(const pdi_mechanical_bc_load_scaling *shares,
                                                const pdi_mechanical_bc_load_weights *part, int d)
{
    return shares->scale[d] * part->surface[d] + shares->remainder[d] * part->takes_remainder[d];
}

PDI_FN void pdi_mechanical_bc_list(pdi_array_visitor *owner, void *object)
{
    pd_mechanical_bc *grips = (pd_mechanical_bc *)object;
    PDI_ARRAY(owner, grips, interpolation.row, grips->interpolation_capacity, "");
}

PDI_FN void pdi_mechanical_bc_free(pd_ctx *ctx, pd_mechanical_bc *g)
{
    pdi_array_registry_free(ctx, pdi_mechanical_bc_list, g);
    memset(g, 0, sizeof *g);
}

PDI_FN pd_status pdi_mechanical_bc_build(pd_ctx *ctx, const pd_setup *setup, pd_solid_coupling *structure,
                                         pd_mechanical_bc *g)
{
    const pd_setup_mechanics *b = &setup->metal_body;
    memset(g, 0, sizeof *g);
    g->setup = setup;
    g->structure = structure;
    for (int k = 0; k < b->mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &b->mechanical_bc[k];
        double face = grip->side >= 0 ? structure->body.volume[0] / structure->grid->h[grip->side / 2] : 0.0;
        int32_t held = 0;
        if (grip->side >= 0) g->held_layers[k] = pdi_mechanical_bc_count_held_layers(g);
        for (int32_t i = 0; i < structure->count; i++) {
            if (!pdi_mechanical_bc_is_held(g, k, i)) continue;
            held += grip->side < 0 || pdi_mechanical_bc_get_layer(g, i, grip->side) == 0;
            for (int d = 0; d < PD_DIM; d++)
                if (grip->has_displacement[d]) structure->prescribed[(int64_t)i * PD_DIM + d] = 1;
            for (int d = 0; d < PD_DIM && grip->side >= 0 && !pd_solid_coupling_is_dynamic(structure); d++)
                g->interpolation_capacity += grip->has_displacement[d];
        }
        g->initial_area[k] = face * held;
        if (held) continue;
        if (grip->side >= 0)
            return pd_fail(ctx, PD_ERR_GEOMETRY, "grip", "no metal on the side %s, expected some that it holds or "
                           "loads", pd_setup_side_name(grip->side));
        return pd_fail(ctx, PD_ERR_GEOMETRY, "grip", "no metal in a shape that is to hold it");
    }
    for (int k = 0; k < b->mechanical_bcs; k++) PD_TRY(pdi_mechanical_bc_check_free_layer(ctx, g, k));
    for (int k = 0; k < b->mechanical_bcs; k++) PD_TRY(pdi_mechanical_bc_set_initial_load_area(ctx, g, k));
    structure->static_solver.desc.interpolation = &g->interpolation;
    return pdi_array_registry_build(ctx, pdi_mechanical_bc_list, g);
}

/* Check that a prescribed displacement, traction or force is below 1e100 in size (grip NULL: a body force); x [m] and t
 * [s] are for the message. PD_ERR_STATE: it is not, or NaN. */
static pd_status pdi_mechanical_bc_check_finite(pd_ctx *ctx, const pd_setup_mechanical_bc *grip, double value,
                                                const double *x, double t)
{
    char of[40] = "a force on all metal";
    if (fabs(value) < 1e100) return PD_OK;
    if (grip && grip->side < 0) snprintf(of, sizeof of, "a displacement of a grip");
    if (grip && grip->side >= 0)
        snprintf(of, sizeof of, "a displacement or load of %s", pd_setup_side_name(grip->side));
    return pd_fail(ctx, PD_ERR_STATE, "grip", "%s is %g at x = %g m, t = %g s, expected a finite number", of, value,
                   x[0], t);
}

PDI_FN int pdi_mechanical_bc_find_sides(const pd_mechanical_bc *g, int32_t i, int d, int *holders)
{
    int count = 0;
    for (int k = 0; k < g->setup->metal_body.mechanical_bcs; k++) {
        const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
        if (grip->side < 0 || !grip->has_displacement[d] || !pdi_mechanical_bc_is_held(g, k, i)) continue;
        int at = 0;
        while (at < count && g->setup->metal_body.mechanical_bc[holders[at]].side / 2 != grip->side / 2) at++;
        holders[at] = k;
        if (at == count) count++;
    }
    return count;
}

/* Prescribed displacement *given [m] of component d by condition k at time t [s]: of a side, at the projection of place
 * x [m] onto it. PD_ERR_STATE: it is not finite. */
static pd_status pdi_mechanical_bc_get_displacement(pd_ctx *ctx, const pd_mechanical_bc *g, int k, const double *x,
                                                    int d, double t, double *given)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    double at[PD_DIM];
    memcpy(at, x, sizeof at);
    if (grip->side >= 0) pdi_mechanical_bc_project_to_side(g, grip->side, at);
    *given = pdi_setup_eval_expr(&grip->displacement[d], at, t);
    return pdi_mechanical_bc_check_finite(ctx, grip, *given, at, t);
}

/* Displacement component d of point i in the held layers of two or three sides at once, where no layer is free: blends
 * the prescribed fields U_a + U_b - (U_a(0) + U_b(0))/2 (theory: eq. 14.21); of three sides, the mean over pairs.
 * Writes u[i PD_DIM + d] [m]. */
static pd_status pdi_mechanical_bc_set_corner_displacement(pd_ctx *ctx, const pd_mechanical_bc *g, const int *holders,
                                                           int count, int32_t i, int d, double t, double *u)
{
    double x[PD_DIM], sum = 0.0;
    int pairs = count * (count - 1) / 2;
    pd_grid_position(g->structure->grid, g->structure->node[i], x);
    for (int b = 1; b < count && b < PD_DIM; b++)
        for (int a = 0; a < b; a++) {
            double edge[PD_DIM], of_a, of_b, edge_a, edge_b;
            memcpy(edge, x, sizeof edge);
            pdi_mechanical_bc_project_to_side(g, g->setup->metal_body.mechanical_bc[holders[a]].side, edge);
            pdi_mechanical_bc_project_to_side(g, g->setup->metal_body.mechanical_bc[holders[b]].side, edge);
            PD_TRY(pdi_mechanical_bc_get_displacement(ctx, g, holders[a], x, d, t, &of_a));
            PD_TRY(pdi_mechanical_bc_get_displacement(ctx, g, holders[b], x, d, t, &of_b));
            PD_TRY(pdi_mechanical_bc_get_displacement(ctx, g, holders[a], edge, d, t, &edge_a));
            PD_TRY(pdi_mechanical_bc_get_displacement(ctx, g, holders[b], edge, d, t, &edge_b));
            sum += (of_a + of_b - 0.5 * (edge_a + edge_b)) / pairs;
        }
    u[(int64_t)i * PD_DIM + d] = fabs(sum) < PDI_MECHANICAL_BC_MIN_DISPLACEMENT ? 0.0 : sum;
    return PD_OK;
}

/* Set the components of u [points][PD_DIM] [m] of point i that condition k prescribes, at its face or place; the others
 * stay. Displacements below 1e-100 m become 0. PD_ERR_STATE: one is not finite. */
static pd_status pdi_mechanical_bc_set_displacement(pd_ctx *ctx, const pd_mechanical_bc *g, int k, int32_t i, double t,
                                                    double *u)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    double x[PD_DIM];
    pd_grid_position(g->structure->grid, g->structure->node[i], x);
    for (int d = 0; d < PD_DIM; d++) {
        double value;
        if (!grip->has_displacement[d]) continue;
        PD_TRY(pdi_mechanical_bc_get_displacement(ctx, g, k, x, d, t, &value));
        u[(int64_t)i * PD_DIM + d] = fabs(value) < PDI_MECHANICAL_BC_MIN_DISPLACEMENT ? 0.0 : value;
    }
    return PD_OK;
}

/* Make room for one more interpolation row: doubles the array where it is full, and does nothing otherwise. As metal
 * dissolves, a point may get more reference points than at the start. After an error the rows are as before. */
static pd_status pdi_mechanical_bc_grow_interpolation(pd_ctx *ctx, pd_mechanical_bc *g)
{
    pd_constraint_row *row = NULL;
    if (g->interpolation.count < g->interpolation_capacity) return PD_OK;
    int64_t led = 2 * g->interpolation_capacity;
    PD_TRY(PD_NEW(ctx, "grip", led, row));
    memcpy(row, g->interpolation.row, (size_t)g->interpolation_capacity * sizeof *row);
    PD_DELETE(ctx, g->interpolation_capacity, g->interpolation.row);
    g->interpolation.row = row;
    g->interpolation_capacity = led;
    return PD_OK;
}

/* Add an interpolation row: component d of held point i follows the first free layer on the line of `leader` with
 * weight share y/Y, y and Y the depths of the point and of that layer. Subtracts that part of the prescribed value from
 * u. */
static pd_status pdi_mechanical_bc_add_interpolation(pd_ctx *ctx, pd_mechanical_bc *g, int k, int32_t i, int32_t leader,
                                                     int d, double share, double t, double *u)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    double x[PD_DIM], given;
    PD_TRY(pdi_mechanical_bc_grow_interpolation(ctx, g));
    pd_constraint_row *row = g->interpolation.row + g->interpolation.count++;
    row->follower = (int64_t)i * PD_DIM + d;
    row->leader = (int64_t)pdi_mechanical_bc_find_point_in_layer(g, leader, grip->side, g->held_layers[k]) * PD_DIM + d;
    row->coefficient = share * (pdi_mechanical_bc_get_layer(g, i, grip->side) + 0.5) / (g->held_layers[k] + 0.5);
    row->near_boundary = pdi_mechanical_bc_get_layer(g, i, grip->side) == 0;
    pd_grid_position(g->structure->grid, g->structure->node[leader], x);
    PD_TRY(pdi_mechanical_bc_get_displacement(ctx, g, k, x, d, t, &given));
    if (fabs(given) >= PDI_MECHANICAL_BC_MIN_DISPLACEMENT) u[row->follower] -= row->coefficient * given;
    return PD_OK;
}

/* Component d of point i in the held layers of condition k. Two or more sides that hold it: their blend. Else adds rows
 * of linear interpolation between the face and the first free layer, as the mean over all nearest reference points;
 * without any the prescribed value stays. Does nothing for shapes and bodies in dynamics. */
static pd_status pdi_mechanical_bc_interpolate_held(pd_ctx *ctx, pd_mechanical_bc *g, int k, int32_t i, int d, double t,
                                                    double *u)
{
    if (g->setup->metal_body.mechanical_bc[k].side < 0 || pd_solid_coupling_is_dynamic(g->structure)) return PD_OK;
    int holders[PD_DIM], count = pdi_mechanical_bc_find_sides(g, i, d, holders);
    if (count > 1) return pdi_mechanical_bc_set_corner_displacement(ctx, g, holders, count, i, d, t, u);
    pdi_mechanical_bc_reference_points l = pdi_mechanical_bc_find_reference_points(g, k, i, d);
    if (l.count && !l.positions) return pdi_mechanical_bc_add_interpolation(ctx, g, k, i, i, d, 1.0, t, u);
    double share = 1.0 / l.count;
    l.next = 0;
    for (int32_t leader = 0; l.count && (leader = pdi_mechanical_bc_next_reference_point(g, k, i, d, &l)) >= 0;)
        PD_TRY(pdi_mechanical_bc_add_interpolation(ctx, g, k, i, leader, d, share, t, u));
    return PD_OK;
}

/* Set all prescribed displacements of u [points][PD_DIM] [m] at time t [s] and rebuild the interpolation rows; then u
 * of a follower includes the part that its leader has now. Where several conditions hold a component of a point, the
 * last one named decides. PD_ERR_STATE: a displacement is not finite. */
static pd_status pdi_mechanical_bc_set_displacements(pd_ctx *ctx, pd_mechanical_bc *g, double t, double *u)
{
    const pd_setup_mechanics *b = &g->setup->metal_body;
    g->interpolation.count = 0;
    for (int32_t i = 0; i < g->structure->count; i++) {
        int last[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) last[d] = -1;
        for (int k = 0; k < b->mechanical_bcs; k++) {
            if (!pdi_mechanical_bc_is_held(g, k, i)) continue;
            PD_TRY(pdi_mechanical_bc_set_displacement(ctx, g, k, i, t, u));
            for (int d = 0; d < PD_DIM; d++)
                if (b->mechanical_bc[k].has_displacement[d]) last[d] = k;
        }
        for (int d = 0; d < PD_DIM; d++)
            if (last[d] >= 0) PD_TRY(pdi_mechanical_bc_interpolate_held(ctx, g, last[d], i, d, t, u));
    }
    for (int64_t k = 0; k < g->interpolation.count; k++) {
        const pd_constraint_row *row = g->interpolation.row + k;
        u[row->follower] += row->coefficient * u[row->leader];
    }
    return PD_OK;
}

/* Traction vector pull [PD_DIM] [Pa] of condition k at place x [m] of its side, and its norm *size [Pa]. A positive
 * pressure is included along the inward normal. PD_ERR_STATE: not finite. */
static pd_status pdi_mechanical_bc_compute_traction(pd_ctx *ctx, const pd_mechanical_bc *g, int k, const double *x,
                                                    double t, double *pull, double *size)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    for (int d = 0; d < PD_DIM; d++) {
        pull[d] = grip->has_traction ? pdi_setup_eval_expr(&grip->traction[d], x, t) : 0.0;
        if (grip->has_pressure && d == grip->side / 2)
            pull[d] += (grip->side % 2 ? -1.0 : 1.0) * pdi_setup_eval_expr(&grip->pressure, x, t);
        PD_TRY(pdi_mechanical_bc_check_finite(ctx, grip, pull[d], x, t));
    }
    *size = pdi_vec_norm(pull);
    return PD_OK;
}

/* Does the traction or pressure of condition k depend on the place along the side? 1 or 0; the coordinate along the
 * normal and time do not count. */
static int pdi_mechanical_bc_is_nonuniform(const pd_mechanical_bc *g, int k)
{
    const pd_setup_mechanical_bc *grip = &g->setup->metal_body.mechanical_bc[k];
    uint32_t uses = grip->has_pressure ? grip->pressure.variables_used : 0, places = ((uint32_t)1 << PD_DIM) - 1;
    for (int d = 0; d < PD_DIM && grip->has_traction; d++) uses |= grip->traction[d].variables_used;
    return (uses & places & ~((uint32_t)1 << grip->side / 2)) != 0;
}

/* Force and moments of a nonuniform traction against those of its nodal loads. The basis functions along the side are
 * 1 and (x - centre)/size: indices [0] and [1 + axis]. */
typedef struct pdi_mechanical_bc_resultants {
    double centre[PD_DIM], size;         /* [m] centre of the loaded faces, and a length: the largest side of the box */
    /* [N] moments of the traction less those of nodal loads, by basis function */
    double moment_deficit[PD_DIM][1 + PD_DIM];
    /* [N] moments of nodal loads with the distance from the side, over `size`, */
    double depth_moment[PD_DIM];
    double depth_moment_slope[PD_DIM][1 + PD_DIM]; /* [N] and their derivatives with respect to the corrections */
    /* [N] Gram matrix: derivatives of moments with respect to corrections */
    double moment_slope[PD_DIM][1 + PD_DIM][1 + PD_DIM];
    /* [-] corrections: coefficients of the basis, over the size of the traction */
    double correction[PD_DIM][1 + PD_DIM];
} pdi_mechanical_bc_resultants;

/* Basis functions 1 and (x - centre)/size along the side at place x [m], into basis [1 + PD_DIM]; axis: the normal of
 * the side. */
static void pdi_mechanical_bc_compute_moment_basis(const pdi_mechanical_bc_resultants *w, const double *x, int axis,
                                                   double *basis)
{
    basis[0] = 1.0;
    for (int d = 0; d < PD_DIM; d++) basis[1 + d] = d == axis ? 0.0 : (x[d] - w->centre[d]) / w->size;
}

/* Add a force [N] of component d, times the basis functions, to the moments that nodal loads lack, w->moment_deficit.
 */
static void pdi_mechanical_bc_add_resultant(pdi_mechanical_bc_resultants *w, int d, double force, const double *basis)
{
    for (int p = 0; p <= PD_DIM; p++) w->moment_deficit[d][p] += force * basis[p];
}

/* [m^(d-1)] Area of the faces of points beside the side of condition k that have not dissolved; a partly dissolved one
 * counts as whole. Also sets the centre of these faces (with mirror images: on the planes of symmetry) and the length
 * scale, the largest side of the box, in w, which is zero before. */
static double pdi_mechanical_bc_compute_loaded_area(const pd_mechanical_bc *g, int k, pdi_mechanical_bc_resultants *w)
{
    const pd_solid_coupling *s = g->structure;
    int side = g->setup->metal_body.mechanical_bc[k].side;
    double area = 0.0, face = s->body.volume[0] / s->grid->h[side / 2], x[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) w->size = pd_max(w->size, g->setup->hi[d] - g->setup->lo[d]);
    for (int32_t i = 0; i < s->count; i++) {
        if (pdi_mechanical_bc_get_layer(g, i, side) || !(s->stiffness_factor[i] > 0.0)) continue;
        pd_grid_position(s->grid, s->node[i], x);
        for (int d = 0; d < PD_DIM; d++) w->centre[d] += face * x[d];
        area += face;
    }
    for (int d = 0; d < PD_DIM && area > 0.0; d++) w->centre[d] /= area;
    for (int plane = 0; plane < 2 * PD_DIM; plane++)
        if (s->desc.mirrors >> plane & 1) pdi_mechanical_bc_project_to_side(g, plane, w->centre);
    return area;
}

/* Add force and moments of the exact traction, times shares->total, on the faces of all points beside the side that
 * have not dissolved, each of area `face` [m^(d-1)], to the deficit, by the two-point Gauss rule along each axis of the
 * side. PD_ERR_STATE: the traction is not finite. */
static pd_status pdi_mechanical_bc_add_traction_moments(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t,
                                                        double face, const pdi_mechanical_bc_load_scaling *shares,
                                                        pdi_mechanical_bc_resultants *w)
{
    const pd_solid_coupling *s = g->structure;
    int side = g->setup->metal_body.mechanical_bc[k].side, axis = side / 2;
    for (int32_t i = 0; i < s->count; i++) {
        if (pdi_mechanical_bc_get_layer(g, i, side) || !(s->stiffness_factor[i] > 0.0)) continue;
        for (int corner = 0; corner < 1 << PD_DIM; corner++) {
            double x[PD_DIM], pull[PD_DIM], basis[1 + PD_DIM], size;
            if (corner >> axis & 1) continue;
            pd_grid_position(s->grid, s->node[i], x);
            for (int b = 0; b < PD_DIM; b++) x[b] += (corner >> b & 1 ? 0.5 : -0.5) * sqrt(1.0 / 3.0) * s->grid->h[b];
            pdi_mechanical_bc_project_to_side(g, side, x);
            PD_TRY(pdi_mechanical_bc_compute_traction(ctx, g, k, x, t, pull, &size));
            pdi_mechanical_bc_compute_moment_basis(w, x, axis, basis);
            for (int d = 0; d < PD_DIM; d++)
                pdi_mechanical_bc_add_resultant(w, d, face / (1 << (PD_DIM - 1)) * shares->total[d] * pull[d], basis);
        }
    }
    return PD_OK;
}

/* Subtract force and moments of the nodal loads from w->moment_deficit, and add up the Gram matrix of corrections
 * (moment_slope) and the moments with the depth below the side, over w->size. Points without load weights are skipped.
 * PD_ERR_STATE: the traction is not finite. */
static pd_status pdi_mechanical_bc_subtract_nodal_moments(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t,
                                                          const pdi_mechanical_bc_load_scaling *shares,
                                                          pdi_mechanical_bc_resultants *w)
{
    const pd_solid_coupling *s = g->structure;
    int side = g->setup->metal_body.mechanical_bc[k].side, axis = side / 2;
    for (int32_t i = 0; i < s->count; i++) {
        double x[PD_DIM], pull[PD_DIM], size, basis[1 + PD_DIM];
        pdi_mechanical_bc_load_weights part;
        if (!pdi_mechanical_bc_compute_load_weights(g, k, i, &part)) continue;
        pd_grid_position(s->grid, s->node[i], x);
        double inside = x[axis];
        pdi_mechanical_bc_project_to_side(g, side, x);
        double depth = (inside - x[axis]) / w->size;
        PD_TRY(pdi_mechanical_bc_compute_traction(ctx, g, k, x, t, pull, &size));
        pdi_mechanical_bc_compute_moment_basis(w, x, axis, basis);
        for (int d = 0; d < PD_DIM; d++) {
            double bears = pdi_mechanical_bc_get_load_weight(shares, &part, d) * s->body.volume[i];
            pdi_mechanical_bc_add_resultant(w, d, -bears * pull[d], basis);
            w->depth_moment[d] += bears * pull[d] * depth;
            for (int p = 0; p <= PD_DIM; p++) {
                w->depth_moment_slope[d][p] += bears * size * basis[p] * depth;
                for (int q = 0; q <= PD_DIM; q++) w->moment_slope[d][p][q] += bears * size * basis[p] * basis[q];
            }
        }
    }
    return PD_OK;
}

/* 1: a correction of component d by basis function p is symmetric with respect to all planes of symmetry of the body;
 * component d changes sign across its own plane. */
static int pdi_mechanical_bc_is_symmetric(const pd_mechanical_bc *g, int d, int p)
{
    for (int axis = 0; axis < PD_DIM; axis++)
        if (g->structure->desc.mirrors >> 2 * axis & 3 && (p == 1 + axis) != (d == axis)) return 0;
    return 1;
}

/* Solve the small linear system for the corrections of component d, w->correction[d], by Gauss elimination; the deficit
 * of that component is overwritten. Basis functions along which the loaded points extend by less than about 0.1 cells,
 * or that break a symmetry, are left out, with the correction 0. */
static void pdi_mechanical_bc_solve_correction(const pd_mechanical_bc *g, int d, pdi_mechanical_bc_resultants *w)
{
    double a[1 + PD_DIM][1 + PD_DIM], *rest = w->moment_deficit[d], *more = w->correction[d];
    int done[1 + PD_DIM] = {0};
    memcpy(a, w->moment_slope[d], sizeof a);
    for (int p = 0; p <= PD_DIM; p++) {
        double least = p ? PDI_MECHANICAL_BC_MIN_EXTENT * g->structure->grid->h[p - 1] / w->size : 0.0;
        if (!pdi_mechanical_bc_is_symmetric(g, d, p) || !(a[p][p] > least * least * a[0][0])) continue;
        done[p] = 1;
        for (int q = p + 1; q <= PD_DIM; q++) {
            double factor = a[q][p] / a[p][p];
            for (int r = p; r <= PD_DIM; r++) a[q][r] -= factor * a[p][r];
            rest[q] -= factor * rest[p];
        }
    }
    for (int p = PD_DIM; p >= 0; p--) {
        if (!done[p]) continue;
        more[p] = rest[p];
        for (int q = p + 1; q <= PD_DIM; q++) more[p] -= a[p][q] * more[q];
        more[p] /= a[p][p];
    }
}

/* Sets the corrections in w, zero before, that give the nodal loads of a nonuniform traction its exact force and
 * moments: points near corners carry a traction from farther outside than it acts. Tangential components first, then
 * the normal one, which also balances the moment of tangential loads that act at a depth. Without metal at the side
 * they stay 0. */
static pd_status pdi_mechanical_bc_solve_traction_correction(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t,
                                                             const pdi_mechanical_bc_load_scaling *shares,
                                                             pdi_mechanical_bc_resultants *w)
{
    const pd_solid_coupling *s = g->structure;
    int axis = g->setup->metal_body.mechanical_bc[k].side / 2;
    double area = pdi_mechanical_bc_compute_loaded_area(g, k, w);
    if (!(area > 0.0)) return PD_OK;
    /* the load stays as metal goes */
    double face = s->body.volume[0] / s->grid->h[axis] * (g->initial_area[k] / area);
    PD_TRY(pdi_mechanical_bc_add_traction_moments(ctx, g, k, t, face, shares, w));
    PD_TRY(pdi_mechanical_bc_subtract_nodal_moments(ctx, g, k, t, shares, w));
    for (int b = 1; b < PD_DIM; b++) {
        int d = (axis + b) % PD_DIM;
        pdi_mechanical_bc_solve_correction(g, d, w);
        for (int p = 0; p <= PD_DIM; p++) w->depth_moment[d] += w->depth_moment_slope[d][p] * w->correction[d][p];
        w->moment_deficit[axis][1 + d] += w->depth_moment[d];
    }
    pdi_mechanical_bc_solve_correction(g, axis, w);
    return PD_OK;
}

PDI_FN pd_status pdi_mechanical_bc_add_traction(pd_ctx *ctx, const pd_mechanical_bc *g, int k, double t, double *load)
{
    const pd_solid_coupling *s = g->structure;
    int side = g->setup->metal_body.mechanical_bc[k].side, axis = side / 2,
        varies = pdi_mechanical_bc_is_nonuniform(g, k);
    pdi_mechanical_bc_resultants w;
    pdi_mechanical_bc_load_scaling shares;
    PD_TRY(pdi_mechanical_bc_compute_load_scaling(ctx, g, k, t, &shares));
    memset(&w, 0, sizeof w);
    if (varies) PD_TRY(pdi_mechanical_bc_solve_traction_correction(ctx, g, k, t, &shares, &w));
    for (int32_t i = 0; i < s->count; i++) {
        double x[PD_DIM], pull[PD_DIM], basis[1 + PD_DIM], size;
        pdi_mechanical_bc_load_weights part;
        if (!pdi_mechanical_bc_compute_load_weights(g, k, i, &part)) continue;
        pd_grid_position(s->grid, s->node[i], x);
        pdi_mechanical_bc_project_to_side(g, side, x);
        PD_TRY(pdi_mechanical_bc_compute_traction(ctx, g, k, x, t, pull, &size));
        if (varies) pdi_mechanical_bc_compute_moment_basis(&w, x, axis, basis);
        for (int d = 0; d < PD_DIM; d++) {
            for (int p = 0; p <= PD_DIM && varies; p++) pull[d] += w.correction[d][p] * basis[p] * size;
            load[(int64_t)i * PD_DIM + d] += pdi_mechanical_bc_get_load_weight(&shares, &part, d) * pull[d];
        }
    }
    return PD_OK;
}

/* A body force acts in proportion to the stiffness factor that is left. */
PDI_FN pd_status pdi_mechanical_bc_apply(pd_ctx *ctx, void *user, double t, double *u, double *load)
{
    pd_mechanical_bc *g = (pd_mechanical_bc *)user;
    const pd_setup_mechanics *b = &g->setup->metal_body;
    const pd_solid_coupling *s = g->structure;
    PD_TRY(pdi_mechanical_bc_set_displacements(ctx, g, t, u));
    for (int k = 0; k < b->mechanical_bcs; k++)
        if (b->mechanical_bc[k].has_traction || b->mechanical_bc[k].has_pressure)
            PD_TRY(pdi_mechanical_bc_add_traction(ctx, g, k, t, load));
    for (int32_t i = 0; i < s->count && b->has_body_force; i++) {
        double x[PD_DIM];
        if (!(s->stiffness_factor[i] > 0.0)) continue;
        pd_grid_position(s->grid, s->node[i], x);
        for (int d = 0; d < PD_DIM; d++) {
            double value = pdi_setup_eval_expr(&b->force[d], x, t);
            PD_TRY(pdi_mechanical_bc_check_finite(ctx, NULL, value, x, t));
            load[(int64_t)i * PD_DIM + d] += s->stiffness_factor[i] * value;
        }
    }
    return PD_OK;
}

PDI_FN double pdi_mechanical_bc_compute_rate_factor(void *user, const pd_local_stress_state *at)
{
    const pd_setup *u = (const pd_setup *)user;
    double vars[PD_SETUP_STRESS_VARS];
    vars[0] = at->pressure;
    vars[1] = at->mises;
    vars[2] = at->plastic_strain;
    memcpy(vars + 3, at->x, sizeof at->x);
    vars[3 + PD_DIM] = at->t;
    return pd_expr_eval(&u->metal_body.rate_factor, vars);
}

#undef PDI_MECHANICAL_BC_MIN_DISPLACEMENT
#undef PDI_MECHANICAL_BC_MIN_EXTENT
#undef PDI_MECHANICAL_BC_SUM_TOLERANCE
#undef PDI_MECHANICAL_BC_MIN_METAL_FRACTION
#undef PDI_MECHANICAL_BC_FIXED_POINT_SCALE
