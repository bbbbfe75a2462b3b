/* solid: what solvers see of a material: forces, their derivative, energy and stress.
 *
 * A material owns the state of its bonds and points and offers this table. Solvers hold displacements u and loads. All
 * arrays have the order of the points of the body; vectors [count][PD_DIM], tensors [count][PD_DIM^2].
 */
#ifndef PD_SOLID_H
#define PD_SOLID_H
#include "core/archive.h"
#include "solid/body.h"

typedef struct pd_solid {
    const char *name;
    void *self;
    pd_body *body;
    const double *edge; /* [count][PD_DIM] [1/m] a traction P n on the surface is the load -P edge; NULL: unknown */
    const uint8_t *follows; /* [count][PD_DIM] 1: it is held but at no place, as it is the reflection of another one;
                             * NULL: none is */
    int linear;         /* 1: forces are linear in u and know nothing of what was before */
    int gradients;      /* 1: forces follow from 1 + grad u, whose last digits are those of 1 */
    /* force [N/m3] of displacements u [m]. PD_RETRY: u is no state of the material, as where bonds are turned inside
     * out. */
    pd_status (*force)(pd_ctx *ctx, void *self, const double *u, double *force);
    /* df [N/m3]: derivative along du [m] of the forces at the u of the last `force`. V_i df_i is symmetric in du. */
    void (*tangent)(const pd_ctx *ctx, void *self, const double *du, double *df);
    /* block [count][PD_DIM^2] [N/m] about -V_i d force_i/d u_i at the last u, for preconditioners: symmetric and
     * positive definite. */
    void (*blocks)(const pd_ctx *ctx, void *self, double *block);
    /* Lame's moduli [count] [Pa], about, of small strains about the places that the points had, for preconditioners: mu
     * and lambda + 2 mu/3 are positive (1D: lambda). Steps of a piece that nothing holds leave its mean motion then.
     * NULL: unknown. */
    void (*moduli)(const pd_ctx *ctx, void *self, double *lambda, double *mu);
    /* Energy [J] (per m in 2D, per m2 in 1D) that is stored at u. */
    double (*energy)(const pd_ctx *ctx, void *self, const double *u);
    /* energy [bonds] [J/m^(2d)] that the families hold in their bonds at u: the density of family i is
     * sum V_j energy_ij. A bond has that of both its ends; a broken one has none. NULL: unknown. */
    void (*bond_energy)(const pd_ctx *ctx, void *self, const double *u, double *energy);
    /* Cauchy stress [Pa] of each point at u. NULL: the material has none. */
    void (*stress)(const pd_ctx *ctx, void *self, const double *u, double *stress);
    /* Normal stress [Pa] across the plane of 2D, of point i with the stress that `stress` gave last. NULL: none. */
    double (*normal)(const void *self, int32_t i, const double *stress);
    /* [J] (per m in 2D, per m2 in 1D) that flow has cost up to the last state. NULL: nothing flows. */
    double (*dissipated)(const void *self);
    /* strain [count] [-]: equivalent plastic strain of each point, of the last state. NULL: nothing flows. */
    void (*slip)(const pd_ctx *ctx, const void *self, double *strain);
    /* Energy density [J/m3] of each point at u. NULL: none but the total. */
    void (*density)(const pd_ctx *ctx, void *self, const double *u, double *density);
    /* pull [PD_DIM] [N/m^(2d)] of the family of point i on the bond that a walk is at, at u:
     * force_i = sum V_j (pull_ij - pull_ji). NULL: bonds are no springs. */
    void (*pull)(const void *self, const double *u, int32_t i, const pd_walk *bond, double *pull);
    /* force [N/m3] at the end of a step of dt [s] to u; v [m/s] are the velocities of the step, NULL before the first
     * one. Bonds break of themselves: how many. NULL: none does. */
    int64_t (*move)(const pd_ctx *ctx, void *self, const double *u, const double *v, double dt, double *force);
    /* Bonds have broken, or points have lost stiffness. */
    pd_status (*update)(pd_ctx *ctx, void *self);
    /* The state at u becomes the one that the next steps begin with. NULL: nothing is remembered. */
    pd_status (*commit)(pd_ctx *ctx, void *self, const double *u);
    /* Longest stable explicit step [s] of small displacements for a density [kg/m3]. */
    double (*limit)(const void *self, double density);
    /* Write all that is remembered, or read it. NULL: nothing is. */
    pd_status (*store)(pd_ctx *ctx, void *self, pd_archive *archive);
} pd_solid;

#ifdef PDI_INTERNAL
/* Von Mises' stress of a stress and, in 2D, the one normal to its plane; *mean: of the normal stresses [Pa]. */
static inline double pdi_solid_mises(const double *stress, double normal, double *mean)
{
    double trace = PD_DIM == 2 ? normal : 0.0, square = 0.0;
    for (int d = 0; d < PD_DIM; d++) trace += stress[d * PD_DIM + d];
    *mean = trace / 3.0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) {
            double part = stress[a * PD_DIM + b] - (a == b ? trace / 3.0 : 0.0);
            square += part * part;
        }
    for (int d = PD_DIM; d < 3; d++) {
        double part = (d == 2 && PD_DIM == 2 ? normal : 0.0) - trace / 3.0;
        square += part * part;
    }
    return sqrt(1.5 * square);
}
#endif

#endif
