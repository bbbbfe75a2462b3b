/* constitutive_law: see constitutive_law.h */
#include "solid/constitutive_law.h"
#include "solid/tensor.h"
#include <math.h>
#include <string.h>

/* Tolerance of a stress that has to vanish, over modulus and strain. */
#define PDI_CONSTITUTIVE_LAW_ROUNDING 1e-15
/* Most Newton iterations; a few are enough. */
#define PDI_CONSTITUTIVE_LAW_MAX_NEWTON 60
/* Most sweeps of Jacobi rotations (up to six are needed), and the off-diagonal entries over the trace that end them. */
#define PDI_CONSTITUTIVE_LAW_MAX_SWEEPS 30
#define PDI_CONSTITUTIVE_LAW_OFF_DIAGONAL 1e-17
/* Relative difference of eigenvalues below which a series replaces the difference quotient. */
#define PDI_CONSTITUTIVE_LAW_CLOSE_EIGENVALUES 1e-5

/* Principal logarithmic strains and stresses of a material point. */
typedef struct pdi_constitutive_law_spectrum {
    double cofactor[PDI_TENSOR]; /* of F */
    double det;                  /* of F */
    double axis[PDI_TENSOR];     /* columns: principal directions of b = F G F^T */
    double square[PD_DIM];       /* of b */
    double strain[3];            /* [-] elastic trial strains, with the directions beyond PD_DIM */
    double stress[3];            /* [Pa] Kirchhoff */
    double moduli[9];            /* [Pa] d stress/d strain; free directions condensed */
    double slope;                /* [Pa] deviatoric stress over deviatoric strain */
    double flow;                 /* [-] increment of the equivalent plastic strain */
} pdi_constitutive_law_spectrum;

/* ---- moduli ---- */

PDI_FN pd_status pdi_constitutive_law_init(pd_ctx *ctx, const pd_constitutive_law *law, pdi_constitutive_law_params *m)
{
    double nu = law->poisson;
    memset(m, 0, sizeof *m);
    m->law = *law;
    m->free = PD_DIM == 1 ? 2 : PD_DIM == 2 && law->plane == PD_PLANE_STRESS;
    if (!(law->young > 0.0) || !(law->young < 1e100) || !(nu > -1.0) || !(nu < 0.5))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain",
                       "E = %g Pa and nu = %g, expected a finite positive E and nu between -1 and 0.5", law->young, nu);
    if (law->kind == PD_FINITE_STRAIN_NEO_HOOKEAN && m->free && nu < 0.0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain",
                       "nu = %g, expected one from 0 for a neo-Hookean material in "
                       "plane stress or 1D",
                       nu);
    m->mu = 0.5 * law->young / (1.0 + nu);
    m->lambda = law->young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    if (law->kind != PD_FINITE_STRAIN_J2) return PD_OK;
    if (!(law->yield > 0.0) || !(law->yield < 1e100) || !(law->hardening >= 0.0) || !(law->hardening < 1e100))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain",
                       "yield stress %g Pa and hardening %g Pa, expected a positive "
                       "stress and no softening",
                       law->yield, law->hardening);
    int saturates = !(fabs(law->saturation) <= 0.0), rates = law->rate > 0.0 && law->rate < 1e100;
    if (saturates && (!rates || !(law->saturation >= law->yield) || !(law->saturation < 1e100)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "finite_strain",
                       "saturation %g Pa at the rate %g, expected at least the yield "
                       "stress of %g Pa and a positive rate",
                       law->saturation, law->rate, law->yield);
    return PD_OK;
}

PDI_FN double pdi_constitutive_law_plane_lambda(const pdi_constitutive_law_params *m)
{
    return m->lambda * 2.0 * m->mu / (2.0 * m->mu + m->free * m->lambda);
}

/* Yield stress [Pa] at the equivalent plastic strain a; *slope: its derivative, *work: its integral from 0 [Pa] (Voce
 * 1948 with linear hardening). Without a saturation above the first yield stress hardening is linear alone. */
static double pdi_constitutive_law_yield_stress(const pd_constitutive_law *law, double a, double *slope, double *work)
{
    double more = law->saturation > 0.0 ? law->saturation - law->yield : 0.0;
    double gone = more > 0.0 ? -expm1(-law->rate * a) : 0.0;
    *slope = law->hardening + more * law->rate * (1.0 - gone);
    *work = (law->yield + 0.5 * law->hardening * a) * a + (more > 0.0 ? more * (a - gone / law->rate) : 0.0);
    return law->yield + law->hardening * a + more * gone;
}

/* ---- neo-Hookean ---- */

/* Logarithm of the stretch t of stress-free directions, neo-Hookean; 0 where there are none: Newton's method for mu
 * (t^2 - 1) + lambda ln J = 0, J = det t^free, which is convex and increasing. log_det: ln det. */
static double pdi_constitutive_law_stress_free_stretch(const pdi_constitutive_law_params *m, double log_det)
{
    double y = m->free ? -m->lambda * log_det / (2.0 * m->mu + m->free * m->lambda) : 0.0;
    for (int k = 0; m->free && k < PDI_CONSTITUTIVE_LAW_MAX_NEWTON; k++) {
        double rest = m->mu * expm1(2.0 * y) + m->lambda * (log_det + m->free * y);
        if (!(fabs(rest) > PDI_CONSTITUTIVE_LAW_ROUNDING * m->lambda * fabs(log_det))) break;
        y -= rest / (2.0 * m->mu * exp(2.0 * y) + m->free * m->lambda);
    }
    return y;
}

/* Neo-Hookean material at f, into p [PD_DIM^2] [Pa]: the first Piola-Kirchhoff stress where df is NULL, otherwise its
 * derivative along df alone. Returns 1; 0: det F <= 0, and p stays. */
static int pdi_constitutive_law_neo_hookean(const pdi_constitutive_law_params *m, const double *f, const double *df,
                                            double *p)
{
    double turned[PDI_TENSOR], part[PDI_TENSOR], det = pdi_tensor_compute_cofactor(f, turned);
    if (!(det > 0.0) || !(det < HUGE_VAL)) return 0;
    for (int k = 0; k < PDI_TENSOR; k++) turned[k] /= det;
    double log_det = log(det), y = pdi_constitutive_law_stress_free_stretch(m, log_det);
    double pull = m->lambda * (log_det + m->free * y) - m->mu;
    if (!df) {
        for (int k = 0; k < PDI_TENSOR; k++) p[k] = m->mu * f[k] + pull * turned[k];
        return 1;
    }
    double soft = 2.0 * m->mu * exp(2.0 * y), lambda = m->lambda * soft / (soft + m->free * m->lambda);
    double trace = pdi_tensor_double_dot(turned, df);
    pdi_tensor_multiply_transposed_b(turned, df, part);
    pdi_tensor_multiply(part, turned, p);
    for (int k = 0; k < PDI_TENSOR; k++) p[k] = m->mu * df[k] - pull * p[k] + lambda * trace * turned[k];
    return 1;
}

/* Energy density [Pa] of a neo-Hookean material; HUGE_VAL where det F <= 0. */
static double pdi_constitutive_law_neo_hookean_energy(const pdi_constitutive_law_params *m, const double *f)
{
    double turned[PDI_TENSOR], det = pdi_tensor_compute_cofactor(f, turned);
    if (!(det > 0.0) || !(det < HUGE_VAL)) return HUGE_VAL;
    double y = pdi_constitutive_law_stress_free_stretch(m, log(det)), log_j = log(det) + m->free * y;
    double first = pdi_tensor_double_dot(f, f) + (3 - PD_DIM) * exp(2.0 * y);
    return 0.5 * m->mu * (first - 3.0 - 2.0 * log_j) + 0.5 * m->lambda * log_j * log_j;
}

/* ---- principal logarithmic strains ---- */

/* Jacobi rotation of the symmetric tensor b in place that makes b_pq zero; the columns of axis take the rotation,
 * too. */
static void pdi_constitutive_law_jacobi_rotate(double *b, double *axis, int p, int q)
{
    double across = b[p * PD_DIM + q];
    if (!(fabs(across) > 0.0)) return;
    double half = 0.5 * (b[q * PD_DIM + q] - b[p * PD_DIM + p]) / across;
    double t = (half < 0.0 ? -1.0 : 1.0) / (fabs(half) + sqrt(half * half + 1.0));
    double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    for (int k = 0; k < PD_DIM; k++) {
        double x = b[k * PD_DIM + p], y = b[k * PD_DIM + q];
        b[k * PD_DIM + p] = c * x - s * y;
        b[k * PD_DIM + q] = s * x + c * y;
    }
    for (int k = 0; k < PD_DIM; k++) {
        double x = b[p * PD_DIM + k], y = b[q * PD_DIM + k];
        b[p * PD_DIM + k] = c * x - s * y;
        b[q * PD_DIM + k] = s * x + c * y;
        x = axis[k * PD_DIM + p];
        y = axis[k * PD_DIM + q];
        axis[k * PD_DIM + p] = c * x - s * y;
        axis[k * PD_DIM + q] = s * x + c * y;
    }
}

/* Eigenvalues of the symmetric tensor b, left on its diagonal, unsorted, and eigenvectors as columns of axis: cyclic
 * Jacobi until the largest off-diagonal entry is at most 1e-17 of the trace, at most 30 sweeps. */
static void pdi_constitutive_law_eigen_decompose(double *b, double *axis)
{
    for (int k = 0; k < PDI_TENSOR; k++) axis[k] = k % (PD_DIM + 1) == 0 ? 1.0 : 0.0;
    for (int sweep = 0; sweep < PDI_CONSTITUTIVE_LAW_MAX_SWEEPS; sweep++) {
        double off = 0.0, trace = 0.0;
        for (int p = 0; p < PD_DIM; p++) {
            trace += b[p * PD_DIM + p];
            for (int q = p + 1; q < PD_DIM; q++) off = pd_max(off, fabs(b[p * PD_DIM + q]));
        }
        if (!(off > PDI_CONSTITUTIVE_LAW_OFF_DIAGONAL * trace)) return;
        for (int p = 0; p < PD_DIM; p++)
            for (int q = p + 1; q < PD_DIM; q++) pdi_constitutive_law_jacobi_rotate(b, axis, p, q);
    }
}

/* Elastic left Cauchy-Green tensor b = F G F^T [PD_DIM^2]; state holds G - 1, NULL: G = 1. */
static void pdi_constitutive_law_compute_left_cauchy_green(const double *f, const double *state, double *b)
{
    double g[PDI_TENSOR], part[PDI_TENSOR], more[PDI_TENSOR];
    pdi_tensor_multiply_transposed_b(f, f, b);
    if (!state) return;
    for (int p = 0, k = 0; p < PD_DIM; p++)
        for (int q = p; q < PD_DIM; q++, k++) {
            g[p * PD_DIM + q] = state[k];
            g[q * PD_DIM + p] = state[k];
        }
    pdi_tensor_multiply(f, g, part);
    pdi_tensor_multiply_transposed_b(part, f, more);
    for (int k = 0; k < PDI_TENSOR; k++) b[k] += more[k];
}

/* Increment of the equivalent plastic strain that brings the equivalent stress [Pa], less 3 mu times the increment,
 * down to the yield stress; before: equivalent plastic strain of the state. 0: it is not above. The residual is convex
 * and decreasing, so Newton's method from 0 converges from one side. */
static double pdi_constitutive_law_plastic_increment(const pdi_constitutive_law_params *m, double equivalent,
                                                     double before)
{
    double flow = 0.0, slope, work;
    for (int k = 0; k < PDI_CONSTITUTIVE_LAW_MAX_NEWTON; k++) {
        double rest =
            equivalent - 3.0 * m->mu * flow - pdi_constitutive_law_yield_stress(&m->law, before + flow, &slope, &work);
        if (!(rest > PDI_CONSTITUTIVE_LAW_ROUNDING * equivalent)) break;
        flow += rest / (3.0 * m->mu + slope);
    }
    return flow;
}

/* Radial return of the trial strains s->strain, which stay: sets principal Kirchhoff stresses, moduli, slope and flow
 * of s. Elastic (flow 0) under other laws than J2, and where the von Mises stress is not above the yield stress.
 * before: equivalent plastic strain of the state. */
static void pdi_constitutive_law_return_map(const pdi_constitutive_law_params *m, double before,
                                            pdi_constitutive_law_spectrum *s)
{
    double trace = s->strain[0] + s->strain[1] + s->strain[2], dev[3], size = 0.0, bend = 0.0, slope, work;
    double bulk = m->lambda + 2.0 * m->mu / 3.0;
    for (int a = 0; a < 3; a++) {
        dev[a] = s->strain[a] - trace / 3.0;
        size += dev[a] * dev[a];
    }
    size = sqrt(size);
    s->slope = 2.0 * m->mu;
    s->flow = 0.0;
    double equivalent = sqrt(1.5) * 2.0 * m->mu * size;
    if (m->law.kind == PD_FINITE_STRAIN_J2 &&
        equivalent > pdi_constitutive_law_yield_stress(&m->law, before, &slope, &work)) {
        s->flow = pdi_constitutive_law_plastic_increment(m, equivalent, before);
        pdi_constitutive_law_yield_stress(&m->law, before + s->flow, &slope, &work);
        s->slope *= 1.0 - 3.0 * m->mu * s->flow / equivalent;
        bend = 6.0 * m->mu * m->mu * (1.0 / (3.0 * m->mu + slope) - s->flow / equivalent) / (size * size);
    }
    for (int a = 0; a < 3; a++) {
        s->stress[a] = bulk * trace + s->slope * dev[a];
        for (int b = 0; b < 3; b++)
            s->moduli[a * 3 + b] = bulk + s->slope * ((a == b) - 1.0 / 3.0) - bend * dev[a] * dev[b];
    }
}

/* Finds the strain of the stress-free directions (safeguarded Newton), into s->strain, with the results of the radial
 * return at it; condenses the moduli. */
static void pdi_constitutive_law_solve_stress_free(const pdi_constitutive_law_params *m, double before,
                                                   pdi_constitutive_law_spectrum *s)
{
    double given = 0.0, low = -HUGE_VAL, high = HUGE_VAL, slope = 1.0;
    for (int a = 0; a < 3 - m->free; a++) given += s->strain[a];
    double y = -m->lambda * given / (m->free * m->lambda + 2.0 * m->mu);
    for (int k = 0; k < PDI_CONSTITUTIVE_LAW_MAX_NEWTON; k++) {
        for (int a = 3 - m->free; a < 3; a++) s->strain[a] = y;
        pdi_constitutive_law_return_map(m, before, s);
        slope = s->moduli[8] + (m->free == 2 ? s->moduli[7] : 0.0);
        double size = m->mu * (fabs(s->strain[0]) + fabs(s->strain[1]) + fabs(y));
        if (!(fabs(s->stress[2]) > PDI_CONSTITUTIVE_LAW_ROUNDING * size)) break;
        if (s->stress[2] < 0.0) low = y;
        else high = y;
        y -= s->stress[2] / slope;
        if (!(y > low) || !(y < high)) y = 0.5 * (low + high);
    }
    double out[3] = {s->moduli[2], s->moduli[5], s->moduli[8]};
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) s->moduli[a * 3 + b] -= m->free * out[a] * out[b] / slope;
}

/* Fills s with principal strains, stresses and moduli of the step from `state` (NULL: virgin) to f. Returns 1; 0: det F
 * <= 0, or rounding leaves b not positive. */
static int pdi_constitutive_law_compute_spectrum(const pdi_constitutive_law_params *m, const double *f,
                                                 const double *state, pdi_constitutive_law_spectrum *s)
{
    double b[PDI_TENSOR], before = state ? state[PDI_CONSTITUTIVE_LAW_STATE - 1] : 0.0;
    s->det = pdi_tensor_compute_cofactor(f, s->cofactor);
    if (!(s->det > 0.0) || !(s->det < HUGE_VAL)) return 0;
    pdi_constitutive_law_compute_left_cauchy_green(f, state, b);
    pdi_constitutive_law_eigen_decompose(b, s->axis);
    for (int a = 0; a < 3; a++) s->strain[a] = PD_DIM == 2 && state ? 0.5 * log1p(state[PDI_SYM_COMPONENTS]) : 0.0;
    for (int a = 0; a < PD_DIM; a++) {
        s->square[a] = b[a * PD_DIM + a];
        if (!(s->square[a] > 0.0)) return 0;
        s->strain[a] = 0.5 * log(s->square[a]);
    }
    if (m->free) pdi_constitutive_law_solve_stress_free(m, before, s);
    else pdi_constitutive_law_return_map(m, before, s);
    return 1;
}

/* out = axis hat axis^T: from principal axes to coordinates. */
static void pdi_constitutive_law_rotate_back(const pdi_constitutive_law_spectrum *s, const double *hat, double *out)
{
    double part[PDI_TENSOR];
    pdi_tensor_multiply(s->axis, hat, part);
    pdi_tensor_multiply_transposed_b(part, s->axis, out);
}

/* out = a F^-T: first Piola-Kirchhoff stress of a Kirchhoff stress. */
static void pdi_constitutive_law_pull_back(const pdi_constitutive_law_spectrum *s, const double *a, double *out)
{
    pdi_tensor_multiply(a, s->cofactor, out);
    for (int k = 0; k < PDI_TENSOR; k++) out[k] /= s->det;
}

/* Kirchhoff stress tau [Pa] of the principal stresses. */
static void pdi_constitutive_law_compute_kirchhoff(const pdi_constitutive_law_spectrum *s, double *tau)
{
    double hat[PDI_TENSOR] = {0.0};
    for (int a = 0; a < PD_DIM; a++) hat[a * PD_DIM + a] = s->stress[a];
    pdi_constitutive_law_rotate_back(s, hat, tau);
}

/* (e_a - e_b)/(b_a - b_b) for eigenvalues a, b with e = ln(b)/2. */
static double pdi_constitutive_law_difference_quotient(double a, double b)
{
    double x = (a - b) / b;
    if (fabs(x) < PDI_CONSTITUTIVE_LAW_CLOSE_EIGENVALUES) return 0.5 * (1.0 - x / 2.0 + x * x / 3.0) / b;
    return 0.5 * log1p(x) / (x * b);
}

/* Derivative of the first Piola-Kirchhoff stress tau F^-T along df: (d tau - tau L^T) F^-T with L = dF F^-1, in
 * principal axes. */
static void pdi_constitutive_law_spectral_tangent(const pdi_constitutive_law_spectrum *s, const double *df, double *dp)
{
    double l[PDI_TENSOR], part[PDI_TENSOR], hat[PDI_TENSOR];
    pdi_tensor_multiply_transposed_b(df, s->cofactor, l);
    for (int k = 0; k < PDI_TENSOR; k++) l[k] /= s->det;
    pdi_tensor_multiply_transposed_a(s->axis, l, part);
    pdi_tensor_multiply(part, s->axis, l);
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) {
            double change = 0.0;
            if (a == b)
                for (int c = 0; c < PD_DIM; c++) change += s->moduli[a * 3 + c] * l[c * PD_DIM + c];
            else
                change = s->slope *
                         pdi_constitutive_law_difference_quotient(s->square[a > b ? a : b], s->square[a > b ? b : a]) *
                         (l[a * PD_DIM + b] * s->square[b] + s->square[a] * l[b * PD_DIM + a]);
            hat[a * PD_DIM + b] = change - s->stress[a] * l[b * PD_DIM + a];
        }
    pdi_constitutive_law_rotate_back(s, hat, part);
    pdi_constitutive_law_pull_back(s, part, dp);
}

/* ---- any of them ---- */

PDI_FN int pdi_constitutive_law_compute_stress(const pdi_constitutive_law_params *m, const double *f,
                                               const double *state, double *p)
{
    pdi_constitutive_law_spectrum s;
    double tau[PDI_TENSOR];
    if (m->law.kind == PD_FINITE_STRAIN_NEO_HOOKEAN) return pdi_constitutive_law_neo_hookean(m, f, NULL, p);
    if (!pdi_constitutive_law_compute_spectrum(m, f, state, &s)) return 0;
    pdi_constitutive_law_compute_kirchhoff(&s, tau);
    pdi_constitutive_law_pull_back(&s, tau, p);
    return 1;
}

PDI_FN void pdi_constitutive_law_apply_tangent(const pdi_constitutive_law_params *m, const double *f,
                                               const double *state, const double *df, double *dp)
{
    pdi_constitutive_law_spectrum s;
    int good = m->law.kind == PD_FINITE_STRAIN_NEO_HOOKEAN ? pdi_constitutive_law_neo_hookean(m, f, df, dp)
                                                           : pdi_constitutive_law_compute_spectrum(m, f, state, &s);
    if (good && m->law.kind != PD_FINITE_STRAIN_NEO_HOOKEAN) pdi_constitutive_law_spectral_tangent(&s, df, dp);
    for (int k = 0; k < PDI_TENSOR && !good; k++) dp[k] = 0.0;
}

PDI_FN void pdi_constitutive_law_compute_tangent(const pdi_constitutive_law_params *m, const double *f,
                                                 const double *state, double *moduli)
{
    pdi_constitutive_law_spectrum s;
    int neo = m->law.kind == PD_FINITE_STRAIN_NEO_HOOKEAN,
        good = neo || pdi_constitutive_law_compute_spectrum(m, f, state, &s);
    for (int row = 0, k = 0; row < PDI_TENSOR; row++) {
        double df[PDI_TENSOR] = {0.0}, dp[PDI_TENSOR] = {0.0};
        df[row] = 1.0;
        if (neo) pdi_constitutive_law_neo_hookean(m, f, df, dp);
        else if (good) pdi_constitutive_law_spectral_tangent(&s, df, dp);
        for (int q = row; q < PDI_TENSOR; q++) moduli[k++] = dp[q];
    }
}

PDI_FN int pdi_constitutive_law_compute_cauchy(const pdi_constitutive_law_params *m, const double *f,
                                               const double *state, double *stress, double *across)
{
    pdi_constitutive_law_spectrum s;
    double p[PDI_TENSOR], turned[PDI_TENSOR], det = pdi_tensor_compute_cofactor(f, turned);
    if (!(det > 0.0) || !(det < HUGE_VAL)) return 0;
    if (m->law.kind == PD_FINITE_STRAIN_NEO_HOOKEAN) {
        pdi_constitutive_law_neo_hookean(m, f, NULL, p);
        pdi_tensor_multiply_transposed_b(p, f, stress);
        double log_det = log(det), y = pdi_constitutive_law_stress_free_stretch(m, log_det);
        det *= exp(m->free * y);
        *across = m->mu * expm1(2.0 * y) + m->lambda * (log_det + m->free * y);
    } else {
        if (!pdi_constitutive_law_compute_spectrum(m, f, state, &s)) return 0;
        pdi_constitutive_law_compute_kirchhoff(&s, stress);
        *across = s.stress[2];
        if (m->free)
            det *= exp(m->free * (s.strain[2] - (state ? 0.5 * log1p(state[PDI_CONSTITUTIVE_LAW_STATE - 2]) : 0.0)));
    }
    for (int k = 0; k < PDI_TENSOR; k++) stress[k] /= det;
    *across /= det;
    return 1;
}

PDI_FN double pdi_constitutive_law_compute_energy(const pdi_constitutive_law_params *m, const double *f,
                                                  const double *state, int plastic)
{
    pdi_constitutive_law_spectrum s;
    double bulk = m->lambda + 2.0 * m->mu / 3.0, trace = 0.0, size = 0.0, slope, work = 0.0;
    if (m->law.kind == PD_FINITE_STRAIN_NEO_HOOKEAN) return pdi_constitutive_law_neo_hookean_energy(m, f);
    if (!pdi_constitutive_law_compute_spectrum(m, f, state, &s)) return HUGE_VAL;
    for (int a = 0; a < 3; a++) trace += s.strain[a];
    for (int a = 0; a < 3; a++) size += pow(s.slope * (s.strain[a] - trace / 3.0), 2.0);
    if (plastic && m->law.kind == PD_FINITE_STRAIN_J2)
        pdi_constitutive_law_yield_stress(&m->law, (state ? state[PDI_CONSTITUTIVE_LAW_STATE - 1] : 0.0) + s.flow,
                                          &slope, &work);
    return 0.5 * bulk * trace * trace + 0.25 * size / m->mu + work;
}

PDI_FN double pdi_constitutive_law_commit(const pdi_constitutive_law_params *m, const double *f, double *state)
{
    pdi_constitutive_law_spectrum s;
    double hat[PDI_TENSOR] = {0.0}, b[PDI_TENSOR], part[PDI_TENSOR], g[PDI_TENSOR], left[3];
    double *slip = state + PDI_CONSTITUTIVE_LAW_STATE - 1, slope, before, after;
    if (!pdi_constitutive_law_compute_spectrum(m, f, state, &s) || !(s.flow > 0.0)) return 0.0;
    double trace = s.strain[0] + s.strain[1] + s.strain[2];
    for (int a = 0; a < 3; a++)
        left[a] = trace / 3.0 + 0.5 * s.slope / m->mu * (s.strain[a] - trace / 3.0);
    for (int a = 0; a < PD_DIM; a++) hat[a * PD_DIM + a] = exp(2.0 * left[a]);
    pdi_constitutive_law_rotate_back(&s, hat, b);
    pdi_constitutive_law_pull_back(&s, b, part);
    pdi_tensor_multiply_transposed_a(s.cofactor, part, g); /* F^-1 b F^-T = (cofactor^T/det) b F^-T */
    for (int p = 0, k = 0; p < PD_DIM; p++)
        for (int q = p; q < PD_DIM; q++)
            state[k++] = 0.5 * (g[p * PD_DIM + q] + g[q * PD_DIM + p]) / s.det - (p == q ? 1.0 : 0.0);
    if (PD_DIM < 3) {
        double across = (1.0 + state[PDI_CONSTITUTIVE_LAW_STATE - 2]) * exp(2.0 * (left[2] - s.strain[2]));
        state[PDI_CONSTITUTIVE_LAW_STATE - 2] = across - 1.0;
    }
    pdi_constitutive_law_yield_stress(&m->law, *slip, &slope, &before);
    *slip += s.flow;
    pdi_constitutive_law_yield_stress(&m->law, *slip, &slope, &after);
    return after - before;
}

#undef PDI_CONSTITUTIVE_LAW_ROUNDING
#undef PDI_CONSTITUTIVE_LAW_MAX_NEWTON
#undef PDI_CONSTITUTIVE_LAW_MAX_SWEEPS
#undef PDI_CONSTITUTIVE_LAW_OFF_DIAGONAL
#undef PDI_CONSTITUTIVE_LAW_CLOSE_EIGENVALUES
