/* attack: laws of the scene in pH or species, between metal and species: where metal lies, what they say there.
 *
 * The species move first, with the law in their equations. What it gave in the step of the run is the speed of the
 * metal, which moves after them.
 */
#ifndef PD_ATTACK_H
#define PD_ATTACK_H
#include "metal/dissolve.h"
#include "potential/cell.h"
#include "react/course.h"
#include "run/polarise.h"
#include "run/surfaces.h"
#include "scene/setup.h"

/* The law of a metal. */
typedef struct pd_attack_law {
    struct pd_attack *attack;
    int kind;                    /* of the setup and of the dissolution */
    int metal;                   /* of the etch */
    const pd_surfaces *surfaces; /* whose states the law reads; NULL: it reads none */
} pd_attack_law;

typedef struct pd_attack {
    pd_etch etch;
    const pd_setup *setup;
    pd_dissolve *dissolve;
    const pd_course *course;
    const pd_cell *cell; /* whose potential the law reads, as it was found last, or whose contacts electrodes have;
                          * NULL: neither */
    const pd_surfaces *states; /* that step beside ions that migrate; NULL: there are none */
    pd_polarise polarise; /* electrodes among ions that migrate; else empty */
    pd_attack_law law[PD_SETUP_METALS];
    int laws;       /* metals that are told apart: all where several have a law, else the one that has, or 0 */
    int32_t *grain; /* [total] of the metal beside a node; NULL: no law asks */
    double begin;   /* [s] of the step of the run */
} pd_attack;

#ifdef PDI_INTERNAL
/* The laws of metals of the setup that are chemical, and electrodes among ions that migrate. All is borrowed;
 * dissolve: NULL where metal stays. */
PDI_FN pd_status pdi_attack_build(pd_ctx *ctx, const pd_setup *setup, pd_reactive *reactive, pd_dissolve *dissolve,
                                  const pd_course *course, pd_cell *cell, pd_electrode_map *map,
                                  pd_surfaces *surfaces, pd_attack *attack);
/* The variables vars [PD_EXPR_VARS] of a law, for what is at the surface beside a node: see pd_etch_fn. */
PDI_FN void pdi_attack_vars(const pd_attack_law *law, int32_t node, const double *c, double ph, double phi, double t,
                            double *vars);
/* With electrodes: what they are like before the first step, at time t [s]. */
PDI_FN pd_status pdi_attack_open(pd_ctx *ctx, void *user, double t);
PDI_FN void pdi_attack_free(pd_ctx *ctx, pd_attack *attack);
/* A pd_rate_fn of the dissolution, whose user is a pd_attack_law; its `found`, and the `find` of the course. */
PDI_FN double pdi_attack_rate(void *user, const pd_rate_at *at);
PDI_FN pd_status pdi_attack_found(pd_ctx *ctx, void *user, double t);
PDI_FN pd_status pdi_attack_find(pd_ctx *ctx, void *user, double t);
#endif

#endif
