/* field_plot: ticks, printed units, pictures of fields, plots. */
/* dims: 2 */
#include "io/apng.h"
#include "io/axis_ticks.h"
#include "io/colour.h"
#include "io/file.h"
#include "io/canvas.h"
#include "io/unit_label.h"
#include "io/field_plot.h"
#include "io/plot.h"
#include "fault.h"

#define DIRECTORY "build/files_of_test_picture"

static void start(pd_ctx *ctx)
{
    pd_ctx_init(ctx);
    CHECK_OK(ctx, pd_file_make_directory(ctx, DIRECTORY));
}

/* A range without ends that are numbers, or of a few roundings, has no ticks. */
TEST(ranges_without_ticks)
{
    static const double inf = (double)INFINITY, none = (double)NAN;
    const double ends[][2] = {{0.0, inf},  {-inf, 1.0},  {-inf, inf}, {1.0, inf}, {inf, inf},          {none, 1.0},
                              {1.0, none}, {none, none}, {2.0, 1.0},  {1.0, 1.0}, {1.0, 1.0 + 4.5e-16}},
                 not_positive[][2] = {{0.0, 1.0}, {-1.0, 10.0}, {-10.0, -1.0}, {0.0, 0.0}};
    pdi_axis_ticks axis;
    memset(&axis, 0, sizeof axis);
    for (size_t k = 0; k < 2 * (sizeof ends / sizeof ends[0]); k++) {
        axis.log = (int)(k % 2);
        axis.lo = ends[k / 2][0];
        axis.hi = ends[k / 2][1];
        axis.count = axis.exponent = 7;
        pdi_axis_ticks_compute(8, &axis);
        CHECK_INT(axis.count, 0);
        CHECK_INT(axis.exponent, 0);
    }
    axis.log = 1;
    for (size_t k = 0; k < sizeof not_positive / sizeof not_positive[0]; k++) {
        axis.lo = not_positive[k][0];
        axis.hi = not_positive[k][1];
        pdi_axis_ticks_compute(8, &axis);
        CHECK_INT(axis.count, 0);
    }
}

TEST(ticks_are_round_numbers)
{
    pdi_axis_ticks axis;
    memset(&axis, 0, sizeof axis);
    axis.lo = -80;
    axis.hi = 480;
    pdi_axis_ticks_compute(10, &axis);
    CHECK_INT(axis.count, 5);
    CHECK_STR(axis.label[0], "0");
    CHECK_STR(axis.label[4], "400");
    axis.lo = 0;
    axis.hi = 3.1e-4;
    pdi_axis_ticks_compute(4, &axis);
    CHECK_INT(axis.exponent, -6);
    CHECK_STR(axis.label[axis.count - 1], "300");
    axis.lo = 99.95;
    axis.hi = 100.05;
    pdi_axis_ticks_compute(5, &axis);
    CHECK_STR(axis.label[0], "99.96");
    CHECK_INT(axis.count, 5);
    for (int k = 0; k < 400; k++) { /* any range: enough ticks, all inside, steps 1, 2 or 5 */
        axis.lo = (k % 7 - 3) * pow(10, k % 23 - 11);
        axis.hi = axis.lo + pow(1.37, k % 61 - 30);
        pdi_axis_ticks_widen_range(0, &axis);
        pdi_axis_ticks_compute(8, &axis);
        if (!CHECK(axis.count >= 2 && axis.count <= 9)) NOTE("%g .. %g: %d ticks", axis.lo, axis.hi, axis.count);
        double step = axis.value[1] - axis.value[0], mantissa = step / pow(10, floor(log10(step) + 1e-6));
        CHECK(fabs(mantissa - 1) < 1e-4 || fabs(mantissa - 2) < 1e-4 || fabs(mantissa - 5) < 1e-4);
        CHECK(axis.value[0] >= axis.lo - 1e-5 * step && axis.value[axis.count - 1] <= axis.hi + 1e-5 * step);
        for (int j = 1; j < axis.count; j++) CHECK(strcmp(axis.label[j], axis.label[j - 1]) != 0);
    }
    axis.log = 1;
    axis.lo = 1e-6;
    axis.hi = 1e-2;
    pdi_axis_ticks_compute(8, &axis);
    CHECK_STR(axis.label[0], "10\xE2\x81\xBB\xE2\x81\xB6");
    CHECK_STR(axis.label[axis.count - 1], "10\xE2\x81\xBB\xC2\xB2");
    CHECK_NEAR(pdi_axis_ticks_value_to_fraction(&axis, 1e-4), 0.5, 1e-12);
    axis.lo = 1e-300;
    axis.hi = 1e300;
    CHECK_NEAR(pdi_axis_ticks_value_to_fraction(&axis, 1.0), 0.5, 1e-12);
    for (int k = 0; k < 600; k++) { /* any range: labels enough, in order, inside */
        axis.lo = pow(10, k % 64 * 9 - 300);
        axis.hi = axis.lo * pow(10, 0.01 + k % 29);
        pdi_axis_ticks_compute(8, &axis);
        int named = 0;
        for (int j = 0; j < axis.count; j++) {
            named += axis.label[j][0] != 0;
            CHECK(pdi_axis_ticks_value_to_fraction(&axis, axis.value[j]) > -1e-6 &&
                  pdi_axis_ticks_value_to_fraction(&axis, axis.value[j]) < 1 + 1e-6);
            CHECK(j == 0 || axis.value[j] > axis.value[j - 1]);
        }
        if (!CHECK(named >= 2 && named <= 10)) NOTE("%g .. %g: %d labels", axis.lo, axis.hi, named);
    }
}

TEST(units_are_printed)
{
    static const char *const pairs[][2] = {
        {"C [mol/m3]", "C [mol/m\xC2\xB3]"}, {"rate [um/h]", "rate [\xC2\xB5m/h]"}, {"u2 um", "u2 um"},
        {"a [mol m-2 s-1] b2", "a [mol m\xE2\x81\xBB\xC2\xB2 s\xE2\x81\xBB\xC2\xB9] b2"}, {"", ""},
        {"[u]", "[u]"},
        {"x [m10]", "x [m\xC2\xB9\xE2\x81\xB0]"}};
    char out[PDI_UNIT_LABEL_SIZE], large[2 * PDI_UNIT_LABEL_SIZE];
    for (size_t k = 0; k < sizeof pairs / sizeof pairs[0]; k++)
        CHECK_STR(pdi_unit_label_format(pairs[k][0], out), pairs[k][1]);
    CHECK_STR(pdi_unit_label_format_value("1.2e-05 um2", out), "1.2e-05 \xC2\xB5m\xC2\xB2");
    CHECK_STR(pdi_unit_label_format_value("40", out), "40");
    memset(large, 'm', sizeof large);
    large[0] = '[';
    large[sizeof large - 1] = '\0';
    CHECK_INT(strlen(pdi_unit_label_format(large, out)), PDI_UNIT_LABEL_SIZE - 1);
    /* every sign of the font has ink of its own; an unknown one is a question mark */
    CHECK(pdi_canvas_compute_text_width("\xC2\xB5\xC2\xB7\xC2\xB0\xC3\x97") > 20);
    CHECK(pdi_canvas_compute_text_width("\xC2\xB2") < pdi_canvas_compute_text_width("2"));
    CHECK_INT(pdi_canvas_compute_text_width("\xE2\x82\xAC"), pdi_canvas_compute_text_width("?"));
}

/* What is not negative is not drawn with negative numbers on its axis: zero everywhere, one value, or some. */
TEST(ranges_of_nothing_less_than_zero)
{
    static const double ends[][2] = {{0, 0}, {0, 1e-310}, {1e-310, 1e-310}, {3, 3}, {0.001, 30}, {1e-290, 1e-290}};
    for (int sign = -1; sign < 2; sign += 2)
        for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++)
            for (int margin = 0; margin < 2; margin++) {
                pdi_axis_ticks axis;
                memset(&axis, 0, sizeof axis);
                axis.lo = sign > 0 ? ends[k][0] : -ends[k][1];
                axis.hi = sign > 0 ? ends[k][1] : -ends[k][0];
                double lo = axis.lo, hi = axis.hi;
                pdi_axis_ticks_widen_range(0.03 * margin, &axis);
                CHECK(axis.lo < axis.hi && axis.lo <= fmax(lo, 0) && axis.hi >= hi);
                if (sign > 0) CHECK(axis.lo >= 0);
                if (sign < 0 && hi < -1e-300) CHECK(axis.hi <= 0);
                pdi_axis_ticks_compute(8, &axis);
                CHECK(axis.count >= 2 && axis.count <= 9);
            }
}

static uint32_t pixel(const pd_image *image, int x, int y)
{
    const uint8_t *p = image->pixels + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
    return (uint32_t)p[0] << 16 | (uint32_t)p[1] << 8 | p[2];
}

/* Pixels of one colour and the box around them. */
static int count_colour(const pd_image *image, uint32_t colour, int *box)
{
    int count = 0;
    box[0] = box[1] = 1 << 20;
    box[2] = box[3] = -1;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            if (pixel(image, x, y) != colour) continue;
            count++;
            if (x < box[0]) box[0] = x;
            if (y < box[1]) box[1] = y;
            if (x > box[2]) box[2] = x;
            if (y > box[3]) box[3] = y;
        }
    return count;
}

TEST(a_picture_shows_every_cell_in_its_place)
{
    enum { NX = 20, NY = 15, EACH = 10 };
    double values[NX * NY];
    uint8_t paint[NX * NY] = {0};
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    pd_ctx ctx;
    pd_image image;
    pd_field_plot picture;
    int solid[4], wall[4], box[4];
    pd_ctx_init(&ctx);
    memset(&picture, 0, sizeof picture);
    for (int k = 0; k < NX * NY; k++) values[k] = k;
    paint[0] = PD_PAINT_SOLID;           /* lower left corner */
    paint[NX * NY - 1] = PD_PAINT_WALL;  /* upper right corner */
    values[NX + 3] = NAN;
    picture.nx = NX;
    picture.ny = NY;
    picture.values = values;
    picture.cell_paint = paint;
    picture.hi[0] = 20e-6;
    picture.hi[1] = 15e-6;
    picture.magnification = EACH;
    picture.range_hi = 299;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
    CHECK_INT(count_colour(&image, 0x9A9DA1, solid), EACH * EACH);
    CHECK_INT(count_colour(&image, 0x3C4043, wall), EACH * EACH);
    CHECK_INT(wall[2] - solid[0] + 1, NX * EACH);
    CHECK_INT(solid[3] - wall[1] + 1, NY * EACH);
    CHECK_INT(count_colour(&image, 0xFF00FF, box), EACH * EACH);
    CHECK_INT(box[0] - solid[0], 3 * EACH);
    CHECK_INT(solid[3] - box[3], EACH);
    pdi_colour_fill_table(PD_COLOUR_MAP_SEQUENTIAL, table);
    int wrong = 0;
    for (int k = 1; k < NX * NY - 1; k++) {
        int x = solid[0] + k % NX * EACH + EACH / 2, y = solid[3] - k / NX * EACH - EACH / 2;
        if (k != NX + 3) wrong += pixel(&image, x, y) != table[(int)(k / 299.0 * 255 + 0.5)];
    }
    CHECK_INT(wrong, 0);
    pd_image_free(&ctx, &image);
    CHECK_INT(ctx.in_use, 0);
}

TEST(pictures_of_any_shape_have_a_sensible_size)
{
    static const struct {
        int nx, ny;
        double lx, ly; /* [m] */
    } cases[] = {{112, 60, 560e-6, 300e-6}, {508, 50, 12.7e-3, 50e-6}, {1, 1, 1, 1}, {3000, 2000, 3e-3, 2e-3},
                 {400, 1, 0.4, 0.001}, {1, 400, 0.001, 0.4}, {66, 112, 330e-6, 560e-6}, {128, 128, 1, 1}};
    static double values[3000 * 2000];
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    /* more cells than pixels: a magnification shows all of the field, too: the last column in its colour at the right
     */
    for (int magnification = 0; magnification < 4; magnification++) {
        pd_field_plot picture;
        pd_image image;
        int last = 0;
        memset(&picture, 0, sizeof picture);
        picture.nx = 2000;
        picture.ny = 100;
        picture.hi[0] = 20e-3;
        picture.hi[1] = 1e-3;
        picture.values = values;
        picture.magnification = magnification;
        picture.range_hi = 1.0;
        for (int i = 0; i < 2000 * 100; i++) values[i] = i % 2000 >= 1900 ? 1.0 : 0.0;
        if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
        uint32_t table[256];
        pdi_colour_fill_table(picture.map, table);
        for (int x = 0; x < image.width - 150; x++) last += pixel(&image, x, image.height / 2) == table[255];
        CHECK(last >= 20 && last <= 120);
        pd_image_free(&ctx, &image);
    }
    memset(values, 0, sizeof values);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        for (int map = 0; map <= PD_COLOUR_MAP_VIRIDIS; map++) {
            pd_field_plot picture;
            pd_image image;
            memset(&picture, 0, sizeof picture);
            picture.nx = cases[k].nx;
            picture.ny = cases[k].ny;
            picture.hi[0] = cases[k].lx;
            picture.hi[1] = cases[k].ly;
            picture.values = values;
            picture.map = (pd_colour_map)map;
            picture.title = "a title";
            picture.stamp = "t = 1 s";
            picture.label = "C [mol/m3]";
            if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
            CHECK(image.width >= 300 && image.width <= 1700 && image.height >= 220 && image.height <= 1400);
            for (int x = 0; x < image.width; x++) /* nothing runs into the edge */
                CHECK(pixel(&image, x, 8) == 0xFFFFFF && pixel(&image, x, image.height - 6) == 0xFFFFFF);
            for (int y = 0; y < image.height; y++)
                CHECK(pixel(&image, 8, y) == 0xFFFFFF && pixel(&image, image.width - 8, y) == 0xFFFFFF);
            pd_image_free(&ctx, &image);
        }
    CHECK_INT(ctx.in_use, 0);
}

/* Values of zero and below are blank on a logarithmic range, which has at most eight decades. */
TEST(logarithmic_colours)
{
    static const double values[6] = {-1, 0, 1e-30, 1e-4, 1.02, 1e4};
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    pd_ctx ctx;
    pd_image image;
    pd_field_plot picture;
    double lo = 1e-30, hi = 1e4;
    pd_ctx_init(&ctx);
    pdi_field_plot_adjust_range(PD_COLOUR_MAP_GREY, 1, &lo, &hi);
    CHECK_REL(lo, 1e-4, 1e-12);
    memset(&picture, 0, sizeof picture);
    picture.nx = 6;
    picture.ny = 1;
    picture.values = values;
    picture.hi[0] = 6;
    picture.hi[1] = 1;
    picture.log = 1;
    picture.map = PD_COLOUR_MAP_GREY;
    picture.magnification = 150;
    pdi_colour_fill_table(PD_COLOUR_MAP_GREY, table);
    for (int smooth = 0; smooth < 2; smooth++) {
        static const int place[6] = {-1, -1, 0, 0, 128, 255};
        picture.smooth = smooth;
        if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
        int left = image.width, box[4];
        CHECK(count_colour(&image, table[0], box) > 0);
        left = box[0] - 2 * 150; /* the third cell is the darkest */
        for (int k = 0; k < 6; k++) {
            uint32_t want = place[k] < 0 ? 0xFFFFFF : table[place[k]];
            CHECK_INT(pixel(&image, left + k * 150 + 75, (box[1] + box[3]) / 2), want);
        }
        pd_image_free(&ctx, &image);
    }
    CHECK_INT(ctx.in_use, 0);
}

/* Smooth colours: linear between the middles of cells, one colour beyond the outermost, edges of walls stay. */
TEST(smooth_cells)
{
    static const double values[4] = {0, 255, 0, 255};
    static const uint8_t paint[4] = {PD_PAINT_FIELD, PD_PAINT_FIELD, PD_PAINT_FIELD, PD_PAINT_SOLID};
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    pd_ctx ctx;
    pd_image image;
    pd_field_plot picture;
    int box[4];
    pd_ctx_init(&ctx);
    memset(&picture, 0, sizeof picture);
    picture.nx = 4;
    picture.ny = 1;
    picture.values = values;
    picture.cell_paint = paint;
    picture.hi[0] = 4;
    picture.hi[1] = 1;
    picture.smooth = 1;
    picture.map = PD_COLOUR_MAP_GREY;
    picture.width = 801; /* any number of pixels */
    picture.range_hi = 255;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
    pdi_colour_fill_table(PD_COLOUR_MAP_GREY, table);
    count_colour(&image, 0x9A9DA1, box);
    int right = box[2], y = (box[1] + box[3]) / 2; /* the solid is the last cell */
    int left = right - 800;
    for (int x = 0; x < 600; x++) {
        double at = (x + 0.5) * 4 / 801, value = at < 0.5 ? 0 : at < 1.5 ? at - 0.5 : at < 2.5 ? 2.5 - at : 0;
        uint32_t found = pixel(&image, left + x, y);
        int want = (int)(255 * value + 0.5), near_to = 0;
        for (int d = -1; d <= 1; d++) near_to = near_to || found == table[(int)fmax(0, fmin(255, want + d))];
        if (!CHECK(near_to)) NOTE("pixel %d: %06x, expected %06x", x, found, table[want]);
    }
    CHECK_INT(pixel(&image, left + 640, y), 0x9A9DA1);
    pd_image_free(&ctx, &image);
    CHECK_INT(ctx.in_use, 0);
}

/* A legend shows the labels that are there in their colours; the size does not depend on them. */
TEST(legends_of_labels)
{
    static const char *const names[] = {"none", "fluid", "solid", "a long name"};
    double values[4] = {1, 1, 2, 1};
    pd_ctx ctx;
    pd_image image, other;
    pd_field_plot picture;
    int box[4];
    pd_ctx_init(&ctx);
    memset(&picture, 0, sizeof picture);
    picture.nx = picture.ny = 2;
    picture.values = values;
    picture.hi[0] = picture.hi[1] = 2;
    picture.map = PD_COLOUR_MAP_LABELS;
    picture.names = names;
    picture.name_count = 4;
    picture.width = 200;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
    CHECK_INT(count_colour(&image, pdi_colour_get_label_colour(2), box), 90 * 90 + 16 * 16);
    CHECK_INT(count_colour(&image, pdi_colour_get_label_colour(1), box), 3 * 90 * 90 + 16 * 16);
    CHECK_INT(count_colour(&image, pdi_colour_get_label_colour(3), box), 0);
    values[0] = 3;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &other))) return;
    CHECK(image.width == other.width && image.height == other.height);
    CHECK_INT(count_colour(&other, pdi_colour_get_label_colour(3), box), 90 * 90 + 16 * 16);
    pd_image_free(&ctx, &image);
    pd_image_free(&ctx, &other);
    CHECK_INT(ctx.in_use, 0);
}

/* Constant fields, fields without a value, the least and the largest numbers. */
TEST(extreme_values_have_a_picture)
{
    static const double sets[][4] = {{0, 0, 0, 0}, {5, 5, 5, 5}, {-5, -5, -5, -5}, {1e-308, 2e-308, 0, 1e-310},
                                     {-1e308, 1e308, 0, 1}, {1e300, 1e300, 1e300, 2e300}, {1, 1 + 1e-15, 1, 1},
                                     {NAN, NAN, NAN, NAN}, {INFINITY, 1, 2, 3}};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (size_t k = 0; k < sizeof sets / sizeof sets[0]; k++)
        for (int map = 0; map <= PD_COLOUR_MAP_VIRIDIS; map++)
            for (int way = 0; way < 4; way++) {
                pd_field_plot picture;
                pd_image image;
                memset(&picture, 0, sizeof picture);
                picture.nx = picture.ny = 2;
                picture.values = sets[k];
                picture.hi[0] = picture.hi[1] = 2;
                picture.map = (pd_colour_map)map;
                picture.log = way & 1;
                picture.smooth = way >> 1;
                picture.width = 130;
                picture.label = "C [mol/m3]";
                if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image)))
                    NOTE("set %d, map %d", (int)k, map);
                else CHECK(image.width > 130 && image.width < 700);
                pd_image_free(&ctx, &image);
            }
    CHECK_INT(ctx.in_use, 0);
}

TEST(a_picture_with_wrong_arguments_is_refused)
{
    double value = 1;
    uint8_t paint = 4;
    pd_ctx ctx;
    pd_image image;
    pd_field_plot good, bad;
    pd_ctx_init(&ctx);
    memset(&good, 0, sizeof good);
    good.nx = good.ny = 1;
    good.values = &value;
    good.hi[0] = good.hi[1] = 1;
#define REFUSED(member, wrong, text) \
    bad = good; \
    bad.member = wrong; \
    CHECK_INT(pd_field_plot_draw_image(&ctx, &bad, &image), PD_ERR_ARGUMENT); \
    CHECK(strstr(ctx.message, text) != NULL);
    REFUSED(nx, 0, "0 x 1 cells")
    REFUSED(values, NULL, "cells cannot be drawn")
    REFUSED(hi[1], 0.0, "axis 1 is empty")
    REFUSED(lo[0], NAN, "axis 0 is empty")
    REFUSED(magnification, -1, "magnification -1")
    REFUSED(range_lo, 2.0, "range 2 .. 0")
    REFUSED(range_hi, NAN, "range 0 .. nan")
    REFUSED(map, (pd_colour_map)5, "colour map 5")
    REFUSED(cell_paint, &paint, "paint 4")
    REFUSED(width, 100, "a width of 100 pixels")
    REFUSED(width, 4001, "a width of 4001 pixels")
    good.log = 1;
    good.range_hi = 1;
    REFUSED(range_lo, 0.0, "a logarithmic range from 0 on")
#undef REFUSED
    CHECK_INT(ctx.in_use, 0);
}

TEST(a_curve_passes_through_its_points)
{
    double x[5], y[5];
    pd_ctx ctx;
    pd_plot plot;
    pd_image image;
    int box[4];
    pd_ctx_init(&ctx);
    memset(&plot, 0, sizeof plot);
    for (int k = 0; k < 5; k++) {
        x[k] = pow(10, k);
        y[k] = 3e-7 * x[k] * x[k]; /* a straight line on two log axes */
    }
    plot.count = 1;
    plot.series[0].x = x;
    plot.series[0].y = y;
    plot.series[0].count = 5;
    plot.x_log = plot.y_log = 1;
    plot.x_lo = plot.y_lo = 1e-7;
    plot.x_hi = plot.y_hi = 1e5;
    if (!CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image))) return;
    CHECK(image.width == 1100 && image.height == 760);
    CHECK(count_colour(&image, 0x0072B2, box) > 200);
    /* The frame is found by its ink: its left edge is the longest dark column. */
    int left = 0, right = 0, top = 0, bottom = 0;
    for (int xp = 0; xp < image.width; xp++) {
        int dark = 0;
        for (int yp = 0; yp < image.height; yp++) dark += pixel(&image, xp, yp) == 0x202124;
        if (dark > 500 && !left) left = xp + 1;
        if (dark > 500) right = xp;
    }
    for (int yp = 0; yp < image.height; yp++) {
        int dark = 0;
        for (int xp = 0; xp < image.width; xp++) dark += pixel(&image, xp, yp) == 0x202124;
        if (dark > 700 && !top) top = yp + 1;
        if (dark > 700) bottom = yp;
    }
    for (int k = 0; k <= 40; k++) { /* also between the points */
        double px = pow(10, k * 0.1), py = 3e-7 * px * px;
        int xp = (int)(left + (log10(px) + 7) / 12 * (right - left));
        int yp = (int)(top + (5 - log10(py)) / 12 * (bottom - top));
        int hit = 0;
        for (int d = -1; d <= 1; d++) hit = hit || pixel(&image, xp, yp + d) == 0x0072B2;
        CHECK(hit);
    }
    pd_image_free(&ctx, &image);
}

/* Rows around column x that have the colour of the first curve, or much of it. */
static void coloured(const pd_image *image, int x, int *top, int *bottom)
{
    *top = *bottom = -1;
    for (int y = 0; y < image->height; y++) {
        int blue = 0;
        for (int k = x - 1; k <= x + 1; k++) {
            uint32_t c = pixel(image, k, y);
            blue += (c >> 16) < 0x80 && (c & 0xFF) > (c >> 16) + 0x40;
        }
        if (!blue) continue;
        if (*top < 0) *top = y;
        *bottom = y;
    }
}

/* Bars reach from value - spread to value + spread, where the axis can show that; the range has room for them. */
TEST(points_have_their_spread)
{
    static const double x[] = {1, 5, 9}, y[] = {2, 5, 8}, spread[] = {0, 3, 1}, wide[] = {0, 50, 1};
    pd_ctx ctx;
    pd_plot plot;
    pd_image image;
    int top, bottom, edge;
    pd_ctx_init(&ctx);
    memset(&plot, 0, sizeof plot);
    plot.count = 1;
    plot.series[0].x = x;
    plot.series[0].y = y;
    plot.series[0].error_bar = spread;
    plot.series[0].count = 3;
    plot.series[0].stroke = PD_SERIES_STYLE_MARKERS;
    plot.x_hi = plot.y_hi = 10;
    if (!CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image))) return;
    int left = 0, right = 0, high = 0, low = 0; /* the frame, by its ink */
    for (int k = 0; k < image.width; k++) {
        if (pixel(&image, k, image.height / 3) != 0x202124) continue;
        if (!left) left = k + 1;
        right = k;
    }
    for (int k = 0; k < image.height; k++) {
        if (pixel(&image, left + 31, k) != 0x202124) continue;
        if (!high) high = k + 1;
        low = k;
    }
    double unit = (low - high) / 10.0;
    for (int k = 0; k < 3; k++) {
        int column = (int)(left + x[k] * (right - left) / 10.0);
        double half = spread[k] > 0.0 ? spread[k] * unit : 5.0; /* the marker alone */
        coloured(&image, column, &top, &bottom);
        CHECK_NEAR(top, low - y[k] * unit - half, 3.0);
        CHECK_NEAR(bottom, low - y[k] * unit + half, 3.0);
    }
    pd_image_free(&ctx, &image);
    plot.y_hi = 0.0; /* the range of the data: 2 .. 9 with bars */
    if (!CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image))) return;
    coloured(&image, (int)(left + 9 * (right - left) / 10.0), &edge, &bottom);
    CHECK(edge > high && edge < high + 40);
    pd_image_free(&ctx, &image);
    plot.series[0].error_bar = wide; /* below 0, which a logarithmic axis does not have */
    plot.y_log = 1;
    CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image));
    pd_image_free(&ctx, &image);
    CHECK_INT(ctx.in_use, 0);
}

TEST(a_plot_copes_with_what_cannot_be_shown)
{
    double x[6] = {1, 2, NAN, 4, 5, 6}, y[6] = {0, -1, 2, INFINITY, 1e300, 3};
    pd_ctx ctx;
    pd_plot plot;
    pd_image image;
    pd_ctx_init(&ctx);
    memset(&plot, 0, sizeof plot);
    CHECK_INT(pd_plot_draw_image(&ctx, &plot, &image), PD_ERR_ARGUMENT);
    plot.count = 1;
    plot.series[0].name = "everything";
    plot.series[0].x = x;
    plot.series[0].y = y;
    plot.series[0].count = 2;
    plot.y_log = 1;
    if (CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image))) CHECK_INT(image.width, 1100); /* an empty frame */
    pd_image_free(&ctx, &image);
    plot.series[0].count = 0;
    if (CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image))) CHECK_INT(image.height, 760);
    pd_image_free(&ctx, &image);
    plot.y_lo = 2;
    plot.y_hi = 1;
    plot.series[0].count = 6;
    CHECK_INT(pd_plot_draw_image(&ctx, &plot, &image), PD_ERR_ARGUMENT);
    for (int stroke = 0; stroke <= PD_SERIES_STYLE_BOTH; stroke++)
        for (int k = 0; k < 4; k++) {
            plot.series[0].stroke = (pd_series_style)stroke;
            plot.y_log = k % 2;
            plot.y_lo = k / 2 ? 0.5 : 0;
            plot.y_hi = k / 2 ? 4 : 0;
            if (!CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &image))) return;
            pd_image_free(&ctx, &image);
        }
    plot.width = 100;
    CHECK_INT(pd_plot_draw_image(&ctx, &plot, &image), PD_ERR_ARGUMENT);
    CHECK_INT(ctx.in_use, 0);
}

/* A series of which no point is seen has no row in the legend, and the others keep their colours. */
TEST(a_legend_names_what_is_drawn)
{
    double x[2] = {1, 2}, y[2] = {1, 3}, below[2] = {-1, 0};
    pd_ctx ctx;
    pd_plot plot;
    pd_image without, with;
    pd_ctx_init(&ctx);
    memset(&plot, 0, sizeof plot);
    plot.count = 4;
    for (int k = 0; k < 4; k++) {
        plot.series[k].name = k % 3 ? NULL : "seen";
        plot.series[k].x = x;
        plot.series[k].y = k == 1 ? below : y;
        plot.series[k].count = k == 2 ? 0 : 2;
        plot.series[k].stroke = PD_SERIES_STYLE_BOTH;
    }
    plot.y_log = 1;
    if (!CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &without))) return;
    plot.series[1].name = "a name that makes a legend wider"; /* below 0 on a logarithmic axis */
    plot.series[2].name = "no points";
    if (CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &with))) {
        CHECK(memcmp(with.pixels, without.pixels, (size_t)(3 * with.width * with.height)) == 0);
        pd_image_free(&ctx, &with);
    }
    plot.y_log = 0; /* it is seen there */
    if (CHECK_OK(&ctx, pd_plot_draw_image(&ctx, &plot, &with))) {
        CHECK(memcmp(with.pixels, without.pixels, (size_t)(3 * with.width * with.height)) != 0);
        pd_image_free(&ctx, &with);
    }
    pd_image_free(&ctx, &without);
    CHECK_INT(ctx.in_use, 0);
}

/* What a film refuses; what it shows: tests/scripts/pictures.sh. */
TEST(films_of_one_size)
{
    uint8_t pixels[12] = {0};
    pd_image image = {2, 2, 3, pixels}, other = {2, 1, 3, pixels};
    pd_ctx ctx;
    pdi_apng film;
    start(&ctx);
    CHECK_INT(pdi_apng_create(&ctx, DIRECTORY "/film.png", 0, 100, &film), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_apng_create(&ctx, DIRECTORY "/film.png", 1, 0, &film), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_apng_create(&ctx, DIRECTORY "/none/film.png", 1, 100, &film), PD_ERR_FILE);
    for (int missing = 0; missing < 2; missing++) {
        if (!CHECK_OK(&ctx, pdi_apng_create(&ctx, DIRECTORY "/film.png", 2, 100, &film))) return;
        CHECK_OK(&ctx, pdi_apng_add_frame(&ctx, &film, &image));
        CHECK_INT(pdi_apng_add_frame(&ctx, &film, &other), PD_ERR_ARGUMENT);
        CHECK(strstr(ctx.message, "an image of 2 x 1 pixels in a film of 2 x 2") != NULL);
        if (!missing) CHECK_OK(&ctx, pdi_apng_add_frame(&ctx, &film, &image));
        if (!missing) CHECK_INT(pdi_apng_add_frame(&ctx, &film, &image), PD_ERR_ARGUMENT);
        CHECK_INT(pdi_apng_commit(&ctx, &film), missing ? PD_ERR_ARGUMENT : PD_OK);
        pdi_apng_abandon(&film);
    }
    pd_image back; /* the first one, by a reader of PNG */
    CHECK_OK(&ctx, pd_png_read(&ctx, DIRECTORY "/film.png", &back));
    CHECK(back.width == 2 && back.height == 2);
    pd_image_free(&ctx, &back);
    remove(DIRECTORY "/film.png");
    CHECK_INT(ctx.in_use, 0);
}

/* A frame for which memory is short is not counted: without it the film is refused, and a second attempt gives the file
 * of a film without any failure. */
TEST(frames_that_fail_are_not_counted)
{
    enum { SIZE = 4096 };
    static const char *const path[] = {DIRECTORY "/film.png", DIRECTORY "/again.png"};
    uint8_t pixels[12] = {0}, content[2][SIZE];
    size_t length[2] = {0, 0};
    pd_image image = {2, 2, 3, pixels};
    pd_ctx ctx;
    pdi_apng film;
    start(&ctx);
    for (int k = 0; k < 3; k++) {
        if (!CHECK_OK(&ctx, pdi_apng_create(&ctx, path[k > 0], 2, 100, &film))) return;
        for (int n = 0; n < 2; n++) {
            ctx.alloc.limit = k ? ctx.in_use + 1 : 0;
            if (k) CHECK_INT(pdi_apng_add_frame(&ctx, &film, &image), PD_ERR_LIMIT);
            CHECK_INT(film.frames_written, n);
            ctx.alloc.limit = 0;
            if (k < 2 || n == 0) CHECK_OK(&ctx, pdi_apng_add_frame(&ctx, &film, &image));
        }
        CHECK_INT(pdi_apng_commit(&ctx, &film), k < 2 ? PD_OK : PD_ERR_ARGUMENT);
    }
    for (int k = 0; k < 2; k++) {
        FILE *file = fopen(path[k], "rb");
        if (!CHECK(file != NULL)) return;
        length[k] = fread(content[k], 1, SIZE, file);
        fclose(file);
        remove(path[k]);
    }
    CHECK(length[0] > 100 && length[0] < SIZE && length[0] == length[1]);
    CHECK(memcmp(content[0], content[1], length[0]) == 0);
    CHECK_INT(ctx.in_use, 0);
}

/* Lines of a linear field are straight and stand at their place: pixels, and coordinates of vectors. */
TEST(contours_stand_at_their_place)
{
    enum { NX = 30, NY = 10, EACH = 20 };
    double values[NX * NY], at[1] = {10.25};
    pd_ctx ctx;
    pd_image image, plain;
    pd_field_plot picture;
    int corner[4];
    /* a line 1.5 pixels wide covers 3/4 of the pixels on both sides; below is its white rim */
    uint32_t line = 0;
    for (int shift = 0; shift < 24; shift += 8)
        line |= (uint32_t)(0.75 * (PDI_CANVAS_TEXT_COLOUR >> shift & 255) + 0.25 * 255 + 0.5) << shift;
    start(&ctx);
    memset(&picture, 0, sizeof picture);
    for (int k = 0; k < NX * NY; k++) values[k] = k % NX + 0.5;
    picture.nx = NX;
    picture.ny = NY;
    picture.values = values;
    picture.hi[0] = NX;
    picture.hi[1] = NY;
    picture.range_hi = NX;
    picture.magnification = EACH;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &plain))) return;
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    pdi_colour_fill_table(PD_COLOUR_MAP_SEQUENTIAL, table);
    count_colour(&plain, table[(int)(0.5 / NX * 255 + 0.5)], corner); /* the first column */
    picture.contour_count = 1;
    picture.contours = at;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
    /* what is dark stands around x = 10.25 cells from the left edge, over the whole height */
    for (int y = corner[1]; y < corner[1] + NY * EACH; y++) {
        double ink = 0, moment = 0;
        for (int x = corner[0] + 9 * EACH; x < corner[0] + 12 * EACH; x++) {
            double share = pixel(&image, x, y) != pixel(&plain, x, y);
            ink += share;
            moment += share * (x + 0.5 - corner[0]);
        }
        CHECK_NEAR(moment / ink, 10.25 * EACH, 1e-6);
        CHECK(ink >= 3 && ink <= 5);
    }
    CHECK_INT(pixel(&image, corner[0] + 205, corner[1] + 50), line);
    pd_image_free(&ctx, &image);
    /* the same as vectors */
    CHECK_OK(&ctx, pd_field_plot_write(&ctx, DIRECTORY "/line.svg", &picture));
    char *text = NULL, want[64];
    size_t size = 0;
    CHECK_OK(&ctx, pdi_file_read_all(&ctx, DIRECTORY "/line.svg", 1u << 24, &text, &size));
    const char *path = strstr(text, "<path d=\"M");
    int pieces = 0, misplaced = 0;
    if (CHECK(path != NULL)) {
        snprintf(want, sizeof want, "%d.00 ", corner[0] + 205);
        for (const char *c = path + 9; *c && *c != '"'; c++)
            if (*c == 'M' || *c == 'L') {
                pieces++;
                misplaced += strncmp(c + 1, want, strlen(want)) != 0;
            }
    }
    CHECK(pieces >= 2 * NY);
    CHECK_INT(misplaced, 0);
    pd_free(&ctx, size + 1, 1, &text);
    remove(DIRECTORY "/line.svg");
    /* evenly: two lines part the range in three */
    picture.contours = NULL;
    picture.contour_count = 2;
    if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
    for (int x = 0; x < NX * EACH; x++) {
        int there = fabs(x + 0.5 - 10 * EACH) < 1 || fabs(x + 0.5 - 20 * EACH) < 1;
        int far_off = fabs(x + 0.5 - 10 * EACH) > 3 && fabs(x + 0.5 - 20 * EACH) > 3;
        uint32_t shown = pixel(&image, corner[0] + x, corner[1] + 50);
        if (there) CHECK_INT(shown, line);
        if (far_off) CHECK_INT(shown, pixel(&plain, corner[0] + x, corner[1] + 50));
    }
    pd_image_free(&ctx, &image);
    pd_image_free(&ctx, &plain);
    picture.map = PD_COLOUR_MAP_LABELS;
    CHECK_INT(pd_field_plot_draw_image(&ctx, &picture, &image), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "2 contours, expected 0 to 32, and none of labels") != NULL);
    CHECK_INT(ctx.in_use, 0);
}

TEST(every_failing_allocation_is_reported)
{
    double values[6] = {1, 2, 3, 4, 5, 6}, velocity[12] = {1, 1, 1, 1, 1, 1};
    pd_ctx ctx;
    pd_field_plot picture;
    start(&ctx);
    memset(&picture, 0, sizeof picture);
    picture.nx = 3;
    picture.ny = 2;
    picture.values = values;
    picture.contour_count = 2;
    picture.velocity = velocity;
    picture.streamlines = picture.arrows = 4;
    picture.hi[0] = 3;
    picture.hi[1] = 2;
    int failures = 0;
    static const char *const path[3] = {DIRECTORY "/memory.png", NULL, DIRECTORY "/memory.svg"};
    for (int phase = 0; phase < 3; phase++) {
        pd_status status = PD_ERR_MEMORY;
        for (int tries = 0; status != PD_OK && tries < 50; tries++) {
            fault f;
            pd_image image = {0, 0, 0, NULL};
            fault_context(&f, tries + 1, 1, &ctx);
            status = phase == 1 ? pd_png_read(&ctx, DIRECTORY "/memory.png", &image)
                                : pd_field_plot_write(&ctx, path[phase], &picture);
            failures += status == PD_ERR_MEMORY;
            if (status != PD_OK) CHECK_INT(status, PD_ERR_MEMORY);
            pd_image_free(&ctx, &image);
            CHECK_INT(ctx.in_use, 0);
        }
        CHECK_OK(&ctx, status);
    }
    CHECK(failures >= 12);
    remove(DIRECTORY "/memory.png");
    remove(DIRECTORY "/memory.svg");
    remove(DIRECTORY);
}

TEST_MAIN(ENTRY(ranges_of_nothing_less_than_zero) ENTRY(ranges_without_ticks) ENTRY(ticks_are_round_numbers)
              ENTRY(units_are_printed) ENTRY(a_picture_shows_every_cell_in_its_place)
                  ENTRY(pictures_of_any_shape_have_a_sensible_size) ENTRY(logarithmic_colours) ENTRY(smooth_cells)
                      ENTRY(legends_of_labels) ENTRY(extreme_values_have_a_picture)
                          ENTRY(a_picture_with_wrong_arguments_is_refused) ENTRY(a_curve_passes_through_its_points)
                              ENTRY(points_have_their_spread) ENTRY(a_plot_copes_with_what_cannot_be_shown)
                                  ENTRY(a_legend_names_what_is_drawn) ENTRY(films_of_one_size)
                                      ENTRY(frames_that_fail_are_not_counted) ENTRY(contours_stand_at_their_place)
                                          ENTRY(every_failing_allocation_is_reported))
