/* time_quadrature: see time_quadrature.h */
#include "solve/time_quadrature.h"
#include "core/vec.h"
#include <math.h>

/* [-] Error allowed in an interval, over rtol: this fraction of the amount removed, plus this fraction of the amount
 * that is there. */
#define PDI_TIME_QUADRATURE_RTOL_FACTOR 0.1
#define PDI_TIME_QUADRATURE_ATOL_FACTOR 1e-4
/* [-] Interval arithmetic overestimates the range where a variable occurs twice: bounds may be this many times wider
 * than the range of the point values. */
#define PDI_TIME_QUADRATURE_OVERESTIMATE 4.0
/* Subintervals whose bounds have to be, on average, at most half as wide as those of the interval. */
#define PDI_TIME_QUADRATURE_SUBINTERVALS 4
/* [-] An interval below this fraction of the step is a jump whatever its bounds. */
#define PDI_TIME_QUADRATURE_MIN_INTERVAL 1e-15
/* [-] The last value is taken this fraction of the time before the end, where the function may jump. */
#define PDI_TIME_QUADRATURE_LEFT_LIMIT 1e-15

PDI_FN double pdi_time_quadrature_gauss_point(double from, double to, int second)
{
    double half = 0.5 * (to - from);
    return from + half + (second ? half : -half) / sqrt(3.0);
}

/* Mean over [from, to] by two-point Gauss quadrature. */
static double pdi_time_quadrature_gauss_mean(const pdi_time_quadrature *q, double from, double to)
{
    return 0.5 * (q->value(q->user, pdi_time_quadrature_gauss_point(from, to, 0)) +
                  q->value(q->user, pdi_time_quadrature_gauss_point(from, to, 1)));
}

/* 1: bounds of subintervals are on average at most half as wide as `width`, as of a smooth function. Those of a
 * function that oscillates within each subinterval are not, whatever its point values happen to be. */
static int pdi_time_quadrature_is_smooth(const pdi_time_quadrature *q, double from, double to, double width)
{
    double sum = 0.0, least, most;
    for (int k = 0; k < PDI_TIME_QUADRATURE_SUBINTERVALS; k++) {
        double part = (to - from) / PDI_TIME_QUADRATURE_SUBINTERVALS;
        q->bounds(q->user, from + k * part, from + (k + 1) * part, &least, &most);
        sum += (most - least) / PDI_TIME_QUADRATURE_SUBINTERVALS;
    }
    return sum <= 0.5 * width;
}

PDI_FN pdi_time_quadrature_verdict pdi_time_quadrature_check(const pdi_time_quadrature *q, double from, double to,
                                                             double part, int middle, double *mean)
{
    double half = 0.5 * (from + to), least = 0.0, most = 0.0;
    double first = q->value(q->user, from), last = q->value(q->user, to * (1.0 - PDI_TIME_QUADRATURE_LEFT_LIMIT));
    double centre = q->value(q->user, half), simpson = (first + 4.0 * centre + last) / 6.0;
    double low = pd_min(pd_min(first, last), centre), high = pd_max(pd_max(first, last), centre);
    double gauss = pdi_time_quadrature_gauss_mean(q, from, to);
    *mean = middle ? centre : gauss;
    if (!(fabs(first) + fabs(centre) + fabs(last) + fabs(gauss) < HUGE_VAL))
        return PDI_TIME_QUADRATURE_ACCURATE; /* an error at the evaluation of that value is reported elsewhere */
    if (q->bounds) q->bounds(q->user, from, to, &least, &most);
    double room = q->rtol * (PDI_TIME_QUADRATURE_RTOL_FACTOR * q->weight * pd_min(fabs(simpson), fabs(*mean)) +
                             PDI_TIME_QUADRATURE_ATOL_FACTOR * q->amount);
    double error = pd_max(fabs(simpson - *mean), most - least - PDI_TIME_QUADRATURE_OVERESTIMATE * (high - low));
    if (q->weight * error <= room &&
        (q->weight * (most - least) <= room || pdi_time_quadrature_is_smooth(q, from, to, most - least))) {
        double halves =
            0.5 * (pdi_time_quadrature_gauss_mean(q, from, half) + pdi_time_quadrature_gauss_mean(q, half, to));
        if (q->weight * pd_max(fabs(halves - *mean), fabs(halves - gauss)) <= room)
            return PDI_TIME_QUADRATURE_ACCURATE;
    }
    if (part < PDI_TIME_QUADRATURE_MIN_INTERVAL ||
        part * q->weight * (most - least) <= q->rtol * PDI_TIME_QUADRATURE_ATOL_FACTOR * q->amount)
        return PDI_TIME_QUADRATURE_JUMP;
    return PDI_TIME_QUADRATURE_SUBDIVIDE;
}

#undef PDI_TIME_QUADRATURE_RTOL_FACTOR
#undef PDI_TIME_QUADRATURE_ATOL_FACTOR
#undef PDI_TIME_QUADRATURE_OVERESTIMATE
#undef PDI_TIME_QUADRATURE_SUBINTERVALS
#undef PDI_TIME_QUADRATURE_MIN_INTERVAL
#undef PDI_TIME_QUADRATURE_LEFT_LIMIT
