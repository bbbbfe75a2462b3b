/* axis_ticks: see axis_ticks.h */
#include "io/axis_ticks.h"
#include "io/file.h"
#include "io/unit_label.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Append a tick at a value; nothing where there are PDI_AXIS_TICKS_MAX_COUNT. An empty label makes a minor tick; a
 * label is cut to 31 bytes. */
static void pdi_axis_ticks_add_tick(pdi_axis_ticks *axis, double value, const char *label)
{
    if (axis->count >= PDI_AXIS_TICKS_MAX_COUNT) return;
    axis->value[axis->count] = value;
    snprintf(axis->label[axis->count++], sizeof axis->label[0], "%.31s", label);
}

PDI_FN void pdi_axis_ticks_format_power(int exponent, char *text)
{
    char digits[16];
    snprintf(digits, sizeof digits, "%d", exponent % 1000);
    strcpy(text, "10");
    for (const char *d = digits; *d; d++) strcat(text, pdi_unit_label_get_superscript(*d));
}

/* Smallest of 1, 2, 5 times a power of ten that is at least x, with a tolerance of 1e-9; x > 0. */
static double pdi_axis_ticks_round_step(double x)
{
    double power = pow(10.0, floor(log10(x)));
    double mantissa = x / power * (1 - 1e-9);
    return power * (mantissa <= 1 ? 1 : mantissa <= 2 ? 2 : mantissa <= 5 ? 5 : 10);
}

/* Append the ticks of a linear axis, or of a logarithmic one within a decade: multiples of the smallest step of 1, 2 or
 * 5 times a power of ten with at most max_labels steps over lo..hi. Sets the exponent: 0 where the larger magnitude is
 * at least 0.01 and below 1e5, else the largest multiple of 3 up to its decimal logarithm. No tick where lo >= hi, an
 * end is not finite (the exponent is 0 then), or the range is so narrow that ticks are no different numbers. */
static void pdi_axis_ticks_compute_linear(int max_labels, pdi_axis_ticks *axis)
{
    char label[64];
    double step = pdi_axis_ticks_round_step(axis->hi / (max_labels > 1 ? max_labels : 1) -
                                            axis->lo / (max_labels > 1 ? max_labels : 1));
    double size = pd_max(fabs(axis->lo), fabs(axis->hi)), slack = 1e-6 * step;
    /* Numbers of five digits or many zeros are shown with a common factor, a power of 1000. */
    axis->exponent = 0;
    if (!(step > 0) || step > DBL_MAX || size > DBL_MAX) return; /* one value, or an infinite one */
    if (size >= 1e5 || size < 1e-2) axis->exponent = 3 * (int)floor((log10(size) + 4e-10) / 3);
    double unit = pow(10.0, axis->exponent);
    int digits = (int)-floor(log10(step / unit) + 1e-9);
    digits = digits < 0 ? 0 : digits > 12 ? 12 : digits;
    double first = ceil((axis->lo - slack) / step), last = floor((axis->hi + slack) / step);
    if (!(fabs(first) < 1e15) || !(fabs(last) < 1e15)) return; /* counting on by 1 would end nowhere */
    for (double k = first; k <= last; k += 1) {
        snprintf(label, sizeof label, "%.*f", digits, k * step / unit + 0.0);
        for (char *c = label; *c; c++)
            if (*c == ',') *c = '.';
        pdi_axis_ticks_add_tick(axis, k * step, k == 0 ? "0" : label);
    }
}

/* Append the ticks of a logarithmic axis: at decades, every n-th with a label so that max_labels suffice; up to eight
 * decades also minor ticks at 2..9 times a power of ten, of which up to two decades 2 and 5 have labels. Decades
 * without a label are left out beyond 48. Labels are plain numbers within 1e-3..1e5, else powers of ten. Fewer than two
 * labels: linear ticks replace them all. No tick where an end is not positive and finite. */
static void pdi_axis_ticks_compute_logarithmic(int max_labels, pdi_axis_ticks *axis)
{
    if (!(axis->lo > 0.0) || !(axis->lo <= DBL_MAX) || !(axis->hi > 0.0) || !(axis->hi <= DBL_MAX)) return;
    int first = (int)floor(log10(axis->lo) + 1e-9), last = (int)ceil(log10(axis->hi) - 1e-9);
    int decades = last - first, skip = (decades + max_labels - 1) / max_labels;
    int plain = first >= -3 && last <= 5;
    char label[PDI_FILE_NUMBER_SIZE], power[24];
    if (skip < 1) skip = 1;
    for (int e = first; e <= last; e++)
        for (int k = 1; k < (decades > 8 ? 2 : 10); k++) {
            double value = k * pow(10.0, e);
            if (value < axis->lo * (1 - 1e-9) || value > axis->hi * (1 + 1e-9)) continue;
            int named = (k == 1 && e % skip == 0) || (decades <= 2 && (k == 2 || k == 5));
            if (!named && decades > PDI_AXIS_TICKS_MAX_COUNT / 2) continue;
            if (plain) pdi_file_format_number(k * (e < 0 ? 1 / pow(10.0, -e) : pow(10.0, e)), label);
            else {
                pdi_axis_ticks_format_power(e, power);
                if (k == 1) snprintf(label, sizeof label, "%s", power);
                else snprintf(label, sizeof label, "%d\xC3\x97%s", k, power);
            }
            pdi_axis_ticks_add_tick(axis, value, named ? label : "");
        }
    int count = 0;
    for (int k = 0; k < axis->count; k++) count += axis->label[k][0] != 0;
    if (count > 1) return;
    axis->count = 0; /* within a decade */
    pdi_axis_ticks_compute_linear(max_labels, axis);
}

PDI_FN void pdi_axis_ticks_compute(int max_labels, pdi_axis_ticks *axis)
{
    axis->count = axis->exponent = 0;
    if (axis->log) pdi_axis_ticks_compute_logarithmic(max_labels > 1 ? max_labels : 1, axis);
    else pdi_axis_ticks_compute_linear(max_labels, axis);
}

PDI_FN double pdi_axis_ticks_value_to_fraction(const pdi_axis_ticks *axis, double value)
{
    if (axis->log) return (log(value) - log(axis->lo)) / (log(axis->hi) - log(axis->lo));
    /* halves: the difference of the largest numbers is none */
    return (0.5 * value - 0.5 * axis->lo) / (0.5 * axis->hi - 0.5 * axis->lo);
}

PDI_FN void pdi_axis_ticks_widen_range(double margin_fraction, pdi_axis_ticks *axis)
{
    double size = pd_max(fabs(axis->lo), fabs(axis->hi));
    if (axis->log) {
        if (axis->hi < axis->lo * (1 + 1e-9)) {
            axis->lo /= 2;
            axis->hi *= 2;
        }
        double factor = exp(margin_fraction * (log(axis->hi) - log(axis->lo)));
        axis->lo /= factor;
        axis->hi *= factor;
        return;
    }
    if (size < 1e-300) { /* below, fractions of it underflow */
        axis->lo = 0;
        axis->hi = 1;
    } else if (axis->hi - axis->lo <= 1e-9 * size) {
        axis->lo -= 0.05 * size;
        axis->hi += 0.05 * size;
    }
    double margin = margin_fraction * (axis->hi - axis->lo), lo = axis->lo - margin, hi = axis->hi + margin;
    axis->lo = axis->lo >= 0 && lo < 0 ? 0 : lo;
    axis->hi = axis->hi <= 0 && hi > 0 ? 0 : hi;
}
