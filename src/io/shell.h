/* shell: the surface of a set of cells of a three-dimensional lattice as a smooth mesh.
 *
 * A corner stands between eight cells of which some belong to the set (surface nets, Gibson 1998). It begins where the
 * edges between their middles cross the surface, on the mean, and is moved towards its neighbours without leaving the
 * eight middles, so the steps of cells vanish and the surface stays within a cell of where it was. Around the lattice
 * nothing belongs to the set: a set that reaches a side is closed there by a plane face.
 */
#ifndef PD_SHELL_H
#define PD_SHELL_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* A set of cells. */
typedef struct pdi_shell_desc {
    int n[3];                /* cells */
    double lo[3], h[3];      /* [m] low corner of the lattice, size of a cell */
    /* Share of the cell i[3] that belongs to the set: up to 0: none, 1: all of it. The surface stands at this share of
     * the way through a cell at it, but not behind its middle. */
    double (*share)(const void *user, const int *i);
    /* Value of the surface between a cell of the set and one beside it, which may lie outside of the lattice; NaN: it
     * has none; NULL: all have none. */
    double (*value)(const void *user, const int *in, const int *out);
    const void *user;
} pdi_shell_desc;

/* Zero-initialise. */
typedef struct pdi_shell {
    int64_t corners, corner_room;
    double *x;       /* [corner_room][3] [m] */
    double *mean;    /* [corner_room] [-] of the values around; NaN: none */
    int64_t faces, face_room, value_room;
    int32_t *corner; /* [face_room][4] of each face, counterclockwise seen from outside */
    double *value;   /* [value_room] [-] */
    float *normal;   /* [face_room][4][3] [-] outward, of length 1, of each face at its corners; they differ at edges */
} pdi_shell;

PDI_FN pd_status pdi_shell_build(pd_ctx *ctx, const pdi_shell_desc *desc, pdi_shell *shell);
PDI_FN void pdi_shell_free(pd_ctx *ctx, pdi_shell *shell);
#endif

#endif
