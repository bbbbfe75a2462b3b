/* checkpoint: see checkpoint.h */
#include "run/checkpoint.h"
#include "scene/fingerprint.h"
#include <string.h>

#define PDI_CHECKPOINT_MAX_SCENE_BYTES (1 << 24) /* [byte] largest text of a scene */

/* Store the text of the scene, or compare it with that of the checkpoint. PD_ERR_ARGUMENT: they differ, or the stored
 * one is longer than 16 MiB. */
static pd_status pdi_checkpoint_store_scene(pd_ctx *ctx, const pd_setup *setup, pd_archive *archive)
{
    int64_t size = (int64_t)setup->fingerprint_size;
    char *kept = NULL;
    PD_TRY(PD_ARCHIVE_ARRAY(ctx, archive, "size of the scene", &size, 1));
    if (!archive->is_reading) return PD_ARCHIVE_ARRAY(ctx, archive, "scene", setup->fingerprint, size);
    if (size < 0 || size > PDI_CHECKPOINT_MAX_SCENE_BYTES)
        return pd_fail(ctx, PD_ERR_ARGUMENT, archive->name, "it keeps a scene of %.0f bytes, expected at most %d",
                       (double)size, PDI_CHECKPOINT_MAX_SCENE_BYTES);
    PD_TRY(PD_NEW(ctx, "checkpoint", size + 1, kept));
    pd_status status = PD_ARCHIVE_ARRAY(ctx, archive, "scene", kept, size);
    if (status == PD_OK) status = pdi_fingerprint_check(ctx, setup, kept, archive->name);
    PD_DELETE(ctx, size + 1, kept);
    return status;
}

PDI_FN pd_status pdi_checkpoint_store_model(pd_ctx *ctx, pd_model *model, pd_archive *archive)
{
    const pd_setup *u = model->setup;
    PD_TRY(pdi_checkpoint_store_scene(ctx, u, archive));
    /* what callers change in a setup that was read */
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "until [s]", u->end_time));
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "every [s]", u->output_interval));
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "rtol", u->rtol));
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "fraction", u->max_node_fraction));
    PD_TRY(PD_ARCHIVE_VERIFY(ctx, archive, "max_step [s]", u->max_step));
    return pd_time_loop_store(ctx, &model->time_loop, archive);
}

#undef PDI_CHECKPOINT_MAX_SCENE_BYTES
