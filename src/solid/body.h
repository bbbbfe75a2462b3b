/* body: material points of a solid and their families.
 *
 * Points are those of a lattice or any others. The family of a point is all points within the horizon: |xi| <= horizon,
 * or with `spacing` all whose cells reach into the horizon, where cells at the rim count with the part that lies within
 * it. A family is sorted by the places of its points, so what is summed over it does not depend on the order of the
 * points. Search: cell lists, O(count).
 *
 * Families are read by bond iterators (pd_bond_iterator): a list of index shifts leads through a table of points. The
 * table of a lattice has an entry for each lattice position, and the list is the stencil of a complete family: no bond
 * is stored. The table of other points holds their families one after another (compressed sparse rows). Bonds are
 * numbered in that order. One bit for each bond says whether it is broken.
 *
 * The straight line of a bond may leave the body across a gap, a notch or a slot. Such pairs are no bonds: no family
 * has them. The faces of the surface decide it (visibility criterion), or the callback `joined`. On a lattice a point
 * with an incomplete family has a list of its own, as long as the stencil.
 *
 * With a period a family has periodic images of points, too: also of its own point, where the period is shorter than
 * the horizon. An image moves as its point does. A family is sorted by image numbers first, and all families are
 * stored.
 */
#ifndef PD_BODY_H
#define PD_BODY_H
#include "core/array_registry.h"
#include "solid/partial_volume.h"
#include <math.h>

/* Influence function omega(r): weight of a bond by its length r. */
typedef enum pd_influence {
    PD_INFLUENCE_CONSTANT = 0, /* 1 */
    PD_INFLUENCE_INVERSE,      /* horizon/r */
    PD_INFLUENCE_LINEAR        /* 1 - r/(horizon + spacing) */
} pd_influence;

/* Partial volume: which fraction of a cell at the edge of the horizon counts. */
typedef enum pd_partial_volume {
    PD_PARTIAL_VOLUME_LINEAR = 0, /* by its distance: falls from 1 at horizon - spacing/2 to 0 at horizon + spacing/2 */
    PD_PARTIAL_VOLUME_EXACT       /* the part of the interval, square or cube that lies within the ball */
} pd_partial_volume;

/* 1: the straight line from point i by xi [m], to point j or to an image of it, stays within the body. Asked for one
 * end of a bond alone, that of the lesser coordinate, by several threads. */
typedef int (*pd_bond_inside_fn)(void *user, int32_t i, int32_t j, const double *xi);

typedef struct pd_body_desc {
    int32_t count;
    const double *position; /* [count][PD_DIM] [m] */
    const double *volume;   /* [count] [m^d] */
    double horizon;         /* [m] */
    double spacing;         /* [m] of a lattice: parts of cells at the rim count; 0: points count wholly or not */
    pd_partial_volume rim;  /* of a lattice */
    double period[PD_DIM];  /* [m] by which the points repeat; zero along the last axis: they do not */
    pd_bond_inside_fn joined; /* NULL: no bond leaves the body but by its faces */
    void *user;
    int64_t faces;          /* of the surface; 0: it is not known */
    const double *face;     /* [faces][PD_DIM][PD_DIM] [m] their corners: points, segments, triangles, such as those of
                             * pd_points. Bonds that cross one leave the body. Not with a period */
} pd_body_desc;

typedef struct pd_body {
    int32_t count;
    int32_t real_count; /* points without the mirror images behind planes of symmetry, which come last. The energy of
                         * the body is that of these points */
    const int32_t *image_source; /* [count - own] borrowed: the point that an image stands for; NULL without images */
    const uint8_t *image_reflection; /* [count - own] borrowed: bit d: it is a reflection along axis d */
    double horizon;    /* [m] */
    double spacing;    /* [m] */
    pd_partial_volume rim;
    double period[PD_DIM]; /* [m] */
    /* of a lattice with PD_PARTIAL_VOLUME_EXACT: cells along an axis in cell_fraction; 0: no table */
    int32_t fraction_cells;
    double *cell_fraction; /* [cells^PD_DIM] [-] volume fractions of cells within the horizon by their offsets, axis 0
                            * fastest */
    double *position;  /* [count][PD_DIM] [m] */
    double *volume;    /* [count] [m^d] */
    int64_t bonds;     /* of all families: each bond counts twice */
    int64_t *first_bond; /* [count + 1] number of the first bond of each family */
    int lattice;       /* 1: all points are on a lattice, and families come from the shared stencil */
    int32_t stencil_bonds; /* bonds of the lattice stencil; otherwise bonds of the longest family */
    int64_t shifts;        /* entries of stencil_shift: kinds, or twice that with lists */
    int32_t *stencil_shift;  /* [shifts] index distances from the entry of a point in point_table to those of its
                              * family; then the ones for points with lists of their own */
    int64_t table_entries;   /* entries of point_table */
    int64_t lattice_entries; /* entries of point_table that are lattice positions; lists of single points follow them */
    int32_t *point_table; /* [places] point at each lattice position, -1: none, then the lists of points with incomplete
                           * families; without a lattice the families, one after another */
    int32_t *table_index; /* [count] of a lattice: index in point_table of each point, or of its own list */
    int8_t *bond_image;   /* [bonds] with a period: number of periods between the other end and the point it is an image
                           * of */
    uint8_t *broken;   /* one bit for each bond, whole bytes for each family; 1: broken, set at both ends of the bond */
} pd_body;

/* Iterator over the bonds of the family of a point. */
typedef struct pd_bond_iterator {
    const int32_t *point_entry; /* entry of the point in point_table */
    const int32_t *shift;  /* of the body */
    const uint8_t *broken; /* bits of the family */
    const int8_t *image;   /* of its bonds; NULL without a period */
    int64_t first;         /* number of its first bond */
    int32_t bonds;         /* how many it has */
    int32_t number;        /* current bond: number within the family; -1 before the first one */
    int32_t stencil_position; /* index of its shift: position in the stencil of a lattice */
    int32_t neighbour;        /* the point at its other end */
} pd_bond_iterator;

#define pd_body_build PD_NAME(pd_body_build)
#define pd_body_free PD_NAME(pd_body_free)

/* Builds the families of all points; copies positions and volumes. No bond is broken; after an error the body is empty.
 * PD_ERR_ARGUMENT: no point; a horizon or volume not positive and finite; a horizon below the spacing; an exact rim
 * without a spacing; a place or face corner not finite; faces with a period; a period along the last axis not longer
 * than the points, or below 0.01 (horizon + spacing). PD_ERR_GEOMETRY: two points at one place (the message names
 * both). PD_ERR_SIZE: a lattice has too many families that lost bonds. */
PD_API pd_status pd_body_build(pd_ctx *ctx, const pd_body_desc *desc, pd_body *body);
PD_API void pd_body_free(pd_ctx *ctx, pd_body *body);
/* 1: the body is periodic. */
static inline int pd_body_is_periodic(const pd_body *body) { return body->period[PD_DIM - 1] > 0.0; }
/* Iterator that stands before the first bond of point i. Use: for (pd_bond_iterator f = pd_body_bonds_begin(body, i);
 * pd_body_bonds_next(&f);) ... f.neighbour ... */
static inline pd_bond_iterator pd_body_bonds_begin(const pd_body *body, int32_t i)
{
    pd_bond_iterator f;
    f.first = body->first_bond[i];
    f.bonds = (int32_t)(body->first_bond[i + 1] - f.first);
    f.point_entry = body->point_table + (body->lattice ? (int64_t)body->table_index[i] : f.first);
    f.shift = body->lattice && body->table_index[i] >= body->lattice_entries ? body->stencil_shift + body->stencil_bonds
                                                                             : body->stencil_shift;
    f.broken = body->broken + ((f.first + 7 * (int64_t)i) >> 3); /* each family begins in a byte of its own */
    f.image = pd_body_is_periodic(body) ? body->bond_image + f.first : NULL;
    f.number = f.stencil_position = f.neighbour = -1;
    return f;
}
/* Moves to the next bond, broken ones too. Returns 1; 0: the family has ended, and no further call is allowed. */
static inline int pd_body_bonds_next(pd_bond_iterator *f)
{
    if (++f->number == f->bonds) return 0;
    do f->neighbour = f->point_entry[f->shift[++f->stencil_position]];
    while (f->neighbour < 0);
    return 1;
}
/* 1: the current bond is broken. */
static inline int pd_body_bond_is_broken(const pd_bond_iterator *f)
{
    return f->broken[f->number >> 3] >> (f->number & 7) & 1;
}

#ifdef PDI_INTERNAL
/* Describes the broken-bond bits: the only state of a body that checkpoints store. */
PDI_FN void pdi_body_list_state(pdi_array_visitor *owner, void *body);
/* Describes the arrays of points: position, volume, first bond of each family, table of cell fractions. */
PDI_FN void pdi_body_list_points(pdi_array_visitor *owner, void *body);
/* Describes the arrays of families: point_table, stencil_shift, table_index (lattice), bond_image (period). */
PDI_FN void pdi_body_list_families(pdi_array_visitor *owner, void *body);

/* Number of the current bond among all bonds of the body: index of arrays [bonds]. */
static inline int64_t pdi_body_bond_number(const pd_bond_iterator *f) { return f->first + f->number; }

/* Number of periods between the other end of the current bond and the point that it is an image of: the other end is at
 * the position of f->neighbour plus this number times the period. 0 without a period. */
static inline int pdi_body_bond_image(const pd_bond_iterator *f) { return f->image ? f->image[f->number] : 0; }

/* xi = x_j - x_i [m], from point i to point j itself, not to a periodic image. */
static inline void pdi_body_compute_offset(const pd_body *body, int32_t i, int32_t j, double *xi)
{
    const double *from = body->position + (int64_t)i * PD_DIM;
    const double *to = body->position + (int64_t)j * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) xi[d] = to[d] - from[d];
}
/* Reference vector xi [m] of the current bond of point i, to its periodic image where there is one. */
static inline void pdi_body_bond_vector(const pd_body *body, int32_t i, const pd_bond_iterator *f, double *xi)
{
    pdi_body_compute_offset(body, i, f->neighbour, xi);
    if (!f->image) return;
    for (int d = 0; d < PD_DIM; d++) xi[d] += f->image[f->number] * body->period[d];
}
/* Stretch s = (|Y| - r)/r of a bond xi whose ends have the relative displacement eta, all [m]. Out: Y = xi + eta, r =
 * |xi|, length = |Y|. A difference of squares over their sum, so no digits of small displacements are lost. */
static inline double pdi_body_compute_stretch(const double *xi, const double *eta, double *y, double *r, double *length)
{
    double square = 0.0, more = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        y[d] = xi[d] + eta[d];
        square += xi[d] * xi[d];
        more += eta[d] * (xi[d] + y[d]);
    }
    *r = sqrt(square);
    *length = sqrt(square + more);
    return more / (*r * (*length + *r));
}
/* Entries of the table of a lattice of n [PD_DIM] positions whose bonds span at most `steps` spacings along an axis,
 * with the empty margin before the first position. */
PDI_FN double pdi_body_count_table_entries(const double *n, double steps);
/* Weight w [-] of a bond xi [m]: influence function times the volume fraction of the end cell within the horizon.
 * Linear rim: the fraction is 1 up to horizon - spacing/2 and falls to 0 at horizon + spacing/2; exact rim: that of
 * partial_volume.h; without a spacing 1 at any length. 0: no bond. Broken bonds are not looked up. Even in xi, so both
 * ends get the same bits. */
PDI_FN double pdi_body_compute_bond_weight(const pd_body *body, pd_influence influence, const double *xi);
#endif

#endif
