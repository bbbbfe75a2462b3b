/* checkpoint: the state of a model in a file, and back into a model built from the same setup.
 *
 * What the build gives is not kept. The file is written aside and renamed, so that the one before stays until the new
 * one is complete (store.h). A whole run with its tables and pictures goes on by pd_run_desc (run.h).
 */
#ifndef PD_CHECKPOINT_H
#define PD_CHECKPOINT_H
#include "run/model.h"

#define pd_checkpoint_save PD_NAME(pd_checkpoint_save)
#define pd_checkpoint_load PD_NAME(pd_checkpoint_load)

/* Between two steps of model->couple. PD_ERR_FILE: the former file stays. */
PD_API pd_status pd_checkpoint_save(pd_ctx *ctx, const char *path, pd_model *model);
/* Into a model that was just built: pd_couple_run then goes on with the same bits, with any number of threads.
 * PD_ERR_FILE: missing, cut off or damaged. PD_ERR_ARGUMENT: of another scene, dimension, format or version (the
 * message names the difference). On failure the model is fit for pd_model_free only. */
PD_API pd_status pd_checkpoint_load(pd_ctx *ctx, const char *path, pd_model *model);

#ifdef PDI_INTERNAL
/* The items of a model, for both ways. */
PDI_FN pd_status pdi_checkpoint_model(pd_ctx *ctx, pd_model *model, pd_archive *archive);
#endif

#endif
