/* axis_ticks: tick positions and tick labels of a linear or logarithmic axis. */
#ifndef PD_AXIS_TICKS_H
#define PD_AXIS_TICKS_H
#include "core/config.h"

#ifdef PDI_APP_INTERNAL
#define PDI_AXIS_TICKS_MAX_COUNT 96 /* maximum number of ticks */

/* An axis: its range and ticks. */
typedef struct pdi_axis_ticks {
    double lo, hi; /* [-] range */
    int log;      /* 1: logarithmic, with lo > 0 */
    int exponent; /* labels show value / 10^exponent (linear axes) */
    int count;    /* number of ticks */
    double value[PDI_AXIS_TICKS_MAX_COUNT];   /* [-] values at the ticks */
    char label[PDI_AXIS_TICKS_MAX_COUNT][32]; /* UTF-8; empty: a minor tick */
} pdi_axis_ticks;

/* Set count, values, labels and exponent of an axis from its lo, hi and log: ticks inside lo..hi with about
 * `max_labels` labels at most (below 1: as 1), at multiples of 1, 2 or 5 times a power of ten, or at decades. A
 * logarithmic axis has minor ticks, too, with empty labels; where fewer than two of its labels result, it has linear
 * ticks instead. count is 0 where lo >= hi, an end is not finite (logarithmic: not positive), or rounding leaves no
 * ticks between the ends. */
PDI_FN void pdi_axis_ticks_compute(int max_labels, pdi_axis_ticks *axis);
/* Format 10^exponent as UTF-8, "10" with superscript digits and sign (of the last three digits of the exponent), into
 * text, which has room for 15 bytes. */
PDI_FN void pdi_axis_ticks_format_power(int exponent, char *text);
/* Position of a value along the axis: 0 at lo, 1 at hi, linear or logarithmic; values beyond lie outside 0..1. A
 * logarithmic axis needs a positive value, and any axis lo != hi: else NaN or infinite. */
PDI_FN double pdi_axis_ticks_value_to_fraction(const pdi_axis_ticks *axis, double value);
/* Change lo and hi. A range that is practically empty, or reversed, is widened first: linear, of at most 1e-9 of its
 * larger magnitude, by 5 % of that on both sides (both ends below 1e-300: 0..1); logarithmic, hi below (1 + 1e-9) lo,
 * to lo/2 .. 2 hi. Then it is extended on both sides by `margin_fraction` times its length (logarithmic: that of its
 * logarithm). A linear end of that margin which would cross zero becomes 0. */
PDI_FN void pdi_axis_ticks_widen_range(double margin_fraction, pdi_axis_ticks *axis);
#endif

#endif
