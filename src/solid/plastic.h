/* plastic: metal that flows at von Mises' yield stress and hardens, at small strains.
 *
 * The strain of a point is e, its plastic strain e_p has no trace. The stress  2 mu dev(e - e_p)  does not exceed the
 * yield stress  yield + hardening slip,  where slip is the equivalent plastic strain of all that has been. A step from
 * the last state is taken backward (radial return; Simo and Hughes 1998, box 3.1), so it may be of any length. In 2D
 * strain is plane, and the plastic strain normal to the plane is what the trace leaves. In 1D the bar is under
 * tension or pressure.
 */
#ifndef PD_PLASTIC_H
#define PD_PLASTIC_H
#include "core/owner.h"

typedef struct pd_plastic {
    int64_t count;    /* points; 0: nothing flows */
    double shear;     /* [Pa] mu; 1D: E */
    double yield;     /* [Pa] */
    double hardening; /* [Pa] */
    double *strain;   /* [count][PD_DIM^2] [-] e_p */
    double *slip;     /* [count] [-] */
    double *relief;   /* [count][PD_DIM^2] [Pa] 2 mu e_p, 1D E e_p: by how much e_p lowers the stress */
    double *way;      /* [count][PD_DIM^2] [-] direction of the flow, |way| = 1 with the part normal to the plane */
    double *along;    /* [count] [Pa] d relief/d e along `way`; 0: the point does not flow */
    double *across;   /* [count] [Pa] the same for what turns `way` */
} pd_plastic;

#ifdef PDI_INTERNAL
PDI_FN void pdi_plastic_list(pdi_owner *owner, void *plastic);
/* The step of point i to the displacement gradient h: relief, way, along, across. */
PDI_FN void pdi_plastic_meet(const pd_plastic *plastic, int64_t i, const double *h);
/* Derivative of the relief of point i along dh, into relief. */
PDI_FN void pdi_plastic_bend(const pd_plastic *plastic, int64_t i, const double *dh);
/* The step of point i to h becomes its state. */
PDI_FN void pdi_plastic_commit(const pd_plastic *plastic, int64_t i, const double *h);
/* Energy [J/m3] that e_p takes from the elastic one of the gradient h of point i, at the relief that it has. */
PDI_FN double pdi_plastic_relief(const pd_plastic *plastic, int64_t i, const double *h);
/* [J/m3] that flow has cost at point i: heat and hardening. */
PDI_FN double pdi_plastic_dissipated(const pd_plastic *plastic, int64_t i);
#endif

#endif
