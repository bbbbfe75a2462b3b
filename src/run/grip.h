/* grip: what holds and loads a body: sides of the box, shapes, forces on all of it. */
#ifndef PD_GRIP_H
#define PD_GRIP_H
#include "couple/structure.h"
#include "scene/setup.h"

typedef struct pd_grips {
    const pd_setup *setup;
    pd_structure *structure;
    int rows[PD_SETUP_GRIPS];    /* of nodes beside a side that it holds */
    double area[PD_SETUP_GRIPS]; /* [m^(d-1)] of metal on a side at the start */
    double borne[PD_SETUP_GRIPS][PD_DIM]; /* [m^(d-1)] of it, by (8.5), of each component of a traction */
    int faces[PD_SETUP_GRIPS];   /* bit d: the opposite side holds component d */
    int64_t led;                 /* components of points that sides hold */
    pd_interpolation interpolation; /* [led] room of how they follow free rows, as of the last load */
} pd_grips;

#ifdef PDI_INTERNAL
/* Find what the grips of the setup hold, and say so in structure->held and structure->rest. PD_ERR_GEOMETRY: a grip
 * that touches no metal. All is borrowed. */
PDI_FN pd_status pdi_grip_find(pd_ctx *ctx, const pd_setup *setup, pd_structure *structure, pd_grips *grips);
PDI_FN void pdi_grip_free(pd_ctx *ctx, pd_grips *grips);
PDI_FN void pdi_grip_list(pdi_owner *owner, void *grips);
/* A pd_load_fn; user is the pd_grips. A side moves its face. It holds the rows of nodes beside it as far as bonds feel
 * that the body ends there, where metal led to them without a gap at the start; they move as the straight line from the
 * face to the first row that is free. A traction acts on the metal that the side had at the start: the load stays as
 * metal goes. PD_ERR_STATE: a value is not finite, or too little metal is left to bear a traction. */
PDI_FN pd_status pdi_grip_load(pd_ctx *ctx, void *user, double t, double *u, double *load);
/* 1: grip k holds point i. */
PDI_FN int pdi_grip_holds(const pd_grips *grips, int k, int32_t i);
/* Grips whose sides hold point i along axis d, the last one across each axis: holders [PD_DIM]; returns how many. */
PDI_FN int pdi_grip_holders(const pd_grips *grips, int32_t i, int d, int *holders);
/* Rows beside a side whose bonds feel the end of the body: two horizons. */
PDI_FN int pdi_grip_depth(const pd_grips *grips);
/* [1/m] The part of (8.5) along the axis of a side, inward. */
PDI_FN double pdi_grip_edge(const pd_grips *grips, int32_t i, int side);
/* Add the traction of grip k to load [points][PD_DIM] [N/m3]. */
PDI_FN pd_status pdi_grip_pull(pd_ctx *ctx, const pd_grips *grips, int k, double t, double *load);
/* A pd_pace_fn; user is the pd_setup. */
PDI_FN double pdi_grip_pace(void *user, const pd_structure_at *at);
#endif

#endif
