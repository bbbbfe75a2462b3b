/* potential: the electric potential of an electrolyte around metals (secondary current distribution).
 *
 * div(kappa grad phi) = 0 in the fluid. At metal kappa dphi/dn = -i(E - phi), with the curve i of its electrode and the
 * potential E of the metal. Metals that touch, or are wired to each other, form a circuit: they share one E, which is
 * given, or follows from a given current, or from no net current (free corrosion, galvanic couples). Other surfaces
 * insulate (theory: 12). Newton's method minimises the convex energy of the field, all E included; linear systems are
 * solved by conjugate gradients with multigrid.
 *
 * Where neither a side of the box nor a circuit has a given potential, the mean of phi over the electrolyte is 0.
 */
#ifndef PD_POTENTIAL_H
#define PD_POTENTIAL_H
#include "potential/contact.h"
#include "potential/electrode.h"
#include "solve/krylov.h"
#include "transport/inverse.h"

typedef enum pd_circuit_control {
    PD_CIRCUIT_CURRENT = 0,  /* `value` is the current [A] (per m in planar 2D, per m2 in 1D) from metal to electrolyte.
                              * 0: it corrodes freely */
    PD_CIRCUIT_POTENTIAL = 1 /* `value` is E [V] */
} pd_circuit_control;

typedef struct pd_circuit {
    pd_circuit_control control;
    double value; /* [V] or [A], see above */
} pd_circuit;

/* Zero-initialise. All arrays are borrowed for the life of the object. */
typedef struct pd_potential_desc {
    double conductivity;           /* [S/m] kappa, positive */
    const double *field;           /* [total] [S/m] the same at fluid nodes; NULL: `conductivity` everywhere */
    const pd_electrode *electrode; /* [electrodes] curves */
    int electrodes;                /* 1 to PD_ELECTRODES */
    const uint8_t *metal;          /* [total] which of them a solid node is; NULL: the first one */
    const pd_circuit *circuit;     /* [circuits] */
    int circuits;
    const int *member;             /* [electrodes] circuit of each electrode; NULL: all are in the first one */
    const pd_stencil *wide;        /* family from which normals of cells are found, where no shape tells them; NULL:
                                    * that of the bonds. Three spacings do */
    const double *left;            /* [total] [-] share of the metal that is left in solid nodes; NULL: 1 */
    int held[2 * PD_DIM];          /* 1: a side of the box, a wall or inlet, holds the potential ... */
    double hold[2 * PD_DIM];       /* [V] ... of this value. Other sides insulate, or repeat as the grid says */
    double tolerance;              /* [-] of what the balances lack, over the currents; 0: 1e-12 */
    int max_newton;                /* 0: 200 */
    int idle;                      /* 1: where the curves around a pocket carry current one way only, none passes
                                    * there; 0: refused */
    const char *const *name;       /* [electrodes] for messages; NULL: numbers */
    int apart;                     /* 1: it is not solved, and all contacts are kept */
} pd_potential_desc;

/* It must not be moved once it is built. */
typedef struct pd_potential {
    pd_potential_desc desc; /* defaults filled in */
    const pd_grid *grid;
    const pd_bonds *bonds;
    double *phi;            /* [total] [V] of fluid nodes: guess of the next solve, and its result */
    double *metal;          /* [circuits] [V] E, likewise */
    double *total;          /* [circuits] [A] (per m in planar 2D) current of the last solve */
    pd_contacts contacts;
    double *current;        /* [contacts.count] [A/m2] of the last solve, from metal to electrolyte */
    double *surface;        /* [contacts.count] [V] E - phi at the surface */
    double *slope;          /* [contacts.count] [S/m2] derivative of current by E - phi at the node */
    double *trial;          /* [contacts.count] [A/m2] work */
    int32_t *pocket;        /* [total] a node of the electrolyte that each fluid node hangs together with; -1: no
                             * fluid */
    double *level;          /* [total] [V] of each pocket at that node: in a solve phi counts from there, since beside a
                             * good conductor its differences drown in a level of volts. Else 0 */
    uint8_t *fixed;         /* [total] 1 at that node: held sides touch the pocket */
    int32_t *part;          /* [total + circuits + 1] what hangs together: by nodes, circuits, and ground, which all
                             * given potentials are. The entries of one part have one value, that of an entry of it */
    uint8_t *wet;           /* the same count: 1 at that entry: the part has metal or ground */
    int32_t *place;         /* [circuits] place among the unknowns behind the nodes; -1: E is given, or kept as it is
                             * since nothing else tells it */
    int floating;           /* of them are unknown */
    double origin;          /* [V] held potentials count from here, the least of them */
    pd_diffusion diffusion; /* conductances, with kappa for the diffusivity */
    pd_open_boundary boundary;
    pd_flux flux;
    pd_inverse inverse;
    pd_krylov krylov;
    pd_arena arena;         /* lends what follows for a solve */
    double *absorb;         /* [total] [S/m3] */
    double *repeated;       /* [total] [V] operand with its images */
    double *rest;           /* [total + floating] [A/m3], times circumferences: what balances lack */
    double *step;           /* [total + floating] [V] */
    double *along;          /* [total] [A/m3] what the step changes in the electrolyte */
    double *answer;         /* [floating][total] [-] change of phi with E, about */
    double *schur;          /* [floating][floating] [S/m3] factor of what E has left without phi */
} pd_potential;

typedef struct pd_potential_result {
    int newton, krylov;  /* iterations */
    double residual;     /* [-] what balances lack, over the currents (Euclidean norms) */
    double imbalance;    /* [-] sum of all currents, over the sum of their sizes and of what 0.1 mV drives */
    double through;      /* [A] (per m in planar 2D) from held sides into the electrolyte */
    double anodic;       /* [A] (per m in planar 2D) sum of the currents that leave metal */
    int worst;           /* PD_NOT_CONVERGED: an electrode where balances lack most */
} pd_potential_result;

#ifdef PDI_INTERNAL
#include <math.h>
/* [V] No potential is further off than that. */
#define PDI_POTENTIAL_FAR 1e6
/* [V] Slopes of curves count in the size of currents with that. */
#define PDI_POTENTIAL_SMALL 1e-4

/* Circuit of an electrode. */
static inline int pdi_potential_circuit(const pd_potential *p, int electrode)
{
    return p->desc.member ? p->desc.member[electrode] : 0;
}
/* kappa [S/m] of a fluid node. */
static inline double pdi_potential_kappa(const pd_potential *p, int32_t node)
{
    return p->desc.field ? p->desc.field[node] : p->desc.conductivity;
}
/* E - phi [V] between a metal and a node. */
static inline double pdi_potential_drop(const pd_potential *p, const pd_contact *c)
{
    double level = p->level[p->pocket[c->node]];
    return (p->metal[pdi_potential_circuit(p, c->electrode)] - level) - p->phi[c->node];
}
/* Area of a contact over the volume of a cell, with the circumference [1/m, on rings 1]. */
static inline double pdi_potential_area(const pd_potential *p, const pd_contact *c)
{
    return c->area * pd_grid_circumference(p->grid, c->node);
}
#endif

#endif
