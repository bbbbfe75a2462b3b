/* electrolyte: a solution as a recipe: species, reactions, amounts, a pH that is set, a charge that is closed; and its
 * equilibrium. */
#ifndef PD_ELECTROLYTE_H
#define PD_ELECTROLYTE_H
#include "chemistry/speciation.h"

/* A solution as a recipe: species, reactions, amounts at the start and inlet, pH values, and how charge is balanced. */
typedef struct pd_electrolyte {
    pd_species species[PD_SPECIES_MAX];
    int count; /* of the species */
    pd_reaction reaction[PD_REACTION_MAX];
    int reactions;
    double enthalpy[PD_REACTION_MAX]; /* [J/mol] with which K went from 25 C to the temperature; NaN: K is as given */
    double volume[PD_SPECIES_MAX];    /* [m3/mol] of solids; 0: not known */
    double recipe[PD_SPECIES_MAX];    /* [mol/m3] as written, of the start */
    double initial[PD_SPECIES_MAX];   /* [mol/m3] the same, made neutral; a solid per volume of water */
    double inlet[PD_SPECIES_MAX];     /* [mol/m3] at inlets, made neutral */
    double shape_initial[PD_SPECIES_MAX]; /* [mol/m3] initial concentrations inside of shapes, made neutral */
    double ph, inlet_ph, shape_ph; /* [-] given pH of the start, of inlets, inside of shapes; NaN: it follows from the
                                    * amounts */
    /* index of the ion that is adjusted for electroneutrality; -1: none, charges must sum to 0 */
    int balance_ion;
    int counter_ion; /* index of the counter ion of the acid or base that sets the pH; -1: none */
    pd_activity activity;
    double temperature;  /* [K] */
    int all_minerals_form; /* 1: every mineral forms when supersaturated; 0: only those that are present */
} pd_electrolyte;

/* Equilibrium of a solution. */
typedef struct pd_electrolyte_state {
    double ph;       /* [-] NaN: there is no H+ */
    double strength; /* [mol/m3] ionic strength */
    double charge;   /* [mol/m3] sum of charges */
    double saturation[PD_SPECIES_MAX]; /* [-] of solids log10(IAP/K), formed or not; NaN: unknown */
    pd_speciation_result result;
} pd_electrolyte_state;

#define pd_electrolyte_neutralise PD_NAME(pd_electrolyte_neutralise)
#define pd_electrolyte_solve PD_NAME(pd_electrolyte_solve)
#define pd_electrolyte_reagent PD_NAME(pd_electrolyte_reagent)
#define pd_electrolyte_build_speciation PD_NAME(pd_electrolyte_build_speciation)
#define pd_electrolyte_compute_element_total PD_NAME(pd_electrolyte_compute_element_total)
#define pd_electrolyte_find_species PD_NAME(pd_electrolyte_find_species)
#define pd_electrolyte_remove_undissolved PD_NAME(pd_electrolyte_remove_undissolved)

/* Make the recipe c [mol/m3] neutral by the ion e.balance_ion, and add acid or base until the pH of its equilibrium is
 * `ph` (NaN: none is added). PD_ERR_ARGUMENT: no such ion and charges above 1e-6 of the ionic strength, or it would
 * become negative; a pH without counter ion, H+ or OH-, or one that cannot be reached. Errors of pd_electrolyte_solve.
 * c holds what is in, not the equilibrium; after an error it is unchanged. */
PD_API pd_status pd_electrolyte_neutralise(pd_ctx *ctx, const pd_electrolyte *e, double ph, double *c);
/* Bring c [mol/m3] to equilibrium, in which every reaction with a K is, also one with rates; absent minerals take part
 * with all_minerals_form only. Fills *state; its pH is NaN without H+. PD_ERR_ARGUMENT: c is negative or not finite, or
 * reactions contradict each other. PD_ERR_DIVERGED: no equilibrium is found. c is unchanged then. */
PD_API pd_status pd_electrolyte_solve(pd_ctx *ctx, const pd_electrolyte *e, double *c, pd_electrolyte_state *state);
/* per [e.count]: species in one unit of a neutral reagent "Na+ + OH-", 0 for others. PD_ERR_PARSE: a term that is none,
 * an unknown species, a charge that is not 0; per is unchanged then. */
PD_API pd_status pd_electrolyte_reagent(pd_ctx *ctx, const pd_electrolyte *e, const char *text, double *per);
/* Index of a species by name; -1: there is none. */
PD_API int pd_electrolyte_find_species(const pd_electrolyte *e, const char *name);
/* Builds the speciation system of all reactions with a K, those with rates included, at concentrations c: without
 * reactions of minerals that are absent (c not above 0), unless all_minerals_form. c NULL: with all minerals.
 * PD_ERR_ARGUMENT: as of pd_speciation_build. */
PD_API pd_status pd_electrolyte_build_speciation(pd_ctx *ctx, const pd_electrolyte *e, const double *c,
                                                 pd_speciation *system);
/* Removes solids, gases and electrons other than those with stays[species] = 1, and the reactions that name them.
 * Indices of species and reactions change. */
PD_API void pd_electrolyte_remove_undissolved(pd_electrolyte *e, const int *stays);
/* Total concentration of an element [mol/m3] (atomic number): c times its atoms, summed over all species, solids
 * included. */
PD_API double pd_electrolyte_compute_element_total(const pd_electrolyte *e, const double *c, int element);

#endif
