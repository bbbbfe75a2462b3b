/* [corrode] of a scene: keys, fronts against closed forms, streams, axes, the balance, threads, films, grains, files.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"

/* Ranges of the axes across x. */
#if PD_DIM == 1
#define ACROSS(range)
#elif PD_DIM == 2
#define ACROSS(range) ", " range
#else
#define ACROSS(range) ", " range ", " range
#endif

#define BOX "[grid] h = 1 um  m = 3  box = 0 .. 40 um" ACROSS("0 .. 4 um") "\n"
#define METAL "[shape metal] box = 8 um .. 40 um" ACROSS("0 .. 4 um") "  kind = solid  material = steel304"

/* A flat front that faces x-. */
#define FLAT BOX METAL "\n[side x-] flow = open\n[side x+] flow = mirror\n"
#define END "[run] until = 25 s\n[output] every = 5 s  fields = C, kind, density\n"

static pd_status play(pd_ctx *ctx, const pd_setup *setup, const char *out, pd_run_result *result)
{
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.folder = path_of(out);
    return pd_run(ctx, setup, &desc, result);
}

/* Reads and runs a scene; its setup is freed. */
static int play_text(const char *text, int threads, const char *out, pd_run_result *result)
{
    pd_ctx ctx;
    pd_setup u;
    memset(result, 0, sizeof *result);
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return 0;
    ctx.threads = threads;
    int done = CHECK_OK(&ctx, play(&ctx, &u, out, result));
    leave(&ctx, &u);
    return done;
}

/* ---- keys ---- */

TEST(every_key)
{
    pd_ctx ctx;
    pd_setup u;
    double c = 0.0;
    if (!CHECK_OK(
            &ctx,
            load(&ctx,
                 FLAT "[shape film] box = 0 .. 2 um" ACROSS(
                     "0 .. 4 um") "  kind = passive\n"
                                  "[corrode] rate = 1 um/s * (1 - C/Csat)  Cs = 140 mol/L  Csat = 5 mol/L  D = 7e-10 "
                                  "m2/s\n"
                                  "          initial = 1 mol/L  bulk = 10 mol/m3  driving_force = difference  kernel = "
                                  "inverse\n"
                                  "          weights = published  charge = 2.5\n"
                                  "          repassivation = 0.6*Csat  breaking = stochastic  seed = 12\n"
                                  "[run] until = 25 s  max_dissolved_fraction = 0.02  rtol = 2e-4  max_step = 0.25 s\n",
                 NULL, 0, &u)))
        return;
    CHECK(u.has_corrode && u.has_transport && u.has_dissolve && !u.has_flow && !u.activation);
    CHECK_REL(u.metal[0].solid_c, 140e3, 1e-15);
    CHECK_REL(u.saturation, 5e3, 1e-15);
    CHECK_REL(u.diffusivity, 7e-10, 1e-15);
    CHECK_REL(pd_expr_eval(&u.initial_c, NULL), 1e3, 1e-15);
    CHECK_REL(u.bulk_c, 10.0, 1e-15);
    CHECK_REL(u.max_node_fraction, 0.02, 1e-15);
    CHECK_REL(u.rtol, 2e-4, 1e-15);
    CHECK_REL(u.repassivation, 3e3, 1e-15);
    CHECK(u.stochastic && u.seed == 12);
    CHECK_REL(u.metal[0].material.charge, 2.5, 1e-15);
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &c), 1e-6, 1e-15);
    CHECK(u.drive == PD_DRIVE_DIFFERENCE && u.kernel == PD_KERNEL_INVERSE && u.weights == PD_WEIGHTS_PUBLISHED);
    CHECK(u.passive >= 0 && u.side[0].kind == PD_SIDE_WALL && u.side[0].has_fixed_c &&
          u.side[1].kind == PD_SIDE_MIRROR);
    const double origin[PD_DIM] = {0.0};
    CHECK_REL(pdi_setup_eval_expr(&u.side[0].fixed_c, origin, 0.0), 10.0, 1e-15);
    CHECK_REL(u.max_step, 0.25, 1e-15);
    leave(&ctx, &u);
}

/* i = z F Cs v, with the Cs of the scene. */
TEST(current_is_a_speed)
{
    pd_ctx ctx;
    pd_setup u;
    double c = 2.5e3;
    if (!CHECK_OK(&ctx, load(&ctx, FLAT "[corrode] current = 5 A/cm2 * (1 - C/Csat)  Cs = 143 mol/L  Csat = 5 mol/L\n"
                             "D = 1e-9 m2/s\n" END, NULL, 0, &u)))
        return;
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &c),
              2.5e4 / (2.19 * 96485.33212331001 * 143e3), 1e-12);
    leave(&ctx, &u);
}

TEST(refusals)
{
    static const char *const cases[][2] = {
        {"[transport] D = 1e-9 m2/s\n[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n",
         "found beside a [transport] section"},
        {"[dissolve] rate = 1 um/s\n[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n",
         "found beside [dissolve]"},
        {"[corrode] Csat = 5 mol/L  D = 1e-9 m2/s\n", "found no 'rate'"},
        {"[corrode] rate = 1 um/s  D = 1e-9 m2/s\n", "found no 'Csat'"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L\n", "found no 'D'"},
        {"[corrode] rate = 1 um/s  current = 1 A/m2  Csat = 5 mol/L  D = 1e-9 m2/s\n", "expected one of them"},
        {"[corrode] rate = -1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n", "expected 0 to 1 m/s"},
        {"[corrode] rate = 1 um/s  Csat = 500 mol/L  D = 1e-9 m2/s\n", "at most 142.805 kmol/m3"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  control = both\n", "diffusion, activation"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  grain_boundary_factor = 3\n", "without grains"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  initial = -1 mol/m3\n",
         "expected a value of at least 0"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  repassivation = 6 mol/L\n", "at most 5 kmol/m3"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  control = activation  repassivation = 3 mol/L\n",
         "found beside control = activation"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  breaking = random\n", "deterministic, stochastic"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  seed = 3\n", "found without breaking = stochastic"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  breaking = stochastic  seed = -1\n", "whole number"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  share = 0.1\n", "unknown key 'share'"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s  time = explicit\n", "unknown key 'time'"},
        {"[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n[run] until = 1 s  max_dissolved_fraction = 2\n",
         "at most 1"}};
    char text[1200];
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        snprintf(text, sizeof text, "%s%s%s", FLAT, cases[k][0], strstr(cases[k][0], "[run]") ? "" : END);
        refused(text, cases[k][1]);
    }
    refused(BOX METAL "\n[side x-] flow = open  C = 0\n[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n" END,
            "expected bulk in [corrode]");
    refused(BOX "[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n" END, "found no solid");
    refused(BOX METAL "\n[shape f] box = 0 .. 2 um" ACROSS("0 .. 4 um")
            "  kind = passive\n[transport] D = 1e-9 m2/s\n" END, "without a [corrode] section");
}

/* ---- fronts ---- */

/* Activation control: the metal that is gone grows by Cs v t, v by Faraday's law, and the front moves at v. */
TEST(front_moves_at_the_speed_of_the_current)
{
    const char *text = FLAT "[corrode] control = activation  current = 2.19 * F * Cs * 1 um/s  Cs = 143 mol/L\n"
                            "Csat = 5.1 mol/L\n"
                            "[total all]\n" END;
    pd_run_result r;
    pd_ctx ctx;
    if (!play_text(text, 1, "front", &r)) return;
    CHECK_LE(r.mass_balance_error, 1e-12);
    CHECK_REL(r.volume_loss, 25.0 / 32.0, 1e-2);
    CHECK(r.has_front);
    CHECK(r.corrosion_depth >= 24e-6 && r.corrosion_depth <= 26e-6 * (1.0 + 1e-6)); /* whole layers */
    pd_ctx_init(&ctx);
    double cross = PD_DIM == 1 ? 1.0 : PD_DIM == 2 ? 4e-6 : 16e-12;
    CHECK_REL(last_of(&ctx, "front/total_all.csv", PD_DIM == 1 ? "solid [mol/m2]" : PD_DIM == 2 ? "solid [mol/m]"
                      : "solid [mol]"), (1.0 - r.volume_loss) * 143e3 * 32e-6 * cross, 1e-9);
    CHECK_NEAR(last_of(&ctx, "front/diagnostics.csv", "front"), r.corrosion_depth, 1e-12);
    /* what turned fluid in the last step still holds its rest */
    CHECK(last_of(&ctx, "front/diagnostics.csv", "C_max") <= 5.1e3);
}

#define DIFFUSING "[corrode] rate = 1 um/s  Cs = 143 mol/L  Csat = 5.1 mol/L  D = 8.5e-10 m2/s\n"

/* A film in front of all metal leaves it as it is; half of a film leaves half of the front. */
TEST(films)
{
    pd_run_result open, closed;
    if (!play_text(FLAT DIFFUSING END, 1, "open", &open)) return;
    if (!play_text(FLAT "[shape film] box = -10 um .. 50 um" ACROSS("-10 um .. 50 um") "  kind = passive\n"
                   DIFFUSING END, 1, "closed", &closed))
        return;
    CHECK(open.volume_loss > 0.3);
    CHECK_NEAR(closed.volume_loss, 0.0, 1e-300);
    CHECK_LE(open.mass_balance_error, 1e-12);
#if PD_DIM == 2
    pd_run_result half;
    if (!play_text(FLAT "[side y-] flow = mirror\n[side y+] flow = mirror\n"
                   "[shape film] box = -10 um .. 50 um, 2 um .. 50 um  kind = passive\n" DIFFUSING END, 1, "half",
                   &half))
        return;
    CHECK(half.volume_loss > 0.2 * open.volume_loss && half.volume_loss < 0.9 * open.volume_loss);
#endif
}

/* The field at the start, held fluid behind the open side, and probes between nodes. */
TEST(initial_field_and_probe)
{
    const char *text = FLAT "[corrode] rate = 0 um/s  Csat = 5.1 mol/L  D = 8.5e-10 m2/s  bulk = 1 mol/L\n"
                            "initial = 1 mol/L + 100 mol/L * x/(1 m)\n"
                            "[probe a] at = 3.25 um" ACROSS("2 um") "\n"
                            "[line l] from = 1 um" ACROSS("2 um") "  to = 7 um" ACROSS("2 um") "  points = 3\n"
                            "[run] until = 1 ns\n[output] fields = C\n";
    pd_run_result r;
    pd_ctx ctx;
    if (!play_text(text, 1, "probe", &r)) return;
    pd_ctx_init(&ctx);
    CHECK_REL(last_of(&ctx, "probe/probes.csv", "a_C"), 1000.0 + 1e5 * 3.25e-6, 1e-9);
    CHECK_REL(last_of(&ctx, "probe/line_l_000000_t0.0s.csv", "C [mol/m3]"), 1000.0 + 1e5 * 7e-6, 1e-9);
}

TEST(threads_do_not_matter)
{
    static char kept[2][200000];
    size_t size[2] = {0, 0};
    for (int run = 0; run < 2; run++) {
        pd_run_result r;
        const char *out = run ? "two" : "one";
        char name[64];
        if (!play_text("[grid] h = 1 um  m = 3  box = 0 .. 24 um" ACROSS(
                           "0 .. 20 um") "\n"
                                         "[shape metal] box = 6 um .. 24 um" ACROSS(
                                             "0 .. 20 um") "  kind = solid  material = steel304  grain_size = 8 um\n"
                                                           "[side x-] flow = open\n[corrode] rate = 1 um/s  Csat = 5.1 "
                                                           "mol/L  D = 8.5e-10 m2/s"
                                                           "  grain_boundary_factor = 4\n[run] until = 2 s\n[output] "
                                                           "every = 2 s  fields = C, kind, density\n",
                       run ? 2 : 1, out, &r))
            return;
        CHECK(r.volume_loss > 0.0);
        CHECK_LE(r.mass_balance_error, 1e-12);
        snprintf(name, sizeof name, "%s/corr_000001_t2.0s.vti", out);
        FILE *file = fopen(path_of(name), "rb");
        if (!CHECK(file != NULL)) return;
        size[run] = fread(kept[run], 1, sizeof kept[run], file);
        fclose(file);
        CHECK(size[run] > 100 && size[run] < sizeof kept[run]);
    }
    CHECK(size[0] == size[1] && memcmp(kept[0], kept[1], size[0]) == 0);
}

/* Boundaries go faster: with all of the metal being boundary, by the factor. */
TEST(grains_dissolve_along_their_boundaries)
{
    pd_run_result with, plain;
    char text[1200];
    const char *law = "[corrode] control = activation  rate = 0.5 um/s  Csat = 5.1 mol/L  grain_boundary_factor = %d\n"
                      "[run] until = 20 s\n[output] every = 20 s  fields = C\n";
    char part[400];
    snprintf(part, sizeof part, law, 1);
    snprintf(text, sizeof text, BOX METAL "  grain_size = 4 um\n[side x-] flow = open\n%s", part);
    if (!play_text(text, 1, "plain", &plain)) return;
    snprintf(part, sizeof part, law, 4);
    snprintf(text, sizeof text, BOX METAL "  grain_size = 4 um\n[side x-] flow = open\n%s", part);
    if (!play_text(text, 1, "with", &with)) return;
    CHECK(with.volume_loss > 1.1 * plain.volume_loss && with.volume_loss < 4.0 * plain.volume_loss);
    CHECK_LE(with.mass_balance_error, 1e-12);
}

/* Random breaking: seeds, the balance with short steps and long ones, and damage as a field: whole metal has none, a
 * probe in the solution reads 1. */
TEST(bonds_that_break_at_random)
{
    double lost[4];
    for (int run = 0; run < 4; run++) {
        char text[1200];
        pd_run_result r;
        pd_ctx ctx;
        snprintf(text, sizeof text, FLAT "[corrode] rate = 1 um/s  Csat = 5.1 mol/L  D = 1e-10 m2/s  breaking = %s"
                 "\n[run] until = 4 s%s\n[output] every = 2 s  fields = C, damage\n"
                 "[probe deep] at = 30 um" ACROSS("2 um") "  fields = damage\n"
                 "[probe before] at = 2 um" ACROSS("2 um") "  fields = damage\n",
                 run == 3 ? "deterministic" : run == 2 ? "stochastic  seed = 2" : "stochastic",
                 run == 1 ? "" : "  fraction = 0.02");
        if (!play_text(text, 1, "random", &r)) return;
        CHECK_LE(r.mass_balance_error, 1e-12);
        lost[run] = r.volume_loss;
        pd_ctx_init(&ctx);
        CHECK_NEAR(last_of(&ctx, "random/probes.csv", "deep_damage"), 0.0, 0.0);
        CHECK_NEAR(last_of(&ctx, "random/probes.csv", "before_damage"), 1.0, 0.0);
    }
    NOTE("loss %.5f, long steps %.5f, another seed %.5f, deterministic %.5f", lost[0], lost[1], lost[2], lost[3]);
    CHECK_REL(lost[1], lost[0], 0.1);
    CHECK(fabs(lost[2] - lost[0]) > 1e-9 * lost[0] && fabs(lost[3] - lost[0]) > 1e-9 * lost[0]);
}

/* ---- streams and axes ---- */

#if PD_DIM > 1
#define BODY \
    "[grid] h = 2 um  m = 2  box = 0 .. 48 um" ACROSS("0 .. 24 um") "\n" \
    "[shape body] box = 16 um .. 28 um" ACROSS("8 um .. 16 um") "  kind = solid  material = steel304\n"
#define SALT_LAW "[corrode] Cs = 143 mol/L  Csat = 5.1 mol/L  D = 1e-10 m2/s  rate = %s\n"
#define SHORT (PD_DIM == 2 ? "1 s" : "0.3 s") /* some metal is left */
#define WATCHED "[run] until = %s\n[output] every = 1 s  fields = C, kind\n[plane down] at = x 40 um\n[total all]\n"
#define STREAM \
    "[side x-] flow = inlet  profile = uniform  mean = 0.1 mm/s  C = 0\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"

/* A stream past a body carries off what lies before it: more is lost than where the ends of the channel hold fresh
 * fluid at rest, by a smooth law and by one that jumps, and all of it is accounted for. */
TEST(in_a_stream)
{
    static const char *const laws[3] = {"10 um/s * (1 - C/Csat)", "10 um/s", "10 um/s * (0.1 + 0.9*(C < 0.5*Csat))"};
    for (int law = PD_DIM == 3 ? 2 : 0; law < 3; law++) { /* in 3D they take 20 s each */
        double lost[2];
        for (int stream = 0; stream < 2; stream++) {
            char text[1600], part[400];
            pd_run_result r;
            snprintf(part, sizeof part, SALT_LAW WATCHED, laws[law], SHORT);
            snprintf(text, sizeof text, BODY "%s%s",
                     stream ? STREAM : "[side x-] flow = open\n[side x+] flow = open\n", part);
            if (!play_text(text, 1, "stream", &r)) return;
            CHECK_LE(r.mass_balance_error, 1e-12);
            CHECK_INT(r.unconverged_steps, 0);
            lost[stream] = r.volume_loss;
        }
        NOTE("%s: at rest %.4f, in a stream %.4f of the metal", laws[law], lost[0], lost[1]);
        CHECK(lost[0] > 0.01 && lost[1] > 1.2 * lost[0] && lost[1] < 1.0);
    }
}

TEST(refused_in_a_stream)
{
    refused(BODY STREAM "[corrode] Csat = 5 mol/L  rate = 1 um/s  control = activation\n[run] until = 1 s\n",
            "found 'activation' beside [flow]");
    refused(BODY STREAM "[corrode] Csat = 5 mol/L  rate = 1 um/s  D = 1e-9 m2/s  kernel = square  weights = published\n"
                        "[run] until = 1 s\n",
            "found 'published' beside [flow]");
}
#endif

#if PD_DIM == 2
/* A wire around the axis whose law holds at every concentration loses 1 - (1 - v t/R)^2, in fluid that takes all. Nodes
 * of a layer that is not flat turn one by one: of first order in h/R. */
TEST(around_an_axis)
{
    double off[2];
    for (int fine = 0; fine < 2; fine++) {
        char text[1200];
        pd_run_result r;
        snprintf(text, sizeof text,
                 "[grid] geometry = axisymmetric  h = %s  m = 3  box = 0 .. 8 um, 0 .. 48 um\n"
                 "[shape wire] box = -20 um .. 30 um, -24 um .. 24 um  kind = solid  material = steel304\n"
                 "[side x-] flow = mirror\n[side x+] flow = mirror\n[side y+] flow = open\n"
                 "[corrode] Cs = 143 mol/L  Csat = 5.1 mol/L  D = 1e-6 m2/s  rate = 1 um/s\n"
                 "[run] until = 12 s\n[output] every = 12 s  fields = C, kind\n", fine ? "0.5 um" : "1 um");
        if (!play_text(text, 1, "wire", &r)) return;
        off[fine] = r.volume_loss / (1.0 - 0.5 * 0.5) - 1.0;
        NOTE("h = %s: loss %.5f, off by %.2e", fine ? "0.5 um" : "1 um", r.volume_loss, off[fine]);
        CHECK_LE(r.mass_balance_error, 1e-12);
    }
    CHECK_LE(fabs(off[0]), 1.0 / 24.0);
    CHECK_LE(fabs(off[1]), 0.6 * fabs(off[0]));
}
#endif

#if PD_DIM == 1
#define OF_DIM
#elif PD_DIM == 2
#define OF_DIM SLOW_ENTRY_IF(PD_DIM == 3, in_a_stream) ENTRY(refused_in_a_stream) ENTRY(around_an_axis)
#else
#define OF_DIM SLOW_ENTRY_IF(PD_DIM == 3, in_a_stream) ENTRY(refused_in_a_stream)
#endif

TEST_MAIN(ENTRY(every_key) ENTRY(current_is_a_speed) ENTRY(refusals) ENTRY(front_moves_at_the_speed_of_the_current)
              ENTRY(films) ENTRY(initial_field_and_probe) SLOW_ENTRY_IF(PD_DIM == 3, threads_do_not_matter)
                  ENTRY(grains_dissolve_along_their_boundaries) ENTRY(bonds_that_break_at_random) OF_DIM)
