/* species: chemical species: charge, phase and elements, parsed from a name such as Mg2+ or Mg(OH)2(s). */
#ifndef PD_SPECIES_H
#define PD_SPECIES_H
#include "core/base.h"

#define PD_SPECIES_MAX 32      /* species of a system */
#define PD_SPECIES_NAME 24     /* [byte] of a name with its end */
#define PD_SPECIES_ELEMENTS 8  /* different ones in a species */

typedef enum pd_phase {
    PD_PHASE_SOLUTE = 0,
    PD_PHASE_SOLVENT, /* H2O: its activity is 1 */
    PD_PHASE_SOLID,   /* name(s): its activity is 1 where it is present */
    PD_PHASE_GAS,     /* name(g) */
    PD_PHASE_ELECTRON /* e- */
} pd_phase;

typedef struct pd_species_desc {
    const char *name;    /* Mg2+, OH-, SO4^2-, SO4-2, CaCO3, Mg(OH)2(s), CaHPO4:2H2O(s), e- */
    const char *formula; /* without charge, of a name that is none, as C6H12O6 of glucose; NULL: the name is one */
    int has_charge;      /* 1: charge is given; it has to be that of the name, where this is a formula */
    int charge;          /* [-] */
    double diffusivity;  /* [m2/s] at 25 C; 0: not known */
} pd_species_desc;

typedef struct pd_species {
    char name[PD_SPECIES_NAME];
    int charge;  /* [-] */
    pd_phase phase;
    int elements;
    int element[PD_SPECIES_ELEMENTS]; /* atomic numbers, each once */
    int count[PD_SPECIES_ELEMENTS];   /* atoms in one unit */
    double diffusivity;               /* [m2/s] at 25 C; 0: not known */
} pd_species;

#define pd_species_read PD_NAME(pd_species_read)
#define pd_species_get_symbol PD_NAME(pd_species_get_symbol)

/* Read a species. The charge is the end of the name: a sign, or a number beside it. A digit before the sign is the
 * charge behind the symbol of one element (Mg2+); elsewhere it counts atoms (NO3-, H2PO4-), and the last one of two is
 * the charge (SO42-). SO4^2-, SO4_2-, SO4-2 and SO4-- always say which. PD_ERR_PARSE: a name without or with too many
 * bytes, no formula and none given, name and given values disagree. PD_ERR_ARGUMENT: diffusivity negative or not
 * finite, charge beyond 20. species is zero then. */
PD_API pd_status pd_species_read(pd_ctx *ctx, const pd_species_desc *desc, pd_species *species);
/* Symbol of an atomic number, 1 to 118 (not checked), into text of 3 bytes, with its end. */
PD_API void pd_species_get_symbol(int element, char *text);
#ifdef PDI_INTERNAL
/* Number of atoms of an element (atomic number) in one unit of the species; 0: it has none. */
PDI_FN int pdi_species_count_atoms(const pd_species *species, int element);
#endif

#endif
