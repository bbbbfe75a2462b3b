/* coat: what surfaces of metal carry besides the species beside them, such as the cover and the thickness of a film:
 * states with laws for their rates, stepped with the species (theory: 9.10).
 *
 * The states of a place are ordinary differential equations in the concentrations at the surface, which are those of
 * the node behind what metal gives (etch.h). A step of the species is one of the states: they are first taken to its
 * middle, with concentrations that go on as in the last step; what depends on them is found there and holds for the
 * step. Then they take the step again, with concentrations from its start to its end. Second order in time. Among ions
 * that migrate they are taken to both stages of the step of the species instead, which find potentials with them.
 */
#ifndef PD_COAT_H
#define PD_COAT_H
#include "react/reactive.h"
#include "solve/physics.h"
#include "solve/stiff_ode.h"

#define PD_COAT_MOST PD_STIFF_ODE_MAX_EQUATIONS /* states */
#define PD_COAT_AROUND 2           /* values besides the species that rates may read */

/* What rates read at a place. */
typedef struct pd_coat_at {
    int32_t node;
    const double *c;      /* [solutes] [mol/m3] at the surface, of those that rates read */
    double ph;            /* [-] NaN without H+ */
    const double *around; /* [PD_COAT_AROUND] [unit of each] as the caller says */
    double time;          /* [s] */
} pd_coat_at;

typedef struct pd_coat_desc {
    int count;                                     /* states, 1 to PD_COAT_MOST */
    double low[PD_COAT_MOST], high[PD_COAT_MOST];  /* [unit of each] rates out of them are 0 there; infinite: none */
    const char *name[PD_COAT_MOST];                /* for messages */
    double rtol;                                   /* [-] error of a step over the largest that each state has been */
    double tolerance;                              /* [-] error of the equations of a place in each of their own steps;
                                                    * 0: 1e-10 */
    uint32_t reads;                                /* bit n: rates depend on solute n, */
    int reads_ph;                                  /* 1: on pH */
    uint32_t reads_around;                         /* with `surface`, bit n: on value n around */
    /* on [total] of fluid nodes: bit k: the surface there carries state k; 0 before the call. `anew`: nodes have turned
     * fluid since the last one */
    pd_status (*where)(pd_ctx *ctx, void *user, int anew, uint32_t *on);
    double (*initial)(void *user, int state, int32_t node);
    void (*rate)(void *user, const pd_coat_at *at, const double *y, double *rate); /* [count] [unit of each per s] */
    /* Bring what depends on states to time t [s]; NULL: nothing does but what is asked for in the step. */
    pd_solve_at_fn solve;
    void (*around)(void *user, int32_t node, double *around); /* then; NULL: nothing else is read */
    /* Adds to flows [components] what comes out of metal at a node, as of pd_etch: [mol/m3]. NULL: nothing does. */
    void (*film)(void *user, int32_t node, double *flows);
    /* Among ions that migrate: c [solutes] [mol/m3] and `around` at the surface beside a node, as they are now; 0:
     * there is none. The metal is asked at the stages of a step then, with the states that were foreseen for each, and
     * `solve` brings what follows them there. NULL: by `film`. */
    int (*surface)(void *user, int32_t node, double *c, double *around);
    int stages; /* 1: with `surface` */
    void *user;
} pd_coat_desc;

typedef struct pd_coat {
    pd_coat_desc desc;
    pd_reactive *reactive;
    pd_components film;           /* see pd_etch */
    double scale[PD_SPECIES_MAX]; /* [-] the same */
    uint32_t *on;     /* [total] see `where` */
    uint32_t *was;    /* [total] work */
    int32_t *node;    /* [total] of places */
    int32_t count;    /* of places */
    double *value;    /* [states][total] [unit of each] now; within a step of the species in its middle */
    double *start;    /* [states][total] [unit of each] at the start of the step */
    double *middle;   /* [states][total] [unit of each] in its middle, or at its first stage, as it was foreseen */
    double *ending;   /* [states][total] [unit of each] at its end, with `surface` */
    double from, span; /* [s] of the step at hand, with `surface` */
    /* at the surface, columns of solutes that rates read [mol/m3], with pH of ln gamma of a charge of 1 [-]: -1, and
     * with `surface` of value n around: -2 - n */
    int columns, solute[PD_SPECIES_MAX + 1 + PD_COAT_AROUND];
    double *fresh;    /* [columns][total] [unit of each] at the start of the step */
    double *slope;    /* [columns][total] [unit of each per s] of that, in the last step */
    double *first;    /* [columns][total] [unit of each] the same with what comes out of metal in the middle */
    double *way;      /* [columns][total] [unit of each per s] change from there to the end of the step */
    int *off;         /* [total] work: what went wrong at places */
    double size[PD_COAT_MOST]; /* [unit of each] largest value since the start */
    double last;      /* [s] the last step; 0: none */
    double error;     /* [-] of the last attempt, over what it may be */
    int anew;         /* 1: nodes have turned fluid; at first, too */
    int begun;        /* 1: there are places */
} pd_coat;

#ifdef PDI_INTERNAL
/* reactive is borrowed. */
PDI_FN pd_status pdi_coat_build(pd_ctx *ctx, pd_reactive *reactive, const pd_coat_desc *desc, pd_coat *coat);
PDI_FN void pdi_coat_free(pd_ctx *ctx, pd_coat *coat);
/* Its columns, from the desc and reactive. */
PDI_FN void pdi_coat_columns(pd_coat *coat);
PDI_FN void pdi_coat_list(pdi_array_visitor *owner, void *object);
/* Find the places as they are now; new ones take over what those around them carry. */
PDI_FN pd_status pdi_coat_places(pd_ctx *ctx, pd_coat *coat);
/* A step of the species begins at t [s]. */
PDI_FN pd_status pdi_coat_begin(pd_ctx *ctx, pd_coat *coat, double t);
/* To the middle of a step of dt [s]. PD_RETRY: a rate is not finite, or no steps follow it; after some `trial`s there
 * is a message. */
PDI_FN pd_status pdi_coat_ahead(pd_ctx *ctx, pd_coat *coat, double t, double dt, int trial);
/* To its end, after the species, whose concentrations [solutes][total] were `from`. */
PDI_FN pd_status pdi_coat_behind(pd_ctx *ctx, pd_coat *coat, const double *from, double t, double dt,
                                 int trial);
/* With `surface`: states are those foreseen for a share of the step, of its first stage or 1. */
PDI_FN pd_status pdi_coat_stage(pd_ctx *ctx, pd_coat *coat, double share);
/* The same for a step of dt [s] in which they stay as they are. */
PDI_FN void pdi_coat_rest(pd_coat *coat, double t, double dt);
/* The step of dt [s] stands; it does not. */
PDI_FN void pdi_coat_accept(pd_coat *coat, double dt);
PDI_FN void pdi_coat_reject(pd_coat *coat);
/* What rates read at a place, and y [count] its states: at the start t [s] of the step at hand, or (dt > 0) at its end,
 * once it has been tried. c [PD_SPECIES_MAX] and around [PD_COAT_AROUND] hold what `at` points to. */
PDI_FN void pdi_coat_reads(const pd_coat *coat, int32_t place, double t, double dt, double *c, double *around,
                           pd_coat_at *at, double *y);
/* A state at the surface beside a fluid node; where that carries none, the mean of the nearest places within two cells,
 * else that of the start. */
PDI_FN double pdi_coat_value(const pd_coat *coat, int state, int32_t node);
#endif

#endif
