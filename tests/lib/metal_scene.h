/* Scenes of the tests of bond-based corrosion: metal of the 304 pencil electrode in a box. */
#ifndef METAL_SCENE_H
#define METAL_SCENE_H
#include "couple/time_loop.h"
#include "metal/content.h"
#include "metal/dissolve.h"
#include "test.h"
#include "transport/amount.h"

#define CS 143e3     /* [mol/m3] */
#define CSAT 5.1e3   /* [mol/m3] */
#define SPEED 1e-7   /* [m/s] */
#define H 1e-6       /* [m] */

typedef struct scene {
    pd_ctx ctx;
    pd_stencil_desc stencil_desc;
    pd_stencil stencil;
    pd_grid_desc grid_desc;
    pd_shape shapes[4];
    pd_grid grid;
    pd_bonds bonds;
    pd_transport_desc transport_desc;
    pd_transport transport;
    pd_dissolve_desc desc;
    pd_dissolve dissolve;
    pd_time_loop_desc couple_desc;
    pd_time_loop couple;
    double bulk; /* [mol/m3] held on open sides: walls of the grid */
    int open[2 * PD_DIM];
    double speed;
} scene;

static scene test_scene;

static double constant_law(void *user, const pd_rate_at *at)
{
    (void)at;
    return *(const double *)user;
}

/* `bulk` on the planes of open sides, no flux elsewhere. */
static double held_bulk(void *user, const double *x)
{
    const scene *s = (const scene *)user;
    for (int d = 0; d < PD_DIM; d++)
        for (int side = 0; side < 2; side++) {
            double plane = side ? s->grid_desc.hi[d] : s->grid_desc.lo[d];
            if (s->open[2 * d + side] && fabs(x[d] - plane) < 1e-6 * s->stencil_desc.h[d]) return s->bulk;
        }
    return NAN;
}

/* A box of cells from the origin, m = 3, activation control at SPEED. */
static inline scene *scene_start(int x, int y, int z)
{
    scene *s = &test_scene;
    int n[3];
    memset(s, 0, sizeof *s);
    pd_ctx_init(&s->ctx);
    n[0] = x;
    n[1] = y;
    n[2] = z;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = H;
        s->grid_desc.hi[d] = n[d] * H;
    }
    s->stencil_desc.m = 3.0;
    s->grid_desc.shapes = s->shapes;
    s->grid_desc.solid = &s->shapes[0];
    s->speed = SPEED;
    s->couple_desc.fraction = 0.2;
    s->transport_desc.user = s;
    s->desc.model = PD_METAL_BONDS;
    s->desc.solid = CS;
    s->desc.saturation = CSAT;
    s->desc.activation = 1;
    s->desc.rate = constant_law;
    s->desc.uniform = 1;
    s->desc.rate_user = &s->speed;
    return s;
}

/* Everything but lattice and bonds; the status is that of the first builder that refuses. */
static pd_status scene_physics(scene *s)
{
    pd_status status = pd_transport_build(&s->ctx, &s->grid, &s->bonds, NULL, &s->transport_desc, &s->transport);
    if (status == PD_OK)
        status = pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &s->transport, &s->desc, &s->dissolve);
    if (status == PD_OK) status = pd_time_loop_build(&s->ctx, &s->couple_desc, &s->grid, &s->bonds, &s->couple);
    if (status == PD_OK) status = pd_time_loop_add_process(&s->ctx, &s->couple, pd_dissolve_process(&s->dissolve));
    return status;
}

static int scene_metal(scene *s)
{
    for (int k = 0; k < 2 * PD_DIM; k++)
        if (s->open[k]) s->transport_desc.held = held_bulk;
    return CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) &&
           CHECK_OK(&s->ctx, scene_physics(s));
}

static int scene_lattice(scene *s)
{
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil)) &&
           CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid));
}

static inline int scene_build(scene *s) { return scene_lattice(s) && scene_metal(s); }

static void scene_free(scene *s)
{
    pd_dissolve_free(&s->ctx, &s->dissolve);
    pd_dissolve_free(&s->ctx, &s->dissolve); /* twice is allowed */
    pd_transport_free(&s->ctx, &s->transport);
    pd_bonds_free(&s->ctx, &s->bonds);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT(s->ctx.in_use, 0);
}

static inline pd_status scene_run(scene *s, double t_end)
{
    return pd_time_loop_run(&s->ctx, &s->couple, t_end, 0.0, NULL, NULL);
}

static inline double scene_solid(const scene *s)
{
    double volume;
    return pdi_content_stock(&s->ctx, &s->dissolve, &volume);
}

/* One step that does not pass t_end. */
static inline int scene_step(scene *s, double t_end)
{
    pd_time_loop *c = &s->couple;
    if (!c->started && !CHECK_OK(&s->ctx, pd_time_loop_start(&s->ctx, c))) return 0;
    return CHECK_OK(&s->ctx, pd_time_loop_step(&s->ctx, c, t_end));
}

/* All fluid holds c; the balance begins anew with it. */
static inline void scene_fill(scene *s, double c)
{
    double before = pd_transport_stock(&s->ctx, &s->transport);
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_FLUID) s->transport.c[i] = c;
    s->couple.ledger[0].start += pd_transport_stock(&s->ctx, &s->transport) - before;
}

static inline void scene_periodic(scene *s)
{
    for (int d = 1; d < PD_DIM; d++) s->grid_desc.side[2 * d] = s->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
}

static inline void half_space(scene *s, double at)
{
    s->shapes[0].type = PD_SHAPE_HALF_SPACE;
    s->shapes[0].a[0] = at;
    s->shapes[0].b[0] = -1.0;
}

#define PENCIL_D 8.5e-10         /* [m2/s] */
#define PENCIL_LAMBDA 0.13515753 /* [-] sqrt(pi) l exp(l^2) erf(l) = Csat/(Cs - Csat), Cs = 143 M, Csat = 5.1 M */
#define PENCIL_START 8e-6        /* [m] depth at which the run starts, on the closed form */

static inline uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* A lump of metal with holes beside a wall, in a box with one kind of each side. */
static inline scene *lump(pd_drive drive, int threads, const double *factor)
{
    static const pd_side sides[6] = {PD_SIDE_WALL, PD_SIDE_MIRROR, PD_SIDE_PERIODIC, PD_SIDE_PERIODIC, PD_SIDE_WALL,
                                     PD_SIDE_WALL};
    /* with threads so large that they are used */
    int y = threads ? 12 : 5, z = threads ? 12 : 6;
    scene *s = PD_DIM == 3 ? scene_start(12, y, z) : scene_start(40, threads ? 80 : 25, 0);
    uint32_t seed = 99;
    s->ctx.threads = threads;
    for (int k = 0; k < 2 * PD_DIM; k++) s->grid_desc.side[k] = sides[k];
    s->open[0] = 1;
    if (PD_DIM == 3) s->open[5] = 1;
    half_space(s, 0.4 * s->grid_desc.hi[0]);
    s->grid_desc.wall = &s->shapes[1];
    s->shapes[1].type = PD_SHAPE_BALL;
    s->shapes[1].radius = 2.5 * H;
    s->shapes[1].a[0] = 0.5 * s->grid_desc.hi[0];
    s->stencil_desc.m = 2.0;
    s->desc.activation = 0;
    s->desc.drive = drive;
    s->desc.factor = factor;
    s->transport_desc.diffusivity = 1e-12;
    s->transport_desc.initial = 100.0;
    if (!scene_lattice(s)) return NULL;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_SOLID && next_random(&seed) % 12 == 0) pdi_grid_set_fluid(&s->grid, i);
    return scene_metal(s) ? s : NULL;
}

#endif
