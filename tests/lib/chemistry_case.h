/* chemistry_case: species and reactions of a test by their names. */
#ifndef CHEMISTRY_CASE_H
#define CHEMISTRY_CASE_H
#include "chemistry/components.h"
#include "test.h"

typedef struct mixture {
    pd_ctx ctx;
    pd_species s[PD_SPECIES_MAX];
    pd_reaction r[PD_REACTION_MAX];
    int species, reactions;
} mixture;

/* A species of diffusivity d [m2/s]; formula NULL: the name is one. */
static inline int mix_species(mixture *v, const char *name, const char *formula, double d)
{
    pd_species_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.name = name;
    desc.formula = formula;
    desc.diffusivity = d;
    CHECK_OK(&v->ctx, pd_species_read(&v->ctx, &desc, &v->s[v->species]));
    return v->species++;
}

/* In equilibrium, or (forward > 0) at finite rates. */
static inline void mix_reaction(mixture *v, const char *text, double log10_k, double forward, const char *unit)
{
    pd_reaction_desc d;
    memset(&d, 0, sizeof d);
    d.text = text;
    d.k = log10_k;
    d.k_unit = "log10";
    d.forward = forward;
    d.forward_unit = unit;
    CHECK_OK(&v->ctx, pd_reaction_read(&v->ctx, &d, v->s, v->species, &v->r[v->reactions++]));
}

static inline int mix_at(const mixture *v, const char *name)
{
    for (int i = 0; i < v->species; i++)
        if (strcmp(v->s[i].name, name) == 0) return i;
    return -1;
}

static inline void mix_begin(mixture *v)
{
    memset(v, 0, sizeof *v);
    pd_ctx_init(&v->ctx);
}

/* Body fluid: water, carbonate, phosphate, calcium and magnesium with their pairs, salt. PHREEQC's constants. */
static inline void mix_body_fluid(mixture *v)
{
    mix_begin(v);
    mix_species(v, "H2O", NULL, 0.0);
    mix_species(v, "H+", NULL, 9.31e-9);
    mix_species(v, "OH-", NULL, 5.27e-9);
    mix_species(v, "CO3-2", NULL, 0.955e-9);
    mix_species(v, "HCO3-", NULL, 1.18e-9);
    mix_species(v, "CO2", NULL, 1.92e-9);
    mix_species(v, "PO4-3", NULL, 0.612e-9);
    mix_species(v, "HPO4-2", NULL, 0.69e-9);
    mix_species(v, "H2PO4-", NULL, 0.846e-9);
    mix_species(v, "Ca2+", NULL, 0.793e-9);
    mix_species(v, "Mg2+", NULL, 0.705e-9);
    mix_species(v, "Na+", NULL, 1.33e-9);
    mix_species(v, "Cl-", NULL, 2.03e-9);
    mix_species(v, "CaHCO3+", NULL, 0.5e-9);
    mix_species(v, "MgHPO4", NULL, 0.7e-9);
    mix_reaction(v, "H2O = H+ + OH-", -14.0, 0.0, NULL);
    mix_reaction(v, "HCO3- = CO3-2 + H+", -10.329, 0.0, NULL);
    mix_reaction(v, "CO2 + H2O = HCO3- + H+", -6.352, 0.0, NULL);
    mix_reaction(v, "HPO4-2 = PO4-3 + H+", -12.346, 0.0, NULL);
    mix_reaction(v, "H2PO4- = HPO4-2 + H+", -7.207, 0.0, NULL);
    mix_reaction(v, "Ca2+ + HCO3- = CaHCO3+", 1.106, 0.0, NULL);
    mix_reaction(v, "Mg2+ + HPO4-2 = MgHPO4", 2.87, 0.0, NULL);
}

/* c [species] [mol/m3] of Hanks' solution, not in equilibrium. */
static inline void mix_hanks(const mixture *v, double *c)
{
    for (int i = 0; i < v->species; i++) c[i] = 0.0;
    c[mix_at(v, "H2O")] = 55344.0;
    c[mix_at(v, "HCO3-")] = 4.2;
    c[mix_at(v, "HPO4-2")] = 0.34;
    c[mix_at(v, "H2PO4-")] = 0.44;
    c[mix_at(v, "Ca2+")] = 1.26;
    c[mix_at(v, "Mg2+")] = 0.9;
    c[mix_at(v, "Na+")] = 142.0;
    c[mix_at(v, "Cl-")] = 145.0;
}
#endif
