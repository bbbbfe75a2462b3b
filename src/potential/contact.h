/* contact: where metal meets the electrolyte: the area of each electrode that a fluid node has, and its distance.
 *
 * A bond of the fluid that ends on metal would carry a(n) (xi.N) times the slope of the potential to its node. That is
 * the area which it stands for, over the volume of the node. The sum over all bonds that cross a plane is exactly its
 * area, whatever its direction, since the second moments of a(n) are those of the Laplacian (theory: eq. 12.3). The
 * normal N is that of the shape where the surface is known, else that of the cells around.
 */
#ifndef PD_CONTACT_H
#define PD_CONTACT_H
#include "lattice/bond.h"

/* Most electrodes. */
#define PD_ELECTRODES 256

/* An electrode beside a fluid node. */
typedef struct pd_contact {
    int32_t node;
    int electrode;
    double area; /* [1/m] over the volume of the node */
    double way;  /* [m] from the node to the surface */
    double share; /* [-] factor of the curve, at least 0: 1, or as the caller sets it */
    double moment[PD_DIM]; /* [-] a current density of 1 carries that through the node (theory: eq. 12.8) */
} pd_contact;

typedef struct pd_contacts {
    pd_contact *list; /* [capacity] by nodes, and for each of them by electrodes; all of a node are idle, or none */
    int32_t count;    /* where currents may pass; behind them stand */
    int32_t idle;     /* those of pockets where none can */
    int32_t capacity;
} pd_contacts;

#ifdef PDI_INTERNAL
/* The metal of a grid. */
typedef struct pdi_contact_metal {
    const uint8_t *electrode; /* [total] index of the electrode of solid nodes; NULL: 0 */
    const double *left;       /* [total] [-] share of the metal that is left in solid nodes; NULL: 1 */
    const pd_stencil *wide;   /* family that normals of cells are found with */
} pdi_contact_metal;

/* All of them. */
static inline int32_t pdi_contact_all(const pd_contacts *contacts) { return contacts->count + contacts->idle; }
/* PD_ERR_MEMORY, PD_ERR_LIMIT. None is idle. */
PDI_FN pd_status pdi_contact_find(pd_ctx *ctx, const pd_bonds *bonds, const pdi_contact_metal *metal,
                                  pd_contacts *contacts);
PDI_FN void pdi_contact_free(pd_ctx *ctx, pd_contacts *contacts);
#endif

#endif
