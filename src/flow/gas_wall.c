/* gas_wall: see gas_wall.h */
#include "flow/gas_wall.h"
#include "lattice/surface.h"
#include <math.h>
#include <string.h>

/* [-] walls whose normals have a smaller cosine meet in an edge; other surfaces are smooth */
#define PDI_GAS_WALL_EDGE_COSINE 0.5
/* [-] walls whose normals have a cosine below minus this are those of a channel */
#define PDI_GAS_WALL_CHANNEL_COSINE 0.9
#define PDI_GAS_WALL_CORNER_VOLUME 0.3 /* [-] three walls whose unit normals span a larger volume meet in a corner */
#define PDI_GAS_WALL_STEP 1e-3 /* [cells] step of finite differences that find edges */
#define PDI_GAS_WALL_ROUNDING 1e-9 /* [-] parts of an area and differences of cosines that are rounding */

PDI_COLD_BEGIN
/* Different walls that the closed bonds of a row meet: points [m] and normals towards the gas. */
typedef struct pdi_gas_wall_hits {
    int count;
    int *hit_count;         /* [count] bonds */
    double *point, *normal; /* [count][PD_DIM] */
} pdi_gas_wall_hits;

/* 1: the walls a and b face each other across a concave edge: the cosine of their normals is between -0.9 and 0.5 (no
 * channel, no smooth surface), and the point of each lies in front of the other. */
static int pdi_gas_wall_is_concave_pair(const pdi_gas_wall_hits *w, int a, int b)
{
    const double *na = w->normal + a * PD_DIM, *nb = w->normal + b * PD_DIM;
    double dot = pdi_vec_dot(na, nb), front_a = 0.0, front_b = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        double offset = w->point[b * PD_DIM + d] - w->point[a * PD_DIM + d];
        front_a += offset * na[d];
        front_b -= offset * nb[d];
    }
    return dot < PDI_GAS_WALL_EDGE_COSINE && dot > -PDI_GAS_WALL_CHANNEL_COSINE && front_a > 0.0 && front_b > 0.0;
}

/* Volume that the unit normals of walls a, b, c span, 1 when they are orthogonal; 0 in 1D and 2D, and when c makes no
 * concave pair with a or with b. The pair a, b is not checked. */
static double pdi_gas_wall_compute_normal_volume(const pdi_gas_wall_hits *w, int a, int b, int c)
{
    const double *na = w->normal + a * PD_DIM, *nb = w->normal + b * PD_DIM, *nc = w->normal + c * PD_DIM;
    double volume = 0.0;
    if (PD_DIM < 3 || !pdi_gas_wall_is_concave_pair(w, a, c) || !pdi_gas_wall_is_concave_pair(w, b, c)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        int e = (d + 1) % PD_DIM, f = (d + 2) % PD_DIM;
        volume += na[d] * (nb[e] * nc[f] - nb[f] * nc[e]);
    }
    return fabs(volume);
}

/* Finds the walls of a concave edge or corner. In 3D three walls of pairwise concave edges, whose normals span the
 * largest volume, above 0.3; else the concave pair with the smallest cosine. wall: their indices. Returns their number:
 * 0, 2, or 3 in 3D. 0 where there is none, or where the best choice is not the only one, as between a ball and a
 * floor. */
static int pdi_gas_wall_find_corner(const pdi_gas_wall_hits *w, int *wall)
{
    double least = 1.0, widest = PDI_GAS_WALL_CORNER_VOLUME;
    int found = 0, alike = 0;
    for (int a = 0; a < w->count; a++)
        for (int b = a + 1; b < w->count; b++) {
            double dot = pdi_vec_dot(w->normal + a * PD_DIM, w->normal + b * PD_DIM);
            if (!pdi_gas_wall_is_concave_pair(w, a, b)) continue;
            if (found < 3 && dot < least + PDI_GAS_WALL_ROUNDING) {
                alike = dot > least - PDI_GAS_WALL_ROUNDING;
                least = pd_min(least, dot);
                wall[0] = a;
                wall[1] = b;
                found = 2;
            }
            for (int c = b + 1; c < w->count && PD_DIM == 3; c++) {
                double volume = pdi_gas_wall_compute_normal_volume(w, a, b, c);
                if (!(volume > widest - PDI_GAS_WALL_ROUNDING)) continue;
                alike = found == 3 && volume < widest + PDI_GAS_WALL_ROUNDING;
                widest = pd_max(widest, volume);
                wall[0] = a;
                wall[1] = b;
                wall[2] = c;
                found = 3;
            }
        }
    return alike ? 0 : found;
}

/* Splits the area vector `face` [PD_DIM] among the walls of a corner, in place, into face [walls][PD_DIM], which sum up
 * to it; what no wall normal gives is shared in proportion to their areas. Returns 1; 0: the normals are not
 * independent or one part would be negative, `face` is unchanged. */
static int pdi_gas_wall_split_area(const pdi_gas_wall_hits *w, const int *wall, int walls, double *face)
{
    double gram[PD_DIM * PD_DIM], inverse[PD_DIM * PD_DIM], part[3] = {0.0}, rest[PD_DIM];
    double size = pdi_vec_norm(face), sum = 0.0;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = 0; b < PD_DIM; b++) {
            int both = a < walls && b < walls;
            const double *na = w->normal + wall[a] * PD_DIM, *nb = w->normal + wall[b] * PD_DIM;
            gram[a * PD_DIM + b] = both ? pdi_vec_dot(na, nb) : a == b;
        }
    if (!(pdi_vec_invert(gram, inverse) > 0.0)) return 0;
    for (int a = 0; a < walls; a++) {
        for (int b = 0; b < walls; b++)
            part[a] -= inverse[a * PD_DIM + b] * pdi_vec_dot(w->normal + wall[b] * PD_DIM, face);
        if (part[a] < -PDI_GAS_WALL_ROUNDING * size) return 0;
        if (part[a] < PDI_GAS_WALL_ROUNDING * size) part[a] = 0.0;
        sum += part[a];
    }
    if (!(sum > 0.0)) return 0;
    for (int d = 0; d < PD_DIM; d++) {
        rest[d] = face[d];
        for (int a = 0; a < walls; a++) rest[d] += part[a] * w->normal[wall[a] * PD_DIM + d];
    }
    for (int a = 0; a < walls; a++)
        for (int d = 0; d < PD_DIM; d++)
            face[a * PD_DIM + d] = part[a] / sum * rest[d] - part[a] * w->normal[wall[a] * PD_DIM + d];
    return 1;
}

/* Point x [m] where closed bond k of row r meets a wall, and the wall's normal n towards the gas. Returns 1, or 0 on an
 * edge, which has none, and without a wall. */
static int pdi_gas_wall_find_plane(const pd_bonds *bonds, int32_t r, int k, double *x, double *n)
{
    double distance, slope[PD_DIM], most = 0.0;
    int32_t closed = pdi_bond_find_surface_point(bonds, r, k, x, n);
    if (closed < 0) return 0;
    if (pdi_bond_surface_distance(bonds, closed, x) < HUGE_VAL)
        return pdi_surface_compute_normal(bonds, closed, x, PDI_GAS_WALL_STEP, &distance, slope);
    for (int d = 0; d < PD_DIM; d++) most = pd_max(most, fabs(n[d]));
    return most > 1.0 - PDI_GAS_WALL_ROUNDING;
}

/* Distance [m] of wall `at` with the area vector `face`: weighted mean over the bonds that meet it, rather than another
 * wall of the corner. walls 0: over all. Opposite bonds that are both closed take no part. 0: no such bond. */
static double pdi_gas_wall_compute_distance(const pd_bonds *bonds, int32_t r, const pdi_gas_wall_hits *w,
                                            const int *wall, int walls, int at, const double *face)
{
    const pd_stencil *s = bonds->stencil;
    double weights = 0.0, along = 0.0, size = pdi_vec_norm(face);
    for (int k = 0; k < s->count && size > 0.0; k++) {
        double n[PD_DIM], x[PD_DIM], normal[PD_DIM];
        int fits = 1;
        if (pdi_bond_is_open(bonds, r, k) || !pdi_bond_is_open(bonds, r, s->count - 1 - k)) continue;
        if (walls && !pdi_gas_wall_find_plane(bonds, r, k, x, normal)) continue;
        for (int a = 0; a < walls; a++)
            fits = fits && pdi_vec_dot(normal, w->normal + wall[a] * PD_DIM) <=
                               pdi_vec_dot(normal, w->normal + wall[at] * PD_DIM) + PDI_GAS_WALL_ROUNDING;
        if (!fits) continue;
        int group = pdi_bond_path_find_closed_group(&bonds->paths, bonds->node[r], k);
        double weight = pdi_gas_wall_get_bond_face(s, k, n);
        weights += weight;
        along += weight * s->group_entry[group] * pdi_vec_dot(s->xi + k * PD_DIM, face);
    }
    return weights > 0.0 ? along / (weights * size) : 0.0;
}

/* Adds a wall at point x with normal n, unless it faces away from the gas (n along `face`). Of walls with the same
 * normal the nearest to the gas counts, at the mean of its points within `slack` [m], since a single point at an edge
 * does not tell on which side the other wall is. */
static void pdi_gas_wall_add_wall(pdi_gas_wall_hits *w, const double *face, const double *x, const double *n,
                                  double slack)
{
    int at = 0;
    double size = pdi_vec_norm(face);
    if (pdi_vec_dot(n, face) > PDI_GAS_WALL_ROUNDING * size) return;
    while (at < w->count && !(pdi_vec_dot(n, w->normal + at * PD_DIM) > 1.0 - PDI_GAS_WALL_ROUNDING)) at++;
    double *place = w->point + at * PD_DIM;
    double nearer = at < w->count ? pdi_vec_dot(n, x) - pdi_vec_dot(n, place) : HUGE_VAL;
    if (nearer < -slack) return;
    if (nearer > slack) w->hit_count[at] = 0;
    w->hit_count[at]++;
    for (int d = 0; d < PD_DIM; d++)
        place[d] = w->hit_count[at] > 1 ? place[d] + (x[d] - place[d]) / w->hit_count[at] : x[d];
    memcpy(w->normal + at * PD_DIM, n, PD_DIM * sizeof *n);
    if (at == w->count) w->count++;
}

/* face [PD_DIM][PD_DIM], gap [PD_DIM] of row r: the slip walls of a concave edge or corner; else, and in 1D always, one
 * wall. Others are 0. Opposite bonds that are both closed cancel, and take no part. w: work. */
static void pdi_gas_wall_build_row(const pd_bonds *bonds, int32_t r, pdi_gas_wall_hits *w, double *face, double *gap)
{
    const pd_stencil *s = bonds->stencil;
    int wall[3] = {0, 0, 0}, walls = 0;
    for (int i = 0; i < PD_DIM * PD_DIM; i++) face[i] = 0.0;
    for (int k = 0; k < s->count; k++)
        for (int d = 0; d < PD_DIM && !pdi_bond_is_open(bonds, r, k) && pdi_bond_is_open(bonds, r, s->count - 1 - k);
             d++)
            face[d] += s->gradient_weight[k * PD_DIM + d];
    w->count = 0;
    for (int k = 0; k < s->count && PD_DIM > 1; k++) {
        double x[PD_DIM], n[PD_DIM];
        if (pdi_bond_is_open(bonds, r, k) || !pdi_gas_wall_find_plane(bonds, r, k, x, n)) continue;
        pdi_gas_wall_add_wall(w, face, x, n, PDI_GAS_WALL_ROUNDING * pdi_vec_min(bonds->grid->h));
    }
    if (w->count > 1) walls = pdi_gas_wall_find_corner(w, wall);
    if (walls && !pdi_gas_wall_split_area(w, wall, walls, face)) walls = 0;
    for (int a = 0; a < PD_DIM; a++)
        gap[a] = pdi_gas_wall_compute_distance(bonds, r, w, wall, walls, a < walls ? a : 0, face + a * PD_DIM);
}

PDI_FN pd_status pdi_gas_wall_build(pd_ctx *ctx, const pd_bonds *bonds, int32_t rows, double *face, double *gap)
{
    pdi_gas_wall_hits w;
    int count = bonds->stencil->count;
    memset(&w, 0, sizeof w);
    pd_status status = PD_NEW(ctx, "gas", count, w.hit_count);
    if (status >= 0) status = PD_NEW(ctx, "gas", count * PD_DIM, w.point);
    if (status >= 0) status = PD_NEW(ctx, "gas", count * PD_DIM, w.normal);
    for (int32_t r = 0; r < rows && status >= 0; r++)
        pdi_gas_wall_build_row(bonds, r, &w, face + (int64_t)r * PD_DIM * PD_DIM, gap + (int64_t)r * PD_DIM);
    PD_DELETE(ctx, count, w.hit_count);
    PD_DELETE(ctx, count * PD_DIM, w.point);
    PD_DELETE(ctx, count * PD_DIM, w.normal);
    return status;
}
PDI_COLD_END
