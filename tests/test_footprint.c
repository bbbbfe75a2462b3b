/* footprint: the estimate of a run's memory against measured peaks, and what it refuses.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include "run/footprint.h"

/* Scenes of the examples, of every sort of physics; tests run in the root of the repository. */
typedef struct example {
    const char *scene;
    const char *shorter; /* than the example */
} example;

static const example examples[] = {
#if PD_DIM == 1
    {"pencil_304_bonds_1d.scene", "until=1 s"},
    {"validation/advection_1d.scene", "until=0.01 s"},
    {"validation/gauss_1d.scene", NULL},
    {"validation/layers_1d.scene", NULL},
    {"validation/rate_1d.scene", NULL},
    {"shock_tube_1d.scene", NULL}
#elif PD_DIM == 2
    {"mg_pin_2d.scene", "h=10 um"},
    {"mg_pin_axi.scene", "h=10 um"},
    {"intergranular_2d.scene", "h=2 um"},
    {"plate_hole_2d.scene", NULL},
    {"pit_304_2d.scene", "h=2 um"},
    {"glass_branching_2d.scene", "h=0.5 mm"},
    {"validation/annulus_2d.scene", NULL},
    {"validation/layers_2d.scene", NULL},
    {"validation/startup_2d.scene", NULL},
    {"mg_al_couple_film_2d.scene", "h=0.4 mm"},
    {"validation/flux_2d.scene", NULL}
#else
    {"pits_304_3d.scene", "h=4 um"},
    {"uniform_cu_3d.scene", "h=2 um"},
    {"validation/pencil_304_3d.scene", NULL}
#endif
};

static int stop_soon(void *user)
{
    int *steps = (int *)user;
    return ++*steps >= 3;
}

/* Within its stated error, both ways. */
TEST(estimate_against_peak)
{
    for (size_t k = 0; k < sizeof examples / sizeof examples[0]; k++) {
        pd_ctx ctx;
        pd_setup u;
        pd_run_desc desc;
        pd_run_result result;
        pd_footprint b;
        char path[300];
        int steps = 0;
        memset(&desc, 0, sizeof desc);
        need_folder();
        char of[300];
        snprintf(of, sizeof of, "%s/%d", folder, (int)k); /* one folder, one run */
        desc.folder = of;
        desc.stop = stop_soon;
        desc.stop_user = &steps;
        snprintf(path, sizeof path, "examples/scenes/%s", examples[k].scene);
        pd_ctx_init(&ctx);
        ctx.threads = 1;
        if (!CHECK_OK(&ctx, pd_scene_read(&ctx, path, &examples[k].shorter, examples[k].shorter != NULL, &u))) continue;
        pd_footprint_estimate(&u, &b);
        CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
        double ratio = b.all / (double)ctx.peak;
        if (!CHECK(ratio <= 1.0 + PD_FOOTPRINT_ERROR && ratio >= 1.0 / (1.0 + PD_FOOTPRINT_ERROR)))
            NOTE("%s: estimate %.0f, peak %.0f bytes", examples[k].scene, b.all, (double)ctx.peak);
        leave(&ctx, &u);
    }
}

#define FLUID "[grid] h = %s  box = 0 .. 1 mm" ACROSS "\n[transport] D = 1e-9 m2/s\n[run] until = 1 s\n"

#if PD_DIM == 1
#define ACROSS
#elif PD_DIM == 2
#define ACROSS ", 0 .. 1 mm"
#else
#define ACROSS ", 0 .. 1 mm, 0 .. 1 mm"
#endif

/* Wherever the box begins: within 3 of 20 cells of the walls the families of m = 3 are cut, and nowhere else. */
TEST(any_place_of_the_box)
{
    static const char *const box[] = {"0 .. 1 mm", "-1 mm .. 0", "-0.5 mm .. 0.5 mm", "-3 mm .. -2 mm",
                                      "2 mm .. 3 mm"};
    double first = 0.0;
    for (size_t k = 0; k < sizeof box / sizeof box[0]; k++) {
        pd_ctx ctx;
        pd_setup u;
        pd_footprint b;
        char text[400];
        const char *at = box[k], *comma = ", ";
        snprintf(text, sizeof text, "[grid] h = 50 um  m = 3  box = %s%s%s%s%s\n[transport] D = 1e-9 m2/s\n"
                 "[run] until = 1 s\n", at, PD_DIM > 1 ? comma : "", PD_DIM > 1 ? at : "", PD_DIM > 2 ? comma : "",
                 PD_DIM > 2 ? at : "");
        if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
        pd_footprint_estimate(&u, &b);
        if (!k) first = b.all;
        CHECK_REL(b.all, first, 1e-12);
        CHECK_NEAR(b.cut, pow(20.0, PD_DIM) - pow(14.0, PD_DIM), 1e-9);
        leave(&ctx, &u);
    }
    /* metal up to 4 cells from one side, a wall at the other one, mirrors across */
    pd_ctx ctx;
    pd_setup u;
    pd_footprint b;
    static const char *const text =
        "[grid] h = 50 um  m = 3  box = -1 mm .. 0" ACROSS "\n[side x-] flow = mirror\n"
        "[shape metal] kind = solid  box = -1 mm .. -0.8 mm" ACROSS "\n"
#if PD_DIM > 1
        "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#endif
#if PD_DIM > 2
        "[side z-] flow = mirror\n[side z+] flow = mirror\n"
#endif
        "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n[run] until = 1 s\n";
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    pd_footprint_estimate(&u, &b);
    CHECK_NEAR(b.cut, 6.0 * pow(20.0, PD_DIM - 1), 1e-9);
    CHECK_NEAR(b.solid, 4.0 * pow(20.0, PD_DIM - 1), 1e-9);
    leave(&ctx, &u);
}

/* A scene that is too large is refused before any of it is built, and no folder appears. */
TEST(refused_before_work)
{
    static const char *const spacings[] = {"1 nm", "0.1 um", "2.5 um"};
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result result;
    char text[400];
    snprintf(text, sizeof text, FLUID, spacings[PD_DIM - 1]);
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    memset(&desc, 0, sizeof desc);
    desc.folder = path_of("none");
    size_t before = ctx.in_use;
    ctx.alloc.limit = 20000000;
    CHECK_INT(pd_run(&ctx, &u, &desc, &result), PD_ERR_LIMIT);
    CHECK(!result.bad_input);
    CHECK(strstr(ctx.message, "the run needs about") && strstr(ctx.message, "the limit is 20 MB"));
    CHECK_LE(ctx.peak - before, 300000);
    CHECK_INT(ctx.in_use, before);
    CHECK(access(path_of("none"), F_OK) != 0);
    leave(&ctx, &u);
}

/* More nodes than an int32 counts. */
#if PD_DIM == 1
TEST(more_nodes_than_int32)
{
    char text[400];
    snprintf(text, sizeof text, FLUID, "1e-13 m");
    refused(text, "a.scene:1: box: found 1e+10 cells of 0.0001 nm on axis x, expected fewer than 1e+09");
}
#else
TEST(more_nodes_than_int32)
{
    char text[400];
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result result;
    snprintf(text, sizeof text, FLUID, PD_DIM == 2 ? "10 nm" : "0.5 um");
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    memset(&desc, 0, sizeof desc);
    CHECK_INT(pd_run(&ctx, &u, &desc, &result), PD_ERR_SIZE);
    CHECK(result.bad_input && strstr(ctx.message, "a.scene:1: grid: the lattice has"));
    leave(&ctx, &u);
}
#endif

TEST_MAIN(ENTRY(estimate_against_peak) ENTRY(any_place_of_the_box)
          ENTRY(refused_before_work) ENTRY(more_nodes_than_int32))
