/* partial_volume: see partial_volume.h */
#include "solid/partial_volume.h"
#include "core/vec.h"
#include <math.h>

/* Tolerance of intersection, over the radius. */
#define PDI_PARTIAL_VOLUME_ROUNDING 1e-9

/* Square root, 0 where rounding made the argument negative. */
static double pdi_partial_volume_sqrt_positive(double x) { return x > 0.0 ? sqrt(x) : 0.0; }

/* Area of the disc of radius r where x > p >= 0 and y > q >= 0. Angles come from the same roots as lengths, so that
 * their errors cancel. */
static double pdi_partial_volume_disc_corner_area(double p, double q, double r)
{
    double square = r * r;
    if (!(p * p + q * q < square)) return 0.0;
    double along = pdi_partial_volume_sqrt_positive(square - p * p),
           across = pdi_partial_volume_sqrt_positive(square - q * q);
    double angle = 0.5 * PD_PI - atan2(p, along) - atan2(q, across);
    return 0.5 * (square * angle - p * (along - q) - q * (across - p));
}

/* Integral of asin(a/sqrt(1 - t^2)) over t from 0 to z; rest^2 = 1 - a^2 - z^2. */
static double pdi_partial_volume_integrate_asin(double a, double z, double rest)
{
    return a > 0.0 ? z * atan2(a, rest) + a * atan2(z, rest) - atan2(a * z, rest) : 0.0;
}

/* Volume of the unit ball where all coordinates exceed a, b, c >= 0: divergence theorem with x/3, from the spherical
 * face and the three plane faces (theory: eq. 14.19). */
static double pdi_partial_volume_ball_corner_volume(double a, double b, double c)
{
    double rest = 1.0 - a * a - b * b;
    if (!(rest > c * c)) return 0.0;
    double top = sqrt(rest), sphere = 0.5 * PD_PI * (top - c);
    sphere -= pdi_partial_volume_integrate_asin(a, top, b) -
              pdi_partial_volume_integrate_asin(a, c, pdi_partial_volume_sqrt_positive(1.0 - a * a - c * c));
    sphere -= pdi_partial_volume_integrate_asin(b, top, a) -
              pdi_partial_volume_integrate_asin(b, c, pdi_partial_volume_sqrt_positive(1.0 - b * b - c * c));
    return (sphere - a * pdi_partial_volume_disc_corner_area(b, c, pdi_partial_volume_sqrt_positive(1.0 - a * a)) -
            b * pdi_partial_volume_disc_corner_area(a, c, pdi_partial_volume_sqrt_positive(1.0 - b * b)) -
            c * pdi_partial_volume_disc_corner_area(a, b, pdi_partial_volume_sqrt_positive(1.0 - c * c))) /
           3.0;
}

/* Volume of the unit ball (length, area) beyond a corner [PD_DIM] >= 0 along all axes, in 1D, 2D or 3D. */
static double pdi_partial_volume_corner_volume(const double *corner)
{
    if (PD_DIM == 1) return corner[0] < 1.0 ? 1.0 - corner[0] : 0.0;
    if (PD_DIM == 2) return pdi_partial_volume_disc_corner_area(corner[0], corner[PD_DIM - 1], 1.0);
    return pdi_partial_volume_ball_corner_volume(corner[0], corner[PD_DIM / 2], corner[PD_DIM - 1]);
}

/* Volume of the unit ball within the box from lo >= 0 to hi, by inclusion and exclusion of corners. */
static double pdi_partial_volume_box_volume(const double *lo, const double *hi)
{
    double sum = 0.0;
    for (int k = 0; k < 1 << PD_DIM; k++) {
        double corner[PD_DIM], sign = 1.0;
        for (int d = 0; d < PD_DIM; d++) {
            corner[d] = k >> d & 1 ? hi[d] : lo[d];
            sign = k >> d & 1 ? -sign : sign;
        }
        sum += sign * pdi_partial_volume_corner_volume(corner);
    }
    return sum;
}

PDI_FN int pdi_partial_volume_is_inside(const double *xi, double size, double r)
{
    double near = 0.0, inner = r * (1.0 - PDI_PARTIAL_VOLUME_ROUNDING);
    for (int d = 0; d < PD_DIM; d++) {
        double gap = fabs(xi[d]) - 0.5 * size;
        near += gap > 0.0 ? gap * gap : 0.0;
    }
    return near < inner * inner;
}

PDI_FN double pdi_partial_volume_compute_fraction(const double *xi, double size, double r)
{
    double lo[2][PD_DIM], hi[2][PD_DIM], far = 0.0, sum = 0.0, whole = 1.0;
    if (!pdi_partial_volume_is_inside(xi, size, r)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) { /* in radii; what lies beyond 0 is mirrored */
        double at = fabs(xi[d]) / r, half = 0.5 * size / r;
        lo[0][d] = at > half ? at - half : 0.0;
        hi[0][d] = at + half;
        lo[1][d] = 0.0;
        hi[1][d] = at < half ? half - at : 0.0;
        far += hi[0][d] * hi[0][d];
        whole *= 2.0 * half;
    }
    if (far <= 1.0) return 1.0;
    for (int k = 0; k < 1 << PD_DIM; k++) {
        double from[PD_DIM], to[PD_DIM];
        int empty = 0;
        for (int d = 0; d < PD_DIM; d++) {
            from[d] = lo[k >> d & 1][d];
            to[d] = hi[k >> d & 1][d];
            empty = empty || !(to[d] > from[d]);
        }
        if (!empty) sum += pdi_partial_volume_box_volume(from, to);
    }
    double part = sum / whole;
    return part < 0.0 ? 0.0 : part > 1.0 ? 1.0 : part;
}

#undef PDI_PARTIAL_VOLUME_ROUNDING
