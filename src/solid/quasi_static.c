/* quasi_static: see quasi_static.h */
#include "solid/quasi_static.h"
#include "solid/body_bonds.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* [-] Default of break_fraction. */
#define PDI_QUASI_STATIC_DEFAULT_BREAK_FRACTION 0.5
/* Most iterations of boundary values that depend on the solution. */
#define PDI_QUASI_STATIC_MAX_ROUNDS 60
/* Bonds that a mechanism rotates by less than this share of the fastest one count as not moving. */
#define PDI_QUASI_STATIC_MIN_ROTATION 0.1
/* Most halvings of a load step. */
#define PDI_QUASI_STATIC_MAX_HALVINGS 8

PDI_FN void pdi_quasi_static_list(pdi_array_visitor *owner, void *object)
{
    pd_quasi_static *quasi_static = (pd_quasi_static *)object;
    PDI_ARRAY_STATE(owner, quasi_static, u, quasi_static->n, "m");
    PDI_ARRAY_STATE(owner, quasi_static, load, quasi_static->n, "N/m3");
    PDI_ARRAY_STATE(owner, quasi_static, force, quasi_static->n, "N/m3");
    PDI_ARRAY(owner, quasi_static, start, 2 * quasi_static->n, "1");
    PDI_ARRAY(owner, quasi_static, correction, 3 * quasi_static->n, "1");
    PDI_ARRAY(owner, quasi_static, saved, 3 * quasi_static->n, "1");
    PDI_ARRAY_ENTRY(owner, PDI_ARRAY_KIND_STATE, quasi_static, detached, quasi_static->n / PD_DIM, "1");
    PDI_SCALAR_STATE(owner, quasi_static, time, "s");
    PDI_SCALAR_STATE(owner, quasi_static, solved, "1");
    PDI_SCALAR_STATE(owner, quasi_static, stale, "1");
    PDI_SCALAR_STATE(owner, quasi_static, work, "J");
    PDI_SCALAR_STATE(owner, quasi_static, stored, "J");
    PDI_SCALAR_STATE(owner, quasi_static, released, "J");
    PDI_SCALAR_STATE(owner, quasi_static, dissolved_energy, "J");
    PDI_SCALAR_STATE(owner, quasi_static, separation_time, "s");
    PDI_SCALAR_STATE(owner, quasi_static, components, "1");
    PDI_SCALAR_STATE(owner, quasi_static, initial_components, "1");
    PDI_SCALAR_STATE(owner, quasi_static, broken, "1");
    PDI_SCALAR_STATE(owner, quasi_static, detached_points, "1");
    PDI_SCALAR_STATE(owner, quasi_static, solves, "1");
    PDI_SCALAR_STATE(owner, quasi_static, iterations, "1");
    PDI_SCALAR_STATE(owner, quasi_static, residual, "1");
}

pd_status pd_quasi_static_build(pd_ctx *ctx, const pd_material_interface *solid, const pd_quasi_static_desc *desc,
                                pd_quasi_static *q)
{
    memset(q, 0, sizeof *q);
    if (!(desc->break_fraction <= 1.0) || !(desc->rtol >= 0.0) || !(desc->rtol < 1.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "quasi_static",
                       "%g of what is beyond the criterion and rtol = %g: "
                       "expected 0 to 1",
                       desc->break_fraction, desc->rtol);
    q->desc = *desc;
    if (!(desc->break_fraction >= 0.0)) q->desc.break_fraction = PDI_QUASI_STATIC_DEFAULT_BREAK_FRACTION;
    q->solid = *solid;
    q->n = (int64_t)solid->body->count * PD_DIM;
    q->separation_time = -1.0;
    pd_status status = pdi_array_registry_build(ctx, pdi_quasi_static_list, q);
    if (status == PD_OK) status = pd_bond_failure_build(ctx, &q->solid, &desc->criterion, &q->criterion);
    if (status < 0) pd_quasi_static_free(ctx, q);
    return status;
}

void pd_quasi_static_free(pd_ctx *ctx, pd_quasi_static *q)
{
    pd_bond_failure_free(ctx, &q->criterion);
    pdi_array_registry_free(ctx, pdi_quasi_static_list, q);
    memset(q, 0, sizeof *q);
}

/* ---- loads ---- */

/* 1: component k is prescribed. */
static int pdi_quasi_static_is_held(const pd_quasi_static *q, int64_t k)
{
    return q->desc.prescribed && q->desc.prescribed[k];
}

/* Copies u, load and force into `saved`, before a move. */
static void pdi_quasi_static_save_state(pd_quasi_static *q)
{
    memcpy(q->saved, q->u, (size_t)q->n * sizeof *q->u);
    memcpy(q->saved + q->n, q->load, (size_t)q->n * sizeof *q->load);
    memcpy(q->saved + 2 * q->n, q->force, (size_t)q->n * sizeof *q->force);
}

/* Load step at the fraction `part`: corrects interpolated displacements in u, whose free leaders count in full. */
static void pdi_quasi_static_scale_interpolated(pd_quasi_static *q, double part)
{
    const pd_multipoint_constraint *all = q->desc.interpolation;
    for (int64_t k = 0; all && part < 1.0 && k < all->count; k++) {
        const pd_constraint_row *row = all->row + k;
        q->u[row->follower] += (1.0 - part) * row->coefficient * (q->u[row->leader] - q->start[row->leader]);
    }
}

/* Loads into load and prescribed displacements into u, at the fraction `part` (0 to 1) between `start` and time t: the
 * callback gives those of t, and both are interpolated linearly. load is 0 before the call; points that have come off
 * have no load at any fraction. Errors: of the callback. */
static pd_status pdi_quasi_static_set_loads(pd_ctx *ctx, pd_quasi_static *q, double t, double part)
{
    for (int64_t k = 0; k < q->n; k++) q->load[k] = 0.0;
    PD_TRY(q->desc.load(ctx, q->desc.user, t, q->u, q->load));
    for (int64_t k = 0; k < q->n; k++) {
        const double *start = q->start + k;
        if (part < 1.0) q->load[k] = start[q->n] + part * (q->load[k] - start[q->n]);
        if (q->detached[k / PD_DIM]) q->load[k] = 0.0;
        if (pdi_quasi_static_is_held(q, k)) q->u[k] = *start + part * (q->u[k] - *start);
    }
    pdi_quasi_static_scale_interpolated(q, part);
    return PD_OK;
}

/* 1: a component (piece [count]) lacks supports along an axis along which its loads do not balance, or they do work
 * along a free rigid motion; 0: it is held, they balance, or it has no loads. */
static int pdi_quasi_static_is_unsupported(const pd_quasi_static *q, const int32_t *piece, int32_t count)
{
    pd_rigid_modes rigid;
    for (int a = 0; a < PD_DIM; a++)
        if (!pdi_equilibrium_is_balanced(q->solid.body, q->desc.prescribed, q->load, a, piece, count, NULL)) return 1;
    pdi_rigid_modes_compute(q->solid.body, q->desc.prescribed, piece, count, &rigid);
    return pdi_equilibrium_has_unbalanced_moment(&q->solid, q->desc.prescribed, q->load, &rigid);
}

/* Point i comes off at time t [s]: its loads vanish, at the saved state too, so they do no work. Counts it, and sets
 * separation_time if it is the first one. */
static void pdi_quasi_static_detach_point(pd_quasi_static *q, int32_t i, double t)
{
    q->detached[i] = 1;
    for (int d = 0; d < PD_DIM; d++) q->load[(int64_t)i * PD_DIM + d] = q->saved[q->n + (int64_t)i * PD_DIM + d] = 0.0;
    q->detached_points++;
    if (q->separation_time < 0.0) q->separation_time = t;
}

/* 1: a component counts as a part of the body: it has more points than stencil_bonds of the body, the bonds of the
 * largest family, or one of its displacements is prescribed or loaded; 0: none of these. */
static int pdi_quasi_static_is_fragment(const pd_quasi_static *q, const int32_t *piece, int32_t count)
{
    if (count > q->solid.body->stencil_bonds) return 1;
    for (int32_t n = 0; n < count; n++)
        for (int d = 0; d < PD_DIM; d++) {
            int64_t k = (int64_t)piece[n] * PD_DIM + d;
            if (pdi_quasi_static_is_held(q, k) || fabs(q->load[k]) > 0.0) return 1;
        }
    return 0;
}

/* Components without supports against their loads lose these, unless one is the whole body. Counts the parts of the
 * body, into components and at first initial_components; a part that comes off, or more parts than at first, sets
 * separation_time to t unless it is set. */
static pd_status pdi_quasi_static_detach_components(pd_ctx *ctx, pd_quasi_static *q, double t)
{
    int32_t *piece = NULL, all = q->solid.body->count;
    uint8_t *seen = NULL;
    pd_status status = PD_NEW(ctx, "quasi_static", all, piece);
    if (status == PD_OK) status = PD_NEW(ctx, "quasi_static", all, seen);
    if (status == PD_OK) q->components = 0;
    for (int32_t i = 0; i < all && status == PD_OK; i++) {
        if (seen[i]) continue;
        int32_t count = pdi_body_bonds_find_component(q->solid.body, i, seen, piece);
        q->components += pdi_quasi_static_is_fragment(q, piece, count);
        if (count == all || !pdi_quasi_static_is_unsupported(q, piece, count)) continue;
        for (int32_t k = 0; k < count; k++) pdi_quasi_static_detach_point(q, piece[k], t);
    }
    PD_DELETE(ctx, all, piece);
    PD_DELETE(ctx, all, seen);
    if (!q->initial_components) q->initial_components = q->components;
    if (q->components > q->initial_components && q->separation_time < 0.0) q->separation_time = t;
    return status;
}

/* Largest |eta|/|xi| [1/m] by which a motion [n] rotates or stretches an unbroken bond of point i; 0: there is none. */
static double pdi_quasi_static_rotation_rate(const pd_body *body, int32_t i, const double *motion)
{
    double most = 0.0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) {
        double xi[PD_DIM], length = 0.0, way = 0.0;
        if (pd_body_bond_is_broken(&f)) continue;
        pdi_body_bond_vector(body, i, &f, xi);
        for (int d = 0; d < PD_DIM; d++) {
            double eta = motion[(int64_t)f.neighbour * PD_DIM + d] - motion[(int64_t)i * PD_DIM + d];
            length += xi[d] * xi[d];
            way += eta * eta;
        }
        most = pd_max(most, way / length);
    }
    return sqrt(most);
}

/* 1: the motion rotates bonds of point i at more than a tenth of the largest rate of all points, most [1/m]. */
static int pdi_quasi_static_is_rotating(const pd_quasi_static *q, int32_t i, const double *motion, double most)
{
    return pdi_quasi_static_rotation_rate(q->solid.body, i, motion) > PDI_QUASI_STATIC_MIN_ROTATION * most;
}

/* Points that a mechanism [n] rotates about a hinge come off at time t [s]. A body that rotates as a whole has no
 * hinge, and stays. Returns how many points; 0: none. */
static int32_t pdi_quasi_static_detach_mechanism(pd_quasi_static *q, const double *mechanism, double t)
{
    const pd_body *body = q->solid.body;
    double most = 0.0;
    int32_t count = 0, rests = 0;
    for (int32_t i = 0; i < body->count; i++) most = pd_max(most, pdi_quasi_static_rotation_rate(body, i, mechanism));
    for (int32_t i = 0; i < body->count && most > 0.0; i++)
        rests += q->detached[i] ||
                 (pdi_body_bonds_count_intact(body, i) && !pdi_quasi_static_is_rotating(q, i, mechanism, most));
    for (int32_t i = 0; i < body->count && rests; i++) {
        if (q->detached[i] || !pdi_quasi_static_is_rotating(q, i, mechanism, most)) continue;
        pdi_quasi_static_detach_point(q, i, t);
        count++;
    }
    return count;
}

/* ---- balance ---- */

/* Forces [N/m3] at the mean of the saved and the present displacements, into correction [n]; the next [n] hold that
 * mean. PD_RETRY: none, as the material is linear or has no such state. */
static pd_status pdi_quasi_static_midpoint_force(pd_ctx *ctx, pd_quasi_static *q)
{
    double *u = q->correction + q->n;
    if (q->solid.linear) return PD_RETRY;
    for (int64_t k = 0; k < q->n; k++) u[k] = 0.5 * (q->saved[k] + q->u[k]);
    return q->solid.force(ctx, q->solid.self, u, q->correction);
}

/* Adds the work [J] of loads and reactions from the saved state to this one to `work`: trapezoidal rule, or with the
 * midpoint forces in `correction` (curved 1) Simpson's rule. */
static void pdi_quasi_static_add_work(pd_quasi_static *q, int curved)
{
    const double *volume = q->solid.body->volume, *load = q->saved + q->n, *force = q->saved + 2 * q->n;
    pdi_compensated_sum all = {0.0, 0.0};
    for (int64_t k = 0; k < q->n; k++) {
        double mean = pdi_quasi_static_is_held(q, k) ? -0.5 * (q->force[k] + force[k]) : 0.5 * (q->load[k] + load[k]);
        if (curved) mean += (force[k] + q->force[k] - 2.0 * q->correction[k]) / 3.0;
        pdi_compensated_sum_add(&all, volume[k / PD_DIM] * mean * (q->u[k] - q->saved[k]));
    }
    q->work += pdi_compensated_sum_total(&all);
}

/* Solves for the equilibrium, into u, and again as long as a mechanism comes off (PD_ERR_DIVERGED, whose message is
 * then cleared); counts solves and iterations, sets residual. force becomes that of the saved state. Statuses: as of
 * pd_equilibrium_solve. */
static pd_status pdi_quasi_static_solve_equilibrium(pd_ctx *ctx, pd_quasi_static *q, double t)
{
    pd_status status = PD_ERR_DIVERGED;
    for (int turns = 1; turns;) {
        pd_equilibrium_desc desc;
        pd_equilibrium_result result;
        memset(&desc, 0, sizeof desc);
        desc.prescribed = q->desc.prescribed;
        desc.interpolation = q->desc.interpolation;
        desc.rtol = q->desc.rtol;
        desc.mechanism = q->force;
        status = pd_equilibrium_solve(ctx, &q->solid, &desc, q->load, q->u, &result);
        q->iterations += result.iterations;
        q->solves++;
        q->residual = result.residual;
        turns = status == PD_ERR_DIVERGED && pdi_quasi_static_detach_mechanism(q, q->force, t);
        if (!turns) continue;
        ctx->status = PD_OK; /* the next balance is without them */
        ctx->message[0] = '\0';
    }
    memcpy(q->force, q->saved + 2 * q->n, (size_t)q->n * sizeof *q->force);
    return status;
}

/* Internal forces at u, into force. PD_ERR_STATE: u is no state of the material. */
static pd_status pdi_quasi_static_compute_force(pd_ctx *ctx, pd_quasi_static *q)
{
    pd_status status = q->solid.force(ctx, q->solid.self, q->u, q->force);
    if (status <= PD_OK) return status;
    return pd_fail(ctx, PD_ERR_STATE, "quasi_static", "the balance at %g s is no state of the %s material", q->time,
                   q->solid.name);
}

/* Updates the material after bonds or stiffness have changed at fixed displacements: force and stored energy change,
 * and the energy lost [J] is added to *taken. stale becomes 0. */
static pd_status pdi_quasi_static_update_material(pd_ctx *ctx, pd_quasi_static *q, double *taken)
{
    double was = q->stored;
    PD_TRY(q->solid.update(ctx, q->solid.self));
    PD_TRY(pdi_quasi_static_compute_force(ctx, q));
    q->stored = q->solid.energy(ctx, q->solid.self, q->u);
    *taken += was - q->stored;
    q->stale = 0;
    return PD_OK;
}

/* 1: an entry of a and b [n] differs by more than rtol (0: its default) times the largest absolute entry of both; 0:
 * they agree. */
static int pdi_quasi_static_differs(const pd_ctx *ctx, const pd_quasi_static *q, const double *a, const double *b)
{
    double near = q->desc.rtol > 0.0 ? q->desc.rtol : PD_EQUILIBRIUM_RTOL;
    near *= pd_max(pdi_par_max_abs(ctx, q->n, a), pdi_par_max_abs(ctx, q->n, b));
    for (int64_t k = 0; k < q->n; k++)
        if (fabs(a[k] - b[k]) > near) return 1;
    return 0;
}

/* *differs: 1: prescribed displacements or loads at time t are not those of the present solution. Corrections of
 * prescribed displacements into correction [n], whose other parts are work; new loads into load; u stays. */
static pd_status pdi_quasi_static_check_boundary(pd_ctx *ctx, pd_quasi_static *q, double t, double part, int *differs)
{
    double *u = q->correction + q->n, *load = q->correction + 2 * q->n;
    memcpy(u, q->u, (size_t)q->n * sizeof *u);
    memcpy(load, q->load, (size_t)q->n * sizeof *load);
    PD_TRY(pdi_quasi_static_set_loads(ctx, q, t, part));
    *differs = pdi_quasi_static_differs(ctx, q, u, q->u) || pdi_quasi_static_differs(ctx, q, load, q->load);
    for (int64_t k = 0; k < q->n; k++) q->correction[k] = pdi_quasi_static_is_held(q, k) ? q->u[k] - u[k] : 0.0;
    memcpy(q->u, u, (size_t)q->n * sizeof *u);
    return PD_OK;
}

/* Moves the prescribed displacements in u by their corrections: in full in the first round (first 1), then with
 * Anderson acceleration, which is allocated at its first use. */
static pd_status pdi_quasi_static_move_prescribed(pd_ctx *ctx, pd_quasi_static *q, int first)
{
    double *x, *step;
    int64_t n = 0;
    if (first) {
        for (int64_t k = 0; k < q->n; k++) q->u[k] += q->correction[k];
        return PD_OK;
    }
    if (!q->acceleration.n) {
        for (int64_t k = 0; k < q->n; k++) q->acceleration.n += pdi_quasi_static_is_held(q, k);
        PD_TRY(pdi_array_registry_build(ctx, pdi_anderson_list, &q->acceleration));
    }
    x = q->correction + q->n; /* the rest of `asked` is free until loads are asked for again */
    step = q->correction + 2 * q->n;
    for (int64_t k = 0; k < q->n; k++) {
        if (!pdi_quasi_static_is_held(q, k)) continue;
        x[n] = q->u[k];
        step[n++] = q->correction[k];
    }
    pdi_anderson_update(&q->acceleration, x, step);
    n = 0;
    for (int64_t k = 0; k < q->n; k++)
        if (pdi_quasi_static_is_held(q, k)) q->u[k] = x[n++];
    return PD_OK;
}

/* Frees the Anderson acceleration. */
static void pdi_quasi_static_reset_mixing(pd_ctx *ctx, pd_quasi_static *q)
{
    pdi_array_registry_free(ctx, pdi_anderson_list, &q->acceleration);
    memset(&q->acceleration, 0, sizeof q->acceleration);
}

/* Rounds of equilibrium and boundary values, at most 60, until these differ no more (pdi_quasi_static_differs);
 * components without supports come off in each. There is at least one solve. PD_RETRY, PD_NOT_CONVERGED: as of the
 * equilibrium, at once. PD_ERR_STATE: they do not converge. */
static pd_status pdi_quasi_static_iterate_boundary(pd_ctx *ctx, pd_quasi_static *q, double t, double part)
{
    int differs = 1;
    for (int again = 0; again < PDI_QUASI_STATIC_MAX_ROUNDS; again++) {
        PD_TRY(pdi_quasi_static_check_boundary(ctx, q, t, part, &differs));
        if (again && !differs) return PD_OK;
        if (differs) PD_TRY(pdi_quasi_static_move_prescribed(ctx, q, again == 0));
        PD_TRY(pdi_quasi_static_detach_components(ctx, q, t));
        pd_status status = pdi_quasi_static_solve_equilibrium(ctx, q, t);
        if (status != PD_OK) return status;
    }
    return pd_fail(ctx, PD_ERR_STATE, "quasi_static",
                   "what holds the body at %g s depends on how it moves, and does "
                   "not come to rest in %d rounds, as where the %s material beside it flows without end",
                   t, PDI_QUASI_STATIC_MAX_ROUNDS, q->solid.name);
}

/* Equilibrium at the fraction `part` of the step, with boundary values that may depend on it. Plastic states are those
 * of the last commit in each round, so intermediate solutions leave no trace. Frees the acceleration. */
static pd_status pdi_quasi_static_solve_coupled(pd_ctx *ctx, pd_quasi_static *q, double t, double part)
{
    pd_status status = pdi_quasi_static_iterate_boundary(ctx, q, t, part);
    pdi_quasi_static_reset_mixing(ctx, q);
    return status;
}

/* Equilibrium at the fraction `part` of the step, bond failure, and again until no bond breaks. Adds work and released
 * energy, and commits the history of the material each time. PD_RETRY: not found; u, load and force are those before
 * the last solve. PD_NOT_CONVERGED: above its tolerance, and no bond is tested at it. */
static pd_status pdi_quasi_static_equilibrate(pd_ctx *ctx, pd_quasi_static *q, double t, double part)
{
    for (;;) {
        pd_status status = pdi_quasi_static_solve_coupled(ctx, q, t, part);
        if (status < 0) return status;
        if (status == PD_RETRY) {
            memcpy(q->u, q->saved, (size_t)q->n * sizeof *q->u);
            memcpy(q->load, q->saved + q->n, (size_t)q->n * sizeof *q->load);
            return PD_RETRY;
        }
        pd_status middle = pdi_quasi_static_midpoint_force(ctx, q);
        if (middle < 0) return middle;
        PD_TRY(pdi_quasi_static_compute_force(ctx, q));
        pdi_quasi_static_add_work(q, middle == PD_OK);
        q->stored = q->solid.energy(ctx, q->solid.self, q->u);
        if (q->solid.commit) PD_TRY(q->solid.commit(ctx, q->solid.self, q->u));
        if (status != PD_OK) return status;
        int64_t broken = pd_bond_failure_break(ctx, &q->criterion, q->u, q->desc.break_fraction);
        if (!broken) return PD_OK;
        PD_TRY(pd_check_cancel(ctx, "quasi_static", q->solves));
        q->broken += broken;
        PD_TRY(pdi_quasi_static_update_material(ctx, q, &q->released));
        pdi_quasi_static_save_state(q);
    }
}

/* Load step to time t, halved where Newton's method fails; `start` becomes the present state. PD_ERR_STATE: too many
 * halvings. PD_NOT_CONVERGED: the last part did not reach its tolerance. */
static pd_status pdi_quasi_static_advance(pd_ctx *ctx, pd_quasi_static *q, double t)
{
    double done = 0.0, part = 1.0, least = ldexp(1.0, -PDI_QUASI_STATIC_MAX_HALVINGS);
    memcpy(q->start, q->u, (size_t)q->n * sizeof *q->u);
    memcpy(q->start + q->n, q->load, (size_t)q->n * sizeof *q->load);
    while (done < 1.0) {
        pdi_quasi_static_save_state(q);
        pd_status status = pdi_quasi_static_equilibrate(ctx, q, t, done + part);
        if (status < 0) return status;
        if (status != PD_RETRY) {
            done += part;
            if (status != PD_OK && !(done < 1.0)) return status;
            continue;
        }
        part *= 0.5;
        if (part < least)
            return pd_fail(ctx, PD_ERR_STATE, "quasi_static", "no balance from %g to %g s: after %.4g of the step the "
                           "%s material bears no more, as where metal flows without end, or the body buckles",
                           q->time, t, done, q->solid.name);
    }
    return PD_OK;
}

pd_status pd_quasi_static_solve_at(pd_ctx *ctx, pd_quasi_static *q, double t)
{
    int moves = !q->solved || q->stale;
    pd_status status = PD_OK;
    if (q->stale) PD_TRY(pdi_quasi_static_update_material(ctx, q, &q->dissolved_energy));
    if (!moves) {
        memcpy(q->start, q->load, (size_t)q->n * sizeof *q->load);
        PD_TRY(pdi_quasi_static_check_boundary(ctx, q, t, 1.0, &moves));
        memcpy(q->load, q->start, (size_t)q->n * sizeof *q->load);
    }
    if (moves) status = pdi_quasi_static_advance(ctx, q, t);
    if (status < 0) return status;
    q->solved = 1;
    q->time = t;
    return status;
}

/* ---- a process ---- */

/* The process callback that brings the body to time t. */
static pd_status pdi_quasi_static_process_solve_at(pd_ctx *ctx, void *self, double t)
{
    return pd_quasi_static_solve_at(ctx, (pd_quasi_static *)self, t);
}

/* The process callback for checkpoints: own state and that of the material. */
static pd_status pdi_quasi_static_process_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_quasi_static *q = (pd_quasi_static *)self;
    PD_TRY(pdi_array_registry_store(ctx, pdi_quasi_static_list, q, archive));
    return q->solid.store ? q->solid.store(ctx, q->solid.self, archive) : PD_OK;
}

pd_physics pd_quasi_static_process(pd_quasi_static *q)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "quasi_static";
    p.self = q;
    p.start = pdi_quasi_static_process_solve_at;
    p.solve_at = pdi_quasi_static_process_solve_at;
    p.max_run_step = pdi_physics_limit_max_step;
    p.checkpoint = pdi_quasi_static_process_store;
    return p;
}

#undef PDI_QUASI_STATIC_DEFAULT_BREAK_FRACTION
#undef PDI_QUASI_STATIC_MAX_ROUNDS
#undef PDI_QUASI_STATIC_MIN_ROTATION
#undef PDI_QUASI_STATIC_MAX_HALVINGS
