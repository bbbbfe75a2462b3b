/* step_diagnostics: see step_diagnostics.h */
#include "physics/step_diagnostics.h"
#include <math.h>
#include <string.h>

#define PDI_STEP_DIAGNOSTICS_INFINITE_DISTANCE 1e30f /* [m2] squared distance where there is no fluid yet */

/* Exact Euclidean distance transform along a line of nodes: lower envelope of parabolas (Felzenszwalb and Huttenlocher
 * 2012, algorithm 1). */
typedef struct pdi_step_diagnostics_parabola_envelope {
    int32_t n, stride; /* nodes of the line, and between two of them */
    double spacing_squared; /* [m2] squared spacing */
    int32_t *parabola_node; /* [n] nodes whose parabolas form the envelope */
    double *interval_start; /* [n] [spacings] where their parts of it begin */
} pdi_step_diagnostics_parabola_envelope;

/* One-dimensional distance transform along a line: to[q] = min over p of from[p] + (distance of p and q)^2 [m2], both
 * squared distances; the infinite distance where all of `from` are. from and to are different arrays. w: work. */
static void pdi_step_diagnostics_distance_transform_line(const pdi_step_diagnostics_parabola_envelope *w,
                                                         const float *from, float *to)
{
    int32_t parts = 0, at = 0;
    for (int32_t q = 0; q < w->n; q++) {
        double value = (double)from[(int64_t)q * w->stride] / w->spacing_squared + (double)q * q, start = -HUGE_VAL;
        if (!(from[(int64_t)q * w->stride] < PDI_STEP_DIAGNOSTICS_INFINITE_DISTANCE)) continue;
        for (; parts; parts--) {
            int32_t v = w->parabola_node[parts - 1];
            start =
                (value - (double)from[(int64_t)v * w->stride] / w->spacing_squared - (double)v * v) / (2.0 * (q - v));
            if (start > w->interval_start[parts - 1]) break;
            start = -HUGE_VAL;
        }
        w->parabola_node[parts] = q;
        w->interval_start[parts++] = start;
    }
    for (int32_t q = 0; q < w->n; q++) {
        to[(int64_t)q * w->stride] = PDI_STEP_DIAGNOSTICS_INFINITE_DISTANCE;
        if (!parts) continue;
        while (at + 1 < parts && w->interval_start[at + 1] <= (double)q) at++;
        double way = (double)(q - w->parabola_node[at]);
        to[(int64_t)q * w->stride] =
            (float)(w->spacing_squared * way * way + (double)from[(int64_t)w->parabola_node[at] * w->stride]);
    }
}

/* Distance transform along all lines of one axis in the box, from [total] to another array [total] [m2]. w: work. */
static void pdi_step_diagnostics_distance_transform_axis(const pd_grid *grid, int axis,
                                                         pdi_step_diagnostics_parabola_envelope *w, const float *from,
                                                         float *to)
{
    w->n = grid->n[axis];
    w->stride = grid->stride[axis];
    w->spacing_squared = grid->h[axis] * grid->h[axis];
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        pd_grid_index(grid, node, i);
        if (i[axis] == 0 && pd_grid_is_inside(grid, i))
            pdi_step_diagnostics_distance_transform_line(w, from + node, to + node);
    }
}

/* Inner part of pdi_step_diagnostics_compute_depths: allocates work, which the caller frees, and transforms all axes.
 */
static pd_status pdi_step_diagnostics_compute_depths_inner(pd_ctx *ctx, const pd_grid *grid, int64_t longest,
                                                           pdi_step_diagnostics_parabola_envelope *w, float **work,
                                                           pd_step_diagnostics *o)
{
    PD_TRY(PD_NEW(ctx, "observe", o->nodes, *work));
    PD_TRY(PD_NEW(ctx, "observe", longest, w->parabola_node));
    PD_TRY(PD_NEW(ctx, "observe", longest, w->interval_start));
    for (int32_t i = 0; i < o->nodes; i++)
        o->initial_depth[i] = grid->kind[i] == PD_FLUID ? 0.0f : PDI_STEP_DIAGNOSTICS_INFINITE_DISTANCE;
    for (int axis = 0; axis < PD_DIM; axis++) {
        pdi_step_diagnostics_distance_transform_axis(grid, axis, w, o->initial_depth, *work);
        memcpy(o->initial_depth, *work, (size_t)o->nodes * sizeof **work);
    }
    for (int32_t i = 0; i < o->nodes; i++) o->initial_depth[i] = sqrtf(o->initial_depth[i]);
    return PD_OK;
}

/* Allocate o->initial_depth and set the Euclidean distance [m] of each node of the box from the nearest fluid node now,
 * 0 at fluid ones. Work is freed; after an error the caller frees initial_depth. */
static pd_status pdi_step_diagnostics_compute_depths(pd_ctx *ctx, const pd_grid *grid, pd_step_diagnostics *o)
{
    pdi_step_diagnostics_parabola_envelope way;
    float *work = NULL;
    int64_t longest = 1;
    memset(&way, 0, sizeof way);
    for (int d = 0; d < PD_DIM; d++) longest = grid->n[d] > longest ? grid->n[d] : longest;
    o->nodes = grid->total;
    PD_TRY(PD_NEW(ctx, "observe", o->nodes, o->initial_depth));
    pd_status status = pdi_step_diagnostics_compute_depths_inner(ctx, grid, longest, &way, &work, o);
    PD_DELETE(ctx, longest, way.interval_start);
    PD_DELETE(ctx, longest, way.parabola_node);
    PD_DELETE(ctx, o->nodes, work);
    return status;
}

/* Inner part of the build: resets o. Bond-based corrosion gets the initial depths. A flux error is computed (has_flux)
 * for a flow with exactly one inlet side whose mean velocity is not 0, with an outlet opposite and none elsewhere. */
static pd_status pdi_step_diagnostics_build_inner(pd_ctx *ctx, const pd_model *model, pd_step_diagnostics *o)
{
    const pd_setup *u = model->setup;
    int inlet = model->inlet.first, through = u->has_flow && model->inlet.inlets == 1;
    memset(o, 0, sizeof *o);
    if (u->has_corrode) PD_TRY(pdi_step_diagnostics_compute_depths(ctx, &model->grid, o));
    for (int s = 0; s < 2 * PD_DIM && through; s++)
        if (s != inlet) through = (u->side[s].kind == PD_SIDE_OUTLET) == (s / 2 == inlet / 2);
    if (!through || !(fabs(model->inlet.mean[inlet]) > 0.0)) return PD_OK;
    o->has_flux = 1;
    o->flux_axis = inlet / 2;
    o->flux_towards_plus = inlet % 2 == 0;
    o->layers = model->grid.n[o->flux_axis];
    return PD_NEW(ctx, "observe", o->layers, o->layer_flux);
}

pd_status pd_step_diagnostics_build(pd_ctx *ctx, const pd_model *model, pd_step_diagnostics *o)
{
    pd_status status = pdi_step_diagnostics_build_inner(ctx, model, o);
    if (status < 0) pd_step_diagnostics_free(ctx, o);
    return status;
}

void pd_step_diagnostics_free(pd_ctx *ctx, pd_step_diagnostics *o)
{
    PD_DELETE(ctx, o->layers, o->layer_flux);
    PD_DELETE(ctx, o->nodes, o->initial_depth);
    memset(o, 0, sizeof *o);
}

/* Largest speed and concentration at fluid nodes now, 0 without such a field or node; nodes just converted do not count
 * for the concentration. Corrosion depth: largest initial depth of a node that is fluid now, never below the last. */
static void pdi_step_diagnostics_compute_extremes(const pd_model *m, pd_step_diagnostics *o)
{
    int32_t total = m->grid.total;
    const double *c = m->transport.c, *u = pd_model_velocity(m);
    double c_max = 0.0, v_max = 0.0, front = o->corrosion_depth;
    for (int32_t i = 0; i < total; i++) {
        double square = 0.0;
        if (m->grid.kind[i] != PD_FLUID) continue;
        if (c && c[i] > c_max && !pd_model_is_undefined(m, PD_FIELD_C, i)) c_max = c[i];
        if (o->initial_depth && (double)o->initial_depth[i] > front) front = (double)o->initial_depth[i];
        for (int d = 0; d < PD_DIM && u; d++) square += u[(int64_t)d * total + i] * u[(int64_t)d * total + i];
        if (square > v_max) v_max = square;
    }
    o->c_max = c_max;
    o->v_max = sqrt(v_max);
    o->corrosion_depth = front;
}

/* Indices of two planes (between layers index - 1 and index), from 1 to n - 1: *low lies a quarter of the length before
 * the first solid from the low end of the axis, *high a quarter of that behind the last solid from the high end.
 * Without solid: at 1/4 and 3/4. */
static void pdi_step_diagnostics_choose_planes(const pd_grid *grid, int axis, int *low, int *high)
{
    int n = grid->n[axis], first = n, last = -1;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_SOLID) continue;
        pd_grid_index(grid, node, i);
        first = i[axis] < first ? i[axis] : first;
        last = i[axis] > last ? i[axis] : last;
    }
    *low = first / 4;
    *high = n - (n - 1 - last) / 4;
    if (*low < 1) *low = 1;
    if (*high > n - 1) *high = n - 1;
}

/* Volume flux [m^d/s] through each layer of nodes, towards +, from node velocities, into o->layer_flux: the sums of
 * pdi_flow_integrate_nodal_section in one sweep. */
static void pdi_step_diagnostics_compute_layer_fluxes(const pd_model *m, pd_step_diagnostics *o)
{
    const pd_grid *grid = &m->grid;
    double face = m->stencil.volume / grid->h[o->flux_axis];
    for (int32_t k = 0; k < o->layers; k++) o->layer_flux[k] = 0.0;
    for (int32_t node = 0; node < grid->total; node++) {
        int i[PD_DIM];
        if (grid->kind[node] != PD_FLUID) continue;
        pd_grid_index(grid, node, i);
        double area = face * pd_grid_circumference(grid, node);
        o->layer_flux[i[o->flux_axis]] += area * m->flow.u[(int64_t)o->flux_axis * grid->total + node];
    }
}

/* Relative difference of the conserved flux downstream and upstream of the solid, and largest deviation of the flux of
 * a layer from that of the layer behind the upstream plane; the worst so far are kept. With values in time they are
 * relative to the largest flux so far. Does nothing if the planes coincide. */
static void pdi_step_diagnostics_compute_flux_error(pd_ctx *ctx, pd_model *m, pd_step_diagnostics *o)
{
    int low, high;
    pdi_step_diagnostics_choose_planes(&m->grid, o->flux_axis, &low, &high);
    if (low >= high) return;
    int up = o->flux_towards_plus ? low : high, down = o->flux_towards_plus ? high : low;
    double before = pd_flow_integrate_section(ctx, &m->flow, o->flux_axis, up);
    double behind = pd_flow_integrate_section(ctx, &m->flow, o->flux_axis, down);
    pdi_step_diagnostics_compute_layer_fluxes(m, o);
    double reference = o->layer_flux[o->flux_towards_plus ? up : up - 1]; /* the layer behind the plane */
    double scale = fabs(before), wide = fabs(reference);
    if (m->inlet.is_time_dependent) { /* a stream that turns is at rest now and then */
        o->max_flux[0] = scale = pd_max(scale, o->max_flux[0]);
        o->max_flux[1] = wide = pd_max(wide, o->max_flux[1]);
    }
    o->flux_error = pd_max(o->flux_error, fabs(behind - before) / scale);
    for (int32_t k = 0; k < o->layers; k++)
        o->layer_flux_error = pd_max(o->layer_flux_error, fabs(o->layer_flux[k] - reference) / wide);
}

void pd_step_diagnostics_update(pd_ctx *ctx, pd_model *m, pd_step_diagnostics *o)
{
    o->volume_loss = pd_time_loop_volume_loss(&m->time_loop);
    pdi_step_diagnostics_compute_extremes(m, o);
    pd_model_statistics effort;
    pd_model_get_statistics(m, &effort);
    if (!o->has_flux || effort.flow_solves == o->flow_solves) return;
    o->flow_solves = effort.flow_solves;
    pdi_step_diagnostics_compute_flux_error(ctx, m, o);
}

pd_status pd_step_diagnostics_store(pd_ctx *ctx, pd_step_diagnostics *o, pd_archive *archive)
{
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "flux", &o->flux_error, 1));
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "largest flux", o->max_flux, 2));
    return PD_ARCHIVE_ARRAY(ctx, archive, "flux_max", &o->layer_flux_error, 1);
}

double pd_step_diagnostics_compute_peclet(const pd_model *m, const char **slowest)
{
    const pd_electrolyte *e = &m->setup->electrolyte;
    const pd_reactive *r = &m->reactive;
    double most = 0.0, least = HUGE_VAL;
    *slowest = "";
    if (!m->setup->has_chemistry || !r->flow) return 0.0;
    for (int k = 0; k < e->count; k++) {
        double d = e->species[k].diffusivity;
        if (r->components.solute_of_species[k] < 0 || !(d > 0.0) || !(d < least)) continue;
        least = d;
        *slowest = e->species[k].name;
    }
    for (int32_t i = 0; i < m->grid.total; i++)
        for (int d = 0; d < PD_DIM && m->grid.kind[i] == PD_FLUID; d++)
            most = pd_max(most, fabs(r->flow->u[(int64_t)d * m->grid.total + i]) * m->grid.h[d]);
    return most / least;
}

#undef PDI_STEP_DIAGNOSTICS_INFINITE_DISTANCE
