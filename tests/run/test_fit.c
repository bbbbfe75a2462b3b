/* fit: values of a scene from measured points: closed forms with their standard errors, bounds, lattices, messages.
 * dims: 1 */
#define _XOPEN_SOURCE 700
#include "fault.h"
#include "run/fit.h"
#include "scene_file.h"

/* A slab of 32 um that recedes by v from one side: the loss is v t/(32 um), on every lattice. */
#define SLAB "[constants] v = 2 um/h\n[grid] h = 1 um  m = 3  box = 0 .. 40 um\n" \
    "[shape metal] box = 8 um .. 40 um  kind = solid\n[side x-] flow = noslip\n[transport] D = 1e-9 m2/s\n" \
    "[dissolve] rate = v\n[run] until = 4 h\n[output] every = 4 h  fields = C\n"

static void put_text(const char *name, const char *text) { put(name, text, strlen(text)); }

static char said[4000];

static void keep(void *user, pd_print_kind kind, const char *text)
{
    size_t used = strlen(said);
    (void)user;
    (void)kind;
    snprintf(said + used, sizeof said - used, "%s\n", text);
}

/* The call of stop_once that stops, 0: none, -1: the first one between two lattices; calls so far. */
static int stop_at, stop_calls;

static int stop_once(void *user)
{
    return ++stop_calls == stop_at || (stop_at < 0 && ((const pd_fit *)user)->result.converged);
}

static pd_status fit_of(pd_ctx *ctx, const char *scene, const char *const *range, int ranges, const char *data,
                        pd_fit *fit)
{
    pd_fit_desc desc;
    memset(&desc, 0, sizeof desc);
    pd_ctx_init(ctx);
    ctx->threads = 1;
    put("a.scene", scene, strlen(scene));
    desc.scene = path_of("a.scene");
    desc.range = range;
    desc.ranges = ranges;
    desc.measured = data;
    desc.print = keep;
    desc.stop = stop_at ? stop_once : NULL;
    desc.stop_user = fit;
    stop_calls = 0;
    said[0] = '\0';
    pd_status status = pd_fit_run(ctx, &desc, fit);
    CHECK_INT(ctx->in_use, 0);
    return status;
}

/* The loss is linear in the scale: s = sum(w f d)/sum(w f f), error 1/sqrt(sum(w f f)), f the loss of the scene. */
TEST(rate_of_a_slab)
{
    static const double t[] = {0.7, 1.3, 2.0, 3.4}, d[] = {6.0, 9.5, 18.5, 29.0}, sigma[] = {1.0, 1.0, 2.0, 3.0};
    static const char *const range[] = {"dissolve.rate_scale=0.5..2"};
    char text[400] = "time [h],loss [%],spread [%]\n", line[2048];
    double fd = 0.0, ff = 0.0, chi2 = 0.0, square = 0.0;
    pd_ctx ctx;
    pd_fit fit;
    for (int k = 0; k < 4; k++) {
        double f = 100.0 * t[k] / 16.0 / sigma[k];
        fd += f * d[k] / sigma[k];
        ff += f * f;
        snprintf(text + strlen(text), sizeof text - strlen(text), "%g,%g,%g\n", t[k], d[k], sigma[k]);
    }
    for (int k = 0; k < 4; k++) {
        double off = fd / ff * 100.0 * t[k] / 16.0 - d[k];
        chi2 += off * off / (sigma[k] * sigma[k]);
        square += off * off / 4.0;
    }
    put_text("d.csv", text);
    CHECK_OK(&ctx, fit_of(&ctx, SLAB, range, 1, path_of("d.csv"), &fit));
    CHECK_REL(fit.result.value[0], fd / ff, 1e-6);
    CHECK_REL(fit.result.standard_error[0], 1.0 / sqrt(ff), 1e-6);
    CHECK_REL(fit.result.sum, chi2, 1e-6);
    CHECK_REL(fit.rms, sqrt(square), 1e-6);
    CHECK_INT(fit.points, 4);
    CHECK(fit.result.converged && fit.result.degrees_of_freedom == 3);
    CHECK_REL(fit.result.high[0] - fit.result.value[0], 1.959964 / sqrt(ff), 1e-6); /* chi2 below the freedom */
    CHECK_LE(chi2, 3.0);
    CHECK_LE(fit.result.evaluations, 6); /* on the lattice of the scene */
    CHECK(strstr(said, "h = 4 um") && strstr(said, "h = 2 um") && strstr(said, "h = 1 um"));
    pd_fit_format_result(&fit, line, sizeof line);
    CHECK(strstr(line, "result case=a fit=volume_loss points=4 rms=") != NULL);
    CHECK(strstr(line, " unit=% ") && strstr(line, " dissolve.rate_scale=") && strstr(line, ".error="));
    NOTE("%d runs, %d of them at h", fit.evaluations, fit.result.evaluations);
    /* without spreads the same sum without weights, and Student's t with 3 degrees of freedom */
    put_text("d.csv", "time [h],loss [%]\n0.7,6\n1.3,9.5\n2,18.5\n3.4,29\n");
    CHECK_OK(&ctx, fit_of(&ctx, SLAB, range, 1, path_of("d.csv"), &fit));
    for (int k = 0, first = 1; k < 4; k++, first = 0) {
        double f = 100.0 * t[k] / 16.0;
        fd = (first ? 0.0 : fd) + f * d[k];
        ff = (first ? 0.0 : ff) + f * f;
    }
    square = 0.0;
    for (int k = 0; k < 4; k++) square += pow(fd / ff * 100.0 * t[k] / 16.0 - d[k], 2.0);
    CHECK_REL(fit.result.value[0], fd / ff, 1e-6);
    CHECK_REL(fit.result.standard_error[0], sqrt(square / 3.0 / ff), 1e-5);
    CHECK_REL(fit.rms, sqrt(square / 4.0), 1e-6);
    CHECK_REL((fit.result.high[0] - fit.result.value[0]) / fit.result.standard_error[0], 3.18245, 1e-5);
}

/* A constant with a unit, bounds in another one, points of the scene and a shifted clock; the bound that is hit. */
TEST(constants_and_bounds)
{
    static const char *const range[] = {"constants.v=1e-10 m/s .. 4 um/h"}, *const low[] = {"v=0.5..1.5 um/h"};
    pd_ctx ctx;
    pd_fit fit;
    char line[2048];
    put_text("d.csv", "when,solid_lost\n10,0\n11,0.078125\n12,0.15625\n13,0.234375\n"); /* 2.5 um/h */
    const char *scene = SLAB "[measured m] file = d.csv  time = when in h  value = solid_lost  start = 10 h\n";
    CHECK_OK(&ctx, fit_of(&ctx, scene, range, 1, NULL, &fit));
    CHECK_STR(fit.parameter[0].unit, "um/h");
    CHECK_NEAR(fit.parameter[0].low, 0.36, 1e-12);
    CHECK_REL(fit.result.value[0], 2.5, 1e-6);
    CHECK_INT(fit.points, 3);
    CHECK_LE(fit.rms, 1e-6);
    CHECK(strncmp(fit.override[0], "constants.v=2.", 14) == 0 && strstr(fit.override[0], " um/h"));
    CHECK(fit_of(&ctx, scene, low, 1, NULL, &fit) >= 0);
    CHECK_NEAR(fit.result.value[0], 1.5, 0.0);
    CHECK_INT(fit.result.active_bound[0], 1);
    pd_fit_format_result(&fit, line, sizeof line);
    CHECK(strstr(line, " v=1.5 v.") && !strstr(line, "nan") && strstr(line, " v.bound=high"));
}

static void refuses(const char *scene, const char *range, const char *data, const char *part)
{
    pd_ctx ctx;
    pd_fit fit;
    CHECK(fit_of(&ctx, scene, &range, 1, data, &fit) < 0);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
}

TEST(refusals)
{
    static const char *const two[] = {"v=1..2 um/h", "dissolve.rate_scale=1..2"};
    static const char *const twice[] = {"v=1..2 um/h", "v=1..3 um/h"};
    pd_ctx ctx;
    pd_fit fit;
    put_text("d.csv", "time [h],loss [%],spread [%]\n0,0,0\n1,5,1\n2,12,1\n");
    put_text("zero.csv", "time [h],loss [%],spread [%]\n1,5,0\n2,12,1\n");
    put_text("one.csv", "time [h],loss [%]\n1,5\n");
    char data[512];
    snprintf(data, sizeof data, "%s", path_of("d.csv"));
    refuses(SLAB, "v", data, "found 'v', expected KEY=LOW..HIGH");
    refuses(SLAB, "v=1", data, "expected KEY=LOW..HIGH");
    refuses(SLAB, "v=..2 um/h", data, "expected a number on either side of '..'");
    /* what the C library takes for numbers beyond those of scenes */
    refuses(SLAB, "v=0x1..2 um/h", data, "found 'v=0x1..2 um/h', expected bounds of one dimension");
    refuses(SLAB, "dissolve.rate_scale=0x1p-1..0x1p1", data, "expected bounds of one dimension");
    refuses(SLAB, "v=nan..2 um/h", data, "expected a number on either side of '..'");
    refuses(SLAB, "v=1..inf um/h", data, "expected a number on either side of '..'");
    refuses(SLAB, "v=0..1e999 um/h", data, "expected a finite low bound below the high one");
    refuses(SLAB, "v=2..1 um/h", data, "expected a finite low bound below the high one");
    refuses(SLAB, "v=1 s..2 um/h", data, "expected bounds of one dimension");
    refuses(SLAB, "w=1..2", data, "found the key 'w', which no section of");
    refuses(SLAB, "dissolve.rate_scal=1..2", data, "rate_scal");
    refuses(SLAB, "v=1..2 um", data, "expected a speed [m/s]");
    refuses(SLAB, "v=1..2 um/h", NULL, "found no [measured NAME] section in the scene, expected one or --to FILE");
    refuses(SLAB, "v=1..2 um/h", "nowhere.csv", "nowhere.csv");
    refuses(SLAB, "v=1..2 um/h", path_of("zero.csv"), "found a spread of 0 in data at t = 3600 s");
    refuses(SLAB, "transport.D=1e-10..1e-9 m2/s", data, "transport.D has no effect on the points");
    refuses(SLAB, "grid.m=0.1..2", data, "command line: m: found 0.1, expected");
    CHECK(fit_of(&ctx, SLAB, twice, 2, data, &fit) < 0 && strstr(ctx.message, "expected each key once"));
    CHECK(fit_of(&ctx, SLAB, two, 2, path_of("one.csv"), &fit) < 0);
    if (!CHECK(strstr(ctx.message, "found 1 point for 2 parameters") != NULL)) NOTE("message: %s", ctx.message);
    CHECK(fit.bad_input);
    CHECK(fit_of(&ctx, SLAB, two, 2, data, &fit) < 0); /* their product is all that counts */
    if (!CHECK(strstr(ctx.message, "do not distinguish the 2 parameters") != NULL)) NOTE("message: %s", ctx.message);
}

/* A wish to stop, whenever it comes, ends the fit; it is no failure of a run or of a lattice. */
TEST(stops)
{
    static const char *const range = "v=1..4 um/h";
    pd_ctx ctx;
    pd_fit fit;
    int ended = 0, times = 0;
    put_text("d.csv", "time [h],loss [%],spread [%]\n0,0,0\n1,5,1\n2,12,1\n");
    for (stop_at = -1; !ended && stop_at < 5000; stop_at += stop_at < 0 ? 2 : 47, times++) {
        pd_status status = fit_of(&ctx, SLAB, &range, 1, path_of("d.csv"), &fit);
        ended = stop_calls < stop_at;
        CHECK_INT((int)status, ended ? (int)PD_OK : (int)PD_CANCELLED);
        if (!ended) CHECK_STR(ctx.message, "fit: interrupted");
        if (!ended && stop_at > 0) CHECK_INT(stop_calls, stop_at);
        CHECK(strstr(said, "no fit at") == NULL);
    }
    NOTE("%d times", times);
    CHECK_LE(10, times); /* on all lattices */
    stop_at = 0;
}

static pd_status whole(pd_ctx *ctx, void *user)
{
    static const char *const range = "v=1..4 um/h";
    static pd_fit fit;
    pd_fit_desc desc;
    (void)user;
    memset(&desc, 0, sizeof desc);
    desc.scene = path_of("a.scene");
    desc.range = &range;
    desc.ranges = 1;
    char data[512];
    snprintf(data, sizeof data, "%s", path_of("d.csv"));
    desc.measured = data;
    return pd_fit_run(ctx, &desc, &fit);
}

TEST(no_memory)
{
    put_text("d.csv", "time [h],loss [%],spread [%]\n0,0,0\n1,5,1\n2,12,1\n");
    put_text("a.scene", SLAB);
    NOTE("%ld calls", fault_sweep("fit", whole, NULL, 20, 487));
}

TEST_MAIN(ENTRY(rate_of_a_slab) ENTRY(constants_and_bounds) ENTRY(refusals) ENTRY(stops) ENTRY(no_memory))
