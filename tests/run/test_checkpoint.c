/* Checkpoints: runs that are stopped and go on have the files of a run that was not, byte for byte; damaged files,
 * those of another scene, dimension or version are refused; a checkpoint that cannot be written leaves the former one.
 * Who watches a run does not change it.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "checkpoint_scene.h"
#include "io/archive_file.h"
#include "checkpoint_model.h"
#include "run/monitor.h"
#include "physics/step_diagnostics.h"
#include "io/zlib.h"
#include <signal.h>
#include <sys/resource.h>

/* ---- runs that go on ---- */

typedef struct player {
    int steps, stop_after; /* 0: never */
    char text[2000];
} player;

static int stop(void *user)
{
    player *p = (player *)user;
    return ++p->steps == p->stop_after;
}

static void listen(void *user, pd_print_kind kind, const char *text)
{
    player *p = (player *)user;
    size_t used = strlen(p->text);
    if (kind != PD_PRINT_PROGRESS) snprintf(p->text + used, sizeof p->text - used, "%s\n", text);
}

/* One run of a scene: `stop_after` looks at the clock it stops, with checkpoints when `keep`. */
static pd_status play(pd_ctx *ctx, const pd_setup *u, const char *out, int stop_after, int resume, int threads,
                      player *p, pd_run_result *result)
{
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(p, 0, sizeof *p);
    p->stop_after = stop_after;
    ctx->threads = threads;
    desc.folder = path_of(out);
    desc.print = listen;
    desc.print_user = p;
    desc.stop = stop;
    desc.stop_user = p;
    desc.checkpoints = 1;
    desc.checkpoint_every = 1e9;
    desc.resume = resume;
    return pd_run(ctx, u, &desc, result);
}

/* Stopped every `each` steps, the thread count changing every time, a run goes on to the files of folder `whole`. */
static void chain(pd_ctx *ctx, const pd_setup *u, const char *whole, const char *out, int each,
                  const pd_run_result *wanted)
{
    pd_run_result result;
    player p;
    int parts = 0;
    do {
        if (!CHECK_OK(ctx, play(ctx, u, out, each, parts > 0, 1 + parts % 2, &p, &result))) return;
        parts++;
    } while (result.stopped && CHECK(parts < 2000));
    CHECK(parts > 1);
    CHECK_NEAR(result.time, wanted->time, 0.0);
    CHECK_INT(result.steps, wanted->steps);
    CHECK_INT(result.evaluations, wanted->evaluations);
    CHECK_NEAR(result.volume_loss, wanted->volume_loss, 0.0);
    CHECK_NEAR(result.mass_balance_error, wanted->mass_balance_error, 0.0);
    CHECK_NEAR(result.layer_flux_error, wanted->layer_flux_error, 0.0);
    CHECK_NEAR(result.corrosion_depth, wanted->corrosion_depth, 0.0);
    same_folders(whole, out);
}

TEST(stopped_and_not)
{
    for (int k = 0; k < KINDS; k++) {
        pd_ctx ctx;
        pd_setup u;
        pd_run_result result;
        player p;
        char whole[64], every[64], some[64];
        int before = test_now.failures;
        snprintf(whole, sizeof whole, "whole%d", k);
        snprintf(every, sizeof every, "every%d", k);
        snprintf(some, sizeof some, "some%d", k);
        if (!CHECK_OK(&ctx, load(&ctx, kinds[k].text, NULL, 0, &u))) return;
        if (CHECK_OK(&ctx, play(&ctx, &u, whole, 0, 0, 1, &p, &result)) && CHECK(result.steps > 3)) {
            if (PD_DIM == 2) chain(&ctx, &u, whole, every, 1, &result); /* in 3D that takes minutes */
            chain(&ctx, &u, whole, some, 1 + (p.steps - 1) / 3, &result);
            /* states that are checked have metal that went */
            if (u.has_dissolve) CHECK(result.volume_loss > 0.01);
        }
        if (test_now.failures > before) NOTE("of %s, %d steps", kinds[k].name, p.steps);
        leave(&ctx, &u);
    }
}

/* Rows and frames behind the checkpoint, as after a kill, are cut off and made again. */
TEST(behind_the_checkpoint)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result result;
    player p;
    char command[1200];
    if (!CHECK_OK(&ctx, load(&ctx, COUPLED, NULL, 0, &u))) return;
    CHECK_OK(&ctx, play(&ctx, &u, "whole", 0, 0, 1, &p, &result));
    int third = p.steps / 3;
    CHECK(third > 0);
    CHECK_OK(&ctx, play(&ctx, &u, "killed", third, 0, 1, &p, &result));
    snprintf(command, sizeof command, "cp %s %s", path_of("killed/checkpoint.bin"), path_of("kept"));
    CHECK_INT(system(command), 0);
    CHECK_OK(&ctx, play(&ctx, &u, "killed", third, 1, 1, &p, &result));
    CHECK(result.stopped);
    snprintf(command, sizeof command, "cp %s %s; printf '3,4' >> %s; printf x > %s", path_of("kept"),
             path_of("killed/checkpoint.bin"), path_of("killed/diagnostics.csv"),
             path_of("killed/checkpoint.bin.part"));
    CHECK_INT(system(command), 0);
    CHECK_OK(&ctx, play(&ctx, &u, "killed", 0, 1, 1, &p, &result));
    CHECK(strstr(p.text, "goes on from t = ") != NULL);
    same_folders("whole", "killed");
    leave(&ctx, &u);
}

/* A run that is done has no checkpoint, one that begins anew removes that of another, and tables must be there. */
TEST(life_of_a_checkpoint)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result result;
    player p;
    if (!CHECK_OK(&ctx, load(&ctx, COUPLED, NULL, 0, &u))) return;
    CHECK_OK(&ctx, play(&ctx, &u, "life", 3, 0, 1, &p, &result));
    CHECK(result.stopped && access(path_of("life/checkpoint.bin"), R_OK) == 0);
    CHECK(access(path_of("life/checkpoint.bin.part"), F_OK) != 0);
    put("life/probes.csv", "# short\n", 8);
    CHECK_INT(play(&ctx, &u, "life", 0, 1, 1, &p, &result), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "probes.csv' holds 8 bytes, expected at least the ") != NULL && result.bad_input);
    remove(path_of("life/probes.csv"));
    CHECK_INT(play(&ctx, &u, "life", 0, 1, 1, &p, &result), PD_ERR_FILE);
    CHECK(access(path_of("life/checkpoint.bin"), R_OK) == 0);
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(&p, 0, sizeof p);
    p.stop_after = 2;
    desc.folder = path_of("life");
    desc.stop = stop;
    desc.stop_user = &p;
    CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
    CHECK(result.stopped && access(path_of("life/checkpoint.bin"), F_OK) != 0);
    CHECK_INT(play(&ctx, &u, "life", 0, 1, 1, &p, &result), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "cannot open '") != NULL && strstr(ctx.message, "checkpoint.bin") != NULL);
    leave(&ctx, &u);
}

/* A list that is not the one of the checkpoint is refused, and no file that it names is deleted: neither behind the
 * length of the list, which lies within a line here, nor under the rest of that line. */
TEST(list_of_another_run)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result result;
    player p;
    size_t size, at = 0, after;
    char list[4000];
    if (!CHECK_OK(&ctx, load(&ctx, COUPLED, NULL, 0, &u))) return;
    CHECK_OK(&ctx, play(&ctx, &u, "list", 3, 0, 1, &p, &result));
    char *bytes = bytes_of(path_of("list/pdcorr.files"), &size);
    if (!CHECK(bytes && size > 60 && size < 2000)) return;
    for (int lines = 0; lines < 2; at++) lines += bytes[at] == '\n';
    memcpy(list, bytes, at);
    memset(list + at, 'a', size - at);
    strcpy(list + size, "b.csv\nmine.csv\n");
    put("list/pdcorr.files", list, strlen(list));
    put("list/b.csv", "1", 1);
    put("list/mine.csv", "1", 1);
    CHECK_INT(play(&ctx, &u, "list", 0, 1, 1, &p, &result), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "no line of '") != NULL && strstr(ctx.message, "pdcorr.files' ends at byte ") != NULL);
    CHECK(result.bad_input);
    CHECK(access(path_of("list/b.csv"), R_OK) == 0);
    CHECK(access(path_of("list/mine.csv"), R_OK) == 0);
    CHECK(access(path_of("list/pdcorr.files.part"), F_OK) != 0);
    char *left = bytes_of(path_of("list/pdcorr.files"), &after);
    CHECK(left && after == strlen(list) && memcmp(left, list, after) == 0);
    free(left);
    /* with the list as it was, and a file behind its end, the run goes on and deletes that */
    memcpy(list, bytes, size);
    strcpy(list + size, "mine.csv\n");
    put("list/pdcorr.files", list, strlen(list));
    CHECK_OK(&ctx, play(&ctx, &u, "list", 3, 1, 1, &p, &result));
    CHECK(access(path_of("list/b.csv"), R_OK) == 0);
    CHECK(access(path_of("list/mine.csv"), F_OK) != 0);
    free(bytes);
    leave(&ctx, &u);
}

/* ---- models, without the files of a run ---- */

#define SMALL \
    "[grid] h = 1 um  m = 1  box = 0 .. 4 um" ACROSS("0 .. 3 um") "\n[shape b] box = 0 .. 2 um" ACROSS("0 .. 3 um") \
    "  kind = solid  material = mg4ag\n[transport] D = 1e-9 m2/s\n[dissolve] rate = 2 um/h  # as it was\n" \
    "[run] until = 1 h\n[output] every = 10 min  fields = C\n"

static int grow(pd_ctx *ctx, pd_setup *u, pd_model *m, const char *text)
{
    return CHECK_OK(ctx, load(ctx, text, NULL, 0, u)) && CHECK_OK(ctx, pd_model_build(ctx, u, m));
}

/* Some metal has turned fluid, and some has not. */
static int stop_when_turned(void *user, const pd_time_loop *couple)
{
    (void)user;
    return couple->grid->solid_count < couple->solid_nodes_start;
}

TEST(models_go_on)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model a, b;
    if (!grow(&ctx, &u, &a, COUPLED) || !CHECK_OK(&ctx, pd_model_build(&ctx, &u, &b))) return;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &a.time_loop, u.end_time, u.output_interval, stop_when_turned, NULL));
    CHECK(a.grid.solid_count > 0 && a.grid.solid_count < b.grid.solid_count && a.time_loop.steps > 1);
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("model"), &a));
    CHECK_OK(&ctx, checkpoint_load(&ctx, path_of("model"), &b));
    CHECK_INT(memcmp(a.grid.kind, b.grid.kind, (size_t)a.grid.total), 0);
    CHECK_INT(a.grid.solid_count, b.grid.solid_count);
    CHECK_OK(&ctx, pd_bonds_validate(&ctx, &b.bonds));
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &a.time_loop, u.end_time, u.output_interval, NULL, NULL));
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &b.time_loop, u.end_time, u.output_interval, NULL, NULL));
    CHECK_INT(memcmp(a.grid.kind, b.grid.kind, (size_t)a.grid.total), 0);
    CHECK_INT(memcmp(a.transport.c, b.transport.c, (size_t)a.grid.total * sizeof(double)), 0);
    CHECK_INT(memcmp(a.flow.u, b.flow.u, (size_t)a.grid.total * PD_DIM * sizeof(double)), 0);
    CHECK_INT(memcmp(a.flow.p, b.flow.p, (size_t)a.grid.total * sizeof(double)), 0);
    CHECK_INT(memcmp(&a.time_loop.ledger, &b.time_loop.ledger, sizeof a.time_loop.ledger), 0);
    CHECK_NEAR(a.time_loop.time, u.end_time, 0.0);
    CHECK_INT(a.time_loop.steps, b.time_loop.steps);
    /* metal that is there cannot come from metal that is gone: b has made steps */
    CHECK(checkpoint_load(&ctx, path_of("model"), &b) == PD_ERR_GEOMETRY);
    pd_model_free(&ctx, &a);
    pd_model_free(&ctx, &b);
    leave(&ctx, &u);
}

/* ---- who looks on ---- */

typedef struct watcher {
    pd_ctx *ctx;
    pd_model *model;
    pd_monitors monitors;
    pd_step_diagnostics observables;
} watcher;

static int watch(void *user, const pd_time_loop *couple)
{
    watcher *w = (watcher *)user;
    pd_step_diagnostics_update(w->ctx, w->model, &w->observables);
    CHECK_OK(w->ctx, pdi_monitors_step(w->ctx, &w->monitors));
    return couple->time < 0.0;
}

/* Values of the fluid and the metal that differ in their bits; ghosts are whoever filled them last. */
static int differ(const pd_grid *grid, int components, const double *a, const double *b)
{
    int count = 0;
    for (int32_t i = 0; i < grid->total && a; i++)
        for (int d = 0; d < components && (grid->kind[i] == PD_FLUID || grid->kind[i] == PD_SOLID); d++)
            count += memcmp(&a[(int64_t)d * grid->total + i], &b[(int64_t)d * grid->total + i], sizeof *a) != 0;
    return count;
}

/* All that watches a run, from before its first step on, changes no bit of it. */
static void observed(int k)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model a, b;
    watcher w;
    memset(&w, 0, sizeof w);
    w.ctx = &ctx;
    w.model = &b;
    if (!grow(&ctx, &u, &a, kinds[k].text) || !CHECK_OK(&ctx, pd_model_build(&ctx, &u, &b))) return;
    int before = test_now.failures;
    if (CHECK_OK(&ctx, pdi_monitors_build(&ctx, &b, &w.monitors)) &&
        CHECK_OK(&ctx, pd_step_diagnostics_build(&ctx, &b, &w.observables))) {
        CHECK_OK(&ctx, pd_time_loop_run(&ctx, &a.time_loop, u.end_time, u.output_interval, NULL, NULL));
        CHECK_OK(&ctx, pd_time_loop_run(&ctx, &b.time_loop, u.end_time, u.output_interval, watch, &w));
        CHECK(a.time_loop.steps > 2);
        CHECK_INT(b.time_loop.steps, a.time_loop.steps);
        CHECK_INT(memcmp(a.grid.kind, b.grid.kind, (size_t)a.grid.total), 0);
        CHECK_INT(differ(&a.grid, 1, a.transport.c, b.transport.c), 0);
        CHECK_INT(differ(&a.grid, PD_DIM, a.flow.u, b.flow.u), 0);
        CHECK_INT(differ(&a.grid, 1, a.flow.p, b.flow.p), 0);
        CHECK_INT(memcmp(&a.time_loop.ledger, &b.time_loop.ledger, sizeof a.time_loop.ledger), 0);
    }
    if (test_now.failures > before) NOTE("of %s", kinds[k].name);
    pd_step_diagnostics_free(&ctx, &w.observables);
    pdi_monitors_free(&ctx, &w.monitors);
    pd_model_free(&ctx, &a);
    pd_model_free(&ctx, &b);
    leave(&ctx, &u);
}

TEST(observed_and_not) { observed(0); }

TEST(observed_of_all_kinds)
{
    for (int k = 1; k < KINDS; k++) observed(k);
}

/* ---- files that are refused ---- */

static pd_status refusal(pd_ctx *ctx, const char *bytes, size_t size)
{
    pd_archive_file store;
    put("bad", bytes, size);
    pd_status status = pd_archive_file_open(ctx, path_of("bad"), &store);
    pdi_archive_file_abandon(&store);
    return status;
}

/* Every byte of a checkpoint counts, and so does its length. */
TEST(damage)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    size_t size;
    int missed = 0, unclear = 0;
    if (!grow(&ctx, &u, &m, SMALL)) return;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, 600.0, 0.0, NULL, NULL));
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("good"), &m));
    char *bytes = bytes_of(path_of("good"), &size);
    if (!CHECK(bytes && size > 1000 && size < 30000)) return;
    CHECK_OK(&ctx, refusal(&ctx, bytes, size));
    for (size_t k = 0; k < size; k++) {
        char was = bytes[k];
        bytes[k] = (char)(was ^ (1 << k % 8));
        missed += refusal(&ctx, bytes, size) != PD_ERR_FILE;
        unclear += !strstr(ctx.message, "/bad' ");
        unclear += !strstr(ctx.message, "damaged") && !strstr(ctx.message, "cut off");
        bytes[k] = was;
    }
    for (size_t length = 0; length < size; length++) {
        missed += refusal(&ctx, bytes, length) != PD_ERR_FILE;
        unclear += !strstr(ctx.message, "/bad' is cut off in ");
    }
    CHECK_INT(missed, 0);
    CHECK_INT(unclear, 0);
    char *longer = (char *)calloc(1, size + 1);
    if (CHECK(longer != NULL)) memcpy(longer, bytes, size);
    if (longer) CHECK_INT(refusal(&ctx, longer, size + 1), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "goes on behind its end") != NULL);
    free(longer);
    free(bytes);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

/* Put a number into the head of a checkpoint, with its checksum. */
static void forge(char *bytes, size_t at, const void *value, size_t size)
{
    memcpy(bytes + at, value, size);
    uint32_t crc = pdi_zlib_crc32(0, (const uint8_t *)bytes, 60);
    memcpy(bytes + 60, &crc, 4);
}

TEST(other_files)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    size_t size;
    char head[64], part[80];
    uint32_t format = 7, dim = 5 - PD_DIM, order = 0x04030201u;
    if (!grow(&ctx, &u, &m, SMALL)) return;
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("good"), &m));
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
    char *bytes = bytes_of(path_of("good"), &size);
    if (!CHECK(bytes && size > 64)) return;
    memcpy(head, bytes, sizeof head);
    forge(bytes, 12, &format, 4);
    CHECK_INT(refusal(&ctx, bytes, size), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "is of format 7, expected 3") != NULL);
    memcpy(bytes, head, sizeof head);
    forge(bytes, 16, &dim, 4);
    CHECK_INT(refusal(&ctx, bytes, size), PD_ERR_ARGUMENT);
    snprintf(part, sizeof part, "is of dimension %d, expected %d", (int)dim, PD_DIM);
    CHECK(strstr(ctx.message, part) != NULL);
    memcpy(bytes, head, sizeof head);
    forge(bytes, 24, "0.0.7", 6);
    CHECK_INT(refusal(&ctx, bytes, size), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "was written by pdcorr 0.0.7, expected " PD_VERSION) != NULL);
    memcpy(bytes, head, sizeof head);
    forge(bytes, 8, &order, 4);
    CHECK_INT(refusal(&ctx, bytes, size), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "the other byte order") != NULL);
    CHECK_INT(refusal(&ctx, "[grid] h = 1 um\n", 16), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "does not begin like a checkpoint") != NULL);
    free(bytes);
}

/* The checkpoint of `text` is refused by the scene `other` with a message that ends like this. */
static void stranger(const char *text, const char *other, pd_status wanted, const char *part)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!grow(&ctx, &u, &m, text)) return;
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, 600.0, 0.0, NULL, NULL));
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("theirs"), &m));
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
    if (!grow(&ctx, &u, &m, other)) return;
    CHECK_INT(checkpoint_load(&ctx, path_of("theirs"), &m), wanted);
    if (part && !CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

#define SCENE(grid, rate, rest) \
    "[grid] h = 1 um  m = 1" grid "  box = 0 .. 4 um" ACROSS("0 .. 3 um") "\n[shape b] box = 0 .. 2 um" \
    ACROSS("0 .. 3 um") "  kind = solid  material = mg4ag\n[transport] D = 1e-9 m2/s\n[dissolve] rate = " rate \
    "\n[run] until = 1 h\n[output] every = 10 min  fields = C" rest "\n"

TEST(other_scenes)
{
    stranger(SMALL, SCENE("", "2   um/h", ""), PD_OK, NULL);
    stranger(SMALL, SCENE("  threads = 2", "2 um/h", "  folder = elsewhere"), PD_OK, NULL);
    stranger(SMALL, SCENE("", "3 um/h", ""), PD_ERR_ARGUMENT,
             "it is of another scene: found 'dissolve.rate = 2 um/h', expected 'dissolve.rate = 3 um/h'");
    stranger(SMALL, SCENE("", "2 um/h", "\n[probe a] at = 3 um" ACROSS("1 um")), PD_ERR_ARGUMENT,
             "it is of another scene: found no '[probe a]', expected one");
    stranger(SCENE("", "2 um/h", "\n[probe a] at = 3 um" ACROSS("1 um")), SMALL, PD_ERR_ARGUMENT,
             "it is of another scene: found '[probe a]', expected none");
    stranger(SMALL, SCENE("", "2 um/h  grain_boundary_factor = 1", ""), PD_ERR_ARGUMENT,
             "it is of another scene: found no 'dissolve.grain_boundary_factor = 1', expected one");
    stranger(COUPLED, SMALL, PD_ERR_ARGUMENT, "it is of another scene: found '");
}

/* Settings that a caller changes behind the reader. */
TEST(other_settings)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    if (!grow(&ctx, &u, &m, SMALL)) return;
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("good"), &m));
    u.end_time = 7200.0;
    CHECK_INT(checkpoint_load(&ctx, path_of("good"), &m), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "good' is of another run: until [s] = 3600, expected 7200") != NULL);
    u.end_time = 3600.0;
    CHECK_OK(&ctx, checkpoint_load(&ctx, path_of("good"), &m));
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

/* ---- no room ---- */

TEST(no_room)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    pd_run_result result;
    player p;
    struct rlimit before, small;
    size_t size, after;
    if (!grow(&ctx, &u, &m, COUPLED)) return;
    CHECK_OK(&ctx, pd_time_loop_start(&ctx, &m.time_loop));
    CHECK_OK(&ctx, checkpoint_save(&ctx, path_of("room"), &m));
    char *bytes = bytes_of(path_of("room"), &size);
    CHECK_OK(&ctx, pd_time_loop_run(&ctx, &m.time_loop, u.end_time, u.output_interval, stop_when_turned, NULL));
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    CHECK_INT(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 4000;
    CHECK(size > small.rlim_cur);
    CHECK_INT(setrlimit(RLIMIT_FSIZE, &small), 0);
    CHECK_INT(checkpoint_save(&ctx, path_of("room"), &m), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "cannot write '") != NULL && strstr(ctx.message, "room.part': ") != NULL);
    /* a run that cannot keep its state says so and fails when it is to stop */
    CHECK_INT(play(&ctx, &u, "noroom", 3, 0, 1, &p, &result), PD_ERR_FILE);
    CHECK_INT(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, handler);
    CHECK(access(path_of("room.part"), F_OK) != 0);
    char *left = bytes_of(path_of("room"), &after);
    CHECK(bytes && left && size == after && memcmp(bytes, left, size) == 0);
    pd_model_free(&ctx, &m);
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m))) CHECK_OK(&ctx, checkpoint_load(&ctx, path_of("room"), &m));
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
    free(bytes);
    free(left);
}

TEST_MAIN(SLOW_ENTRY(stopped_and_not) SLOW_ENTRY_IF(PD_DIM == 3, behind_the_checkpoint) ENTRY(life_of_a_checkpoint)
              ENTRY(list_of_another_run) SLOW_ENTRY_IF(PD_DIM == 3, models_go_on)
                  SLOW_ENTRY_IF(PD_DIM == 3, observed_and_not) SLOW_ENTRY(observed_of_all_kinds)
                      SLOW_ENTRY_IF(PD_DIM == 3, damage) ENTRY(other_files) ENTRY(other_scenes) ENTRY(other_settings)
                          ENTRY(no_room))
