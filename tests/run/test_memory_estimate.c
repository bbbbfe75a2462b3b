/* memory_estimate: the estimate of a run's memory against measured peaks, and what it refuses.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include "physics/memory_estimate.h"
#include "physics/model.h"

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
        pd_memory_estimate b;
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
        pd_memory_estimate_compute(&u, &b);
        CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
        double ratio = b.total_bytes / (double)ctx.peak;
        if (!CHECK(ratio <= 1.0 + PD_MEMORY_ESTIMATE_ERROR && ratio >= 1.0 / (1.0 + PD_MEMORY_ESTIMATE_ERROR)))
            NOTE("%s: estimate %.0f, peak %.0f bytes", examples[k].scene, b.total_bytes, (double)ctx.peak);
        leave(&ctx, &u);
    }
}

/* Bytes that parts of a model take more on the next finer lattice: what does not grow with it cancels. */
typedef struct part_of {
    const char *scene;
    unsigned parts; /* bit p: that part */
    double off;     /* [-] share by which the estimate may be off: faces that are no planes are sampled */
} part_of;

#define BIT(part) (1u << PD_PART_##part)

static const part_of part_table[] = {
#if PD_DIM == 1
    {"examples/scenes/mg_migration_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"examples/scenes/mg_film_bajger_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"examples/scenes/sbf_apatite_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(CHEMISTRY), 1e-9},
    {"examples/scenes/pencil_304_bonds_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE), 1e-9},
    {"examples/scenes/shock_tube_1d.scene", BIT(GRID) | BIT(GAS), 1e-9},
    {"examples/scenes/validation/pulse_1d.scene", BIT(GRID) | BIT(FLOW) | BIT(TRANSPORT), 1e-9},
    {"examples/scenes/validation/layers_1d.scene", BIT(GRID) | BIT(TRANSPORT), 1e-9},
    {"examples/scenes/validation/rate_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE), 1e-9},
    {"tests/scenes/cathode_left_ions_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/limiting_current_1d.scene", BIT(GRID) | BIT(CHEMISTRY) | BIT(POTENTIAL), 1e-9},
    {"tests/scenes/limiting_current_given_1d.scene", BIT(GRID) | BIT(CHEMISTRY) | BIT(POTENTIAL), 1e-9},
    {"tests/scenes/limiting_current_acid_1d.scene", BIT(GRID) | BIT(CHEMISTRY) | BIT(POTENTIAL), 1e-9},
    {"tests/scenes/voltammogram_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(CHEMISTRY) | BIT(POTENTIAL), 1e-9},
    {"tests/scenes/metal_ion_first_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/oxygen_used_up_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/sums_of_totals_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/surface_states_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/state_fields_1d.scene", BIT(GRID) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/two_minerals_1d.scene", BIT(GRID) | BIT(CHEMISTRY), 1e-9},
    {"tests/scenes/pulse_law_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE), 1e-9},
    {"tests/scenes/all_metal_1d.scene", BIT(GRID) | BIT(TRANSPORT) | BIT(DISSOLVE), 1e-9},
    {"tests/scenes/solid_mirror_1d.scene", BIT(GRID), 1e-9}
#elif PD_DIM == 2
    {"tests/scenes/gas_box_2d.scene", BIT(GAS), 1e-9},
    {"examples/scenes/validation/startup_2d.scene", BIT(FLOW), 1e-9},
    {"examples/scenes/validation/couette_2d.scene", BIT(FLOW), 1e-9},
    {"examples/scenes/validation/cavity_2d.scene", BIT(FLOW), 1e-9},
    {"examples/scenes/intergranular_2d.scene", BIT(TRANSPORT), 1e-9},
    {"examples/scenes/intergranular_2d.scene", BIT(GRAIN), 1e-3},
    {"examples/scenes/mg_disc_brucite_2d.scene", BIT(TRANSPORT) | BIT(CHEMISTRY), 2e-3},
    {"examples/scenes/mg_disc_brucite_2d.scene", BIT(GRID), 0.06},
    /* nodes beside the metal: room for 1.25 times those of a square of its area, whose rim is 2/sqrt(pi) of a disc's */
    {"examples/scenes/mg_disc_brucite_2d.scene", BIT(DISSOLVE), 0.25},
    {"examples/scenes/mg_disc_ph_2d.scene", BIT(FLOW) | BIT(CHEMISTRY), 5e-3},
    {"examples/scenes/pit_304_potential_2d.scene", BIT(TRANSPORT) | BIT(CHEMISTRY), 0.01},
    {"examples/scenes/plate_hole_2d.scene", BIT(GRID) | BIT(SOLID), 0.02},
    {"examples/scenes/validation/slab_2d.scene", BIT(TRANSPORT), 0.01},
    {"examples/scenes/validation/layers_2d.scene", BIT(TRANSPORT), 0.02},
    {"examples/scenes/templates/plate_2d.scene", BIT(GRID) | BIT(SOLID), 0.04},
    {"tests/scenes/solid_side_2d.scene", BIT(SOLID), 0.02},
    {"tests/scenes/law_of_a_state_2d.scene", BIT(TRANSPORT), 0.02},
    {"tests/scenes/law_of_a_state_2d.scene", BIT(CHEMISTRY), 1e-3},
    {"tests/scenes/no_current_no_uptake_2d.scene", BIT(TRANSPORT) | BIT(CHEMISTRY), 0.01},
    {"tests/scenes/electrode_corner_2d.scene", BIT(POTENTIAL), 0.02},
    {"tests/scenes/inlet_scaled_2d.scene", BIT(FLOW), 2e-3},
    {"tests/scenes/bonds_in_flow_in_time_2d.scene", BIT(FLOW), 0.01}
#else
    {"examples/scenes/templates/plate_3d.scene", BIT(SOLID), 1e-3},
    {"examples/scenes/templates/galvanic_3d.scene", BIT(TRANSPORT), 0.02},
    {"examples/scenes/validation/pencil_304_3d.scene", BIT(TRANSPORT), 5e-3},
    {"tests/scenes/stresses_3d.scene", BIT(SOLID), 0.02},
    {"tests/scenes/duct_developed_3d.scene", BIT(FLOW), 0.01},
    {"tests/scenes/duct_developed_3d.scene", BIT(GRID), 0.05}
#endif
};

TEST(parts_grow_as_estimated)
{
    for (size_t k = 0; k < sizeof part_table / sizeof part_table[0]; k++) {
        double estimate[2][PD_PART_COUNT], found[2][PD_PART_COUNT], h = 0.0;
        for (int fine = 0; fine < 2; fine++) {
            static pd_model model;
            pd_ctx ctx;
            pd_setup u;
            pd_memory_estimate b;
            char spacing[60];
            const char *finer = spacing;
            snprintf(spacing, sizeof spacing, "grid.h=%.17g m", 0.5 * h);
            pd_ctx_init(&ctx);
            ctx.threads = 1;
            if (!CHECK_OK(&ctx, pd_scene_read(&ctx, part_table[k].scene, &finer, fine, &u))) return;
            h = u.h[0];
            pd_memory_estimate_compute(&u, &b);
            memset(&model, 0, sizeof model);
            if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &model)))
                for (int p = 0; p < PD_PART_COUNT; p++) {
                    estimate[fine][p] = b.bytes[p];
                    found[fine][p] = (double)model.bytes[p];
                }
            pd_model_free(&ctx, &model);
            leave(&ctx, &u);
        }
        for (int p = 0; p < PD_PART_COUNT; p++) {
            if (!(part_table[k].parts >> p & 1u)) continue;
            if (!CHECK_REL(estimate[1][p] - estimate[0][p], found[1][p] - found[0][p], part_table[k].off))
                NOTE("%s: part %d", part_table[k].scene, p);
        }
    }
}

/* Levels of multigrids appear in a run: what its peak takes more on the next finer lattice. */
#if PD_DIM == 2
TEST(peaks_grow_as_estimated)
{
    static const char *const scene[] = {"examples/scenes/validation/cavity_2d.scene",
                                        "examples/scenes/validation/poiseuille_2d.scene"};
    static const char *const spacing[2][2] = {{"grid.h=1 m / 32", "grid.h=1 m / 64"},
                                              {"grid.h=1 m / 40", "grid.h=1 m / 80"}};
    for (size_t k = 0; k < sizeof scene / sizeof scene[0]; k++) {
        double estimate[2] = {0.0, 0.0}, found[2] = {0.0, 0.0};
        for (int fine = 0; fine < 2; fine++) {
            pd_ctx ctx;
            pd_setup u;
            pd_run_desc desc;
            pd_run_result result;
            pd_memory_estimate b;
            const char *finer = spacing[k][fine];
            memset(&desc, 0, sizeof desc);
            desc.no_files = 1;
            pd_ctx_init(&ctx);
            ctx.threads = 1;
            if (!CHECK_OK(&ctx, pd_scene_read(&ctx, scene[k], &finer, 1, &u))) return;
            pd_memory_estimate_compute(&u, &b);
            estimate[fine] = b.total_bytes - b.output_bytes;
            CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
            found[fine] = (double)ctx.peak;
            leave(&ctx, &u);
        }
        CHECK_REL(estimate[1] - estimate[0], found[1] - found[0], 0.12);
    }
}
#define PEAKS ENTRY(peaks_grow_as_estimated)
#else
#define PEAKS
#endif

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
        pd_memory_estimate b;
        char text[400];
        const char *at = box[k], *comma = ", ";
        snprintf(text, sizeof text, "[grid] h = 50 um  m = 3  box = %s%s%s%s%s\n[transport] D = 1e-9 m2/s\n"
                 "[run] until = 1 s\n", at, PD_DIM > 1 ? comma : "", PD_DIM > 1 ? at : "", PD_DIM > 2 ? comma : "",
                 PD_DIM > 2 ? at : "");
        if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
        pd_memory_estimate_compute(&u, &b);
        if (!k) first = b.total_bytes;
        CHECK_REL(b.total_bytes, first, 1e-12);
        CHECK_NEAR(b.truncated, pow(20.0, PD_DIM) - pow(14.0, PD_DIM), 1e-9);
        leave(&ctx, &u);
    }
    /* metal up to 4 cells from one side, a wall at the other one, mirrors across */
    pd_ctx ctx;
    pd_setup u;
    pd_memory_estimate b;
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
    pd_memory_estimate_compute(&u, &b);
    CHECK_NEAR(b.truncated, 6.0 * pow(20.0, PD_DIM - 1), 1e-9);
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

TEST_MAIN(ENTRY(estimate_against_peak) ENTRY(parts_grow_as_estimated) PEAKS ENTRY(any_place_of_the_box)
          ENTRY(refused_before_work) ENTRY(more_nodes_than_int32))
