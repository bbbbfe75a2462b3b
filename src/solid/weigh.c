/* weigh: see weigh.h */
#include "solid/weigh.h"
#include "core/par.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* How much a bond counts by its direction: base + a q, with q = sum n_k^4 - 3/(d + 2). */
static double pdi_weigh_share(double base, double a, const double *xi, double square)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += xi[d] * xi[d] * xi[d] * xi[d] / (square * square);
    return base + a * (sum - 3.0 / (PD_DIM + 2.0));
}

static void pdi_weigh_sum(const pdi_weigh *o, double base, double a, pdi_weigh_sums *s)
{
    const pd_body *body = o->body;
    int reach = (int)ceil(body->horizon / body->spacing + 0.5), wide = 2 * reach + 1, all = 1;
    double volume = 1.0;
    memset(s, 0, sizeof *s);
    s->least = HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) all *= wide, volume *= body->spacing;
    for (int k = 0; k < all; k++) {
        double xi[PD_DIM], square = 0.0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= wide) {
            xi[d] = (rest % wide - reach) * body->spacing;
            square += xi[d] * xi[d];
        }
        double r = sqrt(square), first = xi[0] * xi[0], second = PD_DIM > 1 ? xi[PD_DIM - 1] * xi[PD_DIM - 1] : 0.0;
        if (!(square > 0.0) || !(r < body->horizon + 0.5 * body->spacing)) continue;
        double weight = pdi_body_weight(body, o->influence, r) * pdi_weigh_share(base, a, xi, square);
        s->least = fmin(s->least, weight);
        weight = (double)(float)weight * volume; /* as bonds store it */
        s->size += weight * square;
        s->axis += weight * first * first / square;
        s->off += weight * first * second / square;
        s->volume += volume * pdi_body_weight(body, PD_INFLUENCE_CONSTANT, r);
    }
}

PDI_FN pd_status pdi_weigh_calibrate(pd_ctx *ctx, pdi_weigh *o, int isotropic)
{
    pdi_weigh_sums plain, cubic;
    if (!(o->body->spacing > 0.0)) return PD_OK;
    if (PD_DIM > 1 && isotropic) {
        pdi_weigh_sum(o, 1.0, 0.0, &plain);
        pdi_weigh_sum(o, 0.0, 1.0, &cubic);
        double odd = cubic.axis - 3.0 * cubic.off;
        if (fabs(odd) > 0.0) o->shear = (3.0 * plain.off - plain.axis) / odd;
    }
    pdi_weigh_sum(o, 1.0, o->shear, &o->whole);
    if (o->whole.least > 0.0) return PD_OK;
    return pdi_fail(ctx, PD_ERR_ARGUMENT, "ordinary", "no weights make a horizon of %g spacings the same in all "
                    "directions: use the position method, or a larger horizon", o->body->horizon / o->body->spacing);
}

/* ---- weights ---- */

/* What point i has of a whole family, for the factors of its bonds: along each axis, or of its volume. */
static void pdi_weigh_part(const pdi_weigh *o, int32_t i, double *part)
{
    const pd_body *body = o->body;
    for (int d = 0; d < PD_DIM; d++) part[d] = 0.0;
    for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
        double xi[PD_DIM], volume = body->volume[body->column[b]];
        pdi_body_bond(body, i, b, xi);
        double square = pdi_vec_dot(xi, xi), r = sqrt(square);
        double weight = pdi_body_weight(body, o->influence, r) * pdi_weigh_share(1.0, o->shear, xi, square);
        double inside = volume * pdi_body_weight(body, PD_INFLUENCE_CONSTANT, r);
        for (int d = 0; d < PD_DIM; d++)
            part[d] += o->way == PDI_WEIGH_ENERGY
                           ? weight * volume * xi[d] * xi[d] * xi[d] * xi[d] / (square * o->whole.axis)
                           : inside / o->whole.volume;
    }
}

/* Factor of a bond whose ends have these parts of a whole family (theory: eq. 8.8). */
static double pdi_weigh_factor(const pdi_weigh *o, const double *own, const double *other, const double *xi)
{
    double sum = 0.0, square = pdi_vec_dot(xi, xi);
    if (o->way == PDI_WEIGH_VOLUME) return 2.0 / (own[0] + other[0]);
    for (int d = 0; d < PD_DIM; d++) {
        double factor = 0.5 * (1.0 / own[d] + 1.0 / other[d]);
        sum += xi[d] * xi[d] / (square * factor * factor);
    }
    return 1.0 / sqrt(sum);
}

/* Weights of the bonds of point i. Both ends of a bond get the same number. part NULL: no factors. */
static void pdi_weigh_family(const pdi_weigh *o, const double *part, int32_t i, float *to)
{
    const pd_body *body = o->body;
    for (int64_t b = body->row[i]; b < body->row[i + 1]; b++) {
        double xi[PD_DIM];
        const double *own = part ? part + (int64_t)i * PD_DIM : NULL;
        pdi_body_bond(body, i, b, xi);
        double square = pdi_vec_dot(xi, xi);
        double weight = pdi_body_weight(body, o->influence, sqrt(square));
        weight *= pdi_weigh_share(1.0, o->shear, xi, square);
        if (part) weight *= pdi_weigh_factor(o, own, part + (int64_t)body->column[b] * PD_DIM, xi);
        to[b] = body->broken[b] ? 0.0f : (float)weight;
    }
}

PDI_FN pd_status pdi_weigh_bonds(pd_ctx *ctx, const pdi_weigh *o, float *weight)
{
    const pd_body *body = o->body;
    int nt = pdi_par_threads(ctx, body->bonds * 20);
    double *part = NULL;
    (void)nt;
    if (o->way != PDI_WEIGH_PLAIN) {
        PDI_TRY(PDI_NEW(ctx, "ordinary", (int64_t)body->count * PD_DIM, part));
        PDI_PARALLEL_FOR(nt)
        for (int32_t i = 0; i < body->count; i++) pdi_weigh_part(o, i, part + (int64_t)i * PD_DIM);
    }
    PDI_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) pdi_weigh_family(o, part, i, weight);
    PDI_DELETE(ctx, (int64_t)body->count * PD_DIM, part);
    return PD_OK;
}
