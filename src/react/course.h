/* course: species in time as a process, in steps of two stages with a controlled error (theory: 8).
 *
 * Metal that dissolves gives amounts by node; they enter by the stoichiometry of a reaction, in the steps that follow
 * up to the end of the step of the run. Nodes that turn fluid begin as water without solutes, with migration with a
 * share of the fluid beside them.
 */
#ifndef PD_COURSE_H
#define PD_COURSE_H
#include "react/advance.h"
#include "react/coat.h"
#include "react/etch.h"
#include "solve/physics.h"

typedef struct pd_course_desc {
    double rtol;    /* [-] error of a step in the totals, over the largest of each component; 0: 1e-3 */
    double largest; /* [s] largest step; 0: none */
    int settle;     /* 1: the fields start steady */
    double *fed;    /* [total] [mol/m3] of metal that fluid nodes have got and that is not yet in the species; of each
                     * metal of `surface`. NULL: none dissolves. Borrowed: it is emptied here */
    const double *shed; /* [species] [-] of each with one of the metal, negative: it goes; unread without `fed` */
    void (*feed)(void *user, double *source); /* adds to sources [solutes][total] [mol/m3/s], as they are from the start
                                               * of the step of the run; NULL: nothing does */
    void *feeder;     /* user of that */
    pd_solve_at_fn bring; /* brings what `feed` goes by, and the metal, to the middle t [s] of each step; what is behind
                           * the species follows each of them then. NULL: that holds for a step of the run */
    void *bringer;    /* user of that */
    /* `feed` takes up more of a solute at a node than is there, at time t [s]: fails with a message that says who does;
     * NULL: nobody says */
    pd_status (*drained)(pd_ctx *ctx, void *user, int32_t node, int solute, double t);
    const pd_species *species; /* [species_count] names for messages, those that `reactive` was built of; NULL: none.
                                * Borrowed */
    int species_count;
    pd_etch *surface; /* metal dissolves by a law in the species, which move before it; NULL: it does not. Borrowed */
    pd_solve_at_fn find; /* lists its places when the species are at the start of a step of the run. With `cover`: also
                          * weighs them for each step of the species, or writes `ahead` where there is no `surface` */
    pd_solve_at_fn open; /* with `surface`, before the first step; NULL: nothing is to be done */
    void *user;
    double cover;       /* [m] thickness of minerals under which 1/e of metal is bare; 0: they cover none. Else the
                         * species move before the metal */
    double *bare;       /* [total] [-] bare share of metal nodes, times `whole`; with `cover`. Borrowed, written here:
                         * in a step of the species that of its middle, when the metal moves the mean over the step
                         * of the run */
    int layers;         /* [cells] of metal below its surface that dissolve, by faces; with `cover` */
    const double *whole; /* [total] [-] factor of the metal without minerals; NULL: 1. Borrowed */
    pd_coat *coat;      /* states of surfaces, which step with the species; NULL: there are none. Borrowed. `feed` is
                         * asked in the middle of each step then, and what is behind the species follows each of them */
    int *reached;       /* 0 is written to it when `bare` has changed; NULL: to none */
} pd_course_desc;

typedef struct pd_course {
    pd_course_desc desc;    /* defaults filled in; shed is not kept */
    pd_reactive *reactive;
    double lasts;                  /* [-] share of the step at hand after which a piece of metal is used up; 1: none */
    int used;                      /* 1: one is */
    double shed[PD_SPECIES_MAX];   /* [-] of solutes */
    double *start;          /* [solutes][total] [mol/m3] at the start of the step */
    double *carry;          /* [components][total] [mol/m3] the same */
    double *solid;          /* [minerals][total] [mol/m3] the same; NULL: none form */
    double *psi;            /* [total] [-] F phi/(R T), the same; with states among ions that migrate */
    double in[PD_SPECIES_MAX], out[PD_SPECIES_MAX]; /* [mol] the same */
    double time;            /* [s] */
    double dt;              /* [s] that is tried next; 0: not known yet */
    double error;           /* [-] estimated error of the last step */
    double residual;        /* [-] largest that a step has left of a balance, over its terms */
    double left;            /* [s] of the step of the run */
    double *due;            /* [metals][total] [mol/m3] of `fed` that comes in that time; NULL: none is */
    double taken;           /* [mol] of metal that is in the species */
    double *each;           /* [metals] [mol] of each of them; NULL: there is one */
    /* metal that minerals cover: */
    double *share;          /* [total] [-] bare, at the end of the step; -1: no minerals are near, or it is no metal */
    double *now, *first;    /* [total] [-] the same at the start of the step, and of the step of the run */
    double *rate;           /* [total] [1/s] at which it changed in the last step */
    double *mean;           /* [total] [-] over the step of the run, weighted by what bare metal would give; within it
                             * the sum of shares times `given` */
    double given;           /* [m] of `surface`, or [mol/m3] of `ahead`: sum of these weights */
    double step;            /* [s] the step at hand */
    double *ahead;          /* [total] [mol/m3/s] of metal that fluid nodes get in the step; NULL: by `surface`, or it
                             * gives nothing */
    double *came;           /* [total] [mol/m3] of it, in the step of the run; NULL: it gives nothing */
    double begin, span;     /* [s] start of the step of the run, length of one that is tried next; 0: not known yet */
    double tried, jump;     /* [s] first step that was tried; [-] error of shares of the last one that was */
    double covered;         /* [-] error of shares in the step of the run, over what it may be */
    int begun;              /* 1: places of the surface are those of the step of the run */
    int bent;               /* 1: nodes have turned fluid; the next step is not judged */
    int failed;             /* with migration: steps without a solution of their own, from `since` on */
    double since;           /* [s] */
    int settled;            /* with `psi`: 1: it is that of the ions as they are */
    int64_t steps, rejected, krylov, newton;
    int64_t euler;          /* steps taken by backward Euler */
} pd_course;

#define pd_course_build PD_NAME(pd_course_build)
#define pd_course_process PD_NAME(pd_course_process)
#define pd_course_free PD_NAME(pd_course_free)
#define pd_course_lost PD_NAME(pd_course_lost)

/* reactive is borrowed, and of order 2 (steady fields: of order 1). PD_ERR_ARGUMENT: a knob is negative or not
 * finite. */
PD_API pd_status pd_course_build(pd_ctx *ctx, pd_reactive *reactive, const pd_course_desc *desc, pd_course *course);
/* The species as a process. PD_ERR_STATE: the error does not fall with the step. PD_ERR_DIVERGED: no steady fields. */
PD_API pd_physics pd_course_process(pd_course *course);
PD_API void pd_course_free(pd_ctx *ctx, pd_course *course);
/* [mol] of a metal that is lost: what is in the species, and what the next step brings there. */
PD_API double pd_course_lost(const pd_course *course, int metal);

#ifdef PDI_INTERNAL
/* Arrays of a pd_course. */
PDI_FN void pdi_course_list(pdi_array_visitor *owner, void *object);
#endif

#endif
