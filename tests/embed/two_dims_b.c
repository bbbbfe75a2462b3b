#define PD_DIM 3
#include "pdcorr.h"
#include "two_dims.h"

int bonds_3d(void)
{
    pd_ctx ctx;
    pd_stencil_desc desc = {3.0, {1e-6, 1e-6, 1e-6}, PD_WEIGHTS_CALIBRATED};
    pd_stencil stencil;
    pd_ctx_init(&ctx);
    int count = pd_stencil_build(&ctx, &desc, &stencil) == PD_OK ? stencil.count : -1;
    pd_stencil_free(&ctx, &stencil);
    return count;
}
