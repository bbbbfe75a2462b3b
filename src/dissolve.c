/* dissolve: see dissolve.h */
#include "dissolve.h"
#include "par.h"
#include <math.h>
#include <string.h>

/* Content above the threshold that counts as none, as a fraction of Cs: rounding of the losses. */
#define PDI_DISSOLVE_EMPTY 1e-12

static double pdi_dissolve_factor(const pd_dissolve *d, int32_t solid)
{
    return d->desc.factor ? d->desc.factor[solid] : 1.0;
}

/* What an intact node loses before it turns fluid [mol/m3]. */
static double pdi_dissolve_span(const pd_dissolve *d) { return d->desc.solid * (1.0 - d->desc.threshold); }

/* 1 when metal can pass bond k of fluid node i to its solid end: no wall in between. */
static int pdi_dissolve_free(const pd_dissolve *d, int32_t i, int k)
{
    const pd_stencil *s = d->bonds->stencil;
    for (int g = s->group_first[k]; g < s->group_first[k + 1] - 1; g++) {
        int walled = 1;
        for (int c = s->group_cell[g]; c < s->group_cell[g + 1] && walled; c++) {
            uint8_t kind = d->grid->kind[i + d->bonds->cell_shift[c]];
            walled = kind == PD_WALL || kind == PD_OUTSIDE;
        }
        if (walled) return 0;
    }
    return 1;
}

/* Rate [1/s] at which solid node j loses its span: f sum c(n) v_i over its fluid ends. */
static double pdi_dissolve_rate(const pd_dissolve *d, int32_t j)
{
    const pd_stencil *s = d->bonds->stencil;
    double sum = 0.0;
    for (int k = 0; k < s->count; k++) {
        int32_t i = j + d->bonds->shift[k];
        if (d->grid->kind[i] != PD_FLUID || !pdi_dissolve_free(d, i, s->count - 1 - k)) continue;
        sum += s->area[k] * (d->speed[i] + d->slope[i] * d->transport->c[i]);
    }
    return sum * pdi_dissolve_factor(d, j);
}

static pd_status pdi_dissolve_collect(pd_ctx *ctx, pd_dissolve *d)
{
    int32_t count = 0;
    for (int32_t j = 0; j < d->grid->total; j++) count += d->exposed[j];
    if (count > d->front_capacity) {
        int32_t fresh = count + count / 4 + 16;
        PDI_TRY(PDI_GROW(ctx, "dissolve", d->front_capacity, fresh, d->front));
        d->front_capacity = fresh;
    }
    d->front_count = 0;
    for (int32_t j = 0; j < d->grid->total; j++)
        if (d->exposed[j]) d->front[d->front_count++] = j;
    return PD_OK;
}

static int pdi_dissolve_is_exposed(const pd_dissolve *d, int32_t j)
{
    if (d->grid->kind[j] != PD_SOLID) return 0;
    for (int k = 0; k < d->bonds->stencil->count; k++)
        if (d->grid->kind[j + d->bonds->shift[k]] == PD_FLUID) return 1;
    return 0;
}

pd_status pd_dissolve_build(pd_ctx *ctx, pd_grid *grid, const pd_bonds *bonds, pd_transport *transport,
                            const pd_dissolve_desc *desc, pd_dissolve *d)
{
    memset(d, 0, sizeof *d);
    if (!(desc->solid > 0.0) || !(desc->solid < 1e100) || !(desc->threshold >= 0.0) || !(desc->threshold < 1.0) || !desc->rate)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                        "Cs = %g mol/m3 must be positive, the threshold %g lie in [0, 1), a rate law be given", desc->solid,
                        desc->threshold);
    d->desc = *desc;
    d->grid = grid;
    d->bonds = bonds;
    d->transport = transport;
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->exposed));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->weight));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->speed));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->slope));
    PDI_TRY(PDI_NEW(ctx, "dissolve", grid->total, d->loss));
    for (int32_t j = 0; j < grid->total; j++) {
        if (grid->kind[j] == PD_SOLID) transport->c[j] = desc->solid;
        d->exposed[j] = (uint8_t)pdi_dissolve_is_exposed(d, j);
    }
    return pdi_dissolve_collect(ctx, d);
}

/* The law near c: v = speed + slope c. It never deposits, and a rising law is taken at its present value. */
static pd_status pdi_dissolve_law(pd_ctx *ctx, pd_dissolve *d, int32_t i)
{
    double c = d->transport->c[i], step = 1e-4 * fmax(fabs(c), 1e-7 * d->desc.solid);
    double now = d->desc.rate(d->desc.rate_user, c), ahead = d->desc.rate(d->desc.rate_user, c + step);
    if (!(fabs(now) < 1e100) || !(fabs(ahead) < 1e100)) {
        double x[PD_DIM];
        pd_grid_position(d->grid, i, x);
        return pdi_fail(ctx, PD_ERR_STATE, "dissolve",
                        "the rate law gives %g m/s at c = %g mol/m3 (node %d at x = %g m), expected a finite speed", now, c,
                        (int)i, x[0]);
    }
    d->slope[i] = now > 0.0 ? fmin((ahead - now) / step, 0.0) : 0.0;
    d->speed[i] = fmax(now, 0.0) - d->slope[i] * c;
    return PD_OK;
}

pd_status pd_dissolve_prepare(pd_ctx *ctx, pd_dissolve *d)
{
    const pd_bonds *b = d->bonds;
    const pd_stencil *s = b->stencil;
    pd_transport *t = d->transport;
    for (int32_t i = 0; i < d->grid->total; i++) t->source[i] = t->absorb[i] = 0.0;
    for (int32_t r = 0; r < b->rows; r++) {
        int32_t i = b->node[r];
        double weight = 0.0;
        for (int k = 0; k < s->count; k++) {
            int32_t j = i + b->shift[k];
            if (d->grid->kind[j] == PD_SOLID && pdi_dissolve_free(d, i, k)) weight += s->area[k] * pdi_dissolve_factor(d, j);
        }
        d->weight[i] = weight * pdi_dissolve_span(d);
        if (!(weight > 0.0)) continue;
        PDI_TRY(pdi_dissolve_law(ctx, d, i));
        t->source[i] = d->weight[i] * d->speed[i];
        t->absorb[i] = -d->weight[i] * d->slope[i];
    }
    return PD_OK;
}

double pd_dissolve_fastest(pd_ctx *ctx, const pd_dissolve *d)
{
    double fastest = 0.0;
    (void)ctx;
    for (int32_t f = 0; f < d->front_count; f++) fastest = fmax(fastest, pdi_dissolve_rate(d, d->front[f]));
    return fastest;
}

/* What node j was charged beyond its content goes to its solid neighbours: the front has moved on to them. Debris
 * without neighbours owes it to the fluid around, which repays in the next step. */
static pd_status pdi_dissolve_hand_over(pd_ctx *ctx, pd_dissolve *d, int32_t j, double excess)
{
    const pd_stencil *s = d->bonds->stencil;
    double *c = d->transport->c, floor_content = d->desc.threshold * d->desc.solid;
    for (int pass = 0; pass < 2; pass++) {
        double sum = 0.0;
        uint8_t wanted = pass ? PD_FLUID : PD_SOLID;
        for (int give = 0; give < 2; give++) {
            for (int k = 0; k < s->count; k++) {
                int32_t i = j + d->bonds->shift[k];
                if (d->grid->kind[i] != wanted || (!pass && c[i] <= floor_content)) continue;
                double weight = s->area[k] * (pass ? 1.0 : pdi_dissolve_factor(d, i));
                if (!give) sum += weight;
                else if (pass) d->transport->carry[i] -= excess * weight / sum;
                else d->loss[i] += excess * weight / sum;
            }
            if (!(sum > 0.0)) break;
        }
        if (sum > 0.0) return PD_OK;
    }
    return pdi_fail(ctx, PD_ERR_INTERNAL, "dissolve", "node %d dissolved without any neighbour", (int)j);
}

static pd_status pdi_dissolve_note(pd_ctx *ctx, pd_dissolve *d, int32_t j)
{
    if (d->changed_count == d->changed_capacity) {
        int32_t fresh = d->changed_capacity * 2 + 64;
        PDI_TRY(PDI_GROW(ctx, "dissolve", d->changed_capacity, fresh, d->changed));
        d->changed_capacity = fresh;
    }
    d->changed[d->changed_count++] = j;
    return PD_OK;
}

/* Nodes within one bond of `j` may have become exposed. */
static void pdi_dissolve_expose(pd_dissolve *d, int32_t j)
{
    d->exposed[j] = 0;
    for (int k = 0; k < d->bonds->stencil->count; k++) {
        int32_t i = j + d->bonds->shift[k];
        if (d->grid->kind[i] == PD_SOLID) d->exposed[i] = 1;
    }
}

/* Take the losses from the contents and hand over what is too much, until no node is overdrawn. */
static pd_status pdi_dissolve_settle(pd_ctx *ctx, pd_dissolve *d)
{
    double *c = d->transport->c, floor_content = d->desc.threshold * d->desc.solid;
    for (int again = 1; again;) {
        int32_t first = d->changed_count;
        again = 0;
        for (int32_t j = 0; j < d->grid->total; j++) {
            if (d->grid->kind[j] != PD_SOLID || !(fabs(d->loss[j]) > 0.0)) continue;
            c[j] -= d->loss[j];
            d->loss[j] = 0.0;
            if (c[j] <= floor_content + PDI_DISSOLVE_EMPTY * d->desc.solid) PDI_TRY(pdi_dissolve_note(ctx, d, j));
        }
        for (int32_t n = first; n < d->changed_count; n++) {
            int32_t j = d->changed[n];
            double excess = floor_content - c[j];
            if (excess > 0.0) {
                PDI_TRY(pdi_dissolve_hand_over(ctx, d, j, excess));
                c[j] = floor_content;
                again = 1;
            }
        }
        for (int32_t n = first; n < d->changed_count; n++) pdi_grid_dissolve(d->grid, d->changed[n]);
    }
    return PD_OK;
}

pd_status pd_dissolve_finish(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    double span = pdi_dissolve_span(d);
    int nt = pdi_par_threads(ctx, (int64_t)d->front_count * d->bonds->stencil->count * 4);
    (void)nt;
    d->changed_count = 0;
    PDI_PARALLEL_FOR(nt)
    for (int32_t f = 0; f < d->front_count; f++) d->loss[d->front[f]] = dt * span * pdi_dissolve_rate(d, d->front[f]);
    PDI_TRY(pdi_dissolve_settle(ctx, d));
    if (!d->changed_count) return PD_OK;
    for (int32_t n = 0; n < d->changed_count; n++) pdi_dissolve_expose(d, d->changed[n]);
    return pdi_dissolve_collect(ctx, d);
}

double pd_dissolve_stock(pd_ctx *ctx, const pd_dissolve *d)
{
    pdi_sum sum = {0.0, 0.0};
    (void)ctx;
    for (int32_t j = 0; j < d->grid->total; j++)
        if (d->grid->kind[j] == PD_SOLID) pdi_sum_add(&sum, d->transport->c[j]);
    return pdi_sum_total(&sum) * d->bonds->stencil->volume;
}

void pd_dissolve_free(pd_ctx *ctx, pd_dissolve *d)
{
    int32_t total = d->grid ? d->grid->total : 0;
    PDI_DELETE(ctx, total, d->exposed);
    PDI_DELETE(ctx, total, d->weight);
    PDI_DELETE(ctx, total, d->speed);
    PDI_DELETE(ctx, total, d->slope);
    PDI_DELETE(ctx, total, d->loss);
    PDI_DELETE(ctx, d->front_capacity, d->front);
    PDI_DELETE(ctx, d->changed_capacity, d->changed);
    memset(d, 0, sizeof *d);
}
