/* field_view: output fields by name as arrays over the cells of the box, for programs that access a model while it
 * runs. */
#ifndef PD_FIELD_VIEW_H
#define PD_FIELD_VIEW_H
#include "physics/model.h"

/* A field over the cells of the box, without ghosts; NaN where a cell has just turned fluid, and nothing is known of
 * what is dissolved in it: component d of cell i, j, k stands at
 * data[d * part + i * stride[0] + j * stride[1] + k * stride[2]]. */
typedef struct pd_field_view {
    const double *data; /* [components][cells] [unit of the label] */
    const char *label;  /* "C [mol/m3]" */
    int components;     /* PD_DIM of v, else 1 */
    int n[PD_DIM];      /* cells */
    int64_t stride[PD_DIM], component_stride;
} pd_field_view;

/* The values of the fields that were asked for. Zero-initialise. */
typedef struct pd_field_views {
    int64_t cells;                 /* of the box */
    double *field[PD_FIELD_COUNT]; /* [components][cells] [unit of the field] */
} pd_field_views;

#ifdef PDI_APP_INTERNAL
/* Compute a field as it is now into views->field, which is allocated at its first request, and describe it in view; the
 * values stay in place until it is requested again. Velocities are 0 outside the fluid. PD_ERR_ARGUMENT, view zero: no
 * such field, or the scene has none. */
PDI_FN pd_status pdi_field_view_get(pd_ctx *ctx, pd_model *model, pd_field_views *views, const char *name,
                                    pd_field_view *view);
/* Free the values of all fields and zero views; every view of them is invalid then. */
PDI_FN void pdi_field_view_free(pd_ctx *ctx, pd_field_views *views);
#endif

#endif
