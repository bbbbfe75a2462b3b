/* body: see body.h */
#include "solid/body.h"
#include "core/par.h"
#include "solid/visibility.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rounding of distances over the horizon: lattice points at a distance of exactly the horizon belong to the family. */
#define PDI_BODY_ROUNDING 1e-9
/* Smallest period over the horizon and a cell: image numbers are stored in one byte. */
#define PDI_BODY_MIN_PERIOD 0.01
/* Exact cell fractions are tabulated for horizons of fewer spacings than this. */
#define PDI_BODY_MAX_TABLE_SPACINGS 30

/* Cell list of the neighbour search: cells at least as wide as the longest bond, and at most as many as points. */
typedef struct pdi_body_cell_list {
    int32_t n[PD_DIM];
    double lo[PD_DIM], width[PD_DIM];
    int32_t count;
    int32_t *first; /* [count + 1] begin of each cell in point */
    int32_t *point; /* [points] */
    int32_t *rank_of_point, *point_of_rank; /* [points] rank in the order of coordinates, and the point of a rank */
} pdi_body_cell_list;

/* A point with its position, for the sort by coordinates. */
typedef struct pdi_body_sort_entry {
    double x[PD_DIM];
    int32_t point;
} pdi_body_sort_entry;

/* qsort order by position, last axis first; 0: same position. */
static int pdi_body_compare_positions(const void *a, const void *b)
{
    const pdi_body_sort_entry *p = (const pdi_body_sort_entry *)a, *q = (const pdi_body_sort_entry *)b;
    for (int d = PD_DIM - 1; d >= 0; d--)
        if (p->x[d] < q->x[d] || p->x[d] > q->x[d]) return p->x[d] < q->x[d] ? -1 : 1;
    return 0;
}

PDI_FN void pdi_body_list_points(pdi_array_visitor *owner, void *object)
{
    pd_body *body = (pd_body *)object;
    PDI_ARRAY(owner, body, position, (int64_t)body->count * PD_DIM, "m");
    PDI_ARRAY(owner, body, volume, body->count, "m^d");
    PDI_ARRAY(owner, body, first_bond, body->count ? body->count + 1 : 0, "1");
    int64_t parts = 1;
    for (int d = 0; d < PD_DIM; d++) parts *= body->fraction_cells;
    PDI_ARRAY(owner, body, cell_fraction, parts, "1");
}

PDI_FN void pdi_body_list_families(pdi_array_visitor *owner, void *object)
{
    pd_body *body = (pd_body *)object;
    PDI_ARRAY(owner, body, point_table, body->table_entries, "1");
    PDI_ARRAY(owner, body, stencil_shift, body->shifts, "1");
    PDI_ARRAY(owner, body, table_index, body->lattice ? body->count : 0, "1");
    PDI_ARRAY(owner, body, bond_image, pd_body_is_periodic(body) ? body->bonds : 0, "1");
}

/* Bytes of the broken-bond bits of all families. */
static int64_t pdi_body_count_bytes(const pd_body *body) { return (body->bonds + 7 * (int64_t)body->count) / 8; }

PDI_FN void pdi_body_list_state(pdi_array_visitor *owner, void *object)
{
    pd_body *body = (pd_body *)object;
    PDI_ARRAY_STATE(owner, body, broken, pdi_body_count_bytes(body), "1");
}

/* Frees a cell list of a body of `points` points. */
static void pdi_body_free_cell_list(pd_ctx *ctx, int32_t points, pdi_body_cell_list *c)
{
    PD_DELETE(ctx, c->count + 1, c->first);
    PD_DELETE(ctx, points, c->point);
    PD_DELETE(ctx, points, c->rank_of_point);
    PD_DELETE(ctx, points, c->point_of_rank);
}

/* Upper bound of the bond length [m]: horizon + sqrt(d)/2 spacing with an exact rim, horizon + spacing/2 with a linear
 * one, and the horizon plus rounding without a spacing. */
static double pdi_body_max_bond_length(const pd_body *body)
{
    if (body->rim == PD_PARTIAL_VOLUME_EXACT) return body->horizon + 0.5 * sqrt((double)PD_DIM) * body->spacing;
    return body->spacing > 0.0 ? body->horizon + 0.5 * body->spacing : body->horizon * (1.0 + PDI_BODY_ROUNDING);
}

/* Number of the cell that holds position x; its index along the axes into index [PD_DIM], unless that is NULL. A
 * position outside of the grid gets the nearest cell along each axis. */
static int32_t pdi_body_find_cell(const pdi_body_cell_list *c, const double *x, int32_t *index)
{
    int32_t cell = 0;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        double at = (x[d] - c->lo[d]) / c->width[d];
        int32_t i = at < 0.0 ? 0 : at < c->n[d] ? (int32_t)at : c->n[d] - 1;
        if (index) index[d] = i;
        cell = cell * c->n[d] + i;
    }
    return cell;
}

/* Sets lo, n, width and count of the cell list from the bounding box of the points. Cells are at least a bond length
 * wide; the width grows by factors of 1.5 until there are at most body->count cells. An axis shorter than that has one
 * cell. */
static void pdi_body_init_cell_grid(const pd_body *body, pdi_body_cell_list *c)
{
    double size[PD_DIM], reach = pdi_body_max_bond_length(body);
    for (int d = 0; d < PD_DIM; d++) {
        double lo = HUGE_VAL, hi = -HUGE_VAL;
        for (int32_t i = 0; i < body->count; i++) {
            lo = pd_min(lo, body->position[(int64_t)i * PD_DIM + d]);
            hi = pd_max(hi, body->position[(int64_t)i * PD_DIM + d]);
        }
        c->lo[d] = lo;
        size[d] = hi - lo;
    }
    for (double cells = HUGE_VAL, wide = reach; cells > (double)body->count; wide *= 1.5) {
        cells = 1.0;
        for (int d = 0; d < PD_DIM; d++) cells *= pd_max(floor(size[d] / wide), 1.0);
        for (int d = 0; d < PD_DIM && cells <= (double)body->count; d++) {
            c->n[d] = (int32_t)pd_max(floor(size[d] / wide), 1.0);
            c->width[d] = pd_max(size[d] / c->n[d], reach);
        }
    }
    c->count = 1;
    for (int d = 0; d < PD_DIM; d++) c->count *= c->n[d];
}

/* Ranks all points by position, into rank_of_point and point_of_rank. PD_ERR_GEOMETRY: two points at the same
 * position. */
static pd_status pdi_body_sort_points(pd_ctx *ctx, const pd_body *body, pdi_body_cell_list *c)
{
    pdi_body_sort_entry *place = NULL;
    PD_TRY(PD_NEW(ctx, "body", body->count, place));
    for (int32_t i = 0; i < body->count; i++) {
        place[i].point = i;
        memcpy(place[i].x, body->position + (int64_t)i * PD_DIM, sizeof place[i].x);
    }
    qsort(place, (size_t)body->count, sizeof *place, pdi_body_compare_positions);
    int32_t twin = -1;
    for (int32_t k = 0; k < body->count; k++) {
        c->point_of_rank[k] = place[k].point;
        c->rank_of_point[place[k].point] = k;
        if (k && pdi_body_compare_positions(&place[k - 1], &place[k]) == 0) twin = k;
    }
    PD_DELETE(ctx, body->count, place);
    if (twin < 0) return PD_OK;
    return pd_fail(ctx, PD_ERR_GEOMETRY, "body", "points %d and %d are at one place", (int)c->point_of_rank[twin - 1],
                   (int)c->point_of_rank[twin]);
}

/* Allocates and fills the arrays of a cell list whose grid is set; points of a cell stand by rank. PD_ERR_GEOMETRY: two
 * points at one position. The caller frees, after an error too. */
static pd_status pdi_body_build_cell_list(pd_ctx *ctx, const pd_body *body, pdi_body_cell_list *c)
{
    PD_TRY(PD_NEW(ctx, "body", c->count + 1, c->first));
    PD_TRY(PD_NEW(ctx, "body", body->count, c->point));
    PD_TRY(PD_NEW(ctx, "body", body->count, c->rank_of_point));
    PD_TRY(PD_NEW(ctx, "body", body->count, c->point_of_rank));
    PD_TRY(pdi_body_sort_points(ctx, body, c));
    for (int32_t i = 0; i < body->count; i++)
        c->first[pdi_body_find_cell(c, body->position + (int64_t)i * PD_DIM, NULL) + 1]++;
    for (int32_t k = 0; k < c->count; k++) c->first[k + 1] += c->first[k];
    for (int32_t k = body->count - 1; k >= 0; k--) { /* by rank within a cell */
        int32_t i = c->point_of_rank[k];
        int32_t cell = pdi_body_find_cell(c, body->position + (int64_t)i * PD_DIM, NULL);
        c->point[--c->first[cell + 1]] = i;
    }
    for (int32_t k = 0; k < c->count; k++) c->first[k] = c->first[k + 1];
    c->first[c->count] = body->count;
    return PD_OK;
}

/* 1: a point at xi [m] with |xi|^2 = square [m2] belongs to the family: with an exact rim its cell intersects the ball
 * by more than rounding, with a linear one its distance is < reach, without a spacing <= reach. reach [m]:
 * pdi_body_max_bond_length. */
static int pdi_body_is_in_family(const pd_body *body, const double *xi, double square, double reach)
{
    if (square > reach * reach) return 0;
    if (body->rim == PD_PARTIAL_VOLUME_EXACT) return pdi_partial_volume_is_inside(xi, body->spacing, body->horizon);
    return !(body->spacing > 0.0) || sqrt(square) < reach;
}

/* Neighbours of point i among the images number `image` of all points (0: the points themselves, without i), as ranks,
 * unsorted, into `to` unless it is NULL. An image of i itself counts. Searches the 3^d cells around. Returns how
 * many. */
static int32_t pdi_body_find_family(const pd_body *body, const pdi_body_cell_list *c, int32_t i, int image, int32_t *to)
{
    const double *x = body->position + (int64_t)i * PD_DIM;
    double reach = pdi_body_max_bond_length(body), seen[PD_DIM];
    int32_t own[PD_DIM], found = 0, around = 1;
    for (int d = 0; d < PD_DIM; d++) seen[d] = x[d] - image * body->period[d];
    pdi_body_find_cell(c, seen, own);
    for (int d = 0; d < PD_DIM; d++) around *= 3;
    for (int32_t k = 0; k < around; k++) {
        int32_t cell = 0, stride = 1, inside = 1;
        for (int32_t d = 0, rest = k; d < PD_DIM; stride *= c->n[d++], rest /= 3) {
            int32_t at = own[d] + rest % 3 - 1;
            inside = inside && at >= 0 && at < c->n[d];
            cell += at * stride;
        }
        if (!inside) continue;
        for (int32_t p = c->first[cell]; p < c->first[cell + 1]; p++) {
            int32_t j = c->point[p];
            double xi[PD_DIM], square = 0.0;
            for (int d = 0; d < PD_DIM; d++) {
                xi[d] = body->position[(int64_t)j * PD_DIM + d] - x[d] + image * body->period[d];
                square += xi[d] * xi[d];
            }
            if ((j == i && !image) || !pdi_body_is_in_family(body, xi, square, reach)) continue;
            if (to) to[found] = c->rank_of_point[j];
            found++;
        }
    }
    return found;
}

/* qsort order of ranks. */
static int pdi_body_compare_ranks(const void *a, const void *b)
{
    int32_t p = *(const int32_t *)a, q = *(const int32_t *)b;
    return (p > q) - (p < q);
}

/* Largest image number that bonds may lead to, on either side; 0 without a period. */
static int pdi_body_max_image(const pd_body *body)
{
    return pd_body_is_periodic(body) ? (int)(pdi_body_max_bond_length(body) / body->period[PD_DIM - 1]) + 1 : 0;
}

/* Stores the family of point i in point_table and bond_image from bond first_bond[i] on: sorted by image number, then
 * by position. */
static void pdi_body_store_family(pd_body *body, const pdi_body_cell_list *c, int32_t i)
{
    int64_t begin = body->first_bond[i];
    int most = pdi_body_max_image(body);
    for (int image = -most; image <= most; image++) {
        int32_t *family = body->point_table + begin;
        size_t length = (size_t)pdi_body_find_family(body, c, i, image, family);
        qsort(family, length, sizeof *family, pdi_body_compare_ranks);
        for (size_t k = 0; k < length; k++) family[k] = c->point_of_rank[family[k]];
        for (size_t k = 0; k < length && most; k++) body->bond_image[begin + (int64_t)k] = (int8_t)image;
        begin += (int64_t)length;
    }
}

/* Turns family sizes in first_bond[i + 1] into the number of the first bond of each family; sets bonds. Returns the
 * largest size. */
static int32_t pdi_body_number_bonds(pd_body *body)
{
    int64_t longest = 0;
    body->first_bond[0] = 0;
    for (int32_t i = 0; i < body->count; i++) {
        if (body->first_bond[i + 1] > longest) longest = body->first_bond[i + 1];
        body->first_bond[i + 1] += body->first_bond[i];
    }
    body->bonds = body->first_bond[body->count];
    return (int32_t)longest;
}

/* Families of a body that is no lattice, or has a period: finds them from the cell list, allocates and fills the arrays
 * of families, and sets first_bond, bonds and the counts of these arrays. */
static pd_status pdi_body_build_families(pd_ctx *ctx, pd_body *body, const pdi_body_cell_list *c)
{
    int most = pdi_body_max_image(body);
    int nt = pd_par_threads(ctx, (int64_t)body->count * 1000);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        body->first_bond[i + 1] = 0;
        for (int image = -most; image <= most; image++)
            body->first_bond[i + 1] += pdi_body_find_family(body, c, i, image, NULL);
    }
    body->shifts = body->stencil_bonds = pdi_body_number_bonds(body);
    body->table_entries = body->lattice_entries = body->bonds;
    PD_TRY(pdi_array_registry_build(ctx, pdi_body_list_families, body));
    for (int32_t k = 0; k < body->stencil_bonds; k++) body->stencil_shift[k] = k;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) pdi_body_store_family(body, c, i);
    return PD_OK;
}

/* Coordinates of the points of a lattice along its axes. */
typedef struct pdi_body_lattice_axes {
    int32_t n[PD_DIM];     /* places along each axis */
    int32_t begin[PD_DIM + 1]; /* of each axis in x */
    double lo[PD_DIM];     /* [m] */
    int32_t steps;         /* of a bond along an axis, at most */
    int64_t margin;        /* entries before the first position */
    int32_t stride[PD_DIM];
    double *x;             /* [begin[PD_DIM]] [m] the coordinate of all points there; HUGE_VAL: there is none */
    double *distance_range; /* [PD_DIM][steps + 1][2] [m] least and largest distance of so many steps; largest < 0:
                             * none */
} pdi_body_lattice_axes;

/* Describes the arrays of lattice axes. */
static void pdi_body_list_lattice_axes(pdi_array_visitor *owner, void *object)
{
    pdi_body_lattice_axes *axes = (pdi_body_lattice_axes *)object;
    PDI_ARRAY(owner, axes, x, axes->begin[PD_DIM], "m");
    PDI_ARRAY(owner, axes, distance_range, axes->begin[PD_DIM] > 0 ? 2 * PD_DIM * (axes->steps + 1) : 0, "m");
}

PDI_FN double pdi_body_count_table_entries(const double *n, double steps)
{
    double stride = 1.0, lead = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        lead += steps * stride;
        stride *= n[d] + steps;
    }
    return lead + stride;
}

/* Lattice box around all points: sets the grid of the axes, and the number of table entries of the body. Returns 1; 0:
 * the table would have more than 2 (2 steps + 1)^d entries per point, or 2e9 of them. */
static int pdi_body_init_lattice_box(pd_body *body, pdi_body_lattice_axes *a)
{
    double n[PD_DIM], most = 1.0;
    double steps = floor(pdi_body_max_bond_length(body) / body->spacing * (1.0 + PDI_BODY_ROUNDING));
    for (int d = 0; d < PD_DIM; d++) {
        double hi = a->lo[d] = body->position[d];
        for (int64_t i = d; i < (int64_t)body->count * PD_DIM; i += PD_DIM) {
            a->lo[d] = pd_min(a->lo[d], body->position[i]);
            hi = pd_max(hi, body->position[i]);
        }
        n[d] = floor((hi - a->lo[d]) / body->spacing + 0.5) + 1.0;
        most *= 2.0 * steps + 1.0;
    }
    double places = pdi_body_count_table_entries(n, steps);
    if (!(places <= 2.0 * most * (double)body->count) || !(places < 2e9)) return 0;
    a->steps = (int32_t)steps;
    body->table_entries = body->lattice_entries = (int64_t)places;
    int64_t stride = 1;
    for (int d = 0; d < PD_DIM; d++) {
        a->n[d] = (int32_t)n[d];
        a->begin[d + 1] = a->begin[d] + a->n[d];
        a->stride[d] = (int32_t)stride;
        a->margin += a->steps * stride;
        stride *= a->n[d] + a->steps;
    }
    return 1;
}

/* Finds the coordinates that all points share along each axis, into x, and the range of distances between points `s`
 * steps apart, into distance_range. Returns 1; 0: a point is off the lattice by more than 1e-9 spacings, or two points
 * of one lattice plane differ in its coordinate by any bit. */
static int pdi_body_try_coordinates(const pd_body *body, const pdi_body_lattice_axes *a)
{
    for (int32_t k = 0; k < a->begin[PD_DIM]; k++) a->x[k] = HUGE_VAL;
    for (int32_t i = 0; i < body->count; i++)
        for (int d = 0; d < PD_DIM; d++) {
            double x = body->position[(int64_t)i * PD_DIM + d], at = (x - a->lo[d]) / body->spacing;
            double *known = a->x + a->begin[d] + (int32_t)floor(at + 0.5);
            if (!(fabs(at - floor(at + 0.5)) <= PDI_BODY_ROUNDING)) return 0;
            if (!(*known < HUGE_VAL)) *known = x;
            if (x < *known || x > *known) return 0;
        }
    for (int d = 0; d < PD_DIM; d++)
        for (int32_t s = 0; s <= a->steps; s++) {
            double *span = a->distance_range + 2 * (d * (a->steps + 1) + s);
            span[0] = HUGE_VAL;
            span[1] = -1.0;
            for (int32_t k = a->begin[d]; k + s < a->begin[d + 1]; k++) {
                if (!(a->x[k] < HUGE_VAL) || !(a->x[k + s] < HUGE_VAL)) continue;
                span[0] = pd_min(span[0], a->x[k + s] - a->x[k]);
                span[1] = pd_max(span[1], a->x[k + s] - a->x[k]);
            }
        }
    return 1;
}

/* 1: lattice offset number k (axis 0 fastest) is in the family, by its least and largest length; 0: it is not, it is
 * zero, or no points are so far apart; -1: the two lengths disagree. *shift: distance of table entries over this
 * offset. */
static int pdi_body_is_step_in_family(const pd_body *body, const pdi_body_lattice_axes *a, int64_t k, int64_t *shift)
{
    int wide = 2 * a->steps + 1, belongs[2];
    double xi[2][PD_DIM], reach = pdi_body_max_bond_length(body), most = 0.0;
    *shift = 0;
    for (int d = 0; d < PD_DIM; d++, k /= wide) {
        int32_t step = (int32_t)(k % wide) - a->steps, size = step < 0 ? -step : step;
        const double *span = a->distance_range + 2 * (d * (a->steps + 1) + size);
        if (span[1] < 0.0) return 0;
        *shift += (int64_t)step * a->stride[d];
        xi[0][d] = span[0];
        xi[1][d] = span[1];
        most += span[1];
    }
    if (!(most > 0.0)) return 0;
    for (int e = 0; e < 2; e++) {
        double square = 0.0;
        for (int d = 0; d < PD_DIM; d++) square += xi[e][d] * xi[e][d];
        belongs[e] = pdi_body_is_in_family(body, xi[e], square, reach);
    }
    return belongs[0] == belongs[1] ? belongs[0] : -1;
}

/* Table shifts of a complete family in order, into `to` unless it is NULL. Returns how many; -1: rounding of positions
 * decides on one of them. */
static int32_t pdi_body_find_stencil(const pd_body *body, const pdi_body_lattice_axes *a, int32_t *to)
{
    int64_t all = 1, shift;
    int32_t found = 0;
    for (int d = 0; d < PD_DIM; d++) all *= 2 * a->steps + 1;
    for (int64_t k = 0; k < all; k++) {
        int belongs = pdi_body_is_step_in_family(body, a, k, &shift);
        if (belongs < 0) return -1;
        if (belongs && to) to[found] = (int32_t)shift;
        found += belongs;
    }
    return found;
}

/* Fills stencil_shift, point_table and table_index of a lattice and numbers the bonds; first_bond is overwritten.
 * Returns 1; 0: two points at one lattice position, or entries of the table plus points exceed twice the number of
 * bonds: then stored families take less memory. */
static int pdi_body_build_lattice_table(const pd_ctx *ctx, pd_body *body, const pdi_body_lattice_axes *a)
{
    int nt = pd_par_threads(ctx, (int64_t)body->count * body->stencil_bonds);
    (void)nt;
    pdi_body_find_stencil(body, a, body->stencil_shift);
    for (int64_t k = 0; k < body->table_entries; k++) body->point_table[k] = -1;
    for (int32_t i = 0; i < body->count; i++) {
        int64_t place = a->margin;
        for (int d = 0; d < PD_DIM; d++) {
            double at = (body->position[(int64_t)i * PD_DIM + d] - a->lo[d]) / body->spacing;
            place += (int64_t)floor(at + 0.5) * a->stride[d];
        }
        if (body->point_table[place] >= 0) return 0;
        body->point_table[place] = i;
        body->table_index[i] = (int32_t)place;
    }
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++) {
        const int32_t *at = body->point_table + body->table_index[i];
        int32_t found = 0;
        for (int32_t k = 0; k < body->stencil_bonds; k++) found += at[body->stencil_shift[k]] >= 0;
        body->first_bond[i + 1] = found;
    }
    pdi_body_number_bonds(body);
    return body->table_entries + body->count <= 2 * body->bonds;
}

/* Families by a shared stencil: allocates the arrays of families and sets lattice to 1. It stays 0, with PD_OK and
 * nothing allocated, without a spacing, with a period, where a point is off the lattice, where rounding decides on a
 * member of the stencil, where two points share a position, or where the table is too large. Families equal those of
 * the cell list. */
static pd_status pdi_body_build_lattice_families(pd_ctx *ctx, pd_body *body)
{
    pdi_body_lattice_axes axes;
    memset(&axes, 0, sizeof axes);
    if (!(body->spacing > 0.0) || pd_body_is_periodic(body) || !pdi_body_init_lattice_box(body, &axes)) return PD_OK;
    pd_status status = pdi_array_registry_build(ctx, pdi_body_list_lattice_axes, &axes);
    int32_t kinds = 0;
    if (status == PD_OK && pdi_body_try_coordinates(body, &axes)) kinds = pdi_body_find_stencil(body, &axes, NULL);
    if (kinds > 0) {
        body->shifts = body->stencil_bonds = kinds;
        body->lattice = 1;
        status = pdi_array_registry_build(ctx, pdi_body_list_families, body);
        if (status == PD_OK && !pdi_body_build_lattice_table(ctx, body, &axes)) {
            pdi_array_registry_free(ctx, pdi_body_list_families, body);
            body->lattice = 0;
        }
    }
    pdi_array_registry_free(ctx, pdi_body_list_lattice_axes, &axes);
    return status;
}

/* 1: the line of the bond stays within the body. Both ends ask for the same line, so they agree. */
static int pdi_body_is_joined(const pd_body *body, const pd_body_desc *desc, int32_t i, const pd_bond_iterator *f)
{
    double xi[PD_DIM];
    int first = 0;
    pdi_body_bond_vector(body, i, f, xi);
    for (int d = 0; d < PD_DIM && !first; d++) first = xi[d] > 0.0 ? 1 : xi[d] < 0.0 ? -1 : 0;
    if (first > 0) return desc->joined(desc->user, i, f->neighbour, xi);
    for (int d = 0; d < PD_DIM; d++) xi[d] = -xi[d];
    return desc->joined(desc->user, f->neighbour, i, xi);
}

/* Sets lost [bonds] to 1 for bonds that leave the body; set entries stay. Returns how many are set. */
static int64_t pdi_body_mark_leaving_bonds(const pd_ctx *ctx, const pd_body *body, const pd_body_desc *desc,
                                           uint8_t *lost)
{
    int64_t all = 0;
    int nt = pd_par_threads(ctx, body->bonds * 20);
    (void)nt;
    PD_PARALLEL_FOR(nt)
    for (int32_t i = 0; i < body->count; i++)
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            if (!lost[pdi_body_bond_number(&f)])
                lost[pdi_body_bond_number(&f)] = (uint8_t)!pdi_body_is_joined(body, desc, i, &f);
    for (int64_t k = 0; k < body->bonds; k++) all += lost[k];
    return all;
}

/* Number of bonds of point i that do not leave the body. */
static int64_t pdi_body_count_left(const pd_body *body, const uint8_t *lost, int32_t i)
{
    int64_t left = body->first_bond[i + 1] - body->first_bond[i];
    for (int64_t k = body->first_bond[i]; k < body->first_bond[i + 1]; k++) left -= lost[k];
    return left;
}

/* Sets first_bond and bonds to the bond numbers without the lost [bonds] ones. */
static void pdi_body_renumber_bonds(pd_body *body, const uint8_t *lost)
{
    int64_t begin = 0;
    for (int32_t i = 0; i < body->count; i++) {
        int64_t left = pdi_body_count_left(body, lost, i);
        body->first_bond[i] = begin;
        begin += left;
    }
    body->first_bond[body->count] = body->bonds = begin;
}

/* Lattice: points whose families lose bonds get lists of their own behind the lattice entries of point_table, as long
 * as the stencil, -1 where there is no bond; sets table_index; arrays grow. first_bond stays: pdi_body_renumber_bonds
 * has to follow. PD_ERR_SIZE: the table would have INT32_MAX entries; nothing has changed then. */
static pd_status pdi_body_store_incomplete_families(pd_ctx *ctx, pd_body *body, const uint8_t *lost)
{
    int64_t lists = 0, room = body->table_entries;
    for (int32_t i = 0; i < body->count; i++)
        lists += pdi_body_count_left(body, lost, i) < body->first_bond[i + 1] - body->first_bond[i];
    room += lists * body->stencil_bonds;
    if (room >= INT32_MAX)
        return pd_fail(ctx, PD_ERR_SIZE, "body",
                       "%g families of %d bonds have lists of their own, too many: use a "
                       "shorter horizon",
                       (double)lists, (int)body->stencil_bonds);
    PD_TRY(PD_GROW(ctx, "body", body->table_entries, room, body->point_table));
    body->table_entries = room;
    PD_TRY(PD_GROW(ctx, "body", body->shifts, 2 * (int64_t)body->stencil_bonds, body->stencil_shift));
    body->shifts = 2 * (int64_t)body->stencil_bonds;
    for (int32_t k = 0; k < body->stencil_bonds; k++) body->stencil_shift[body->stencil_bonds + k] = k;
    int64_t list = body->lattice_entries;
    for (int32_t i = 0; i < body->count; i++) {
        if (pdi_body_count_left(body, lost, i) == body->first_bond[i + 1] - body->first_bond[i]) continue;
        for (int32_t k = 0; k < body->stencil_bonds; k++) body->point_table[list + k] = -1;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
            if (!lost[pdi_body_bond_number(&f)]) body->point_table[list + f.stencil_position] = f.neighbour;
        body->table_index[i] = (int32_t)list;
        list += body->stencil_bonds;
    }
    return PD_OK;
}

/* No lattice: removes the bonds that `lost` [bonds] marks from the stored families, and shortens the arrays;
 * stencil_bonds becomes the size of the longest family left. first_bond stays: pdi_body_renumber_bonds has to
 * follow. */
static pd_status pdi_body_remove_lost_bonds(pd_ctx *ctx, pd_body *body, const uint8_t *lost)
{
    int64_t left = 0, longest = 0, bonds = body->bonds;
    for (int32_t i = 0; i < body->count; i++) {
        int64_t begin = left;
        for (int64_t k = body->first_bond[i]; k < body->first_bond[i + 1]; k++) {
            if (lost[k]) continue;
            body->point_table[left] = body->point_table[k];
            if (pd_body_is_periodic(body)) body->bond_image[left] = body->bond_image[k];
            left++;
        }
        longest = left - begin > longest ? left - begin : longest;
    }
    PD_TRY(PD_GROW(ctx, "body", bonds, left, body->point_table));
    body->table_entries = body->lattice_entries = left;
    PD_TRY(PD_GROW(ctx, "body", body->shifts, longest, body->stencil_shift));
    body->shifts = body->stencil_bonds = (int32_t)longest;
    return pd_body_is_periodic(body) ? PD_GROW(ctx, "body", bonds, left, body->bond_image) : PD_OK;
}

/* As pdi_body_mark_leaving_bonds, by the faces of the surface instead of desc->joined (visibility criterion). *count:
 * how many entries of lost are set. */
static pd_status pdi_body_mark_crossing_bonds(pd_ctx *ctx, const pd_body *body, const pd_body_desc *desc, uint8_t *lost,
                                              int64_t *count)
{
    pdi_visibility visibility;
    pd_body_desc by = *desc;
    memset(&visibility, 0, sizeof visibility);
    visibility.position = body->position;
    visibility.face = desc->face;
    visibility.faces = desc->faces;
    by.joined = pdi_visibility_is_joined;
    by.user = &visibility;
    pd_status status = pdi_visibility_build(ctx, pdi_body_max_bond_length(body), &visibility);
    if (status == PD_OK) *count = pdi_body_mark_leaving_bonds(ctx, body, &by, lost);
    pdi_visibility_free(ctx, &visibility);
    return status;
}

/* Removes all bonds that leave the body, by faces and by desc->joined, and renumbers the others. Nothing changes
 * without faces and callback. */
static pd_status pdi_body_remove_leaving_bonds(pd_ctx *ctx, pd_body *body, const pd_body_desc *desc)
{
    int64_t bonds = body->bonds, count = 0;
    uint8_t *lost = NULL;
    if ((!desc->joined && !desc->faces) || !bonds) return PD_OK;
    PD_TRY(PD_NEW(ctx, "body", bonds, lost));
    pd_status status = desc->faces ? pdi_body_mark_crossing_bonds(ctx, body, desc, lost, &count) : PD_OK;
    if (status == PD_OK && desc->joined) count = pdi_body_mark_leaving_bonds(ctx, body, desc, lost);
    if (status == PD_OK && count) {
        status = body->lattice ? pdi_body_store_incomplete_families(ctx, body, lost)
                               : pdi_body_remove_lost_bonds(ctx, body, lost);
        if (status == PD_OK) pdi_body_renumber_bonds(body, lost);
    }
    PD_DELETE(ctx, bonds, lost);
    return status;
}

/* Fills cell_fraction with the exact volume fractions of cells within the horizon, by their non-negative lattice
 * offsets. */
static void pdi_body_tabulate_fractions(pd_body *body)
{
    int64_t all = 1;
    for (int d = 0; d < PD_DIM; d++) all *= body->fraction_cells;
    for (int64_t k = 0; k < all; k++) {
        double xi[PD_DIM];
        int64_t rest = k;
        for (int d = 0; d < PD_DIM; d++, rest /= body->fraction_cells)
            xi[d] = (double)(rest % body->fraction_cells) * body->spacing;
        body->cell_fraction[k] = pdi_partial_volume_compute_fraction(xi, body->spacing, body->horizon);
    }
}

/* Volume fraction of the cell at xi within the horizon, for an exact rim: from the table where xi is a lattice offset
 * within 1e-9 spacings that the table holds, otherwise computed. */
static double pdi_body_cell_fraction(const pd_body *body, const double *xi)
{
    int64_t place = 0;
    for (int d = PD_DIM - 1; d >= 0; d--) {
        double at = fabs(xi[d]) / body->spacing, near = floor(at + 0.5);
        if (!(fabs(at - near) < PDI_BODY_ROUNDING) || !(near < (double)body->fraction_cells))
            return pdi_partial_volume_compute_fraction(xi, body->spacing, body->horizon);
        place = place * body->fraction_cells + (int64_t)near;
    }
    return body->cell_fraction[place];
}

PDI_FN double pdi_body_compute_bond_weight(const pd_body *body, pd_influence influence, const double *xi)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) square += xi[d] * xi[d];
    double r = sqrt(square), inside = body->horizon + 0.5 * body->spacing - r;
    double part = body->spacing > 0.0 && inside < body->spacing ? inside / body->spacing : 1.0;
    if (body->rim == PD_PARTIAL_VOLUME_EXACT) part = pdi_body_cell_fraction(body, xi);
    else if (body->spacing > 0.0 && !(inside > 0.0)) return 0.0;
    if (influence == PD_INFLUENCE_INVERSE) return part * body->horizon / r;
    if (influence == PD_INFLUENCE_LINEAR) return part * (1.0 - r / (body->horizon + body->spacing));
    return part;
}

/* PD_ERR_ARGUMENT: the points do not lie within one period along the last axis, so that a point could meet an image, or
 * the period is too short. Without a period it is PD_OK. */
static pd_status pdi_body_check_period(pd_ctx *ctx, const pd_body_desc *desc)
{
    double lo = HUGE_VAL, hi = -HUGE_VAL, least = PDI_BODY_MIN_PERIOD * (desc->horizon + desc->spacing);
    double length = desc->period[PD_DIM - 1], most = 0.0;
    for (int d = 0; d < PD_DIM; d++) most = pd_max(most, fabs(desc->period[d]));
    if (!(most > 0.0)) return PD_OK;
    for (int64_t i = 0; i < desc->count; i++) {
        lo = pd_min(lo, desc->position[i * PD_DIM + PD_DIM - 1]);
        hi = pd_max(hi, desc->position[i * PD_DIM + PD_DIM - 1]);
    }
    int apart = hi - lo < length * (1.0 - PDI_BODY_ROUNDING);
    if (apart && length >= least && most < 1e100) return PD_OK;
    return pd_fail(ctx, PD_ERR_ARGUMENT, "body", "points that repeat after %g m along the last axis, expected a finite"
                   " length of more than the %g m of the points and at least %g m", length, hi - lo, least);
}

/* PD_ERR_ARGUMENT: a value of the description is out of range, as of pd_body_build; corners of faces are not checked
 * for being finite. */
static pd_status pdi_body_check(pd_ctx *ctx, const pd_body_desc *desc)
{
    if (desc->rim != PD_PARTIAL_VOLUME_LINEAR && (desc->rim != PD_PARTIAL_VOLUME_EXACT || !(desc->spacing > 0.0)))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "body",
                       "rim %d with a spacing of %g m, expected one of pd_partial_volume, and a"
                       " lattice for exact parts", (int)desc->rim, desc->spacing);
    if (desc->count < 1 || !(desc->horizon > 0.0) || !(desc->horizon < 1e100) || !(desc->spacing >= 0.0) ||
        !(desc->spacing <= desc->horizon))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "body",
                       "%d points, horizon %g m, spacing %g m: expected at least one point and a finite horizon of at "
                       "least a spacing", (int)desc->count, desc->horizon, desc->spacing);
    for (int32_t i = 0; i < desc->count; i++) {
        int good = desc->volume[i] > 0.0 && desc->volume[i] < 1e100;
        for (int d = 0; d < PD_DIM; d++) good = good && fabs(desc->position[(int64_t)i * PD_DIM + d]) < 1e100;
        if (!good)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "body", "point %d at x = %g m has the volume %g, expected finite "
                           "places and positive volumes", (int)i, desc->position[(int64_t)i * PD_DIM],
                           desc->volume[i]);
    }
    if (desc->faces < 0 || (desc->faces && !desc->face) || (desc->faces && desc->period[PD_DIM - 1] > 0.0))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "body", "%g faces%s, expected some or none, and none of a body that "
                       "repeats", (double)desc->faces, desc->face ? "" : " without corners");
    return pdi_body_check_period(ctx, desc);
}

/* Inner part of the build, into an empty body: checks, copies, finds families by the lattice table where that is
 * possible, otherwise by the cell list, and removes bonds that leave the body. In 1D the rim is the linear one, which
 * is exact. The table of fractions exists with an exact rim below 30 spacings. After an error the caller frees. */
static pd_status pdi_body_build_inner(pd_ctx *ctx, const pd_body_desc *desc, pd_body *body, pdi_body_cell_list *cells)
{
    PD_TRY(pdi_body_check(ctx, desc));
    body->count = body->real_count = desc->count;
    body->horizon = desc->horizon;
    body->spacing = desc->spacing;
    memcpy(body->period, desc->period, sizeof body->period);
    body->rim = PD_DIM > 1 ? desc->rim : PD_PARTIAL_VOLUME_LINEAR; /* which is exact in 1D */
    if (body->rim == PD_PARTIAL_VOLUME_EXACT && body->horizon < PDI_BODY_MAX_TABLE_SPACINGS * body->spacing)
        body->fraction_cells = (int32_t)ceil(body->horizon / body->spacing) + 2;
    PD_TRY(pdi_array_registry_build(ctx, pdi_body_list_points, body));
    if (body->fraction_cells) pdi_body_tabulate_fractions(body);
    memcpy(body->position, desc->position, (size_t)desc->count * PD_DIM * sizeof *desc->position);
    memcpy(body->volume, desc->volume, (size_t)desc->count * sizeof *desc->volume);
    PD_TRY(pdi_body_build_lattice_families(ctx, body));
    if (!body->lattice) {
        pdi_body_init_cell_grid(body, cells);
        PD_TRY(pdi_body_build_cell_list(ctx, body, cells));
        PD_TRY(pdi_body_build_families(ctx, body, cells));
    }
    PD_TRY(pdi_body_remove_leaving_bonds(ctx, body, desc));
    return pdi_array_registry_build(ctx, pdi_body_list_state, body);
}

pd_status pd_body_build(pd_ctx *ctx, const pd_body_desc *desc, pd_body *body)
{
    pdi_body_cell_list cells;
    memset(body, 0, sizeof *body);
    memset(&cells, 0, sizeof cells);
    pd_status status = pdi_body_build_inner(ctx, desc, body, &cells);
    pdi_body_free_cell_list(ctx, desc->count, &cells);
    if (status < 0) pd_body_free(ctx, body);
    return status;
}

void pd_body_free(pd_ctx *ctx, pd_body *body)
{
    pdi_array_registry_free(ctx, pdi_body_list_state, body);
    pdi_array_registry_free(ctx, pdi_body_list_families, body);
    pdi_array_registry_free(ctx, pdi_body_list_points, body);
    memset(body, 0, sizeof *body);
}

#undef PDI_BODY_ROUNDING
#undef PDI_BODY_MIN_PERIOD
#undef PDI_BODY_MAX_TABLE_SPACINGS
