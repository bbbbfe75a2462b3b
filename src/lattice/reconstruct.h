/* reconstruct: quadratic least-squares reconstruction of scalars and velocities at nodes near smooth walls, for
 * gradients and for the wall terms of the Laplacian.
 *
 * The gradient (2.9) of a truncated family is exact for linear fields: on one side of a surface its error is half of
 * the second difference of the field over the reach of the bonds. The wall terms (2.2) treat each cut bond by itself,
 * and omit the change of the velocity gradient along the surface. Rows (nodes) at shapes that are curved or inclined
 * use instead: for a scalar parabolas along the axes, or with wide families a quadratic fit to the far ends of bonds
 * (eq. 2.11); for a velocity a quadratic fit that includes the points on the surface (eq. 2.7), where the bonds
 * determine one. With nearest neighbours the cubic part of a velocity that vanishes on the surface follows from the
 * second derivatives of the pressure, and the error of the sums for it is computed beforehand (eq. 2.8).
 */
#ifndef PD_RECONSTRUCT_H
#define PD_RECONSTRUCT_H
#include "lattice/bond.h"

typedef struct pd_quadratic_reconstruction {
    const pd_bonds *bonds;
    int32_t count, capacity; /* rows near smooth surfaces */
    int32_t *row;            /* [capacity] row of pd_bonds */
    uint8_t *has_velocity_fit; /* [capacity] 1: the bonds determine the velocity fit */
    double *wall_coefficients; /* [capacity][terms] [unit of 1/(base m2)] of the sum over cut bonds (2.7) */
    double *wall_friction;     /* [capacity] [1/m2] its coefficient of the velocity of the node: wall friction */
    /* [bonds of the stencil][terms] [unit of base] base weight times the quadratic terms at far ends of bonds */
    double *weighted_terms;
    int32_t wide_capacity;   /* capacity, or 0: families of nearest neighbours */
    double *viscous_error;   /* [capacity - wide][PD_DIM][second derivatives] [m] error of the viscous term (2.8) for
                              * each second derivative of the pressure over mu */
    uint8_t *has_scalar_fit; /* [wide] 1: the bonds determine the scalar fit */
    /* [wide][PD_DIM][terms] [unit of 1/(base m)] gradient of the fit from sums of terms times differences */
    double *gradient_map;
    int32_t row_capacity; /* capacity of the rows of pd_bonds */
    int32_t *index;       /* [rows] index of a row of pd_bonds in these lists; -1: not near a smooth surface */
} pd_quadratic_reconstruction;

#ifdef PDI_INTERNAL
/* Computes the fits of all rows near smooth surfaces for the present geometry, and allocates or grows the arrays; `rec`
 * is zero or holds earlier fits, which are lost. `bonds` store wall terms (no PD_BONDS_NO_FLOW) and are borrowed.
 * extra_weight: NULL, or [bonds of the stencil] [1/m2] added, times `factor`, to the Laplacian weights (isotropic
 * friction, eq. 3.14). Fails only for memory; the caller frees `rec` then, too. */
PDI_FN pd_status pdi_reconstruct_update(pd_ctx *ctx, const pd_bonds *bonds, const double *extra_weight, double factor,
                                        pd_quadratic_reconstruction *rec);
PDI_FN void pdi_reconstruct_free(pd_ctx *ctx, pd_quadratic_reconstruction *rec);

#define PDI_RECONSTRUCT_HESSIAN_SIZE (PD_DIM * (PD_DIM + 1) / 2) /* second derivatives: xx, yx, yy, .. */
/* Replaces grad [PD_DIM][total] of f [total] at the rows near smooth surfaces (eq. 2.11): by the fit of wide families
 * where they have one, else by parabolas along the axes on which they have two neighbours or two nodes on one side;
 * components along other axes, and other nodes, stay. Ghost values of f must be set. */
PDI_FN void pdi_reconstruct_set_gradient(const pd_ctx *ctx, const pd_quadratic_reconstruction *rec, const double *f,
                                         double *grad);
/* 1: row r of the bonds has a velocity fit; 0: none, or it is not near a smooth surface. */
static inline int pdi_reconstruct_has_velocity_fit(const pd_quadratic_reconstruction *rec, int32_t r)
{
    return r < rec->row_capacity && rec->index[r] >= 0 && rec->has_velocity_fit[rec->index[r]];
}
/* wall [PD_DIM] [1/(m s)] = contribution of the cut bonds of row r, which has a velocity fit, to the Laplacian of the
 * velocity u [PD_DIM][total] [m/s], for a wall at rest (second sum of eq. 2.7). */
PDI_FN void pdi_reconstruct_apply_wall_laplacian(const pd_quadratic_reconstruction *rec, int32_t r, const double *u,
                                                 double *wall);
/* error [PD_DIM] [unit of f / m] = error (discrete minus exact) of the viscous term of row r, which is near a smooth
 * surface, for the pressure f [total], to be subtracted (eq. 2.8); 0 for wide families and without a velocity fit. */
PDI_FN void pdi_reconstruct_compute_viscous_error(const pd_quadratic_reconstruction *rec, int32_t r, const double *f,
                                                  double *error);
/* Derivative at 0 of the parabola through the values `below` at -a, `at` at 0 and `above` at b; a, b > 0. */
static inline double pdi_reconstruct_parabola_derivative(double a, double b, double below, double at, double above)
{
    return ((above - at) * a / b + (at - below) * b / a) / (a + b);
}
#endif

#endif
