/* inlet: see inlet.h */
#include "physics/inlet.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* The layer of nodes inside a side of the box: numbers, extent and mean inflow. */
typedef struct pdi_inlet_layer {
    int64_t open, solid;
    int lo, hi;     /* 2D: first and last open index along the side */
    double velocity; /* [m/s] mean inward velocity of the profile expression */
    double mean_magnitude; /* [m/s] mean of its absolute value */
} pdi_inlet_layer;

/* Set i [PD_DIM] to the first node in front of a side. Returns the face area of a cell there [m^(d-1)], without the
 * circumference of rings. */
static double pdi_inlet_set_first_node(const pd_grid *grid, int side, int *i)
{
    double face = 1.0;
    for (int d = 0; d < PD_DIM; d++) {
        i[d] = d == side / 2 && side % 2 ? grid->n[d] - 1 : 0;
        if (d != side / 2) face *= grid->h[d];
    }
    return face;
}

/* Advance i [PD_DIM] to the next node of the layer normal to `axis`. Returns 1; 0: the layer is done, and i is at its
 * first node again. */
static int pdi_inlet_set_next_node(const pd_grid *grid, int axis, int *i)
{
    for (int d = 0; d < PD_DIM; d++) {
        if (d == axis) continue;
        if (++i[d] < grid->n[d]) return 1;
        i[d] = 0;
    }
    return 0;
}

/* An expression flows in if its mean is above this fraction of the mean of its absolute value (rounding). */
#define PDI_INLET_MIN_INFLOW 1e-12
/* Samples along an axis for the open part of a cell face that a wall cuts. */
#define PDI_INLET_SAMPLES 32

/* 1 or -1: sign of the axis component of a velocity that flows in through a side. */
static double pdi_inlet_get_inward_sign(int side) { return side % 2 ? -1.0 : 1.0; }

/* Velocity u [PD_DIM] [m/s] of the profile expression of a side at x [m] and time t [s]. */
static void pdi_inlet_compute_expression(const pd_setup_side *side, const double *x, double t, double *u)
{
    for (int d = 0; d < PD_DIM; d++) u[d] = pdi_setup_eval_expr(&side->velocity[d], x, t);
}

/* Count the fluid (open) and solid nodes of the layer inside a side, and average its profile expression at time t [s],
 * taken on the side, over the area of the fluid ones, into all of *layer; without an expression or fluid the averages
 * are 0. lo and hi are set in 2D only. */
static void pdi_inlet_compute_layer(const pd_setup *setup, const pd_grid *grid, double t, int side,
                                    pdi_inlet_layer *layer)
{
    int i[PD_DIM], axis = side / 2, along = PD_DIM > 1 ? 1 - axis : 0;
    double sum = 0.0, size = 0.0, weight = 0.0;
    memset(layer, 0, sizeof *layer);
    pdi_inlet_set_first_node(grid, side, i);
    do {
        int32_t node = pd_grid_node(grid, i);
        layer->solid += grid->kind[node] == PD_SOLID;
        if (grid->kind[node] != PD_FLUID) continue;
        int s = PD_DIM == 2 ? i[along] : 0;
        if (layer->open == 0) layer->lo = s;
        layer->hi = s;
        layer->open++;
        double x[PD_DIM], u[PD_DIM];
        if (setup->side[side].profile != PD_PROFILE_EXPRESSION) continue;
        pd_grid_position(grid, node, x);
        x[axis] = side % 2 ? grid->hi[axis] : grid->lo[axis];
        pdi_inlet_compute_expression(&setup->side[side], x, t, u);
        sum += pdi_inlet_get_inward_sign(side) * u[axis] * pd_grid_circumference(grid, node);
        size += fabs(u[axis]) * pd_grid_circumference(grid, node);
        weight += pd_grid_circumference(grid, node);
    } while (pdi_inlet_set_next_node(grid, axis, i));
    if (!(weight > 0.0)) return;
    layer->velocity = sum / weight;
    layer->mean_magnitude = size / weight;
}

/* 2D: coordinate [m] along the side of the surface between the open node at index s and the closed one at s + step (1
 * or -1). The end of the box where that node lies outside; halfway where it is no wall, as beside solid; else the
 * surface of the wall shape: its entry on the line if smooth, by 60 bisections if not. */
static double pdi_inlet_find_wall_edge(const pd_grid *grid, int side, int s, int step)
{
    int axis = side / 2, along = PD_DIM > 1 ? 1 - axis : 0, i[PD_DIM];
    double x[PD_DIM], a, b;
    pdi_inlet_set_first_node(grid, side, i);
    i[along] = s;
    pd_grid_position(grid, pd_grid_node(grid, i), x);
    if (s + step < 0 || s + step >= grid->n[along]) return step < 0 ? grid->lo[along] : grid->hi[along];
    a = x[along];
    b = a + step * grid->h[along];
    i[along] = s + step;
    if (grid->kind[pd_grid_node(grid, i)] != PD_WALL) return 0.5 * (a + b);
    if (grid->wall >= 0 && pd_shape_is_smooth(grid->shapes, grid->wall)) {
        double way[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) way[d] = d == along ? b - a : 0.0;
        return a + pd_min(pdi_grid_find_shape_entry(grid, grid->wall, x, way, 1.0), 1.0) * (b - a);
    }
    for (int k = 0; k < 60 && grid->wall >= 0; k++) {
        x[along] = 0.5 * (a + b);
        if (pd_shape_distance(grid->shapes, grid->wall, x) > 0.0) a = x[along];
        else b = x[along];
    }
    return 0.5 * (a + b);
}

/* Radius [m] of a tube along `axis` among the wall shapes (complement of a cylinder, shape number `index` or its
 * parts), with its centre [PD_DIM] [m]. -1: there is none. */
static double pdi_inlet_find_tube_radius(const pd_grid *grid, int index, int axis, double *centre)
{
    const pd_shape *s = &grid->shapes[index];
    double radius = -1.0;
    if (s->type == PD_SHAPE_COMPLEMENT) {
        const pd_shape *c = &grid->shapes[s->child[0]];
        if (c->type != PD_SHAPE_CYLINDER || c->axis != axis) return -1.0;
        memcpy(centre, c->a, sizeof c->a);
        return c->radius;
    }
    for (int k = 0; k < s->child_count && s->type == PD_SHAPE_UNION && radius < 0.0; k++)
        radius = pdi_inlet_find_tube_radius(grid, s->child[k], axis, centre);
    return radius;
}

/* 1: a node in front of a side is fluid if and only if its distance from the axis through centre is below radius [m]:
 * the opening is that circle. */
static int pdi_inlet_is_circular(const pd_grid *grid, int side, const double *centre, double radius)
{
    int i[PD_DIM], axis = side / 2;
    pdi_inlet_set_first_node(grid, side, i);
    do {
        int32_t node = pd_grid_node(grid, i);
        double x[PD_DIM], square = 0.0;
        pd_grid_position(grid, node, x);
        for (int d = 0; d < PD_DIM; d++)
            if (d != axis) square += (x[d] - centre[d]) * (x[d] - centre[d]);
        if ((square < radius * radius) != (grid->kind[node] == PD_FLUID)) return 0;
    } while (pdi_inlet_set_next_node(grid, axis, i));
    return 1;
}

/* Report why an inlet side cannot be built. Returns PD_ERR_GEOMETRY. */
static pd_status pdi_inlet_reject(pd_ctx *ctx, int side, const char *why)
{
    return pd_fail(ctx, PD_ERR_GEOMETRY, "inlet", "side %s: %s", pd_setup_side_name(side), why);
}

/* Axisymmetric opening from lo to hi [m]: an annulus or tube across the axis, a cylinder along it. Sets centre, inner
 * radius and width of the side; *area: on entry its length [m], then [m2]. several: 1: the opening has gaps, and cell
 * rings are added up. */
static void pdi_inlet_measure_annulus(const pd_grid *grid, int side, double lo, double hi, int several, pd_inlet *inlet,
                                      double *area)
{
    int i[PD_DIM], axis = side / 2, r = PD_DIM - 1;
    if (axis == r) {
        *area *= 2.0 * PD_PI * (side % 2 ? grid->hi[r] : grid->lo[r]);
        return;
    }
    inlet->centre[side][r] = 0.0;
    inlet->inner_radius[side] = lo;
    inlet->width[side] = lo > 0.0 ? hi - lo : 2.0 * hi;
    *area = PD_PI * (hi - lo) * (hi + lo);
    pdi_inlet_set_first_node(grid, side, i);
    if (several) *area = 0.0;
    if (several) do {
            int32_t node = pd_grid_node(grid, i);
            if (grid->kind[node] == PD_FLUID) *area += pd_grid_circumference(grid, node) * grid->h[r];
        } while (pdi_inlet_set_next_node(grid, axis, i));
}

/* Open fraction [-] of the cell face around x [m] on a side with normal `axis`. Where the wall shape is within half a
 * diagonal of the face: by 32 samples along each axis, those on the surface counted as one half, on rings weighted by
 * the radius. Elsewhere, and without wall shapes, `fluid`: 1: its node is fluid. */
static double pdi_inlet_compute_open_fraction(const pd_grid *grid, int axis, const double *x, int fluid)
{
    double at[PD_DIM], reach = 0.0, open = 0.0, all = 0.0;
    int i[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) reach += d == axis ? 0.0 : 0.25 * grid->h[d] * grid->h[d];
    if (grid->wall < 0 || fabs(pd_shape_distance(grid->shapes, grid->wall, x)) > sqrt(reach)) return fluid;
    memset(i, 0, sizeof i);
    for (int more = 1; more;) {
        double around = 1.0;
        more = 0;
        for (int d = 0; d < PD_DIM; d++) {
            at[d] = d == axis ? x[d] : x[d] + ((i[d] + 0.5) / PDI_INLET_SAMPLES - 0.5) * grid->h[d];
            if (d == PD_DIM - 1 && grid->circumference) around = fabs(at[d] / x[d]);
        }
        all += around;
        double distance = pd_shape_distance(grid->shapes, grid->wall, at),
               tie = pd_shape_surface_tolerance(grid->h, at);
        open += distance > tie ? around : distance >= -tie ? 0.5 * around : 0.0; /* on a face: one half */
        for (int d = 0; d < PD_DIM && !more; d++) {
            if (d == axis) continue;
            more = ++i[d] < PDI_INLET_SAMPLES;
            if (!more) i[d] = 0;
        }
    }
    return open / all;
}

/* Area [m^(d-1)] of the open part of a side, with cut cell faces sampled: over fluid and wall nodes, so that solid
 * closes its faces. */
static double pdi_inlet_integrate_open_area(const pd_grid *grid, int side)
{
    int i[PD_DIM], axis = side / 2;
    double sum = 0.0, face = pdi_inlet_set_first_node(grid, side, i);
    do {
        double x[PD_DIM];
        int32_t node = pd_grid_node(grid, i);
        pd_grid_position(grid, node, x);
        x[axis] = side % 2 ? grid->hi[axis] : grid->lo[axis];
        if (grid->kind[node] == PD_FLUID || grid->kind[node] == PD_WALL)
            sum += face * pd_grid_circumference(grid, node) *
                   pdi_inlet_compute_open_fraction(grid, axis, x, grid->kind[node] == PD_FLUID);
    } while (pdi_inlet_set_next_node(grid, axis, i));
    return sum;
}

/* Planar 2D, for parabolas: an opening that ends on a mirror side (or any side that is neither wall nor periodic) is
 * half of a channel; width and centre become those of the whole. One that ends on a periodic side needs a solved
 * profile. One with walls at both ends stays. PD_ERR_GEOMETRY: both ends are no walls, so that no profile develops. */
static pd_status pdi_inlet_apply_symmetry(pd_ctx *ctx, const pd_grid *grid, int side, const pdi_inlet_layer *layer,
                                          pd_inlet *inlet)
{
    int along = PD_DIM > 1 ? 1 - side / 2 : 0, free[2];
    for (int end = 0; end < 2; end++)
        free[end] = (end ? layer->hi == grid->n[along] - 1 : layer->lo == 0) &&
                    grid->side[2 * along + end] != PD_SIDE_WALL;
    if (free[0] && free[1])
        return pdi_inlet_reject(ctx, side,
                                "found no wall beside the opening, so that no profile develops, expected "
                                "profile = uniform");
    if (!free[0] && !free[1]) return PD_OK;
    if (grid->side[2 * along + free[1]] == PD_SIDE_PERIODIC) {
        inlet->needs_profile[side] = 1;
        return PD_OK;
    }
    inlet->centre[side][along] += (free[0] ? -0.5 : 0.5) * inlet->width[side];
    inlet->width[side] *= 2.0;
    return PD_OK;
}

/* Measure the open part of a side: its *area [m^(d-1)], and in inlet its width, centre, inner radius and needs_profile
 * (1: a parabola has no closed form there: several openings in 2D, no circle in 3D). In 3D without a circle width is
 * the diameter of a circle of that area. PD_ERR_GEOMETRY: no open node; for a parabola: solid in the layer, 1D, or no
 * wall. */
static pd_status pdi_inlet_measure_opening(pd_ctx *ctx, const pd_grid *grid, int side, const pdi_inlet_layer *layer,
                                           pd_inlet *inlet, double *area)
{
    int axis = side / 2, along = PD_DIM > 1 ? 1 - axis : 0;
    int parabola = inlet->setup->side[side].profile == PD_PROFILE_PARABOLA;
    double face = 1.0, radius = -1.0;
    for (int d = 0; d < PD_DIM; d++)
        if (d != axis) face *= grid->h[d];
    *area = (double)layer->open * face;
    if (layer->open == 0) return pdi_inlet_reject(ctx, side, "the inlet is closed by wall or solid");
    if (parabola && layer->solid)
        return pdi_inlet_reject(ctx, side, "found solid in the inlet, expected it free for a parabola");
    if (PD_DIM == 1) {
        inlet->width[side] = grid->hi[0] - grid->lo[0];
        return parabola ? pdi_inlet_reject(ctx, side, "found profile = parabola in 1D, expected uniform") : PD_OK;
    }
    if (PD_DIM == 2) {
        double lo = pdi_inlet_find_wall_edge(grid, side, layer->lo, -1),
               hi = pdi_inlet_find_wall_edge(grid, side, layer->hi, 1);
        inlet->width[side] = hi - lo;
        inlet->centre[side][along] = 0.5 * (lo + hi);
        int several = layer->open != layer->hi - layer->lo + 1;
        if (!several) *area = hi - lo;
        else inlet->needs_profile[side] = parabola;
        if (!several && parabola && !grid->circumference)
            PD_TRY(pdi_inlet_apply_symmetry(ctx, grid, side, layer, inlet));
        if (PD_DIM == 2 && grid->circumference) pdi_inlet_measure_annulus(grid, side, lo, hi, several, inlet, area);
        return PD_OK;
    }
    if (grid->wall >= 0) radius = pdi_inlet_find_tube_radius(grid, grid->wall, axis, inlet->centre[side]);
    if (radius > 0.0 && pdi_inlet_is_circular(grid, side, inlet->centre[side], radius)) {
        inlet->width[side] = 2.0 * radius;
        *area = PD_PI * radius * radius;
        return PD_OK;
    }
    *area = pdi_inlet_integrate_open_area(grid, side);
    inlet->width[side] = sqrt(4.0 * *area / PD_PI);
    inlet->needs_profile[side] = parabola;
    return PD_OK;
}

/* Area [m^(d-1)] of the cell faces of a side that are open. */
static double pdi_inlet_compute_open_faces(const pd_grid *grid, int side)
{
    int i[PD_DIM], axis = side / 2;
    double sum = 0.0, face = pdi_inlet_set_first_node(grid, side, i);
    do {
        int32_t node = pd_grid_node(grid, i);
        double out = axis < PD_DIM - 1 ? 0.0 : side % 2 ? 0.5 * grid->h[axis] : -0.5 * grid->h[axis];
        if (grid->kind[node] == PD_FLUID) sum += face * pdi_grid_circumference_at(grid, node, out);
    } while (pdi_inlet_set_next_node(grid, axis, i));
    return sum;
}

/* Does any boundary value of the fluid or body force depend on time? 1 or 0. */
static int pdi_inlet_is_time_dependent(const pd_setup *setup)
{
    int timed = 0;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        const pd_setup_side *s = &setup->side[side];
        timed = timed || pd_setup_is_time_dependent(&s->inflow_of_time) || pd_setup_is_time_dependent(&s->inlet_c) ||
                pd_setup_is_time_dependent(&s->fixed_c);
        for (int d = 0; d < PD_DIM; d++)
            timed = timed || pd_setup_is_time_dependent(&s->velocity[d]) ||
                    pd_setup_is_time_dependent(&s->wall_velocity[d]);
    }
    for (int k = 0; k < setup->wall_count; k++)
        timed = timed || pd_setup_is_time_dependent(&setup->wall_shape[k].fixed_c);
    for (int d = 0; d < PD_DIM; d++) timed = timed || pd_setup_is_time_dependent(&setup->body_force[d]);
    return timed;
}

PDI_FN double pdi_inlet_get_mean_velocity(const pd_inlet *inlet, int side)
{
    const pd_setup_side *s = &inlet->setup->side[side];
    double at[PD_DIM] = {0.0};
    int timed = 0;
    if (s->inflow_of_time.variables_used)
        return pdi_setup_eval_expr(&s->inflow_of_time, at, inlet->time) /
               (s->flow_rate > 0.0 ? inlet->area[side] : 1.0);
    for (int d = 0; d < PD_DIM; d++) timed = timed || pd_setup_is_time_dependent(&s->velocity[d]);
    if (!timed) return inlet->mean[side];
    pdi_inlet_layer layer;
    pdi_inlet_compute_layer(inlet->setup, inlet->grid, inlet->time, side, &layer);
    return layer.velocity;
}

/* 1: the circular opening of a side lies within the box; mirror sides cut others. */
static int pdi_inlet_is_inside_box(const pd_grid *grid, int side, const pd_inlet *inlet)
{
    for (int d = 0; d < PD_DIM; d++) {
        double half = 0.5 * inlet->width[side] * (1.0 - 1e-9), c = inlet->centre[side][d];
        if (d != side / 2 && (c - half < grid->lo[d] || c + half > grid->hi[d])) return 0;
    }
    return 1;
}

/* Inner part of the build: resets *inlet and measures all inlet sides with a profile; error_side is the side at hand. A
 * flow rate in planar 2D is that through a tube of the width of the opening. PD_ERR_GEOMETRY: as of
 * pdi_inlet_measure_opening, or an expression with a mean whose inward mean is at most 1e-12 of the mean of its
 * size. */
static pd_status pdi_inlet_build_inner(pd_ctx *ctx, const pd_setup *setup, const pd_grid *grid, pd_inlet *inlet)
{
    memset(inlet, 0, sizeof *inlet);
    inlet->setup = setup;
    inlet->grid = grid;
    inlet->is_time_dependent = pdi_inlet_is_time_dependent(setup);
    inlet->first = -1;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        const pd_setup_side *s = &setup->side[side];
        pdi_inlet_layer layer;
        double area;
        if (s->kind != PD_SIDE_INLET || s->profile == PD_PROFILE_NONE) continue;
        inlet->error_side = side;
        pdi_inlet_compute_layer(setup, grid, 0.0, side, &layer);
        PD_TRY(pdi_inlet_measure_opening(ctx, grid, side, &layer, inlet, &area));
        double opening = PD_DIM == 3 && !pdi_inlet_is_inside_box(grid, side, inlet)
                             ? pdi_inlet_integrate_open_area(grid, side)
                             : area;
        inlet->opening[side] = area;
        if (PD_DIM == 2 && !grid->circumference && s->flow_rate > 0.0)
            area = 0.25 * PD_PI * inlet->width[side] * inlet->width[side];
        inlet->area[side] = area;
        inlet->area_ratio[side] = pdi_inlet_compute_open_faces(grid, side);
        inlet->area_ratio[side] = inlet->area_ratio[side] > 0.0 ? opening / inlet->area_ratio[side] : 1.0;
        inlet->mean[side] = s->flow_rate > 0.0 ? s->flow_rate / area : s->mean_speed;
        if (s->inflow_of_time.variables_used) inlet->mean[side] = pdi_inlet_get_mean_velocity(inlet, side);
        if (s->profile == PD_PROFILE_EXPRESSION && !s->is_scaled) inlet->mean[side] = layer.velocity;
        if (s->is_scaled && !(layer.velocity > PDI_INLET_MIN_INFLOW * layer.mean_magnitude))
            return pdi_inlet_reject(ctx, side,
                                    "the expression that a mean scales does not enter in the mean over the "
                                    "opening, expected one that does");
        if (s->is_scaled) inlet->scale[side] = inlet->area_ratio[side] / layer.velocity;
        if (inlet->first < 0) inlet->first = side;
        inlet->inlets++;
    }
    return PD_OK;
}

PDI_FN int64_t pdi_inlet_count_side_cells(const pd_grid *grid, int side)
{
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) cells *= d == side / 2 ? 1 : grid->n[d];
    return cells;
}

PDI_FN void pdi_inlet_free(pd_ctx *ctx, pd_inlet *inlet)
{
    for (int side = 0; side < 2 * PD_DIM && inlet->grid; side++)
        PD_DELETE(ctx, pdi_inlet_count_side_cells(inlet->grid, side), inlet->profile[side]);
}

PDI_FN pd_status pdi_inlet_build(pd_ctx *ctx, const pd_setup *setup, const pd_grid *grid, pd_inlet *inlet)
{
    pd_status status = pdi_inlet_build_inner(ctx, setup, grid, inlet);
    int latest = inlet->error_side;
    if (status < 0) memset(inlet, 0, sizeof *inlet);
    inlet->error_side = latest; /* the side that is refused */
    return status;
}

/* Fully developed velocity over its mean at s = r/R in a tube (k = 0) or an annulus with radius ratio k (White, Viscous
 * Fluid Flow, 3-3.3). */
static double pdi_inlet_compute_annulus_profile(double k, double s)
{
    if (!(k > 0.0)) return 2.0 * (1.0 - s * s);
    double a = (1.0 - k * k) / log(1.0 / k);
    return 2.0 * (1.0 - s * s + a * log(s)) / (1.0 + k * k - a);
}

/* Index of the cell in the layer of a side with normal `axis` that x [m] lies in front of; places beyond the layer
 * count to its last cells. */
static int64_t pdi_inlet_find_cell(const pd_grid *grid, int axis, const double *x)
{
    int64_t place = 0;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        int at = (int)floor((x[d] - grid->lo[d]) / grid->h[d]);
        if (d == axis) continue;
        at = at < 0 ? 0 : at >= grid->n[d] ? grid->n[d] - 1 : at;
        place = place * grid->n[d] + at;
    }
    return place;
}

PDI_FN void pdi_inlet_get_velocity(void *user, const double *x, double *u)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    const pd_setup *setup = inlet->setup;
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0;
    for (int side = 0; side < 2 * PD_DIM; side++) {
        int axis = side / 2;
        double beyond = side % 2 ? x[axis] - setup->hi[axis] : setup->lo[axis] - x[axis], square = 0.0;
        if (beyond <= 0.0) continue;
        const pd_setup_side *s = &setup->side[side];
        if (s->profile == PD_PROFILE_EXPRESSION) {
            double scale = s->is_scaled ? inlet->scale[side] * pdi_inlet_get_mean_velocity(inlet, side) : 1.0;
            pdi_inlet_compute_expression(s, x, inlet->time, u);
            for (int d = 0; d < PD_DIM; d++) u[d] *= scale;
            return;
        }
        u[axis] = pdi_inlet_get_inward_sign(side) *
                  (s->inflow_of_time.variables_used ? pdi_inlet_get_mean_velocity(inlet, side) : inlet->mean[side]);
        if (s->profile != PD_PROFILE_PARABOLA) {
            u[axis] *= inlet->area_ratio[side];
            return;
        }
        if (inlet->profile[side]) {
            u[axis] *= inlet->profile[side][pdi_inlet_find_cell(inlet->grid, axis, x)];
            return;
        }
        if (inlet->needs_profile[side]) return;
        if (setup->axisymmetric && axis != PD_DIM - 1) {
            double inner = inlet->inner_radius[side], width = inlet->width[side];
            double outer = inner > 0.0 ? inner + width : 0.5 * width;
            u[axis] *= pdi_inlet_compute_annulus_profile(inner / outer, x[PD_DIM - 1] / outer);
            return;
        }
        for (int d = 0; d < PD_DIM; d++) {
            double across = d == axis ? 0.0 : 2.0 * (x[d] - inlet->centre[side][d]) / inlet->width[side];
            square += across * across;
        }
        u[axis] *= (PD_DIM == 3 ? 2.0 : 1.5) * (1.0 - square);
        return;
    }
}

PDI_FN int pdi_inlet_is_inflow(void *user, int side, const double *x)
{
    const pd_setup *u = (const pd_setup *)user;
    if (!u->side[side].is_open) return u->side[side].kind == PD_SIDE_INLET;
    double v = pdi_setup_eval_expr(&u->initial_velocity[side / 2], x, 0.0);
    return side % 2 ? v < 0.0 : v > 0.0;
}

PDI_FN double pdi_inlet_get_concentration(void *user, const double *x)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    const pd_setup *u = inlet->setup;
    for (int s = 0; s < 2 * PD_DIM; s++) {
        int d = s / 2;
        int there = s % 2 ? x[d] >= u->hi[d] : x[d] <= u->lo[d];
        const pd_expr *entering = &u->side[s].inlet_c;
        if ((entering->code || entering->fn) && there) return pdi_setup_eval_expr(entering, x, inlet->time);
    }
    return u->inlet_c;
}

PDI_FN void pdi_inlet_compute_body_force(void *user, const double *x, double *force)
{
    const pd_inlet *inlet = (const pd_inlet *)user;
    for (int d = 0; d < PD_DIM; d++) force[d] = pdi_setup_eval_expr(&inlet->setup->body_force[d], x, inlet->time);
}
