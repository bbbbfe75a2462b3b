/* [measured NAME], [constants] and rate_scale of a scene: columns and units, times that steps end on, differences of
 * known size, files, runs that go on from a checkpoint, messages.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "fault.h"
#include "scene_file.h"

#if PD_DIM == 1
#define ACROSS(range)
#else
#define ACROSS(range) ", " range
#endif

/* A slab of 32 um that recedes by 2 um/h from one side: the loss is t/(16 h), whatever the steps. */
#define SLAB "[grid] h = 1 um  m = 3  box = 0 .. 40 um" ACROSS("0 .. 4 um") "\n" \
    "[shape metal] box = 8 um .. 40 um" ACROSS("0 .. 4 um") "  kind = solid\n" \
    "[side x-] flow = noslip\n[transport] D = 1e-9 m2/s\n[dissolve] rate = v\n" \
    "[run] until = 4 h\n[output] every = 1 h  fields = C\n"
#define SLAB_V "[constants] v = 2 um/h\n" SLAB

static void put_text(const char *name, const char *text) { put(name, text, strlen(text)); }

static char result_line[512];

static void keep_line(void *user, pd_print_kind kind, const char *text)
{
    (void)user;
    if (kind == PD_PRINT_RESULT && strstr(text, " measured=")) snprintf(result_line, sizeof result_line, "%s", text);
}

/* Run the scene into a folder; computed [points] */
static pd_status run(pd_ctx *ctx, const pd_setup *u, const char *into, double *computed)
{
    pd_run_desc desc;
    pd_run_result result;
    memset(&desc, 0, sizeof desc);
    desc.folder = path_of(into);
    desc.print = keep_line;
    desc.computed_at_points = computed;
    result_line[0] = '\0';
    return pd_run(ctx, u, &desc, &result);
}

static double value_of(const char *key)
{
    char wanted[40];
    snprintf(wanted, sizeof wanted, " %s=", key);
    const char *at = strstr(result_line, wanted);
    if (!CHECK(at != NULL)) {
        NOTE("no%s in %s", wanted, result_line);
        return 0.0;
    }
    return strtod(at + strlen(wanted), NULL);
}

/* Points off by 0, +3 and -4 points at odd times; one before the start and one behind the end do not count. */
TEST(differences)
{
    pd_ctx ctx;
    pd_setup u;
    double computed[6], t[3] = {0.777, 1.5, 3.9};
    put_text("a.csv", "# made up\ntime [h],loss [%],spread [%]\n-1,50,1\n0,0,0\n0.777,4.85625,1\n1.5,12.375,2\n"
             "3.9,20.375,5\n5,0,1\n");
    if (!CHECK_OK(&ctx, load(&ctx, SLAB_V "[measured a] file = a.csv\n", NULL, 0, &u))) return;
    CHECK_INT(u.measured_count, 1);
    if (CHECK_OK(&ctx, run(&ctx, &u, "out", computed))) {
        CHECK_NEAR(value_of("points"), 3, 0);
        CHECK_NEAR(value_of("rms"), 5.0 / sqrt(3.0), 1e-3);
        CHECK_NEAR(value_of("largest"), 4.0, 1e-9);
        CHECK_REL(value_of("at"), 3.9 * 3600.0, 1e-9);
        CHECK_NEAR(value_of("within_spread"), 2, 0);
        CHECK(isnan(computed[0]) && isnan(computed[1]) && isnan(computed[5]));
        for (int k = 0; k < 3; k++) CHECK_REL(computed[k + 2], t[k] / 16.0, 1e-12);
        CHECK_NEAR(last_of(&ctx, "out/measured_a.csv", "measured [%]"), 0.0, 0.0);
        FILE *picture = fopen(path_of("out/volume_loss.png"), "rb");
        if (CHECK(picture != NULL)) fclose(picture);
        CHECK(fopen(path_of("out/measured_a.png"), "rb") == NULL); /* they stand in the plot of the loss */
    }
    leave(&ctx, &u);
}

/* Other headings, another clock, another figure in another unit; two sections. */
TEST(columns)
{
    pd_ctx ctx;
    pd_setup u;
    double computed[5], cs = 1738.0 / 0.024305, width = PD_DIM == 2 ? 4e-6 : 1.0;
    const char *unit = PD_DIM == 2 ? "mmol/m" : "mmol/m2";
    char text[1200];
    put_text("b.csv", "t_min,left,lost\n120,9,0.0625\n180,8,0.125\n");
    put_text("c.csv", "x,lost_pct,when\n1,6.25,1\n1,12.5,2\n1,18.75,3\n");
    snprintf(text, sizeof text, SLAB_V "[total all]\n[measured b] file = b.csv  time = t_min in min  value = left in %s"
             "  start = 1 h  of = total.all.solid\n"
             "[measured c] file = c.csv  time = when in h  value = lost_pct in %%\n", unit);
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    CHECK_REL(u.measured[0].time[0], 3600.0, 1e-12);
    CHECK_REL(u.measured[0].value[1], 8e-3, 1e-12);
    CHECK(u.measured[0].spread == NULL);
    if (CHECK_OK(&ctx, run(&ctx, &u, "out", computed))) {
        for (int k = 0; k < 2; k++) CHECK_REL(computed[k], cs * width * (32e-6 - (k + 1) * 2e-6), 1e-12);
        for (int k = 0; k < 3; k++) CHECK_REL(computed[2 + k], (k + 1) / 16.0, 1e-12);
        CHECK_NEAR(value_of("rms"), 0.0, 1e-10); /* of the last section */
        CHECK(strstr(result_line, "within") == NULL);
        FILE *picture = fopen(path_of("out/measured_b.png"), "rb");
        if (CHECK(picture != NULL)) fclose(picture);
    }
    leave(&ctx, &u);
}

/* pH and what is dissolved at a probe: a lye diffuses from walls that hold it into water, a slab of 40 um whose middle
 * has 1 - 4/pi sum (-1)^n/(2 n + 1) exp(-D (2 n + 1)^2 pi^2 t/L^2) of it. */
TEST(probes)
{
    pd_ctx ctx;
    pd_setup u;
    double computed[4], base = 0.0, t = 0.1, length = 40e-6, pi = 3.14159265358979324;
    put_text("p.csv", "t_s,pH,Na\n0.05,11,5\n0.1,12,5\n");
    if (!CHECK_OK(&ctx, load(&ctx, "[grid] h = 0.5 um  box = 0 .. 40 um" ACROSS("0 .. 2 um") "\n"
                             "[side x-] flow = noslip  species = inlet\n[side x+] flow = noslip  species = inlet\n"
                             "[chemistry] activity = ideal\n[species H+] D = 5e-9 m2/s\n"
                             "[species OH-] D = 5e-9 m2/s  inlet = 10 mM\n"
                             "[species Na+] D = 5e-9 m2/s  inlet = 10 mM\n"
                             "[reaction water] H2O = H+ + OH-  log10_K = -14\n"
                             "[transport] D = 5e-9 m2/s\n[run] until = 0.1 s  rtol = 1e-5\n"
                             "[probe mid] at = 20 um" ACROSS("1 um") "  fields = pH, Na+\n"
                             "[measured a] file = p.csv  time = t_s in s  value = pH  of = probe.mid.pH\n"
                             "[measured b] file = p.csv  time = t_s in s  value = Na in mol/m3  of = probe.mid.Na+\n",
                             NULL, 0, &u))) return;
    if (CHECK_OK(&ctx, run(&ctx, &u, "out", computed))) {
        for (int n = 0; n < 20; n++)
            base += (n % 2 ? -1.0 : 1.0) / (2 * n + 1) * exp(-5e-9 * (2 * n + 1) * (2 * n + 1) * pi * pi * t /
                                                             (length * length));
        base = 10.0 * (1.0 - 4.0 / pi * base);
        CHECK_REL(computed[3], base, 1e-3);
        CHECK_NEAR(computed[1], 11.0 + log10(base), 4e-4);
        CHECK(computed[0] > 10.0 && computed[0] < computed[1]);
        CHECK_REL(value_of("largest"), computed[3] - 5.0, 4e-4);
    }
    leave(&ctx, &u);
}

static int stop_soon(void *user)
{
    int *left = (int *)user;
    return --*left < 0;
}

static void check_same(const char *a, const char *b)
{
    int c = 0, d = 0;
    FILE *one = fopen(a, "rb"), *two = fopen(b, "rb");
    if (CHECK(one && two))
        while (c == d && c != EOF) {
            c = fgetc(one);
            d = fgetc(two);
        }
    CHECK_INT(c, d);
    if (one) fclose(one);
    if (two) fclose(two);
}

/* A run that was stopped between points goes on with the same bytes. */
TEST(stopped)
{
    static const char *const files[] = {"measured_a.csv", "measured_b.csv", "measured_b.png", "volume_loss.png"};
    const char *text = SLAB_V "[total all]\n[measured a] file = a.csv\n[measured b] file = b.csv  time = t_min in min  "
                       "value = left in %s  of = total.all.solid\n";
    char scene[1200];
    pd_ctx ctx;
    pd_setup u;
    put_text("a.csv", "time [h],loss [%]\n0.5,3\n1.5,9\n3.3,20\n");
    put_text("b.csv", "t_min,left\n20,9\n180,8\n");
    snprintf(scene, sizeof scene, text, PD_DIM == 2 ? "mmol/m" : "mmol/m2");
    if (!CHECK_OK(&ctx, load(&ctx, scene, NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, "whole", NULL));
    for (int resume = 0; resume < 2; resume++) {
        pd_run_desc desc;
        pd_run_result result;
        int left = 8;
        memset(&desc, 0, sizeof desc);
        desc.folder = path_of("cut");
        desc.checkpoints = 1;
        desc.checkpoint_every = 1e9;
        desc.resume = resume;
        if (!resume) desc.stop = stop_soon;
        desc.stop_user = &left;
        CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
        CHECK_INT(result.stopped, !resume);
    }
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++) {
        char whole[64], cut[64];
        snprintf(whole, sizeof whole, "whole/%s", files[k]);
        snprintf(cut, sizeof cut, "cut/%s", files[k]);
        check_same(path_of(whole), path_of(cut));
    }
    leave(&ctx, &u);
}

/* Constants stand for numbers of any dimension, one in another; rate_scale multiplies the law. */
TEST(constants)
{
    static const char *const more[] = {"constants.v=3 um/h", "dissolve.rate_scale=0.5"};
    pd_ctx ctx;
    pd_setup u;
    double none = 0.0;
    if (!CHECK_OK(&ctx, load(&ctx, "[constants] tau = 2 h  path = 4 um  v = path/tau\n" SLAB, NULL, 0, &u))) return;
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &none), 2e-6 / 3600.0, 1e-14);
    leave(&ctx, &u);
    if (!CHECK_OK(&ctx, load(&ctx, SLAB_V, more, 2, &u))) return;
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &none), 1.5e-6 / 3600.0, 1e-14);
    leave(&ctx, &u);
    refused("[constants] v = 2 um\n" SLAB, "found a length [m], expected a speed [m/s]");
    refused("[constants] v = 2 um/h  C = 1\n" SLAB, "found the name 'C', expected one that expressions do not have");
    refused("[constants] v = w\n" SLAB, "found 'w'");
    refused("[constants] v = 2 um/h  s = 2 s\n" SLAB, "found the name 's', which is a unit, expected another");
    refused("[constants] v = 2 um/h  m2 = 1 m2\n" SLAB, "found the name 'm2', which is a unit");
    if (!CHECK_OK(&ctx, load(&ctx, "[constants] h0 = 1 h  d0 = 4 um  v = 2*d0/h0/4\n" SLAB, NULL, 0, &u))) return;
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &none), 2e-6 / 3600.0, 1e-14);
    leave(&ctx, &u);
}

/* The scene is read, and its run refused with a message that holds `part`. */
static void unwatched(const char *text, const char *part)
{
    pd_ctx ctx;
    pd_setup u;
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    CHECK(run(&ctx, &u, "none", NULL) < 0);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
    leave(&ctx, &u);
}

TEST(refusals)
{
    put_text("a.csv", "time [h],loss [%],spread [%]\n1,5,1\n2,6,1\n");
    refused(SLAB_V "[measured] file = a.csv\n", "[measured NAME]");
    refused(SLAB_V "[measured a] file = b0.csv\n", "b0.csv");
    refused(SLAB_V "[measured a] file = a.csv  value = los\n", "expected a column of");
    refused(SLAB_V "[measured a] file = a.csv  time = 2\n", "found a plain number, expected a time [s]");
    refused(SLAB_V "[measured a] file = a.csv  standard_deviation = 1\n",
            "standard_deviation: found a time [s], expected a plain number");
    refused(SLAB_V "[measured a] file = a.csv  of = loss\n", "of: found 'loss'");
    refused(SLAB_V "[measured a] file = a.csv  start = 2 h\n", "found no point behind the start");
    refused(SLAB_V "[measured a] file = a.csv  start = -9 h\n", "before its end at t = 4 h");
    refused(SLAB_V "[measured a] fil = a.csv\n", "did you mean 'file'?");
    put_text("a.csv", "time [h],loss [%]\n2,5\n1,6\n");
    refused(SLAB_V "[measured a] file = a.csv\n", "a.csv:3: found 1, expected a time that is not before");
    put_text("a.csv", "time [h],loss [%],spread [%]\n1,5,1\n2,6,-1\n");
    refused(SLAB_V "[measured a] file = a.csv\n", "a.csv:3: found -1, expected a finite one of at least 0");
    put_text("a.csv", "time [h],loss [%]\n1,nan\n");
    refused(SLAB_V "[measured a] file = a.csv\n", "expected a finite value");
    put_text("a.csv", "time [h]\n1\n");
    refused(SLAB_V "[measured a] file = a.csv\n", "found 1 columns");
    put_text("a.csv", "time [h],solid [mol]\n1,1\n");
    unwatched(SLAB_V "[measured a] file = a.csv\n", "the values of a are an amount [mol], expected a plain number");
    unwatched(SLAB_V "[total all]\n[measured a] file = a.csv  of = total.al.solid\n",
              "a.scene:10: measured: found of = total.al.solid");
    unwatched(SLAB_V "[measured a] file = a.csv  of = probe.p.C\n", "the run watches: volume_loss");
}

/* Read and run a scene without a folder of pictures in between. */
static pd_status whole(pd_ctx *ctx, void *user)
{
    pd_setup *u = (pd_setup *)user;
    pd_run_desc desc;
    pd_run_result result;
    double computed[8];
    memset(&desc, 0, sizeof desc);
    desc.folder = path_of("faults");
    desc.computed_at_points = computed;
    pd_status status = pd_scene_read(ctx, path_of("a.scene"), NULL, 0, u);
    if (status < 0) return status;
    status = pd_run(ctx, u, &desc, &result);
    pd_setup_free(ctx, u);
    return status < 0 ? status : PD_OK;
}

TEST(no_memory)
{
    const char *scene = SLAB_V "[total all]\n[measured a] file = a.csv\n[measured b] file = a.csv  of = total.all.C_max"
                        "  value = 3  start = -1 h\n";
    static pd_setup u;
    put_text("a.csv", "time [h],loss [%],C [mol/m3]\n0.5,3,5\n1.5,9,6\n");
    put_text("a.scene", scene);
    long calls = fault_sweep("measured", whole, &u, 60, 41);
    NOTE("%ld calls", calls);
}

TEST_MAIN(ENTRY(differences) ENTRY(columns) ENTRY(probes) ENTRY(stopped) ENTRY(constants) ENTRY(refusals)
          ENTRY(no_memory))
