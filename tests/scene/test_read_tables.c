/* [table NAME] of a scene: columns and units, functions in every expression, messages, the run with such a law.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"

#if PD_DIM == 1
#define ACROSS(range)
#else
#define ACROSS(range) ", " range
#endif

#define BOX "[grid] h = 1 um  m = 3  box = 0 .. 30 um" ACROSS("0 .. 4 um") "\n"
#define METAL "[shape metal] box = 8 um .. 30 um" ACROSS("0 .. 4 um") "  kind = solid  material = steel304\n"
#define SIDES "[side x-] flow = open\n[side x+] flow = mirror\n"
#define END "[run] until = 4 s\n[output] every = 2 s\n"
#define CORRODE "[corrode] Csat = 5.6 mol/L  Cs = 140 mol/L  D = 7.2e-10 m2/s  "

static void put_text(const char *name, const char *text) { put(name, text, strlen(text)); }

/* The examples hold the published figures of alloy 625; a table of a scene gives the closed form that they came from:
 * at them to their five digits, between them to the interpolation. ln i rises by g = 0.51 over the last piece, where
 * the slope of the parabola at the end is off by g^3/3 of i/h: 4/27 g^3/3 = 0.7 % of i at the end, 0.9 % in the piece.
 * Slopes of inner points are off by half of that. */
TEST(crevice_data)
{
    char *bytes = NULL;
    size_t size = 0;
    pd_ctx ctx;
    pd_setup u;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, "examples/scenes/crevice_625.csv", 1 << 16, &bytes, &size))) return;
    put("crevice.csv", bytes, size);
    PD_DELETE(&ctx, size + 1, bytes);
    if (!CHECK_OK(&ctx, load(&ctx, "[table iC] file = crevice.csv  x = C_mol_per_L in mol/L  y = i_A_per_m2 in A/m2\n"
                             BOX METAL SIDES CORRODE "current = iC(C)\n" END, NULL, 0, &u)))
        return;
    double at_points = 0.0, between = 0.0, last = 0.0;
    for (int k = 0; k <= 560; k++) {
        double c = 10.0 * k, pH = 7.405 * exp(-0.08036 * 1e-3 * c) - 6.498; /* C in mol/L */
        double i = 1e4 * pow(10.0, 1.151 * exp(-0.723 * pH) - 7.647);
        double error = fabs(pd_expr_eval(&u.metal[0].rate, &c) / i - 1.0);
        if (k % 20 == 0) at_points = fmax(at_points, error);
        else if (k < 540) between = fmax(between, error);
        else last = fmax(last, error);
    }
    NOTE("relative error %.3g at the points, %.3g between, %.3g in the last piece", at_points, between, last);
    CHECK_LE(at_points, 5e-5);
    CHECK_LE(between, 4.5e-3);
    CHECK_LE(last, 9e-3);
    double beyond = 1e4, before = -1.0;
    CHECK_REL(pd_expr_eval(&u.metal[0].rate, &beyond), 3.2422, 1e-15); /* the end values hold */
    CHECK_REL(pd_expr_eval(&u.metal[0].rate, &before), 8.9212e-4, 1e-15);
    leave(&ctx, &u);
}

/* One table or two, columns by number, in numbers, places and laws; commands replace the file. */
TEST(in_every_expression)
{
    static const char *const other[1] = {"table.f.file=double.csv"};
    const char *text = "[table f] file = line.csv  x = 1 in mm  y = size in um\n"
                       "[table g] file = line.csv  x = time [s\n";
    pd_ctx ctx;
    pd_setup u;
    double c = 1e3;
    put_text("line.csv", "# a line\n\"length [mm]\", size,none\n\n0,0,1\n2,20,1\r\n4,40,1\n");
    put_text("double.csv", "\"length [mm]\",size\n0,0\n4,80\n");
    refused(text, "a.scene:2");
    text = "[table f] file = line.csv  x = 1 in mm  y = size in um\n"
           "[table g] file = line.csv  x = size  y = 1\n"
           "[grid] h = f(0.1 mm)  m = 3  box = 0 .. f(3 mm)" ACROSS("0 .. 4 um") "\n" METAL SIDES
           "[corrode] Csat = 5 mol/L  D = 1e-9 m2/s  rate = f(C/Csat * 1 mm)/s + 0.1*f(1 mm)*(g(5) < 0.6)/s\n"
           "initial = 1 mol/L * g(10*x/(10 um))\n" END;
    for (int k = 0; k < 2; k++) {
        double factor = k ? 2.0 : 1.0, x[3] = {5e-6, 0.0, 0.0};
        if (!CHECK_OK(&ctx, load(&ctx, text, other, 0, &u))) return;
        pd_setup_free(&ctx, &u);
        if (k == 0) CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u));
        else CHECK_OK(&ctx, load(&ctx, "[table f] file = line.csv  x = 1 in mm  y = size in um\n"
                                 "[table g] file = line.csv  x = size  y = 1\n" BOX METAL SIDES
                                 "[corrode] Csat = 5 mol/L  D = 1e-9 m2/s\n"
                                 "rate = f(C/Csat * 1 mm)/s + 0.1*f(1 mm)*(g(5) < 0.6)/s\n"
                                 "initial = 1 mol/L * g(10*x/(10 um))\n" END, other, 1, &u));
        CHECK_REL(u.h[0], 1e-6, 1e-12);
        CHECK_REL(u.hi[0], 30e-6, 1e-12);
        CHECK_REL(pd_expr_eval(&u.metal[0].rate, &c), factor * (2e-6 + 1e-6), 1e-12);
        CHECK_REL(pd_expr_eval(&u.initial_c, x), 1e3 * 0.5, 1e-12);
        leave(&ctx, &u);
    }
}

TEST(messages)
{
    static const struct {
        const char *csv, *section, *part;
    } list[] = {
        {"C,i\n0,1\n1,2\n", "[table] file = t.csv  x = C  y = i", "a.scene:1: table: found the name ''"},
        {"C,i\n0,1\n1,2\n", "[table exp] file = t.csv  x = C  y = i", "found the name 'exp', expected"},
        {"C,i\n0,1\n1,2\n", "[table pi] file = t.csv  x = C  y = i", "found the name 'pi'"},
        {"C,i\n0,1\n1,2\n", "[table Csat] file = t.csv  x = C  y = i", "found the name 'Csat'"},
        {"C,i\n0,1\n1,2\n", "[table x-] file = t.csv  x = C  y = i", "expected a short word of letters"},
        {"C,i\n0,1\n1,2\n", "[table f] x = C  y = i", "found no 'file' in [table f]"},
        {"C,i\n0,1\n1,2\n", "[table f] file = t.csv  y = i", "found no 'x' in [table f]"},
        {"C,i\n0,1\n1,2\n", "[table f] file = none.csv  x = C  y = i", "a.scene:1: file: file: cannot open"},
        {"C,i\n0,1\n1,2\n", "[table f] file = t.csv  x = c  y = i", "a.scene:1: x: found 'c', expected a column of"},
        {"C,i\n0,1\n1,2\n", "[table f] file = t.csv  x = 3  y = i", "t.csv: C, i"},
        {"C,i\n0,1\n1,2\n", "[table f] file = t.csv  x = C in mol/Li  y = i", "x: found 'mol/Li', expected a unit"},
        {"C,i\n0,1\n1,2\n", "[table f] file = t.csv  x = C  y = i  outside = NaN", "expected one of hold, error"},
        {"C,i\n0,1\n1,2\n", "[table f] file = t.csv  x = C  y = i  order = 3", "expected one of file, x, y, outside"},
        {"C,i\n0,1\n\n1,two\n", "[table f] file = t.csv  x = C  y = i", "t.csv:4: column 'i': 'two' is not a number"},
        {"C,i\n0,1\n1\n", "[table f] file = t.csv  x = C  y = i", "t.csv:3: 1 fields, expected 2"},
        {"C,i\n0,1\n# off\n2,1\n1,2\n", "[table f] file = t.csv  x = C  y = i",
         "t.csv:5: found x = 1, y = 2 behind x = 2, y = 1, expected ascending values"},
        {"C,i\n0,1\n0,2\n", "[table f] file = t.csv  x = C  y = i", "t.csv:3: found x = 0"},
        {"C,i\n0,1\n1,inf\n", "[table f] file = t.csv  x = C  y = i", "t.csv:3: found x = 1, y = inf behind"},
        {"C,i\n0,1\n", "[table f] file = t.csv  x = C  y = i", "file: curve: found 1 point, expected at least 2"},
        {"C,i\n", "[table f] file = t.csv  x = C  y = i", "found 0 points, expected at least 2"},
        {"", "[table f] file = t.csv  x = C  y = i", "t.csv: no line of column names"}};
    static const char *const uses[][2] = {
        {"f(C)", "found a concentration [mol/m3], expected a plain number as the argument of f"},
        {"f(1) * 1", "found a plain number"},
        {"f(1, 2)", "expected ')' (f takes 1 argument)"},
        {"f * 1 m/s", "found the function 'f', expected '(' after it"},
        {"ff(1) * 1 m/s", "found 'ff', expected a known variable, constant or function"}};
    char text[1200];
    for (size_t k = 0; k < sizeof list / sizeof list[0]; k++) {
        put_text("t.csv", list[k].csv);
        snprintf(text, sizeof text, "%s\n" BOX METAL SIDES CORRODE "rate = 1 um/s\n" END, list[k].section);
        refused(text, list[k].part);
    }
    put_text("t.csv", "C,i\n0,1\n1,2\n");
    for (size_t k = 0; k < sizeof uses / sizeof uses[0]; k++) {
        snprintf(text, sizeof text, "[table f] file = t.csv  x = C  y = i\n" BOX METAL SIDES CORRODE "rate = %s\n" END,
                 uses[k][0]);
        refused(text, k == 1 ? "found a number without unit, expected a speed" : uses[k][1]);
    }
}

/* A law from a table that is a line gives the run of the line itself; outside of it the run ends with a message. */
TEST(run_with_a_table)
{
    double loss[2] = {0.0, 0.0};
    put_text("line.csv", "C,i\n-1,1.2\n0,1\n1,0.8\n2.5,0.5\n5.6,-0.12\n");
    put_text("short.csv", "C,i\n0,1\n0.5,0.9\n");
    for (int k = 0; k < 3; k++) {
        const char *laws[3] = {"1 um/s * (1 - 0.2*C/(1 mol/L))", "f(C)", "f(C)"};
        char text[1200];
        pd_run_desc desc;
        pd_run_result result;
        pd_ctx ctx;
        pd_setup u;
        memset(&desc, 0, sizeof desc);
        desc.folder = path_of("out");
        snprintf(text, sizeof text, "[table f] file = %s  x = C in mol/L  y = i in um/s  outside = error\n" BOX METAL
                 SIDES CORRODE "rate = %s\n" END, k < 2 ? "line.csv" : "short.csv", laws[k]);
        if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
        pd_status status = pd_run(&ctx, &u, &desc, &result);
        CHECK_INT(status, k < 2 ? PD_OK : PD_ERR_STATE);
        if (k == 2 && !CHECK(strstr(ctx.message, "the rate law gives") != NULL)) NOTE("%s", ctx.message);
        if (k < 2) loss[k] = result.volume_loss;
        if (k < 2) CHECK_LE(result.mass_balance_error, 1e-12);
        leave(&ctx, &u);
    }
    CHECK(loss[0] > 0.0);
    CHECK_REL(loss[1], loss[0], 1e-9); /* laws that differ by rounding; steps are solved to that */
}

TEST_MAIN(ENTRY(crevice_data) ENTRY(in_every_expression) ENTRY(messages) ENTRY(run_with_a_table))
