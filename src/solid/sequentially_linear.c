/* sequentially_linear: see sequentially_linear.h */
#include "solid/sequentially_linear.h"
#include <math.h>
#include <string.h>

/* Stored energy over the first one below which the body counts as separated: rounding of the solver. */
#define PDI_SEQUENTIALLY_LINEAR_SEPARATED 1e-12
/* Relative margin of the critical value within which bonds break together: rounding of the factor. */
#define PDI_SEQUENTIALLY_LINEAR_TIE 1e-12

/* Describes the arrays. */
static void pdi_sequentially_linear_list(pdi_array_visitor *owner, void *object)
{
    pd_sequentially_linear *sequential = (pd_sequentially_linear *)object;
    PDI_ARRAY(owner, sequential, u, sequential->n, "m");
    PDI_ARRAY(owner, sequential, event_u, sequential->n, "m");
}

/* Inner part of the build; after an error the caller frees. */
static pd_status pdi_sequentially_linear_build_inner(pd_ctx *ctx, const pd_material_interface *solid,
                                                     const pd_sequentially_linear_desc *desc, pd_sequentially_linear *s)
{
    memset(s, 0, sizeof *s);
    if (!solid->linear || !desc->unit_displacement == !desc->load || (desc->unit_displacement && !desc->prescribed))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "sequentially_linear",
                       "the %s material, %s: expected linear forces, and either "
                       "loads or points that are held and moved",
                       solid->name,
                       !desc->unit_displacement == !desc->load ? desc->load ? "moved points and loads" : "no load"
                                                               : "points that nothing holds");
    s->desc = *desc;
    s->solid = *solid;
    s->n = (int64_t)solid->body->count * PD_DIM;
    PD_TRY(pd_bond_failure_build(ctx, solid, &desc->criterion, &s->criterion));
    if (!(s->criterion.critical > 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "sequentially_linear",
                       "no bond breaks, expected a critical value or the energy of"
                       " a crack");
    PD_TRY(pdi_array_registry_build(ctx, pdi_sequentially_linear_list, s));
    for (int64_t k = 0; k < s->n && desc->unit_displacement; k++)
        s->u[k] = desc->prescribed[k] ? desc->unit_displacement[k] : 0.0;
    return PD_OK;
}

pd_status pd_sequentially_linear_build(pd_ctx *ctx, const pd_material_interface *solid,
                                       const pd_sequentially_linear_desc *desc, pd_sequentially_linear *s)
{
    pd_status status = pdi_sequentially_linear_build_inner(ctx, solid, desc, s);
    if (status < 0) pd_sequentially_linear_free(ctx, s);
    return status;
}

void pd_sequentially_linear_free(pd_ctx *ctx, pd_sequentially_linear *s)
{
    pd_bond_failure_free(ctx, &s->criterion);
    pdi_array_registry_free(ctx, pdi_sequentially_linear_list, s);
    memset(s, 0, sizeof *s);
}

/* Equilibrium of the remaining bonds at the factor 1, into u, after an update of the material once bonds have broken;
 * sets `done`, with PD_OK, where loads have torn a component off. */
static pd_status pdi_sequentially_linear_solve_equilibrium(pd_ctx *ctx, pd_sequentially_linear *s)
{
    pd_equilibrium_desc desc;
    pd_equilibrium_result result;
    memset(&desc, 0, sizeof desc);
    desc.prescribed = s->desc.prescribed;
    desc.rtol = s->desc.rtol;
    if (s->broken && s->solid.update) PD_TRY(s->solid.update(ctx, s->solid.self));
    pd_status status = pd_equilibrium_solve(ctx, &s->solid, &desc, s->desc.load, s->u, &result);
    s->iterations = result.iterations;
    if (s->broken && s->desc.load && (status == PD_ERR_STATE || status == PD_ERR_DIVERGED)) {
        s->done = 1;
        ctx->status = PD_OK; /* the end of the analysis is no error */
        ctx->message[0] = '\0';
        return PD_OK;
    }
    return status;
}

/* Energy [J] stored at the present displacement q by a body that stores `energy` [J] at the factor 1: energy q^2 of
 * moved points, q^2/(4 energy) of loads; 0 where `energy` is not positive. */
static double pdi_sequentially_linear_stored_energy(const pd_sequentially_linear *s, double energy)
{
    double q = s->displacement;
    if (!s->desc.load) return energy * q * q;
    return energy > 0.0 ? q * q / (4.0 * energy) : 0.0;
}

/* Bonds have broken at the present displacement: the drop of stored energy is dissipated. energy [J]: now stored at the
 * factor 1. */
static void pdi_sequentially_linear_release_energy(pd_sequentially_linear *s, double energy)
{
    double stored = pdi_sequentially_linear_stored_energy(s, energy);
    s->dissipated += s->stored - stored;
    s->stored = stored;
}

/* Moves to another load factor at fixed bonds: force times displacement is twice the stored energy. Sets factor, force,
 * displacement and stored, and adds to work. energy [J]: stored at the factor 1. */
static void pdi_sequentially_linear_move_to(pd_sequentially_linear *s, double factor, double energy)
{
    double stored = energy * factor * factor;
    s->work += stored - s->stored;
    s->force = s->desc.load ? factor : 2.0 * energy * factor;
    s->displacement = s->desc.load ? 2.0 * energy * factor : factor;
    s->factor = factor;
    s->stored = stored;
}

/* Ends the analysis: the drop of stored energy at the present displacement is dissipated, and done becomes 1. energy
 * [J]: now stored at the factor 1. */
static void pdi_sequentially_linear_finish(pd_sequentially_linear *s, double energy)
{
    pdi_sequentially_linear_release_energy(s, energy);
    s->done = 1;
}

/* Breaks the bonds at `fraction` [-] (about 1) of the load factor of the next event; event_u becomes the displacements
 * there. Returns how many. */
static int64_t pdi_sequentially_linear_break_bonds(const pd_ctx *ctx, pd_sequentially_linear *s, double fraction)
{
    for (int64_t k = 0; k < s->n; k++) s->event_u[k] = fraction * s->first.factor * s->u[k];
    return pd_bond_failure_break(ctx, &s->criterion, s->event_u, 0.0);
}

pd_status pd_sequentially_linear_next_event(pd_ctx *ctx, pd_sequentially_linear *s)
{
    if (s->done) return PD_OK;
    for (int64_t parted = 1; parted; s->broken += parted) {
        PD_TRY(pdi_sequentially_linear_solve_equilibrium(ctx, s));
        double energy = s->done ? 0.0 : s->solid.energy(ctx, s->solid.self, s->u);
        if (!s->events) s->initial_energy = energy;
        int apart = s->done || (s->desc.load ? 0 : !(energy > PDI_SEQUENTIALLY_LINEAR_SEPARATED * s->initial_energy));
        if (!apart) pd_bond_failure_find_first(ctx, &s->criterion, s->u, &s->first);
        if (apart || s->first.bond < 0 || !(s->first.factor > 0.0)) {
            pdi_sequentially_linear_finish(s, apart ? 0.0 : energy);
            return PD_OK;
        }
        /* points whose families cannot feel what tears them come off before */
        parted = pdi_sequentially_linear_break_bonds(
            ctx, s, 1.0 - PDI_SEQUENTIALLY_LINEAR_TIE / pd_min(s->criterion.critical, 1.0));
        if (parted) continue;
        pdi_sequentially_linear_release_energy(s, energy);
        pdi_sequentially_linear_move_to(s, s->first.factor, energy);
    }
    int64_t broken = pdi_sequentially_linear_break_bonds(
        ctx, s, 1.0 + PDI_SEQUENTIALLY_LINEAR_TIE / pd_min(s->criterion.critical, 1.0));
    if (!broken)
        return pd_fail(ctx, PD_ERR_INTERNAL, "sequentially_linear", "no bond breaks at the factor %g at which one does",
                       s->factor);
    for (int64_t k = 0; k < s->n; k++) s->event_u[k] = s->factor * s->u[k];
    s->broken += broken;
    s->events++;
    return PD_OK;
}

#undef PDI_SEQUENTIALLY_LINEAR_SEPARATED
#undef PDI_SEQUENTIALLY_LINEAR_TIE
