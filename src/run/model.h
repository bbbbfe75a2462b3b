/* model: the objects of one run, built from a setup: grid, bonds and only the physics that the setup asks for. */
#ifndef PD_MODEL_H
#define PD_MODEL_H
#include "couple/couple.h"
#include "run/inlet.h"
#include "run/wall.h"

/* Objects point at each other: a built model must not be moved. Absent physics stays zero. */
typedef struct pd_model {
    const pd_setup *setup;
    int line;                 /* of the scene: what was being built when the build failed; 0: unknown */
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_inlet inlet;
    pd_flow flow;
    pd_steady steady;     /* absent with explicit flow */
    pd_implicit implicit;
    pd_unsteady unsteady;
    pd_transport transport;
    pd_advance advance;   /* without dissolution */
    pd_grain grain;
    pd_grain_stats grain_stats;
    double *factor;           /* [total] [-] rate factor of the grain boundaries; NULL: 1 */
    pd_dissolve dissolve;
    uint8_t *passive;         /* [total] 1: in front of a passive film; NULL: none */
    pd_couple couple;
    size_t bytes[PD_PART_COUNT];     /* [byte] */
    int64_t unknowns[PD_PART_COUNT];
} pd_model;

#define pd_model_build PD_NAME(pd_model_build)
#define pd_model_free PD_NAME(pd_model_free)

/* setup is borrowed for the life of the model. The errors of the builders, PD_ERR_STATE for an initial field that is
 * negative or not finite. */
PD_API pd_status pd_model_build(pd_ctx *ctx, const pd_setup *setup, pd_model *model);
PD_API void pd_model_free(pd_ctx *ctx, pd_model *model);

#ifdef PDI_INTERNAL
/* The lattice of a setup alone. *line: of the scene, what was being built; unchanged when unknown. */
PDI_FN pd_status pdi_model_grid(pd_ctx *ctx, const pd_setup *setup, int *line, pd_stencil *stencil, pd_grid *grid);
#endif

#endif
