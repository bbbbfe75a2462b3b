/* colour: see colour.h */
#include "io/colour.h"
#include <math.h>

#define PDI_COLOUR_FINE 2048 /* samples for the arc length */
#define PDI_COLOUR_DEGREE 0.017453292519943295 /* [rad] one degree */

typedef struct pdi_colour_lab {
    double l, a, b;
} pdi_colour_lab;

/* Linear sRGB of an OKLab colour; 1 when it can be shown. */
static int pdi_colour_linear(pdi_colour_lab c, double *rgb)
{
    double l = c.l + 0.3963377774 * c.a + 0.2158037573 * c.b, m = c.l - 0.1055613458 * c.a - 0.0638541728 * c.b;
    double s = c.l - 0.0894841775 * c.a - 1.2914855480 * c.b;
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    rgb[0] = 4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s;
    rgb[1] = -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s;
    rgb[2] = -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s;
    for (int k = 0; k < 3; k++)
        if (!(rgb[k] >= 0 && rgb[k] <= 1)) return 0;
    return 1;
}

static uint32_t pdi_colour_srgb(pdi_colour_lab c)
{
    double rgb[3];
    uint32_t packed = 0;
    pdi_colour_linear(c, rgb);
    for (int k = 0; k < 3; k++) {
        double x = rgb[k] < 0 ? 0 : rgb[k] > 1 ? 1 : rgb[k];
        x = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
        packed = packed << 8 | (uint32_t)(255 * x + 0.5);
    }
    return packed;
}

/* Lightness, chroma, hue [degree]; the chroma is lowered until the colour can be shown. */
static pdi_colour_lab pdi_colour_polar(double lightness, double chroma, double hue)
{
    pdi_colour_lab c;
    double rgb[3];
    for (;; chroma *= 0.995) {
        c.l = lightness;
        c.a = chroma * cos(hue * PDI_COLOUR_DEGREE);
        c.b = chroma * sin(hue * PDI_COLOUR_DEGREE);
        if (chroma < 1e-3 || pdi_colour_linear(c, rgb)) return c;
    }
}

/* A smooth curve through five equidistant values (Catmull-Rom). */
static double pdi_colour_curve(const double *v, double t)
{
    int k = t >= 1 ? 3 : (int)(4 * t);
    double s = 4 * t - k, a = v[k > 0 ? k - 1 : 0], b = v[k], c = v[k + 1], d = v[k < 3 ? k + 2 : 4];
    return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)));
}

static pdi_colour_lab pdi_colour_path(pd_map map, double t)
{
    static const double chroma[5] = {0.120, 0.100, 0.088, 0.150, 0.180}, hue[5] = {316, 268, 194, 152, 106};
    if (map == PD_MAP_SEQUENTIAL)
        return pdi_colour_polar(0.27 + 0.65 * t, pdi_colour_curve(chroma, t), pdi_colour_curve(hue, t));
    double s = 2 * t - 1, away = fabs(s);
    return pdi_colour_polar(0.965 - 0.525 * away, 0.165 * sqrt(away) * (0.6 + 0.4 * away), s < 0 ? 255 : 28);
}

PDI_FN void pdi_colour_table(pd_map map, uint32_t *table)
{
    double length[PDI_COLOUR_FINE + 1];
    pdi_colour_lab before = pdi_colour_path(map, 0);
    length[0] = 0;
    for (int i = 1; i <= PDI_COLOUR_FINE; i++) {
        pdi_colour_lab c = pdi_colour_path(map, (double)i / PDI_COLOUR_FINE);
        double da = c.a - before.a, db = c.b - before.b, dl = c.l - before.l;
        length[i] = length[i - 1] + sqrt(dl * dl + da * da + db * db);
        before = c;
    }
    /* Equal steps along the path look equally large. */
    for (int k = 0, i = 0; k < PDI_COLOUR_COUNT; k++) {
        double want = length[PDI_COLOUR_FINE] * k / (PDI_COLOUR_COUNT - 1);
        while (i < PDI_COLOUR_FINE - 1 && length[i + 1] < want) i++;
        double share = (want - length[i]) / (length[i + 1] - length[i]);
        table[k] = pdi_colour_srgb(pdi_colour_path(map, fmin((i + share) / PDI_COLOUR_FINE, 1.0)));
    }
}

PDI_FN uint32_t pdi_colour_label(int64_t number)
{
    /* Turning by the golden angle keeps neighbouring numbers far apart. */
    double hue = 137.50776405003785 * (double)(number % 1000003);
    int shade = (int)((number % 3 + 3) % 3);
    return pdi_colour_srgb(pdi_colour_polar(0.58 + 0.12 * shade, 0.115, fmod(hue, 360.0)));
}

PDI_FN uint32_t pdi_colour_series(int k)
{
    static const uint32_t table[6] = {0x0072B2u, 0xD55E00u, 0x009E73u, 0xCC79A7u, 0xE69F00u, 0x56B4E9u};
    return table[k % 6];
}
