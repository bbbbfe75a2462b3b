/* ordinary_case: bodies for tests of solids, their displacements, and conjugate gradients on the table of a material.
 */
#ifndef ORDINARY_CASE_H
#define ORDINARY_CASE_H
#include "random.h"
#include "solid/material_interface.h"
#include "test.h"

enum { MOST = PD_DIM == 3 ? 12000 : 4000 }; /* points */
enum { T = PD_DIM * PD_DIM };

typedef struct solid_case {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    double position[MOST * PD_DIM], volume[MOST], u[MOST * PD_DIM], force[MOST * PD_DIM], load[MOST * PD_DIM];
    double other[MOST * PD_DIM], stress[MOST * T], block[MOST * T], held[MOST * PD_DIM];
    double rest[MOST * PD_DIM], way[MOST * PD_DIM], done[MOST * PD_DIM], mended[MOST * PD_DIM];
} solid_case;

static solid_case test_case;

static inline solid_case *case_begin(void)
{
    memset(&test_case, 0, sizeof test_case);
    pd_ctx_init(&test_case.ctx);
    return &test_case;
}

static inline solid_case *case_body(solid_case *c, double horizon, double spacing)
{
    c->desc.position = c->position;
    c->desc.volume = c->volume;
    c->desc.horizon = horizon;
    c->desc.spacing = spacing;
    return CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &c->desc, &c->body)) ? c : NULL;
}

/* n cells of width h along each axis, the middle of the box at 0; m and spacing in cells. */
static inline solid_case *box(const int *n, double h, double m, double spacing)
{
    solid_case *c = case_begin();
    int all = 1;
    for (int d = 0; d < PD_DIM; d++) all *= n[d];
    if (!CHECK(all <= MOST)) return NULL;
    for (int k = 0; k < all; k++) {
        for (int d = 0, rest = k; d < PD_DIM; rest /= n[d++])
            c->position[k * PD_DIM + d] = (rest % n[d] - 0.5 * (n[d] - 1)) * h;
        c->volume[k] = pow(h, PD_DIM);
    }
    c->desc.count = all;
    return case_body(c, m * h, spacing * h);
}

/* A block 1 mm wide of n cells an axis with a hole and a re-entrant corner; `stir` moves points by that share of a
 * cell. */
static inline solid_case *block(int n, double m, double spacing, double stir)
{
    solid_case *c = case_begin();
    uint32_t seed = 3;
    int all = 1;
    for (int d = 0; d < PD_DIM; d++) all *= n;
    for (int k = 0; k < all; k++) {
        double x[PD_DIM], corner = 1.0, hole = 0.0;
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= n) {
            x[d] = (rest % n + 0.5) / n;
            corner = fmin(corner, x[d]);
            hole += (x[d] - 0.35) * (x[d] - 0.35);
        }
        if (PD_DIM > 1 && (corner > 0.6 || hole < 0.02)) continue;
        for (int d = 0; d < PD_DIM; d++)
            c->position[c->desc.count * PD_DIM + d] = (x[d] + stir * (random_share(&seed) - 0.5) / n) * 1e-3;
        c->volume[c->desc.count++] = pow(1e-3 / n, PD_DIM) * (1.0 + stir * (random_share(&seed) - 0.5));
    }
    return case_body(c, m * 1e-3 / n, spacing * 1e-3 / n);
}

static inline void case_end(solid_case *c)
{
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

/* u = G x. */
static inline void linear(const solid_case *c, const double *g, double *u)
{
    for (int32_t i = 0; i < c->body.count; i++)
        for (int p = 0; p < PD_DIM; p++) {
            u[i * PD_DIM + p] = 0.0;
            for (int q = 0; q < PD_DIM; q++) u[i * PD_DIM + p] += g[p * PD_DIM + q] * c->position[i * PD_DIM + q];
        }
}

/* Stress of the displacement gradient g, and its energy density. */
static inline double hooke(double lambda, double mu, const double *g, double *p)
{
    double trace = 0.0, energy = 0.0;
    for (int d = 0; d < PD_DIM; d++) trace += g[d * PD_DIM + d];
    for (int k = 0; k < T; k++) {
        p[k] = mu * (g[k] + g[k % PD_DIM * PD_DIM + k / PD_DIM]) + (k / PD_DIM == k % PD_DIM ? lambda * trace : 0.0);
        energy += 0.5 * p[k] * g[k];
    }
    return energy;
}

static inline double inner(int n, const double *a, const double *b)
{
    double sum = 0.0;
    for (int k = 0; k < n; k++) sum += a[k] * b[k];
    return sum;
}

/* z = D^-1 r with the diagonal of the blocks. */
static inline void case_mend(solid_case *c, int n)
{
    for (int k = 0; k < n; k++)
        c->mended[k] = c->held[k] > 0.0 ? 0.0
                                        : c->rest[k] / c->block[k / PD_DIM * T + k % PD_DIM * (PD_DIM + 1)];
}

/* Displacements of a linear solid under the loads; what is `held` stays. Returns the iterations. */
static inline int case_solve(solid_case *c, const pd_material_interface *s, double rtol)
{
    int n = c->body.count * PD_DIM, k = 0;
    CHECK_OK(&c->ctx, s->force(&c->ctx, s->self, c->u, c->force));
    s->blocks(&c->ctx, s->self, c->block);
    for (int p = 0; p < n; p++) {
        c->rest[p] = c->held[p] > 0.0 ? 0.0 : c->volume[p / PD_DIM] * (c->force[p] + c->load[p]);
        c->way[p] = 0.0;
    }
    case_mend(c, n);
    double rho = inner(n, c->rest, c->mended), old = 0.0, first = rho;
    for (; k < 5000 && rho > rtol * rtol * first; k++) {
        for (int p = 0; p < n; p++) c->way[p] = c->mended[p] + (k ? rho / old * c->way[p] : 0.0);
        s->tangent(&c->ctx, s->self, c->way, c->done);
        for (int p = 0; p < n; p++) c->done[p] = c->held[p] > 0.0 ? 0.0 : -c->volume[p / PD_DIM] * c->done[p];
        double step = rho / inner(n, c->way, c->done);
        for (int p = 0; p < n; p++) {
            c->u[p] += step * c->way[p];
            c->rest[p] -= step * c->done[p];
        }
        case_mend(c, n);
        old = rho;
        rho = inner(n, c->rest, c->mended);
    }
    CHECK(k < 5000);
    CHECK_OK(&c->ctx, s->force(&c->ctx, s->self, c->u, c->force));
    return k;
}

#endif
