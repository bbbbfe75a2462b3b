/* loops: see loops.h
 *
 * Design: pockets and circuits are classes of a union. Surfaces that carry current both ways join them. Of the others
 * those go whose class has surfaces of one direction alone, until none is left.
 */
#include "react/loops.h"
#include "core/disjoint_sets.h"
#include "react/layer.h"
#include <math.h>
#include <string.h>

/* [V] Drops from metal to fluid, to either side, at which a surface shows which way it carries current. */
#define PDI_LOOPS_FAR 10.0
/* Share of the current at one of them which is none at the other. */
#define PDI_LOOPS_SLACK 1e-9

/* Ways of a surface: charge comes from the metal into the fluid, and it goes there. */
enum { PDI_LOOPS_OUT = 1, PDI_LOOPS_IN = 2 };

/* The class of what holds a potential, behind nodes and circuits. */
static int32_t pdi_loops_ground(const pd_etch *s)
{
    return (int32_t)s->reactive->grid->total + s->desc.electrodes.circuits;
}

/* The class of the metal of a place. */
static int32_t pdi_loops_metal(const pd_etch *s, int32_t p)
{
    int circuit = pdi_etch_circuit(s, p);
    return circuit < 0 ? pdi_loops_ground(s) : (int32_t)s->reactive->grid->total + circuit;
}

/* Charge that a place gives to the fluid at a drop to it, over what is the same for all drops. */
static double pdi_loops_charge(const pd_etch *s, int32_t p, double drop)
{
    const pd_reactive *r = s->reactive;
    double speed, flow, sum = 0.0, electrons = 0.0;
    pdi_layer_bare(s, p, drop, &speed, &flow);
    if (s->weight[p] > 0.0 && fabs(pdi_etch_of(s, p)->charge) > PDI_LOOPS_SLACK)
        sum += pdi_etch_of(s, p)->charge * s->weight[p] * speed;
    if (!s->electrode || s->electrode[p] < 0 || !(s->area[p] > 0.0)) return sum;
    const double *part = s->part + s->electrode[p] * r->components.solutes;
    for (int n = 0; n < r->components.solutes; n++) electrons += r->components.charge[n] * part[n];
    return sum + electrons * s->area[p] * flow;
}

/* Ways of a place. A curve that species at hand stop may carry either way later on. */
static int pdi_loops_ways(const pd_etch *s, int32_t p)
{
    double out = pdi_loops_charge(s, p, PDI_LOOPS_FAR), in = pdi_loops_charge(s, p, -PDI_LOOPS_FAR);
    if (out > 0.0 && in >= 0.0 && in <= PDI_LOOPS_SLACK * out) return PDI_LOOPS_OUT;
    if (in < 0.0 && out <= 0.0 && out >= PDI_LOOPS_SLACK * in) return PDI_LOOPS_IN;
    if (fabs(out) > 0.0 || fabs(in) > 0.0 || out != out || in != in) return PDI_LOOPS_OUT | PDI_LOOPS_IN;
    int reads = s->electrode && s->electrode[p] >= 0 && s->desc.electrodes.reads &&
                s->desc.electrodes.reads[s->electrode[p]];
    return reads ? PDI_LOOPS_OUT | PDI_LOOPS_IN : 0;
}

/* Fluid that bonds join, and sides that hold a potential. */
static void pdi_loops_pockets(pd_etch *s)
{
    const pd_reactive *r = s->reactive;
    const pd_migration *m = &r->migration;
    const pd_bonds *bonds = r->bonds;
    const double *hold = r->diffusion.wall_rate;
    int holds = 0;
    for (int n = 0; n < r->components.solutes; n++)
        holds = holds || (m->charge[n] != 0.0 && m->wall[n] == m->wall[n]);
    for (int32_t i = 0; i < r->grid->total; i++) {
        if (r->grid->kind[i] != PD_FLUID) continue;
        if (holds && hold && hold[i] > 0.0) pdi_disjoint_sets_merge(s->joined, i, pdi_loops_ground(s));
        for (int k = 0; k < bonds->stencil->count; k++) {
            int32_t far = i + bonds->paths.shift[k];
            if (!pdi_flux_open(&r->flux, i, k)) continue;
            if (r->grid->kind[far] == PD_IMAGE) far = pd_grid_find_source(r->grid, far, NULL);
            if (far < 0) continue;
            if (r->grid->kind[far] == PD_INLET) pdi_disjoint_sets_merge(s->joined, i, pdi_loops_ground(s));
            if (r->grid->kind[far] == PD_FLUID) pdi_disjoint_sets_merge(s->joined, i, far);
        }
    }
}

/* Circuits of a given potential; `currents`: or of a given current. */
static void pdi_loops_circuits(pd_etch *s, int currents)
{
    const pd_etch_electrodes *of = &s->desc.electrodes;
    for (int n = 0; n < of->circuits; n++) {
        double value = of->given ? of->given(of->user, n, s->time) : of->circuit[n].value;
        double later = of->given && s->span > 0.0 ? of->given(of->user, n, s->from + s->span) : value;
        if (of->circuit[n].holds || (currents && (fabs(value) > 0.0 || fabs(later) > 0.0)))
            pdi_disjoint_sets_merge(s->joined, (int32_t)s->reactive->grid->total + n, pdi_loops_ground(s));
    }
}

/* Surfaces of one direction whose pocket or circuit has none of the other one carry nothing. `way` of classes: what
 * their surfaces do, seen from the metal's side. */
static void pdi_loops_prune(pd_etch *s)
{
    int32_t count = pdi_loops_ground(s) + 1;
    for (int some = 1; some;) {
        some = 0;
        memset(s->way_of, 0, (size_t)count);
        for (int32_t p = 0; p < s->count; p++) {
            int32_t metal = pdi_disjoint_sets_find_root(s->joined, pdi_loops_metal(s, p));
            int32_t fluid = pdi_disjoint_sets_find_root(s->joined, s->node[p]);
            if (s->open[p] || !s->ways[p] || metal == fluid) continue;
            s->way_of[metal] |= s->ways[p];
            s->way_of[fluid] |= (uint8_t)(s->ways[p] ^ (PDI_LOOPS_OUT | PDI_LOOPS_IN));
        }
        for (int32_t p = 0; p < s->count; p++) {
            int32_t metal = pdi_disjoint_sets_find_root(s->joined, pdi_loops_metal(s, p));
            int32_t fluid = pdi_disjoint_sets_find_root(s->joined, s->node[p]);
            if (s->open[p] || !s->ways[p] || metal == fluid) continue;
            if (s->way_of[metal] == (PDI_LOOPS_OUT | PDI_LOOPS_IN) &&
                s->way_of[fluid] == (PDI_LOOPS_OUT | PDI_LOOPS_IN)) continue;
            s->open[p] = 1;
            some = 1;
        }
    }
}

/* A circuit whose metal carries current one way everywhere has no potential: whether that is an error its search says,
 * unless it has lost its partner. */
static void pdi_loops_alone(pd_etch *s)
{
    for (int n = 0; n < s->desc.electrodes.circuits && !s->alone; n++) {
        int ways = 0;
        if (s->desc.electrodes.circuit[n].holds) continue;
        for (int32_t p = 0; p < s->count; p++)
            if (pdi_etch_circuit(s, p) == n) ways |= s->ways[p];
        for (int32_t p = 0; p < s->count && ways != (PDI_LOOPS_OUT | PDI_LOOPS_IN); p++)
            if (pdi_etch_circuit(s, p) == n) s->open[p] = 0;
    }
}

/* Fluid that no loop passes has no potential, where there is one elsewhere. */
static void pdi_loops_idle(pd_etch *s)
{
    const pd_grid *grid = s->reactive->grid;
    int32_t ground = pdi_disjoint_sets_find_root(s->joined, pdi_loops_ground(s));
    int some = 0;
    memset(s->way_of, 0, (size_t)pdi_loops_ground(s) + 1);
    for (int32_t p = 0; p < s->count; p++)
        if (!s->open[p] && s->ways[p]) some = s->way_of[pdi_disjoint_sets_find_root(s->joined, s->node[p])] = 1;
    for (int32_t i = 0; i < grid->total; i++) {
        int32_t root = pdi_disjoint_sets_find_root(s->joined, i);
        some = some || (grid->kind[i] == PD_FLUID && root == ground);
    }
    for (int32_t i = 0; i < grid->total; i++) {
        int32_t root = pdi_disjoint_sets_find_root(s->joined, i);
        s->reactive->migration.idle[i] = grid->kind[i] == PD_FLUID && some && root != ground && !s->way_of[root];
    }
}

static void pdi_loops_begin(pd_etch *s, int currents)
{
    for (int32_t i = 0; i <= pdi_loops_ground(s); i++) s->joined[i] = i;
    pdi_loops_pockets(s);
    pdi_loops_circuits(s, currents);
}

/* Surfaces that carry current join metal and fluid. */
static void pdi_loops_close(pd_etch *s)
{
    for (int32_t p = 0; p < s->count; p++)
        if (!s->open[p] && s->ways[p]) pdi_disjoint_sets_merge(s->joined, s->node[p], pdi_loops_metal(s, p));
}

PDI_FN void pdi_loops_find(pd_reactive *r)
{
    pd_etch *s = r->surface;
    if (!r->migration.on || !s) return;
    pdi_loops_begin(s, 1);
    for (int32_t p = 0; p < s->count; p++) {
        s->open[p] = 0;
        s->ways[p] = (uint8_t)pdi_loops_ways(s, p);
        if (s->ways[p] == (PDI_LOOPS_OUT | PDI_LOOPS_IN))
            pdi_disjoint_sets_merge(s->joined, s->node[p], pdi_loops_metal(s, p));
    }
    pdi_loops_prune(s);
    pdi_loops_alone(s);
    pdi_loops_close(s);
    pdi_loops_idle(s);
    pdi_loops_begin(s, 0); /* a given current holds no potential */
    pdi_loops_close(s);
}

PDI_FN void pdi_loops_level(pd_reactive *r)
{
    pd_etch *s = r->surface;
    pd_migration *m = &r->migration;
    double *sum = m->size, *count = m->current;
    if (!m->on) return;
    if (!s) {
        pdi_migration_level(m);
        return;
    }
    int32_t ground = pdi_disjoint_sets_find_root(s->joined, pdi_loops_ground(s)), total = (int32_t)r->grid->total;
    for (int32_t i = 0; i < total; i++) sum[i] = count[i] = 0.0;
    for (int32_t i = 0; i < total; i++) {
        if (r->grid->kind[i] != PD_FLUID) continue;
        sum[pdi_disjoint_sets_find_root(s->joined, i)] += m->psi[i];
        count[pdi_disjoint_sets_find_root(s->joined, i)] += 1.0;
    }
    for (int32_t i = 0; i < total; i++) {
        int32_t root = pdi_disjoint_sets_find_root(s->joined, i);
        if (r->grid->kind[i] == PD_FLUID && root != ground) m->psi[i] -= sum[root] / count[root];
    }
    for (int n = 0; n < s->desc.electrodes.circuits; n++) {
        int32_t root = pdi_disjoint_sets_find_root(s->joined, total + n);
        if (root != ground && root < total) s->level[n] -= m->volt * (sum[root] / count[root]);
    }
}

#undef PDI_LOOPS_FAR
#undef PDI_LOOPS_SLACK
