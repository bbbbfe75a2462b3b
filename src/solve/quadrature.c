/* quadrature: see quadrature.h */
#include "solve/quadrature.h"
#include "core/vec.h"
#include <math.h>

/* What a piece misses may cost this share of the tolerance of what is taken, and this share of the size that it is
 * taken from. */
#define PDI_QUADRATURE_COST 0.1
#define PDI_QUADRATURE_FAINT 1e-4
/* Bounds are wider than the values between them by what an expression says twice: this often is still seen. */
#define PDI_QUADRATURE_WIDE 4.0
/* Parts of a piece whose bounds are together at most half as wide as its own. */
#define PDI_QUADRATURE_PARTS 4
/* A shorter piece, over the step, is a jump whatever its bounds. */
#define PDI_QUADRATURE_SHORT 1e-15
/* Share of a time by which the last value of a piece lies before its end, where the function may jump. */
#define PDI_QUADRATURE_BEFORE 1e-15

PDI_FN double pdi_quadrature_instant(double from, double to, int second)
{
    double half = 0.5 * (to - from);
    return from + half + (second ? half : -half) / sqrt(3.0);
}

/* Mean by Gauss' rule. */
static double pdi_quadrature_gauss(const pdi_quadrature *q, double from, double to)
{
    return 0.5 * (q->value(q->user, pdi_quadrature_instant(from, to, 0)) +
                  q->value(q->user, pdi_quadrature_instant(from, to, 1)));
}

/* 1: bounds become narrower with the piece: a smooth function is straight over its parts. Those of a function that
 * swings within each part do not, whatever its instants happen to show. */
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
        return PDI_QUADRATURE_FITS; /* who asks for that value will say so */
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
