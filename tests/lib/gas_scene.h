/* gas_scene: a box of gas for the test programs of the module gas. */
#ifndef GAS_SCENE_H
#define GAS_SCENE_H
#include "test.h"
#include "flow/gas.h"
#include "io/archive_file.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GAMMA 1.4
#define P_FIELD (PD_DIM + 1)

#define PI 3.14159265358979323846

/* [m/s] a stream that is no axis */
static const double STREAM[3] = {1.0, 0.5, -0.25};

typedef struct scene {
    pd_ctx ctx;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_gas gas;
} scene;

/* What a scene differs in; zero: m = 3, walls, unit cells, no solid. */
typedef struct setup {
    double m, length; /* length [m] of axis 0, 0: 1 */
    int cells[PD_DIM];
    pd_side side[2 * PD_DIM];
    const pd_shape *shapes;
    const pd_shape *solid; /* one of the shapes */
    pd_gas_desc gas;
} setup;

static inline void setup_init(setup *u, int along, int across, pd_side ends, pd_side sides)
{
    memset(u, 0, sizeof *u);
    for (int d = 0; d < PD_DIM; d++) {
        u->cells[d] = d ? across : along;
        u->side[2 * d] = u->side[2 * d + 1] = d ? sides : ends;
    }
    u->length = 1.0;
    u->gas.gamma = GAMMA;
}

static inline pd_status scene_build(scene *s, const setup *u)
{
    pd_stencil_desc sd;
    pd_grid_desc gd;
    memset(s, 0, sizeof *s);
    memset(&sd, 0, sizeof sd);
    memset(&gd, 0, sizeof gd);
    pd_ctx_init(&s->ctx);
    sd.m = u->m;
    for (int d = 0; d < PD_DIM; d++) {
        sd.h[d] = u->length / u->cells[0];
        gd.hi[d] = u->cells[d] * sd.h[d];
    }
    memcpy(gd.side, u->side, sizeof gd.side);
    gd.shapes = u->shapes;
    gd.solid = u->solid;
    PD_TRY(pd_stencil_build(&s->ctx, &sd, &s->stencil));
    PD_TRY(pd_grid_build(&s->ctx, &s->stencil, &gd, &s->grid));
    PD_TRY(pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds));
    return pd_gas_build(&s->ctx, &s->grid, &s->bonds, &u->gas, &s->gas);
}

static inline void scene_free(scene *s)
{
    pd_gas_free(&s->ctx, &s->gas);
    pd_bonds_free(&s->ctx, &s->bonds);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT((int)s->ctx.in_use, 0);
}

static inline double field(const scene *s, int c, int32_t node)
{
    return s->gas.primitive[(int64_t)c * s->grid.total + node];
}

#endif
