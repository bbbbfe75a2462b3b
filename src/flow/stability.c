/* stability: see stability.h */
#include "flow/stability.h"
#include "core/array_registry.h"
#include "core/vec.h"
#include "core/rng.h"
#include "lattice/op.h"
#include <math.h>
#include <string.h>

/* Wave numbers along an axis for each node of the reach: eigenvalues rise by 3 % at most between two of them. */
#define PDI_STABILITY_WAVES_PER_NODE 4
#define PDI_STABILITY_MAX_REFINEMENTS 6 /* halvings of the spacing of wave numbers around the worst */
#define PDI_STABILITY_LANCZOS_STEPS 40  /* Lanczos steps for the norm of a gradient with cut families */
#define PDI_STABILITY_ANGLES 48         /* samples of the part of the energy that is in the density */
#define PDI_STABILITY_SAFETY 0.98       /* [-] for waves between the sampled ones, and unconverged Lanczos steps */
#define PDI_STABILITY_IMAGINARY_LIMIT 1.7320508075688772 /* sqrt(3): stability limit on the imaginary axis */

/* ---- the region of 1 + z + z^2/2 + z^3/6 ---- */

/* 1: z = re + i im is in the stability region |1 + z + z^2/2 + z^3/6| <= 1. */
static int pdi_stability_is_stable(double re, double im)
{
    double pr = 0.5 + re / 6.0, pi = im / 6.0, next;
    for (int k = 0; k < 2; k++) { /* Horner's scheme */
        next = 1.0 + re * pr - im * pi;
        pi = re * pi + im * pr;
        pr = next;
    }
    return pr * pr + pi * pi <= 1.0 + 1e-10;
}

/* Lowers *dt until dt times the eigenvalue re + i im [1/s] is stable, by bisection between 0 and *dt; a stable *dt
 * stays. A positive re counts as 0. */
static void pdi_stability_limit_step(double re, double im, double *dt)
{
    re = pd_min(re, 0.0);
    if (pdi_stability_is_stable(*dt * re, *dt * im)) return;
    double low = 0.0, high = *dt;
    for (int k = 0; k < 40; k++) {
        double middle = 0.5 * (low + high);
        if (pdi_stability_is_stable(middle * re, middle * im)) low = middle;
        else high = middle;
    }
    *dt = low;
}

/* ---- waves ---- */

/* Symbols of the stencil at the wave vector k [rad per node]: gradient [PD_DIM] [1/m]; laplacian, of -Laplacian [1/m2];
 * diffusion, of the density diffusion [1/m2]. Opposite bonds go in pairs. */
static void pdi_stability_compute_symbols(const pd_stencil *s, const double *k, double *gradient, double *laplacian,
                                          double *diffusion)
{
    double g[PD_DIM], flux[PD_DIM];
    *laplacian = 0.0;
    for (int d = 0; d < PD_DIM; d++) g[d] = flux[d] = 0.0;
    for (int n = 0; n < s->count / 2; n++) {
        double phase = 0.0;
        for (int d = 0; d < PD_DIM; d++) phase += k[d] * s->offset[n * PD_DIM + d];
        double sine = sin(phase);
        *laplacian += 2.0 * s->laplacian_weight[n] * (1.0 - cos(phase));
        for (int d = 0; d < PD_DIM; d++) {
            g[d] += 2.0 * s->gradient_weight[n * PD_DIM + d] * sine;
            flux[d] += s->laplacian_weight[n] * s->xi[n * PD_DIM + d] * sine;
        }
    }
    *diffusion = *laplacian;
    for (int d = 0; d < PD_DIM; d++) {
        gradient[d] = fabs(g[d]);
        *diffusion -= flux[d] * g[d];
    }
}

/* Lowers *dt for one wave in a stream of `speed` [m/s] along its gradient. With symbols i G and -L and the
 * stabilisation T: sound l = -i G v + m, m^2 + (nu L + T) m + nu L T + G^2 c^2 + i G v T/2 = 0; shear l = -i G v - nu L
 * (eq. 3.38). */
static void pdi_stability_limit_by_wave(const pdi_stability_state *q, double gradient, double laplacian,
                                        double diffusion, double speed, double *dt)
{
    double v = q->viscosity * laplacian, t = q->stabilisation * diffusion, shift = -gradient * speed;
    double re = 0.25 * (v - t) * (v - t) - gradient * gradient * q->sound_speed * q->sound_speed,
           im = -0.5 * gradient * speed * t;
    double size = sqrt(re * re + im * im);
    double root_re = sqrt(0.5 * pd_max(size + re, 0.0)), root_im = sqrt(0.5 * pd_max(size - re, 0.0));
    if (im < 0.0) root_im = -root_im;
    pdi_stability_limit_step(-0.5 * (v + t) + root_re, shift + root_im, dt);
    pdi_stability_limit_step(-0.5 * (v + t) - root_re, shift - root_im, dt);
    pdi_stability_limit_step(-v, shift, dt);
}

/* Lowers *dt for one wave in a fluid at rest, and in the fastest stream unless max_velocity has no component along it:
 * eigenvalues of all others lie between. */
static void pdi_stability_limit_by_streams(const pdi_stability_state *q, const double *gradient, double laplacian,
                                           double diffusion, double *dt)
{
    double square = 0.0, along = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        square += gradient[d] * gradient[d];
        along += gradient[d] * q->max_velocity[d];
    }
    double size = sqrt(square);
    pdi_stability_limit_by_wave(q, size, laplacian, diffusion, 0.0, dt);
    if (along > 0.0) pdi_stability_limit_by_wave(q, size, laplacian, diffusion, along / size, dt);
}

/* Wave vector k [PD_DIM] [rad per node] of the wave with this index. */
static void pdi_stability_get_wave_vector(const pd_stability *sp, int wave, double *k)
{
    for (int d = 0; d < PD_DIM; d++) {
        k[d] = PD_PI * (wave % sp->waves_per_axis) / (sp->waves_per_axis - 1);
        wave /= sp->waves_per_axis;
    }
}

/* Lowers *dt by a search for the worst wave around k [PD_DIM] [rad per node]: a step up and down along one axis after
 * the other, halved six times from the spacing of the sampled waves. k moves to it. */
static void pdi_stability_limit_by_refined_waves(const pd_stability *sp, const pdi_stability_state *q, double *k,
                                                 double *dt)
{
    double step = PD_PI / (sp->waves_per_axis - 1), gradient[PD_DIM], laplacian, diffusion;
    for (int level = 0; level < PDI_STABILITY_MAX_REFINEMENTS; level++) {
        step *= 0.5;
        for (int d = 0; d < PD_DIM; d++)
            for (int side = 0; side < 2; side++) {
                double before = *dt, at = k[d];
                k[d] = side ? at + step : at - step;
                pdi_stability_compute_symbols(sp->stencil, k, gradient, &laplacian, &diffusion);
                pdi_stability_limit_by_streams(q, gradient, laplacian, diffusion, dt);
                if (!(*dt < before)) k[d] = at;
            }
    }
}

/* Longest stable step [s] without cut families: the worst of all waves (eq. 3.38). */
static double pdi_stability_limit_by_waves(const pd_stability *sp, const pdi_stability_state *q)
{
    double dt, k[PD_DIM];
    int worst = 0;
    /* the region lies within 2.6 of the origin */
    dt = 2.6 / (q->viscosity * sp->max_laplacian);
    for (int w = 0; w < sp->waves; w++) {
        double before = dt;
        pdi_stability_limit_by_streams(q, sp->gradient_symbol + (int64_t)w * PD_DIM, sp->laplacian_symbol[w],
                                       sp->diffusion_symbol[w], &dt);
        if (dt < before) worst = w;
    }
    pdi_stability_get_wave_vector(sp, worst, k);
    pdi_stability_limit_by_refined_waves(sp, q, k, &dt);
    return dt;
}

/* ---- surfaces ---- */

/* Longest stable step [s] with cut families, from operator norms (eq. 3.39): with the part cos^2 of the energy in the
 * density, dissipation is at most x, sound and stream at most y, so the numerical range lies in these rectangles. */
static double pdi_stability_limit_by_norms(const pd_stability *sp, const pdi_stability_state *q)
{
    double speed = 0.0, dt = HUGE_VAL;
    for (int d = 0; d < PD_DIM; d++) speed += q->max_velocity[d] * q->max_velocity[d];
    speed = sqrt(speed);
    for (int a = 0; a <= PDI_STABILITY_ANGLES; a++) {
        double angle = 0.5 * PD_PI * a / PDI_STABILITY_ANGLES, c = cos(angle), s = sin(angle);
        double x = c * c * q->stabilisation * sp->max_laplacian +
                   s * s * q->viscosity * (sp->max_laplacian + sp->wall_increase);
        double y = sp->gradient_norm * (2.0 * s * c * q->sound_speed + speed);
        dt = pd_min(dt, y > 0.0 ? PDI_STABILITY_IMAGINARY_LIMIT / y : HUGE_VAL);
        if (!(dt < HUGE_VAL)) dt = 2.6 / x;
        pdi_stability_limit_step(-x, y, &dt);
    }
    return dt;
}

PDI_FN double pdi_stability_compute_limit(const pd_stability *sp, const pdi_stability_state *q)
{
    return PDI_STABILITY_SAFETY *
           (sp->has_cut_families ? pdi_stability_limit_by_norms(sp, q) : pdi_stability_limit_by_waves(sp, q));
}

/* ---- build ---- */

/* Fields of the Lanczos iteration. */
typedef struct pdi_stability_lanczos_fields {
    const pd_flow *flow;
    double *now, *before, *after; /* [total] */
    double *grad, *advecting;     /* [PD_DIM][total] */
} pdi_stability_lanczos_fields;

/* after = -div (1 - wall curvature weight) grad now [1/m2 of now]: the self-adjoint acoustic operator with walls, 0
 * outside of fluid nodes. Fills the ghosts of now; grad and advecting are work. */
static void pdi_stability_apply_acoustic_operator(const pd_ctx *ctx, pdi_stability_lanczos_fields *w)
{
    const pd_bonds *bonds = w->flow->bonds;
    int64_t total = w->flow->grid->total;
    pdi_ghosts_set_pressure(&bonds->ghosts, 0.0, w->now);
    pd_op_gradient(ctx, bonds, w->now, w->grad);
    for (int32_t r = 0; r < bonds->rows; r++)
        for (int d = 0; d < PD_DIM; d++)
            w->grad[d * total + bonds->node[r]] *= pd_max(1.0 - bonds->wall_curvature[r], 0.0);
    pd_ghosts_set_vector(&bonds->ghosts, w->grad);
    pdi_flow_compute_advecting_velocity(ctx, w->flow, w->grad, NULL, w->advecting);
    pd_op_divergence(ctx, bonds, w->advecting, w->after);
    for (int64_t i = 0; i < total; i++)
        w->after[i] = w->flow->grid->kind[i] == PD_FLUID ? -w->after[i] : 0.0;
}

/* Inner product over fluid nodes, weighted by the circumference in axisymmetric lattices. */
static double pdi_stability_compute_dot(const pd_grid *grid, const double *a, const double *b)
{
    double sum = 0.0;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) sum += a[i] * b[i] * pd_grid_circumference(grid, i);
    return sum;
}

/* Largest eigenvalue, at least 0, of a symmetric tridiagonal matrix by Sturm bisection. off [n - 1]: squares of the
 * elements beside the diagonal. */
static double pdi_stability_compute_max_tridiagonal(int n, const double *diagonal, const double *off)
{
    double high = 0.0, low = 0.0;
    for (int i = 0; i < n; i++) {
        double radius = sqrt(i ? off[i - 1] : 0.0) + sqrt(i < n - 1 ? off[i] : 0.0);
        high = pd_max(high, diagonal[i] + radius);
    }
    for (int k = 0; k < 60; k++) {
        double middle = 0.5 * (low + high), pivot = 1.0;
        int above = 0;
        for (int i = 0; i < n; i++) {
            pivot = middle - diagonal[i] - (i ? off[i - 1] / pivot : 0.0);
            if (!(fabs(pivot) > 0.0)) pivot = 1e-300;
            above += pivot < 0.0;
        }
        if (above) low = middle;
        else high = middle;
    }
    return high;
}

/* Largest eigenvalue [1/m2], at least 0, of pdi_stability_apply_acoustic_operator by at most 40 Lanczos steps from a
 * fixed sequence of random numbers: an estimate from below. Ends where the next vector is 1e-12 of the largest diagonal
 * element; 0 without fluid nodes. */
static double pdi_stability_estimate_max_eigenvalue(const pd_ctx *ctx, pdi_stability_lanczos_fields *w)
{
    const pd_grid *grid = w->flow->grid;
    double diagonal[PDI_STABILITY_LANCZOS_STEPS], off[PDI_STABILITY_LANCZOS_STEPS], size, last = 0.0;
    int n = 0;
    for (int32_t i = 0; i < grid->total; i++)
        w->now[i] = grid->kind[i] == PD_FLUID ? pdi_rng_uniform(1, 0, (uint64_t)i) - 0.5 : 0.0;
    size = sqrt(pdi_stability_compute_dot(grid, w->now, w->now));
    while (n < PDI_STABILITY_LANCZOS_STEPS && size > 1e-12 * last && size > 0.0) {
        for (int32_t i = 0; i < grid->total; i++) w->now[i] /= size;
        pdi_stability_apply_acoustic_operator(ctx, w);
        diagonal[n] = pdi_stability_compute_dot(grid, w->now, w->after);
        for (int32_t i = 0; i < grid->total; i++) {
            double next = w->after[i] - diagonal[n] * w->now[i] - (n ? size * w->before[i] : 0.0);
            w->before[i] = w->now[i];
            w->now[i] = grid->kind[i] == PD_FLUID ? next : 0.0;
        }
        last = pd_max(last, fabs(diagonal[n]));
        off[n++] = pdi_stability_compute_dot(grid, w->now, w->now);
        size = sqrt(off[n - 1]);
    }
    return n ? pdi_stability_compute_max_tridiagonal(n, diagonal, off) : 0.0;
}

/* *norm [1/m] = norm of the gradient with cut families. */
static pd_status pdi_stability_estimate_gradient_norm(pd_ctx *ctx, const pd_flow *flow, double *norm)
{
    int64_t total = flow->grid->total, size = (2 * PD_DIM + 3) * total;
    double *field = NULL;
    pdi_stability_lanczos_fields w;
    PD_TRY(PD_NEW(ctx, "spectrum", size, field));
    w.flow = flow;
    w.now = field;
    w.before = w.now + total;
    w.after = w.before + total;
    w.grad = w.after + total;
    w.advecting = w.grad + PD_DIM * total;
    *norm = sqrt(pdi_stability_estimate_max_eigenvalue(ctx, &w));
    PD_DELETE(ctx, size, field);
    return PD_OK;
}

/* Largest increase [1/m2], at least 0, of the eigenvalues of -lap by walls: maximum over rows of wall_laplacian less
 * the weights of closed bonds. A cut bond counts 1/t of its weight at the node, where without the wall it would count
 * once (eq. 2.3). */
static double pdi_stability_compute_wall_increase(const pd_bonds *bonds)
{
    double most = 0.0;
    for (int32_t r = 0; r < bonds->rows; r++) {
        const double *lap = pdi_bond_get_laplacian_weights(bonds, bonds->node[r]);
        double more = bonds->wall_laplacian[r];
        for (int k = 0; k < bonds->stencil->count; k++)
            if (!pdi_bond_is_open(bonds, r, k)) more -= lap[k];
        most = pd_max(most, more);
    }
    return most;
}

/* Bound [1/m2] of the eigenvalues of -lap on axisymmetric lattices: largest row sum. */
static double pdi_stability_compute_ring_bound(const pd_bonds *bonds)
{
    double most = 0.0;
    for (int32_t i = 0; i < bonds->grid->total; i++) {
        double sum = 0.0;
        if (bonds->grid->kind[i] != PD_FLUID) continue;
        for (int k = 0; k < bonds->stencil->count; k++) sum += 2.0 * fabs(pdi_bond_get_laplacian_weights(bonds, i)[k]);
        if (bonds->axisym.hoop) sum += bonds->axisym.hoop[i / bonds->grid->stride[PD_DIM - 1]];
        most = pd_max(most, sum);
    }
    return most;
}

/* Lists the arrays of a pd_stability. */
static void pdi_stability_list(pdi_array_visitor *owner, void *object)
{
    pd_stability *spectrum = (pd_stability *)object;
    PDI_ARRAY(owner, spectrum, gradient_symbol, (int64_t)spectrum->waves * PD_DIM, "1/m");
    PDI_ARRAY(owner, spectrum, laplacian_symbol, spectrum->waves, "1/m2");
    PDI_ARRAY(owner, spectrum, diffusion_symbol, spectrum->waves, "1/m2");
}

PDI_FN pd_status pdi_stability_build(pd_ctx *ctx, const pd_flow *flow, pd_stability *sp)
{
    const pd_stencil *s = flow->bonds->stencil;
    memset(sp, 0, sizeof *sp);
    sp->stencil = s;
    sp->waves_per_axis = PDI_STABILITY_WAVES_PER_NODE * (s->reach + 1);
    sp->waves = 1;
    for (int d = 0; d < PD_DIM; d++) sp->waves *= sp->waves_per_axis;
    sp->has_cut_families = flow->bonds->rows > 0 || flow->bonds->axisym.laplacian_weight;
    PD_TRY(pdi_array_registry_build(ctx, pdi_stability_list, sp));
    for (int w = 0; w < sp->waves; w++) {
        double k[PD_DIM];
        pdi_stability_get_wave_vector(sp, w, k);
        pdi_stability_compute_symbols(s, k, sp->gradient_symbol + (int64_t)w * PD_DIM, &sp->laplacian_symbol[w],
                                      &sp->diffusion_symbol[w]);
        sp->max_laplacian = pd_max(sp->max_laplacian, sp->laplacian_symbol[w]);
    }
    if (!sp->has_cut_families) return PD_OK;
    if (flow->bonds->axisym.laplacian_weight) sp->max_laplacian = pdi_stability_compute_ring_bound(flow->bonds);
    sp->wall_increase = pdi_stability_compute_wall_increase(flow->bonds);
    return pdi_stability_estimate_gradient_norm(ctx, flow, &sp->gradient_norm);
}

PDI_FN void pdi_stability_free(pd_ctx *ctx, pd_stability *sp)
{
    pdi_array_registry_free(ctx, pdi_stability_list, sp);
    memset(sp, 0, sizeof *sp);
}
