/* solid_newton: displacements of a material at rest, by Newton's method with conjugate gradients. */
#ifndef SOLID_NEWTON_H
#define SOLID_NEWTON_H
#include "solid_case.h"
#include "core/vec.h"
#include "solid/solid.h"

typedef struct solid_newton {
    int rounds, products;
    double residual; /* [-] forces of free points over the given ones */
} solid_newton;

/* a.b over free components. */
static inline double solid_newton_dot(int32_t n, const uint8_t *held, const double *a, const double *b)
{
    double sum = 0.0;
    for (int32_t k = 0; k < n; k++) sum += held[k] ? 0.0 : a[k] * b[k];
    return sum;
}

/* y = -V tangent(x) of free components. */
static inline void solid_newton_product(pd_ctx *ctx, const pd_solid *s, const uint8_t *held, const double *x, double *y)
{
    s->tangent(ctx, s->self, x, y);
    for (int32_t k = 0; k < s->body->count * PD_DIM; k++) y[k] = held[k] ? 0.0 : -s->body->volume[k / PD_DIM] * y[k];
}

static inline void solid_newton_scale(const pd_solid *s, const uint8_t *held, const double *inverse, const double *x,
                                      double *y)
{
    for (int32_t k = 0; k < s->body->count * PD_DIM; k++) {
        y[k] = 0.0;
        for (int d = 0; d < PD_DIM && !held[k]; d++) y[k] += inverse[k * PD_DIM + d] * x[k - k % PD_DIM + d];
    }
}

/* step = A^-1 rest to `tolerance` of it. */
static inline int solid_newton_linear(pd_ctx *ctx, const pd_solid *s, const uint8_t *held, double tolerance,
                                      double *rest, double *step)
{
    static double inverse[MOST * T], block[MOST * T], way[MOST * PD_DIM], image[MOST * PD_DIM], scaled[MOST * PD_DIM];
    int32_t n = s->body->count * PD_DIM;
    int products = 0;
    s->blocks(ctx, s->self, block);
    for (int32_t i = 0; i < s->body->count; i++) {
        for (int k = 0; k < T; k++)
            if (k / PD_DIM != k % PD_DIM && (held[i * PD_DIM + k / PD_DIM] || held[i * PD_DIM + k % PD_DIM]))
                block[i * T + k] = 0.0;
        pdi_vec_invert(block + i * T, inverse + i * T);
    }
    solid_newton_scale(s, held, inverse, rest, way);
    double size = solid_newton_dot(n, held, rest, way), first = size;
    memset(step, 0, (size_t)n * sizeof *step);
    while (size > tolerance * tolerance * first && products < 3000) {
        solid_newton_product(ctx, s, held, way, image);
        products++;
        double slope = solid_newton_dot(n, held, way, image), length = size / slope;
        if (!(slope > 0.0)) break;
        for (int32_t k = 0; k < n; k++) step[k] += length * way[k], rest[k] -= length * image[k];
        solid_newton_scale(s, held, inverse, rest, scaled);
        double next = solid_newton_dot(n, held, rest, scaled);
        for (int32_t k = 0; k < n; k++) way[k] = scaled[k] + next / size * way[k];
        size = next;
    }
    return products;
}

/* Forces of free components at u [N], and their size over that of loads and of what holds. Negative: u is no state. */
static inline double solid_newton_rest(pd_ctx *ctx, const pd_solid *s, const uint8_t *held, const double *load,
                                       const double *u, double *rest)
{
    double size = 0.0, sum = 0.0;
    if (s->force(ctx, s->self, u, rest) != PD_OK) return -1.0;
    for (int32_t k = 0; k < s->body->count * PD_DIM; k++) {
        double volume = s->body->volume[k / PD_DIM], given = held[k] ? rest[k] : load ? load[k] : 0.0;
        rest[k] = held[k] ? 0.0 : volume * (rest[k] + (load ? load[k] : 0.0));
        size += volume * volume * given * given;
        sum += rest[k] * rest[k];
    }
    return size > 0.0 ? sqrt(sum / size) : sqrt(sum);
}

/* Energy less the work of loads. */
static inline double solid_newton_potential(pd_ctx *ctx, const pd_solid *s, const double *load, const double *u)
{
    double work = 0.0;
    for (int32_t k = 0; load && k < s->body->count * PD_DIM; k++) work += s->body->volume[k / PD_DIM] * load[k] * u[k];
    return s->energy(ctx, s->self, u) - work;
}

/* u [count][PD_DIM]: a state at rest. Held components go to `given`; load may be NULL. A step is halved until the
 * material takes it, and the potential or the forces have become less. */
static inline solid_newton solid_newton_solve(pd_ctx *ctx, const pd_solid *s, const uint8_t *held, const double *given,
                                              const double *load, double rtol, double *u)
{
    static double rest[MOST * PD_DIM], step[MOST * PD_DIM], moved[MOST * PD_DIM], trial[MOST * PD_DIM];
    solid_newton r = {0, 0, 1.0};
    int32_t n = s->body->count * PD_DIM;
    for (int32_t k = 0; k < n; k++) moved[k] = held[k] ? given[k] - u[k] : 0.0;
    solid_newton_rest(ctx, s, held, load, u, rest);
    solid_newton_product(ctx, s, held, moved, trial);
    for (int32_t k = 0; k < n; k++) rest[k] -= trial[k];
    r.products += solid_newton_linear(ctx, s, held, 1e-4, rest, step);
    for (int32_t k = 0; k < n; k++) u[k] += moved[k] + step[k];
    r.residual = solid_newton_rest(ctx, s, held, load, u, rest);
    for (r.rounds = 1; r.rounds < 60 && !(r.residual >= 0.0 && r.residual <= rtol); r.rounds++) {
        double length = 1.0, slope = 0.0, potential = solid_newton_potential(ctx, s, load, u), after = -1.0;
        memcpy(moved, rest, sizeof moved);
        r.products += solid_newton_linear(ctx, s, held, fmax(0.1 * rtol / r.residual, 1e-3 * fmin(1.0, r.residual)),
                                          rest, step);
        for (int32_t k = 0; k < n; k++) slope += moved[k] * step[k];
        for (; length > 1e-6; length *= 0.5) {
            for (int32_t k = 0; k < n; k++) trial[k] = u[k] + length * step[k];
            after = solid_newton_rest(ctx, s, held, load, trial, rest);
            if (after >= 0.0 && after < 0.5 * r.residual) break;
            if (after >= 0.0 &&
                solid_newton_potential(ctx, s, load, trial) < potential - 1e-4 * length * slope) break;
        }
        r.residual = after;
        memcpy(u, trial, (size_t)n * sizeof *u);
    }
    return r;
}

#endif
