/* vary: see vary.h */
#include "run/vary.h"
#include "core/vec.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* Places along an axis at which a value that depends on place is looked at. */
#define PDI_VARY_PLACES 3
/* A value that leaves the range of both ends by less than this share of its size is seen. */
#define PDI_VARY_SEEN 0.05
/* A value below this share of the largest to come is none. */
#define PDI_VARY_NONE 1e-6
/* A quarter of a part that changes by more than this share of what the part does holds a jump, or what is as steep. */
#define PDI_VARY_STEEP 0.75
/* Share of a step within which a jump lies at its start. */
#define PDI_VARY_BEGINS 1e-9
/* What the middle of a step may miss of the mean of a value, over rtol. */
#define PDI_VARY_MEAN 1.0
/* A value below this share of the largest to come is faint in its mean over a step. */
#define PDI_VARY_FAINT 0.25
/* Currents that grow by the factor exp(x) in a step have the mean exp(x/2) (1 + x^2/24). */
#define PDI_VARY_CURVED 24.0
/* [V] Curves bend over the thermal voltage of 4 electrons, RT/(4 F), at least. */
#define PDI_VARY_SPAN 6.4e-3
/* Second differences below this share of currents are those of rounding. */
#define PDI_VARY_STRAIGHT 1e-9
/* The tolerance where none is given. */
#define PDI_VARY_RTOL 1e-3
/* Parts of a step that are looked at, at most, and halvings of it. */
#define PDI_VARY_PARTS 2000
#define PDI_VARY_HALVINGS 40
/* Ends of a step that are tried. */
#define PDI_VARY_TRIALS 60

static void pdi_vary_list(pdi_owner *owner, void *object)
{
    pd_vary *vary = (pd_vary *)object;
    PDI_ARRAY(owner, vary, value, vary->capacity, "");
}

/* Take an expression of place and time, at the places of the box; side < 0: all of it, else those of a side. */
static void pdi_vary_take(const pd_setup *u, const pd_expr *expr, int side, pd_vary *vary)
{
    int places = 1;
    if (!pdi_setup_timed(expr)) return;
    for (int d = 0; d < PD_DIM; d++)
        if ((expr->uses >> d & 1u) && d != (side < 0 ? -1 : side / 2)) places *= PDI_VARY_PLACES;
    for (int k = 0; k < places; k++) {
        int rest = k;
        pd_vary_value *value = vary->value ? &vary->value[vary->count] : NULL;
        for (int d = 0; d < PD_DIM && value; d++) {
            int varies = (expr->uses >> d & 1u) && d != (side < 0 ? -1 : side / 2);
            double part = varies ? (rest % PDI_VARY_PLACES + 0.5) / PDI_VARY_PLACES : 0.5;
            if (varies) rest /= PDI_VARY_PLACES;
            if (side >= 0 && d == side / 2) part = side % 2 ? 1.0 : 0.0;
            value->x[d] = u->lo[d] + part * (u->hi[d] - u->lo[d]);
        }
        if (value) value->expr = expr;
        vary->count++;
    }
}

static void pdi_vary_sides(const pd_setup *u, pd_vary *vary)
{
    for (int s = 0; s < 2 * PD_DIM; s++) {
        const pd_setup_side *side = &u->side[s];
        pdi_vary_take(u, &side->stream, s, vary);
        pdi_vary_take(u, &side->entering, s, vary);
        pdi_vary_take(u, &side->held, s, vary);
        for (int d = 0; d < PD_DIM; d++) {
            pdi_vary_take(u, &side->velocity[d], s, vary);
            pdi_vary_take(u, &side->slide[d], s, vary);
        }
    }
}

static void pdi_vary_body(const pd_setup *u, pd_vary *vary)
{
    for (int k = 0; k < u->metal_body.grips; k++) {
        const pd_setup_grip *grip = &u->metal_body.grip[k];
        for (int d = 0; d < PD_DIM; d++) {
            if (grip->moves[d]) pdi_vary_take(u, &grip->move[d], grip->side, vary);
            if (grip->pulls) pdi_vary_take(u, &grip->pull[d], grip->side, vary);
        }
        if (grip->presses) pdi_vary_take(u, &grip->press, grip->side, vary);
    }
    for (int d = 0; d < PD_DIM && u->metal_body.weighs; d++) pdi_vary_take(u, &u->metal_body.force[d], -1, vary);
}

/* Change [V] by which the current of a table grows e-fold where it bends most, over spans that curves bend in. Beside a
 * zero of the current the slope says by how much it bends. HUGE_VAL: it is straight. */
static double pdi_vary_bends(const pd_electrode_term *term)
{
    const double *u = term->potential, *i = term->current;
    double fold = HUGE_VAL;
    for (int k = 1, a = 0, b = 1; k + 1 < term->points; k++) {
        while (a + 1 < k && u[k] - u[a + 1] >= PDI_VARY_SPAN) a++;
        while (b + 1 < term->points && (b <= k || u[b] - u[k] < PDI_VARY_SPAN)) b++;
        double down = u[k] - u[a], up = u[b] - u[k], slope = fabs(i[b] - i[a]) / (down + up);
        double bend = 2.0 * fabs((i[b] - i[k]) / up - (i[k] - i[a]) / down) / (down + up);
        double size = (fabs(i[a]) + fabs(i[k]) + fabs(i[b])) / 3.0;
        if (!(bend * down * up > PDI_VARY_STRAIGHT * size)) continue;
        fold = pdi_min(fold, pdi_max(sqrt(size / bend), slope / bend));
    }
    return fold;
}

/* Change [V] by which currents of an electrode grow e-fold at most; HUGE_VAL: its curve is straight. */
static double pdi_vary_fold(const pd_setup_electrode *e)
{
    const pd_electrode_term *term = &e->term;
    double fold = HUGE_VAL;
    if (e->primary || term->kind == PD_ELECTRODE_LINEAR) return fold;
    if (term->kind != PD_ELECTRODE_BUTLER_VOLMER) return pdi_vary_bends(term);
    if (term->anodic > 0.0) fold = term->anodic;
    return term->cathodic > 0.0 ? pdi_min(fold, term->cathodic) : fold;
}

static void pdi_vary_electrodes(const pd_setup *u, pd_vary *vary)
{
    double fold = HUGE_VAL;
    for (int k = 0; k < u->potential.electrodes; k++) fold = pdi_min(fold, pdi_vary_fold(&u->potential.electrode[k]));
    for (int k = 0; k < u->potential.electrodes; k++) {
        const pd_setup_electrode *e = &u->potential.electrode[k];
        int32_t first = vary->count;
        pdi_vary_take(u, &e->given, -1, vary);
        for (int32_t n = first; n < vary->count && vary->value; n++) {
            vary->value[n].middle = u->has_dissolve || !u->migrates;
            vary->value[n].fold = e->holds && !u->migrates ? fold : HUGE_VAL;
        }
    }
}

/* All values; without room they are counted. */
static void pdi_vary_all(const pd_setup *u, pd_vary *vary)
{
    vary->count = 0;
    pdi_vary_sides(u, vary);
    for (int k = 0; k < u->wall_count; k++) pdi_vary_take(u, &u->walls[k].held, -1, vary);
    for (int d = 0; d < PD_DIM; d++) pdi_vary_take(u, &u->body[d], -1, vary);
    for (int k = 0; k < u->metals; k++) pdi_vary_take(u, &u->metal[k].potential, -1, vary);
    pdi_vary_electrodes(u, vary);
    pdi_vary_body(u, vary);
}

PDI_FN pd_status pdi_vary_build(pd_ctx *ctx, const pd_setup *setup, pd_vary *vary)
{
    memset(vary, 0, sizeof *vary);
    vary->last = setup->until;
    vary->rtol = setup->rtol > 0.0 ? setup->rtol : PDI_VARY_RTOL;
    pdi_vary_all(setup, vary);
    vary->capacity = vary->count;
    if (!vary->count) return PD_OK;
    pd_status status = pdi_owner_build(ctx, pdi_vary_list, vary);
    if (status < 0) memset(vary, 0, sizeof *vary);
    else pdi_vary_all(setup, vary);
    return status;
}

PDI_FN void pdi_vary_free(pd_ctx *ctx, pd_vary *vary)
{
    pdi_owner_free(ctx, pdi_vary_list, vary);
    memset(vary, 0, sizeof *vary);
}

static pdi_range pdi_vary_range(const pd_vary_value *value, double a, double b)
{
    double vars[PD_EXPR_VARS];
    memset(vars, 0, sizeof vars);
    memcpy(vars, value->x, sizeof value->x);
    return pdi_range_of(value->expr, vars, PD_DIM, a, b);
}

/* What both ends of a step show. */
typedef struct pdi_vary_ends {
    double low, high, room; /* values beyond both by `room` are still seen */
} pdi_vary_ends;

static pdi_vary_ends pdi_vary_shown(const pd_vary_value *value, double t, double end, double most)
{
    pdi_range first = pdi_vary_range(value, t, t), last = pdi_vary_range(value, end, end);
    pdi_vary_ends e;
    e.low = first.low < last.low ? first.low : last.low;
    e.high = first.high > last.high ? first.high : last.high;
    e.room = PDI_VARY_SEEN * pdi_max(pdi_max(fabs(e.low), fabs(e.high)), most);
    e.room = pdi_max(e.room, DBL_MIN); /* below, values have lost their digits, and jump */
    return e;
}

/* A jump that lies before lies at the start of the step. */
static double pdi_vary_begins(double t, double end)
{
    return t + PDI_VARY_BEGINS * (end - t) + 8.0 * DBL_EPSILON * fabs(t);
}

/* 1: no quarter of a part changes by nearly as much as the part: the value does not jump there. */
static int pdi_vary_smooth(const pd_vary_value *value, double from, double to, double width)
{
    double quarter = 0.25 * (to - from);
    for (int k = 0; k < 4; k++) {
        pdi_range range = pdi_vary_range(value, from + k * quarter, from + (k + 1) * quarter);
        if (range.high - range.low > PDI_VARY_STEEP * width) return 0;
    }
    return 1;
}

/* Where the value leaves what the ends of a step show, or jumps, just before it does; `end`: it does not. A jump at the
 * start of the step is behind it. `most`: the largest value to come. */
static double pdi_vary_first(const pd_vary_value *value, double most, double t, double end)
{
    double stack[PDI_VARY_HALVINGS + 2], from = t, shortest = ldexp(end - t, -PDI_VARY_HALVINGS);
    pdi_vary_ends ends = pdi_vary_shown(value, t, end, PDI_VARY_NONE * most);
    double begins = pdi_vary_begins(t, end);
    int top = 0;
    if (!(ends.low > -HUGE_VAL) || !(ends.high < HUGE_VAL)) return end; /* who asks for that value will say so */
    stack[top++] = end;
    for (int part = 0; part < PDI_VARY_PARTS && top > 0; part++) {
        double to = stack[top - 1], middle = 0.5 * (from + to);
        pdi_range range = pdi_vary_range(value, from, to);
        double size = pdi_max(fabs(range.low), fabs(range.high));
        double more = size < HUGE_VAL ? pdi_max(PDI_VARY_SEEN * size, ends.room) : ends.room;
        int seen = range.low >= ends.low - more && range.high <= ends.high + more;
        int last = top > PDI_VARY_HALVINGS || to - from <= shortest || !(middle > from) || !(middle < to);
        if (seen && (range.high - range.low <= more || pdi_vary_smooth(value, from, to, range.high - range.low))) {
            from = to;
            top--;
        } else if (!last) {
            stack[top++] = middle;
        } else if (from > begins) {
            return from;
        } else {
            ends = pdi_vary_shown(value, to, end, PDI_VARY_NONE * most);
            from = to;
            top--;
        }
    }
    return top > 0 && from > t ? from : top > 0 ? 0.5 * (t + end) : end;
}

static double pdi_vary_at(const pd_vary_value *value, double t) { return pdi_vary_range(value, t, t).low; }

/* Where a step ends by whose middle a value is taken: Simpson's rule says the same mean, and so little changes that
 * what grows with it has its mean there, too. */
static double pdi_vary_mean(const pd_vary *vary, const pd_vary_value *value, double most, double t, double end)
{
    double begins = pdi_vary_begins(t, end), wide = sqrt(PDI_VARY_CURVED * vary->rtol) * value->fold;
    for (int k = 0; value->middle && k < PDI_VARY_HALVINGS && begins < end; k++) {
        double first = pdi_vary_at(value, begins), middle = pdi_vary_at(value, 0.5 * (t + end));
        double last = pdi_vary_at(value, end * (1.0 - DBL_EPSILON)), simpson = (first + 4.0 * middle + last) / 6.0;
        double size = value->fold < HUGE_VAL ? value->fold : pdi_max(fabs(simpson), PDI_VARY_FAINT * most);
        double change = pdi_max(fabs(last - first), pdi_max(fabs(middle - first), fabs(last - middle)));
        if (!(fabs(simpson - middle) > PDI_VARY_MEAN * vary->rtol * size) && !(change > wide)) return end;
        end = 0.5 * (t + end);
        begins = pdi_vary_begins(t, end);
    }
    return end;
}

PDI_FN double pdi_vary_until(void *user, double t, double end)
{
    const pd_vary *vary = (const pd_vary *)user;
    for (int trial = 0; trial < PDI_VARY_TRIALS; trial++) {
        double earlier = end;
        for (int32_t k = 0; k < vary->count; k++) {
            pdi_range all = pdi_vary_range(&vary->value[k], t, pdi_max(end, vary->last));
            double most = pdi_max(fabs(all.low), fabs(all.high));
            if (!(most < HUGE_VAL)) most = 0.0;
            earlier = pdi_vary_first(&vary->value[k], most, t, earlier);
            earlier = pdi_vary_mean(vary, &vary->value[k], most, t, earlier);
        }
        if (!(earlier < end) || !(earlier > t)) return end;
        end = earlier;
    }
    return end;
}

#undef PDI_VARY_PLACES
#undef PDI_VARY_SEEN
#undef PDI_VARY_STEEP
#undef PDI_VARY_BEGINS
#undef PDI_VARY_MEAN
#undef PDI_VARY_NONE
#undef PDI_VARY_FAINT
#undef PDI_VARY_CURVED
#undef PDI_VARY_SPAN
#undef PDI_VARY_STRAIGHT
#undef PDI_VARY_RTOL
#undef PDI_VARY_PARTS
#undef PDI_VARY_HALVINGS
#undef PDI_VARY_TRIALS
