/* material_interface: interface of a mechanical material model: forces, tangent, energy, stress, state.
 *
 * A material owns the state of its bonds and points and fills in this table of functions. Solvers hold displacements u
 * and loads. All arrays have the order of the points of the body; vectors [count][PD_DIM], tensors [count][PD_DIM^2].
 */
#ifndef PD_MATERIAL_INTERFACE_H
#define PD_MATERIAL_INTERFACE_H
#include "core/archive.h"
#include "solid/body.h"

typedef struct pd_material_interface {
    const char *name;
    void *self;
    pd_body *body;
    const double *surface_vector; /* [count][PD_DIM] [1/m] surface vector: a traction P n is the load density -P edge;
                                   * NULL: unknown */
    const uint8_t *is_image;      /* [count][PD_DIM] 1: the displacement of a mirror image: it is no unknown, but not
                                   * prescribed either, as it follows its point; NULL: none */
    int linear;         /* 1: forces are linear in u and do not depend on the history */
    int gradient_based; /* 1: forces follow from 1 + grad u, so their rounding is relative to 1, not to grad u */
    /* Internal force density [N/m3] at displacements u [m]. PD_RETRY: not defined at u, as where a bond is inverted. */
    pd_status (*force)(pd_ctx *ctx, void *self, const double *u, double *force);
    /* Tangent: df [N/m3] is the directional derivative along du [m] of the forces at the u of the last `force`. The
     * operator V_i df_i is symmetric. */
    void (*tangent)(const pd_ctx *ctx, void *self, const double *du, double *df);
    /* Diagonal blocks [count][PD_DIM^2] [N/m], about -V_i d force_i/d u_i at the last u, for preconditioners: symmetric
     * and positive definite. */
    void (*blocks)(const pd_ctx *ctx, void *self, double *block);
    /* Approximate Lame's moduli [count] [Pa] of small strains of the undeformed body, for preconditioners: mu and
     * lambda + 2 mu/3 are positive (1D: lambda). With them the solver keeps the mean rigid motion of free components.
     * NULL: unknown. */
    void (*moduli)(const pd_ctx *ctx, void *self, double *lambda, double *mu);
    /* Energy [J] (per m in 2D, per m2 in 1D) that is stored at u. */
    double (*energy)(const pd_ctx *ctx, void *self, const double *u);
    /* Bond energies [bonds] [J/m^(2d)] at u, by family: the energy density of point i is sum V_j energy_ij. A bond has
     * the sum of both its ends; a broken one has none. NULL: unknown. */
    void (*bond_energy)(const pd_ctx *ctx, void *self, const double *u, double *energy);
    /* Cauchy stress [count][PD_DIM^2] [Pa] at u; NaN where it is not defined. NULL: the material has none. */
    void (*stress)(const pd_ctx *ctx, void *self, const double *u, double *stress);
    /* Out-of-plane normal stress [Pa] in 2D of point i, with the stress that `stress` gave last. NULL: none. */
    double (*out_of_plane_stress)(const void *self, int32_t i, const double *stress);
    /* Plastic dissipation [J] (per m in 2D, per m2 in 1D) up to the last committed state. NULL: no plasticity. */
    double (*dissipated)(const void *self);
    /* strain [count] [-]: equivalent plastic strain of the last committed state. NULL: no plasticity. */
    void (*plastic_strain)(const pd_ctx *ctx, const void *self, double *strain);
    /* Energy density [count] [J/m3] at u. NULL: none but the total. */
    void (*density)(const pd_ctx *ctx, void *self, const double *u, double *density);
    /* Force state t [PD_DIM] [N/m^(2d)] of point i on the current bond, at u: force_i = sum V_j (t_ij - t_ji). NULL:
     * not a bond-based material. */
    void (*force_state)(const void *self, const double *u, int32_t i, const pd_bond_iterator *bond, double *pull);
    /* Explicit dynamics: force [N/m3] at the end of a time step of dt [s] to u; v [m/s] are the velocities of the step,
     * NULL before the first one. Bonds break by the rule of the material. Returns how many. NULL: use `force`. */
    int64_t (*dynamic_force)(const pd_ctx *ctx, void *self, const double *u, const double *v, double dt, double *force);
    /* Recomputes what depends on bonds and stiffness, after bonds have broken or points have lost stiffness. */
    pd_status (*update)(pd_ctx *ctx, void *self);
    /* Commits the history variables at u: the next steps begin with them. NULL: no history. */
    pd_status (*commit)(pd_ctx *ctx, void *self, const double *u);
    /* Longest stable explicit step [s] of small displacements for a density [kg/m3]. */
    double (*stable_step)(const void *self, double density);
    /* Writes the history variables to an archive, or reads them. NULL: none. */
    pd_status (*store)(pd_ctx *ctx, void *self, pd_archive *archive);
} pd_material_interface;

#ifdef PDI_INTERNAL
/* Von Mises stress [Pa] of a symmetric stress [PD_DIM^2]. normal [Pa]: in 2D the out-of-plane normal stress, otherwise
 * not read; in 1D the other normal stresses are 0. *mean [Pa]: mean of the three normal stresses. */
static inline double pdi_material_interface_von_mises(const double *stress, double normal, double *mean)
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
