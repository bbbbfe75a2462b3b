/* 05: a scene file in 20 lines.  cc -std=c99 -O2 -I. examples/05_embed.c -o 05_embed -lm */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"
#include <stdio.h>

int main(int argc, char **argv)
{
    const char *scene = argc > 1 ? argv[1] : "examples/scenes/mg_pin_2d.scene";
    const char *changes[] = {"h=10 um", "until=1 h", "output.folder=out/embed"};
    char line[512];
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc = {0};
    pd_run_result result;
    pd_ctx_init(&ctx);
    if (pd_scene_read(&ctx, scene, changes, 3, &setup) < 0 || pd_run(&ctx, &setup, &desc, &result) < 0) {
        fprintf(stderr, "%s\n", ctx.message);
        return 1;
    }
    pd_run_format_result(&result, line, sizeof line);
    printf("%s\n", line);
    pd_setup_free(&ctx, &setup);
    return 0;
}
