/* j2_plasticity: J2 plasticity of small strains with linear isotropic hardening.
 *
 * The strain of a point is e, its plastic strain e_p has no trace. The stress  2 mu dev(e - e_p)  does not exceed the
 * yield stress  yield + hardening slip,  where slip is the accumulated equivalent plastic strain. A step from
 * the last state is implicit (radial return; Simo and Hughes 1998, box 3.1), so it may be of any length. In 2D
 * strain is plane, and the plastic strain normal to the plane is what the trace leaves. In 1D the bar is under
 * tension or pressure.
 */
#ifndef PD_J2_PLASTICITY_H
#define PD_J2_PLASTICITY_H
#include "core/array_registry.h"

typedef struct pd_j2_plasticity {
    int64_t count;    /* points; 0: no plasticity */
    double shear;     /* [Pa] mu; 1D: E */
    double yield;     /* [Pa] */
    double hardening; /* [Pa] */
    double *strain;   /* [count][PD_DIM^2] [-] e_p */
    double *equivalent_strain; /* [count] [-] equivalent plastic strain */
    /* [count][PD_DIM^2] [Pa] plastic stress 2 mu e_p, 1D E e_p: by how much e_p lowers the stress */
    double *plastic_stress;
    double *flow_direction; /* [count][PD_DIM^2] [-] flow direction, of unit norm with its out-of-plane part */
    /* [count] [Pa] derivative of relief by the strain along the flow direction; 0: elastic step */
    double *tangent_along;
    double *tangent_across; /* [count] [Pa] derivative by a strain that turns the flow direction */
} pd_j2_plasticity;

#ifdef PDI_INTERNAL
/* Describes the arrays: plastic strains are state, the others work of a step. */
PDI_FN void pdi_j2_plasticity_list(pdi_array_visitor *owner, void *plastic);
/* Radial return of point i from its state, which stays, to the displacement gradient h [PD_DIM^2]: sets plastic_stress,
 * flow_direction, tangent_along and tangent_across. The step is elastic unless the von Mises stress is > yield +
 * hardening times equivalent strain: then plastic_stress is that of the state, both tangents are 0, and flow_direction
 * holds the trial stress [Pa]. */
PDI_FN void pdi_j2_plasticity_return_map(const pd_j2_plasticity *plastic, int64_t i, const double *h);
/* Derivative of the plastic stress of point i along dh, into plastic_stress, which is overwritten; zero after an
 * elastic step. To be called after pdi_j2_plasticity_return_map, whose flow direction and tangents it reads. */
PDI_FN void pdi_j2_plasticity_apply_tangent(const pd_j2_plasticity *plastic, int64_t i, const double *dh);
/* Makes the plastic strain of the step of point i to the gradient h its state; an elastic step changes nothing. It
 * needs no pdi_j2_plasticity_return_map. */
PDI_FN void pdi_j2_plasticity_commit(const pd_j2_plasticity *plastic, int64_t i, const double *h);
/* Energy density [J/m3] by which the plastic strain lowers the elastic energy of the gradient h, at the present
 * plastic_stress (pdi_j2_plasticity_return_map). */
PDI_FN double pdi_j2_plasticity_energy_relief(const pd_j2_plasticity *plastic, int64_t i, const double *h);
/* Plastic work [J/m3] of point i up to its state, heat and what hardening stores, without a stiffness factor. */
PDI_FN double pdi_j2_plasticity_dissipated(const pd_j2_plasticity *plastic, int64_t i);
#endif

#endif
