/* checkpoint_model: a model in a file. */
#ifndef CHECKPOINT_MODEL_H
#define CHECKPOINT_MODEL_H
#include "io/archive_file.h"
#include "run/checkpoint.h"

static inline pd_status checkpoint_move(pd_ctx *ctx, pd_model *model, pd_archive_file *store)
{
    pd_status status = pdi_checkpoint_store_model(ctx, model, &store->archive);
    if (status == PD_OK) return pd_archive_file_close(ctx, store);
    pdi_archive_file_abandon(store);
    return status;
}

static inline pd_status checkpoint_save(pd_ctx *ctx, const char *path, pd_model *model)
{
    pd_archive_file store;
    PD_TRY(pd_archive_file_create(ctx, path, &store));
    return checkpoint_move(ctx, model, &store);
}

static inline pd_status checkpoint_load(pd_ctx *ctx, const char *path, pd_model *model)
{
    pd_archive_file store;
    PD_TRY(pd_archive_file_open(ctx, path, &store));
    return checkpoint_move(ctx, model, &store);
}

#endif
