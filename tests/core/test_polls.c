/* Every place where the caller may stop: no memory stays, no file is half written.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "fault.h"
#include "physics/model.h"
#include "scene/scene.h"
#include "scene_file.h"
#include "run/coarsen_setup.h"
#include "io/vti.h"

#if PD_DIM == 2
#define VALUES(a) a ", " a
#define SLIDING "1 mm/s, 0"
#define SIZE "16 um"
#define HALF "8 um"
#else
#define VALUES(a) a ", " a ", " a
#define SLIDING "1 mm/s, 0, 0"
#define SIZE "10 um"
#define HALF "5 um"
#endif

enum { CALLS = 20000 };

typedef struct stopper {
    long asked, stop_at;  /* calls so far, the one that is answered by a stop */
    const char *doing;    /* at that call */
    uint8_t fresh[CALLS]; /* 1: the call before was made by something else */
} stopper;

static int asked(void *user, const char *doing, int64_t count)
{
    stopper *s = (stopper *)user;
    (void)count;
    if (!s->stop_at && s->asked + 1 < CALLS) s->fresh[s->asked + 1] = !s->doing || strcmp(doing, s->doing) != 0;
    s->doing = doing;
    return ++s->asked == s->stop_at;
}

/* The work is stopped at its calls in turn, each alone: all of the first `dense`, and behind them those that something
 * else makes than the one before, but every `stride`th of these. Returns the number of calls. */
static long stop_everywhere(const char *what, fault_work work, void *user, long dense, long stride)
{
    static stopper s;
    fault f;
    pd_ctx ctx;
    long calls = 0, changes = 0, stops = 0;
    for (long k = 0; k <= calls; k++) {
        if (k > dense && (!s.fresh[k] || changes++ % stride)) continue;
        s.asked = 0;
        s.doing = NULL;
        stops++;
        fault_context(&f, 0, 0, &ctx);
        ctx.cancel = asked;
        ctx.cancel_user = &s;
        s.stop_at = k;
        pd_status status = work(&ctx, user);
        if (k == 0) calls = s.asked < CALLS ? s.asked : CALLS - 1;
        if (!CHECK(status == (k ? PD_CANCELLED : PD_OK)) || !CHECK(s.asked == (k ? k : calls)))
            NOTE("%s: stop %ld of %ld (%s): status %d after %ld calls: %s", what, k, calls, s.doing, (int)status,
                 s.asked, ctx.message);
        if (!CHECK(f.live == 0 && f.wrong == 0 && ctx.in_use == 0))
            NOTE("%s: stop %ld of %ld (%s): %ld blocks left", what, k, calls, s.doing, f.live);
    }
    NOTE("%s: %ld calls, %ld stops", what, calls, stops - 1);
    return calls;
}

static pd_setup shared; /* read once, as its files are */

static pd_ctx reader;   /* of it */

static int prepare(const char *text) { return CHECK_OK(&reader, load(&reader, text, NULL, 0, &shared)); }

#define BOX "[grid] h = 1 um  m = 2  box = " VALUES("0 .. " SIZE) "\n"
#define PIN "[shape pin] ball = " VALUES(HALF) "  radius = 3 um  kind = solid  material = mg4ag\n"

static pd_status model_work(pd_ctx *ctx, void *user)
{
    static pd_model model;
    pd_status status = pd_model_build(ctx, &shared, &model);
    (void)user;
    if (status >= 0)
        status = pd_time_loop_run(ctx, &model.time_loop, shared.end_time, shared.output_interval, NULL, NULL);
    pd_model_free(ctx, &model);
    return status;
}

static pd_status coarser_work(pd_ctx *ctx, void *user)
{
    static pd_coarsened_setup coarser;
    (void)user;
    return pdi_coarsen_setup_build(ctx, &shared, 2, &coarser);
}

/* All that a frame holds; neither the file nor its beginning is there after a stop. */
static pd_status vti_work(pd_ctx *ctx, void *user)
{
    const pd_grid *grid = (const pd_grid *)user;
    pd_vti_field field;
    char part[600];
    const char *path = path_of("frame.vti");
    memset(&field, 0, sizeof field);
    field.name = "kind";
    field.type = PD_VTI_UINT8;
    field.data = grid->kind;
    remove(path);
    pd_status status = pd_vti_write(ctx, path, grid, 0.0, &field, 1);
    snprintf(part, sizeof part, "%s.part", path);
    FILE *whole = fopen(path, "rb"), *half = fopen(part, "rb");
    CHECK((whole != NULL) == (status == PD_OK) && half == NULL);
    if (whole) fclose(whole);
    if (half) fclose(half);
    return status;
}

/* From the lattice to the last step: bonds, multigrids, flow, transport, dissolution. */
TEST(dissolution)
{
    if (!prepare(BOX PIN "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s  C = 0\n[side x+] flow = outlet\n"
                 "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n[transport] D = 1e-9 m2/s\n"
                 "[dissolve] rate = 100 um/h * (1 - C/Csat)  Csat = 56 mol/m3\n[run] until = 1 s\n"
                 "[output] every = 5 s\n"))
        return;
    CHECK_LE(40, stop_everywhere("dissolution", model_work, NULL, 30, PD_DIM == 2 ? 7 : 31));
    leave(&reader, &shared);
}

TEST(flow_in_time)
{
    if (!prepare(BOX "[side y+] velocity = " SLIDING "\n[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s  time = implicit\n"
                 "[transport] D = 1e-9 m2/s  initial = x / 1 um * 1 mol/m3\n[run] until = 1e-8 s\n"
                 "[output] every = 1e-8 s\n"))
        return;
    CHECK_LE(40, stop_everywhere("flow in time", model_work, NULL, 30, PD_DIM == 2 ? 7 : 31));
    leave(&reader, &shared);
}

TEST(frames_and_coarser)
{
    pd_ctx ctx;
    int line;
    pd_stencil stencil;
    pd_grid grid;
    if (!prepare(BOX PIN "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n[run] until = 5 s\n"
                 "[output] every = 5 s\n"))
        return;
    CHECK_LE(3, stop_everywhere("coarser", coarser_work, NULL, CALLS, 1));
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pd_model_build_grid(&ctx, &shared, &line, &stencil, &grid))) return;
    CHECK_INT(stop_everywhere("vti", vti_work, &grid, CALLS, 1), PD_DIM == 2 ? 16 : 100);
    pd_grid_free(&ctx, &grid);
    pd_stencil_free(&ctx, &stencil);
    CHECK_INT(ctx.in_use, 0);
    leave(&reader, &shared);
}

TEST_MAIN(SLOW_ENTRY_IF(PD_DIM == 3, dissolution) ENTRY(flow_in_time) ENTRY(frames_and_coarser))
