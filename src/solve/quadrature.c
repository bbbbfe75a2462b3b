/* quadrature: see quadrature.h */
#include "solve/quadrature.h"
#include "core/vec.h"
#include <math.h>

/* [-] Error allowed in an interval, over rtol: this fraction of the amount removed, plus this fraction of the amount
 * that is there. */
#define PDI_QUADRATURE_COST 0.1
#define PDI_QUADRATURE_FAINT 1e-4
/* [-] Interval arithmetic overestimates the range where a variable occurs twice: bounds may be this many times wider
 * than the range of the point values. */
#define PDI_QUADRATURE_WIDE 4.0
/* Subintervals whose bounds have to be, on average, at most half as wide as those of the interval. */
#define PDI_QUADRATURE_PARTS 4
/* [-] An interval below this fraction of the step is a jump whatever its bounds. */
#define PDI_QUADRATURE_SHORT 1e-15
/* [-] The last value is taken this fraction of the time before the end, where the function may jump. */
#define PDI_QUADRATURE_BEFORE 1e-15

PDI_FN double pdi_quadrature_instant(double from, double to, int second)
{
    double half = 0.5 * (to - from);
    return from + half + (second ? half : -half) / sqrt(3.0);
}

/* Mean over [from, to] by two-point Gauss quadrature. */
static double pdi_quadrature_gauss(const pdi_quadrature *q, double from, double to)
{
    return 0.5 * (q->value(q->user, pdi_quadrature_instant(from, to, 0)) +
                  q->value(q->user, pdi_quadrature_instant(from, to, 1)));
}

/* 1: bounds of subintervals are at most half as wide as `width`, as of a smooth function. Those of a function that
 * oscillates within each subinterval are not, whatever its point values happen to be. */
static int pdi_quadrature_narrows(const pdi_quadrature *q, double from, double to, double width)
{
    double sum = 0.0, least, most;
    for (int k = 0; k < PDI_QUADRATURE_PARTS; k++) {
        double part = (to - from) / PDI_QUADRATURE_PARTS;
        q->bounds(q->user, from + k * part, from + (k + 1) * part, &least, &most);
        sum += (most - least) / PDI_QUADRATURE_PARTS;
    }
    return sum <= 0.5 * width;
}

PDI_FN pdi_quadrature_piece pdi_quadrature_judge(const pdi_quadrature *q, double from, double to, double part,
                                                 int middle, double *mean)
{
    double half = 0.5 * (from + to), least = 0.0, most = 0.0;
    double first = q->value(q->user, from), last = q->value(q->user, to * (1.0 - PDI_QUADRATURE_BEFORE));
    double centre = q->value(q->user, half), simpson = (first + 4.0 * centre + last) / 6.0;
    double low = pdi_min(pdi_min(first, last), centre), high = pdi_max(pdi_max(first, last), centre);
    double gauss = pdi_quadrature_gauss(q, from, to);
    *mean = middle ? centre : gauss;
    if (!(fabs(first) + fabs(centre) + fabs(last) + fabs(gauss) < HUGE_VAL))
        return PDI_QUADRATURE_FITS; /* an error at the evaluation of that value is reported elsewhere */
    if (q->bounds) q->bounds(q->user, from, to, &least, &most);
    double room = q->rtol * (PDI_QUADRATURE_COST * q->share * pdi_min(fabs(simpson), fabs(*mean)) +
                             PDI_QUADRATURE_FAINT * q->size);
    double error = pdi_max(fabs(simpson - *mean), most - least - PDI_QUADRATURE_WIDE * (high - low));
    if (q->share * error <= room &&
        (q->share * (most - least) <= room || pdi_quadrature_narrows(q, from, to, most - least))) {
        double halves = 0.5 * (pdi_quadrature_gauss(q, from, half) + pdi_quadrature_gauss(q, half, to));
        if (q->share * pdi_max(fabs(halves - *mean), fabs(halves - gauss)) <= room) return PDI_QUADRATURE_FITS;
    }
    if (part < PDI_QUADRATURE_SHORT ||
        part * q->share * (most - least) <= q->rtol * PDI_QUADRATURE_FAINT * q->size)
        return PDI_QUADRATURE_JUMP;
    return PDI_QUADRATURE_DIVIDE;
}

#undef PDI_QUADRATURE_COST
#undef PDI_QUADRATURE_FAINT
#undef PDI_QUADRATURE_WIDE
#undef PDI_QUADRATURE_PARTS
#undef PDI_QUADRATURE_SHORT
#undef PDI_QUADRATURE_BEFORE
