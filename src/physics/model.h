/* model: builds all solvers of one simulation from a setup: grid, bonds and only the physics that the setup has. */
#ifndef PD_MODEL_H
#define PD_MODEL_H
#include "physics/physics_list.h"

#define pd_model_build PD_NAME(pd_model_build)
#define pd_model_build_grid PD_NAME(pd_model_build_grid)
#define pd_model_free PD_NAME(pd_model_free)
#define pd_model_get_statistics PD_NAME(pd_model_get_statistics)

/* Build all solvers of a setup, which is borrowed for the life of the model; resets *model, which must not be moved
 * afterwards. The errors of the builders; PD_ERR_STATE: an initial field is negative or not finite. On failure nothing
 * is left but error_line. */
PD_API pd_status pd_model_build(pd_ctx *ctx, const pd_setup *setup, pd_model *model);
PD_API void pd_model_free(pd_ctx *ctx, pd_model *model);
/* Collect the solver statistics of a model, into all of *effort; 0 where there is no such solver. */
PD_API void pd_model_get_statistics(const pd_model *model, pd_model_statistics *effort);
/* Build stencil and grid of a setup only; after an error the caller frees the stencil, too. *line: becomes the line of
 * the scene's shapes, if it has any, before the grid is built, as an error is about these; else it stays. */
PD_API pd_status pd_model_build_grid(pd_ctx *ctx, const pd_setup *setup, int *line, pd_stencil *stencil,
                                     pd_grid *grid);

#endif
