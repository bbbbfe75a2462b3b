/* bond_scene: stencil, grid and bonds of a box with shapes, for the tests of bonds. */
#ifndef BOND_SCENE_H
#define BOND_SCENE_H
#include "lattice/bond.h"
#include "fault.h"
#include "test.h"

#define CELLS_MAX 4096

typedef struct scene {
    pd_ctx ctx;
    pd_stencil stencil;
    pd_grid_desc desc;
    pd_shape shapes[7];
    uint8_t mask[CELLS_MAX];
    int n[PD_DIM], cells;
    pd_grid grid;
    pd_bonds bonds;
} scene;

static scene test_scene;

/* A box from the origin with spacing h, walls all round, no shape; the context is kept. */
static int scene_init(scene *s, double m, double h, int x, int y, int z)
{
    pd_stencil_desc sd;
    pd_ctx ctx = s->ctx;
    int all[3];
    memset(s, 0, sizeof *s);
    memset(&sd, 0, sizeof sd);
    s->ctx = ctx;
    all[0] = x;
    all[1] = y;
    all[2] = z;
    sd.m = m;
    s->desc.shapes = s->shapes;
    s->cells = 1;
    for (int d = 0; d < PD_DIM; d++) {
        sd.h[d] = h;
        s->n[d] = all[d];
        s->cells *= all[d];
        s->desc.hi[d] = all[d] * h;
    }
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &sd, &s->stencil));
}

/* The mask becomes the solid. */
static void scene_voxels(scene *s)
{
    s->shapes[0].type = PD_SHAPE_VOXELS;
    s->shapes[0].mask = s->mask;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].b[d] = s->stencil.h[d];
        s->shapes[0].mask_size[d] = s->n[d];
    }
    s->desc.solid = &s->shapes[0];
}

static int scene_build(scene *s)
{
    return CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->desc, &s->grid)) &&
           CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) &&
           CHECK_OK(&s->ctx, pd_bonds_validate(&s->ctx, &s->bonds));
}

static void scene_free(scene *s)
{
    pd_bonds_free(&s->ctx, &s->bonds);
    pd_bonds_free(&s->ctx, &s->bonds); /* twice is allowed */
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT(s->ctx.in_use, 0);
}

#endif
