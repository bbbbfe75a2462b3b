/* Scenes of the tests of bond-based corrosion: metal of the 304 pencil electrode in a box. */
#ifndef CORRODE_SCENE_H
#define CORRODE_SCENE_H
#include "metal/march.h"
#include "test.h"

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
    pd_corrode_desc desc;
    pd_corrode corrode;
    double speed;
} scene;

static scene test_scene;

static double constant_law(void *user, const pd_rate_at *at)
{
    (void)at;
    return *(const double *)user;
}

/* A box of cells from the origin, m = 3, activation control at SPEED. */
static scene *scene_start(int x, int y, int z)
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
    s->grid_desc.solid = 0;
    s->grid_desc.wall = -1;
    s->speed = SPEED;
    s->desc.solid = CS;
    s->desc.saturation = CSAT;
    s->desc.activation = 1;
    s->desc.rate = constant_law;
    s->desc.uniform = 1;
    s->desc.rate_user = &s->speed;
    return s;
}

static int scene_build(scene *s)
{
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil)) &&
           CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)) &&
           CHECK_OK(&s->ctx, pd_corrode_build(&s->ctx, &s->grid, &s->stencil, &s->desc, &s->corrode));
}

static void scene_free(scene *s)
{
    pd_corrode_free(&s->ctx, &s->corrode);
    pd_corrode_free(&s->ctx, &s->corrode); /* twice is allowed */
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT(s->ctx.in_use, 0);
}

static void half_space(scene *s, double at)
{
    s->shapes[0].type = PD_SHAPE_HALF_SPACE;
    s->shapes[0].a[0] = at;
    s->shapes[0].b[0] = -1.0;
}

#define PENCIL_D 8.5e-10         /* [m2/s] */
#define PENCIL_LAMBDA 0.13515753 /* [-] sqrt(pi) l exp(l^2) erf(l) = Csat/(Cs - Csat), Cs = 143 M, Csat = 5.1 M */
#define PENCIL_START 8e-6        /* [m] depth at which the run starts, on the closed form */
#define PENCIL_10S 24.9218e-6    /* [m] depth at 10 s (closed form; pencil304_stefan.csv) */

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* A lump of metal with holes beside a wall, in a box with one kind of each side. */
static scene *lump(pd_drive drive, int threads, const double *factor)
{
    static const pd_side sides[6] = {PD_SIDE_INLET, PD_SIDE_MIRROR, PD_SIDE_PERIODIC, PD_SIDE_PERIODIC, PD_SIDE_WALL,
                                     PD_SIDE_OUTLET};
    /* with threads so large that they are used */
    int y = threads ? 12 : 5, z = threads ? 12 : 6;
    scene *s = PD_DIM == 3 ? scene_start(12, y, z) : scene_start(40, threads ? 80 : 25, 0);
    uint32_t seed = 99;
    s->ctx.threads = threads;
    for (int k = 0; k < 2 * PD_DIM; k++) s->grid_desc.side[k] = sides[k];
    half_space(s, 0.4 * s->grid_desc.hi[0]);
    s->grid_desc.wall = 1;
    s->shapes[1].type = PD_SHAPE_BALL;
    s->shapes[1].r = 2.5 * H;
    s->shapes[1].a[0] = 0.5 * s->grid_desc.hi[0];
    s->stencil_desc.m = 2.0;
    s->desc.activation = 0;
    s->desc.diffusivity = 1e-12;
    s->desc.initial = 100.0;
    s->desc.drive = drive;
    s->desc.factor = factor;
    if (!CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil)) ||
        !CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)))
        return NULL;
    for (int32_t i = 0; i < s->grid.total; i++)
        if (s->grid.kind[i] == PD_SOLID && next_random(&seed) % 12 == 0) pdi_grid_dissolve(&s->grid, i);
    return CHECK_OK(&s->ctx, pd_corrode_build(&s->ctx, &s->grid, &s->stencil, &s->desc, &s->corrode)) ? s : NULL;
}


#endif
