/* instant: see instant.h */
#include "run/instant.h"

pd_status pd_instant_field(pd_ctx *ctx, const pd_instant *at, const char *name, pd_view *view)
{
    return pdi_view_field(ctx, at->own, at->views, name, view);
}

pd_status pd_instant_figures(pd_ctx *ctx, const pd_instant *at, pd_figures *figures)
{
    figures->count = 0;
    return pdi_figures_collect(ctx, at->own, at->monitors, 1, figures);
}
