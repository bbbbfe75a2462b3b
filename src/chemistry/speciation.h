/* speciation: equilibrium of a closed volume: solutes, water, and minerals that are present or not (theory: 7.4).
 *
 * The state of a volume is an array of concentrations, one a species [mol/m3]; a solid counts per volume of water.
 * Reactions run by extents until each is in equilibrium, so that elements and charge stay what they are at the start,
 * to rounding. A mineral is present at saturation, or absent below it. Nothing is allocated, and nothing but the
 * arguments is written: many threads may use one system.
 */
#ifndef PD_SPECIATION_H
#define PD_SPECIATION_H
#include "chemistry/activity.h"
#include "chemistry/reaction.h"

/* Species and reactions as solves need them. */
typedef struct pd_speciation {
    int species, reactions;
    int charge[PD_SPECIES_MAX];
    int phase[PD_SPECIES_MAX];                  /* pd_phase */
    double nu[PD_REACTION_MAX][PD_SPECIES_MAX]; /* [-] */
    double ln_k[PD_REACTION_MAX];               /* [-] with mol/L */
    double debye_hueckel;                       /* [-] A of Davies' equation, with mol/L; 0: ideal */
} pd_speciation;

typedef struct pd_speciation_result {
    int iterations;     /* of Newton */
    int mineral_changes; /* of the minerals that are present */
    double residual;    /* [-] largest |ln(IAP/K)| of a reaction of the species that are present */
    double strength;    /* [mol/m3] ionic strength */
    double log_activity[PD_SPECIES_MAX]; /* [-] decimal, mol/L; of solids log10(IAP/K); -HUGE_VAL: it cannot be made */
} pd_speciation_result;

#define pd_speciation_build PD_NAME(pd_speciation_build)
#define pd_speciation_solve PD_NAME(pd_speciation_solve)

/* A system of `count` species and the reactions that are in equilibrium: kinetic ones are left out. temperature [K] is
 * that of Davies' equation. PD_ERR_ARGUMENT: count not 1 .. PD_SPECIES_MAX, more than PD_REACTION_MAX equilibria, a gas
 * or an electron in one of them, or one that is the sum of others with another K. system is zero then. */
PD_API pd_status pd_speciation_build(pd_ctx *ctx, const pd_species *species, int count, const pd_reaction *reactions,
                                     int reaction_count, pd_activity activity, double temperature,
                                     pd_speciation *system);
/* Bring c [mol/m3] to equilibrium by Newton's method with an active set of minerals. A species that no reaction makes
 * of those with c > 0 stays 0. PD_ERR_ARGUMENT, without a message: c is negative (water may be) or not finite.
 * PD_NOT_CONVERGED: no solution was found, or 100 changes of minerals. c is unchanged then. */
PD_API pd_status pd_speciation_solve(const pd_speciation *system, double *c, pd_speciation_result *result);

#endif
