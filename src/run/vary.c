/* vary: see vary.h */
#include "run/vary.h"
#include <math.h>
#include <string.h>

/* Places along an axis at which a value that depends on place is looked at. */
#define PDI_VARY_PLACES 3
/* A value that leaves the range of both ends by less than this share of its size is seen. */
#define PDI_VARY_SEEN 0.05
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

/* All values; without room they are counted. */
static void pdi_vary_all(const pd_setup *u, pd_vary *vary)
{
    vary->count = 0;
    pdi_vary_sides(u, vary);
    for (int k = 0; k < u->wall_count; k++) pdi_vary_take(u, &u->walls[k].held, -1, vary);
    for (int d = 0; d < PD_DIM; d++) pdi_vary_take(u, &u->body[d], -1, vary);
    for (int k = 0; k < u->metals; k++) pdi_vary_take(u, &u->metal[k].potential, -1, vary);
    for (int k = 0; k < u->potential.electrodes; k++) pdi_vary_take(u, &u->potential.electrode[k].given, -1, vary);
    pdi_vary_body(u, vary);
}

PDI_FN pd_status pdi_vary_build(pd_ctx *ctx, const pd_setup *setup, pd_vary *vary)
{
    memset(vary, 0, sizeof *vary);
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

/* The end of the first part of a step in which the value leaves what its ends show; `end`: it does not. */
static double pdi_vary_first(const pd_vary_value *value, double t, double end)
{
    double stack[PDI_VARY_HALVINGS + 2], from = t, shortest = ldexp(end - t, -PDI_VARY_HALVINGS);
    pdi_range first = pdi_vary_range(value, t, t), last = pdi_vary_range(value, end, end);
    double low = first.low < last.low ? first.low : last.low, high = first.high > last.high ? first.high : last.high;
    double room = PDI_VARY_SEEN * (fabs(low) > fabs(high) ? fabs(low) : fabs(high));
    int top = 0;
    if (!(low > -HUGE_VAL) || !(high < HUGE_VAL)) return end; /* who asks for that value will say so */
    stack[top++] = end;
    for (int part = 0; part < PDI_VARY_PARTS && top > 0; part++) {
        double to = stack[top - 1], middle = 0.5 * (from + to);
        pdi_range range = pdi_vary_range(value, from, to);
        double size = fabs(range.low) > fabs(range.high) ? fabs(range.low) : fabs(range.high);
        double more = size < HUGE_VAL && PDI_VARY_SEEN * size > room ? PDI_VARY_SEEN * size : room;
        if (range.low >= low - more && range.high <= high + more) {
            from = to;
            top--;
            continue;
        }
        if (top > PDI_VARY_HALVINGS || to - from <= shortest || !(middle > from) || !(middle < to)) return to;
        stack[top++] = middle;
    }
    return top > 0 && from > t ? from : top > 0 ? 0.5 * (t + end) : end;
}

PDI_FN double pdi_vary_until(void *user, double t, double end)
{
    const pd_vary *vary = (const pd_vary *)user;
    for (int trial = 0; trial < PDI_VARY_TRIALS; trial++) {
        double earlier = end;
        for (int32_t k = 0; k < vary->count; k++) earlier = pdi_vary_first(&vary->value[k], t, earlier);
        if (!(earlier < end) || !(earlier > t)) return end;
        end = earlier;
    }
    return end;
}

#undef PDI_VARY_PLACES
#undef PDI_VARY_SEEN
#undef PDI_VARY_PARTS
#undef PDI_VARY_HALVINGS
#undef PDI_VARY_TRIALS
