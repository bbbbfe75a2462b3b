/* A program of a user: the version, and the bonds of a family in the dimension that it is compiled for. */
#include <pdcorr.h>
#include <stdio.h>

#if PD_VERSION_MAJOR == 0 && PD_VERSION_MINOR < 1
#error "an older pdcorr"
#endif

int main(void)
{
    pd_ctx ctx;
    pd_stencil_desc desc;
    pd_stencil stencil;
    pd_ctx_init(&ctx);
    desc.m = 3.0;
    desc.weights = PD_WEIGHTS_CALIBRATED;
    for (int d = 0; d < PD_DIM; d++) desc.h[d] = 5e-6;
    if (pd_stencil_build(&ctx, &desc, &stencil) != PD_OK) {
        printf("%s\n", ctx.message);
        return 1;
    }
    printf("%s %d.%d.%d dim=%d bonds=%d\n", PD_VERSION, PD_VERSION_MAJOR, PD_VERSION_MINOR, PD_VERSION_PATCH, PD_DIM,
           stencil.count);
    pd_stencil_free(&ctx, &stencil);
    return ctx.in_use != 0;
}
