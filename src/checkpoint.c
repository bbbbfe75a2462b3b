/* checkpoint: see checkpoint.h */
#include "checkpoint.h"
#include "identity.h"
#include <string.h>

#define PDI_CHECKPOINT_SCENE (1 << 24) /* [byte] */

/* The text of the scene. */
static pd_status pdi_checkpoint_scene(pd_ctx *ctx, const pd_setup *u, pd_store *store)
{
    int64_t size = (int64_t)u->identity_size;
    char *kept = NULL;
    PDI_TRY(PDI_STORE(ctx, store, "size of the scene", &size, 1));
    if (!store->reading) return PDI_STORE(ctx, store, "scene", u->identity, size);
    if (size < 0 || size > PDI_CHECKPOINT_SCENE)
        return pdi_fail(ctx, PD_ERR_ARGUMENT, store->file.path, "it keeps a scene of %.0f bytes, expected at most %d",
                        (double)size, PDI_CHECKPOINT_SCENE);
    PDI_TRY(PDI_NEW(ctx, "checkpoint", size + 1, kept));
    pd_status status = PDI_STORE(ctx, store, "scene", kept, size);
    if (status == PD_OK) status = pdi_identity_compare(ctx, u, kept, store->file.path);
    PDI_DELETE(ctx, size + 1, kept);
    return status;
}

PDI_FN pd_status pdi_checkpoint_model(pd_ctx *ctx, pd_model *model, pd_store *store)
{
    const pd_setup *u = model->setup;
    PDI_TRY(pdi_checkpoint_scene(ctx, u, store));
    /* what callers change in a setup that was read */
    PDI_TRY(pd_store_check(ctx, store, "until [s]", u->until));
    PDI_TRY(pd_store_check(ctx, store, "every [s]", u->every));
    PDI_TRY(pd_store_check(ctx, store, "rtol", u->rtol));
    PDI_TRY(pd_store_check(ctx, store, "fraction", u->fraction));
    PDI_TRY(pd_store_check(ctx, store, "max_step [s]", u->max_step));
    return pd_couple_store(ctx, &model->couple, store);
}

/* The model through a store that was just created or opened. */
static pd_status pdi_checkpoint_move(pd_ctx *ctx, pd_model *model, pd_store *store)
{
    pd_status status = pdi_checkpoint_model(ctx, model, store);
    if (status == PD_OK) return pd_store_close(ctx, store);
    pd_store_abandon(store);
    return status;
}

pd_status pd_checkpoint_save(pd_ctx *ctx, const char *path, pd_model *model)
{
    pd_store store;
    PDI_TRY(pd_store_create(ctx, path, &store));
    return pdi_checkpoint_move(ctx, model, &store);
}

pd_status pd_checkpoint_load(pd_ctx *ctx, const char *path, pd_model *model)
{
    pd_store store;
    PDI_TRY(pd_store_open(ctx, path, &store));
    return pdi_checkpoint_move(ctx, model, &store);
}

#undef PDI_CHECKPOINT_SCENE
