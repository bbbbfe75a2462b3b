/* elasticity: closed forms of elasticity and fracture, E = 1, for validation cases and tests. Include pdcorr.h, or
 * solid/correspondence.h, before. */
#ifndef CASES_ELASTICITY_H
#define CASES_ELASTICITY_H
#include <math.h>

#define ELASTICITY_PI 3.14159265358979323846

#if PD_DIM == 1
/* Waves in a chain of springs of 2 E/horizon^2, the neighbours at the horizon counting half: phase velocity over
 * sqrt(E/rho) at k times the cell, and the longest step by Silling and Askari over the time of a wave through a cell,
 * with the horizon m (data: dispersion_1d). */
static const double elasticity_waves[8] = {0.1, 0.25, 0.5, 1.0, 1.5, 2.0, 2.5, 3.1415926535897932};
static const struct { int m; double phase[8], step; } elasticity_dispersion[4] = {
    {2, {0.99895897, 0.99351447, 0.97435489, 0.90207228, 0.79631399, 0.67630573, 0.56288231, 0.45015816}, 1.2649111},
    {3, {0.99791926, 0.98708034, 0.94952004, 0.81634321, 0.64804486, 0.49995632, 0.40161511, 0.32415092}, 1.6431677},
    {4, {0.99646574, 0.97815245, 0.91599067, 0.71375896, 0.50912085, 0.38725256, 0.32292319, 0.25989893}, 2.0211646},
    {6, {0.99232604, 0.95315323, 0.82788048, 0.51543935, 0.36022962, 0.28496816, 0.2303215, 0.18580704}, 2.7578314}};
#endif

/* Ring (2D) or shell (3D) of radii 1 and 2 under the pressure 1 inside: radial displacement at r (Timoshenko and
 * Goodier 1970, secs. 28 and 136). */
static inline double elasticity_lame(double r, double nu, pd_plane plane)
{
    if (PD_DIM == 3) return ((1.0 - 2.0 * nu) * r + 0.5 * (1.0 + nu) * 8.0 / (r * r)) / 7.0;
    if (plane == PD_PLANE_STRESS) return ((1.0 - nu) * r + (1.0 + nu) * 4.0 / r) / 3.0;
    return (1.0 + nu) * ((1.0 - 2.0 * nu) * r + 4.0 / r) / 3.0;
}

#if PD_DIM > 1
/* Displacement around a hole of radius 1 in an infinite plate under the stress 1 along x, plane stress (Kirsch
 * 1898). */
static inline void elasticity_kirsch(const double *x, double nu, double *u)
{
    double r = sqrt(x[0] * x[0] + x[1] * x[1]), t = atan2(x[1], x[0]);
    double g = 0.5 / (1.0 + nu), k = (3.0 - nu) / (1.0 + nu);
    double ur = (r * (k - 1.0) / 2.0 + r * cos(2 * t) + (1.0 + (1.0 + k) * cos(2 * t)) / r - cos(2 * t) / (r * r * r)) /
                (4.0 * g);
    double ut = ((1.0 - k) / r - r - 1.0 / (r * r * r)) * sin(2 * t) / (4.0 * g);
    u[0] = ur * cos(t) - ut * sin(t);
    u[1] = ur * sin(t) + ut * cos(t);
}

/* Stress along x there. */
static inline double elasticity_kirsch_stress(const double *x)
{
    double q = 1.0 / (x[0] * x[0] + x[1] * x[1]), t = atan2(x[1], x[0]);
    return 1.0 - q * (1.5 * cos(2.0 * t) + cos(4.0 * t)) + 1.5 * q * q * cos(4.0 * t);
}

/* Displacement at y, in the axes of a crack that ends at 0 and runs along y[0], for the stress intensities k[0] and
 * k[1] (Williams 1957; Anderson 2017, table 2.2). */
static inline void elasticity_williams(const double *y, double nu, pd_plane plane, const double *k, double *u)
{
    double g = 0.5 / (1.0 + nu), kappa = plane == PD_PLANE_STRESS ? (3.0 - nu) / (1.0 + nu) : 3.0 - 4.0 * nu;
    double r = sqrt(y[0] * y[0] + y[1] * y[1]), t = 0.5 * atan2(y[1], y[0]), s = sqrt(r / (2.0 * ELASTICITY_PI));
    u[0] = s / (2.0 * g) * (k[0] * cos(t) * (kappa - 1.0 + 2.0 * sin(t) * sin(t)) +
                            k[1] * sin(t) * (kappa + 1.0 + 2.0 * cos(t) * cos(t)));
    u[1] = s / (2.0 * g) * (k[0] * sin(t) * (kappa + 1.0 - 2.0 * cos(t) * cos(t)) -
                            k[1] * cos(t) * (kappa - 1.0 - 2.0 * sin(t) * sin(t)));
}

/* Displacement of a cantilever of height 1 and the given length, plane stress, under the force 1 at its end, which is
 * spread as a parabola (Timoshenko and Goodier 1970, sec. 21); without contraction also one of width 1 in 3D. */
static inline void elasticity_cantilever(const double *x, double length, double nu, double *u)
{
    double y = x[1], a = x[0];
    u[0] = -2.0 * y * ((6.0 * length - 3.0 * a) * a + (2.0 + nu) * (y * y - 0.25));
    u[1] = 2.0 * (3.0 * nu * y * y * (length - a) + 0.25 * (4.0 + 5.0 * nu) * a + (3.0 * length - a) * a * a);
}

/* Displacement of a bar of E = 1 that moments bend to the curvature 1 (Timoshenko and Goodier 1970, sec. 102; in plane
 * stress the same without z). */
static inline void elasticity_bent(const double *x, double nu, double *u)
{
    double z = PD_DIM == 3 ? x[PD_DIM - 1] : 0.0;
    u[PD_DIM - 1] = nu * x[1] * z;
    u[0] = -x[0] * x[1];
    u[1] = 0.5 * (x[0] * x[0] + nu * (x[1] * x[1] - z * z));
}
#endif

#if PD_DIM == 2
/* A tube of radii 1 and 2 whose metal flows up to the radius c, plane strain, yield stress sqrt(3) in shear units k = 1
 * (Hill 1950, ch. 5): the pressure over k, and the displacement beyond c over k. */
static inline double elasticity_hill_pressure(double c) { return 2.0 * (log(c) + 0.5 * (1.0 - 0.25 * c * c)); }
static inline double elasticity_hill(double r, double c, double nu)
{
    return (1.0 + nu) * c * c * ((1.0 - 2.0 * nu) * r / 4.0 + 1.0 / r);
}

/* K of a compact specimen of width 1 with a crack of length a under the force 1 (ASTM E 399; Anderson 2017, table 2.4;
 * to 0.5 %). */
static inline double elasticity_compact(double a)
{
    return (2.0 + a) / pow(1.0 - a, 1.5) * (0.886 + a * (4.64 - a * (13.32 - a * (14.72 - 5.6 * a))));
}

/* K of a strip of width 1 with a crack of length a at one side under the stress 1 (Tada, Paris and Irwin 2000, 2.10; to
 * 0.5 %). */
static inline double elasticity_edge_notch(double a)
{
    double t = 0.5 * ELASTICITY_PI * a, s = 1.0 - sin(t);
    return sqrt(ELASTICITY_PI * a) * sqrt(tan(t) / t) * (0.752 + 2.02 * a + 0.37 * s * s * s) / cos(t);
}
#endif

#endif
