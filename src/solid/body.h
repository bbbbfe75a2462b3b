/* body: material points of a solid and their families.
 *
 * Points are those of a lattice or any others. The family of a point is all points within the horizon: |xi| <= horizon,
 * or with `spacing` all whose cells reach into the horizon, where cells at the rim count with the part that lies within
 * it. A family is sorted by the places of its points, so what is summed over it does not depend on the order of the
 * points. Search: cell lists, O(count).
 *
 * Families are read by walks (pd_walk): a list of shifts leads through a table of points. The table of a lattice has an
 * entry for each of its places, and the list is the family of a whole place: no bond is stored. That of other points
 * has their families, one after another. Bonds have numbers in that order, and a bit each that says whether the bond is
 * broken.
 *
 * A bond may leave the body: across a gap, a notch or a slot its ends are not joined. The faces of its surface tell
 * which bonds leave it, or `joined` which do not. A bond that leaves it is none, and no family has it. Places whose
 * family lacks some have a list of their own, as long as that of a whole place.
 *
 * With a period a family has images of points, too: its own as well, where the period is shorter than the horizon. An
 * image moves as its point does. A family is sorted by images first, and all families are stored.
 */
#ifndef PD_BODY_H
#define PD_BODY_H
#include "core/owner.h"
#include "solid/rim.h"
#include <math.h>

/* How bonds count by their length r. */
typedef enum pd_influence {
    PD_INFLUENCE_CONSTANT = 0, /* 1 */
    PD_INFLUENCE_INVERSE,      /* horizon/r */
    PD_INFLUENCE_LINEAR        /* 1 - r/(horizon + spacing) */
} pd_influence;

/* Which part of a cell at the rim of the horizon counts. */
typedef enum pd_rim {
    PD_RIM_LINEAR = 0, /* by its distance: falls from 1 at horizon - spacing/2 to 0 at horizon + spacing/2 */
    PD_RIM_EXACT       /* the part of the interval, square or cube that lies within the ball */
} pd_rim;

/* 1: the straight line from point i by xi [m], to point j or to an image of it, stays within the body. Asked for one
 * end of a bond alone, that of the lesser coordinate, by several threads. */
typedef int (*pd_joined_fn)(void *user, int32_t i, int32_t j, const double *xi);

typedef struct pd_body_desc {
    int32_t count;
    const double *position; /* [count][PD_DIM] [m] */
    const double *volume;   /* [count] [m^d] */
    double horizon;         /* [m] */
    double spacing;         /* [m] of a lattice: parts of cells at the rim count; 0: points count wholly or not */
    pd_rim rim;             /* of a lattice */
    double period[PD_DIM];  /* [m] by which the points repeat; zero along the last axis: they do not */
    pd_joined_fn joined;    /* NULL: no bond leaves the body but by its faces */
    void *user;
    int64_t faces;          /* of the surface; 0: it is not known */
    const double *face;     /* [faces][PD_DIM][PD_DIM] [m] their corners: points, segments, triangles, such as those of
                             * pd_points. Bonds that cross one leave the body. Not with a period */
} pd_body_desc;

typedef struct pd_body {
    int32_t count;
    int32_t own;       /* points whose energy is that of the body: all, but images behind planes of symmetry, which come
                        * last */
    const int32_t *of;   /* [count - own] borrowed: the point that an image stands for; NULL without images */
    const uint8_t *flip; /* [count - own] borrowed: bit d: it is a reflection along axis d */
    double horizon;    /* [m] */
    double spacing;    /* [m] */
    pd_rim rim;
    double period[PD_DIM]; /* [m] */
    int32_t cells;     /* of a lattice with exact parts: cells an axis whose parts are kept; 0: none */
    double *part;      /* [cells^PD_DIM] [-] parts of cells by their places in the lattice, axis 0 fastest */
    double *position;  /* [count][PD_DIM] [m] */
    double *volume;    /* [count] [m^d] */
    int64_t bonds;     /* of all families: each bond counts twice */
    int64_t *row;      /* [count + 1] number of the first bond of each family */
    int lattice;       /* 1: all points are at places of a lattice, and its table is the shorter one */
    int32_t kinds;     /* bonds of a family of the lattice, of others bonds of the longest one */
    int64_t shifts;    /* entries of shift: kinds, or twice that with lists */
    int32_t *shift;    /* [shifts] from the entry of a point in member to those of its family;
                        * then those of a list */
    int64_t places;    /* entries of the table */
    int64_t charted;   /* of these the places of a lattice */
    int32_t *member;   /* [places] points at the places of a lattice, -1: none, and then lists of points whose families
                        * lack bonds; or families, one after another */
    int32_t *place;    /* [count] of a lattice: entry of each point in member, or of its list */
    int8_t *image;     /* [bonds] of a period: by how many the image at the other end is off its point */
    uint8_t *broken;   /* bits of bonds, whole bytes for each family; 1: it is broken, and both of its ends say so */
} pd_body;

/* A walk through the family of a point, from bond to bond. */
typedef struct pd_walk {
    const int32_t *at;     /* entry of the point in member */
    const int32_t *shift;  /* of the body */
    const uint8_t *broken; /* bits of the family */
    const int8_t *image;   /* of its bonds; NULL without a period */
    int64_t first;         /* number of its first bond */
    int32_t bonds;         /* how many it has */
    int32_t n;             /* the bond that the walk is at: bond n of the family */
    int32_t kind;          /* its shift */
    int32_t to;            /* the point at its other end */
} pd_walk;

#define pd_body_build PD_NAME(pd_body_build)
#define pd_body_free PD_NAME(pd_body_free)
#define pd_body_family PD_NAME(pd_body_family)
#define pd_body_break PD_NAME(pd_body_break)

/* PD_ERR_ARGUMENT: no point, a horizon that is not positive, a place, a face or a volume that is not finite or not
 * positive, faces with a period, a period within which the points do not lie, or of less than a hundredth of the
 * horizon. PD_ERR_GEOMETRY: two points at one place (the message names both). */
PD_API pd_status pd_body_build(pd_ctx *ctx, const pd_body_desc *desc, pd_body *body);
PD_API void pd_body_free(pd_ctx *ctx, pd_body *body);
/* The points that point i has bonds with, into to, and which of these bonds are broken, into broken; both
 * [row[i + 1] - row[i]], or NULL. A point stands there once for each of its images. Returns how many there are. */
PD_API int32_t pd_body_family(const pd_body *body, int32_t i, int32_t *to, uint8_t *broken);
/* Break the bond of two points, at both ends; bonds of their images stay. 1: it was intact; 0: it was broken, or there
 * is none. */
PD_API int pd_body_break(pd_body *body, int32_t i, int32_t j);

#ifdef PDI_INTERNAL
PDI_FN void pdi_body_list(pdi_owner *owner, void *body);
PDI_FN void pdi_body_row_list(pdi_owner *owner, void *body);
PDI_FN void pdi_body_table_list(pdi_owner *owner, void *body);

/* 1: the points of the body repeat. */
static inline int pdi_body_repeats(const pd_body *body) { return body->period[PD_DIM - 1] > 0.0; }
/* A walk that stands before the first bond of point i:
 *
 *     for (pd_walk f = pdi_walk_from(body, i); pdi_walk_next(&f);) ... f.to ...
 */
static inline pd_walk pdi_walk_from(const pd_body *body, int32_t i)
{
    pd_walk f;
    f.first = body->row[i];
    f.bonds = (int32_t)(body->row[i + 1] - f.first);
    f.at = body->member + (body->lattice ? (int64_t)body->place[i] : f.first);
    f.shift = body->lattice && body->place[i] >= body->charted ? body->shift + body->kinds : body->shift;
    f.broken = body->broken + ((f.first + 7 * (int64_t)i) >> 3); /* each family begins in a byte of its own */
    f.image = pdi_body_repeats(body) ? body->image + f.first : NULL;
    f.n = f.kind = f.to = -1;
    return f;
}
/* On to the next bond. 0: there is none. */
static inline int pdi_walk_next(pd_walk *f)
{
    if (++f->n == f->bonds) return 0;
    do f->to = f->at[f->shift[++f->kind]];
    while (f->to < 0);
    return 1;
}
/* The number of the bond. */
static inline int64_t pdi_walk_bond(const pd_walk *f) { return f->first + f->n; }
/* 1: it is broken. */
static inline int pdi_walk_broken(const pd_walk *f) { return f->broken[f->n >> 3] >> (f->n & 7) & 1; }

/* By how many the image at its other end is off its point. */
static inline int pdi_walk_image(const pd_walk *f) { return f->image ? f->image[f->n] : 0; }

/* Point j less point i [m]. */
static inline void pdi_body_bond(const pd_body *body, int32_t i, int32_t j, double *xi)
{
    const double *from = body->position + (int64_t)i * PD_DIM;
    const double *to = body->position + (int64_t)j * PD_DIM;
    for (int d = 0; d < PD_DIM; d++) xi[d] = to[d] - from[d];
}
/* The other end of a bond of point i less that point [m]. */
static inline void pdi_walk_vector(const pd_body *body, int32_t i, const pd_walk *f, double *xi)
{
    pdi_body_bond(body, i, f->to, xi);
    if (!f->image) return;
    for (int d = 0; d < PD_DIM; d++) xi[d] += f->image[f->n] * body->period[d];
}
/* Stretch of a bond xi whose ends move apart by eta; Y, r and |Y| [m]. It is a difference of squares over their sum,
 * which has the digits of the displacements. */
static inline double pdi_body_strain(const double *xi, const double *eta, double *y, double *r, double *length)
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
/* How many bonds point i has that are not broken. */
PDI_FN int64_t pdi_body_intact(const pd_body *body, int32_t i);
/* Break all bonds of point i, at both ends. How many. */
PDI_FN int64_t pdi_body_release(pd_body *body, int32_t i);
/* Bond n of point i is broken, as this end of it says; the other end has to say so, too. */
PDI_FN void pdi_body_mark(pd_body *body, int32_t i, int32_t n);
/* Which bond of the point at the other end of a bond of point i is the same bond. */
PDI_FN int32_t pdi_walk_back(const pd_body *body, int32_t i, const pd_walk *f);
/* Break a bond of point i, at both ends. 1: it was intact. */
PDI_FN int pdi_walk_break(pd_body *body, int32_t i, const pd_walk *f);
/* Which bond of point j leads to point i, not to an image of it; -1: none. */
PDI_FN int32_t pdi_body_back(const pd_body *body, int32_t i, int32_t j);
/* 1: no bond is broken. */
PDI_FN int pdi_body_whole(const pd_body *body);
/* Entries of the table of a lattice of n[PD_DIM] places whose bonds take so many steps along an axis; those before the
 * first place, too. */
PDI_FN double pdi_body_places(const double *n, double steps);
/* felt [count]: 1: the family of a point that is no image, or of one that has a bond with such a point; 0 before the
 * call. Forces of points that are no images depend on these families alone. */
PDI_FN void pdi_body_felt(const pd_body *body, uint8_t *felt);
/* The points that bonds join to point i, into piece[0 ..] [count]; seen [count] marks them. Returns how many. */
PDI_FN int32_t pdi_body_piece(const pd_body *body, int32_t i, uint8_t *seen, int32_t *piece);
/* Weight of the bond xi [m]: its influence times the part of the cell at its end that lies within the horizon; 0: it is
 * none. Both ends get the same bits. */
PDI_FN double pdi_body_weight(const pd_body *body, pd_influence influence, const double *xi);
#endif

#endif
