/* memory: whatever allocation fails, the caller hears of it, nothing leaks and no file is left half-written.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "fault.h"
#include "scene_file.h"
#include "run/richardson.h"
#include "flow/gas.h"
#include "io/field_plot.h"
#include "io/plot.h"
#include "io/png.h"
#include "io/vti.h"
#include <dirent.h>

/* Calls that fail one by one, and the stride behind them. */
enum { DENSE = 300, STRIDE = 11 };

/* The end of a box across x. */
#if PD_DIM == 1
#define ACROSS(a, b)
#define VALUES(x, rest) x
#elif PD_DIM == 2
#define ACROSS(a, b) ", " a " um .. " b " um"
#define VALUES(x, rest) x ", " rest
#else
#define ACROSS(a, b) ", " a " um .. " b " um, " a " um .. " b " um"
#define VALUES(x, rest) x ", " rest ", " rest
#endif

#define GRID "[grid] h = 1 um  m = 2  box = 0 .. 16 um" ACROSS("0", "8") "\n"
#define BLOCK "[shape metal] box = 6 um .. 11 um" ACROSS("3", "5") "\n  kind = solid  material = mg4ag\n"
#define GRAINS "  grain_size = 3 um  grain_size_deviation = 0.3 um  grain_boundary_width = 0.5 um\n"
#define STREAM "[side x-] flow = inlet  profile = uniform  mean = 0.01 m/s  C = 1 mol/m3\n[side x+] flow = outlet\n"
#define OPEN "[side x-] flow = open\n[side x+] flow = open\n"
#define WATER "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s"
#define WATCH "[probe p] at = " VALUES("3.5 um", "1.5 um") "  fields = C\n" \
              "[line l] from = " VALUES("1 um", "1 um") "  to = " VALUES("3 um", "2 um") "  points = 3  fields = C" \
              "  images = none\n" \
              "[total t] box = 0 .. 8 um" ACROSS("0", "8") "\n"

#define FORCE \
    "[force f] box = 4 um .. 13 um" ACROSS( \
        "2", "6") "  balance = no\n" \
                  "[transfer f] box = 4 um .. 13 um" ACROSS( \
                      "2", "6") "\n" \
                                "  along = x  reference_length = 1 um  surface = Csat  fluid = bulk\n"

/* ---- what a folder may hold after a failure ---- */

static void tables_whole(const char *path)
{
    pd_ctx ctx;
    pd_table table;
    double values[4096];
    pd_ctx_init(&ctx);
    memset(&table, 0, sizeof table);
    if (CHECK_OK(&ctx, pd_table_read(&ctx, path, &table)) && CHECK(table.rows <= 4096))
        for (int k = 0; k < table.columns; k++)
            CHECK_OK(&ctx, pd_table_parse_column(&ctx, &table, pd_table_get_text(&table, -1, k), values));
    pd_table_free(&ctx, &table);
}

/* Its last bytes, behind whatever makes them the end. */
static void ends_with(const char *path, const void *end, size_t size)
{
    char found[16] = "";
    FILE *file = fopen(path, "rb");
    if (!CHECK(file != NULL)) return;
    if (!CHECK(fseek(file, -(long)size, SEEK_END) == 0 && fread(found, 1, size, file) == size &&
               memcmp(found, end, size) == 0))
        NOTE("%s is cut off", path);
    fclose(file);
}

static int ends(const char *name, const char *end)
{
    size_t n = strlen(name), m = strlen(end);
    return n >= m && strcmp(name + n - m, end) == 0;
}

/* Every file of the folder is whole, and goes. Returns how many there were. */
static int empty_folder(const char *path)
{
    char name[600];
    int files = 0;
    DIR *folder_of_run = opendir(path);
    for (struct dirent *e = folder_of_run ? readdir(folder_of_run) : NULL; e; e = readdir(folder_of_run)) {
        if (e->d_name[0] == '.') continue;
        snprintf(name, sizeof name, "%s/%s", path, e->d_name);
        if (!CHECK(!ends(name, ".part"))) NOTE("%s", name);
        if (ends(name, ".csv")) tables_whole(name);
        if (ends(name, ".png")) ends_with(name, "\0\0\0\0IEND\xae\x42\x60\x82", 12);
        if (ends(name, ".vti") || ends(name, ".pvd")) ends_with(name, "</VTKFile>\n", 11);
        CHECK(remove(name) == 0);
        files++;
    }
    if (folder_of_run) closedir(folder_of_run);
    return files;
}

/* ---- scenes ---- */

typedef struct scene_work {
    const char *text;
    int dry, estimate;
    int files; /* of the last run */
} scene_work;

static void hear(void *user, pd_print_kind kind, const char *text)
{
    (void)user;
    (void)kind;
    CHECK(text[0] != '\0' || kind == PD_PRINT_PROGRESS);
}

static pd_status run_scene(pd_ctx *ctx, void *user)
{
    scene_work *w = (scene_work *)user;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    pd_scalar_outputs figures;
    pd_richardson e;
    memset(&desc, 0, sizeof desc);
    memset(&figures, 0, sizeof figures);
    desc.folder = path_of("out");
    desc.print = hear;
    desc.no_files = w->dry;
    if (w->estimate) desc.figures = &figures;
    pd_status status = pd_scene_read(ctx, path_of("a.scene"), NULL, 0, &setup);
    if (status == PD_OK) status = pd_run(ctx, &setup, &desc, &result);
    if (status == PD_OK && w->estimate) {
        status = pd_richardson_run(ctx, &setup, &desc, &figures, &e);
        pd_richardson_free(ctx, &e);
        pd_richardson_free(ctx, &e);
    }
    w->files = w->dry ? 0 : empty_folder(path_of("out"));
    pd_scalar_outputs_free(ctx, &figures);
    pd_setup_free(ctx, &setup);
    pd_setup_free(ctx, &setup);
    return status;
}

/* All calls of reading and running a scene. */
static void sweep(const char *what, const char *text, int dry, int estimate)
{
    scene_work w;
    memset(&w, 0, sizeof w);
    w.text = text;
    w.dry = dry;
    w.estimate = estimate;
    put("a.scene", text, strlen(text));
    long calls = fault_sweep(what, run_scene, &w, DENSE, STRIDE);
    CHECK(calls > 50);
    if (calls > DENSE) NOTE("%s: %ld calls: all to %d, then every %dth", what, calls, DENSE, STRIDE);
}

#if PD_DIM > 1
/* A loose flow and a field that spreads fast: a basis that may grow and is refused memory goes on with what it has
 * (test_krylov). */
TEST(dissolving_pin)
{
    sweep("pin",
          GRID BLOCK GRAINS STREAM WATER
          "  steady = 0.05\n[transport] D = 1e-7 m2/s\n"
          "[dissolve] rate = 1 um/s * (1 - C/Csat)  Csat = 50 mol/m3  grain_boundary_factor = 3\n"
          "[run] until = 0.1 s\n[output] every = 0.1 s  images = C, v, grain\n"
          "  fields = C, v, p, kind, grain, phase, D, rate, density\n" WATCH "[plane in] at = x 2 um\n" FORCE,
          0, 0);
}
#endif

TEST(dissolving_block)
{
    sweep("block",
          GRID BLOCK GRAINS "[transport] D = 1e-9 m2/s  initial = if(x < 3 um, 1 mol/m3, 0)\n"
                            "[dissolve] rate = 1 um/s  threshold = 0.1\n[run] until = 0.2 s\n"
                            "[output] every = 0.2 s  fields = C, rate\n" WATCH
                            "[transfer m] surface = 1 mol/m3  fluid = 0 mol/m3  reference_length = 1 um\n",
          0, 0);
}

/* Walls that hold a concentration, and a medium. */
TEST(steady_transport)
{
    sweep("layers", GRID "[shape gel] box = 8 um .. 20 um" ACROSS("-9", "20") "  kind = medium  D = 1e-10 m2/s\n"
          "[shape post] box = 4 um .. 7 um" ACROSS("2", "6") "  kind = wall  C = 2 mol/m3\n"
          "[side x-] C = 0\n[side x+] C = 1 mol/m3\n[transport] D = 1e-9 m2/s  time = steady\n"
          "[output] fields = C, D\n" WATCH, 0, 0);
}

TEST(flow_in_time)
{
    static const char *const forms[] = {"implicit  rtol = 1e-2  force = " VALUES("10 m/s2", "0"),
                                        "explicit  c0 = 0.2 m/s", "given  vx = 0.01 m/s"};
    static const char *const sides[] = {"[side x-] flow = periodic\n[side x+] flow = periodic\n", STREAM, OPEN};
    for (int k = 0; k < 3; k++) {
        char text[2000];
        snprintf(text, sizeof text, GRID "%s" WATER "  speed = 0.01 m/s  length = 1 um  time = %s\n"
                 "[transport] D = 1e-9 m2/s  initial = 1 mol/m3\n[run] until = %s\n"
                 "[output] every = 1 s  fields = C, v, p, density\n" WATCH, sides[k], forms[k],
                 k == 1 ? "2e-7 s" : "2e-6 s");
        sweep(forms[k], text, 0, 0);
    }
}

/* ---- bond-based corrosion ---- */

#define METAL "[shape metal] box = 4 um .. 16 um" ACROSS("0", "8") "  kind = solid  material = steel304\n"
#define OPEN_END "[side x-] flow = open\n[side x+] flow = mirror\n"

TEST(corrosion)
{
    sweep("implicit",
          GRID METAL GRAINS OPEN_END "[shape film] half_space = yes  point = " VALUES("3 um", "0") "  normal = " VALUES(
              "1", "0") "  kind = passive\n"
                        "[corrode] rate = 0.5 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  grain_boundary_factor = 2\n"
                        "[run] until = 2 s\n[output] every = 2 s  fields = C, density, phase\n" WATCH,
          0, 0);
    sweep("stochastic", GRID METAL OPEN_END "[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n"
          "breaking = stochastic  repassivation = 0.1 mol/L\n"
          "[run] until = 0.02 s\n[output] every = 0.02 s\n" WATCH, 0, 0);
    sweep("activation", GRID METAL OPEN_END "[corrode] rate = 1 um/s  Csat = 5 mol/L  control = activation\n"
          "[run] until = 2 s\n[output] every = 2 s\n" WATCH, 0, 0);
}

/* ---- other geometries, files that a scene names, pictures ---- */

#if PD_DIM == 2
TEST(rings)
{
    sweep("rings", "[grid] geometry = axisymmetric  h = 1 um  m = 2  box = 0 .. 16 um, 0 .. 8 um\n"
          "[shape metal] box = 6 um .. 11 um, -3 um .. 3 um  kind = solid\n[side x-] flow = inlet  profile = uniform\n"
          "  mean = 0.01 m/s\n[side x+] flow = outlet\n" WATER "  steady = 1e-2\n[transport] D = 1e-9 m2/s\n"
          "[dissolve] rate = 1 um/s\n[run] until = 0.1 s\n[output] every = 0.1 s  images = C\n", 0, 0);
}
#endif

/* A mask of 2 x 1 (x 1) voxels. */
TEST(masks)
{
    static const uint8_t voxels[2] = {0, 1};
    char text[2000];
    put("a.raw", voxels, sizeof voxels);
#if PD_DIM == 2
    pd_ctx ctx;
    pd_image image;
    uint8_t pixels[6] = {0, 0, 0, 255, 255, 255};
    pd_ctx_init(&ctx);
    memset(&image, 0, sizeof image);
    image.width = 2;
    image.height = 1;
    image.channels = 3;
    image.pixels = pixels;
    CHECK_OK(&ctx, pd_png_write(&ctx, path_of("a.png"), &image));
    const char *named = "mask = a.png";
#else
    const char *named = "raw = a.raw  size = " VALUES("2", "1");
#endif
    snprintf(text, sizeof text, GRID "[shape block] %s  corner = " VALUES("0 um", "0 um") "  cell = 4 um\n"
             "[shape other] raw = a.raw  size = " VALUES("2", "1") "  corner = " VALUES("8 um", "0 um")
             "  cell = 1 um\n[shape metal] union = block, other  kind = solid\n"
             "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s\n[run] until = 0.1 s\n"
             "[output] every = 0.1 s  images = density\n", named);
    sweep("masks", text, 0, 0);
}

#if PD_DIM > 1
TEST(flat_file)
{
    sweep("flat", "dx = 10e-6\nm_ratio = 1\nL_wire = 60e-6\nR_wire = 20e-6\nR_tube = 50e-6\nL_upstream = 50e-6\n"
          "L_downstream = 50e-6\nQ_flow = 0\nT_final = 1\ngrain_size_mean = 20e-6\ngrain_size_std = 0\n", 1, 0);
}
#endif

/* The error estimate runs coarser lattices. */
TEST(error_estimate)
{
    sweep("estimate", "[grid] h = 1 um  m = 1  box = 0 .. 16 um" ACROSS("0", "8") "\n[side x-] C = 1 mol/m3\n"
          "[transport] D = 1e-9 m2/s  time = steady\n[total t] box = 0 .. 8 um" ACROSS("0", "8") "\n", 1, 1);
}

/* ---- what no scene builds ---- */

static void at_rest(void *user, const double *x, double *rho, double *v, double *p)
{
    (void)user;
    (void)x;
    *rho = 1.0;
    *p = 1.0;
    for (int d = 0; d < PD_DIM; d++) v[d] = 0.0;
}

static pd_status run_gas(pd_ctx *ctx, void *user)
{
    pd_stencil_desc family;
    pd_grid_desc box;
    pd_gas_desc desc;
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    pd_gas gas;
    (void)user;
    memset(&family, 0, sizeof family);
    memset(&box, 0, sizeof box);
    memset(&desc, 0, sizeof desc);
    memset(&grid, 0, sizeof grid);
    memset(&bonds, 0, sizeof bonds);
    memset(&gas, 0, sizeof gas);
    family.m = 2.0;
    for (int d = 0; d < PD_DIM; d++) {
        family.h[d] = 1.0;
        box.hi[d] = 8.0;
    }
    desc.gamma = 1.4;
    desc.spatial_order = PD_GAS_SECOND;
    desc.initial = at_rest;
    pd_status status = pd_stencil_build(ctx, &family, &stencil);
    if (status == PD_OK) status = pd_grid_build(ctx, &stencil, &box, &grid);
    if (status == PD_OK) status = pd_bonds_build(ctx, &stencil, &grid, 0, &bonds);
    if (status == PD_OK) status = pd_gas_build(ctx, &grid, &bonds, &desc, &gas);
    if (status == PD_OK) status = pd_physics_run(ctx, pd_gas_process(&gas), 0.5);
    for (int twice = 0; twice < 2; twice++) {
        pd_gas_free(ctx, &gas);
        pd_bonds_free(ctx, &bonds);
        pd_grid_free(ctx, &grid);
        pd_stencil_free(ctx, &stencil);
    }
    return status;
}

TEST(gas)
{
    CHECK(fault_sweep("gas", run_gas, NULL, DENSE, STRIDE) > 20);
}

/* A plot, its picture read back, a table and a collection of files. */
static pd_status run_files(pd_ctx *ctx, void *user)
{
    static const char *const names[] = {"t", "x"};
    const double values[] = {0.0, 1.0, 1.0, 2.0};
    pd_plot plot;
    pd_image image;
    pd_table table;
    pd_pvd pvd;
    (void)user;
    memset(&plot, 0, sizeof plot);
    memset(&image, 0, sizeof image);
    memset(&table, 0, sizeof table);
    memset(&pvd, 0, sizeof pvd);
    plot.title = plot.x_label = plot.y_label = "a";
    plot.count = 1;
    plot.series[0].x = values;
    plot.series[0].y = values + 2;
    plot.series[0].count = 2;
    pd_status status = pd_plot_write(ctx, path_of("out/a.png"), &plot);
    if (status == PD_OK) status = pd_png_read(ctx, path_of("out/a.png"), &image);
    if (status == PD_OK) status = pdi_csv_write_table(ctx, path_of("out/a.csv"), names, 2, values, 2);
    if (status == PD_OK) status = pd_table_read(ctx, path_of("out/a.csv"), &table);
    if (status == PD_OK) status = pdi_pvd_init(ctx, path_of("out/a.pvd"), &pvd);
    for (int k = 0; k < 30 && status == PD_OK; k++) status = pdi_pvd_add_file(ctx, &pvd, k, path_of("out/a.vti"));
    for (int twice = 0; twice < 2; twice++) {
        pd_image_free(ctx, &image);
        pd_table_free(ctx, &table);
        pdi_pvd_free(ctx, &pvd);
    }
    empty_folder(path_of("out"));
    return status;
}

TEST(files)
{
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    need_folder();
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, path_of("out")));
    CHECK(fault_sweep("files", run_files, NULL, DENSE, STRIDE) > 10);
}

/* ---- the limit ---- */

/* To the byte: what a run takes at most is enough, one byte less is not. */
TEST(limit_to_the_byte)
{
    scene_work w;
    pd_ctx ctx;
    static const char text[] = GRID BLOCK "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s\n"
                               "[run] until = 0.1 s\n[output] every = 0.1 s\n";
    memset(&w, 0, sizeof w);
    w.dry = 1;
    put("a.scene", text, strlen(text));
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    if (!CHECK_OK(&ctx, run_scene(&ctx, &w))) return;
    size_t peak = ctx.peak;
    for (int less = 0; less < 2; less++) {
        fault f;
        fault_context(&f, 0, 0, &ctx);
        ctx.alloc.limit = peak - (size_t)less;
        pd_status status = run_scene(&ctx, &w);
        CHECK_INT(status, less ? PD_ERR_LIMIT : PD_OK);
        CHECK(f.peak <= ctx.alloc.limit && ctx.peak == f.peak);
        CHECK(f.live == 0 && ctx.in_use == 0);
        if (less) CHECK(strstr(ctx.message, "the limit is") != NULL);
    }
}

#if PD_DIM == 1
#define OF_DIM
#elif PD_DIM == 2
#define OF_DIM SLOW_ENTRY_IF(PD_DIM == 3, dissolving_pin) ENTRY(flat_file) ENTRY(rings)
#else
#define OF_DIM SLOW_ENTRY_IF(PD_DIM == 3, dissolving_pin) ENTRY(flat_file)
#endif

TEST_MAIN(OF_DIM ENTRY(dissolving_block) ENTRY(steady_transport) ENTRY(flow_in_time) ENTRY(corrosion) ENTRY(masks)
              ENTRY(error_estimate) ENTRY(gas) ENTRY(files) ENTRY(limit_to_the_byte))
