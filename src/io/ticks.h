/* ticks: where the ticks of an axis stand and what is written beside them. */
#ifndef PD_TICKS_H
#define PD_TICKS_H
#include "core/config.h"

#ifdef PDI_INTERNAL
#define PDI_TICKS_TICKS 96 /* most ticks */

typedef struct pdi_ticks {
    double lo, hi;
    int log;      /* logarithmic; lo > 0 */
    int exponent; /* the labels show value / 10^exponent (linear axes) */
    int count;
    double at[PDI_TICKS_TICKS];
    char label[PDI_TICKS_TICKS][32]; /* UTF-8; empty: a minor tick */
} pdi_ticks;

/* Choose at most about `most` labelled ticks inside lo..hi: steps of 1, 2 or 5 times a power of ten, or decades. */
PDI_FN void pdi_ticks_ticks(int most, pdi_ticks *axis);
/* "10" with raised digits, into text[32]. */
PDI_FN void pdi_ticks_power(int exponent, char *text);
/* Place of a value along the axis: 0 at lo, 1 at hi. */
PDI_FN double pdi_ticks_place(const pdi_ticks *axis, double value);
/* Open a range that is empty to the eye (hi - lo below 1e-9 of its size; zero alone: 0 .. 1), then a margin of `share`
 * on both sides, which a linear range does not carry beyond zero. */
PDI_FN void pdi_ticks_widen(double share, pdi_ticks *axis);
#endif

#endif
