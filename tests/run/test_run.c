/* run: what a refusal names, what the result of a run says of its flow, all points that a scene may have.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "run/fit.h"
#include "run/parameter_sweep.h"
#include "scene_file.h"

#if PD_DIM == 1
#define ACROSS
#else
#define ACROSS ", 0 .. 4 um"
#endif

static pd_status run(pd_ctx *ctx, const pd_setup *u, const char *into, pd_run_result *result)
{
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.folder = path_of(into);
    return pd_run(ctx, u, &desc, result);
}

/* The scene is read, and its run is refused with a message that holds `part`. */
static void refused_run(const char *text, const char *part)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    CHECK(run(&ctx, &u, "refused", &r) < 0);
    if (!CHECK(strstr(ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", ctx.message, part);
    leave(&ctx, &u);
}

/* What the lattice refuses is said of the line of the first solid, and without one of the first shape. */
TEST(line_of_a_shape)
{
    const char *const box = "[grid] h = 1 um  box = 0 .. 9 um" ACROSS "\n[transport] D = 1e-9 m2/s\n"
        "[run] until = 1 s\n";
    static const struct {
        const char *shapes, *says;
    } cases[] = {
        {"[shape w] box = 0 .. 1 um" ACROSS "  kind = wall\n[shape s] box = 5 um .. 20 um" ACROSS "  kind = solid\n",
         "a.scene:5: grid: the solid reaches from 5e-06 m to 2e-05 m"},
        {"[shape m] box = 0 .. 3 um" ACROSS "  kind = medium  D = 1e-10 m2/s\n"
         "[shape s] box = 4 um .. 5 um" ACROSS "  kind = solid\n"
         "[shape t] box = 7 um .. 12 um" ACROSS "  kind = solid\n",
         "a.scene:5: grid: the solid reaches from 4e-06 m to 1.2e-05 m"},
        {"[shape s] box = 5 um .. 20 um" ACROSS "  kind = solid\n[shape w] box = 0 .. 1 um" ACROSS "  kind = wall\n",
         "a.scene:4: grid: the solid reaches from 5e-06 m to 2e-05 m"},
        {"[shape w] box = 0 .. 9 um" ACROSS "  kind = wall\n[shape v] box = 2 um .. 3 um" ACROSS "  kind = wall\n",
         "a.scene:4: grid: the wall covers every node"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[1000];
        snprintf(text, sizeof text, "%s%s", box, cases[k].shapes);
        refused_run(text, cases[k].says);
    }
}

static int stop_at_once(void *user, const char *doing, int64_t count)
{
    (void)user;
    (void)doing;
    (void)count;
    return 1;
}

/* A run of a sweep that is stopped while it is built has not failed. */
TEST(sweep_stopped_before_the_first_step)
{
    static const char *const scene = "[grid] h = 1 um  box = 0 .. 9 um" ACROSS "\n[transport] D = 1e-9 m2/s\n"
                                     "[side x-] C = 1 mol/m3\n[run] until = 1 s\n",
                             *const axis = "transport.D=1e-9 m2/s, 2e-9 m2/s";
    pd_ctx ctx;
    pd_run_desc run_desc;
    pd_parameter_sweep_desc desc;
    pd_parameter_sweep sweep;
    pd_parameter_sweep_count count;
    pd_ctx_init(&ctx);
    put("sweep.scene", scene, strlen(scene));
    memset(&run_desc, 0, sizeof run_desc);
    memset(&desc, 0, sizeof desc);
    memset(&count, 0, sizeof count);
    desc.scene = path_of("sweep.scene");
    desc.axes = &axis;
    desc.axis_count = 1;
    desc.folder = path_of("sweep");
    if (!CHECK_OK(&ctx, pd_parameter_sweep_build(&ctx, &desc, &sweep))) return;
    CHECK_OK(&ctx, pd_parameter_sweep_run(&ctx, &sweep, 0, &run_desc));
    ctx.cancel = stop_at_once;
    CHECK_INT((int)pd_parameter_sweep_run(&ctx, &sweep, 1, &run_desc), (int)PD_RETRY);
    ctx.cancel = NULL;
    CHECK_OK(&ctx, pd_parameter_sweep_write(&ctx, &sweep, &count));
    CHECK(count.done == 1 && count.failed == 0 && count.stopped == 1);
    pd_parameter_sweep_free(&ctx, &sweep);
    CHECK_INT(ctx.in_use, 0);
}

#if PD_DIM == 1
/* The law of a metal that is an electrode among ions is no number: no potential of it gives a current, and the run says
 * of which law and place, the first cell of fluid. */
TEST(law_of_an_electrode)
{
    static const char *const laws[] = {"sqrt(pH - 20)", "10^(E/(0.1 V))*(pH - 20)^0.5", "log([Mg2+]/(1 mM) - 1)"};
    for (int k = 0; k < 3; k++) {
        char text[2000];
        snprintf(text, sizeof text, "[grid] h = 50 um  m = 2  box = 0 mm .. 1 mm\n"
                 "[shape mg] box = 0 mm .. 0.3 mm  kind = solid  material = mg4ag\n[side x+] species = inlet\n"
                 "[chemistry] activity = ideal  migration = yes\n"
                 "[species H+] D = 9.31e-9 m2/s  initial = 1e-4 mol/m3  inlet = 1e-4 mol/m3\n"
                 "[species OH-] D = 5.27e-9 m2/s  initial = 1e-4 mol/m3  inlet = 1e-4 mol/m3\n"
                 "[species Na+] D = 1.33e-9 m2/s  initial = 100 mol/m3  inlet = 100 mol/m3\n"
                 "[species Cl-] D = 2.03e-9 m2/s  initial = 100 mol/m3  inlet = 100 mol/m3\n"
                 "[species Mg2+] D = 7.05e-10 m2/s\n[reaction water] H2O = H+ + OH-  log10_K = -14\n"
                 "[transport] D = 1.5e-9 m2/s\n"
                 "[dissolve mg4ag] rate = (1e-12 m/s)*%s  reaction = Mg = Mg2+ + 2 e-\n"
                 "[potential]\n[electrode m] shape = mg\n[run] until = 1 s\n", laws[k]);
        refused_run(text, "dissolve: the rate law in pH, species or E gives nan m/s at t = 0 s (node ");
        refused_run(text, " at (0.000325) m, pH 7), expected a speed below 1e100 m/s");
    }
}
#endif

#if PD_DIM == 2
/* The residual of a run is the larger one of momentum and continuity, of the reference speed and length. */
TEST(residual_of_a_flow)
{
    static const char scene[] =
        "[grid] h = 10 um  box = 0 .. 300 um, 0 .. 100 um\n[shape b] box = 100 um .. 150 um, 0 .. 50 um  kind = wall\n"
        "[side x-] flow = inlet  profile = parabola  mean = 1 cm/s\n[side x+] flow = outlet\n"
        "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n";
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    pd_run_result r;
    double most[2] = {0.0, 0.0};
    if (!CHECK_OK(&ctx, load(&ctx, scene, NULL, 0, &u))) return;
    CHECK_OK(&ctx, run(&ctx, &u, "flow", &r));
    if (!CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m)) || !CHECK_OK(&ctx, pd_time_loop_start(&ctx, &m.time_loop)))
        return;
    int64_t total = m.grid.total, split = PD_DIM * total;
    double *of = (double *)calloc((size_t)(split + total), sizeof *of);
    if (!CHECK(of != NULL)) return;
    pdi_flow_assemble_residual(&ctx, &m.flow, of, of + split);
    for (int64_t k = 0; k < split + total; k++) most[k >= split] = fmax(most[k >= split], fabs(of[k]));
    free(of);
    double speed = m.flow.reference_speed, length = m.flow.reference_length;
    most[0] /= speed / length * (speed + m.flow.nu / length);
    most[1] /= speed / length;
    NOTE("momentum %g, continuity %g", most[0], most[1]);
    CHECK_LE(1.1 * fmin(most[0], most[1]), fmax(most[0], most[1])); /* one is the larger one */
    CHECK_REL(r.residual, fmax(most[0], most[1]), 1e-6);
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
}

/* As many sets of points as a scene may have, beside a long note: all of them count, none else. */
TEST(most_sets_of_points)
{
    static const char *const range = "v=1 um/h .. 4 um/h";
    char text[4000] =
        "[constants] v = 2 um/h\n[grid] h = 1 um  m = 2  box = 0 .. 20 um, 0 .. 4 um\n"
        "[shape metal] box = 8 um .. 20 um, 0 .. 4 um  kind = solid\n[side y-] flow = mirror\n[side y+] flow = mirror\n"
        "[transport] D = 1e-9 m2/s\n[dissolve] rate = v\n[solid] E = 1 GPa  nu = 0.487654\n"
        "[side x+] ux = 0 m  uy = 0 m\n[run] until = 3 h\n[output] every = 3 h  fields = C\n";
    static const char points[] = "time [h],loss [%],spread [%]\n1,25,1\n2,50,1\n"; /* 3 um/h of 12 um */
    pd_ctx ctx;
    pd_fit_desc desc;
    pd_fit fit;
    put("d.csv", points, strlen(points));
    for (int k = 0; k < PD_SETUP_MEASURED_MAX; k++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "[measured m%d] file = d.csv\n", k);
    put("a.scene", text, strlen(text));
    memset(&desc, 0, sizeof desc);
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    desc.scene = path_of("a.scene");
    desc.range = &range;
    desc.ranges = 1;
    CHECK_OK(&ctx, pd_fit_run(&ctx, &desc, &fit));
    CHECK_INT(fit.measured_sets, PD_SETUP_MEASURED_MAX);
    CHECK_INT(fit.points, 2 * PD_SETUP_MEASURED_MAX);
    CHECK_REL(fit.result.value[0], 3.0, 1e-6);
    CHECK_INT(ctx.in_use, 0);
}
#endif

/* The threads of a scene are those of its run, and the context has those of the caller behind it, also when the run is
 * refused: its solid reaches out of the box. Those of the caller go first. */
TEST(threads_of_each_run)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_result r;
    char text[400];
    for (int k = 0; k < 6; k++) {
        int scene = 1 + k % 2, caller = k == 4 ? 3 : 0, bad = k > 1 && k < 4;
        snprintf(text, sizeof text,
                 "[grid] h = 1 um  threads = %d  box = 0 .. 9 um" ACROSS "\n[shape s] box = 5 um .. %d um" ACROSS
                 "  kind = solid\n[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h\n[run] until = 1 s\n",
                 scene, bad ? 20 : 9);
        if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) continue;
        ctx.threads = caller;
        pd_status status = run(&ctx, &u, "threads", &r);
        if (bad) CHECK(status < 0);
        else if (CHECK_OK(&ctx, status)) {
#ifdef _OPENMP
            CHECK_INT(r.threads, caller ? caller : scene);
#else
            CHECK_INT(r.threads, 1);
#endif
        }
        CHECK_INT(ctx.threads, caller);
        leave(&ctx, &u);
    }
}

#if PD_DIM == 1
TEST_MAIN(ENTRY(line_of_a_shape) ENTRY(sweep_stopped_before_the_first_step)
              ENTRY(threads_of_each_run) ENTRY(law_of_an_electrode))
#else
TEST_MAIN(ENTRY(line_of_a_shape) ENTRY(sweep_stopped_before_the_first_step)
              ENTRY(threads_of_each_run) ENTRY(residual_of_a_flow) ENTRY(most_sets_of_points))
#endif
