/* electrode: current density of a metal surface as a function of its overpotential: a sum of reactions, each of them
 * Butler-Volmer, Tafel, linear or a measured curve, with limiting currents (theory: 12.2).
 *
 * The argument of all curves is u = E - phi, the potential of the metal less that of the electrolyte at its surface. It
 * is what a reference electrode beside the surface measures. Currents are positive where they leave the metal (anodic).
 * No curve falls as u rises, so that a field has one solution. None overflows up to 1e100 V.
 */
#ifndef PD_ELECTRODE_H
#define PD_ELECTRODE_H
#include "core/array_registry.h"

typedef enum pd_electrode_kind {
    PD_ELECTRODE_BUTLER_VOLMER = 0, /* i = i_a - i_c, i_a = x/(1 + x/limit), x = exchange exp((u - equilibrium)/anodic),
                                     * and i_c likewise with exp(-(u - equilibrium)/cathodic). Tafel: one of both */
    PD_ELECTRODE_LINEAR = 1,        /* i = (u - equilibrium)/resistance */
    PD_ELECTRODE_TABLE = 2 /* monotone cubics through points (monotone_cubic.h), straight on beyond both ends with the
                            * slope of the last interval */
} pd_electrode_kind;

/* Zero-initialise. */
typedef struct pd_electrode_term {
    pd_electrode_kind kind;
    double equilibrium;       /* [V] Butler-Volmer, linear */
    double exchange;          /* [A/m2] Butler-Volmer: positive */
    double anodic, cathodic;  /* [V] change of u by which a branch grows by a factor e, RT/(alpha z F): a slope per
                               * decade over ln 10. 0: there is no such branch */
    double anodic_limit, cathodic_limit; /* [A/m2] limiting current densities of the branches; 0: none */
    double resistance;        /* [m2/S] linear: positive */
    int points;               /* table: at least 2 */
    const double *potential;  /* [points] [V] ascending */
    const double *current;    /* [points] [A/m2] nowhere falling */
} pd_electrode_term;

/* Zero-initialise. */
typedef struct pd_electrode_desc {
    const pd_electrode_term *term; /* [count] copied, with their tables */
    int count;          /* 0: charges pass at no overpotential: u is `equilibrium` everywhere (primary distribution) */
    double equilibrium; /* [V] of that */
    double film;        /* [m2/S] of a coating or film, in series; 0: none */
} pd_electrode_desc;

typedef struct pd_electrode {
    pd_electrode_desc desc; /* term is that below */
    pd_electrode_term *term; /* [count] tables are those below */
    int count, points;
    double *potential, *current, *slope; /* [points] [V] [A/m2] [S/m2] tables, one behind the other */
    double scale;            /* [A/m2] a size of the currents */
} pd_electrode;

#define pd_electrode_build PD_NAME(pd_electrode_build)
#define pd_electrode_current PD_NAME(pd_electrode_current)
#define pd_electrode_free PD_NAME(pd_electrode_free)

/* PD_ERR_ARGUMENT: a number is not finite or has the wrong sign, a term without a branch, a table that is not ascending
 * or whose current falls. */
PD_API pd_status pd_electrode_build(pd_ctx *ctx, const pd_electrode_desc *desc, pd_electrode *electrode);
/* Current density [A/m2] at u [V], of the terms alone; *slope [S/m2] (or NULL) its derivative. 0 without terms. */
PD_API double pd_electrode_current(const pd_electrode *electrode, double u, double *slope);
PD_API void pd_electrode_free(pd_ctx *ctx, pd_electrode *electrode);

#ifdef PDI_INTERNAL
/* Current density [A/m2] of `share` [-] times the curve at E - phi = `drop` [V], where phi lies behind `resist` > 0
 * [m2/S] of electrolyte, and behind the film; *slope [S/m2] its derivative; *u [V] a guess in, the overpotential at the
 * surface out. */
PDI_FN double pdi_electrode_through(const pd_electrode *electrode, double share, double drop, double resist, double *u,
                                    double *slope);
/* Least and largest current density [A/m2], infinite where there is no limit. */
PDI_FN void pdi_electrode_range(const pd_electrode *electrode, double *least, double *most);
#endif

#endif
