/* model_scene: the model of a scene that stands in the test, built, run and freed. Include it behind other headers: its
 * names would hide theirs. */
#ifndef MODEL_SCENE_H
#define MODEL_SCENE_H
#include "physics/model.h"
#include "scene/scene.h"
#include "test.h"

static pd_ctx ctx;
static pd_setup setup;
static pd_model model;

static int open_threads(const char *text, const char *const *overrides, int count, int threads)
{
    pd_ctx_init(&ctx);
    ctx.threads = threads;
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", text, overrides, count, &setup))) return 0;
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &setup, &model))) return 1;
    pd_setup_free(&ctx, &setup);
    return 0;
}

static inline int open_model(const char *text, const char *const *overrides, int count)
{
    return open_threads(text, overrides, count, 0);
}

static void close_model(void)
{
    pd_model_free(&ctx, &model);
    pd_setup_free(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
}

/* Up to t [s]: amounts balance, and so do the currents, in a cell or among ions, which stay neutral. */
static inline int run_to(double t)
{
    double off;
    int done = CHECK_OK(&ctx, pd_time_loop_run(&ctx, &model.time_loop, t, 0.0, NULL, NULL));
    CHECK_LE(pd_time_loop_imbalance(&model.time_loop), 1e-12);
    CHECK_LE(model.cell.result.imbalance, 1e-12);
    if (model.dissolution_laws.species_electrodes.setup) {
        CHECK_LE(pd_reactive_neutrality(&model.reactive), 1e-12);
        pd_species_electrodes_compute_total_current(&model.dissolution_laws.species_electrodes, &off);
        CHECK_LE(off, 1e-12);
    }
    return done;
}

#endif
