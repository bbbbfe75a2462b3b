/* snapshot: see snapshot.h */
#include "run/snapshot.h"

pd_status pd_instant_field(pd_ctx *ctx, const pd_instant *at, const char *name, pd_view *view)
{
    return pdi_field_view_get(ctx, at->own, at->views, name, view);
}

pd_status pd_instant_figures(pd_ctx *ctx, const pd_instant *at, pd_figures *figures)
{
    figures->count = 0;
    return pdi_scalar_outputs_collect(ctx, at->own, at->monitors, 1, figures);
}
