/* dissolve: see dissolve.h */
#include "metal/dissolve.h"
#include "core/par.h"
#include "metal/content.h"
#include "metal/damage.h"
#include "metal/error.h"
#include "metal/moments.h"
#include "metal/tilt.h"
#include "transport/amount.h"
#include "transport/explicit.h"
#include <math.h>
#include <string.h>

/* Rounds in which law and transport have to agree, on a share of the fastest speed or of the field. */
#define PDI_DISSOLVE_ROUNDS 100
#define PDI_DISSOLVE_NEAR 1e-8
#define PDI_DISSOLVE_CLOSE 1e-10
/* Bonds: a speed is near, too, when a step of it changes less than this share of the concentration. */
#define PDI_DISSOLVE_MARGIN 3e-9
/* Bonds: the default of rtol. */
#define PDI_DISSOLVE_RTOL 1e-3
/* Slope of a rising law in the equations, over all else that a node exchanges. */
#define PDI_DISSOLVE_RISE 0.5
/* Metals whose laws touch 0 at concentrations within this share of each other touch it together. */
#define PDI_DISSOLVE_SAME 1e-9

/* ---- build ---- */

static pd_status pdi_dissolve_check_metal(pd_ctx *ctx, const pd_dissolve_desc *desc, const pd_metal *metal)
{
    if (!(metal->solid > 0.0) || !(metal->solid < 1e100) || !(desc->threshold >= 0.0) || !(desc->threshold < 1.0) ||
        !metal->rate)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                       "Cs = %g mol/m3 must be positive, the threshold %g lie in [0, 1), a rate law be given",
                       metal->solid, desc->threshold);
    if (desc->model != PD_METAL_BONDS) return PD_OK;
    if (!(metal->solid > desc->saturation) || !(desc->saturation > 0.0) || desc->threshold > 0.0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                       "Cs = %g, Csat = %g mol/m3 and a threshold of %g, expected Cs > Csat > 0 and no threshold",
                       metal->solid, desc->saturation, desc->threshold);
    return PD_OK;
}

static pd_metal pdi_dissolve_metal(const pd_dissolve_desc *desc, int m)
{
    pd_metal first;
    first.solid = desc->solid;
    first.rate = desc->rate;
    first.rate_user = desc->rate_user;
    first.uniform = desc->uniform;
    first.timeless = desc->timeless;
    first.bounds = desc->bounds;
    first.breaks = desc->breaks;
    first.break_count = desc->break_count;
    return m ? desc->more[m - 1] : first;
}

static pd_status pdi_dissolve_check(pd_ctx *ctx, const pd_dissolve_desc *desc, int given)
{
    if (desc->more_count < 0 || desc->more_count >= PDI_LAW_METALS || (desc->more_count && !desc->more))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve", "%d metals beside the first one, expected 0 to %d and their "
                       "list", desc->more_count, PDI_LAW_METALS - 1);
    for (int m = 0; m <= desc->more_count; m++) {
        pd_metal metal = pdi_dissolve_metal(desc, m);
        PD_TRY(pdi_dissolve_check_metal(ctx, desc, &metal));
    }
    if (given && (desc->model == PD_METAL_SURFACE || !desc->activation))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve", "the field of transport is given, but not by activation");
    if (desc->model == PD_METAL_SURFACE) return PD_OK;
    if (desc->model != PD_METAL_BONDS || desc->sheds > 1)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve", "model %d, expected 0 or 1, and 0 where each metal sheds for "
                       "itself", (int)desc->model);
    if (!(desc->bulk >= 0.0) || desc->bulk > desc->saturation || !(desc->rtol >= 0.0) || !(desc->rtol < 1.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                       "bulk = %g mol/m3 and rtol = %g, expected 0 to Csat = %g mol/m3 and 0 to below 1", desc->bulk,
                       desc->rtol, desc->saturation);
    if (!(desc->repassivation >= 0.0) || desc->repassivation > desc->saturation)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                       "repassivation below %g mol/m3, expected 0 to Csat = %g mol/m3", desc->repassivation,
                       desc->saturation);
    if ((int)desc->drive < PD_DRIVE_CONSTANT || (int)desc->drive > PD_DRIVE_DIFFERENCE)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve", "drive %d, expected 0 or 1", (int)desc->drive);
    return PD_OK;
}

PDI_FN void pdi_dissolve_list(pdi_array_visitor *owner, void *object)
{
    pd_dissolve *dissolve = (pd_dissolve *)object;
    if (!dissolve->grid) return;
    const pd_dissolve_desc *desc = &dissolve->desc;
    int64_t total = dissolve->grid->total;
    int bonds = desc->model == PD_METAL_BONDS, stochastic = bonds && desc->stochastic;
    PDI_ARRAY(owner, dissolve, kind, dissolve->kinds, "");
    PDI_ARRAY(owner, dissolve, front, dissolve->capacity, "1");
    PDI_ARRAY(owner, dissolve, changed, dissolve->capacity, "1");
    PDI_ARRAY(owner, dissolve, piece, dissolve->capacity, "1");
    if (dissolve->timed) PDI_ARRAY(owner, dissolve, moment, PDI_MOMENTS_MOST, "s");
    if (dissolve->timed) PDI_ARRAY(owner, dissolve, part, PDI_MOMENTS_MOST, "1");
    PDI_ARRAY(owner, dissolve, mark, total, "1");
    PDI_ARRAY(owner, dissolve, exposed, total, "1");
    PDI_ARRAY(owner, dissolve, rate, total, "1/s");
    PDI_ARRAY(owner, dissolve, slot, total, "1");
    if (PD_DIM > 1 && desc->weights == PD_WEIGHTS_CALIBRATED) PDI_ARRAY(owner, dissolve, facing, total * PD_DIM, "1");
    if (PD_DIM > 1 && desc->weights == PD_WEIGHTS_CALIBRATED) PDI_ARRAY(owner, dissolve, tilt, total, "1");
    if (bonds && desc->repassivation > 0.0) PDI_ARRAY_STATE(owner, dissolve, film, total, "1");
    if (bonds && !desc->activation) PDI_ARRAY_STATE(owner, dissolve, moved, total, "mol/m3");
    int64_t sheds = desc->sheds > 1 ? dissolve->kinds * total : total;
    if (desc->sheds && !desc->lags) PDI_ARRAY(owner, dissolve, shed, sheds, "mol/m3");
    if (desc->sheds && desc->lags) PDI_ARRAY_STATE(owner, dissolve, shed, sheds, "mol/m3");
    if (stochastic) PDI_ARRAY(owner, dissolve, links, total, "1");
    if (stochastic) PDI_ARRAY(owner, dissolve, last, total, "mol/m3");
    PDI_SCALAR_STATE(owner, dissolve, next_dt, "s");
    PDI_SCALAR_STATE(owner, dissolve, last_dt, "s");
    PDI_SCALAR_STATE(owner, dissolve, lean, "mol");
    PDI_SCALAR_STATE(owner, dissolve, stray, "mol");
    PDI_SCALAR_STATE(owner, dissolve, last_speed, "mol/s");
    PDI_SCALAR_STATE(owner, dissolve, drift, "mol/s");
    PDI_SCALAR_STATE(owner, dissolve, turned, "1");
    PDI_SCALAR_STATE(owner, dissolve, out, "mol");
    PDI_SCALAR_STATE(owner, dissolve, in, "mol");
    PDI_SCALAR_STATE(owner, dissolve, krylov, "1");
    PDI_SCALAR_STATE(owner, dissolve, result.limiter, "1");
    PDI_SCALAR_STATE(owner, dissolve, result.change, "1");
}

/* Mechanical bonds of solid nodes, and the content at which the last of them breaks. */
static void pdi_dissolve_links(const pd_ctx *ctx, pd_dissolve *d)
{
    const pd_stencil *s = d->paths.stencil;
    int nt = pd_par_threads(ctx, (int64_t)d->grid->solid_count * s->count);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t j = 0; j < d->grid->total; j++) {
        int links = 0;
        if (d->grid->kind[j] != PD_SOLID) continue;
        for (int k = 0; k < s->count; k++) links += d->grid->kind[pdi_entry_far(&d->paths, j, k)] == PD_SOLID;
        d->links[j] = (uint16_t)links;
        double supply = pdi_metal_solid(d, j) - d->desc.saturation;
        d->last[j] = d->desc.saturation + (1.0 - pdi_damage_last(d->desc.seed, j, links)) * supply;
    }
}

/* The metals: with bonds they turn at saturation. */
static pd_status pdi_dissolve_kinds(pd_ctx *ctx, pd_dissolve *d)
{
    d->uniform = 1;
    for (int m = 0; m < d->kinds; m++) {
        pdi_metal_kind *kind = &d->kind[m];
        kind->law = pdi_dissolve_metal(&d->desc, m);
        kind->solid = kind->law.solid;
        double threshold = pdi_metal_bonds(d) ? d->desc.saturation / kind->solid : d->desc.threshold;
        kind->end = threshold * kind->solid;
        kind->supply = kind->solid * (1.0 - threshold);
        kind->from = HUGE_VAL;
        kind->touch = -1.0;
        if (pdi_metal_bonds(d)) kind->ratio = log(kind->solid / d->desc.saturation);
        d->uniform = d->uniform && kind->law.uniform;
    }
    d->desc.more = NULL;
    for (int32_t j = 0; j < d->grid->total; j++)
        if (d->grid->kind[j] == PD_SOLID && pdi_metal_of(d, j) >= d->kinds)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve", "node %d is of metal %d, expected 0 to %d", (int)j,
                           pdi_metal_of(d, j), d->kinds - 1);
    return PD_OK;
}

PDI_COLD_BEGIN
static pd_status pdi_dissolve_make(pd_ctx *ctx, pd_grid *grid, const pd_stencil *s, pd_transport *transport,
                                   const pd_dissolve_desc *desc, pd_dissolve *d)
{
    const pd_stencil *own = transport->bonds->stencil;
    memset(d, 0, sizeof *d);
    PD_TRY(pdi_dissolve_check(ctx, desc, transport->desc.given));
    if (desc->model == PD_METAL_SURFACE && s->m < own->m)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve",
                       "the metal has a horizon of %g spacings, expected at least the %g of the transport", s->m,
                       own->m);
    d->desc = *desc;
    d->grid = grid;
    PD_TRY(pdi_bond_path_build(ctx, s, grid, &d->paths));
    d->transport = transport;
    d->weight = s->area_weight;
    if (pdi_metal_bonds(d)) {
        if (!(desc->rtol > 0.0)) d->desc.rtol = PDI_DISSOLVE_RTOL;
        PD_TRY(pdi_front_build(ctx, s, desc->kernel, desc->weights, &d->kernel));
        d->weight = d->kernel.weight;
    }
    d->kinds = desc->more_count + 1;
    d->capacity = (int32_t)grid->solid_count;
    for (int m = 0; m < d->kinds; m++) {
        pd_metal metal = pdi_dissolve_metal(desc, m);
        d->timed = d->timed || (!metal.uniform && !metal.timeless);
    }
    PD_TRY(pdi_array_registry_build(ctx, pdi_dissolve_list, d));
    PD_TRY(pdi_dissolve_kinds(ctx, d));
    d->next_dt = HUGE_VAL;
    for (int32_t j = 0; j < grid->total; j++) {
        if (grid->kind[j] == PD_SOLID) transport->c[j] = pdi_metal_solid(d, j);
        if (grid->kind[j] == PD_FLUID && desc->activation) transport->c[j] = desc->bulk;
        d->exposed[j] = (uint8_t)pdi_content_is_exposed(d, j);
        d->slot[j] = -1;
        if (d->tilt) d->tilt[j] = 1.0f;
    }
    if (d->links) pdi_dissolve_links(ctx, d);
    for (int32_t j = 0; j < grid->total && desc->factor; j++)
        if (grid->kind[j] == PD_SOLID && (!(desc->factor[j] >= 0.0) || !(desc->factor[j] < 1e100)))
            return pd_fail(ctx, PD_ERR_ARGUMENT, "dissolve", "node %d has the factor %g, expected a finite one of at "
                           "least 0", (int)j, desc->factor[j]);
    d->lead = pdi_content_lead(s);
    for (int k = 0; k < own->count; k++) d->spread += own->laplacian_weight[k];
    pdi_content_collect(d);
    return pdi_reach_make_room(ctx, d, d->front_count + 1);
}

pd_status pd_dissolve_build(pd_ctx *ctx, pd_grid *grid, const pd_stencil *stencil, pd_transport *transport,
                            const pd_dissolve_desc *desc, pd_dissolve *d)
{
    pd_status status = pdi_dissolve_make(ctx, grid, stencil, transport, desc, d);
    if (status < 0) pd_dissolve_free(ctx, d);
    return status;
}
PDI_COLD_END

/* ---- the law ---- */

static pd_status pdi_dissolve_unlawful(pd_ctx *ctx, const pd_dissolve *d, pdi_law *law, int32_t i)
{
    char place[PDI_GRID_POSITION_LENGTH];
    double c = law->at.c;
    return pd_fail(ctx, PD_ERR_STATE, "dissolve",
                   "the rate law gives %g m/s at c = %g mol/m3, t = %g s (node %d at %s m), expected a speed below "
                   "1e100 m/s",
                   pdi_law_rate(law, c), c, d->time, (int)i, pdi_grid_format_position(d->grid, i, place));
}

/* The metal of uniform law that is alone beside the node; NULL: there are several, or it is another law. */
static pdi_metal_kind *pdi_dissolve_alone(const pd_dissolve *d, const pdi_beside *beside)
{
    pdi_metal_kind *found = NULL;
    for (int m = 0; m < d->kinds; m++) {
        if (!(pdi_metal_portion(d, beside)[m].weight > 0.0)) continue;
        if (found || !d->kind[m].law.uniform) return NULL;
        found = &d->kind[m];
    }
    return found;
}

/* A node where that metal alone is at the same concentration. There is no film, and it has the same line. NULL: none is
 * known. */
static const pdi_beside *pdi_dissolve_like(const pd_dissolve *d, const pdi_metal_kind *alone, double c)
{
    if (!alone || alone->like < 0 || !pdi_metal_bonds(d) || d->desc.drive != PD_DRIVE_CONSTANT) return NULL;
    const pdi_beside *like = &d->beside[alone->like];
    double known = pd_max(d->transport->c[like->node], 0.0);
    return known < c || known > c ? NULL : like;
}

/* Where the laws of all metals beside a node touch 0; 0: nowhere. A law is looked at once, and where it depends on more
 * than the concentration that is held against it as it is at the node. */
static double pdi_dissolve_touch(pd_dissolve *d, const pdi_beside *beside, const pdi_law *law, int alone)
{
    const pdi_metal_beside *portion = pdi_metal_portion(d, beside);
    pdi_law one = *law;
    double touch = -1.0;
    int n = 0;
    one.touch = 0.0;
    for (int m = 0; m < d->kinds && n < law->metals; m++) {
        pdi_metal_kind *kind = &d->kind[m];
        if (!((beside->weight > 0.0 ? portion[m].weight : portion[m].enters) > 0.0)) continue;
        one.metals = 1;
        one.metal[0] = law->metal[n++];
        if (kind->touch < 0.0 && pdi_law_rate(&one, 0.0) > 0.0) kind->touch = pdi_law_touch_point(&one);
        if (!(kind->touch > 0.0) || (touch > 0.0 && fabs(touch - kind->touch) > PDI_DISSOLVE_SAME * touch)) return 0.0;
        touch = pd_max(touch, kind->touch);
    }
    one = *law;
    return touch > 0.0 && (alone || pdi_law_touches(&one, touch)) ? touch : 0.0;
}

/* The first line of the law at a node beside metal. */
static pd_status pdi_dissolve_begin_law(pd_ctx *ctx, pd_dissolve *d, pdi_beside *beside)
{
    pdi_law law;
    double c = pd_max(d->transport->c[beside->node], 0.0);
    pdi_metal_kind *alone = pdi_dissolve_alone(d, beside);
    const pdi_beside *like = pdi_dissolve_like(d, alone, c);
    if (like) {
        beside->touch = like->touch;
        beside->point = like->point;
        beside->before = like->before;
        return PD_OK;
    }
    pdi_interface_law(d, beside, &law);
    beside->touch = law.touch = pdi_dissolve_touch(d, beside, &law, alone != NULL);
    if (alone && !(c >= alone->from && c < alone->to)) {
        alone->from = c;
        alone->to = pd_min(pdi_law_end(&law, c, law.top), law.limit);
        if (law.touch > c) alone->to = pd_min(alone->to, law.touch);
    }
    double from = alone ? alone->from : c, to = alone ? alone->to : 0.0;
    if (!alone && law.touch > c) to = pd_min(pdi_law_end(&law, c, law.touch), law.touch);
    if (!pdi_law_begin(&law, pdi_interface_resist(d, beside), from, to, c, &beside->point))
        return pdi_dissolve_unlawful(ctx, d, &law, beside->node);
    beside->before = pdi_interface_line(d, beside);
    if (alone) alone->like = (int32_t)(beside - d->beside);
    return PD_OK;
}

/* What the lines make of the equations of transport. Nodes at a jump of the law hold its concentration, until the
 * speeds are settled. */
static void pdi_dissolve_sources(pd_dissolve *d, double dt, int settled)
{
    pd_transport *t = d->transport;
    t->ceiling = 0.0; /* where the lines end */
    t->pinned_count = 0;
    for (int32_t k = 0; k < d->beside_count; k++) {
        pdi_beside *beside = &d->beside[k];
        if (dt > 0.0 && beside->weight > 0.0) {
            double own = 1.0 / dt + pdi_interface_diffusivity(d, beside->node) * d->spread;
            pdi_law_tame(PDI_DISSOLVE_RISE * own / beside->weight, &beside->point);
        }
        double source = beside->weight * beside->point.speed, absorb = -beside->weight * beside->point.slope;
        if (beside->point.pinned && !settled) {
            t->pinned[t->pinned_count++] = beside->node;
            t->c[beside->node] = beside->point.pin;
            source = 0.0;
        }
        t->source[beside->node] = source + beside->given;
        t->absorb[beside->node] = absorb;
        if (source > 0.0 || absorb < 0.0)
            t->ceiling = pd_max(t->ceiling, absorb > 0.0 ? source / absorb : HUGE_VAL);
    }
    /* a last solve at rest follows lines that have met their laws, which end at saturation */
    if (pdi_metal_bonds(d) && !t->flow) t->ceiling = pd_min(t->ceiling, d->desc.saturation);
}

/* Films form where fluid beside metal is below the threshold; how many are new. */
static int32_t pdi_dissolve_films(pd_dissolve *d)
{
    int32_t formed = 0;
    for (int32_t k = 0; k < d->beside_count && d->film; k++) {
        int32_t i = d->beside[k].node;
        if (d->film[i] || !(d->transport->c[i] < d->desc.repassivation)) continue;
        d->film[i] = 1;
        formed++;
    }
    return formed;
}

pd_status pd_dissolve_prepare(pd_ctx *ctx, pd_dissolve *d)
{
    pd_transport *t = d->transport;
    int stays = pdi_interface_stays(d);
    d->rated = 0;
    if (stays) {
        memset(d->mark, 0, (size_t)d->grid->total);
        return PD_OK;
    }
    pdi_par_zero(ctx, d->grid->total, t->source);
    pdi_par_zero(ctx, d->grid->total, t->absorb);
    for (int m = 0; m < d->kinds; m++) d->kind[m].like = -1;
    pdi_tilt_update(ctx, d);
    PD_TRY(pdi_interface_land(ctx, d));
    if (pdi_dissolve_films(d)) {
        d->reached = 0;
        PD_TRY(pdi_interface_land(ctx, d));
    }
    memset(d->mark, 0, (size_t)d->grid->total);
    d->gone_count = 0;
    if (d->desc.found) PD_TRY(d->desc.found(ctx, d->desc.found_user, d->time));
    for (int32_t k = 0; k < d->beside_count; k++)
        if (d->beside[k].weight > 0.0) PD_TRY(pdi_dissolve_begin_law(ctx, d, &d->beside[k]));
    if (!(d->last_dt > 0.0) && d->moved) d->next_dt = pd_transport_limit(ctx, t);
    pdi_interface_means(d);
    pdi_dissolve_sources(d, 0.0, 1);
    return PD_OK;
}

/* Rates of the exposed nodes by the speeds that there are. */
static void pdi_dissolve_find_rates(const pd_ctx *ctx, pd_dissolve *d)
{
    int nt = pd_par_threads(ctx, (int64_t)d->front_count * d->paths.stencil->count * 4);
    (void)nt;
    if (pdi_interface_stays(d)) return;
    int all = !pdi_interface_lasts(d);
    PD_PARALLEL_FOR(nt)
    for (int32_t f = 0; f < d->front_count; f++) {
        int32_t j = d->front[f];
        if (d->mark[j] & PDI_CONTENT_GONE) continue;
        if (all || d->rate[j] < 0.0) d->rate[j] = pdi_interface_rate(d, f);
    }
    pdi_interface_rated(d);
}

/* What steps are chosen for at exposed node f, by the rates that were found last [1/s]. */
static double pdi_dissolve_pace(const pd_dissolve *d, int32_t f)
{
    return d->desc.drive == PD_DRIVE_CONSTANT ? d->rate[d->front[f]] : pdi_interface_pace(d, f);
}

PDI_FN double pdi_dissolve_fastest(pd_ctx *ctx, pd_dissolve *d)
{
    double fastest = 0.0;
    if (d->desc.drive == PD_DRIVE_CONSTANT) pdi_dissolve_find_rates(ctx, d);
    for (int32_t f = 0; f < d->front_count; f++) fastest = pd_max(fastest, pdi_dissolve_pace(d, f));
    return fastest;
}

/* ---- law and transport of a step together ---- */

static void pdi_dissolve_rates(const pd_ctx *ctx, pd_dissolve *d)
{
    if (!pdi_interface_stays(d)) {
        pdi_interface_means(d);
        pdi_dissolve_find_rates(ctx, d);
    }
    d->rated = 1;
}

/* *met: 1 when the lines have at the present field the speeds of the law. Otherwise there are new lines. */
static pd_status pdi_dissolve_meet(pd_ctx *ctx, pd_dissolve *d, double dt, int *met)
{
    const pd_transport *t = d->transport;
    double fastest = 0.0;
    *met = 1;
    if (t->pinned_count) pdi_transport_residual(ctx, t, t->work);
    for (int32_t k = 0; k < d->beside_count; k++) fastest = pd_max(fastest, d->beside[k].point.largest);
    for (int32_t k = 0; k < d->beside_count; k++) {
        pdi_beside *beside = &d->beside[k];
        pdi_law law;
        if (!(beside->weight > 0.0)) continue;
        pdi_interface_law(d, beside, &law);
        double near = PDI_DISSOLVE_NEAR * fastest, held = near;
        if (pdi_metal_bonds(d)) { /* what a node holds beyond its law goes to the next step, and raises its field */
            held = PDI_DISSOLVE_MARGIN * t->size / (dt * beside->weight);
            near = pd_max(near, held);
        }
        double need = -t->work[beside->node] / beside->weight;
        int found = beside->point.pinned ? pdi_law_meet_pinned(&law, need, held, &beside->point)
                                         : pdi_law_meet(&law, t->c[beside->node], near, PDI_DISSOLVE_CLOSE * t->size,
                                                        &beside->point);
        if (found < 0) return pdi_dissolve_unlawful(ctx, d, &law, beside->node);
        *met &= found;
    }
    return PD_OK;
}

/* 1: no node that lasts loses more than it may. */
static int pdi_dissolve_moderate(pd_dissolve *d, double lost, double dt)
{
    if (!(d->most > 0.0) || lost <= d->most) return 1;
    d->retry_dt = 0.5 * dt * d->most / lost;
    return 0;
}

/* PD_OK: the step stands; PD_RETRY: it does not. */
static pd_status pdi_dissolve_stands(pd_ctx *ctx, pd_dissolve *d, double dt, pd_transport_result *result)
{
    double lost = 0.0;
    for (int32_t f = 0; f < d->front_count; f++)
        if (!(d->mark[d->front[f]] & PDI_CONTENT_GONE)) lost = pd_max(lost, dt * pdi_dissolve_pace(d, f));
    return pdi_dissolve_moderate(d, lost, dt) ? pdi_error_stands(ctx, d, lost, dt, result) : PD_RETRY;
}

/* Law and transport of a step together. */
static pd_status pdi_dissolve_solve(pd_ctx *ctx, pd_dissolve *d, double dt, pd_transport_result *result)
{
    pd_transport *t = d->transport;
    pd_status status = PD_OK;
    int krylov = 0, met = !pdi_metal_bonds(d);
    for (d->rounds = 1; d->rounds <= PDI_DISSOLVE_ROUNDS; d->rounds++) {
        t->rough = !met;
        if (!d->desc.activation) {
            pdi_dissolve_sources(d, dt, 0);
            status = pdi_transport_stage(ctx, t, dt, 1, result);
            result->krylov = krylov += result->krylov;
            if (status < 0) return status;
            PD_TRY(pdi_dissolve_meet(ctx, d, dt, &met));
            if (!met || t->rough) continue;
        }
        pdi_dissolve_rates(ctx, d);
        /* less metal leaves less in the fluid, so others give more: each round finds new pieces, or is the last one */
        if (pdi_content_spare(d, dt)) continue;
        pd_status stands = pdi_dissolve_stands(ctx, d, dt, result);
        return stands == PD_OK ? status : stands;
    }
    d->retry_dt = 0.5 * dt;
    return PD_RETRY;
}

/* The speeds that were found stand for the lines: what metal loses and fluid gains is the same number. Where a line is
 * steeper than all that the fluid does, its concentration gives the speed to few digits, and the balance of the node
 * gives it. */
static void pdi_dissolve_final_speeds(const pd_ctx *ctx, pd_dissolve *d, double dt)
{
    const pd_transport *t = d->transport;
    if (!t->pinned_count) pdi_transport_residual(ctx, t, t->work); /* else it is that of the last round */
    for (int32_t k = 0; k < d->beside_count; k++) {
        const pdi_beside *beside = &d->beside[k];
        pdi_law_point *p = &d->beside[k].point;
        if (p->pinned) continue;
        double own = 1.0 / dt + pdi_interface_diffusivity(d, beside->node) * d->spread;
        double speed = pdi_interface_line(d, beside);
        if (-p->slope * beside->weight > own) speed = pd_max(speed - t->work[beside->node] / beside->weight, 0.0);
        p->speed = speed;
        p->slope = 0.0;
    }
    pdi_dissolve_sources(d, dt, 1);
    pdi_dissolve_rates(ctx, d);
}

PDI_FN pd_status pdi_dissolve_transport(pd_ctx *ctx, pd_dissolve *d, double dt, pd_transport_result *result)
{
    pd_transport *t = d->transport;
    memset(result, 0, sizeof *result);
    if (d->desc.activation) {
        pd_status status = pdi_dissolve_solve(ctx, d, dt, result);
        t->pinned_count = 0;
        return status;
    }
    PD_TRY(pdi_transport_begin(ctx, t, dt));
    pd_status status = pdi_error_held(ctx, d, dt);
    if (status >= 0) status = pdi_dissolve_solve(ctx, d, dt, result);
    if (status >= 0 && status != PD_RETRY) pdi_dissolve_final_speeds(ctx, d, dt);
    t->pinned_count = 0;
    t->rough = 0;
    return pdi_transport_end(ctx, t, dt, status);
}

/* After the transport step of dt [s]: take the losses from the solid, turn empty nodes fluid (grid kinds and ghosts
 * change; bonds, flow and transport are the caller's to update with d->changed). */
static pd_status pdi_dissolve_finish(pd_ctx *ctx, pd_dissolve *d, double dt)
{
    if (!d->rated) pdi_dissolve_rates(ctx, d);
    d->rated = 0;
    pd_status status = pdi_content_finish(ctx, d, dt);
    d->turned = d->changed_count;
    return status;
}

PDI_FN double pdi_dissolve_damage(const pd_dissolve *d, int32_t i)
{
    if (d->grid->kind[i] == PD_FLUID) return 1.0;
    if (d->grid->kind[i] != PD_SOLID) return 0.0;
    double lost = (pdi_metal_solid(d, i) - d->transport->c[i]) / pdi_metal_supply(d, i);
    lost = pd_min(pd_max(lost, 0.0), 1.0);
    return d->links ? pdi_damage_broken(d->desc.seed, i, d->links[i], lost) : lost;
}

/* ---- the process ---- */

/* A node may lose this many times the share that steps are chosen for, where the law speeds up. */
#define PDI_DISSOLVE_EXCESS 2.0
/* Share of the longest step by which its first time lies behind its start. */
#define PDI_DISSOLVE_BEHIND 1e-9
/* A step that is below this share of the wanted one has failed. */
#define PDI_DISSOLVE_SHORTEST 1e-9

PDI_COLD_BEGIN
static pd_status pdi_dissolve_start(pd_ctx *ctx, void *self, double t)
{
    return pdi_transport_at(ctx, ((pd_dissolve *)self)->transport, t);
}

/* Laws that depend on time: the instants at which a step takes them. Returns the factor that makes the step short
 * enough; 1: it is. No node may lose more than the step may take. */
static double pdi_dissolve_shorten(pd_dissolve *d, const pd_step *s)
{
    double taken;
    if (!d->moment) return 1.0;
    double factor = pdi_moments_find(d, s->time, s->dt, &taken), share = taken / s->max_dissolved_fraction;
    if (factor < 1.0) return factor;
    return share <= 1.0 + 1e-9 ? 1.0 : pd_max(0.9 / share, 0.1);
}

PDI_FN pd_status pdi_dissolve_mean(pd_ctx *ctx, pd_dissolve *d, double t, double dt)
{
    double taken;
    if (d->moment && pdi_moments_find(d, t, dt, &taken) < 1.0) return PD_RETRY;
    pd_status status = pd_dissolve_prepare(ctx, d);
    d->moments = 0;
    return status;
}

/* A step that is so short. */
static double pdi_dissolve_shortened(pd_dissolve *d, const pd_step *s)
{
    pd_step step = *s;
    for (double factor = 0.0; factor < 1.0; step.dt *= factor) factor = pdi_dissolve_shorten(d, &step);
    d->moments = 0;
    return step.dt;
}

/* The longest admissible step. */
static pd_status pdi_dissolve_longest(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_dissolve *d = (pd_dissolve *)self;
    d->most = PDI_DISSOLVE_EXCESS * s->max_dissolved_fraction;
    d->rtol = pdi_metal_bonds(d) ? d->desc.rtol : s->rtol;
    d->lost = s->dissolved;
    d->time = s->time;
    d->moments = 0;
    d->longest = 0.0;
    PD_TRY(pd_dissolve_prepare(ctx, d));
    pdi_error_judge(d);
    if (d->desc.driven) { /* behind a jump of what is given, at which the last step has ended */
        d->time += PDI_DISSOLVE_BEHIND * s->dt;
        PD_TRY(pd_dissolve_prepare(ctx, d));
    }
    double fastest = pdi_dissolve_fastest(ctx, d);
    if (fastest > 0.0) s->dt = pd_min(s->dt, s->max_dissolved_fraction / fastest);
    pdi_error_begin(d, s->dt);
    s->dt = pd_min(s->dt, d->next_dt);
    PD_TRY(pdi_physics_limit_max_step(ctx, self, s));
    if (d->desc.lags && !d->desc.found) s->dt = pdi_dissolve_shortened(d, s);
    return PD_OK;
}

static pd_status pdi_dissolve_limit(pd_ctx *ctx, void *self, pd_step *s)
{
    PD_TRY(pdi_dissolve_longest(ctx, self, s));
    s->dt = pdi_physics_equal_steps(s->latest_end - s->time, s->dt);
    return PD_OK;
}

static pd_status pdi_dissolve_attempt(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_dissolve *d = (pd_dissolve *)self;
    double end = s->time + s->dt;
    s->error = pdi_dissolve_shorten(d, s);
    if (s->error < 1.0) {
        d->moments = 0;
        return PD_RETRY;
    }
    if (!d->uniform || d->longest > 0.0) { /* what changes in time is taken at the middle of the step */
        d->time = s->time + 0.5 * s->dt;
        PD_TRY(pd_dissolve_prepare(ctx, d));
        pdi_error_middle(d);
    }
    if (s->solve_at) PD_TRY(s->solve_at(ctx, s->solve_at_user, end));
    PD_TRY(pdi_transport_at(ctx, d->transport, end));
    pd_status status = pdi_dissolve_transport(ctx, d, s->dt, &d->result);
    d->krylov += status < 0 ? 0 : d->result.krylov;
    d->longest = pd_max(d->longest, s->dt);
    return status;
}

static pd_status pdi_dissolve_reject(pd_ctx *ctx, void *self, pd_step *s)
{
    const pd_dissolve *d = (const pd_dissolve *)self;
    double left = s->latest_end - s->time;
    if (s->error < 1.0) {
        s->dt = pdi_physics_equal_steps(left, s->dt * s->error);
        return PD_OK;
    }
    if (d->retry_dt < PDI_DISSOLVE_SHORTEST * d->longest)
        return pd_fail(ctx, PD_ERR_DIVERGED, "dissolve",
                       "at t = %g s law and transport have no common solution for steps of %g s or more, or the law "
                       "grows so fast that metal would lose more than %g of a cell in them. Take a smoother law",
                       s->time, s->dt, d->most);
    s->dt = pdi_physics_equal_steps(left, d->retry_dt);
    return PD_OK;
}

/* What a node beside metal has got in a step of dt [s]; lines have no slope any more. */
static void pdi_dissolve_shed(const pd_dissolve *d, const pdi_beside *beside, double dt)
{
    const pdi_metal_beside *portion = pdi_metal_portion(d, beside);
    if (d->desc.sheds < 2) d->shed[beside->node] += dt * d->transport->source[beside->node];
    for (int m = 0; m < d->kinds && d->desc.sheds > 1; m++) {
        double speed = portion[m].weight > 0.0 ? portion[m].speed : 0.0;
        pdi_metal_shed(d, m)[beside->node] += dt * (portion[m].weight * speed + portion[m].stock);
    }
}

static pd_status pdi_dissolve_accept(pd_ctx *ctx, void *self, pd_step *s)
{
    pd_dissolve *d = (pd_dissolve *)self;
    d->out += s->dt * d->transport->outflow;
    d->in += s->dt * d->transport->inflow;
    pdi_error_end(d, s->dt);
    for (int32_t k = 0; k < d->beside_count && d->shed; k++) pdi_dissolve_shed(d, &d->beside[k], s->dt);
    PD_TRY(pdi_dissolve_finish(ctx, d, s->dt));
    d->moments = 0;
    for (int32_t k = 0; k < d->changed_count && d->shed; k++) {
        int32_t j = d->changed[k];
        pdi_metal_shed(d, pdi_metal_of(d, j))[j] += d->transport->c[j];
    }
    d->out += d->rinsed;
    s->converted_nodes = d->changed;
    s->converted_count = d->changed_count;
    if (d->desc.anew) s->ends_substeps = 1;
    return PD_OK;
}

static pd_status pdi_dissolve_stuck(pd_ctx *ctx, void *self, const pd_step *s)
{
    (void)self;
    return pd_fail(
        ctx, PD_ERR_STATE, "dissolve",
        "steps of %g s do not lead on from t = %g s to %g s: max_dissolved_fraction (%g) or max_step (%g s) is too "
        "small, or the metal dissolves too fast",
        s->dt, s->time, s->latest_end, s->max_dissolved_fraction, s->max_step);
}

static pd_status pdi_dissolve_changed(pd_ctx *ctx, void *self, const int32_t *turned, int32_t count)
{
    pd_dissolve *d = (pd_dissolve *)self;
    PD_TRY(pd_transport_update(ctx, d->transport));
    if (turned != d->changed) pdi_content_turned(d, turned, count); /* its own nodes it knows */
    return PD_OK;
}

static pd_status pdi_dissolve_store(pd_ctx *ctx, void *self, pd_archive *archive)
{
    pd_dissolve *d = (pd_dissolve *)self;
    if (archive->is_reading) d->reached = d->tilted = 0; /* films may be read */
    PD_TRY(pdi_transport_store(ctx, d->transport, archive));
    for (int m = 0; m < d->kinds; m++)
        PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "where a law touches 0", &d->kind[m].touch, 1));
    return pdi_array_registry_store(ctx, pdi_dissolve_list, d, archive);
}

static void pdi_dissolve_balance(pd_ctx *ctx, void *self, int k, pd_amounts *a)
{
    const pd_dissolve *d = (const pd_dissolve *)self;
    (void)k;
    double volume;
    a->solid += pdi_content_stock(ctx, d, &volume);
    a->volume += volume;
    a->dissolved += pd_transport_stock(ctx, d->transport);
    a->undelivered += pd_transport_carried(ctx, d->transport);
    a->out += d->out;
    a->in += d->in;
}

pd_physics pd_dissolve_process(pd_dissolve *d)
{
    pd_physics p;
    memset(&p, 0, sizeof p);
    p.name = "dissolution";
    p.self = d;
    p.element = pdi_transport_element();
    p.elements = 1;
    p.start = pdi_dissolve_start;
    p.max_run_step = pdi_dissolve_longest;
    p.limit = pdi_dissolve_limit;
    p.attempt = pdi_dissolve_attempt;
    p.accept = pdi_dissolve_accept;
    p.reject = pdi_dissolve_reject;
    p.report_underflow = pdi_dissolve_stuck;
    p.nodes_converted = pdi_dissolve_changed;
    p.checkpoint = pdi_dissolve_store;
    p.add_amounts = pdi_dissolve_balance;
    return p;
}
PDI_COLD_END

void pd_dissolve_free(pd_ctx *ctx, pd_dissolve *d)
{
    pdi_front_free(ctx, &d->kernel);
    pdi_array_registry_free(ctx, pdi_dissolve_list, d);
    pdi_array_registry_free(ctx, pdi_reach_beside_list, d);
    pdi_array_registry_free(ctx, pdi_reach_list, d);
    pdi_bond_path_free(ctx, &d->paths);
    memset(d, 0, sizeof *d);
}
