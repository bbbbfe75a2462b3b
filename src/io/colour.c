/* colour: see colour.h */
#include "io/colour.h"
#include <math.h>

#define PDI_COLOUR_ARC_SAMPLES 2048 /* samples of a map from which its arc length in OKLab is computed */
#define PDI_COLOUR_RADIANS_PER_DEGREE 0.017453292519943295 /* [rad] one degree */

/* A colour in OKLab: lightness l, green-red a, blue-yellow b. */
typedef struct pdi_colour_oklab {
    double l, a, b;
} pdi_colour_oklab;

/* Convert an OKLab colour to linear RGB, rgb[3] (Ottosson 2020), not clamped. Returns 1 when it lies in the sRGB gamut,
 * each component in 0..1, else 0. */
static int pdi_colour_oklab_to_linear_rgb(pdi_colour_oklab c, double *rgb)
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

/* Linear value 0..1 of one 8-bit channel of an sRGB colour (IEC 61966-2-1); shift: its bit position. */
static double pdi_colour_srgb_to_linear(uint32_t srgb, int shift)
{
    double x = (double)(srgb >> shift & 255) / 255;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

/* Convert an sRGB colour 0xRRGGBB to OKLab (Ottosson 2020). */
static pdi_colour_oklab pdi_colour_srgb_to_oklab(uint32_t srgb)
{
    double r = pdi_colour_srgb_to_linear(srgb, 16), g = pdi_colour_srgb_to_linear(srgb, 8),
           b = pdi_colour_srgb_to_linear(srgb, 0);
    double l = cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    double m = cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    double s = cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    pdi_colour_oklab c;
    c.l = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    c.a = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    c.b = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
    return c;
}

/* Convert an OKLab colour to sRGB 0xRRGGBB (IEC 61966-2-1), clamped to the gamut. */
static uint32_t pdi_colour_oklab_to_srgb(pdi_colour_oklab c)
{
    double rgb[3];
    uint32_t packed = 0;
    pdi_colour_oklab_to_linear_rgb(c, rgb);
    for (int k = 0; k < 3; k++) {
        double x = rgb[k] < 0 ? 0 : rgb[k] > 1 ? 1 : rgb[k];
        x = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
        packed = packed << 8 | (uint32_t)(255 * x + 0.5);
    }
    return packed;
}

/* OKLab colour from lightness, chroma and hue [degree]; the chroma is reduced in steps of 0.5 % until the colour lies
 * in the sRGB gamut, or the chroma is below 1e-3. */
static pdi_colour_oklab pdi_colour_lch_to_oklab(double lightness, double chroma, double hue)
{
    pdi_colour_oklab c;
    double rgb[3], along = cos(hue * PDI_COLOUR_RADIANS_PER_DEGREE), across = sin(hue * PDI_COLOUR_RADIANS_PER_DEGREE);
    for (;; chroma *= 0.995) {
        c.l = lightness;
        c.a = chroma * along;
        c.b = chroma * across;
        if (chroma < 1e-3 || pdi_colour_oklab_to_linear_rgb(c, rgb)) return c;
    }
}

/* Catmull-Rom spline through five values v[5] at t = 0, 1/4, .. 1, evaluated at t = 0..1. */
static double pdi_colour_interpolate_spline(const double *v, double t)
{
    int k = t >= 1 ? 3 : (int)(4 * t);
    double s = 4 * t - k, a = v[k > 0 ? k - 1 : 0], b = v[k], c = v[k + 1], d = v[k < 3 ? k + 2 : 4];
    return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)));
}

/* Colour of viridis at t = 0..1: linear interpolation in OKLab between ten of its colours. */
static pdi_colour_oklab pdi_colour_interpolate_viridis(double t)
{
    static const uint32_t table[10] = {0x440154u, 0x482878u, 0x3E4989u, 0x31688Eu, 0x26828Eu,
                                       0x1F9E89u, 0x35B779u, 0x6DCD59u, 0xB4DE2Cu, 0xFDE725u};
    int k = t >= 1 ? 8 : (int)(9 * t);
    double s = 9 * t - k;
    pdi_colour_oklab a = pdi_colour_srgb_to_oklab(table[k]), b = pdi_colour_srgb_to_oklab(table[k + 1]);
    a.l += s * (b.l - a.l);
    a.a += s * (b.a - a.a);
    a.b += s * (b.b - a.b);
    return a;
}

/* OKLab colour of a map at its parameter t = 0..1, before equalising the arc length; PD_COLOUR_MAP_LABELS is taken as
 * the diverging map. */
static pdi_colour_oklab pdi_colour_evaluate_map(pd_colour_map map, double t)
{
    static const double chroma[5] = {0.120, 0.100, 0.088, 0.150, 0.180}, hue[5] = {316, 268, 194, 152, 106};
    if (map == PD_COLOUR_MAP_SEQUENTIAL)
        return pdi_colour_lch_to_oklab(0.27 + 0.65 * t, pdi_colour_interpolate_spline(chroma, t),
                                       pdi_colour_interpolate_spline(hue, t));
    if (map == PD_COLOUR_MAP_VIRIDIS) return pdi_colour_interpolate_viridis(t);
    if (map == PD_COLOUR_MAP_GREY) return pdi_colour_lch_to_oklab(0.2 + 0.78 * t, 0, 0);
    double s = 2 * t - 1, distance = fabs(s);
    return pdi_colour_lch_to_oklab(0.965 - 0.525 * distance, 0.165 * sqrt(distance) * (0.6 + 0.4 * distance),
                                   s < 0 ? 255 : 28);
}

PDI_FN void pdi_colour_fill_table(pd_colour_map map, uint32_t *table)
{
    double length[PDI_COLOUR_ARC_SAMPLES + 1];
    pdi_colour_oklab before = pdi_colour_evaluate_map(map, 0);
    length[0] = 0;
    for (int i = 1; i <= PDI_COLOUR_ARC_SAMPLES; i++) {
        pdi_colour_oklab c = pdi_colour_evaluate_map(map, (double)i / PDI_COLOUR_ARC_SAMPLES);
        double da = c.a - before.a, db = c.b - before.b, dl = c.l - before.l;
        length[i] = length[i - 1] + sqrt(dl * dl + da * da + db * db);
        before = c;
    }
    /* Equal steps of the table are equal arc lengths in OKLab. */
    for (int k = 0, i = 0; k < PDI_COLOUR_TABLE_SIZE; k++) {
        double want = length[PDI_COLOUR_ARC_SAMPLES] * k / (PDI_COLOUR_TABLE_SIZE - 1);
        while (i < PDI_COLOUR_ARC_SAMPLES - 1 && length[i + 1] < want) i++;
        double share = (want - length[i]) / (length[i + 1] - length[i]);
        table[k] =
            pdi_colour_oklab_to_srgb(pdi_colour_evaluate_map(map, pd_min((i + share) / PDI_COLOUR_ARC_SAMPLES, 1.0)));
    }
}

PDI_FN uint32_t pdi_colour_get_label_colour(int64_t number)
{
    /* Hues by the golden angle 137.5 degrees: neighbouring numbers get different colours. */
    double hue = 137.50776405003785 * (double)(number % 1000003);
    int shade = (int)((number % 3 + 3) % 3);
    return pdi_colour_oklab_to_srgb(pdi_colour_lch_to_oklab(0.58 + 0.12 * shade, 0.115, fmod(hue, 360.0)));
}

PDI_FN uint32_t pdi_colour_get_series_colour(int k)
{
    static const uint32_t table[6] = {0x0072B2u, 0xD55E00u, 0x009E73u, 0xCC79A7u, 0xE69F00u, 0x56B4E9u};
    return table[k % 6];
}
