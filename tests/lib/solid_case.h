/* solid_case: a body with a notch, a hole and a re-entrant corner, displacements of it, and products of them. */
#ifndef SOLID_CASE_H
#define SOLID_CASE_H
#include "random.h"
#include "solid/body.h"
#include "test.h"

#define MOST 4000 /* points */
enum { T = PD_DIM * PD_DIM, CELLS = PD_DIM == 1 ? 40 : PD_DIM == 2 ? 16 : 7 };

typedef struct solid_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    double position[MOST * PD_DIM], volume[MOST];
} solid_case;

/* n cells an axis of 1 mm; `stir` moves points by that share of a cell. whole 1: a box. */
static inline solid_case *solid_cells(int n, double m, double spacing, double stir, int whole)
{
    static solid_case room;
    solid_case *c = &room;
    uint32_t seed = 3;
    int all = 1;
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    for (int d = 0; d < PD_DIM; d++) all *= n;
    for (int k = 0; k < all; k++) {
        double x[PD_DIM], corner = 1.0, hole = 0.0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= n) {
            x[d] = (rest % n + 0.5) / n;
            corner = fmin(corner, x[d]);
            hole += (x[d] - 0.35) * (x[d] - 0.35);
        }
        if (PD_DIM > 1 && !whole && (corner > 0.6 || hole < 0.02)) continue;
        for (int d = 0; d < PD_DIM; d++)
            c->position[c->desc.count * PD_DIM + d] = (x[d] + stir * (random_share(&seed) - 0.5) / n) * 1e-3;
        c->volume[c->desc.count++] = pow(1e-3 / n, PD_DIM) * (1.0 + stir * (random_share(&seed) - 0.5));
    }
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = m * 1e-3 / n;
    c->desc.spacing = spacing * 1e-3 / n;
    return CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body)) ? c : NULL;
}

static inline solid_case *solid_block(int n, double m, double spacing, double stir)
{
    return solid_cells(n, m, spacing, stir, 0);
}

/* u = (F - 1) x, and noise of that size [m]. */
static inline void solid_stretch(const solid_case *c, const double *f, double noise, uint32_t seed, double *u)
{
    for (int32_t i = 0; i < c->body.count; i++)
        for (int p = 0; p < PD_DIM; p++) {
            const double *x = c->position + i * PD_DIM;
            u[i * PD_DIM + p] = noise * random_real(&seed) - x[p];
            for (int q = 0; q < PD_DIM; q++) u[i * PD_DIM + p] += f[p * PD_DIM + q] * x[q];
        }
}

/* sum V a b. */
static inline double solid_work(const solid_case *c, const double *a, const double *b)
{
    double sum = 0.0;
    for (int32_t k = 0; k < c->body.count * PD_DIM; k++) sum += c->volume[k / PD_DIM] * a[k] * b[k];
    return sum;
}

/* A gradient that stretches by 1 - most to 1 + most and turns by anything: a product of such matrices. */
static inline void solid_gradient(uint32_t *seed, double most, double *f)
{
    for (int k = 0; k < T; k++) f[k] = k % (PD_DIM + 1) == 0 ? 1.0 + most * random_real(seed) : 0.0;
    for (int turn = 0; turn < 2; turn++) {
        for (int a = 0; a < PD_DIM; a++)
            for (int b = a + 1; b < PD_DIM; b++) {
                double angle = 3.0 * random_real(seed), c = cos(angle), s = sin(angle);
                for (int k = 0; k < PD_DIM; k++) {
                    double *x = turn ? f + a * PD_DIM + k : f + k * PD_DIM + a;
                    double *y = turn ? f + b * PD_DIM + k : f + k * PD_DIM + b, old = *x;
                    *x = c * old - s * *y;
                    *y = s * old + c * *y;
                }
            }
    }
}

#endif
