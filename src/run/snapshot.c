/* snapshot: see snapshot.h */
#include "run/snapshot.h"

pd_status pd_snapshot_get_field(pd_ctx *ctx, const pd_snapshot *at, const char *name, pd_field_view *view)
{
    return pdi_field_view_get(ctx, at->writable_model, at->views, name, view);
}

pd_status pd_snapshot_get_outputs(pd_ctx *ctx, const pd_snapshot *at, pd_scalar_outputs *figures)
{
    figures->count = 0;
    return pdi_scalar_outputs_collect(ctx, at->writable_model, at->monitors, 1, figures);
}
