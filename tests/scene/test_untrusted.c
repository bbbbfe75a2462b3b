/* Files that nobody vouches for: every example, cut off and with bytes changed, is read or refused with a message, and
 * leaves nothing behind. What a file may ask for is bounded, and where it may write.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include "physics/memory_estimate.h"
#include "physics/model.h"

#if PD_DIM == 1
#define ACROSS(range)
#define VALUES(x) x
static const char *const scenes[] = {"pencil_304_bonds_1d.scene", "validation/layers_1d.scene",
                                     "validation/pencil_304_1d.scene"};
#elif PD_DIM == 2
#define ACROSS(range) ", " range
#define VALUES(x) x ", " x
static const char *const scenes[] = {"mg_pin_2d.scene", "mg_pin_axi.scene", "pit_304_2d.scene", "s0_params.cfg",
                                     "validation/taylor_green_2d.scene", "validation/smith_hutton_2d.scene"};
#else
#define ACROSS(range) ", " range ", " range
#define VALUES(x) x ", " x ", " x
static const char *const scenes[] = {"mg_pin_3d.scene", "pits_304_3d.scene", "s0_params.cfg"};
#endif

enum { FILE_MOST = 8000, BUILD_EACH = 40 };

/* Reads bytes[size]; a small scene now and then is built, too. Returns 1 when it was accepted. */
static int attempt(const char *bytes, size_t size, int build)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model *model = NULL;
    pd_memory_estimate b;
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    ctx.alloc.limit = 20000000;
    put("b.scene", bytes, size);
    pd_status status = pd_scene_read(&ctx, path_of("b.scene"), NULL, 0, &u);
    int accepted = status == PD_OK;
    if (accepted) {
        pd_memory_estimate_compute(&u, &b);
        CHECK(b.total_bytes > 0.0 && pdi_file_is_subpath(u.folder));
        if (build && b.total_bytes - b.output_bytes < 1e6) {
            model = (pd_model *)calloc(1, sizeof *model);
            if (CHECK(model != NULL)) status = pd_model_build(&ctx, &u, model);
            if (model) pd_model_free(&ctx, model);
            free(model);
        }
        pd_setup_free(&ctx, &u);
    }
    if (status < 0) CHECK(ctx.status == status && ctx.message[0] != '\0' && status != PD_ERR_INTERNAL);
    CHECK_INT(ctx.in_use, 0);
    return accepted;
}

static size_t example(const char *name, char *bytes)
{
    char path[300];
    snprintf(path, sizeof path, "examples/scenes/%s", name);
    FILE *file = fopen(path, "rb");
    if (!CHECK(file != NULL)) return 0;
    size_t size = fread(bytes, 1, FILE_MOST, file);
    fclose(file);
    CHECK(size > 100 && size < FILE_MOST);
    return size;
}

/* Every byte once, changed to another printable or odd one. */
TEST(changed_bytes)
{
    static const char others[] = "0-9e[]=#.,/(*^\n\t\xff\x01 zh";
    static char bytes[FILE_MOST];
    int accepted = 0, tried = 0;
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        size_t size = example(scenes[k], bytes);
        for (size_t at = 0; at < size; at++) {
            char old = bytes[at];
            bytes[at] = others[(at * 7 + k) % (sizeof others - 1)];
            tried++;
            accepted += attempt(bytes, size, tried % BUILD_EACH == 0);
            bytes[at] = old;
        }
    }
    NOTE("%d of %d changed files are scenes", accepted, tried);
    CHECK(accepted > 0 && accepted < tried);
}

TEST(cut_off)
{
    static char bytes[FILE_MOST];
    int accepted = 0, tried = 0;
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        size_t size = example(scenes[k], bytes);
        for (size_t length = 0; length < size; length++, tried++) accepted += attempt(bytes, length, 0);
    }
    CHECK(accepted > 0 && accepted < tried);
}

/* A run of bytes that stands twice, or is gone. */
TEST(repeated_and_missing)
{
    static char bytes[FILE_MOST], other[2 * FILE_MOST];
    for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
        size_t size = example(scenes[k], bytes);
        for (size_t at = 0; at + 30 < size; at += 3) {
            memcpy(other, bytes, at + 30);
            memcpy(other + at + 30, bytes + at, size - at);
            attempt(other, size + 30, 0);
            memcpy(other, bytes, at);
            memcpy(other + at, bytes + at + 10, size - at - 10);
            attempt(other, size - 10, 0);
        }
    }
}

/* ---- limits ---- */

#define SMALL "[grid] h = 1 um  box = 0 .. 20 um" ACROSS("0 .. 20 um") "\n[transport] D = 1e-9 m2/s\n"

TEST(nested_expressions)
{
    char text[4000], inner[2000] = "";
    for (int k = 0; k < 200; k++) strcat(inner, "(");
    strcat(inner, "1 s");
    for (int k = 0; k < 200; k++) strcat(inner, ")");
    snprintf(text, sizeof text, SMALL "[run] until = %s\n", inner);
    refused(text, "the expression is nested deeper than 64 levels");
    inner[0] = '\0';
    for (int k = 0; k < 400; k++) strcat(inner, "2^");
    snprintf(text, sizeof text, SMALL "[run] until = %s1 * 1 s\n", inner);
    refused(text, "more than 64 operands wait for their operator");
}

TEST(too_many)
{
    static char text[400000];
    size_t used = (size_t)snprintf(text, sizeof text, SMALL "[run] until = 1 s\n");
    for (int k = 0; k < 5000; k++) used += (size_t)snprintf(text + used, sizeof text - used, "[shape s%d]\n", k);
    refused(text, "more than 4096 sections");
    used = (size_t)snprintf(text, sizeof text, SMALL);
    for (int k = 0; k < 70; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, "[shape s%d] box = 0 .. 1 um" ACROSS("0 .. 1 um")
                                 "  kind = solid\n", k);
    refused(text, "more than");
}

TEST(sizes_and_times)
{
    refused("[grid] h = 1e-30 m  box = 0 .. 20 um" ACROSS("0 .. 20 um") "\n[transport] D = 1e-9 m2/s\n"
            "[run] until = 1 s\n", "cells of 1e-21 nm on axis x, expected fewer than 1e+09");
    refused("[grid] h = 1 um  box = 0 .. 1e300 m" ACROSS("0 .. 20 um") "\n[transport] D = 1e-9 m2/s\n"
            "[run] until = 1 s\n", "on axis x, expected fewer than 1e+09");
    refused(SMALL "[run] until = 1 s  max_step = 1e-15 s\n", "found 1e+15 steps until the end, expected at most 1e+09");
    refused(SMALL "[run] until = 1 s\n[output] every = 1 ns\n", "found 1e+09 frames until the end");
    refused(SMALL "[run] until = 1e200 s * 1e200\n", "the value is infinite");
#if PD_DIM == 2
    refused("dx = 1e-30\n", "a.scene:1: dx: found");
#endif
}

/* A file that is longer than its mask is not read to its end. */
TEST(long_masks)
{
    pd_ctx ctx;
    pd_setup u;
    static const char zeros[100000];
    put("long.raw", zeros, sizeof zeros);
    CHECK(load(&ctx, SMALL "[run] until = 1 s\n[shape a] raw = long.raw  size = " VALUES("2") "  corner = " VALUES("0")
               "  cell = 1 um  kind = wall\n", NULL, 0, &u) < 0);
    CHECK(strstr(ctx.message, "a.scene:4: raw: file: ") && strstr(ctx.message, "is larger than"));
    CHECK_INT(ctx.in_use, 0);
}

/* ---- places ---- */

TEST(folders)
{
    static const char *const outside[] = {"/x/y", "..", "../x", "a/../../x", "a/..", "C:/x", "\\x", "a\\..\\..\\x"};
    static const char *const inside[] = {"out", "out/a..b", "a/b/c", "./out", "...", ".hidden/x"};
    char text[600];
    for (size_t k = 0; k < sizeof outside / sizeof outside[0]; k++) {
        CHECK(!pdi_file_is_subpath(outside[k]));
        snprintf(text, sizeof text, SMALL "[run] until = 1 s\n[output] folder = %s\n", outside[k]);
        refused(text, "a.scene:4: folder: found '");
        refused(text, "expected a folder below the current one, without '..'");
#if PD_DIM == 2
        snprintf(text, sizeof text, "dx = 5e-6\noutput_dir = %s\n", outside[k]);
        refused(text, "a.scene:2: output_dir: found '");
#endif
    }
    for (size_t k = 0; k < sizeof inside / sizeof inside[0]; k++) {
        pd_ctx ctx;
        pd_setup u;
        snprintf(text, sizeof text, SMALL "[run] until = 1 s\n[output] folder = %s\n", inside[k]);
        if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) continue;
        CHECK_STR(u.folder, inside[k]);
        leave(&ctx, &u);
    }
    refused(SMALL "[run] until = 1 s\n[output] prefix = ../x\n", "prefix: found '../x'");
}

TEST_MAIN(ENTRY(changed_bytes) ENTRY(cut_off) ENTRY(repeated_and_missing) ENTRY(nested_expressions) ENTRY(too_many)
          ENTRY(sizes_and_times) ENTRY(long_masks) ENTRY(folders))
