/* terms: what laws and curves at a surface see of the node beside it (theory: 9.5).
 */
#ifndef PD_TERMS_H
#define PD_TERMS_H
#include "react/etch.h"

#ifdef PDI_INTERNAL
/* A node and its film. */
typedef struct pdi_terms {
    const pd_etch *s;
    const pdi_etch_kind *kind;        /* its metal */
    int32_t node;
    double thick;
    double still, creep;              /* of metal that does not move, and [mol s2/m5] what its speed adds */
    double davies;                    /* ln gamma of a charge of 1 */
    double flows[PD_SPECIES_MAX];     /* [mol/m3] of components at the node: sums of what diffuses */
    double c[PD_SPECIES_MAX];         /* [mol/m3] at the node */
    double at[PD_SPECIES_MAX];        /* [mol/m3] times `scale`: at the surface, the last that was found */
    double ln_k[PD_SPECIES_MAX];      /* of the film, with those coefficients */
    double surface[PD_SPECIES_MAX];   /* [mol/m3] at the surface, with migration */
    double down[PD_SPECIES_MAX];      /* [-] of that, times `scale`, is `at` */
    double into[PD_SPECIES_MAX];      /* [mol/m3] of components: totals of `at` */
    double psi, lift;                 /* F phi/(R T) of the node, of the surface over it */
    double sweep;                     /* [-] what the surface moves, of what diffuses through the film */
    int electrode;                    /* -1: none */
    double level;                     /* [V] of the metal */
    double way;                       /* [s/m] through the film of the electrode */
    double flow, guess;               /* [mol/m2/s] of the electrode */
    double share;                     /* [-] of its curve */
    uint32_t reads;                   /* what its curve reads */
    int odd, odds;                    /* 1: the law is no number where it was asked last, or somewhere before */
} pdi_terms;

/* A node beside that metal; place -1: it has none. */
PDI_FN void pdi_terms_enter(const pd_etch *s, int metal, int32_t node, int32_t place, double thick,
                            pd_components *film, pdi_terms *w);
/* pH and phi of a law for the concentrations c, where F phi/(R T) is psi. */
PDI_FN void pdi_terms_read(const pdi_terms *w, const double *c, double psi, double *ph, double *phi);
/* The law for the concentrations c, where F phi/(R T) is psi. */
PDI_FN double pdi_terms_number(const pdi_terms *w, const double *c, double psi);
/* The same; what is negative, or no number, counts as 0. */
PDI_FN double pdi_terms_law(const pdi_terms *w, const double *c, double psi);
/* The flow of the electrode there. */
PDI_FN double pdi_terms_curve(const pdi_terms *w, const double *c, double psi);
#endif

#endif
