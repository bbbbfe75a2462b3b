/* fixture: the objects of a test, built in the order in which they need each other and freed in the reverse one.
 *
 *   scene *s = &test_scene;
 *   scene_box(s, 3.0, 1e-5, 40, 20, 10);        descs: a closed box of cells of 10 um, a horizon of 3 spacings
 *   s->grid_desc.side[0] = PD_SIDE_INLET;
 *   s->with = WITH_FLOW | WITH_TRANSPORT;       besides stencil, grid and bonds
 *   if (!scene_build(s)) return;
 *   scene_free(s);
 *
 * scene_try is scene_build for a test that expects an error. scene_grid and scene_rest are its halves, for a test that
 * changes the grid in between.
 */
#ifndef FIXTURE_H
#define FIXTURE_H
#include "couple/time_loop.h"
#include "flow/quasi_steady.h"
#include "metal/dissolve.h"
#include "random.h"
#include "test.h"

enum {
    WITH_FLOW = 1,
    WITH_STEADY = 2,
    WITH_TRANSPORT = 4,
    WITH_DISSOLVE = 8,
    WITH_COUPLE = 16
};

#define SCENE_SHAPES 4
#define SCENE_FIELDS 4

typedef struct scene {
    pd_ctx ctx;
    int with;
    int fields; /* of the test's own, SCENE_FIELDS at most */
    pd_stencil_desc stencil_desc;
    pd_grid_desc grid_desc;
    pd_shape shapes[SCENE_SHAPES];
    pd_flow_desc flow_desc;
    pd_steady_desc steady_desc;
    pd_transport_desc transport_desc;
    pd_dissolve_desc dissolve_desc;
    pd_time_loop_desc couple_desc;
    double mean, width; /* [m/s] [m] of a channel, for inlets of tests that get the scene */
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    pd_steady steady;
    pd_transport transport;
    pd_dissolve dissolve;
    pd_quasi_steady quasi;
    pd_time_loop couple;
    pd_transport_result result;
    int64_t size;                /* of a vector field */
    double *field[SCENE_FIELDS]; /* [size] each, zeros */
} scene;

/* Empty descs: no solid, no walls but the sides. */
static inline void scene_reset(scene *s)
{
    memset(s, 0, sizeof *s);
    pd_ctx_init(&s->ctx);
    s->grid_desc.shapes = s->shapes;
}

/* A closed box from the origin of x * y * z cells of spacing h, with a horizon of m spacings (0: the default). */
static inline void scene_box(scene *s, double m, double h, int x, int y, int z)
{
    int n[3];
    n[0] = x;
    n[1] = y;
    n[2] = z;
    scene_reset(s);
    s->stencil_desc.m = m;
    for (int d = 0; d < PD_DIM; d++) {
        s->stencil_desc.h[d] = h;
        s->grid_desc.hi[d] = n[d] * h;
    }
}

/* A shape from lo to hi. */
static inline void scene_solid_box(pd_shape *shape, const double *lo, const double *hi)
{
    shape->type = PD_SHAPE_BOX;
    for (int d = 0; d < PD_DIM; d++) {
        shape->a[d] = lo[d];
        shape->b[d] = hi[d];
    }
}

static inline pd_status scene_try_grid(scene *s)
{
    PD_TRY(pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil));
    return pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid);
}

static inline pd_status scene_try_rest(scene *s)
{
    pd_flow *flow = s->with & WITH_FLOW ? &s->flow : NULL;
    pd_steady *steady = s->with & WITH_STEADY ? &s->steady : NULL;
    PD_TRY(pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds));
    s->size = (int64_t)PD_DIM * s->grid.total;
    if (flow) PD_TRY(pd_flow_build(&s->ctx, &s->grid, &s->bonds, &s->flow_desc, flow));
    if (steady) PD_TRY(pd_steady_build(&s->ctx, flow, &s->steady_desc, steady));
    if (s->with & WITH_TRANSPORT)
        PD_TRY(pd_transport_build(&s->ctx, &s->grid, &s->bonds, flow, &s->transport_desc, &s->transport));
    if (s->with & WITH_DISSOLVE)
        PD_TRY(pd_dissolve_build(&s->ctx, &s->grid, &s->stencil, &s->transport, &s->dissolve_desc, &s->dissolve));
    if (s->with & WITH_COUPLE) PD_TRY(pd_time_loop_build(&s->ctx, &s->couple_desc, &s->grid, &s->bonds, &s->couple));
    if ((s->with & WITH_COUPLE) && steady)
        PD_TRY(pd_time_loop_add_process(&s->ctx, &s->couple, pd_quasi_steady_process(flow, steady, &s->quasi)));
    if ((s->with & WITH_COUPLE) && (s->with & WITH_DISSOLVE))
        PD_TRY(pd_time_loop_add_process(&s->ctx, &s->couple, pd_dissolve_process(&s->dissolve)));
    for (int k = 0; k < s->fields; k++) PD_TRY(PD_NEW(&s->ctx, "test", s->size, s->field[k]));
    return PD_OK;
}

static inline pd_status scene_try(scene *s)
{
    PD_TRY(scene_try_grid(s));
    return scene_try_rest(s);
}

static inline int scene_grid(scene *s) { return CHECK_OK(&s->ctx, scene_try_grid(s)); }
static inline int scene_rest(scene *s) { return CHECK_OK(&s->ctx, scene_try_rest(s)); }
static inline int scene_build(scene *s) { return CHECK_OK(&s->ctx, scene_try(s)); }

/* The same with a horizon of m spacings. */
static inline int scene_grid_m(scene *s, double m)
{
    s->stencil_desc.m = m;
    return scene_grid(s);
}

static inline int scene_build_m(scene *s, double m)
{
    s->stencil_desc.m = m;
    return scene_build(s);
}

/* Everything is freed twice, which is allowed; nothing is left. */
static inline void scene_free(scene *s)
{
    for (int twice = 0; twice < 2; twice++) {
        pd_dissolve_free(&s->ctx, &s->dissolve);
        pd_transport_free(&s->ctx, &s->transport);
        pd_steady_free(&s->ctx, &s->steady);
        pd_flow_free(&s->ctx, &s->flow);
        pd_bonds_free(&s->ctx, &s->bonds);
        pd_grid_free(&s->ctx, &s->grid);
        pd_stencil_free(&s->ctx, &s->stencil);
    }
    for (int k = 0; k < s->fields; k++) PD_DELETE(&s->ctx, s->size, s->field[k]);
    CHECK_INT(s->ctx.in_use, 0);
}

#endif
