/* front: weights of the bonds across a front between metal and fluid, and the speed that they give it.
 *
 * Through the bond of offset n a solid node loses at the rate v b(n) times a driving amount (see dissolve.h). A flat
 * front with the unit normal N that has dissolved layer by layer then moves at v f(N), exactly, with
 *     f(N) = 1/2 sum_n b(n) |xi.N|                                                    (theory: eq. 11.2)
 * whatever h and m. Calibrated weights have f = 1 along every axis: no trial run is needed to get a rate.
 */
#ifndef PD_FRONT_H
#define PD_FRONT_H
#include "core/array_registry.h"
#include "core/vec.h"
#include "lattice/stencil.h"
#include <math.h>

typedef enum pd_kernel {
    PD_KERNEL_AREA = 0, /* b = c(n), the area weights of eq. 10.5: f closest to 1 in all directions */
    PD_KERNEL_SQUARE,   /* b like beta V/|xi|^2 (Jafarzadeh et al. 2021, eq. 1 and 22) */
    PD_KERNEL_INVERSE   /* b like beta V/|xi| */
} pd_kernel;

typedef struct pd_front {
    const pd_stencil *stencil;
    pd_kernel kernel;
    double *weight; /* [count] [1/m] b(n) */
    double total;   /* [1/m] sum b(n): what a node with fluid all around loses by */
    double micro;   /* [m^(1-d)] PD_KERNEL_SQUARE on equal spacings: b = micro beta V/|xi|^2, so the
                     * micro-dissolvability of that paper is k_diss = v ln(Cs/Csat) micro. 0 otherwise */
} pd_front;

#ifdef PDI_INTERNAL
/* The stencil is borrowed. PD_WEIGHTS_PUBLISHED: continuum coefficients, for which f = 1 only when m is large; on
 * unequal spacings those of the smallest one times (delta_ref/delta_theta)^d, delta_theta = m |xi|/|n|.
 * PD_ERR_ARGUMENT: there are no printed area weights, and in 1D no inverse squares. PD_ERR_GEOMETRY: a calibrated
 * weight is negative. */
PDI_FN pd_status pdi_front_build(pd_ctx *ctx, const pd_stencil *stencil, pd_kernel kernel, pd_weights weights,
                                 pd_front *front);
PDI_FN void pdi_front_free(pd_ctx *ctx, pd_front *front);
/* f(N) [-] of a unit vector. */
static inline double pdi_front_measure(const pd_front *front, const double *normal)
{
    double sum = 0.0;
    for (int k = 0; k < front->stencil->count; k++)
        sum += 0.5 * front->weight[k] * fabs(pdi_vec_dot(front->stencil->xi + k * PD_DIM, normal));
    return sum;
}
#endif

#ifdef PDI_INTERNAL
PDI_FN void pdi_front_list(pdi_array_visitor *owner, void *front);
#endif

#endif
