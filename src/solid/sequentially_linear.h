/* sequentially_linear: sequentially linear analysis of fracture under a proportional load, one broken bond after
 * another.
 *
 * For materials whose forces are linear. The equilibrium of the remaining bonds is solved
 * for the load times 1. The factor at which the first of them reaches its critical value is the next event; it breaks,
 * with those that tie with it, and so on. Factors may fall and so may displacements: the path follows what arc length
 * follows, and needs no iteration. Force F and displacement q are conjugate: F works along q. Of moved points q is the
 * factor, of loads F is. Bonds break while q stays: what is stored less then is what they have taken. Then q goes on,
 * forward or back, to the next event (theory: 15.14).
 *
 * Source: Rots and Invernizzi 2004 (sequentially linear analysis).
 */
#ifndef PD_SEQUENTIALLY_LINEAR_H
#define PD_SEQUENTIALLY_LINEAR_H
#include "solid/bond_failure.h"
#include "solid/equilibrium.h"

/* Zero-initialise. Either `moved` or `load` is given. */
typedef struct pd_sequentially_linear_desc {
    const uint8_t *prescribed;       /* [count][PD_DIM] 1: this displacement is given; NULL: none. Borrowed */
    const double *unit_displacement; /* [count][PD_DIM] [m] displacements of what is held, at the factor 1; NULL: 0.
                                      * Borrowed */
    const double *load;          /* [count][PD_DIM] [N/m3] at the factor 1; NULL: none. Borrowed */
    pd_bond_failure_desc criterion; /* by which bonds break */
    double rtol;                 /* [-] as of pd_equilibrium_desc */
} pd_sequentially_linear_desc;

typedef struct pd_sequentially_linear {
    pd_sequentially_linear_desc desc;
    pd_material_interface solid;
    pd_bond_failure criterion;
    int64_t n;            /* components of all points */
    double *u;            /* [n] [m] at the factor 1, of the bonds that are left */
    double *event_u;      /* [n] [m] at the last event, before its bonds broke */
    double factor;        /* [-] of the last event */
    double force;         /* F there, before bonds break: [N m] of moved points (per m in 2D, per m2 in 1D), [-] of
                           * loads */
    double displacement;  /* q there: [-] of moved points, [N m] (per m in 2D, per m2 in 1D) of loads */
    double stored;        /* [J] (per m in 2D, per m2 in 1D) there, before bonds break */
    double work;          /* [J] of the load up to there */
    double dissipated;    /* [J] that bonds have taken, those of the last event not yet counted; at the end all */
    pd_first_failure first; /* the bond of the last event */
    int64_t events, broken;
    double initial_energy; /* [J] stored at the factor 1 by all bonds */
    int done;             /* 1: no other bond breaks, or a loaded piece has come off */
    int iterations;       /* of the last balance */
} pd_sequentially_linear;

#define pd_sequentially_linear_build PD_NAME(pd_sequentially_linear_build)
#define pd_sequentially_linear_next_event PD_NAME(pd_sequentially_linear_next_event)
#define pd_sequentially_linear_free PD_NAME(pd_sequentially_linear_free)

/* The material is borrowed, its table copied. After an error the object is empty. PD_ERR_ARGUMENT: forces that are not
 * linear, both unit_displacement and load or none of them, unit_displacement without prescribed, no critical value, and
 * as of pd_bond_failure_build. */
PD_API pd_status pd_sequentially_linear_build(pd_ctx *ctx, const pd_material_interface *solid,
                                              const pd_sequentially_linear_desc *desc,
                                              pd_sequentially_linear *sequential);
/* Computes the next event (factor, force, displacement, stored, work) and breaks its bonds in the body; nothing where
 * `done` is 1. `done`, with PD_OK: there was none, as no bond has a positive measure, loads tore a component
 * off, or displacements left no more than 1e-12 of the first stored energy; what is stored is then dissipated. Points
 * that lose all bonds below the factor break before the event. Errors: those of the equilibrium and of the material. */
PD_API pd_status pd_sequentially_linear_next_event(pd_ctx *ctx, pd_sequentially_linear *sequential);
PD_API void pd_sequentially_linear_free(pd_ctx *ctx, pd_sequentially_linear *sequential);

#endif
