/* Uses the library whose implementation is in another file. */
#include "pdcorr.h"

int main(void)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    return ctx.in_use != 0;
}
