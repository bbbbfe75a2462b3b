/* A scalar problem on a box of cells for the tests of the multigrid: coefficients, masks, walls, flow. */
#ifndef TESTS_MULTIGRID_H
#define TESTS_MULTIGRID_H
#include "solve/multigrid.h"
#include "random.h"
#include "test.h"
#include "multigrid_build.h"
#include <stdlib.h>

#define PI 3.14159265358979323846
#define GHOST 2

typedef struct problem {
    int n[PD_DIM], np[PD_DIM];
    int cells, nodes;
    int32_t stride[PD_DIM], first;
    uint8_t *active;
    float *conduct[PD_DIM], *flux[PD_DIM], *wall, *mass;
    int flow, periodic; /* flux is used; bits of the axes that wrap */
    int general; /* bit 0: ask for the general smoother without flow too; bit 1: for contrast */
    int *pocket; /* of each cell, -1: none */
    int pockets;
    pd_ctx ctx;
    pd_multigrid mg;
} problem;

static uint32_t seed;

static inline double uniform(void) { return random_share(&seed); }

static inline void *room(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) {
        printf("out of memory\n");
        exit(2);
    }
    return p;
}

/* Box of n cells along all axes (shrunk by the axis number for odd = 1), unit conductance. */
static inline void start(problem *p, int n, int odd)
{
    memset(p, 0, sizeof *p);
    pd_ctx_init(&p->ctx);
    seed = 1; /* each problem by itself: counts do not depend on the tests before */
    p->cells = p->nodes = 1;
    for (int d = 0; d < PD_DIM; d++) {
        p->n[d] = odd ? n + 1 - 2 * d : n;
        p->np[d] = p->n[d] + 2 * GHOST;
        p->stride[d] = p->nodes;
        p->first += (int32_t)(GHOST * p->nodes);
        p->cells *= p->n[d];
        p->nodes *= p->np[d];
    }
    size_t cells = (size_t)p->cells;
    p->active = (uint8_t *)room(cells, 1);
    p->wall = (float *)room(cells, sizeof(float));
    p->mass = (float *)room(cells, sizeof(float));
    p->pocket = (int *)room(cells, sizeof(int));
    memset(p->active, 1, cells);
    for (int d = 0; d < PD_DIM; d++) {
        p->conduct[d] = (float *)room(cells, sizeof(float));
        p->flux[d] = (float *)room(cells, sizeof(float));
        for (int c = 0; c < p->cells; c++) p->conduct[d][c] = 1.0f;
    }
}

static inline void finish(problem *p)
{
    pdi_multigrid_free(&p->ctx, &p->mg);
    pdi_multigrid_free(&p->ctx, &p->mg);
    CHECK_INT(p->ctx.in_use, 0);
    free(p->active);
    free(p->wall);
    free(p->mass);
    free(p->pocket);
    for (int d = 0; d < PD_DIM; d++) {
        free(p->conduct[d]);
        free(p->flux[d]);
    }
}

static inline int step(const problem *p, int d)
{
    int s = 1;
    for (int e = 0; e < d; e++) s *= p->n[e];
    return s;
}

static inline int coordinate(const problem *p, int c, int d) { return c / step(p, d) % p->n[d]; }

static inline int node(const problem *p, int c)
{
    int at = (int)p->first;
    for (int d = 0; d < PD_DIM; d++) at += coordinate(p, c, d) * (int)p->stride[d];
    return at;
}

/* Neighbour of c along +-d, -1: none that takes part. */
static inline int neighbour(const problem *p, int c, int d, int upper)
{
    int i = coordinate(p, c, d);
    int side = upper ? i == p->n[d] - 1 : i == 0, s = upper ? step(p, d) : -step(p, d);
    if (side && !(p->periodic >> d & 1)) return -1;
    int q = side ? c - s * (p->n[d] - 1) : c + s;
    return p->active[q] ? q : -1;
}

static inline void cycle(void *user, const double *x, double *y)
{
    problem *p = (problem *)user;
    pdi_multigrid_cycle(&p->ctx, &p->mg, x, y);
}

/* Dirichlet walls at the sides of the chosen axes (bits) and, when asked, at inactive cells: half a cell away. */
static inline void walls(problem *p, int axes, int obstacles)
{
    for (int c = 0; c < p->cells; c++) {
        p->wall[c] = 0.0f;
        for (int d = 0; d < PD_DIM; d++)
            for (int upper = 0; upper < 2; upper++) {
                int i = coordinate(p, c, d), side = upper ? i == p->n[d] - 1 : i == 0;
                int face = upper || i == 0 ? c : c - step(p, d);
                if (side ? axes >> d & 1 : obstacles && neighbour(p, c, d, upper) < 0)
                    p->wall[c] += 2.0f * p->conduct[d][face];
            }
    }
}

static inline pd_status build(problem *p)
{
    pd_multigrid_desc desc;
    memset(&desc, 0, sizeof desc);
    for (int d = 0; d < PD_DIM; d++) {
        desc.n[d] = p->n[d];
        desc.stride[d] = p->stride[d];
        desc.periodic[d] = p->periodic >> d & 1;
    }
    desc.first = p->first;
    desc.symmetric = !p->flow && !(p->general & 1);
    desc.high_contrast = p->general >> 1;
    return multigrid_build(&p->ctx, &desc, &p->mg);
}

static inline pd_status setup(problem *p)
{
    return pdi_multigrid_setup(&p->ctx, &p->mg, p->active, (const float *const *)p->conduct,
                               p->flow ? (const float *const *)p->flux : NULL, p->wall, p->mass);
}

static inline double norm_difference(const problem *p, const double *u, const double *v)
{
    double sum = 0.0;
    for (int i = 0; i < p->nodes; i++) sum += (u[i] - v[i]) * (u[i] - v[i]);
    return sqrt(sum);
}

static inline double *vector(const problem *p) { return (double *)room((size_t)p->nodes, sizeof(double)); }

static inline double *random_vector(const problem *p)
{
    double *v = vector(p);
    for (int c = 0; c < p->cells; c++)
        if (p->active[c]) v[node(p, c)] = uniform() - 0.5;
    return v;
}

/* Through flow along axis 0 (kind 0), oblique (1), one vortex in the plane of the first two axes (2). */
static inline void flow(problem *p, double peclet, int kind)
{
    double a = PI / p->n[0], q = PD_DIM > 1 ? PI / p->n[PD_DIM > 1 ? 1 : 0] : 0.0;
    p->flow = 1;
    for (int c = 0; c < p->cells; c++) {
        int i = coordinate(p, c, 0), j = PD_DIM > 1 ? coordinate(p, c, PD_DIM > 1 ? 1 : 0) : 0;
        p->mass[c] = 0.0f;
        for (int d = 0; d < PD_DIM; d++) {
            double f = kind == 2 ? 0.0 : d == 0 ? peclet : kind == 1 ? 0.7 * peclet : 0.0;
            /* differences of the stream function sin(a x) sin(q y) at the corners */
            if (kind == 2 && d == 0) f = peclet / a * sin(a * (i + 1)) * (sin(q * (j + 1)) - sin(q * j));
            if (kind == 2 && d == 1) f = -peclet / a * sin(q * (j + 1)) * (sin(a * (i + 1)) - sin(a * i));
            p->flux[d][c] = (float)f;
            if (kind < 2 && coordinate(p, c, d) == p->n[d] - 1) p->mass[c] += (float)f; /* leaves the box */
        }
    }
}

/* A hard case: random mask and conductances, odd sizes. */
static inline void tangle(problem *p)
{
    start(p, PD_DIM == 3 ? 21 : 70, 1);
    for (int c = 0; c < p->cells; c++) {
        p->active[c] = uniform() > 0.15;
        p->mass[c] = (float)(0.01 * uniform());
        for (int d = 0; d < PD_DIM; d++) p->conduct[d][c] = (float)pow(10.0, 2.0 * uniform() - 1.0);
    }
    walls(p, 1, 0);
}

#endif
