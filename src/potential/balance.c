/* balance: see balance.h */
#include "potential/balance.h"
#include "core/root_bracket.h"
#include "core/par.h"
#include <math.h>

/* Rounding of a row, in units of that of its terms. */
#define PDI_BALANCE_ROUNDING 16.0
/* [V] Longest step: on a plateau a step has no end. */
#define PDI_BALANCE_LONG 100.0
/* Least slope of a curve behind its electrolyte, over that of the electrolyte: a plateau holds no potential. */
#define PDI_BALANCE_FLAT 1e-15
/* A step is taken when its end has at most this share of the slope of the energy at its start. */
#define PDI_BALANCE_ENOUGH 0.5
/* How often a step is doubled at most. */
#define PDI_BALANCE_DOUBLE 6
/* Scalar operations of a contact, to decide on threads. */
#define PDI_BALANCE_WORK 400

static void pdi_balance_currents(const pd_ctx *ctx, pd_potential *p)
{
    int nt = pd_par_threads(ctx, (int64_t)p->contacts.count * PDI_BALANCE_WORK);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t n = 0; n < p->contacts.count; n++) {
        const pd_contact *c = &p->contacts.list[n];
        double resist = c->way / pdi_potential_kappa(p, c->node);
        p->current[n] = pdi_electrode_through(&p->desc.electrode[c->electrode], c->share, pdi_potential_drop(p, c),
                                              resist, &p->surface[n], &p->slope[n]);
        p->slope[n] = pd_max(p->slope[n], PDI_BALANCE_FLAT / resist);
    }
}

static void pdi_balance_images(const pd_ctx *ctx, pd_potential *p, const double *x)
{
    pdi_par_copy(ctx, p->grid->total, x, p->repeated);
    pd_ghosts_set_scalar(&p->bonds->ghosts, p->repeated);
}

PDI_FN void pdi_balance_bonds(const pd_ctx *ctx, pd_potential *p, const double *x, int held, double *y)
{
    pd_flux flux = p->flux;
    pd_diffusion loose = p->diffusion;
    if (!held) loose.wall_rate = NULL;
    flux.diffusion = &loose;
    pdi_balance_images(ctx, p, x);
    pdi_flux_apply(ctx, &flux, p->repeated, y);
    for (int32_t i = 0; i < p->grid->total && p->grid->circumference; i++)
        if (p->grid->kind[i] == PD_FLUID) y[i] *= pd_grid_circumference(p->grid, i);
}

PDI_FN pdi_balance_size pdi_balance_rest(const pd_ctx *ctx, pd_potential *p)
{
    int32_t total = p->grid->total;
    double volume = p->bonds->stencil->volume, conduct = p->bonds->stencil->lap_sum, least = 0.0, most = 0.0;
    pdi_compensated_sum currents = {0.0, 0.0}, rounding = {0.0, 0.0};
    pdi_balance_size size;
    pdi_par_zero(ctx, total, p->absorb);
    pdi_par_zero(ctx, total + p->floating, p->rest);
    pdi_balance_bonds(ctx, p, p->phi, 0, p->rest);
    for (int32_t i = 0; i < total; i++) {
        if (p->grid->kind[i] != PD_FLUID) continue;
        double around = pd_grid_circumference(p->grid, i);
        p->rest[i] = around * pdi_diffusion_gain(&p->diffusion, i, p->phi[i], 0.0) - p->rest[i];
        least = pd_min(least, p->phi[i]);
        most = pd_max(most, p->phi[i]);
    }
    pdi_balance_currents(ctx, p);
    for (int n = 0; n < p->desc.circuits; n++)
        if (p->place[n] >= 0) p->rest[total + p->place[n]] = p->desc.circuit[n].value / volume;
    for (int32_t n = 0; n < p->contacts.count; n++) {
        const pd_contact *c = &p->contacts.list[n];
        int place = p->place[pdi_potential_circuit(p, c->electrode)];
        double area = pdi_potential_area(p, c), enters = area * p->current[n];
        double small = area * p->slope[n] * PDI_POTENTIAL_SMALL, drop = pdi_potential_drop(p, c);
        double round = DBL_EPSILON * area * p->slope[n] * (fabs(drop) + fabs(p->level[p->pocket[c->node]]));
        p->rest[c->node] += enters;
        p->absorb[c->node] += c->area * p->slope[n];
        if (place >= 0) p->rest[total + place] -= enters;
        pdi_compensated_sum_add(&currents, enters * enters + small * small);
        pdi_compensated_sum_add(&rounding, round * round);
    }
    for (int32_t i = 0; i < total; i++) {
        if (p->grid->kind[i] != PD_FLUID) continue;
        double around = pd_grid_circumference(p->grid, i);
        double enters = pdi_diffusion_gain(&p->diffusion, i, p->phi[i], 0.0);
        double round = DBL_EPSILON * around * conduct * pdi_potential_kappa(p, i) * pd_max(most, -least);
        pdi_compensated_sum_add(&currents, around * enters * around * enters);
        pdi_compensated_sum_add(&rounding, round * round);
    }
    size.lack = sqrt(pdi_par_dot(ctx, total + p->floating, p->rest, p->rest));
    size.currents = sqrt(pdi_compensated_sum_total(&currents));
    size.rounding = PDI_BALANCE_ROUNDING * sqrt(pdi_compensated_sum_total(&rounding));
    return size;
}

PDI_FN void pdi_balance_still(pd_potential *p, double lack)
{
    for (int32_t n = 0; n < p->contacts.count; n++) {
        const pd_contact *c = &p->contacts.list[n];
        double size = fabs(pdi_potential_drop(p, c)) + fabs(p->level[p->pocket[c->node]]);
        double off = pd_max(PDI_BALANCE_ROUNDING * DBL_EPSILON * size, p->desc.tolerance * PDI_POTENTIAL_SMALL);
        double least = pd_max(p->slope[n] * off, lack / pdi_potential_area(p, c));
        if (fabs(p->current[n]) <= least) p->current[n] = 0.0;
    }
}

/* Slope of the energy at the share s of the step. */
static double pdi_balance_slope(const pd_ctx *ctx, pd_potential *p, double start, double bend, double s)
{
    int32_t total = p->grid->total;
    int nt = pd_par_threads(ctx, (int64_t)p->contacts.count * PDI_BALANCE_WORK);
    pdi_compensated_sum sum = {0.0, 0.0};
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t n = 0; n < p->contacts.count; n++) {
        const pd_contact *c = &p->contacts.list[n];
        int place = p->place[pdi_potential_circuit(p, c->electrode)];
        double by = (place < 0 ? 0.0 : p->step[total + place]) - p->step[c->node], slope, u = p->surface[n];
        double resist = c->way / pdi_potential_kappa(p, c->node), drop = pdi_potential_drop(p, c) + s * by;
        double i = pdi_electrode_through(&p->desc.electrode[c->electrode], c->share, drop, resist, &u, &slope);
        p->trial[n] = pdi_potential_area(p, c) * (i - p->current[n]) * by;
    }
    pdi_compensated_sum_add(&sum, start);
    pdi_compensated_sum_add(&sum, s * bend);
    for (int32_t n = 0; n < p->contacts.count; n++) pdi_compensated_sum_add(&sum, p->trial[n]);
    return pdi_compensated_sum_total(&sum);
}

/* The energy is convex: its slope rises along the step, from below zero. */
PDI_FN double pdi_balance_share(const pd_ctx *ctx, pd_potential *p)
{
    int32_t total = p->grid->total, count = total + p->floating;
    double start = -pdi_par_dot(ctx, count, p->rest, p->step), enough = PDI_BALANCE_ENOUGH * fabs(start);
    pdi_par_zero(ctx, total, p->absorb);
    pdi_par_zero(ctx, total, p->along);
    pdi_balance_bonds(ctx, p, p->step, 1, p->along);
    double bend = pdi_par_dot(ctx, total, p->step, p->along), size = pdi_par_max_abs(ctx, count, p->step);
    double s = size > PDI_BALANCE_LONG ? PDI_BALANCE_LONG / size : 1.0, lo = 0.0, hi = s, low = start;
    double high = pdi_balance_slope(ctx, p, start, bend, s);
    for (int n = 0; n < PDI_BALANCE_DOUBLE && high < -enough; n++) {
        lo = hi;
        low = high;
        hi *= 2.0;
        high = pdi_balance_slope(ctx, p, start, bend, hi);
    }
    if (!(high > enough)) return hi;
    pdi_root_bracket b = {lo, low, hi, high, 0, 0};
    while (pdi_root_bracket_get_next(&b, &s)) {
        double here = pdi_balance_slope(ctx, p, start, bend, s);
        if (fabs(here) <= enough) return s;
        pdi_root_bracket_update(&b, s, here);
    }
    return b.a > 0.0 ? b.a : s;
}

PDI_FN void pdi_balance_totals(pd_potential *p, pd_potential_result *result)
{
    double volume = p->bonds->stencil->volume;
    pdi_compensated_sum through = {0.0, 0.0}, size = {0.0, 0.0}, all = {0.0, 0.0}, anodic = {0.0, 0.0};
    for (int n = 0; n < p->desc.circuits; n++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        for (int32_t k = 0; k < p->contacts.count; k++) {
            const pd_contact *c = &p->contacts.list[k];
            double area = pdi_potential_area(p, c), enters = area * p->current[k];
            if (pdi_potential_circuit(p, c->electrode) != n) continue;
            pdi_compensated_sum_add(&sum, enters);
            pdi_compensated_sum_add(&all, enters);
            pdi_compensated_sum_add(&size, fabs(enters) + area * p->slope[k] * PDI_POTENTIAL_SMALL);
            pdi_compensated_sum_add(&anodic, pd_max(enters, 0.0));
        }
        p->total[n] = volume * pdi_compensated_sum_total(&sum);
    }
    for (int32_t i = 0; i < p->grid->total; i++) {
        if (p->grid->kind[i] != PD_FLUID) continue;
        double around = pd_grid_circumference(p->grid, i), gain = pdi_diffusion_gain(&p->diffusion, i, p->phi[i], 0.0);
        double rate = p->diffusion.wall_rate ? p->diffusion.wall_rate[i] : 0.0;
        pdi_compensated_sum_add(&through, around * gain);
        pdi_compensated_sum_add(&size, around * (fabs(gain) + rate * PDI_POTENTIAL_SMALL));
    }
    for (int32_t n = 0; n < p->boundary.count; n++)
        for (int k = 0; k < p->bonds->stencil->count; k++) {
            int64_t slot = (int64_t)n * p->bonds->stencil->count + k;
            int32_t i = p->boundary.node[n], far = p->boundary.far_end[slot];
            if (p->grid->kind[far] != PD_INLET) continue;
            double rate = pd_grid_circumference(p->grid, i) * p->flux.boundary_bond[slot];
            double drop = p->phi[far] - p->phi[i];
            pdi_compensated_sum_add(&through, rate * drop);
            pdi_compensated_sum_add(&size, rate * (fabs(drop) + PDI_POTENTIAL_SMALL));
        }
    pdi_compensated_sum_add(&all, pdi_compensated_sum_total(&through));
    result->through = volume * pdi_compensated_sum_total(&through);
    result->anodic = volume * pdi_compensated_sum_total(&anodic);
    double sizes = pdi_compensated_sum_total(&size);
    result->imbalance = sizes > 0.0 ? fabs(pdi_compensated_sum_total(&all)) / sizes : 0.0;
}
