/* constitutive_law: constitutive laws of large strains: energy, stress and tangent of one material point.
 *
 * neo-Hookean  psi = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (ln J)^2
 * Hencky       psi = K/2 (tr e)^2 + mu |dev e|^2,  e = ln(F F^T)/2
 * J2           the same of the elastic part F G F^T, with the yield stress
 *              Y(a) = yield + hardening a + (saturation - yield)(1 - exp(-rate a))  of the Kirchhoff stress
 *
 * F is the deformation gradient. Directions beyond PD_DIM have no strain (plane strain), or no stress (plane stress, a
 * bar in 1D). The return to the yield surface is radial in principal logarithmic strains; it minimises an energy, so
 * the tangent is symmetric.
 *
 * Sources: Simo 1992, Simo and Hughes 1998 ch. 9 (plasticity in principal logarithmic strains); Ortiz and Stainier 1999
 * (its energy); Bonet and Wood 2008 (neo-Hookean); Voce 1948 (saturation).
 */
#ifndef PD_CONSTITUTIVE_LAW_H
#define PD_CONSTITUTIVE_LAW_H
#include "core/vec.h"
#include "solid/correspondence.h"

typedef enum pd_constitutive_kind {
    PD_FINITE_STRAIN_NEO_HOOKEAN = 0,
    PD_FINITE_STRAIN_HENCKY,
    PD_FINITE_STRAIN_J2
} pd_constitutive_kind;

typedef struct pd_constitutive_law {
    pd_constitutive_kind kind;
    double young;      /* [Pa] E of small strains; in 1D of a bar */
    double poisson;    /* [-] -1 < nu < 1/2; neo-Hookean in plane stress and 1D from 0 */
    pd_plane plane;    /* of 2D */
    double yield;      /* [Pa] J2: first yield stress */
    double hardening;  /* [Pa] J2: linear part, over the equivalent plastic strain; 0: none */
    double saturation; /* [Pa] J2: yield stress in the end without the linear part; 0: as at first */
    double rate;       /* [-] J2: how fast it saturates, over the equivalent plastic strain */
} pd_constitutive_law;

#ifdef PDI_INTERNAL
/* Entries of a plastic state under J2: G - 1 with G = (F^p^T F^p)^-1, its upper triangle and in 1D and 2D the rest
 * of its diagonal, then the equivalent plastic strain. Zeros: virgin material. */
enum { PDI_CONSTITUTIVE_LAW_STATE = PD_DIM == 3 ? 7 : PD_DIM == 2 ? 5 : 3 };
/* Entries of a material tangent: upper triangle of a symmetric matrix of PD_DIM^2 rows. */
enum { PDI_CONSTITUTIVE_LAW_TANGENT = PD_DIM == 3 ? 45 : PD_DIM == 2 ? 10 : 1 };

/* A law with its moduli. */
typedef struct pdi_constitutive_law_params {
    pd_constitutive_law law;
    double lambda, mu; /* [Pa] */
    int free;          /* number of directions beyond PD_DIM without stress */
} pdi_constitutive_law_params;

/* Checks a law and computes its moduli; the kind is not checked. PD_ERR_ARGUMENT: E not positive and finite; nu not in
 * (-1, 1/2), or neo-Hookean and negative in plane stress or 1D; under J2 a yield stress not positive, negative
 * hardening, or a saturation that is neither 0 nor at least the yield stress, or has no positive rate. m is then of no
 * use. */
PDI_FN pd_status pdi_constitutive_law_init(pd_ctx *ctx, const pd_constitutive_law *law, pdi_constitutive_law_params *m);
/* Lame's lambda [Pa] of small strains for PD_DIM directions, with the stress-free directions condensed: in plane stress
 * and 1D 2 mu lambda/(2 mu + free lambda), otherwise lambda. */
PDI_FN double pdi_constitutive_law_plane_lambda(const pdi_constitutive_law_params *m);
/* First Piola-Kirchhoff stress p [PD_DIM^2] [Pa] of the deformation gradient f, under J2 at the end of a step from
 * `state`, which stays. state: plastic state, NULL but for J2. Returns 1; 0: det F <= 0, and p stays. */
PDI_FN int pdi_constitutive_law_compute_stress(const pdi_constitutive_law_params *m, const double *f,
                                               const double *state, double *p);
/* Directional derivative dp [PD_DIM^2] [Pa] of that stress along df (consistent tangent); zeros where det F <= 0. */
PDI_FN void pdi_constitutive_law_apply_tangent(const pdi_constitutive_law_params *m, const double *f,
                                               const double *state, const double *df, double *dp);
/* The same derivative as the upper triangle, row by row, of the matrix d p/d F [PDI_CONSTITUTIVE_LAW_TANGENT] [Pa];
 * zeros where det F <= 0. */
PDI_FN void pdi_constitutive_law_compute_tangent(const pdi_constitutive_law_params *m, const double *f,
                                                 const double *state, double *moduli);
/* Cauchy stress [PD_DIM^2] [Pa] of the step from `state`, which stays, to f; *across [Pa], never NULL: in 2D the
 * out-of-plane normal stress, otherwise of no use. The volume ratio includes the stretch of stress-free directions.
 * Returns 1; 0: det F <= 0 or not finite, and stress and *across stay. */
PDI_FN int pdi_constitutive_law_compute_cauchy(const pdi_constitutive_law_params *m, const double *f,
                                               const double *state, double *stress, double *across);
/* Elastic energy density [Pa] at the end of the step from `state` to f; HUGE_VAL where det F <= 0. plastic 1: with the
 * plastic work [Pa] from the virgin state up to F; the stress is the derivative of this sum. */
PDI_FN double pdi_constitutive_law_compute_energy(const pdi_constitutive_law_params *m, const double *f,
                                                  const double *state, int plastic);
/* Updates the plastic state to that of F. Returns the increment of plastic work [Pa]; 0: the step is elastic or det F
 * <= 0, and the state stays. */
PDI_FN double pdi_constitutive_law_commit(const pdi_constitutive_law_params *m, const double *f, double *state);
#endif

#endif
