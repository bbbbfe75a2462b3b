/* reaction: a reaction as text, balanced in elements and charge, with its constant of equilibrium and its rates. */
#ifndef PD_REACTION_H
#define PD_REACTION_H
#include "chemistry/species.h"

#define PD_REACTION_MAX 24  /* reactions of a system */
#define PD_REACTION_NAME 32 /* [byte] of a name with its end */

typedef struct pd_reaction_desc {
    const char *name;    /* of messages */
    const char *text;    /* "Mg2+ + 2 OH- = Mg(OH)2(s)": blanks around + and = */
    double k;            /* [unit of k_unit] constant of equilibrium as the text reads; NaN: none */
    const char *k_unit;  /* "mol2/L2"; "log10": k is the decimal logarithm with mol/L; NULL or "": of no unit */
    double forward;      /* [unit of forward_unit] rate constant; 0: the reaction is in equilibrium */
    const char *forward_unit;  /* "L/mol/s" */
    double backward;     /* [unit of backward_unit] 0: forward over K, or none without a K */
    const char *backward_unit; /* "mol/L/s" */
} pd_reaction_desc;

typedef struct pd_reaction {
    char name[PD_REACTION_NAME];
    double nu[PD_SPECIES_MAX]; /* [-] of each species: products positive */
    int has_k;
    double ln_k;                /* [-] natural logarithm of K with mol/L; activities of solids and solvent are 1 */
    int kinetic;
    double forward, backward;   /* [unit of a rate: mol/m3/s over concentrations in mol/m3] */
} pd_reaction;

#define pd_reaction_read PD_NAME(pd_reaction_read)
#define pd_reaction_rate PD_NAME(pd_reaction_rate)

/* Read a reaction among `count` species. PD_ERR_PARSE, in one message with the remedy: an unknown species or one on
 * both sides, no or two =, elements or charge that do not balance, a unit that does not fit, a reaction with neither K
 * nor rate. PD_ERR_ARGUMENT: no text, count not 1 .. PD_SPECIES_MAX, K not positive, a rate negative or not finite, K
 * with both rates. reaction is zero then. */
PD_API pd_status pd_reaction_read(pd_ctx *ctx, const pd_reaction_desc *desc, const pd_species *species, int count,
                                  pd_reaction *reaction);
/* Rate, forward less backward [mol/m3/s], of a kinetic reaction by ideal mass action at concentrations c [mol/m3] of
 * `count` species: no activities. A solid, the solvent, a gas and the electron count as 1. 0 for a reaction without
 * rates. */
PD_API double pd_reaction_rate(const pd_reaction *reaction, const pd_species *species, int count, const double *c);
#ifdef PDI_INTERNAL
/* Parses a sum of species "Na+ + OH-" into the stoichiometric numbers nu (positive) of r, which is zeroed first.
 * PD_ERR_PARSE: an unknown species, a term that is none or is too long, a =. Elements and charge are not checked. name:
 * for messages, becomes that of r, cut off. */
PDI_FN pd_status pdi_reaction_parse_sum(pd_ctx *ctx, const char *name, const char *text, const pd_species *species,
                                        int count, pd_reaction *r);
#endif

#endif
