/* implicit_scene: the objects of a flow in time that is implicit, from descs to the solver. */
#ifndef IMPLICIT_SCENE_H
#define IMPLICIT_SCENE_H
#include "flow/implicit.h"
#include "test.h"

typedef struct scene {
    pd_ctx ctx;
    pd_stencil_desc stencil_desc;
    pd_grid_desc grid_desc;
    pd_flow_desc flow_desc;
    pd_implicit_desc desc;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_flow flow;
    pd_steady steady;
    pd_implicit implicit;
} scene;

static inline int scene_build(scene *s)
{
    pd_steady_desc sd;
    memset(&sd, 0, sizeof sd);
    return CHECK_OK(&s->ctx, pd_stencil_build(&s->ctx, &s->stencil_desc, &s->stencil)) &&
           CHECK_OK(&s->ctx, pd_grid_build(&s->ctx, &s->stencil, &s->grid_desc, &s->grid)) &&
           CHECK_OK(&s->ctx, pd_bonds_build(&s->ctx, &s->stencil, &s->grid, 0, &s->bonds)) &&
           CHECK_OK(&s->ctx, pd_flow_build(&s->ctx, &s->grid, &s->bonds, &s->flow_desc, &s->flow)) &&
           CHECK_OK(&s->ctx, pd_steady_build(&s->ctx, &s->flow, &sd, &s->steady)) &&
           CHECK_OK(&s->ctx, pd_implicit_build(&s->ctx, &s->flow, &s->steady, &s->desc, &s->implicit));
}

static inline void scene_free(scene *s)
{
    pd_implicit_free(&s->ctx, &s->implicit);
    pd_steady_free(&s->ctx, &s->steady);
    pd_flow_free(&s->ctx, &s->flow);
    pd_bonds_free(&s->ctx, &s->bonds);
    pd_grid_free(&s->ctx, &s->grid);
    pd_stencil_free(&s->ctx, &s->stencil);
    CHECK_INT((int)s->ctx.in_use, 0);
}

#endif
