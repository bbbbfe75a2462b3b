/* components: component totals and the concentrations in equilibrium that belong to them (theory: 7.5). Each
 * equilibrium reaction makes one solute of others; solutes that none makes are the components. The total of one is T_k
 * = sum_i m_ki c_i, which no such reaction changes. The totals give all concentrations, at least 0. Nothing is
 * allocated, and nothing but the arguments is written: many threads may use one system. */
#ifndef PD_COMPONENTS_H
#define PD_COMPONENTS_H
#include "chemistry/activity.h"
#include "chemistry/reaction.h"

/* Largest size of the derivatives, [members][joined + 1]: each equilibrium reaction makes a member that is no
 * component, so there are fewer joined components than members. */
#define PD_COMPONENTS_DERIVATIVES (PD_SPECIES_MAX * PD_SPECIES_MAX)

/* A kinetic reaction by mass action, with rate constants at infinite dilution (eq. 7.3). */
typedef struct pd_kinetic {
    double forward, backward;     /* [unit of a rate: mol/m3/s over concentrations in mol/m3] */
    double salt_exponent[2];      /* [-] exponents of ln gamma for both ways, kinetic salt effect */
    double nu[PD_SPECIES_MAX];    /* [-] stoichiometric numbers of solutes, products positive */
    double total_change[PD_SPECIES_MAX]; /* [-] change of the totals by one unit of the reaction */
} pd_kinetic;

/* A component system. Solutes are numbered without the solvent. Components that equilibrium reactions join come
 * first. */
typedef struct pd_components {
    int solutes, count;          /* numbers of solutes and of components */
    int equilibrium_components;  /* components that take part in equilibrium reactions */
    int solute_of_species[PD_SPECIES_MAX]; /* solute index of a species; -1: the solvent, a solid */
    int charge[PD_SPECIES_MAX];  /* of solutes */
    int component_solute[PD_SPECIES_MAX];                 /* solute index of a component */
    double stoichiometry[PD_SPECIES_MAX][PD_SPECIES_MAX]; /* [-] m_ki of component k and solute i (eq. 7.8) */
    /* number and solute indices of members of equilibrium reactions */
    int members, member_solute[PD_SPECIES_MAX];
    double ln_k[PD_SPECIES_MAX];              /* [-] of solutes: ln a = ln_k + sum_k m_k ln a_master, with mol/m3 */
    int kinetics;
    pd_kinetic kinetic[PD_REACTION_MAX];
    double debye_hueckel; /* [-] A of Davies' equation, with mol/L; 0: ideal */
} pd_components;

#define pd_components_compute_ionic_strength PD_NAME(pd_components_compute_ionic_strength)

/* Ionic strength [mol/m3] of concentrations c [solutes]; negative ones count as 0. */
PD_API double pd_components_compute_ionic_strength(const pd_components *components, const double *c);
#ifdef PDI_INTERNAL
/* Builds the component system of `count` species from the reactions among solutes and solvent. Kinetic reactions become
 * `kinetic`, the others hold in equilibrium. temperature [K]: for Davies' equation. PD_ERR_ARGUMENT: count not 1 ..
 * PD_SPECIES_MAX, more than PD_REACTION_MAX reactions, a gas or an electron among the species, no solute, a solid in a
 * reaction (as a species it is ignored), or an equilibrium that is the sum of others with another K. components is zero
 * then. */
PDI_FN pd_status pdi_components_build(pd_ctx *ctx, const pd_species *species, int count, const pd_reaction *reactions,
                                      int reaction_count, pd_activity activity, double temperature,
                                      pd_components *components);
/* Concentrations c [solutes] [mol/m3] in equilibrium with the totals total [count] [mol/m3] (eq. 7.9); c is the first
 * guess on entry. Totals that no concentrations have give the nearest, close to 0. A component that is not joined gets
 * its total, or 0 where that is negative. PD_NOT_CONVERGED, also for a total that is not finite: c is unchanged. */
PDI_FN pd_status pdi_components_solve(const pd_components *components, const double *total, double *c);
/* Totals of the components T_k = sum_i m_ki c_i, total [count] [mol/m3], of concentrations c [solutes] (eq. 7.8), or
 * their changes from changes of c. */
PDI_FN void pdi_components_compute_totals(const pd_components *components, const double *c, double *total);
/* Derivatives of pdi_components_compute_derivatives in single precision, [members][columns] [-], as
 * pdi_components_apply_derivatives takes them. */
PDI_FN void pdi_components_compute_derivatives_single(const pd_components *components, const double *c,
                                                      float *derivatives);
/* Derivatives [members][columns] [-] of the concentrations c of members in equilibrium (eq. 7.10): columns
 * (pdi_components_count_columns) by the totals of the joined components, and with activities a last one by the ionic
 * strength of all solutes that are not joined. Nothing without members. */
PDI_FN void pdi_components_compute_derivatives(const pd_components *components, const double *c, double *derivatives);
/* c [solutes] [mol/m3] = change of the concentrations for a change `total` [count] [mol/m3] of the totals, by
 * pdi_components_compute_derivatives_single; a component that is not joined changes as its total. Negative changes are
 * not clipped. */
PDI_FN void pdi_components_apply_derivatives(const pd_components *components, const float *derivatives,
                                             const double *total, double *c);
/* Number of columns of the derivatives: joined components, and one for the ionic strength when activities are on. */
static inline int pdi_components_count_columns(const pd_components *components)
{
    return components->equilibrium_components + (components->debye_hueckel > 0.0);
}
/* Net rate, forward less backward [mol/m3/s], of a kinetic reaction by mass action with activities at concentrations c
 * [solutes] [mol/m3] (eq. 7.3). NULL allowed: derivatives [solutes] [1/s] of it by c; *gross_rate, the sum of the
 * sizes of both. */
PDI_FN double pdi_components_compute_rate(const pd_components *components, const pd_kinetic *kinetic, const double *c,
                                          double *derivatives, double *gross_rate);
/* c [PD_SPECIES_MAX] [mol/m3] = pure solvent: its own dissociation, kinetic reactions included, is in equilibrium.
 * PD_NOT_CONVERGED: c is 0. */
PDI_FN pd_status pdi_components_solve_pure_solvent(const pd_components *components, double *c);
/* ln gamma of a unit charge at concentrations c [solutes] [mol/m3]; *slope: its derivative by the ionic strength
 * [m3/mol]. Both are 0 for ideal solutes. */
PDI_FN double pdi_components_compute_davies(const pd_components *components, const double *c, double *slope);
/* ln gamma of a unit charge at concentrations c [solutes]; 0 for ideal solutes. */
PDI_FN double pdi_components_compute_ln_gamma(const pd_components *components, const double *c);
#endif

#endif
