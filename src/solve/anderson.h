/* anderson: fixed points x = g(x) of maps that cost much, from the steps g(x) - x at the last places.
 *
 * The next place is the one where the step is least in the plane through the last places, plus what is left of the step
 * there (Anderson 1965; Walker and Ni 2011). Of a linear map it is that of GMRES. Changes of steps are kept orthogonal,
 * and those of places with them (Eirola and Nevanlinna 1989); when there is no room for more, all are dropped. Maps
 * that bend, as of metal that begins to flow, may lead away: where steps grow twice in turn beyond the least one, the
 * search goes on from its place, without what was kept and by half as much of the step.
 */
#ifndef PD_ANDERSON_H
#define PD_ANDERSON_H
#include "core/owner.h"

#define PD_ANDERSON_KEPT 12

typedef struct pd_anderson {
    int64_t n;      /* of a vector */
    int count;      /* changes that are kept */
    int known;      /* 1: there is a last place */
    double *x;      /* [n] [unit of x] the last place */
    double *step;   /* [n] [unit of x] the step there */
    int grown;      /* times in turn that the step has grown beyond the least */
    double size;    /* [unit of x] of the last step */
    double least;   /* [unit of x] of all steps */
    double part;    /* [-] of what is left of a step that the place moves by; 1 until steps have grown so */
    double *best;   /* [n] [unit of x] the place of the least step */
    double *shortest; /* [n] [unit of x] the step there */
    double *turn;   /* [KEPT][n] [-] changes of steps, orthogonal and of length 1 */
    double *way;    /* [KEPT][n] [-] changes of places with them */
} pd_anderson;

#ifdef PDI_INTERNAL
PDI_FN void pdi_anderson_list(pdi_owner *owner, void *anderson);
/* x [n] becomes the next place. step [n]: g(x) - x; it is overwritten. Same bits for any number of threads. */
PDI_FN void pdi_anderson_next(pd_anderson *anderson, double *x, double *step);
/* Places before count no more: those that come are of another map. */
PDI_FN void pdi_anderson_forget(pd_anderson *anderson);
#endif

#endif
