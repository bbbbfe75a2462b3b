/* drawing, scene: keys of pictures, what is refused of them, and what depends on time in a scene without time.
 * dims: 2 */
#define _XOPEN_SOURCE 700
#include "setup/fields.h"
#include "io/field_plot.h"
#include "scene_file.h"

#define CHANNEL "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[side x+] flow = outlet\n" \
    "[flow] rho = 1000 kg/m3  mu = 1e-3 Pa s\n"
#define STREAM CHANNEL "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n" \
    "[transport] D = 1e-9 m2/s  time = steady\n"
#define STILL "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[transport] D = 1e-9 m2/s\n[run] until = 1 s\n"
#define BLOCK "[shape b] box = 0 .. 50 um, 0 .. 50 um  kind = solid\n"

#define DRAWN STREAM "[output] images = C, v, p, kind  "

/* Keys of pictures: their values, and what is refused of them. */
TEST(pictures_as_wanted)
{
    static const char *const rows[][2] = {
        {"range = C 0 1 mol/m3", "range: found '0 1 mol/m3' behind 'C', expected a range: C 0 .. 1 mol/m3"},
        {"range = C 0 .. 1 mol/m3, C 0 .. 2 mol/m3", "range: found 'C' twice"},
        {"range = C 2 mol/m3 .. 1 mol/m3", "range: found 2 .. 1 of 'C', expected the smaller value first"},
        {"range = rate 0 .. 1 m/s", "range: found 'rate', expected one of the fields of 'images'"},
        {"range = kind 0 .. 1", "range: found 'kind', whose values have a colour each"},
        {"log_scale = C  range = C 0 .. 1 mol/m3", "range: found 0 of 'C', which is drawn by its logarithm"},
        {"log_scale = kind", "log_scale: found 'kind', whose values have a colour each"},
        {"colormap = red", "colormap: found 'red', expected violet, viridis, grey or diverging"},
        {"contours = C at mol/m3", "contours: found no value behind 'C at', expected some: C at 1 2 mol/m3"},
        {"contours = C 3, C 4", "contours: found 'C' twice"},
        {"contours = kind 3", "contours: found 'kind', whose values have a colour each"},
        {"contours = C 0", "contours: found '0' behind 'C', expected a number of lines from 1 to 32"},
        {"contours = C 33", "contours: found '33' behind 'C', expected a number of lines from 1 to 32"},
        {"contours = C 3x", "contours: found '3x' behind 'C'"},
        {"contours = C at 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 "
         "mol/m3",
         "contours: found more than 32 values of 'C'"},
        {"streamlines = C, C", "streamlines: found 'C' twice"},
        {"streamlines = C 3", "streamlines: found '3' behind 'C', expected how many fit side by side, from 4 to 100"},
        {"vectors = C 101", "vectors: found '101' behind 'C', expected how many fit side by side, from 4 to 100"},
        {"percentile = 0 %", "percentile: found 0 %, expected a share above 0 and up to 100 %"},
        {"percentile = 101 %", "percentile: found 101 %, expected a share above 0 and up to 100 %"},
        {"format = gif", "format: found 'gif', expected png, svg or both"}};
    pd_ctx ctx;
    pd_setup u;
    char text[640];
    if (!CHECK_OK(&ctx, load(&ctx,
                             DRAWN "range = C 1 mol/m3 .. 5 mol/m3 , v 0.5 mm/s .. 2 mm/s  log_scale = C, p  "
                                   "colormap = grey , p  viridis,v diverging  contours = C at 1 2.5 mol/m3 , p 32,v 1  "
                                   "streamlines = C , v 7  vectors = p 100  "
                                   "format = svg, png  width = 500  cells = smooth  animate = yes  percentile = 98 %\n",
                             NULL, 0, &u)))
        return;
    const pd_setup_image_options *d = &u.drawing;
    CHECK_NEAR(d->range[PD_FIELD_C][0], 1.0, 0.0);
    CHECK_NEAR(d->range[PD_FIELD_C][1], 5.0, 0.0);
    CHECK_NEAR(d->range[PD_FIELD_V][0], 5e-4, 1e-18);
    CHECK_NEAR(d->range[PD_FIELD_V][1], 2e-3, 1e-18);
    CHECK_NEAR(d->range[PD_FIELD_P][1], 0.0, 0.0);
    CHECK_INT(d->map[PD_FIELD_C], 1 + PD_COLOUR_MAP_GREY);
    CHECK_INT(d->map[PD_FIELD_P], 1 + PD_COLOUR_MAP_VIRIDIS);
    CHECK_INT(d->map[PD_FIELD_V], 1 + PD_COLOUR_MAP_DIVERGING);
    CHECK(d->log == (pd_fields_bit(PD_FIELD_C) | pd_fields_bit(PD_FIELD_P)));
    CHECK_INT(d->has_contour_values[PD_FIELD_C], 1);
    CHECK_INT(d->contours[PD_FIELD_C], 2);
    CHECK_NEAR(d->contour_value[PD_FIELD_C][0], 1.0, 0.0);
    CHECK_NEAR(d->contour_value[PD_FIELD_C][1], 2.5, 0.0);
    CHECK_INT(d->has_contour_values[PD_FIELD_P], 0);
    CHECK_INT(d->contours[PD_FIELD_P], 32);
    CHECK_INT(d->contours[PD_FIELD_V], 1);
    CHECK(d->streamlines[PD_FIELD_C] > 0 && d->streamlines[PD_FIELD_C] != 7);
    CHECK_INT(d->streamlines[PD_FIELD_V], 7);
    CHECK_INT(d->streamlines[PD_FIELD_P], 0);
    CHECK_INT(d->vectors[PD_FIELD_P], 100);
    CHECK_INT(d->vectors[PD_FIELD_C], 0);
    CHECK_INT(d->formats, 3);
    CHECK_INT(d->width, 500);
    CHECK(d->smooth && d->animate && !d->surface);
    CHECK_NEAR(d->percentile, 0.98, 1e-15);
    leave(&ctx, &u);
    for (int k = 0; k < (int)(sizeof rows / sizeof rows[0]); k++) {
        snprintf(text, sizeof text, DRAWN "%s\n", rows[k][0]);
        refused(text, rows[k][1]);
    }
    refused(STILL "[output] images = C  vectors = C\n", "vectors: found without a [flow] or [gas] section");
    refused(STILL "[output] percentile = 98 %\n", "percentile: found without 'images', the fields that are drawn");
    refused(STILL "[output] images = C  view = 1, 0, 0\n", "view: found without 'surface'");
    refused(STILL "[output] images = C  surface = yes\n", "surface: found in 2D, expected it in 3D");
    refused(STREAM BLOCK "[transfer t] reference_length = 1 um  surface = 1 mol/m3  fluid = bulk\n",
            "fluid: found 'bulk' without the axis of the stream, expected along = x or y");
    refused(STILL "[transfer t] reference_length = 1 um  surface = 1 mol/m3  fluid = inlet\n",
            "fluid: found 'inlet' in a scene without one, expected bulk or a concentration");
}

/* What depends on time is refused in a scene without time, whatever key it is behind. */
TEST(functions_of_time_at_rest)
{
#define GROWS "*(1 + t/(1 s))"
#define FLOWS \
    "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[flow] rho = 1 g/cm3  mu = 1 mPa s  reference_speed = 1 mm/s\n"
#define CARRIES CHANNEL "[transport] D = 1e-9 m2/s  time = steady\n"
#define LOADED "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n" BLOCK \
    "[solid] E = 200 GPa  nu = 0.3  plane = stress\n"
    static const char *const rows[][2] = {
        {CHANNEL "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s" GROWS "\n", "a.scene:4: mean: "},
        {CHANNEL "[side x-] flow = inlet  profile = uniform  flow_rate = 1 mL/min" GROWS "\n",
         "a.scene:4: flow_rate: "},
        {CHANNEL "[side x-] flow = inlet  profile = expression  vx = 1 mm/s" GROWS "  vy = 0 m/s\n", "a.scene:4: vx: "},
        {CHANNEL "[side x-] flow = inlet  profile = expression  vx = 1 mm/s  vy = 0 m/s" GROWS "\n", "a.scene:4: vy: "},
        {CARRIES "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s  C = 1 mol/m3" GROWS "\n", "a.scene:5: C: "},
        {CARRIES "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n[side y-] C = 1 mol/m3" GROWS "\n",
         "a.scene:6: C: "},
        {CARRIES "[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n"
                 "[shape w] box = 50 um .. 90 um, 0 um .. 30 um  kind = wall  C = 1 mol/m3" GROWS "\n",
         "a.scene:6: C: "},
        {FLOWS "[side y+] velocity = 1 mm/s" GROWS ", 0 m/s\n", "a.scene:3: velocity: "},
        {CHANNEL "  force = 0 m/s2, 1 m/s2" GROWS "\n[side x-] flow = inlet  profile = uniform  mean = 1 mm/s\n",
         "body_force: "},
        {LOADED "[side x-] ux = 0 um\n[side x+] ux = 1 um" GROWS "\n", "a.scene:5: ux: "},
        {LOADED "[side x-] ux = 0 um\n[side y-] uy = 1 um" GROWS "\n", "a.scene:5: uy: "},
        {LOADED "[side x-] ux = 0 um  uy = 0 um\n[side y-] traction = 0 Pa, 1 MPa" GROWS "\n", "a.scene:5: traction: "},
        {LOADED "[side x-] ux = 0 um  uy = 0 um\n[side y-] pressure = 1 MPa" GROWS "\n", "a.scene:5: pressure: "},
        {LOADED "  force = 0 N/m3, 1 N/m3" GROWS "\n[side x-] ux = 0 um  uy = 0 um\n", "body_force: "}};
    for (int k = 0; k < (int)(sizeof rows / sizeof rows[0]); k++) {
        char part[160];
        snprintf(part, sizeof part, "%sfound a function of t in a scene that is steady", rows[k][1]);
        refused(rows[k][0], part);
    }
}

/* A pressure counts from any level, a concentration does not; two sides have one of each. */
TEST(values_of_sides)
{
    pd_ctx ctx;
    pd_setup u;
#define BOX_OF "[grid] h = 10 um  box = 0 .. 200 um, 0 .. 100 um\n[flow] rho = 1 g/cm3  mu = 1 mPa s\n" \
    "[transport] D = 1e-9 m2/s  time = steady\n[side x-] flow = inlet  profile = uniform  mean = 1 mm/s"
    refused(BOX_OF "  C = -1 mol/m3\n[side x+] flow = outlet\n", "a.scene:4: C: found -1 mol/m3");
    refused(BOX_OF "\n[side x+] flow = outlet  p = 1 Pa\n[side y+] flow = outlet  p = 2 Pa\n",
            "p: found 2, another side has 1, expected one value");
    if (!CHECK_OK(&ctx, load(&ctx, BOX_OF "\n[side x+] flow = outlet  p = -2 Pa\n", NULL, 0, &u))) return;
    CHECK_NEAR(u.p_out, -2.0, 0.0);
    leave(&ctx, &u);
}

TEST_MAIN(ENTRY(functions_of_time_at_rest) ENTRY(pictures_as_wanted) ENTRY(values_of_sides))
