/* checkpoint: the state of a model into an archive, and back into a model built from the same setup.
 *
 * What the build gives is not kept. A whole run with its tables and pictures goes on by pd_run_desc (run.h).
 */
#ifndef PD_CHECKPOINT_H
#define PD_CHECKPOINT_H
#include "run/model.h"

#ifdef PDI_INTERNAL
/* Between two steps of model->couple, or into a model that was just built: pd_couple_run then goes on with the same
 * bits, with any number of threads. PD_ERR_ARGUMENT: of another scene (the message names the difference). On failure
 * the model is fit for pdi_model_free only. */
PDI_FN pd_status pdi_checkpoint_model(pd_ctx *ctx, pd_model *model, pd_archive *archive);
#endif

#endif
