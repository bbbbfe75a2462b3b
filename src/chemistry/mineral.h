/* mineral: solids that precipitate from solutes and dissolve again, with a speed or in equilibrium (theory: 7.7).
 *
 * A volume holds totals of components, dissolved and in minerals together. Its concentrations and the amounts of
 * minerals at the end of an implicit step follow from them: a mineral that is there has the speed of its law, one that
 * is not there stays away below saturation. Amounts are at least 0. Nothing is allocated, and nothing but the arguments
 * is written: many threads may use one system.
 */
#ifndef PD_MINERAL_H
#define PD_MINERAL_H
#include "chemistry/components.h"

#define PD_MINERAL_MAX 8 /* minerals of a system */

/* Zero-initialise. Rate law (rate + surface n) (Omega^exponent - 1) with Omega = IAP/K and the amount n [mol/m3] (eq.
 * 7.15); without rate and surface the mineral is in equilibrium. */
typedef struct pd_mineral {
    int species;       /* number of the solid */
    double rate;       /* [mol/m3/s] part that does not depend on the amount */
    double surface_rate; /* [1/s] part in proportion to the amount, as its surface */
    double exponent;   /* [-] of Omega; 0: 1 */
    double nucleation; /* [-] log10 Omega at the start of a step from which an absent mineral forms */
    double volume;     /* [m3/mol] molar volume; 0: it fills no pores */
    double min_porosity; /* [-] left in a cell that is full of it */
} pd_mineral;

typedef struct pd_minerals {
    int count;
    pd_mineral mineral[PD_MINERAL_MAX];          /* exponents filled in */
    double nu[PD_MINERAL_MAX][PD_SPECIES_MAX];   /* [-] stoichiometric numbers of solutes in the dissolution */
    double total_content[PD_MINERAL_MAX][PD_SPECIES_MAX]; /* [-] totals g_sk that one unit holds (theory 7.7) */
    double ln_k[PD_MINERAL_MAX];                 /* [-] ln K of the dissolution, with mol/m3 */
    double charge_square[PD_MINERAL_MAX];        /* [-] sum of nu z^2 */
} pd_minerals;

/* Rate laws and bounds of the minerals of a volume in a step. */
typedef struct pd_mineral_start {
    double dt;                       /* [s] */
    const double *start_amount;      /* [count] [mol/m3] amounts n_old of the backward Euler step (eq. 7.16) */
    double rate[PD_MINERAL_MAX];     /* [mol/m3/s] rate without amount; HUGE_VAL: in equilibrium */
    double amount_rate[PD_MINERAL_MAX]; /* [1/s] rate per amount; both 0: it does not form */
    double initial[PD_MINERAL_MAX];  /* [mol/m3] amounts before the step: they stay even without free volume */
    int has_limits;                  /* 1: minerals grow up to `limit`, 0: up to the free volume */
    double limit[PD_MINERAL_MAX];    /* [mol/m3] HUGE_VAL: none */
    const double *guess;             /* [count] [mol/m3] first guess of the amounts; NULL: n of the solve */
} pd_mineral_start;

#ifdef PDI_INTERNAL
#define PDI_MINERAL_TOLERANCE 1e-13 /* largest |ln Omega - law| of an amount that counts as solved */
#define PDI_MINERAL_MIN_CONCENTRATION 1e-200 /* [mol/m3] lower bound of concentrations in logarithms */
/* [-] a volume within this of its free volume is full, and a law off by more is not met */
#define PDI_MINERAL_FULL_TOLERANCE 1e-9
/* Prepares the minerals of a system; an exponent of 0 becomes 1. PD_ERR_ARGUMENT: more than PD_MINERAL_MAX, a species
 * that is no solid or is there twice, a number that is negative or not finite (nucleation may be negative),
 * min_porosity not in [0, 1), or not exactly one reaction, which needs a K, no other solid, no gas and no electron.
 * `minerals` is zero then. */
PDI_FN pd_status pdi_mineral_build(pd_ctx *ctx, const pd_components *components, const pd_species *species, int count,
                                    const pd_reaction *reactions, int reaction_count, const pd_mineral *list,
                                    int mineral_count, pd_minerals *minerals);
/* Copies the reactions without solids into `rest`, in order; returns their number. */
PDI_FN int pdi_mineral_copy_solid_free_reactions(const pd_species *species, int count, const pd_reaction *reactions,
                                                 int reaction_count, pd_reaction *rest);
/* ln Omega = ln(IAP/K) of mineral s (eq. 7.15) at concentrations conc [solutes] [mol/m3], which count as 1e-200 at
 * least. Where an ion that it dissolves into is missing, the reactants of the dissolution do not raise it. */
PDI_FN double pdi_mineral_compute_ln_omega(const pd_components *c, const pd_minerals *m, int s, const double *conc);
/* Sets the rate laws of a volume for a step that begins with amounts n [count] and concentrations conc: rate,
 * amount_rate and initial, no limits, no guess. The caller sets dt and start_amount. A mineral without rates gets
 * HUGE_VAL (equilibrium). An absent one does not form (both 0) where its nucleation is positive and log10 Omega below
 * it, nor with a surface rate alone. */
PDI_FN void pdi_mineral_begin_step(const pd_components *c, const pd_minerals *m, const double *n, const double *conc,
                                   pd_mineral_start *start);
/* For a second stage that would begin with so little of mineral s, *amount, that its rate were not positive: 1, *amount
 * becomes first_amount [mol/m3] (at least 0), and both rates in start are multiplied with step_ratio, the step from
 * there over that of the stage (theory 7.7). Else 0, and nothing changes. */
PDI_FN int pdi_mineral_try_resume(pd_mineral_start *start, int s, double first_amount, double step_ratio,
                                  double *amount);
/* 1: no concentrations have the dissolved totals, however fast minerals dissolve or grow by their laws and into the
 * free volume in the step: a total that no solute counts negative in would stay below 0. 0: none does; that proves
 * nothing. */
PDI_FN int pdi_mineral_is_infeasible(const pd_components *c, const pd_minerals *m, const pd_mineral_start *start,
                                     const double *total);
/* 1: a mineral of the amounts before [count] [mol/m3] is 0 in `after`, or the volume fraction of all has reached 1 -
 * min_porosity of one that has a volume, to 1e-9. 0: else, also where it was full before. */
PDI_FN int pdi_mineral_has_switched(const pd_minerals *m, const double *before, const double *after);
/* Volume of minerals n [count] [mol/m3] over that of the cell, clipped to 0 .. 1; those of unknown volume count 0. */
PDI_FN double pdi_mineral_compute_volume_fraction(const pd_minerals *minerals, const double *n);
/* Volume of minerals n over that of the cell. */
PDI_FN double pdi_mineral_compute_volume(const pd_minerals *m, const double *n);
/* 1: mineral s forms or dissolves in the step. */
PDI_FN int pdi_mineral_is_reactive(const pd_mineral_start *start, int s);
/* Rate times step [mol/m3] of mineral s at the end amount n: what dissolves far below saturation. HUGE_VAL: in
 * equilibrium. */
PDI_FN double pdi_mineral_compute_max_extent(const pd_mineral_start *start, int s, double n);
/* Growth of mineral s in the backward Euler step [mol/m3] at Omega^p - 1 = excess, of any sign. HUGE_VAL: in
 * equilibrium, or unbounded since dt times the rate per amount times excess is at least 1. */
PDI_FN double pdi_mineral_compute_growth(const pd_mineral_start *start, int s, double excess);
#endif

#endif
