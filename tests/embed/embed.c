/* A whole user program: this file and pdcorr.h. */
#define PDCORR_IMPLEMENTATION
#include "pdcorr.h"
#include <stdio.h>

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
    printf("dim=%d bonds=%d\n", PD_DIM, stencil.count);
    pd_stencil_free(&ctx, &stencil);
    return ctx.in_use != 0;
}
