/* distribution: see distribution.h
 *
 * The field is that of diffusion at rest, with kappa for the diffusivity and what the curves say for what absorbs. The
 * unknown potentials of circuits stand behind those of the nodes.
 */
#include "potential/distribution.h"
#include "core/par.h"
#include "potential/balance.h"
#include "potential/circuit.h"
#include <math.h>
#include <string.h>

#define PDI_DISTRIBUTION_TOLERANCE 1e-12
#define PDI_DISTRIBUTION_NEWTON 200
/* What a circuit has left without phi is at least this share of what its metal conducts: the answer of the electrolyte
 * is that of a preconditioner. */
#define PDI_DISTRIBUTION_LEFT 1e-3
/* [cells] What is that near to a side lies on it. */
#define PDI_DISTRIBUTION_TOUCH 1e-6
/* [V] E - phi of an anode without a cathode: no law gives a speed there. */
#define PDI_DISTRIBUTION_ALONE 100.0

/* kappa at a place in the box. */
static double pdi_distribution_at(void *user, const double *x)
{
    const pd_potential *p = (const pd_potential *)user;
    int i[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        double cell = floor((x[d] - p->grid->lo[d]) / p->grid->h[d]);
        i[d] = (int)pd_min(pd_max(cell, 0.0), p->grid->n[d] - 1);
    }
    int32_t node = pd_grid_node(p->grid, i);
    return p->grid->kind[node] == PD_FLUID ? p->desc.field[node] : p->desc.conductivity;
}

/* Potential [V] above the origin at a place of a wall. */
static double pdi_distribution_wall(void *user, const double *x)
{
    const pd_potential *p = (const pd_potential *)user;
    double sum = 0.0;
    int held = 0;
    for (int s = 0; s < 2 * PD_DIM; s++) {
        double side = s % 2 ? p->grid->hi[s / 2] : p->grid->lo[s / 2];
        if (!p->desc.held[s] || p->grid->side[s] != PD_SIDE_WALL) continue;
        if (fabs(x[s / 2] - side) > PDI_DISTRIBUTION_TOUCH * p->grid->h[s / 2]) continue;
        sum += p->desc.hold[s] - p->origin;
        held++;
    }
    return held ? sum / held : (double)NAN; /* where two sides meet, the mean: neither comes first */
}

/* Inlets hold theirs, or insulate. */
static void pdi_distribution_inlets(pd_potential *p)
{
    const pd_bonds *bonds = p->bonds;
    for (int32_t n = 0; n < p->boundary.count; n++)
        for (int k = 0; k < bonds->stencil->count; k++) {
            int64_t slot = (int64_t)n * bonds->stencil->count + k;
            int32_t far = p->boundary.far_end[slot];
            if (p->grid->kind[far] != PD_INLET) continue;
            int side = pdi_circuit_side(p->grid, far);
            p->phi[far] = p->desc.hold[side] - p->origin;
            if (!p->desc.held[side]) p->flux.boundary_bond[slot] = 0.0;
        }
}

typedef struct pdi_distribution_user {
    pd_ctx *ctx;
    pd_potential *p;
} pdi_distribution_user;

/* Second derivatives of the energy along x [total + floating]. */
static void pdi_distribution_apply(void *user, const double *x, double *y)
{
    pdi_distribution_user *u = (pdi_distribution_user *)user;
    pd_potential *p = u->p;
    int32_t total = p->grid->total;
    pdi_balance_bonds(u->ctx, p, x, 1, y);
    for (int f = 0; f < p->floating; f++) y[total + f] = 0.0;
    for (int32_t n = 0; n < p->contacts.count; n++) {
        const pd_contact *c = &p->contacts.list[n];
        int place = p->place[pdi_potential_circuit(p, c->electrode)];
        if (place < 0) continue;
        double slope = pdi_potential_area(p, c) * p->slope[n];
        y[c->node] -= slope * x[total + place];
        y[total + place] += slope * (x[total + place] - x[c->node]);
    }
}

/* y [total]: about what the electrolyte answers to x, with all E kept. */
static void pdi_distribution_electrolyte(pd_ctx *ctx, pd_potential *p, const double *x, double *y)
{
    const pd_grid *grid = p->grid;
    pdi_par_copy(ctx, grid->total, x, p->repeated);
    for (int32_t i = 0; i < grid->total && grid->circumference; i++)
        if (grid->kind[i] == PD_FLUID) p->repeated[i] /= pd_grid_circumference(grid, i);
    pdi_inverse_apply(ctx, &p->inverse, p->repeated, y);
}

static void pdi_distribution_precondition(void *user, const double *x, double *y)
{
    pdi_distribution_user *u = (pdi_distribution_user *)user;
    pd_potential *p = u->p;
    int32_t total = p->grid->total;
    int count = p->floating;
    pdi_distribution_electrolyte(u->ctx, p, x, y);
    for (int f = 0; f < count; f++) y[total + f] = x[total + f];
    for (int32_t n = 0; n < p->contacts.count && count; n++) {
        const pd_contact *c = &p->contacts.list[n];
        int place = p->place[pdi_potential_circuit(p, c->electrode)];
        if (place >= 0) y[total + place] += pdi_potential_area(p, c) * p->slope[n] * y[c->node];
    }
    for (int f = 0; f < count; f++) { /* forwards and back with the factor */
        for (int g = 0; g < f; g++) y[total + f] -= p->schur[f * count + g] * y[total + g];
        y[total + f] /= p->schur[f * count + f];
    }
    for (int f = count - 1; f >= 0; f--) {
        for (int g = f + 1; g < count; g++) y[total + f] -= p->schur[g * count + f] * y[total + g];
        y[total + f] /= p->schur[f * count + f];
    }
    for (int f = 0; f < count; f++) pdi_par_axpy(u->ctx, total, y[total + f], p->answer + (int64_t)f * total, y);
}

/* What E has left without phi, and its factor (Cholesky), with pivots that stay positive. */
static void pdi_distribution_schur(pd_ctx *ctx, pd_potential *p)
{
    int32_t total = p->grid->total;
    int count = p->floating;
    double *m = p->schur;
    for (int f = 0; f < count; f++) {
        pdi_par_zero(ctx, total, p->step);
        for (int32_t n = 0; n < p->contacts.count; n++) {
            const pd_contact *c = &p->contacts.list[n];
            if (p->place[pdi_potential_circuit(p, c->electrode)] == f)
                p->step[c->node] += pdi_potential_area(p, c) * p->slope[n];
        }
        pdi_par_zero(ctx, total, p->answer + (int64_t)f * total);
        pdi_distribution_electrolyte(ctx, p, p->step, p->answer + (int64_t)f * total);
    }
    for (int f = 0; f < count; f++) {
        double own = 0.0;
        for (int g = 0; g <= f; g++) m[f * count + g] = 0.0;
        for (int32_t n = 0; n < p->contacts.count; n++) {
            const pd_contact *c = &p->contacts.list[n];
            if (p->place[pdi_potential_circuit(p, c->electrode)] != f) continue;
            double slope = pdi_potential_area(p, c) * p->slope[n];
            own += slope;
            for (int g = 0; g <= f; g++) m[f * count + g] -= slope * p->answer[(int64_t)g * total + c->node];
        }
        m[f * count + f] += own;
        for (int g = 0; g <= f; g++) {
            for (int k = 0; k < g; k++) m[f * count + g] -= m[f * count + k] * m[g * count + k];
            if (g < f) m[f * count + g] /= m[g * count + g];
        }
        m[f * count + f] = sqrt(pd_max(m[f * count + f], PDI_DISTRIBUTION_LEFT * own));
    }
}

/* Newton's step for p->rest, to a share of it. */
static pd_status pdi_distribution_linear(pd_ctx *ctx, pd_potential *p, double share, double rounding,
                                      pd_potential_result *result)
{
    pdi_distribution_user user;
    pd_krylov_result linear;
    user.ctx = ctx;
    user.p = p;
    PD_TRY(pdi_inverse_setup(ctx, &p->inverse, 0.0, NULL, 0));
    pdi_distribution_schur(ctx, p);
    p->krylov.desc.rtol = share;
    p->krylov.desc.atol = 0.1 * rounding;
    PD_TRY(pdi_arena_acquire(ctx, &p->arena, pdi_krylov_list, &p->krylov));
    pd_status status = pd_krylov_solve(ctx, &p->krylov, pdi_distribution_apply, pdi_distribution_precondition, &user,
                                       p->rest, p->step, &linear);
    result->krylov += linear.iterations;
    if (status == PD_ERR_DIVERGED) status = PD_OK; /* the best step seen lowers the energy */
    return pdi_arena_release(ctx, &p->arena, pdi_krylov_list, &p->krylov, status);
}

static pd_status pdi_distribution_check_values(pd_ctx *ctx, const pd_potential *p)
{
    char name[PDI_CIRCUIT_NAME];
    for (int n = 0; n < p->desc.circuits; n++)
        if (!(fabs(p->desc.circuit[n].value) < PDI_POTENTIAL_FAR))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "potential", "%s: the given %s is %g, expected -1e6 to 1e6",
                           pdi_circuit_name(p, n, name),
                           p->desc.circuit[n].control == PD_CIRCUIT_POTENTIAL ? "potential" : "current",
                           p->desc.circuit[n].value);
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (p->desc.held[s] && !(fabs(p->desc.hold[s]) < PDI_POTENTIAL_FAR))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "potential", "side %d holds %g V, expected between -1e6 and 1e6", s,
                           p->desc.hold[s]);
    return PD_OK;
}

/* 1: nothing drives a current: no metal is there, and all sides that hold a potential hold the same. */
static int pdi_distribution_rests(const pd_potential *p)
{
    int rests = p->contacts.count == 0;
    for (int s = 0; s < 2 * PD_DIM; s++) rests = rests && (!p->desc.held[s] || !(p->desc.hold[s] > p->origin));
    return rests;
}

static pd_status pdi_distribution_begin(pd_ctx *ctx, pd_potential *p)
{
    PD_TRY(pdi_distribution_check_values(ctx, p));
    PD_TRY(pdi_circuit_check(ctx, p));
    for (int n = 0; n < p->desc.circuits; n++)
        if (p->desc.circuit[n].control == PD_CIRCUIT_POTENTIAL) p->metal[n] = p->desc.circuit[n].value;
    for (int32_t i = 0; i < p->grid->total; i++)
        if (p->grid->kind[i] == PD_FLUID && (!p->wet[p->part[i]] || !(fabs(p->phi[i]) < PDI_POTENTIAL_FAR)))
            p->phi[i] = 0.0;
    p->origin = HUGE_VAL;
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (p->desc.held[s]) p->origin = pd_min(p->origin, p->desc.hold[s]);
    if (!(p->origin < HUGE_VAL)) p->origin = 0.0;
    int rests = pdi_distribution_rests(p);
    for (int32_t i = 0; i < p->grid->total; i++) {
        p->level[i] = p->fixed[i] ? p->origin : 0.0;
        if (p->pocket[i] >= 0 && p->fixed[p->pocket[i]]) p->phi[i] -= p->origin;
        if (rests) p->phi[i] = 0.0; /* no other field is a share of what flows */
    }
    pdi_circuit_raise(p);
    if (p->diffusion.wall_rate) pdi_diffusion_renew(&p->diffusion);
    PD_TRY(pdi_flux_refresh(ctx, &p->flux));
    pdi_distribution_inlets(p);
    return PD_OK;
}

/* The electrode at which the balances lack most: that of a node, or of a circuit. */
static int pdi_distribution_worst(const pd_potential *p)
{
    double most = -1.0;
    int worst = 0;
    for (int32_t k = 0; k < p->contacts.count; k++) {
        const pd_contact *c = &p->contacts.list[k];
        int place = p->place[pdi_potential_circuit(p, c->electrode)];
        double lack = fabs(p->rest[c->node]);
        if (place >= 0) lack = pd_max(lack, fabs(p->rest[p->grid->total + place]));
        if (!(lack > most)) continue;
        most = lack;
        worst = c->electrode;
    }
    return worst;
}

/* The circuit whose potential is farthest off. */
static int pdi_distribution_farthest(const pd_potential *p)
{
    int worst = 0;
    for (int n = 1; n < p->desc.circuits; n++)
        if (fabs(p->metal[n]) > fabs(p->metal[worst])) worst = n;
    return worst;
}

/* The electrode with a current that is no number. */
static const char *pdi_distribution_wrong(const pd_potential *p, char *name)
{
    int32_t k = 0;
    while (k + 1 < p->contacts.count && fabs(p->current[k]) < HUGE_VAL) k++;
    if (p->contacts.count) return pdi_circuit_electrode(p, p->contacts.list[k].electrode, name);
    return pdi_circuit_name(p, 0, name);
}

static pd_status pdi_distribution_newton(pd_ctx *ctx, pd_potential *p, pd_potential_result *result)
{
    int32_t total = p->grid->total;
    double last = HUGE_VAL;
    char name[PDI_CIRCUIT_NAME];
    for (;;) {
        pdi_balance_size size = pdi_balance_rest(ctx, p);
        double most = pd_max(p->desc.tolerance * size.currents, size.rounding);
        result->residual = size.currents > 0.0 ? size.lack / size.currents : 0.0;
        if (!(size.lack < HUGE_VAL))
            return pd_fail(ctx, PD_ERR_DIVERGED, "potential", "the current of %s is not finite after %d steps of "
                           "Newton's method; expected a curve that gives numbers", pdi_distribution_wrong(p, name),
                           result->newton);
        if (size.lack <= most) {
            pdi_balance_still(p, size.lack);
            return PD_OK;
        }
        result->worst = pdi_distribution_worst(p);
        if (result->newton >= p->desc.max_newton) return PD_NOT_CONVERGED;
        PD_TRY(pd_check_cancel(ctx, "potential: Newton", result->newton));
        double share = pd_max(pdi_krylov_forcing(size.lack / last), 0.1 * most / size.lack);
        last = size.lack;
        pd_status status = pdi_distribution_linear(ctx, p, share, size.rounding, result);
        if (status < 0) return status;
        double part = pdi_balance_share(ctx, p), far = 0.0;
        for (int32_t i = 0; i < total; i++)
            if (p->grid->kind[i] == PD_FLUID) p->phi[i] += part * p->step[i];
        for (int n = 0; n < p->desc.circuits; n++) {
            if (p->place[n] >= 0) p->metal[n] += part * p->step[total + p->place[n]];
            far = pd_max(far, fabs(p->metal[n]));
        }
        result->newton++;
        pdi_circuit_raise(p);
        far = pd_max(far, pdi_par_max_abs(ctx, total, p->level));
        if (!(far < PDI_POTENTIAL_FAR) || !(pdi_par_max_abs(ctx, total, p->phi) < PDI_POTENTIAL_FAR))
            return pd_fail(ctx, PD_ERR_STATE, "potential", "the potential of %s leaves every bound: there is no "
                           "solution; expected curves, limits and given values that let its current pass",
                           pdi_circuit_name(p, pdi_distribution_farthest(p), name));
    }
}

static void pdi_distribution_work_list(pdi_array_visitor *owner, void *object)
{
    pd_potential *potential = (pd_potential *)object;
    int64_t total = potential->grid->total, count = total + potential->floating;
    PDI_ARRAY(owner, potential, absorb, total, "S/m3");
    PDI_ARRAY(owner, potential, repeated, total, "V");
    PDI_ARRAY(owner, potential, rest, count, "A/m3");
    PDI_ARRAY(owner, potential, step, count, "V");
    PDI_ARRAY(owner, potential, along, total, "A/m3");
    PDI_ARRAY(owner, potential, answer, potential->floating * total, "1");
    PDI_ARRAY(owner, potential, schur, potential->floating * potential->floating, "S/m3");
    pdi_flux_list(owner, &potential->flux);
    pdi_inverse_list(owner, &potential->inverse);
}

pd_status pd_potential_solve(pd_ctx *ctx, pd_potential *p, pd_potential_result *result)
{
    memset(result, 0, sizeof *result);
    PD_TRY(pdi_arena_acquire(ctx, &p->arena, pdi_distribution_work_list, p));
    pdi_multigrid_set_pointers(&p->inverse.mg);
    p->flux.absorb = p->absorb;
    p->inverse.fresh = 0;
    pd_status status = pdi_distribution_begin(ctx, p);
    if (status >= 0) {
        status = pdi_distribution_newton(ctx, p, result);
        if (status >= 0) pdi_balance_totals(p, result);
        for (int32_t i = 0; i < p->grid->total; i++)
            if (p->pocket[i] >= 0) p->phi[i] += p->level[p->pocket[i]];
        for (int32_t i = 0; i < p->grid->total; i++) p->level[i] = 0.0;
        if (status >= 0) pdi_circuit_level(p);
    }
    pdi_multigrid_clear_pointers(&p->inverse.mg);
    return pdi_arena_release(ctx, &p->arena, pdi_distribution_work_list, p, status);
}

/* ---- building ---- */

PDI_FN void pdi_distribution_list(pdi_array_visitor *owner, void *object)
{
    pd_potential *potential = (pd_potential *)object;
    if (!potential->grid) return;
    int64_t total = potential->grid->total, circuits = potential->desc.circuits;
    PDI_ARRAY_STATE(owner, potential, phi, total, "V");
    PDI_ARRAY_STATE(owner, potential, metal, circuits, "V");
    PDI_ARRAY(owner, potential, total, circuits, "A");
    PDI_ARRAY(owner, potential, pocket, total, "1");
    PDI_ARRAY(owner, potential, level, total, "V");
    PDI_ARRAY(owner, potential, fixed, total, "1");
    PDI_ARRAY(owner, potential, part, total + circuits + 1, "1");
    PDI_ARRAY(owner, potential, wet, total + circuits + 1, "1");
    PDI_ARRAY(owner, potential, place, circuits, "1");
}

PDI_FN void pdi_distribution_contact_list(pdi_array_visitor *owner, void *object)
{
    pd_potential *potential = (pd_potential *)object;
    int64_t count = pdi_contact_all(&potential->contacts);
    PDI_ARRAY(owner, potential, current, count, "A/m2");
    PDI_ARRAY(owner, potential, surface, count, "V");
    PDI_ARRAY(owner, potential, slope, count, "S/m2");
    PDI_ARRAY(owner, potential, trial, count, "A/m2");
}

static pd_status pdi_distribution_check(pd_ctx *ctx, const pd_grid *grid, const pd_potential_desc *desc)
{
    const char *where = "potential";
    if (!(desc->conductivity > 0.0) || !(desc->conductivity < 1e100) || !(desc->tolerance >= 0.0) ||
        !(desc->tolerance < 1.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, where, "conductivity %g S/m, tolerance %g: expected a positive one, and "
                       "one from 0 to 1", desc->conductivity, desc->tolerance);
    if (desc->electrodes < 1 || desc->electrodes > PD_ELECTRODES || !desc->electrode || desc->circuits < 1 ||
        !desc->circuit)
        return pd_fail(ctx, PD_ERR_ARGUMENT, where, "%d electrodes and %d circuits, expected 1 to %d and at least 1",
                       desc->electrodes, desc->circuits, PD_ELECTRODES);
    for (int e = 0; e < desc->electrodes && desc->member; e++)
        if (desc->member[e] < 0 || desc->member[e] >= desc->circuits)
            return pd_fail(ctx, PD_ERR_ARGUMENT, where, "electrode %d is in circuit %d of %d", e, desc->member[e],
                           desc->circuits);
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (desc->held[s] && grid->side[s] != PD_SIDE_WALL && grid->side[s] != PD_SIDE_INLET)
            return pd_fail(ctx, PD_ERR_ARGUMENT, where, "side %d cannot hold a potential, expected a wall or an inlet",
                           s);
    if (desc->wide && desc->wide->reach > grid->ghost)
        return pd_fail(ctx, PD_ERR_ARGUMENT, where, "the wide family reaches over %d cells, the grid has %d layers of "
                       "ghosts", desc->wide->reach, grid->ghost);
    return PD_OK;
}

/* Numbers by node, which may change with the geometry. */
static pd_status pdi_distribution_check_nodes(pd_ctx *ctx, const pd_potential *p)
{
    char text[PDI_GRID_POSITION_LENGTH];
    for (int32_t i = 0; i < p->grid->total; i++) {
        const pd_potential_desc *desc = &p->desc;
        if (p->grid->kind[i] == PD_SOLID && desc->metal && desc->metal[i] >= desc->electrodes)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "potential", "the metal at %s m is electrode %d of %d",
                           pdi_grid_format_position(p->grid, i, text), desc->metal[i], desc->electrodes);
        if (p->grid->kind[i] == PD_FLUID && desc->field && !(desc->field[i] > 0.0 && desc->field[i] < 1e100))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "potential",
                           "conductivity %g S/m at %s m, expected a positive "
                           "number",
                           desc->field[i], pdi_grid_format_position(p->grid, i, text));
    }
    return PD_OK;
}

static void pdi_distribution_krylov(const pd_potential *p, pd_krylov_desc *kd)
{
    memset(kd, 0, sizeof *kd);
    kd->method = PD_KRYLOV_CG;
    kd->equations = "potential";
    kd->n = (int64_t)p->grid->total + p->floating;
    kd->zero_guess = 1;
}

/* Metal and pockets as they are now. */
static pd_status pdi_distribution_survey(pd_ctx *ctx, pd_potential *p)
{
    pdi_contact_metal metal;
    metal.electrode = p->desc.metal;
    metal.left = p->desc.left;
    metal.wide = p->desc.wide;
    PD_TRY(pdi_contact_find(ctx, p->bonds, &metal, &p->contacts));
    PD_TRY(pdi_circuit_find(ctx, p));
    PD_TRY(pdi_array_registry_build(ctx, pdi_distribution_contact_list, p));
    for (int32_t n = 0; n < p->contacts.count; n++) p->surface[n] = pdi_potential_drop(p, &p->contacts.list[n]);
    for (int32_t n = p->contacts.count; n < pdi_contact_all(&p->contacts); n++) {
        double least, most; /* an anode alone is as far below its curve as it gets; of a cathode nothing is known */
        pdi_electrode_range(&p->desc.electrode[p->contacts.list[n].electrode], &least, &most);
        p->surface[n] = least < 0.0 ? (double)NAN : -PDI_DISTRIBUTION_ALONE;
    }
    return PD_OK;
}

PDI_FN pd_status pdi_distribution_contacts(pd_ctx *ctx, pd_potential *p)
{
    pdi_array_registry_free(ctx, pdi_distribution_contact_list, p);
    return pdi_distribution_survey(ctx, p);
}

static pd_status pdi_distribution_room(pd_ctx *ctx, pd_potential *p, size_t *room)
{
    pd_multigrid_desc md;
    pdi_compact_operator_multigrid_desc(p->grid, &md);
    md.symmetric = md.high_contrast = 1;
    md.arena = &p->arena;
    p->inverse.flux = &p->flux;
    PD_TRY(pdi_inverse_plan(ctx, &md, &p->inverse));
    size_t setup = pdi_inverse_room(&p->inverse), linear = pdi_arena_count_bytes(pdi_krylov_list, &p->krylov);
    *room = pdi_arena_count_bytes(pdi_distribution_work_list, p) + (setup > linear ? setup : linear);
    return PD_OK;
}

PDI_FN pd_status pdi_distribution_plan(pd_ctx *ctx, pd_potential *p, size_t *room)
{
    pd_krylov_desc kd;
    p->flux.bonds = p->bonds;
    pdi_distribution_krylov(p, &kd);
    PD_TRY(pdi_krylov_init(ctx, &kd, &p->krylov));
    return pdi_distribution_room(ctx, p, room);
}

/* All that follows from bonds and conductivity. */
static pd_status pdi_distribution_fill(pd_ctx *ctx, pd_potential *p)
{
    pd_diffusion_desc dd;
    pd_krylov_desc kd;
    int walls = 0;
    PD_TRY(pdi_distribution_check_nodes(ctx, p));
    for (int s = 0; s < 2 * PD_DIM; s++) walls = walls || (p->desc.held[s] && p->grid->side[s] == PD_SIDE_WALL);
    memset(&dd, 0, sizeof dd);
    dd.diffusivity = p->desc.conductivity;
    dd.field = p->desc.field ? pdi_distribution_at : NULL;
    dd.held = walls ? pdi_distribution_wall : NULL;
    dd.user = p;
    dd.walls_only = dd.smooth = 1;
    p->origin = HUGE_VAL;
    for (int s = 0; s < 2 * PD_DIM; s++)
        if (p->desc.held[s]) p->origin = pd_min(p->origin, p->desc.hold[s]);
    PD_TRY(pdi_diffusion_build(ctx, p->bonds, &dd, &p->diffusion));
    PD_TRY(pdi_open_boundary_build(ctx, p->bonds, &p->boundary));
    p->flux.bonds = p->bonds;
    p->flux.diffusion = &p->diffusion;
    p->flux.boundary = &p->boundary;
    PD_TRY(pdi_flux_build(ctx, &p->flux));
    PD_TRY(pdi_distribution_survey(ctx, p));
    pdi_distribution_krylov(p, &kd);
    PD_TRY(pdi_krylov_build_unallocated(ctx, &kd, &p->krylov));
    size_t room;
    PD_TRY(pdi_distribution_room(ctx, p, &room));
    return pdi_arena_reserve(ctx, &p->arena, room);
}

static void pdi_distribution_empty(pd_ctx *ctx, pd_potential *p)
{
    pdi_flux_free(ctx, &p->flux);
    pdi_open_boundary_free(ctx, &p->boundary);
    pdi_diffusion_free(ctx, &p->diffusion);
    pdi_inverse_free(ctx, &p->inverse);
    pd_krylov_free(ctx, &p->krylov);
    pdi_array_registry_free(ctx, pdi_distribution_contact_list, p);
    pdi_contact_free(ctx, &p->contacts);
    pd_arena_free(ctx, &p->arena);
    memset(&p->inverse, 0, sizeof p->inverse);
}

static pd_status pdi_distribution_make(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds,
                                    const pd_potential_desc *desc, pd_potential *p)
{
    memset(p, 0, sizeof *p);
    PD_TRY(pdi_distribution_check(ctx, grid, desc));
    p->desc = *desc;
    if (!p->desc.wide) p->desc.wide = bonds->stencil;
    if (!(p->desc.tolerance > 0.0)) p->desc.tolerance = PDI_DISTRIBUTION_TOLERANCE;
    if (p->desc.max_newton <= 0) p->desc.max_newton = PDI_DISTRIBUTION_NEWTON;
    p->grid = grid;
    p->bonds = bonds;
    PD_TRY(pdi_array_registry_build(ctx, pdi_distribution_list, p));
    PD_TRY(pdi_distribution_check_values(ctx, p));
    for (int n = 0; n < desc->circuits; n++)
        if (desc->circuit[n].control == PD_CIRCUIT_POTENTIAL) p->metal[n] = desc->circuit[n].value;
    return pdi_distribution_fill(ctx, p);
}

pd_status pd_potential_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_potential_desc *desc,
                             pd_potential *p)
{
    pd_status status = pdi_distribution_make(ctx, grid, bonds, desc, p);
    if (status < 0) pd_potential_free(ctx, p);
    return status;
}

pd_status pd_potential_update(pd_ctx *ctx, pd_potential *p)
{
    pdi_distribution_empty(ctx, p);
    return pdi_distribution_fill(ctx, p);
}

void pd_potential_free(pd_ctx *ctx, pd_potential *p)
{
    pdi_distribution_empty(ctx, p);
    pdi_array_registry_free(ctx, pdi_distribution_list, p);
    memset(p, 0, sizeof *p);
}
