/* krylov: see krylov.h */
#include "solve/krylov.h"
#include "solve/arnoldi.h"
#include "solve/hessenberg.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* [-] Stagnation: a restart cycle reduces the true residual by less than this factor. */
#define PDI_KRYLOV_STALLED 0.999
/* [-] Ratio p.Ap / p.Dp that is rounding: a few units in the last place for the sum over the bonds of a row. */
#define PDI_KRYLOV_SINGULAR (16.0 * DBL_EPSILON)

/* State of one solve, for both methods. */
typedef struct pdi_krylov_state {
    pd_ctx *ctx;
    pd_krylov *k;
    pd_apply_fn apply, precond;
    void *user;
    const double *b;
    double *x;
    double *v, *w; /* GMRES: [n] the two work vectors, which are swapped */
    /* [unit of b] |b|; tolerance; GMRES: residual of a cycle by its recurrence */
    double b_norm, target, recurrence_norm;
    pd_krylov_result *result;
} pdi_krylov_state;

/* Work vector i, [n]. */
static double *pdi_krylov_vector(const pdi_krylov_state *run, int i)
{
    return run->k->work + (int64_t)i * run->k->desc.n;
}

/* PDI_PAR_GROUP basis vectors from `first` on, all pointers NULL for numbers that have none; the preconditioned basis
 * is numbered after the basis (pdi_krylov_precond_first). */
static pdi_par_vector_group pdi_krylov_get_group(const void *user, int first)
{
    const pdi_krylov_state *run = (const pdi_krylov_state *)user;
    pdi_par_vector_group v;
    int integers = run->k->desc.basis_precision == PD_KRYLOV_INT16;
    for (int m = 0; m < PDI_PAR_GROUP; m++) {
        float *single = pdi_krylov_get_single(run->k, first + m);
        v.doubles[m] = pdi_krylov_get_double(run->k, first + m);
        v.floats[m] = integers ? NULL : single;
        v.integers[m] = integers ? (const int16_t *)(const void *)single : NULL;
        v.scales[m] = integers && single ? single + pdi_krylov_integer_size(run->k->length) : NULL;
    }
    return v;
}

/* Number of entries from desc.first to desc.end. */
static int64_t pdi_krylov_active_length(const pd_krylov_desc *d) { return d->end ? d->end - d->first : d->n; }

/* Vector operations over the entries from desc.first to desc.end: u.v, v += a u, v = u. */
static double pdi_krylov_dot(const pdi_krylov_state *run, const double *u, const double *v)
{
    int64_t first = run->k->desc.first;
    return pdi_par_dot(run->ctx, pdi_krylov_active_length(&run->k->desc), u + first, v + first);
}

static void pdi_krylov_axpy(const pdi_krylov_state *run, double a, const double *u, double *v)
{
    int64_t first = run->k->desc.first;
    pdi_par_axpy(run->ctx, pdi_krylov_active_length(&run->k->desc), a, u + first, v + first);
}

static void pdi_krylov_copy(const pdi_krylov_state *run, const double *u, double *v)
{
    int64_t first = run->k->desc.first;
    pdi_par_copy(run->ctx, pdi_krylov_active_length(&run->k->desc), u + first, v + first);
}

/* v = a v + u over the entries from desc.first to desc.end. */
static void pdi_krylov_scale_add(const pdi_krylov_state *run, double a, double *v, const double *u)
{
    int64_t first = run->k->desc.first, end = first + pdi_krylov_active_length(&run->k->desc);
    int nt = pd_par_threads(run->ctx, end - first);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = first; i < end; i++) v[i] = a * v[i] + u[i];
}

/* v = A u by the callback, which is counted. */
static void pdi_krylov_apply(const pdi_krylov_state *run, const double *u, double *v)
{
    run->apply(run->user, u, v);
    run->result->applies++;
}

/* v = M^-1 u by the callback, which is counted; without one v = u. */
static void pdi_krylov_precond(const pdi_krylov_state *run, const double *u, double *v)
{
    if (run->precond) {
        run->precond(run->user, u, v);
        run->result->precond_applies++;
    } else
        pdi_krylov_copy(run, u, v);
}

/* r = b - A x by one application of A; returns |r|. */
static double pdi_krylov_residual(const pdi_krylov_state *run, double *r)
{
    pdi_krylov_apply(run, run->x, r);
    pdi_krylov_scale_add(run, -1.0, r, run->b);
    return sqrt(pdi_krylov_dot(run, r, r));
}

static int pdi_krylov_is_finite(double value) { return value >= -DBL_MAX && value <= DBL_MAX; }

static const char *pdi_krylov_name(const pdi_krylov_state *run)
{
    return run->k->desc.equations ? run->k->desc.equations : "krylov";
}

/* PD_ERR_DIVERGED: what a callback returned is not finite. */
static pd_status pdi_krylov_fail_nan(const pdi_krylov_state *run, const char *what)
{
    return pd_fail(run->ctx, PD_ERR_DIVERGED, pdi_krylov_name(run),
                   "%s is not finite in iteration %d of its linear solver: expected values and steps whose products "
                   "a double holds",
                   what, run->result->iterations);
}

/* PD_NOT_CONVERGED: the iteration ends, and why. */
static pd_status pdi_krylov_fail_stall(const pdi_krylov_state *run, const char *why)
{
    return pd_fail(run->ctx, PD_NOT_CONVERGED, pdi_krylov_name(run),
                   "%s after %d iterations: residual %.3g, target %.3g", why, run->result->iterations,
                   run->result->residual, run->target);
}

/* ---- GMRES: x += M^-1 V y, y minimises |beta e1 - H y| ---- */

/* Gather the entries that the basis stores: returns `full` itself without spans, else a copy in `scratch`. */
static double *pdi_krylov_pack(const pdi_krylov_state *run, double *full, double *scratch)
{
    const pd_krylov_desc *d = &run->k->desc;
    if (!d->spans) return full;
    pdi_active_range_pack(run->ctx, d->spans, d->components, full, scratch);
    return scratch;
}

/* Scatter them into a full vector; its other entries, which are zero, stay. Without spans it does nothing. */
static void pdi_krylov_unpack(const pdi_krylov_state *run, const double *packed, double *full)
{
    const pd_krylov_desc *d = &run->k->desc;
    if (d->spans) pdi_active_range_unpack(run->ctx, d->spans, d->components, packed, full);
}

/* Zero a work vector before callbacks write to it: they do not write all entries. With low_memory all of it, with spans
 * the packed part, else nothing. */
static void pdi_krylov_zero_scratch(const pdi_krylov_state *run, double *scratch)
{
    const pd_krylov_desc *d = &run->k->desc;
    if (d->low_memory || d->spans) pdi_par_zero(run->ctx, d->low_memory ? d->n : run->k->length, scratch);
}

/* v = a v, stored as basis vector i, and rounded in v to the stored precision: A Z = V H holds for stored vectors. */
static void pdi_krylov_store_vector(const pdi_krylov_state *run, double a, double *v, int i)
{
    int64_t n = run->k->length;
    if (run->k->desc.basis_precision == PD_KRYLOV_INT16) {
        float *single = pdi_krylov_get_single(run->k, i);
        pdi_par_scale_quantise(run->ctx, n, a, v, (int16_t *)(void *)single, single + pdi_krylov_integer_size(n));
        return;
    }
    pdi_par_scale_store(run->ctx, n, a, v, pdi_krylov_get_double(run->k, i), pdi_krylov_get_single(run->k, i));
}

/* v = sum over j < count of y[j] times basis vector first + j. scratch: overwritten with spans. */
static void pdi_krylov_combine(const pdi_krylov_state *run, int first, int count, const double *y, double *scratch,
                               double *v)
{
    double *sum = run->k->desc.spans ? scratch : v;
    pdi_par_zero(run->ctx, run->k->length, sum);
    for (int j = 0; j < count; j += PDI_PAR_GROUP) {
        pdi_par_vector_group basis = pdi_krylov_get_group(run, first + j);
        int group = count - j < PDI_PAR_GROUP ? count - j : PDI_PAR_GROUP;
        pdi_par_multi_axpy(run->ctx, run->k->length, group, y + j, &basis, sum);
    }
    pdi_krylov_unpack(run, sum, v);
}

/* Power of two that scales the largest |z| to 1/2 .. 1, since x may exceed the range of single precision; 1 where z is
 * zero or not finite. */
static double pdi_krylov_power_of_two(const pdi_krylov_state *run, const double *z)
{
    int exponent = 0;
    double largest = pdi_par_max_abs(run->ctx, run->k->length, z);
    if (largest > 0.0 && largest <= DBL_MAX) frexp(largest, &exponent);
    return ldexp(1.0, -exponent);
}

/* Views of `dense`: rotations, right-hand side, coefficients and Hessenberg matrix of a cycle. */
typedef struct pdi_krylov_dense_views {
    double *cs, *sn, *g, *y, *hess;
} pdi_krylov_dense_views;

/* The parts of the dense work array: Hessenberg matrix, rotations, right-hand side, coefficients. */
static pdi_krylov_dense_views pdi_krylov_get_dense(const pd_krylov *krylov)
{
    int most = krylov->desc.max_vectors + 1;
    pdi_krylov_dense_views s;
    s.cs = krylov->dense;
    s.sn = s.cs + most;
    s.g = s.sn + most;
    s.y = s.g + most;
    s.hess = s.y + most;
    return s;
}

/* Exchange the work vectors v and w. */
static void pdi_krylov_swap_work(pdi_krylov_state *run)
{
    double *v = run->v;
    run->v = run->w;
    run->w = v;
}

/* Returns A M^-1 v, packed, for column j; all vectors of this share v and w. Without a preconditioner it is A v.
 * Flexible: stores M^-1 v times *unit, a power of two that column 0 sets and all columns use. */
static double *pdi_krylov_expand(pdi_krylov_state *run, int j, int flexible, double *unit)
{
    if (!run->precond) {
        pdi_krylov_apply(run, run->v, run->w);
        pdi_krylov_swap_work(run); /* v is that vector */
        return pdi_krylov_pack(run, run->v, run->w);
    }
    pdi_krylov_precond(run, run->v, run->w);
    if (flexible) {
        double *packed = pdi_krylov_pack(run, run->w, run->v);
        if (j == 0) *unit = pdi_krylov_power_of_two(run, packed);
        pdi_krylov_store_vector(run, *unit, packed, pdi_krylov_precond_first(run->k) + j);
        pdi_krylov_unpack(run, packed, run->w);
        pdi_krylov_zero_scratch(run, run->v);
    }
    pdi_krylov_apply(run, run->w, run->v);
    return pdi_krylov_pack(run, run->v, run->w);
}

/* v = the correction from `count` columns, w = the old x, x += v; with low_memory only v. PD_ERR_DIVERGED: the
 * correction is not finite, and x stays. */
static pd_status pdi_krylov_add_correction(pdi_krylov_state *run, int flexible, int count, const double *y)
{
    int first = flexible ? pdi_krylov_precond_first(run->k) : 0;
    pdi_krylov_combine(run, first, count, y, run->w, run->v);
    if (run->precond && !flexible) {
        pdi_krylov_zero_scratch(run, run->w);
        pdi_krylov_precond(run, run->v, run->w);
        pdi_krylov_swap_work(run);
    }
    if (!pdi_krylov_is_finite(pdi_krylov_dot(run, run->v, run->v))) return pdi_krylov_fail_nan(run, "the correction");
    if (run->k->desc.low_memory) return PD_OK;
    pdi_krylov_copy(run, run->x, run->w);
    pdi_krylov_axpy(run, 1.0, run->v, run->x);
    return PD_OK;
}

/* One restart cycle from the residual in v (norm beta): x += correction, w = old x; with low_memory the correction is
 * left in v. It ends at 0.9 of the tolerance by the recurrence, in an invariant space (rounding is left of a column),
 * at the iteration limit, at `restart` with fixed_restart, or where the basis is full. Counts iterations, may grow the
 * basis, and sets recurrence_norm to the residual of the recurrence. Errors leave x: PD_ERR_DIVERGED (not finite),
 * PD_CANCELLED, memory with fixed_restart. */
static pd_status pdi_krylov_gmres_cycle(pdi_krylov_state *run, double beta)
{
    const pd_krylov_desc *d = &run->k->desc;
    int flexible = d->flexible && run->precond, count = 0;
    pdi_krylov_dense_views s = pdi_krylov_get_dense(run->k);
    double unit = 1.0, *packed = pdi_krylov_pack(run, run->v, run->w);
    pdi_krylov_store_vector(run, 1.0 / beta, packed, 0);
    pdi_krylov_unpack(run, packed, run->v);
    pdi_krylov_zero_scratch(run, run->w);
    s.g[0] = beta;
    while (run->result->iterations < d->max_iterations) {
        int j = count;
        if (d->fixed_restart && j == d->restart) break;
        if (j == pdi_krylov_capacity(run->k)) {
            int grown = pdi_krylov_grow_basis(run->ctx, run->k);
            s = pdi_krylov_get_dense(run->k); /* it may have moved even so */
            if (grown < 0) return run->ctx->status;
            if (!grown) break;
        }
        double *h = s.hess + pdi_hessenberg_column_offset(j);
        PD_TRY(pd_check_cancel(run->ctx, "GMRES", run->result->iterations));
        packed = pdi_krylov_expand(run, j, flexible, &unit);
        double before = pdi_arnoldi_orthogonalise(run->ctx, run->k->length, j, pdi_krylov_get_group, run, packed, h);
        if (!pdi_krylov_is_finite(before) || !pdi_krylov_is_finite(h[j + 1]))
            return pdi_krylov_fail_nan(run, "an operator application");
        run->result->iterations++;
        count++;
        double next = h[j + 1];
        pdi_hessenberg_rotate(j, h, s.cs, s.sn, s.g);
        /* lucky breakdown: the Krylov space is invariant */
        if (next <= DBL_EPSILON * before || fabs(s.g[count]) <= 0.9 * run->target) break;
        pdi_krylov_store_vector(run, 1.0 / next, packed, j + 1);
        pdi_krylov_unpack(run, packed, run->v);
        pdi_krylov_zero_scratch(run, run->w);
    }
    run->recurrence_norm = fabs(s.g[count]);
    pdi_hessenberg_back_substitute(count, s.hess, s.g, s.y);
    return pdi_krylov_add_correction(run, flexible, count, s.y);
}

/* ---- lean: iterates are stored in the memory of the basis between the cycles ---- */

/* Packed storage of an iterate in double: 0: the best one, in front of the basis; 1: the next one, within the basis. */
static double *pdi_krylov_get_iterate(const pdi_krylov_state *run, int which)
{
    const pd_krylov *k = run->k;
    double *front = k->desc.basis_precision ? (double *)(void *)k->compressed_basis : k->basis;
    return front + which * (k->desc.basis_precision ? pdi_krylov_iterate_size(&k->desc) * k->stride / 2 : k->length);
}

/* full = a stored iterate, scattered with spans. */
static void pdi_krylov_unpack_iterate(const pdi_krylov_state *run, const double *packed, double *full)
{
    if (run->k->desc.spans) pdi_krylov_unpack(run, packed, full);
    else pdi_par_copy(run->ctx, run->k->length, packed, full);
}

/* Compute the next iterate from the correction in v, and its true residual into v by one application of A. Returns its
 * norm. With skip_true_residual and convergence by the recurrence: returns that norm, A is not applied, and v is no
 * residual. */
static double pdi_krylov_lean_residual(pdi_krylov_state *run)
{
    double *next = pdi_krylov_get_iterate(run, 1);
    if (run->k->desc.spans) pdi_krylov_pack(run, run->v, next);
    else pdi_par_copy(run->ctx, run->k->length, run->v, next);
    if (run->k->iterate_vectors) pdi_par_axpy(run->ctx, run->k->length, 1.0, pdi_krylov_get_iterate(run, 0), next);
    if (run->k->desc.skip_true_residual && run->recurrence_norm <= run->target) return run->recurrence_norm;
    pdi_krylov_unpack_iterate(run, next, run->v);
    pdi_krylov_zero_scratch(run, run->w);
    pdi_krylov_apply(run, run->v, run->w);
    pdi_krylov_scale_add(run, -1.0, run->w, run->b);
    pdi_krylov_swap_work(run);
    pdi_krylov_zero_scratch(run, run->w);
    return sqrt(pdi_krylov_dot(run, run->v, run->v));
}

/* Copy the next iterate over the best one, whose memory in front of the basis is in use from now on. */
static void pdi_krylov_lean_accept(const pdi_krylov_state *run)
{
    pdi_par_copy(run->ctx, run->k->length, pdi_krylov_get_iterate(run, 1), pdi_krylov_get_iterate(run, 0));
    run->k->iterate_vectors = pdi_krylov_iterate_size(&run->k->desc);
}

/* End of a lean solve: copy the best iterate to x, or zeros without one, and give its memory back to the basis. */
static void pdi_krylov_lean_end(const pdi_krylov_state *run)
{
    if (run->k->iterate_vectors) pdi_krylov_unpack_iterate(run, pdi_krylov_get_iterate(run, 0), run->x);
    else pdi_par_zero(run->ctx, run->k->desc.n, run->x);
    run->k->iterate_vectors = 0;
}

/* GMRES with restarts, from the residual in v of norm `norm`, until its true norm is at most the tolerance.
 * PD_NOT_CONVERGED: iteration limit, or stagnation: a cycle leaves more than PDI_KRYLOV_STALLED of the norm.
 * PD_ERR_DIVERGED: a residual is not finite. Where a cycle raises the norm or spoils it, x goes back to the iterate
 * before. result->residual: norm of the returned x. */
static pd_status pdi_krylov_gmres(pdi_krylov_state *run, double norm)
{
    const pd_krylov_desc *d = &run->k->desc;
    while (norm > run->target) {
        if (run->result->iterations >= d->max_iterations) return pdi_krylov_fail_stall(run, "no convergence");
        PD_TRY(pdi_krylov_gmres_cycle(run, norm));
        double fresh = d->low_memory ? pdi_krylov_lean_residual(run) : pdi_krylov_residual(run, run->v);
        if (!pdi_krylov_is_finite(fresh) || fresh > norm) {
            /* rounding, a singular operator or a nonlinear preconditioner: the previous iterate was better */
            if (!d->low_memory) pdi_krylov_copy(run, run->w, run->x);
            if (!pdi_krylov_is_finite(fresh)) return pdi_krylov_fail_nan(run, "the residual");
            return pdi_krylov_fail_stall(run, "stagnation");
        }
        run->result->residual = fresh;
        if (d->low_memory) pdi_krylov_lean_accept(run);
        if (fresh > run->target && fresh > PDI_KRYLOV_STALLED * norm) return pdi_krylov_fail_stall(run, "stagnation");
        norm = fresh;
    }
    return PD_OK;
}

/* ---- conjugate gradients ---- */

/* Best iterate of CG. It is copied only when the next one is worse, before x changes. */
typedef struct pdi_krylov_best {
    double *x;
    double norm, current; /* [unit of b] residuals of the best and of the present iterate */
    int saved;            /* x differs from the present iterate */
} pdi_krylov_best;

/* Before x moves to an iterate of the residual norm `next`: keeps x where that is above the least norm so far. */
static void pdi_krylov_best_update(const pdi_krylov_state *run, pdi_krylov_best *best, double next)
{
    if (next > best->norm) {
        if (!best->saved) pdi_krylov_copy(run, run->x, best->x);
        best->saved = 1;
    } else {
        best->norm = next;
        best->saved = 0;
    }
    best->current = next;
}

/* Restore the best iterate and compute its true residual, into scratch, and the norm into result->residual. */
static void pdi_krylov_best_restore(const pdi_krylov_state *run, pdi_krylov_best *best, double *scratch)
{
    if (best->saved) pdi_krylov_copy(run, best->x, run->x);
    best->saved = 0;
    run->result->residual = pdi_krylov_residual(run, scratch);
}

/* Rounding level of p.Ap for the direction p in work vector 1: PDI_KRYLOV_SINGULAR p.Dp; 0 without desc.diagonal.
 * Overwrites work vector 2. */
static double pdi_krylov_singular_limit(const pdi_krylov_state *run)
{
    const double *d = run->k->desc.diagonal, *p = pdi_krylov_vector(run, 1);
    double *z = pdi_krylov_vector(run, 2);
    int64_t first = run->k->desc.first, end = first + pdi_krylov_active_length(&run->k->desc);
    int nt = pd_par_threads(run->ctx, end - first);
    (void)nt;
    if (!d) return 0.0;
    PD_PARALLEL_FOR(nt)
    for (int64_t i = first; i < end; i++) z[i] = d[i] * p[i];
    return PDI_KRYLOV_SINGULAR * pdi_krylov_dot(run, p, z);
}

/* CG from the residual in work vector 0 until the residual of the recurrence meets the tolerance, the iteration limit
 * (both PD_OK), or an error. PD_ERR_DIVERGED: r.z <= 0 (preconditioner), |p.Ap| at the rounding level (singular), p.Ap
 * <= 0 (not positive definite), a value that is not finite. Moves x, keeps the best iterate in *best. Flexible beta
 * (Notay 2000): symmetry of a single-precision multigrid cycle holds to rounding only. */
static pd_status pdi_krylov_cg_cycle(const pdi_krylov_state *run, pdi_krylov_best *best)
{
    double *r = pdi_krylov_vector(run, 0), *p = pdi_krylov_vector(run, 1), *z = pdi_krylov_vector(run, 2);
    double *q = pdi_krylov_vector(run, 3);
    double rho = 0.0, alpha = 0.0;
    for (int first = 1; best->current > run->target; first = 0) {
        if (run->result->iterations >= run->k->desc.max_iterations) return PD_OK;
        PD_TRY(pd_check_cancel(run->ctx, "Krylov", run->result->iterations));
        pdi_krylov_precond(run, r, z);
        double rho_next = pdi_krylov_dot(run, r, z);
        if (!pdi_krylov_is_finite(rho_next)) return pdi_krylov_fail_nan(run, "the preconditioned residual");
        if (rho_next <= 0.0)
            return pd_fail(run->ctx, PD_ERR_DIVERGED, pdi_krylov_name(run),
                           "r.z = %.3g in CG: the preconditioner is not positive definite", rho_next);
        double beta = first ? 0.0 : -alpha * pdi_krylov_dot(run, z, q) / rho;
        pdi_krylov_scale_add(run, beta, p, z);
        pdi_krylov_apply(run, p, q);
        double curvature = pdi_krylov_dot(run, p, q);
        if (!pdi_krylov_is_finite(curvature)) return pdi_krylov_fail_nan(run, "an operator application");
        double flat = pdi_krylov_singular_limit(run);
        if (flat > 0.0 && fabs(curvature) <= flat)
            return pd_fail(run->ctx, PD_ERR_DIVERGED, pdi_krylov_name(run),
                           "p.Ap = %.3g in CG, where %.3g is rounding: the operator is singular", curvature, flat);
        if (curvature <= 0.0)
            return pd_fail(run->ctx, PD_ERR_DIVERGED, pdi_krylov_name(run),
                           "p.Ap = %.3g in CG: the operator is not positive definite (use GMRES)", curvature);
        rho = rho_next;
        alpha = pdi_krylov_dot(run, p, r) / curvature;
        pdi_krylov_axpy(run, -alpha, q, r);
        double next = sqrt(pdi_krylov_dot(run, r, r));
        if (!pdi_krylov_is_finite(next)) return pdi_krylov_fail_nan(run, "the residual");
        pdi_krylov_best_update(run, best, next);
        pdi_krylov_axpy(run, alpha, p, run->x);
        run->result->iterations++;
    }
    return PD_OK;
}

/* CG with restarts from the true residual; the residual in work vector 0 has the norm `norm`. PD_NOT_CONVERGED:
 * iteration limit, or stagnation: a cycle leaves more than PDI_KRYLOV_STALLED of the true norm. After an error of a
 * cycle x is its best iterate by the recurrence, and result->residual that norm. */
static pd_status pdi_krylov_cg(const pdi_krylov_state *run, double norm)
{
    const pd_krylov_desc *d = &run->k->desc;
    double *r = pdi_krylov_vector(run, 0);
    while (norm > run->target) {
        if (run->result->iterations >= d->max_iterations) return pdi_krylov_fail_stall(run, "no convergence");
        pdi_krylov_best best = {pdi_krylov_vector(run, 4), norm, norm, 0};
        pd_status status = pdi_krylov_cg_cycle(run, &best);
        if (status < 0) {
            if (best.saved) pdi_krylov_copy(run, best.x, run->x);
            run->result->residual = best.norm;
            return status;
        }
        pdi_krylov_best_restore(run, &best, r);
        double fresh = run->result->residual;
        if (!pdi_krylov_is_finite(fresh)) return pdi_krylov_fail_nan(run, "the residual");
        if (fresh > run->target && fresh > PDI_KRYLOV_STALLED * norm) return pdi_krylov_fail_stall(run, "stagnation");
        norm = fresh;
    }
    return PD_OK;
}

PDI_FN double pdi_krylov_min_norm(void) { return sqrt(DBL_MIN / DBL_EPSILON); }

/* Set |b|, the tolerance max(rtol |b|, atol, pdi_krylov_min_norm) and the residual of the initial guess, of norm *norm,
 * in v. With zero_guess it zeroes x, and A is not applied. PD_ERR_ARGUMENT: b or the guess is not finite.
 * PD_ERR_DIVERGED: A applied to the guess is not. */
static pd_status pdi_krylov_begin(pdi_krylov_state *run, double *norm)
{
    const pd_krylov_desc *d = &run->k->desc;
    double *r = run->v;
    run->b_norm = sqrt(pdi_krylov_dot(run, run->b, run->b));
    if (!pdi_krylov_is_finite(run->b_norm))
        return pd_fail(run->ctx, PD_ERR_ARGUMENT, pdi_krylov_name(run), "the right-hand side is not finite");
    run->target = pd_max(pd_max(d->rtol * run->b_norm, d->atol), pdi_krylov_min_norm());
    *norm = run->b_norm;
    if (d->zero_guess) {
        pdi_par_zero(run->ctx, d->n, run->x);
        pdi_krylov_copy(run, run->b, r);
    } else {
        if (!pdi_krylov_is_finite(pdi_krylov_dot(run, run->x, run->x)))
            return pd_fail(run->ctx, PD_ERR_ARGUMENT, pdi_krylov_name(run), "the guess is not finite");
        *norm = pdi_krylov_residual(run, r);
        if (!pdi_krylov_is_finite(*norm)) return pdi_krylov_fail_nan(run, "A applied to the guess");
    }
    run->result->residual0 = run->result->residual = *norm;
    return PD_OK;
}

pd_status pd_krylov_solve(pd_ctx *ctx, pd_krylov *krylov, pd_apply_fn apply, pd_apply_fn precond, void *user,
                          const double *b, double *x, pd_krylov_result *result)
{
    pd_krylov_result own;
    pdi_krylov_state run;
    double norm = 0.0;
    memset(&run, 0, sizeof run);
    run.ctx = ctx;
    run.k = krylov;
    run.apply = apply;
    run.precond = precond;
    run.user = user;
    run.b = b;
    run.x = x;
    run.result = result ? result : &own;
    memset(run.result, 0, sizeof *run.result);
    if (!apply || !krylov->work)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "krylov", "%s", apply ? "solver was not built" : "apply is NULL");
    PD_TRY(pdi_krylov_check_range(ctx, &krylov->desc));
    run.v = krylov->desc.low_memory ? x : pdi_krylov_vector(&run, 0);
    run.w = pdi_krylov_vector(&run, krylov->desc.low_memory ? 0 : 1);
    pdi_krylov_zero_scratch(&run, run.v); /* the last solve may have left other data in them */
    pdi_krylov_zero_scratch(&run, run.w);
    PD_TRY(pdi_krylov_begin(&run, &norm));
    pd_status status = PD_OK;
    if (run.b_norm == 0.0 && norm > run.target) { /* x = 0 is the solution */
        pdi_par_zero(ctx, krylov->desc.n, x);
        run.result->residual = 0.0;
    } else
        status = krylov->desc.method == PD_KRYLOV_GMRES ? pdi_krylov_gmres(&run, norm) : pdi_krylov_cg(&run, norm);
    if (krylov->desc.low_memory) pdi_krylov_lean_end(&run);
    run.result->converged = status == PD_OK;
    return pdi_krylov_release_chunks(ctx, krylov, status);
}
