/* components: what reactions in equilibrium leave free: totals of components, and the concentrations that belong to
 * them (theory: 5b.4).
 *
 * Each reaction in equilibrium makes one species of others. Those that none makes are the components; the total of one
 * is T_k = sum_i m_ki c_i, which no such reaction changes. The totals give all concentrations, at least 0. Nothing is
 * allocated, and nothing but the arguments is written: many threads may use one system.
 */
#ifndef PD_COMPONENTS_H
#define PD_COMPONENTS_H
#include "chemistry/activity.h"
#include "chemistry/reaction.h"

/* Room for slopes: each reaction in equilibrium makes a member that is no component, so that one column more than
 * joined components is at most one for each member. */
#define PD_COMPONENTS_SLOPES (PD_SPECIES_MOST * PD_SPECIES_MOST)

/* A reaction at finite rate, by mass action with rate constants of infinite dilution. */
typedef struct pd_kinetic {
    double forward, backward;     /* [unit of a rate: mol/m3/s over concentrations in mol/m3] */
    double salt[2];               /* [-] squares of charges of what each way begins with, less that of the complex */
    double nu[PD_SPECIES_MOST];   /* [-] of solutes */
    double gain[PD_SPECIES_MOST]; /* [-] of totals */
} pd_kinetic;

/* Solutes are numbered without the solvent. The components that reactions in equilibrium join come first. */
typedef struct pd_components {
    int solutes, count;          /* count: of components */
    int joined;                  /* components that take part in reactions in equilibrium */
    int place[PD_SPECIES_MOST];  /* solute of a species; -1: the solvent, a solid */
    int charge[PD_SPECIES_MOST]; /* of solutes */
    int master[PD_SPECIES_MOST]; /* solute that is the component */
    double m[PD_SPECIES_MOST][PD_SPECIES_MOST]; /* [-] of component and solute */
    int live, member[PD_SPECIES_MOST];          /* solutes that take part in reactions in equilibrium */
    double ln_k[PD_SPECIES_MOST]; /* [-] of solutes: ln a = ln_k + sum_k m_k ln a_master, with mol/m3 */
    int kinetics;
    pd_kinetic kinetic[PD_REACTION_MOST];
    double debye; /* [-] A of Davies' equation, with mol/L; 0: ideal */
} pd_components;

#ifdef PDI_INTERNAL
/* A system of `count` species and the reactions of solutes and the solvent; solids have no part in it. temperature [K]
 * is that of Davies' equation. PD_ERR_ARGUMENT: sizes, other phases, reactions that contradict each other. */
PDI_FN pd_status pdi_components_build(pd_ctx *ctx, const pd_species *species, int count, const pd_reaction *reactions,
                                      int reaction_count, pd_activity activity, double temperature,
                                      pd_components *components);
/* c [solutes] [mol/m3], the guess: concentrations in equilibrium with the given totals [count] [mol/m3]. A total that
 * no concentrations have leaves the nearest, which are next to 0. PD_NOT_CONVERGED: c is unchanged. */
PDI_FN pd_status pdi_components_solve(const pd_components *components, const double *total, double *c);
/* total [count] [mol/m3] of concentrations. */
PDI_FN void pdi_components_totals(const pd_components *components, const double *c, double *total);
/* How the solutes `member` follow the totals in equilibrium: by [live][joined + (1: with activities)] [-], the last
 * column by the ionic strength of the others. */
PDI_FN void pdi_components_derive(const pd_components *components, const double *c, float *by);
/* The same in double precision. */
PDI_FN void pdi_components_slopes(const pd_components *components, const double *c, double *by);
/* Change of the concentrations with that of the totals. */
PDI_FN void pdi_components_follow(const pd_components *components, const float *by, const double *total, double *c);
static inline int pdi_components_columns(const pd_components *components)
{
    return components->joined + (components->debye > 0.0);
}
/* Speed [mol/m3/s] of a kinetic reaction (theory: eq. 5b.3), 0 where activities give K. by [solutes], its derivatives
 * [1/s], and size, the sum of both of its ways, may be NULL. */
PDI_FN double pdi_components_speed(const pd_components *components, const pd_kinetic *kinetic, const double *c,
                                   double *by, double *size);
/* c [PD_SPECIES_MOST] [mol/m3] of the solvent alone: its own reactions, at finite rate or not, are in equilibrium.
 * PD_NOT_CONVERGED: c is 0. */
PDI_FN pd_status pdi_components_water(const pd_components *components, double *c);
/* Ionic strength [mol/m3]. */
PDI_FN double pdi_components_strength(const pd_components *components, const double *c);
/* ln gamma of a charge of 1, and its derivative by the ionic strength [m3/mol]. */
PDI_FN double pdi_components_davies(const pd_components *components, const double *c, double *slope);
/* ln gamma of a charge of 1. */
PDI_FN double pdi_components_activity(const pd_components *components, const double *c);
#endif

#endif
