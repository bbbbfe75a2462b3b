/* cell: electrodes on the metal of a run and the potential around them, as a process.
 *
 * The potential is found at the start and at the end of each step, with the surface as it is then, given values of that
 * time and the conductivity of that state. Where these change in time, it is found in the middle, too. Laws of
 * dissolution, reactions of electrodes and charges take current densities from there: from the middle, else from the
 * start (theory: 12.5).
 */
#ifndef PD_CELL_H
#define PD_CELL_H
#include "metal/metal.h"
#include "potential/distribution.h"
#include "solve/physics.h"

/* Zero-initialise. */
typedef struct pd_cell_desc {
    pd_potential_desc potential;       /* electrode, metal, circuit and left are unread; arrays are borrowed */
    const pd_electrode_desc *electrode; /* [potential.electrodes] copied */
    const pd_circuit *circuit;         /* [potential.circuits] copied */
    int (*which)(void *user, int32_t node);                /* electrode of a solid node */
    double (*given)(void *user, int circuit, double t);    /* value of a circuit at time t [s]; NULL: as it is */
    void (*conduct)(void *user, double *field);            /* [total] [S/m] at fluid nodes, now; NULL: uniform */
    /* writes the share of each contact, now; NULL: curves hold as they are */
    pd_status (*share)(pd_ctx *ctx, void *user, pd_contact *contact, int32_t count, double t);
    void *user;
    uint32_t reads; /* bit k: the law of metal k of dissolve reads E - phi */
    const char *const *name; /* [electrodes] borrowed; NULL: numbers stand for them in messages */
    int timed;  /* 1: given values, or shares, depend on time: a step goes by those of its middle */
    int apart;  /* 1: potential and currents are found elsewhere: contacts and circuits alone are those of now */
} pd_cell_desc;

/* What the surface of an electrode has met whose curve is a table. */
typedef struct pd_cell_range {
    double least, most; /* [V] of E - phi; least > most: nothing yet */
    double left;        /* [s] when it first was outside of the table; HUGE_VAL: never */
} pd_cell_range;

/* It must not be moved once it is built. */
typedef struct pd_cell {
    pd_cell_desc desc;
    const pd_grid *grid;
    const pd_dissolve *dissolve; /* NULL: the metal stays */
    pd_electrode *curve;         /* [electrodes] */
    pd_circuit *circuit;         /* [circuits] */
    uint8_t *metal;              /* [total] electrode of solid nodes */
    uint32_t *kinds;             /* [electrodes] bit k: it has metal k of dissolve; 1 without */
    double *charge, *anodic;     /* [electrodes] [C] that have passed since the start: from metal to fluid; what has
                                  * left alone */
    double *charge_error;        /* [electrodes] [C] estimates for the steps, added up */
    double *last_current;        /* [electrodes] [A] at the end of the last step */
    double *stock;               /* [electrodes] [mol] of metal at the build; 0 where nothing dissolves */
    pd_cell_range *met;          /* [electrodes] of curves that are tables */
    double *factor;              /* [electrodes] [-] what laws see of a current density, see pdi_cell_match */
    double *left;                /* [total] [-] see pd_potential_desc; NULL: nothing dissolves */
    int32_t *first;              /* [total] first contact of fluid nodes; -1: none; NULL: nothing dissolves */
    double *field;               /* [total] [S/m] with `conduct`: that of the last solution */
    double *last_field;          /* [total] [S/m] with `conduct`: at the end of the last step */
    double *change;              /* [total] [S/m/s] of it, in the last step */
    pd_potential potential;
    pd_potential_result result;  /* of the last solution */
    int stale;                   /* 1: nodes have turned fluid */
    double time;                 /* [s] of the last solution */
    double reached;              /* [s] end of the last step, up to which charges are counted */
    int64_t solves, newton, krylov;
} pd_cell;

typedef enum pd_cell_touches {
    PD_CELL_APART = 0, /* no fluid touches the metal */
    PD_CELL_IDLE = 1,  /* no current can pass where it does */
    PD_CELL_WORKS = 2
} pd_cell_touches;

/* An electrode as it is now. */
typedef struct pd_cell_electrode {
    pd_cell_touches touches;
    double potential;        /* [V] E of its metal; NaN where nothing tells it */
    double area;             /* [m^(d-1)] of a body of rings all around */
    double current, anodic;  /* [A] (per m in planar 2D, per m2 in 1D) from metal to fluid; what leaves alone */
    double least, most;      /* [A/m2] */
    double charge, passed;   /* [C] likewise, since the start: from metal to fluid; what has left alone */
    double charge_error;     /* [C] by which charge may be off, an estimate */
    double lost;             /* [mol] of metal since the start; 0 where nothing dissolves */
    pd_cell_range met;       /* since the start */
} pd_cell_electrode;

#define pd_cell_build PD_NAME(pd_cell_build)
#define pd_cell_process PD_NAME(pd_cell_process)
#define pd_cell_electrode_of PD_NAME(pd_cell_electrode_of)
#define pd_cell_free PD_NAME(pd_cell_free)
#define pd_cell_table PD_NAME(pd_cell_table)

/* Grid, bonds and dissolve (or NULL) are borrowed. Errors are those of the curves and of the potential; a circuit has
 * metal. */
PD_API pd_status pd_cell_build(pd_ctx *ctx, const pd_grid *grid, const pd_bonds *bonds, const pd_dissolve *dissolve,
                               const pd_cell_desc *desc, pd_cell *cell);
/* It stands behind all that changes metal and fluid. PD_ERR_DIVERGED: balances lack more than the tolerance. */
PD_API pd_physics pd_cell_process(pd_cell *cell);
PD_API void pd_cell_electrode_of(const pd_cell *cell, int electrode, pd_cell_electrode *now);
PD_API void pd_cell_free(pd_ctx *ctx, pd_cell *cell);
/* The table that the curve of an electrode is; NULL: it is none. */
PD_API const pd_electrode_term *pd_cell_table(const pd_cell *cell, int electrode);

#ifdef PDI_INTERNAL
/* u [V] is met at time t [s]. */
PDI_FN void pdi_cell_meet(const pd_electrode_term *table, double u, double t, pd_cell_range *met);
/* The fluid beside metal is known. Areas of contacts and those of dissolution differ on uneven surfaces: what laws get
 * of the current density of an electrode is multiplied so that they get all of what leaves it (theory: 12.5). */
PDI_FN void pdi_cell_match(pd_cell *cell);
/* Beside fluid node i: current density [A/m2] and E - phi at the surface [V] of electrodes with metal `kind`, means
 * over the area of its contacts; where it has none, of those nearest within two cells. 0: there is none. */
PDI_FN int pdi_cell_beside(const pd_cell *cell, int32_t i, int kind, double *current, double *surface);
/* A solution for time t [s] within a step, by which the step goes: with the states of surfaces as they are, and
 * conductivities that change as in the last step. Nothing is done where it is that of the last one. */
PDI_FN pd_status pdi_cell_bring(pd_ctx *ctx, pd_cell *cell, double t);
/* Current density [A/m2] at the contacts of fluid node i, of all electrodes; NaN where it has none. */
PDI_FN double pdi_cell_density(const pd_cell *cell, int32_t i);
/* Current density j[PD_DIM] [A/m2] in fluid node i: the first moment of what its bonds and contacts carry, which a
 * linear field has exactly (theory: eq. 12.8). */
PDI_FN void pdi_cell_current(const pd_cell *cell, int32_t i, double *j);
/* Its arrays, but for those of the potential. */
PDI_FN void pdi_cell_list(pdi_array_visitor *owner, void *object);
#endif

#endif
