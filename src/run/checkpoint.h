/* checkpoint: stores the state of a model in an archive, or loads it into a model built from the same setup.
 *
 * What the build gives is not kept. A whole run with its tables and pictures goes on by pd_run_desc (run.h).
 */
#ifndef PD_CHECKPOINT_H
#define PD_CHECKPOINT_H
#include "physics/model.h"

#ifdef PDI_APP_INTERNAL
/* Store or load the state of a model, between two steps or right after its build: the time loop then continues with the
 * same bits for any number of threads. Loading checks that scene, end time, output interval, rtol, max_node_fraction
 * and max_step are the same. PD_ERR_ARGUMENT: they are not (the message names the difference). After a failure the
 * model may only be freed. */
PDI_FN pd_status pdi_checkpoint_store_model(pd_ctx *ctx, pd_model *model, pd_archive *archive);
#endif

#endif
