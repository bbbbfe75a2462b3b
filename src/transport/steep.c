/* steep: see steep.h */
#include "transport/steep.h"
#include "core/par.h"
#include "lattice/node_loop.h"
#include <math.h>

/* How much a value at the middle of a bond may go on as the field has risen up to its upwind end (Suresh and Huynh
 * 1997), and how curved the field may be behind it, of which a parabola has 1. */
#define PDI_STEEP_RISE 4.0
#define PDI_STEEP_CURVED (4.0 / 3.0)

/* A sweep over the bonds of one line, or over all of them with the shares (0: to find them). */
typedef struct pdi_steep_sweep {
    const pdi_steep *s;
    int k, shares;
    int means; /* 1: of the values of both ends */
    double *y;
} pdi_steep_sweep;

/* ---- values at the middle of bonds ---- */

/* Both bonds of line k are open, of the rows from `row`. */
static inline double pdi_steep_open(const pd_bonds *bonds, int32_t row, int k, int b)
{
    int opposite = bonds->stencil->count - 1 - k;
    return pdi_bond_is_open(bonds, row + b, k) && pdi_bond_is_open(bonds, row + b, opposite) ? 1.0 : 0.0;
}

/* Second differences along the line of bond k, of nodes as in node_loop.h. Where a bond is closed or ends on an outlet
 * the field goes on as a line. */
static inline void pdi_steep_bends(const pdi_steep *s, int32_t i, int32_t row, int32_t place, int k, int count,
                                   double *PD_RESTRICT bend)
{
    const pd_bonds *bonds = s->flux->bonds;
    int32_t shift = bonds->paths.shift[k];
    const double *c = s->c + i;
    if (place >= 0) {
        const int32_t *far = s->flux->boundary->far_end + (int64_t)place * bonds->stencil->count;
        int32_t next = far[k], before = far[bonds->stencil->count - 1 - k];
        bend[0] = next != i && before != i ? s->c[next] - 2.0 * c[0] + s->c[before] : 0.0;
        return;
    }
    for (int b = 0; b < count; b++) bend[b] = c[b + shift] - 2.0 * c[b] + c[b - shift];
    for (int b = 0; b < count && row >= 0; b++) bend[b] *= pdi_steep_open(bonds, row, k, b);
}

static void pdi_steep_bend_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_steep_sweep *of = (const pdi_steep_sweep *)user;
    pdi_steep_bends(of->s, i, row, place, of->k, count, of->s->bend + i);
}

/* The bond that a mirror makes of bond k; odd: bit d: axis d turns round. */
static int pdi_steep_turned(const pd_stencil *s, int k, int odd)
{
    int turned = 0;
    for (int like = 0; turned < s->count && !like; turned += !like) {
        like = 1;
        for (int d = 0; d < PD_DIM; d++) {
            double want = s->xi[k * PD_DIM + d];
            if (odd >> d & 1) want = -want;
            if (fabs(s->xi[turned * PD_DIM + d] - want) > 0.0) like = 0;
        }
    }
    return turned;
}

/* Images of second differences: a mirror makes another line of one across it. Those of such lines are computed anew. */
static void pdi_steep_bend_images(const pdi_steep *s, int k)
{
    const pd_bonds *bonds = s->flux->bonds;
    const pd_ghosts *ghosts = &bonds->ghosts;
    int last = bonds->stencil->count - 1;
    for (int32_t g = 0; g < ghosts->images_end; g++) {
        int32_t source = ghosts->source[g];
        int turned = ghosts->sign_flips[g] ? pdi_steep_turned(bonds->stencil, k, ghosts->sign_flips[g]) : k;
        int same = turned == k || turned == last - k || bonds->grid->kind[source] != PD_FLUID;
        if (same) s->bend[ghosts->node[g]] = s->bend[source];
        else pdi_steep_bends(s, source, bonds->row_of_node[source], -1, turned, 1, s->bend + ghosts->node[g]);
    }
}

/* The smaller and the larger one, without a branch. */
static inline double pdi_steep_low(double a, double b) { return 0.5 * (a + b - fabs(a - b)); }
static inline double pdi_steep_high(double a, double b) { return 0.5 * (a + b + fabs(a - b)); }

/* The least in size of two, zero where their signs differ. */
static inline double pdi_steep_least(double a, double b)
{
    return pdi_steep_high(0.0, pdi_steep_low(a, b)) + pdi_steep_low(0.0, pdi_steep_high(a, b));
}

/* The curvature of both ends that is no more than that of either, nor than what they have if one of them is none. */
static inline double pdi_steep_curve(double a, double b)
{
    return pdi_steep_least(pdi_steep_least(4.0 * a - b, 4.0 * b - a), pdi_steep_least(a, b));
}

/* Value at the middle of the bond along which the field rises by `step`, less that of its near end: of fifth order.
 * before, at, after: second differences there and on either side. */
static inline double pdi_steep_raw(double step, double before, double at, double after)
{
    return 0.5 * step + (2.0 * before - 9.0 * at - 3.0 * after) / 60.0;
}

/* That of the upwind end within what keeps a monotone field monotone (eq. 6.18). */
static inline double pdi_steep_keep(double value, double step, double before, double at, double after)
{
    double rise = step - at, middle = 0.5 * (step - pdi_steep_curve(at, after)), most = PDI_STEEP_RISE * rise;
    double round = 0.5 * rise + PDI_STEEP_CURVED * pdi_steep_curve(before, at);
    double low = pdi_steep_low(pdi_steep_low(0.0, step), middle);
    double high = pdi_steep_high(pdi_steep_high(0.0, step), middle);
    low = pdi_steep_high(low, pdi_steep_low(pdi_steep_low(0.0, most), round));
    high = pdi_steep_low(high, pdi_steep_high(pdi_steep_high(0.0, most), round));
    return value + pdi_steep_least(low - value, high - value);
}

/* Values of the nodes, or the means of what both ends say, kept within the limits of the node. */
PDI_INLINE_HOT void pdi_steep_values(const pdi_steep_sweep *of, int32_t i, int32_t place, int count, int means)
{
    const pdi_steep *s = of->s;
    const pd_bonds *bonds = s->flux->bonds;
    int opposite = bonds->stencil->count - 1 - of->k;
    int32_t next = bonds->paths.shift[of->k], before = -next;
    int64_t total = bonds->grid->total;
    const double *c = s->c + i, *bend = s->bend + i;
    const double *one = s->value + of->k * total + i, *two = s->value + opposite * total + i;
    double on[PDI_BLOCK], back[PDI_BLOCK];
    if (place >= 0) {
        const int32_t *far = s->flux->boundary->far_end + (int64_t)place * bonds->stencil->count;
        next = far[of->k] - i;
        before = far[opposite] - i;
    }
    for (int b = 0; b < count; b++) {
        double rise = c[b + next] - c[b], fall = c[b + before] - c[b];
        if (means) {
            on[b] = 0.5 * (one[b] + rise + two[b + next]);
            back[b] = 0.5 * (two[b] + fall + one[b + before]);
            on[b] = pdi_steep_keep(on[b], rise, bend[b + before], bend[b], bend[b + next]);
            back[b] = pdi_steep_keep(back[b], fall, bend[b + next], bend[b], bend[b + before]);
        } else {
            on[b] = pdi_steep_raw(rise, bend[b + before], bend[b], bend[b + next]);
            back[b] = pdi_steep_raw(fall, bend[b + next], bend[b], bend[b + before]);
        }
    }
    for (int b = 0; b < count; b++) s->ahead[i + b] = on[b];
    for (int b = 0; b < count; b++) s->behind[i + b] = back[b];
}

static void pdi_steep_value_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_steep_sweep *of = (const pdi_steep_sweep *)user;
    (void)row;
    if (count < PDI_BLOCK) pdi_steep_values(of, i, place, count, of->means);
    else if (of->means) pdi_steep_values(of, i, -1, PDI_BLOCK, 1);
    else pdi_steep_values(of, i, -1, PDI_BLOCK, 0);
}

static void pdi_steep_line(const pd_ctx *ctx, pdi_steep_sweep *of)
{
    const pdi_steep *s = of->s;
    const pd_bonds *bonds = s->flux->bonds;
    int64_t total = bonds->grid->total;
    pdi_par_zero(ctx, total, s->bend);
    pdi_node_loop_by_blocks(ctx, s->flux->boundary, bonds->grid->fluid_count * 4, pdi_steep_bend_nodes, of);
    pdi_steep_bend_images(s, of->k);
    pdi_node_loop_by_blocks(ctx, s->flux->boundary, bonds->grid->fluid_count * 60, pdi_steep_value_nodes, of);
    pdi_par_copy(ctx, total, s->ahead, s->value + of->k * total);
    pdi_par_copy(ctx, total, s->behind, s->value + (bonds->stencil->count - 1 - of->k) * total);
}

/* Images of values, when all lines are there; inlets agree with what the other end says. */
static void pdi_steep_images(const pdi_steep *s)
{
    const pd_bonds *bonds = s->flux->bonds;
    const pd_ghosts *ghosts = &bonds->ghosts;
    int64_t total = bonds->grid->total;
    for (int k = 0; k < bonds->stencil->count; k++)
        for (int32_t g = 0; g < ghosts->images_end; g++) {
            int from = ghosts->sign_flips[g] ? pdi_steep_turned(bonds->stencil, k, ghosts->sign_flips[g]) : k;
            s->value[k * total + ghosts->node[g]] = s->value[from * total + ghosts->source[g]];
        }
}

/* ---- what the bonds bring ---- */

/* What node b gains through a bond by which `flux` leaves (eq. 6.17): given is the value of its upwind end. */
static inline double pdi_steep_bring(double flux, double least, double step, double given)
{
    double half = 0.5 * fabs(flux), more = half > least ? half - least : 0.0;
    double leaves = flux > 0.0 ? flux * (given - 0.5 * step) : flux * (given + 0.5 * step);
    return -leaves - more * step;
}

/* Gains and losses of nodes, or what they gain with the shares of both ends. Inlets have no bend and all there is. */
PDI_INLINE_HOT void pdi_steep_block(const pdi_steep_sweep *of, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_steep *s = of->s;
    const pd_flux *t = s->flux;
    const double *c = s->c + i;
    int last = t->bonds->stencil->count - 1;
    int64_t total = t->bonds->grid->total;
    double flux[PDI_BLOCK], bond[PDI_BLOCK], up[PDI_BLOCK], down[PDI_BLOCK];
    for (int b = 0; b < count; b++) up[b] = down[b] = 0.0;
    for (int k = 0; k <= last; k++) {
        int32_t next = pdi_flux_bonds(t, i, row, place, k, count, flux, bond);
        int entry = place >= 0 && t->bonds->grid->kind[i + next] == PD_INLET;
        const double *here = s->value + k * total + i, *there = s->value + (last - k) * total + i + next;
        const double *gain = s->gain + i, *loss = s->loss + i, *far = c + next;
        if (place >= 0 && !next) continue;
        for (int b = 0; b < count; b++) {
            double step = far[b] - c[b], given = flux[b] > 0.0 ? here[b] : there[b];
            if (entry) given = flux[b] > 0.0 ? 0.5 * step : -0.5 * step;
            double bring = pdi_steep_bring(flux[b], bond[b], step, given);
            double in = bring > 0.0 ? bring : 0.0, out = bring > 0.0 ? 0.0 : -bring;
            if (of->shares) {
                in *= pdi_steep_low(gain[b], entry ? 1.0 : loss[b + next]);
                out *= pdi_steep_low(loss[b], entry ? 1.0 : gain[b + next]);
            }
            up[b] += in;
            down[b] += out;
        }
    }
    for (int b = 0; b < count; b++) {
        if (of->shares) of->y[i + b] = up[b] - down[b];
        else {
            s->gain[i + b] = up[b];
            s->loss[i + b] = down[b];
        }
    }
}

static void pdi_steep_nodes(const void *user, int32_t i, int32_t row, int32_t place, int count)
{
    const pdi_steep_sweep *of = (const pdi_steep_sweep *)user;
    if (count == PDI_BLOCK) pdi_steep_block(of, i, row, -1, PDI_BLOCK);
    else pdi_steep_block(of, i, row, place, count);
}

/* What of its gains and losses a node may have (Zalesak 1979); 1: all may have all. The share of one thread. */
static void pdi_steep_limit_share(const pdi_steep *s)
{
    const pd_grid *grid = s->flux->bonds->grid;
    PDI_FOR_NOWAIT
    for (int32_t i = 0; i < grid->total; i++) {
        double in = s->dt * s->gain[i], out = s->dt * s->loss[i];
        double room = pd_max(s->bounds.high - s->plain[i], 0.0), left = pd_max(s->plain[i] - s->bounds.low, 0.0);
        int fluid = grid->kind[i] == PD_FLUID;
        s->gain[i] = fluid && in > room ? room / in : 1.0;
        s->loss[i] = fluid && out > left ? left / out : 1.0;
    }
}

static void pdi_steep_limit(const pd_ctx *ctx, const pdi_steep *s)
{
    const pd_ghosts *ghosts = &s->flux->bonds->ghosts;
    int nt = pd_par_threads(ctx, (int64_t)s->flux->bonds->grid->total * 8);
    PDI_PARALLEL_CALL(nt, pdi_steep_limit_share(s));
    pd_ghosts_set_scalar(ghosts, s->gain);
    pd_ghosts_set_scalar(ghosts, s->loss);
}

PDI_FN void pdi_steep_anti(const pd_ctx *ctx, const pdi_steep *s, double *y)
{
    const pd_bonds *bonds = s->flux->bonds;
    int64_t work = bonds->grid->fluid_count * bonds->stencil->count * 8;
    pdi_steep_sweep of;
    of.s = s;
    of.y = y;
    pdi_par_zero(ctx, bonds->grid->total, s->ahead);
    pdi_par_zero(ctx, bonds->grid->total, s->behind);
    for (of.means = 0; of.means < 2; of.means++) {
        for (of.k = 0; of.k < bonds->stencil->count / 2; of.k++) pdi_steep_line(ctx, &of);
        pdi_steep_images(s);
    }
    for (of.shares = 0; of.shares < 2; of.shares++) {
        pdi_node_loop_by_blocks(ctx, s->flux->boundary, work, pdi_steep_nodes, &of);
        if (!of.shares) pdi_steep_limit(ctx, s);
    }
}

PDI_FN int pdi_steep_may(const pd_flux *flux)
{
    const pd_stencil *s = flux->bonds->stencil;
    return s->reach == 1 && s->count <= 2 * PD_DIM * PD_DIM;
}

PDI_FN void pdi_steep_list(pdi_array_visitor *owner, void *object)
{
    pdi_steep *steep = (pdi_steep *)object;
    const pd_bonds *bonds = steep->flux->bonds;
    PDI_ARRAY_UNINIT(owner, steep, value, (int64_t)bonds->stencil->count * bonds->grid->total, "mol/m3");
}
