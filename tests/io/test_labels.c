/* labels: of pictures of runs as SVG: each stands where its value belongs, on the axes and on the bar of colours.
 * dims: 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"

enum { LABELS = 100 };

typedef struct label {
    double x, y;
    char text[240];
} label;

static struct picture {
    label label[LABELS];
    int count;
    double left, top, width, height; /* [pixel] of the image of the field */
    char all[4000000];
} P;

/* Of the case, where it is not that of the file. */
static char case_name[PD_SETUP_NAME];

/* The picture NAME of the run of `text`; 0: there is none. */
static int picture(const char *text, const char *name)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result result;
    memset(&desc, 0, sizeof desc);
    memset(&P, 0, sizeof P);
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return 0;
    desc.folder = path_of(case_name[0] ? "long" : "run");
    if (case_name[0]) memcpy(u.name, case_name, sizeof u.name);
    int done = CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &result));
    leave(&ctx, &u);
    char path[600];
    snprintf(path, sizeof path, "%s/%s", desc.folder, name);
    FILE *file = done ? fopen(path, "rb") : NULL;
    if (!CHECK(file != NULL)) return 0;
    size_t size = fread(P.all, 1, sizeof P.all - 1, file);
    fclose(file);
    P.all[size] = '\0';
    for (const char *at = P.all; (at = strstr(at, "<text ")) != NULL && P.count < LABELS; at++) {
        label *l = &P.label[P.count];
        const char *turned = strstr(at, "rotate"), *end = strchr(at, '>');
        if (sscanf(at, "<text x=\"%lf\" y=\"%lf\"", &l->x, &l->y) != 2 || !end) continue;
        if (turned && turned < end) l->x = l->y = -1.0; /* stands upright */
        snprintf(l->text, sizeof l->text, "%.*s", (int)strcspn(end + 1, "<"), end + 1);
        P.count++;
    }
    const char *image = strstr(P.all, "<image ");
    return CHECK(image != NULL) && CHECK_INT(sscanf(image, "<image x=\"%lf\" y=\"%lf\" width=\"%lf\" height=\"%lf\"",
                                                    &P.left, &P.top, &P.width, &P.height), 4);
}

static const label *label_of(const char *text)
{
    for (int k = 0; k < P.count; k++)
        if (strcmp(P.label[k].text, text) == 0) return &P.label[k];
    CHECK_STR("no label", text);
    return NULL;
}

static int number_of(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == '\0';
}

/* Labels below the image stand for lo + (hi - lo) (x - left)/width, those left of it likewise up; at least `least` of
 * each. */
static void axes(double lo0, double hi0, double lo1, double hi1, int least)
{
    int halves = lo1 < 0.0; /* distances from an axis in the middle */
    int below = 0, beside = 0;
    double bottom = P.top + P.height;
    for (int k = 0; k < P.count; k++) {
        double value;
        const label *l = &P.label[k];
        if (!number_of(l->text, &value)) continue;
        if (l->y > bottom + 10.0 && l->x >= P.left - 1.0 && l->x < P.left + P.width + 2.0) {
            CHECK_NEAR(l->x, P.left + (value - lo0) / (hi0 - lo0) * P.width, 1.5);
            below++;
        } else if (l->x < P.left && l->x > 0.0) {
            if (halves && l->y - 7.0 > P.top + 0.5 * P.height) value = -value;
            CHECK_NEAR(l->y - 7.0, bottom - (value - lo1) / (hi1 - lo1) * P.height, 1.5); /* 7: half of a digit */
            beside++;
        }
    }
    CHECK(below >= least && beside >= least);
}

/* Labels of the bar, which is as high as the image, from lo to hi, by their logarithm or not. */
static void bar(double lo, double hi, int logarithm, int least)
{
    int seen = 0;
    double bottom = P.top + P.height;
    for (int k = 0; k < P.count; k++) {
        double value, share;
        const label *l = &P.label[k];
        if (l->x < P.left + P.width + 20.0 || l->y < P.top || l->y > bottom + 9.0) continue;
        if (!number_of(l->text, &value)) continue;
        share = logarithm ? log(value / lo) / log(hi / lo) : (value - lo) / (hi - lo);
        CHECK(share > -1e-6 && share < 1.0 + 1e-6);
        CHECK_NEAR(l->y - 7.0, bottom - share * P.height, 1.5);
        seen++;
    }
    CHECK(seen >= least);
}

/* A field that is linear in the cells: 1 from cell to cell along the first axis of the picture, 2 along the second. */
#if PD_DIM == 2
#define FIELD \
    "[grid] h = 1 mm, 0.5 mm  box = -10 mm .. 30 mm, 5 mm .. 25 mm\n" \
    "[transport] D = 1e-12 m2/s  initial = (1 + (x + 10 mm) / 1 mm + 2 * (y - 5 mm) / 0.5 mm) * 1 mol/m3\n" \
    "[run] until = 0.2 s\n[output] every = 0.1 s  fields = none  images = C  format = svg  width = 400  "
#else
#define FIELD \
    "[grid] h = 1 mm, 0.5 mm, 2 mm  box = -10 mm .. 30 mm, 5 mm .. 25 mm, 0 .. 8 mm\n" \
    "[transport] D = 1e-12 m2/s  initial = (1 + (x + 10 mm) / 1 mm + 2 * (y - 5 mm) / 0.5 mm) * 1 mol/m3\n" \
    "[run] until = 0.2 s\n" \
    "[output] every = 0.1 s  fields = none  images = C  format = svg  width = 400  slice = z 4 mm  "
#endif

/* 40 and 40 cells: from 1 + 0.5 + 1 to 1 + 39.5 + 79. */
static const double low = 2.5, high = 119.5;

TEST(axes_and_bars)
{
    if (!picture(FIELD "\n", "C_000002_t0.2s.svg")) return;
    axes(-10.0, 30.0, 5.0, 25.0, 3);
    bar(low, high, 0, 2);
    const label *time = label_of("t = 200 ms");
    CHECK(time && time->y < P.top);
    CHECK(label_of("x [mm]") && label_of("y [mm]") && label_of("C [mol/m\xc2\xb3]"));
    if (!picture(FIELD "range = C -20 mol/m3 .. 180 mol/m3\n", "C_000001_t0.1s.svg")) return;
    axes(-10.0, 30.0, 5.0, 25.0, 3);
    bar(-20.0, 180.0, 0, 4);
    if (!picture(FIELD "log_scale = C\n", "C_000000_t0.0s.svg")) return;
    bar(low, high, 1, 1);
    if (!picture(FIELD "log_scale = C  range = C 1e-3 mol/m3 .. 1e3 mol/m3\n", "C_000000_t0.0s.svg")) return;
    bar(1e-3, 1e3, 1, 2);
}

/* The middle half of the values: ranks a quarter and three quarters of the way, between two of them linear. */
TEST(percentiles)
{
    if (!picture(FIELD "percentile = 50 %\n", "C_000002_t0.2s.svg")) return;
    double sorted[1600], rank = 0.25 * 1599.0;
    int count = 0;
    for (int i = 0; i < 40; i++)
        for (int j = 0; j < 40; j++) {
            double value = low + i + 2.0 * j;
            int k = count++;
            for (; k > 0 && sorted[k - 1] > value; k--) sorted[k] = sorted[k - 1];
            sorted[k] = value;
        }
    int below = (int)rank, above = (int)(1599.0 - rank);
    double part = rank - below, lo = sorted[below] + part * (sorted[below + 1] - sorted[below]);
    part = 1599.0 - rank - above;
    double hi = sorted[above] + part * (sorted[above + 1] - sorted[above]);
    bar(lo, hi, 0, 2);
}

#if PD_DIM == 2
/* Both halves of a body of revolution are drawn: the axis stands in the middle. */
TEST(two_halves)
{
    static const char *const text =
        "[grid] h = 1 mm  box = 0 .. 40 mm, 0 .. 10 mm  geometry = axisymmetric\n[side y-] flow = mirror\n"
        "[transport] D = 1e-9 m2/s  initial = (1 + y / 1 mm) * 1 mol/m3\n[run] until = 1e-3 s\n"
        "[output] every = 1e-3 s  fields = none  images = C  format = svg  width = 400\n";
    if (!picture(text, "C_000000_t0.0s.svg")) return;
    CHECK_NEAR(P.width, 2.0 * P.height, 1.0);
    axes(0.0, 40.0, -10.0, 10.0, 3);
    bar(1.5, 10.5, 0, 3);
}
#endif

#if PD_DIM == 2
/* The range of a logarithm begins with the least value above zero, any other one with the least. Between two plates
 * phi = x/1 mm - 15 V, in cells from 1.5 mm to 38.5 mm. */
TEST(values_below_zero)
{
#define PLATES \
    "[grid] h = 1 mm  box = 0 .. 40 mm, 0 .. 20 mm\n[side y-] flow = mirror\n[side y+] flow = mirror\n" \
    "[shape a] box = 0 .. 1 mm, 0 .. 20 mm  kind = solid  material = mg4ag\n" \
    "[shape b] box = 39 mm .. 40 mm, 0 .. 20 mm  kind = solid  material = copper\n[potential] conductivity = 1 S/m\n" \
    "[electrode a] shape = a  curve = primary  potential = -14 V\n" \
    "[electrode b] shape = b  curve = primary  potential = 24 V\n" \
    "[output] fields = none  images = phi  format = svg  width = 400  "
    if (!picture(PLATES "\n", "phi_000000_t0.0s.svg")) return;
    bar(-13.5, 23.5, 0, 2);
    if (!picture(PLATES "log_scale = phi\n", "phi_000000_t0.0s.svg")) return;
    bar(0.5, 23.5, 1, 2);
    if (!picture(PLATES "log_scale = phi  percentile = 50 %\n", "phi_000000_t0.0s.svg")) return;
    bar(6.25, 17.75, 1, 1); /* each value stands in a column of 20 cells */
}
#endif

/* The title holds the longest name of a case, the field and, where it is a section, its place, or the displacements. */
TEST(long_titles)
{
    char title[200];
    memset(case_name, 'W', sizeof case_name - 1);
#if PD_DIM == 2
    static const char *const text =
        "[grid] h = 1 mm  box = 0 .. 20 mm, 0 .. 10 mm\n[shape s] box = 0 .. 20 mm, 0 .. 10 mm  kind = solid\n"
        "[solid] E = 200 GPa  nu = 0.3  plane = stress\n[side x-] ux = 0 mm  uy = 0 mm\n"
        "[side x+] ux = 1 nm  uy = 0 mm\n"
        "[output] fields = none  images = mises  format = svg  width = 400  deformation_scale = 123456\n";
    snprintf(title, sizeof title, "%s: mises, displacements \xC3\x97 123456", case_name);
    if (picture(text, "mises_000000_t0.0s.svg")) CHECK(label_of(title) != NULL);
#else
    snprintf(title, sizeof title, "%s: C at z = 4 mm", case_name);
    if (picture(FIELD "\n", "C_000000_t0.0s.svg")) CHECK(label_of(title) != NULL);
#endif
    memset(case_name, 0, sizeof case_name);
}

#if PD_DIM == 3
/* The axes of a slice are the other two. */
TEST(slices)
{
    static const char *const slice[] = {"slice = x 12 mm\n", "slice = y 7 mm\n", "slice = z 3 mm\n"};
    static const double lo[3] = {-10.0, 5.0, 0.0}, hi[3] = {30.0, 25.0, 12.0};
    for (int axis = 0; axis < 3; axis++) {
        char text[600];
        int right = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
        snprintf(text, sizeof text, "[grid] h = 2 mm  box = -10 mm .. 30 mm, 5 mm .. 25 mm, 0 .. 12 mm\n"
                 "[transport] D = 1e-12 m2/s\n"
                 "initial = ((x + 10 mm) / 2 mm + 30 * (y - 5 mm) / 2 mm + 500 * z / 2 mm) * 1 mM\n"
                 "[run] until = 1e-3 s\n"
                 "[output] every = 1e-3 s  fields = none  images = C  format = svg  width = 400  %s",
                 slice[axis]);
        if (!picture(text, "C_000000_t0.0s.svg")) return;
        axes(lo[right], hi[right], lo[up], hi[up], 3);
        static const double rise[3] = {1.0, 30.0, 500.0}, at[3] = {11.5, 1.5, 1.5};
        double from = rise[axis] * at[axis] + 0.5 * (rise[right] + rise[up]);
        double across = (hi[right] - lo[right]) / 2.0 - 1.0, above = (hi[up] - lo[up]) / 2.0 - 1.0;
        double to = from + rise[right] * across + rise[up] * above;
        bar(from, to, 0, 2);
        CHECK(label_of(right ? "y [mm]" : "x [mm]") && label_of(up == 1 ? "y [mm]" : "z [mm]"));
    }
}
TEST_MAIN(ENTRY(axes_and_bars) ENTRY(percentiles) ENTRY(slices) ENTRY(long_titles))
#else
TEST_MAIN(ENTRY(axes_and_bars) ENTRY(percentiles) ENTRY(two_halves) ENTRY(values_below_zero)
          ENTRY(long_titles))
#endif
