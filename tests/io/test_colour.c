/* colour: tables of colours by lightness, hues of labels. */
/* dims: 2 */
#include "io/colour.h"
#include "test.h"
#include <math.h>

/* CIE 1976 L*a*b* (D65) of an sRGB colour: not the space in which the tables are made. */
static void cielab(uint32_t colour, double *lab)
{
    double rgb[3], f[3];
    static const double m[3][3] = {{0.4124564, 0.3575761, 0.1804375}, {0.2126729, 0.7151522, 0.0721750},
                                   {0.0193339, 0.1191920, 0.9503041}}, white[3] = {0.95047, 1.0, 1.08883};
    for (int k = 0; k < 3; k++) {
        double x = (colour >> (16 - 8 * k) & 255) / 255.0;
        rgb[k] = x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
    }
    for (int k = 0; k < 3; k++) {
        double t = (m[k][0] * rgb[0] + m[k][1] * rgb[1] + m[k][2] * rgb[2]) / white[k];
        f[k] = t > 216.0 / 24389 ? cbrt(t) : (24389.0 / 27 * t + 16) / 116;
    }
    lab[0] = 116 * f[1] - 16;
    lab[1] = 500 * (f[0] - f[1]);
    lab[2] = 200 * (f[1] - f[2]);
}

TEST(colours_are_ordered_by_lightness)
{
    uint32_t table[PDI_COLOUR_TABLE_SIZE];
    double lab[PDI_COLOUR_TABLE_SIZE][3], straight = 0;
    pdi_colour_fill_table(PD_COLOUR_MAP_SEQUENTIAL, table);
    for (int k = 0; k < PDI_COLOUR_TABLE_SIZE; k++) cielab(table[k], lab[k]);
    CHECK_LE(lab[0][0], 20);
    CHECK_LE(85, lab[255][0]);
    for (int k = 0; k < PDI_COLOUR_TABLE_SIZE; k++) {
        if (k >= 4) CHECK_LE(lab[k - 4][0] + 0.3, lab[k][0]); /* printed in gray the order stays */
        straight = fmax(straight, fabs(lab[k][0] - (lab[0][0] + (lab[255][0] - lab[0][0]) * k / 255)));
    }
    CHECK_LE(straight, 8);
    pdi_colour_fill_table(PD_COLOUR_MAP_DIVERGING, table);
    for (int k = 0; k < PDI_COLOUR_TABLE_SIZE; k++) cielab(table[k], lab[k]);
    for (int k = 0; k < 128; k++) {
        CHECK_NEAR(lab[k][0], lab[255 - k][0], 8); /* both signs weigh the same */
        if (k >= 4) CHECK_LE(lab[k - 4][0], lab[k][0]);
    }
    CHECK_LE(92, lab[127][0]);
    CHECK_LE(hypot(lab[127][1], lab[127][2]), 8);
    CHECK(lab[0][2] < -20 && lab[255][1] > 20); /* blue, red */
    for (int map = PD_COLOUR_MAP_GREY; map <= PD_COLOUR_MAP_VIRIDIS; map++) {
        pdi_colour_fill_table((pd_colour_map)map, table);
        for (int k = 0; k < PDI_COLOUR_TABLE_SIZE; k++) {
            cielab(table[k], lab[k]);
            if (k >= 4) CHECK_LE(lab[k - 4][0] + 0.3, lab[k][0]);
            if (map == PD_COLOUR_MAP_GREY) CHECK_LE(hypot(lab[k][1], lab[k][2]), 1);
        }
    }
    /* viridis as published: its ends, and what is 2/3 of the way */
    CHECK_INT(table[0], 0x440154);
    CHECK_INT(table[255], 0xFDE725);
    double there[3], step = 1e9;
    cielab(0x35B779, there);
    for (int k = 0; k < PDI_COLOUR_TABLE_SIZE; k++)
        step = fmin(step, hypot(lab[k][0] - there[0], hypot(lab[k][1] - there[1], lab[k][2] - there[2])));
    CHECK_LE(step, 1);
}

/* The colour of a number has the hue that is the number times the golden angle and one of three lightnesses of OKLab,
 * as near as 8 bits are, wherever sRGB ends. Matrices: those of Ottosson (2020) from linear sRGB. */
TEST(hues_of_labels)
{
    static const double cone[3][3] = {{0.4122214708, 0.5363325363, 0.0514459929},
                                      {0.2119034982, 0.6806995451, 0.1073969566},
                                      {0.0883024619, 0.2817188376, 0.6299787005}};
    static const double lab[3][3] = {{0.2104542553, 0.7936177850, -0.0040720468},
                                     {1.9779984951, -2.4285922050, 0.4505937099},
                                     {0.0259040371, 0.7827717662, -0.8086757660}};
    for (int number = 0; number < 400; number++) {
        uint32_t colour = pdi_colour_get_label_colour(number);
        double f[3] = {0.0, 0.0, 0.0}, c[3] = {0.0, 0.0, 0.0};
        for (int k = 0; k < 3; k++) {
            double x = (colour >> (16 - 8 * k) & 255) / 255.0;
            x = x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
            for (int j = 0; j < 3; j++) f[j] += cone[j][k] * x;
        }
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) c[j] += lab[j][k] * cbrt(f[k]);
        double turn = atan2(c[2], c[1]) * 180.0 / 3.14159265358979323846 - 137.50776405003785 * number;
        CHECK_NEAR(c[0], 0.58 + 0.12 * (number % 3), 3e-3);
        CHECK_NEAR(turn - 360.0 * floor(turn / 360.0 + 0.5), 0.0, 1.5);
        CHECK(hypot(c[1], c[2]) > 0.05 && hypot(c[1], c[2]) < 0.118);
    }
}

TEST_MAIN(ENTRY(colours_are_ordered_by_lightness) ENTRY(hues_of_labels))
