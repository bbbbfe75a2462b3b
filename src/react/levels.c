/* levels: see levels.h
 *
 * Design: a potential is no unknown of the linear systems. It is found within each residual, and its change is taken
 * out of their rows: a change of rank one for each circuit, which GMRES meets in a step or two.
 */
#include "react/levels.h"
#include "core/vec.h"
#include "react/layer.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PDI_LEVELS_STEPS 200
/* [V] First stride of a search, and the farthest potential beyond those of the fluid beside the metal. */
#define PDI_LEVELS_STRIDE 0.05
#define PDI_LEVELS_FAR 10.0
/* [V] Its first move at least, which grows fourfold. */
#define PDI_LEVELS_LEAST 1e-12
/* Share of the currents of a circuit that their sum may be off by, and a potential, of volts. */
#define PDI_LEVELS_MET 1e-13
#define PDI_LEVELS_CLOSE 2e-16
/* Share of what sources or circuits give that their charge may be, and of the ions of a closed box that one of rounding
 * is at most. */
#define PDI_LEVELS_SLACK 1e-9
#define PDI_LEVELS_FAINT 1e-13

PDI_FN double pdi_levels_place(const pd_etch *s, int32_t p, double speed, double flow)
{
    const pd_reactive *r = s->reactive;
    const double *part = s->part + s->electrode[p] * r->components.solutes;
    double charge = 0.0, volume = r->bonds->stencil->volume * pd_grid_circumference(r->grid, s->node[p]);
    for (int n = 0; n < r->components.solutes; n++) charge += r->components.charge[n] * part[n];
    double law = pdi_etch_of(s, p)->charge * (s->weight[p] > 0.0 ? s->weight[p] * speed : 0.0);
    return volume * (law + charge * s->area[p] * flow);
}

PDI_FN double pdi_levels_charge(const pd_etch *s, int circuit, double *size)
{
    pdi_compensated_sum sum = {0.0, 0.0}, sizes = {0.0, 0.0};
    for (int32_t p = 0; p < s->count; p++) {
        if (pdi_etch_circuit(s, p) != circuit) continue;
        double law = pdi_levels_place(s, p, *pdi_etch_speed(s, p), 0.0);
        double curve = pdi_levels_place(s, p, 0.0, s->flow[p]);
        pdi_compensated_sum_add(&sum, law + curve);
        pdi_compensated_sum_add(&sizes, fabs(law) + fabs(curve));
    }
    *size = pdi_compensated_sum_total(&sizes);
    return pdi_compensated_sum_total(&sum);
}

/* A search: the charge that is too much at potentials on both sides. */
typedef struct pdi_levels_search {
    int circuit;
    double wanted;               /* [mol/s] */
    double low, high;            /* [V] where it is too little, too much; infinite: not known */
    double of_low, of_high;      /* [mol/s] */
    double size;                 /* [mol/s] of the last sum */
} pdi_levels_search;

/* What is too much at E; a bracket takes it. Where no surface was found, none is on that side of `from`. */
static double pdi_levels_try(const pd_ctx *ctx, pd_etch *s, pdi_levels_search *q, double e, double from)
{
    s->level[q->circuit] = e;
    pdi_layer_solve(ctx, s, q->circuit, 0);
    double off = pdi_levels_charge(s, q->circuit, &q->size) - q->wanted;
    if (!(fabs(off) < HUGE_VAL)) off = e < from ? -HUGE_VAL : HUGE_VAL;
    if (off > 0.0) {
        q->high = e;
        q->of_high = off;
    } else {
        q->low = e;
        q->of_low = off;
    }
    return off;
}

/* The next potential to try, after e with `off`. */
static double pdi_levels_next(const pdi_levels_search *q, double e, double off, double slope, int step, double *stride)
{
    double next = slope > 0.0 ? e - off / slope : (double)NAN;
    if (q->low > -HUGE_VAL && q->high < HUGE_VAL) {
        double width = q->high - q->low;
        if (step % 3 == 2 || !(next > q->low) || !(next < q->high)) {
            next = q->low + width * (q->of_low / (q->of_low - q->of_high));
            if (step % 2 || !(next > q->low) || !(next < q->high)) next = q->low + 0.5 * width;
        }
        return next;
    }
    double way = off > 0.0 ? -1.0 : 1.0, least = PDI_LEVELS_LEAST * ldexp(1.0, 2 * step);
    /* to the other side */
    double move = next == next ? pd_min(pd_max(2.0 * fabs(next - e), least), *stride) : *stride;
    *stride *= 2.0;
    return e + way * move;
}

/* The curves jump over what is wanted: rates between those of both sides. */
static void pdi_levels_between(const pd_ctx *ctx, pd_etch *s, const pdi_levels_search *q)
{
    double *speed = s->side, *flow = s->side + s->reactive->grid->total, size;
    s->level[q->circuit] = q->low;
    pdi_layer_solve(ctx, s, q->circuit, 0);
    for (int32_t p = 0; p < s->count; p++) {
        speed[p] = *pdi_etch_speed(s, p);
        flow[p] = s->flow[p];
    }
    double low = pdi_levels_charge(s, q->circuit, &size) - q->wanted;
    s->level[q->circuit] = q->high;
    pdi_layer_solve(ctx, s, q->circuit, 0);
    double high = pdi_levels_charge(s, q->circuit, &size) - q->wanted, share = low < high ? low / (low - high) : 1.0;
    for (int32_t p = 0; p < s->count; p++) {
        if (pdi_etch_circuit(s, p) != q->circuit) continue;
        if (s->weight[p] > 0.0) *pdi_etch_speed(s, p) = speed[p] + share * (*pdi_etch_speed(s, p) - speed[p]);
        s->flow[p] = flow[p] + share * (s->flow[p] - flow[p]);
    }
}

/* [V] Potentials of the fluid beside the metal of a circuit. */
static void pdi_levels_fluid(const pd_etch *s, int circuit, double *least, double *most)
{
    const pd_migration *m = &s->reactive->migration;
    *least = HUGE_VAL;
    *most = -HUGE_VAL;
    for (int32_t p = 0; p < s->count; p++) {
        if (pdi_etch_circuit(s, p) != circuit) continue;
        *least = pd_min(*least, m->volt * m->psi[s->node[p]]);
        *most = pd_max(*most, m->volt * m->psi[s->node[p]]);
    }
}

/* 1: it has a place where currents pass. */
static int pdi_levels_there(const pd_etch *s, int circuit)
{
    for (int32_t p = 0; p < s->count; p++)
        if (pdi_etch_circuit(s, p) == circuit) return 1;
    return 0;
}

/* 1: it is there, and no place of it lies on a loop of current. */
static int pdi_levels_open(const pd_etch *s, int circuit)
{
    int some = 0;
    for (int32_t p = 0; p < s->count; p++) {
        if (pdi_etch_circuit(s, p) != circuit) continue;
        if (!s->open[p]) return 0;
        some = 1;
    }
    return some;
}

/* What the sum is still off by goes by the slopes found last: it is exact to rounding. */
static void pdi_levels_close(pd_etch *s, int circuit, double wanted)
{
    double size, off = pdi_levels_charge(s, circuit, &size) - wanted, volt = s->reactive->migration.volt;
    if (!(s->conduct[circuit] > DBL_MIN)) return;
    double rise = off / (s->conduct[circuit] * volt);
    for (int32_t p = 0; p < s->count; p++) {
        if (pdi_etch_circuit(s, p) != circuit) continue;
        if (s->weight[p] > 0.0) *pdi_etch_speed(s, p) += (double)s->drive[p] * rise;
        s->flow[p] += (double)s->flow_drive[p] * rise;
    }
}

/* A circuit without a given current carries current one way only, and less and less of it towards a far potential:
 * there it carries none. 0: it is another one. */
static int pdi_levels_idle(const pd_ctx *ctx, pd_etch *s, pdi_levels_search *q, double least, double most)
{
    int up = !(q->high < HUGE_VAL);
    if (!s->alone || fabs(q->wanted) > 0.0 || up == !(q->low > -HUGE_VAL)) return 0;
    double near = up ? least : most, far = up ? most + PDI_LEVELS_FAR : least - PDI_LEVELS_FAR;
    pdi_levels_try(ctx, s, q, near, near);
    double size = q->size, off = pdi_levels_try(ctx, s, q, far, far);
    if (!(fabs(off) < HUGE_VAL) || !(q->size <= PDI_LEVELS_SLACK * size)) return 0;
    for (int32_t p = 0; p < s->count; p++) {
        if (pdi_etch_circuit(s, p) != q->circuit) continue;
        if (s->weight[p] > 0.0) *pdi_etch_speed(s, p) = 0.0;
        s->flow[p] = 0.0;
    }
    s->idle |= (uint32_t)1 << q->circuit;
    return 1;
}

static void pdi_levels_find(const pd_ctx *ctx, pd_etch *s, int circuit, double extra)
{
    pdi_levels_search q = {circuit, s->desc.electrodes.circuit[circuit].value / PD_FARADAY + extra, -HUGE_VAL,
                           HUGE_VAL, -HUGE_VAL, HUGE_VAL, 0.0};
    double e = s->level[circuit], stride = PDI_LEVELS_STRIDE, slope = s->conduct[circuit], least, most;
    pdi_levels_fluid(s, circuit, &least, &most);
    if (!(e > least - PDI_LEVELS_FAR) || !(e < most + PDI_LEVELS_FAR)) e = least;
    double off = pdi_levels_try(ctx, s, &q, e, e);
    for (int step = 0; step < PDI_LEVELS_STEPS; step++) {
        if (fabs(off) <= PDI_LEVELS_MET * (q.size + fabs(q.wanted))) {
            pdi_levels_close(s, circuit, q.wanted);
            return;
        }
        if (!(q.high - q.low > PDI_LEVELS_CLOSE * pd_max(fabs(e), 1.0))) break;
        double next = pdi_levels_next(&q, e, off, slope, step, &stride);
        if (!(next > q.low) || !(next < q.high) || next < least - PDI_LEVELS_FAR ||
            next > most + PDI_LEVELS_FAR) break;
        double was = off, before = e;
        off = pdi_levels_try(ctx, s, &q, next, before);
        e = next;
        slope = (off - was) / (e - before);
        if (!(slope < HUGE_VAL)) slope = 0.0;
    }
    if (fabs(q.of_low) < HUGE_VAL && fabs(q.of_high) < HUGE_VAL) {
        pdi_levels_between(ctx, s, &q);
        return;
    }
    if (pdi_levels_idle(ctx, s, &q, least, most)) return;
    s->lost = 1 + circuit;
    for (int32_t p = 0; p < s->count; p++)
        if (pdi_etch_circuit(s, p) == circuit) s->flow[p] = NAN;
}

PDI_FN int pdi_levels_roots(const pd_ctx *ctx, pd_etch *s, int circuit, const pdi_levels_trials *trials, double *root,
                            int most)
{
    double wanted = s->desc.electrodes.circuit[circuit].value / PD_FARADAY, e = trials->from;
    double last = 0.0, at = 0.0, until = -HUGE_VAL, size, least, highest;
    int found = 0;
    pdi_levels_fluid(s, circuit, &least, &highest);
    while (e <= trials->to) {
        s->level[circuit] = e;
        for (int32_t p = 0; p < s->count; p++) /* a guess that is no number is none */
            if (pdi_etch_circuit(s, p) == circuit && !(fabs(s->flow[p]) < HUGE_VAL)) s->flow[p] = 0.0;
        pdi_layer_solve(ctx, s, circuit, 0);
        double off = pdi_levels_charge(s, circuit, &size) - wanted;
        double tried = e, beyond = trials->high + highest + trials->coarse;
        int near = e < until || (e + trials->coarse > trials->low + least && e < beyond);
        e += near ? trials->fine : trials->coarse;
        if (!(fabs(off) > PDI_LEVELS_SLACK * (size + fabs(wanted)))) continue; /* rounding, or no surface was found */
        if (last * off < 0.0 && tried - at > 2.0 * trials->fine && tried > until) { /* once more in small steps */
            until = tried;
            e = at + trials->fine;
            continue;
        }
        if (last * off < 0.0 && found++ < most) root[found - 1] = at + (tried - at) * (last / (last - off));
        last = off;
        at = tried;
    }
    return found;
}

PDI_FN void pdi_levels_solve(const pd_ctx *ctx, pd_etch *s)
{
    double size, extra = s->extra;
    s->lost = 0;
    s->idle = 0;
    if (!s->electrode) {
        pdi_layer_solve(ctx, s, -1, 0);
        return;
    }
    for (int n = 0; n < s->desc.electrodes.circuits; n++) {
        pd_etch_circuit *circuit = &s->desc.electrodes.circuit[n];
        if (s->desc.electrodes.given) circuit->value = s->desc.electrodes.given(s->desc.electrodes.user, n, s->time);
        if (circuit->holds) {
            s->level[n] = circuit->value;
            pdi_layer_solve(ctx, s, n, 0);
        } else if (pdi_levels_open(s, n)) {
            s->idle |= (uint32_t)1 << n;
            pdi_layer_solve(ctx, s, n, 0);
        } else if (pdi_levels_there(s, n)) {
            pdi_levels_find(ctx, s, n, extra);
            extra = 0.0;
        }
        s->charge_of[n] = pdi_levels_charge(s, n, &size);
    }
}

PDI_FN void pdi_levels_derive(pd_etch *s)
{
    double volt = s->reactive->migration.volt;
    for (int n = 0; n < s->desc.electrodes.circuits; n++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        for (int32_t p = 0; p < s->count; p++)
            if (pdi_etch_circuit(s, p) == n)
                pdi_compensated_sum_add(&sum, -pdi_levels_place(s, p, (double)s->drive[p], (double)s->flow_drive[p]));
        s->conduct[n] = pdi_compensated_sum_total(&sum) / volt;
    }
}

PDI_FN void pdi_levels_follow(const pd_etch *s, double *speed, double *flow)
{
    double volt = s->reactive->migration.volt;
    for (int n = 0; n < s->desc.electrodes.circuits; n++) {
        pdi_compensated_sum sum = {0.0, 0.0};
        if (s->desc.electrodes.circuit[n].holds || !(s->conduct[n] > DBL_MIN)) continue;
        for (int32_t p = 0; p < s->count; p++)
            if (pdi_etch_circuit(s, p) == n) pdi_compensated_sum_add(&sum, pdi_levels_place(s, p, speed[p], flow[p]));
        double rise = pdi_compensated_sum_total(&sum) / (s->conduct[n] * volt);
        for (int32_t p = 0; p < s->count; p++) {
            if (pdi_etch_circuit(s, p) != n) continue;
            speed[p] += (double)s->drive[p] * rise;
            flow[p] += (double)s->flow_drive[p] * rise;
        }
    }
}

PDI_FN int pdi_levels_tie(const pd_etch *s)
{
    for (int n = 0; n < s->desc.electrodes.circuits; n++)
        if (s->desc.electrodes.circuit[n].holds && pdi_levels_there(s, n)) return 1;
    return 0;
}

PDI_FN int pdi_levels_free(const pd_etch *s)
{
    int count = 0;
    for (int n = 0; n < s->desc.electrodes.circuits; n++)
        count += !s->desc.electrodes.circuit[n].holds && pdi_levels_there(s, n);
    return count;
}

/* Where no current can leave, those that are given to circuits sum to zero. */
static pd_status pdi_levels_given(pd_ctx *ctx, const pd_etch *metal)
{
    double sum = 0.0, size = 0.0;
    for (int n = 0; n < metal->desc.electrodes.circuits; n++) {
        sum += metal->desc.electrodes.circuit[n].value;
        size += fabs(metal->desc.electrodes.circuit[n].value);
    }
    if (!(fabs(sum) > PDI_LEVELS_SLACK * size)) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "the currents that are given to metals sum to %g A, and no inlet "
                   "or wall that holds species lets a current pass, expected 0, or a given potential", sum);
}

PDI_FN void pdi_levels_ties(pd_reactive *r)
{
    pdi_migration_tie(&r->migration);
    if (r->surface && r->surface->electrode && pdi_levels_tie(r->surface)) r->migration.tied = 1;
}

PDI_FN pd_status pdi_levels_sources(pd_ctx *ctx, pd_reactive *r, double dt)
{
    int64_t total = r->grid->total;
    pdi_compensated_sum sum = {0.0, 0.0};
    double size = 0.0, held = 0.0, late = 0.0;
    pdi_levels_ties(r);
    if (r->surface && r->surface->electrode) r->surface->sourced = 0.0;
    if (r->migration.tied) return PD_OK;
    if (r->surface && r->surface->electrode) PD_TRY(pdi_levels_given(ctx, r->surface));
    else if (r->surface && r->surface->count &&
             (r->surface->desc.reads_phi || fabs(r->surface->kind->charge) > PDI_LEVELS_SLACK))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive", "metal that dissolves %s, and no inlet or wall that holds "
                       "species has a potential and lets a current pass, expected one",
                       r->surface->desc.reads_phi ? "by the potential" : "gives a charge");
    for (int32_t i = 0; i < (int32_t)total; i++) {
        double around = pd_grid_circumference(r->grid, i);
        if (r->grid->kind[i] != PD_FLUID) continue;
        for (int n = 0; n < r->components.solutes; n++) {
            double term = around * r->migration.charge[n] * r->source[n * total + i];
            pdi_compensated_sum_add(&sum, term);
            size += fabs(term);
            held += around * fabs(r->migration.charge[n]) * r->c[n * total + i];
        }
    }
    if (r->surface && r->surface->electrode) {
        r->surface->sourced = r->bonds->stencil->volume * pdi_compensated_sum_total(&sum);
        late = r->surface->late; /* a circuit gives it */
    }
    double most = pd_max(PDI_LEVELS_SLACK * size, PDI_LEVELS_FAINT * held / dt);
    if (!(fabs(pdi_compensated_sum_total(&sum) - late) > most)) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "reactive",
                   "sources give a charge of %g of what they give, and no inlet or "
                   "wall lets a current pass, expected 0",
                   pdi_compensated_sum_total(&sum) / size);
}
