/* scene_file: scenes that a test program writes, reads and runs in a folder of its own, which goes with it. Include it
 * behind `#define _XOPEN_SOURCE 700`. */
#ifndef SCENE_FILE_H
#define SCENE_FILE_H
#include "run/run.h"
#include "test.h"
#include <stdlib.h>
#include <unistd.h>

static char folder[256]; /* of this test program */

static const char *path_of(const char *name)
{
    static char path[4][512];
    static int turn;
    turn = (turn + 1) % 4;
    snprintf(path[turn], sizeof path[0], "%s/%s", folder, name);
    return path[turn];
}

static void remove_folder(void)
{
    char command[300];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    if (system(command) != 0) printf("cannot remove %s\n", folder);
}

static void need_folder(void)
{
    if (folder[0]) return;
    snprintf(folder, sizeof folder, "%s/pdcorr_XXXXXX", P_tmpdir);
    if (CHECK(mkdtemp(folder) != NULL)) atexit(remove_folder);
}

static void put(const char *name, const void *bytes, size_t size)
{
    need_folder();
    FILE *file = fopen(path_of(name), "wb");
    CHECK(file != NULL && fwrite(bytes, 1, size, file) == size && fclose(file) == 0);
}

static pd_status load(pd_ctx *ctx, const char *text, const char *const *overrides, int count, pd_setup *setup)
{
    pd_ctx_init(ctx);
    ctx->threads = 1;
    put("a.scene", text, strlen(text));
    return pd_scene_read(ctx, path_of("a.scene"), overrides, count, setup);
}

static inline void leave(pd_ctx *ctx, pd_setup *setup)
{
    pd_setup_free(ctx, setup);
    pd_setup_free(ctx, setup);
    CHECK_INT(ctx->in_use, 0);
}

/* The scene is refused with a message that holds `part`, and nothing is left behind. */
static inline void refused(const char *text, const char *part)
{
    pd_ctx ctx;
    pd_setup setup;
    CHECK(load(&ctx, text, NULL, 0, &setup) < 0);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
    CHECK_INT(ctx.in_use, 0);
}

/* Column `name` of a table of the run, its last row; 0 when there is none. */
static inline double last_of(pd_ctx *ctx, const char *file, const char *name)
{
    pd_table table;
    double values[2000], value = 0.0;
    memset(&table, 0, sizeof table);
    if (CHECK_OK(ctx, pd_table_read(ctx, path_of(file), &table)) && CHECK(table.rows > 0 && table.rows < 2000) &&
        CHECK_OK(ctx, pd_table_parse_column(ctx, &table, name, values)))
        value = values[table.rows - 1];
    pd_table_free(ctx, &table);
    return value;
}

#endif
