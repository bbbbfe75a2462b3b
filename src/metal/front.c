/* front: see front.h */
#include "metal/front.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

/* Before calibration: beta V |n|^d/|xi|^(d+2), or with one power of |xi| less in the denominator. On equal spacings the
 * first is micro beta V/|xi|^2 with micro = h^-d. */
static double pdi_front_shape(const pd_stencil *s, pd_kernel kernel, int k)
{
    return s->base_weight[k] * (kernel == PD_KERNEL_INVERSE ? pdi_vec_norm(s->xi + k * PD_DIM) : 1.0);
}

/* b(n) = shape(n) sum_a s_a e_a^2 with f = 1 along every axis: sum over n_a > 0 of b xi_a = 1 (eq. 11.3). */
static pd_status pdi_front_calibrate(pd_ctx *ctx, pd_front *f)
{
    const pd_stencil *s = f->stencil;
    double matrix[PD_DIM * PD_DIM], one[PD_DIM], scale[PD_DIM];
    memset(matrix, 0, sizeof matrix);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double xi2 = pdi_vec_dot(xi, xi), shape = pdi_front_shape(s, f->kernel, k);
        /* row a is divided by h_a, so that the system is well scaled for any spacings */
        for (int a = 0; a < PD_DIM; a++)
            for (int b = 0; b < PD_DIM; b++)
                matrix[a * PD_DIM + b] += 0.5 * shape * fabs(xi[a]) / s->h[a] * xi[b] * xi[b] / xi2;
    }
    for (int a = 0; a < PD_DIM; a++) one[a] = 1.0 / s->h[a];
    if (!(pdi_vec_solve(matrix, one, scale) > 0.0))
        return pd_fail(ctx, PD_ERR_GEOMETRY, "front", "the sums over the family are singular (m = %g)", s->m);
    for (int k = 0; k < s->count; k++) {
        const double *xi = s->xi + k * PD_DIM;
        double factor = 0.0;
        for (int a = 0; a < PD_DIM; a++) factor += scale[a] * xi[a] * xi[a] / pdi_vec_dot(xi, xi);
        f->weight[k] = pdi_front_shape(s, f->kernel, k) * factor;
        if (!(f->weight[k] > 0.0))
            return pd_fail(ctx, PD_ERR_GEOMETRY, "front",
                           "a weight is %g 1/m, expected a positive one: the spacings differ too much for this "
                           "kernel, use area weights", f->weight[k]);
    }
    return PD_OK;
}

/* f = 1 as an integral over the horizon (eq. 11.4): of 1/|xi| the factor is 1/delta, 1/delta^2, 3/(pi delta^3) in 1D,
 * 2D and 3D, of 1/|xi|^2 it is 1/(2 delta) in 2D and 2/(pi delta^2) in 3D; in 1D that integral diverges. */
static pd_status pdi_front_print(pd_ctx *ctx, pd_front *f)
{
    const pd_stencil *s = f->stencil;
    double reference = s->h[0], factor;
    if (f->kernel == PD_KERNEL_AREA || (f->kernel == PD_KERNEL_SQUARE && PD_DIM == 1))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "front", "this kernel has no coefficient of the continuum in %dD",
                       PD_DIM);
    for (int a = 1; a < PD_DIM; a++) reference = pd_min(reference, s->h[a]);
    double delta = s->m * reference;
    if (f->kernel == PD_KERNEL_INVERSE) factor = (PD_DIM == 3 ? 3.0 / PD_PI : 1.0) / pow(delta, PD_DIM);
    else factor = PD_DIM == 2 ? 0.5 / delta : 2.0 / (PD_PI * delta * delta);
    /* the shape has |n|^d/|xi|^d = (m/delta_theta)^d in it */
    for (int k = 0; k < s->count; k++)
        f->weight[k] = factor * pow(reference, PD_DIM) * pdi_front_shape(s, f->kernel, k);
    return PD_OK;
}

PDI_FN void pdi_front_list(pdi_array_visitor *owner, void *object)
{
    pd_front *front = (pd_front *)object;
    if (front->stencil) PDI_ARRAY(owner, front, weight, front->stencil->count, "1/m");
}

static pd_status pdi_front_make(pd_ctx *ctx, const pd_stencil *stencil, pd_kernel kernel, pd_weights weights,
                                pd_front *f)
{
    int equal = 1;
    memset(f, 0, sizeof *f);
    f->stencil = stencil;
    f->kernel = kernel;
    if ((int)kernel < PD_KERNEL_AREA || (int)kernel > PD_KERNEL_INVERSE)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "front", "kernel %d, expected 0 to 2", (int)kernel);
    PD_TRY(pdi_array_registry_build(ctx, pdi_front_list, f));
    if (weights == PD_WEIGHTS_PUBLISHED) PD_TRY(pdi_front_print(ctx, f));
    else if (kernel == PD_KERNEL_AREA) memcpy(f->weight, stencil->area_weight, (size_t)stencil->count * sizeof(double));
    else PD_TRY(pdi_front_calibrate(ctx, f));
    for (int k = 0; k < stencil->count; k++) f->total += f->weight[k];
    for (int a = 1; a < PD_DIM; a++) equal = equal && fabs(stencil->h[a] / stencil->h[0] - 1.0) < 1e-12;
    if (kernel == PD_KERNEL_SQUARE && equal) {
        const double *xi = stencil->xi;
        f->micro = f->weight[0] * pdi_vec_dot(xi, xi) / (stencil->partial_volume[0] * stencil->volume);
    }
    return PD_OK;
}

PDI_FN pd_status pdi_front_build(pd_ctx *ctx, const pd_stencil *stencil, pd_kernel kernel, pd_weights weights,
                                 pd_front *f)
{
    pd_status status = pdi_front_make(ctx, stencil, kernel, weights, f);
    if (status < 0) pdi_front_free(ctx, f);
    return status;
}

PDI_FN void pdi_front_free(pd_ctx *ctx, pd_front *f)
{
    pdi_array_registry_free(ctx, pdi_front_list, f);
    memset(f, 0, sizeof *f);
}
