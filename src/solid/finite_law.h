/* finite_law: energy and stress of one place of a solid at large strains.
 *
 * neo-Hookean  psi = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2
 * Hencky       psi = K/2 (tr e)^2 + mu |dev e|^2,  e = ln(F F^T)/2
 * J2           the same of the elastic part F G F^T, with the yield stress
 *              Y(a) = yield + hardening a + (saturation - yield)(1 - exp(-rate a))  of the Kirchhoff stress
 *
 * F is the gradient of the place of points. Directions that PD_DIM leaves out are fixed (plane strain), or stretch so
 * that they bear no stress (plane stress, a bar in 1D). The return to the yield surface is radial in principal
 * logarithmic strains: it is the least of an energy, so the tangent is symmetric.
 *
 * Sources: Simo 1992, Simo and Hughes 1998 ch. 9 (plasticity in principal logarithmic strains); Ortiz and Stainier 1999
 * (its energy); Bonet and Wood 2008 (neo-Hookean); Voce 1948 (saturation).
 */
#ifndef PD_FINITE_LAW_H
#define PD_FINITE_LAW_H
#include "core/vec.h"
#include "solid/elastic.h"

typedef enum pd_finite_kind {
    PD_FINITE_NEO_HOOKEAN = 0,
    PD_FINITE_HENCKY,
    PD_FINITE_J2
} pd_finite_kind;

typedef struct pd_finite_law {
    pd_finite_kind kind;
    double young;      /* [Pa] E of small strains; in 1D of a bar */
    double poisson;    /* [-] -1 < nu < 1/2; neo-Hookean in plane stress and 1D from 0 */
    pd_plane plane;    /* of 2D */
    double yield;      /* [Pa] J2: first yield stress */
    double hardening;  /* [Pa] J2: linear part, over the equivalent plastic strain; 0: none */
    double saturation; /* [Pa] J2: yield stress in the end without the linear part; 0: as at first */
    double rate;       /* [-] J2: how fast it saturates, over the equivalent plastic strain */
} pd_finite_law;

#ifdef PDI_INTERNAL
/* The state of a place under J2: G - 1 with G = (F^p^T F^p)^-1, its upper triangle and in 1D and 2D what is left of its
 * diagonal, and the equivalent plastic strain. Zeros: nothing has yielded. */
enum { PDI_FINITE_STATE = PD_DIM == 3 ? 7 : PD_DIM == 2 ? 5 : 3 };
/* Numbers of a derivative of the stress. */
enum { PDI_FINITE_MODULI = PD_DIM == 3 ? 45 : PD_DIM == 2 ? 10 : 1 };

typedef struct pdi_finite_moduli {
    pd_finite_law law;
    double lambda, mu; /* [Pa] */
    int free;          /* directions beyond PD_DIM that bear no stress */
} pdi_finite_moduli;

/* PD_ERR_ARGUMENT: a modulus out of range. */
PDI_FN pd_status pdi_finite_law_make(pd_ctx *ctx, const pd_finite_law *law, pdi_finite_moduli *m);
/* lambda of small strains in the directions that PD_DIM has [Pa]. */
PDI_FN double pdi_finite_law_lambda(const pdi_finite_moduli *m);
/* First Piola-Kirchhoff stress p [Pa] of F. state is NULL but for J2. 0: F turns the place inside out. */
PDI_FN int pdi_finite_law_stress(const pdi_finite_moduli *m, const double *f, const double *state, double *p);
/* Its derivative dp along df; and as the upper triangle of the matrix of PD_DIM^2 rows, zeros where there is none. */
PDI_FN void pdi_finite_law_tangent(const pdi_finite_moduli *m, const double *f, const double *state, const double *df,
                                   double *dp);
PDI_FN void pdi_finite_law_moduli(const pdi_finite_moduli *m, const double *f, const double *state, double *moduli);
/* Cauchy stress [Pa], and in 2D the normal one across the plane. */
PDI_FN int pdi_finite_law_cauchy(const pdi_finite_moduli *m, const double *f, const double *state, double *stress,
                                 double *across);
/* Energy density [Pa]; infinite where F turns the place inside out. flows 1: and the plastic work [Pa] since the
 * beginning, up to F; the stress is the derivative of both. */
PDI_FN double pdi_finite_law_energy(const pdi_finite_moduli *m, const double *f, const double *state, int flows);
/* What has yielded under F stays. Returns the plastic work [Pa]. */
PDI_FN double pdi_finite_law_commit(const pdi_finite_moduli *m, const double *f, double *state);
#endif

#endif
