/* cut_cell: see cut_cell.h */
#include "lattice/cut_cell.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

#define PDI_CUT_CELL_HALVINGS 3 /* recursive halvings of a cut cell along each axis: parts of h/8 */
#define PDI_CUT_CELL_CORNERS (1 << PD_DIM)
#define PDI_CUT_CELL_VERTICES (PD_DIM + 1) /* vertices of a simplex */
#define PDI_CUT_CELL_SIMPLICES (PD_DIM == 1 ? 1 : PD_DIM == 2 ? 2 : 6)
/* Bits of the shapes that can close a cell. */
#define PDI_CUT_CELL_WALL 1
#define PDI_CUT_CELL_SOLID 2
#define PDI_CUT_CELL_CLOSED (-1) /* the whole cell is closed */

/* State while one cell is processed. */
typedef struct pdi_cut_cell_work {
    const pd_grid *grid;
    int shapes;  /* bits of the smooth shapes that cut the cell */
    int neighbour_shapes; /* the same for the neighbour at the present face */
    int axis;    /* normal to the present face */
    double sign; /* 1: the face is on the upper side of the cell, -1: on the lower one */
    pdi_cut_cell_fn callback;
    void *user;
    double volume;
    pdi_cut_cell_facet piece;
} pdi_cut_cell_work;

/* Permutations of the axes, one for each simplex of a box (Kuhn's triangulation); the first 1, 2 or 6 in 1D, 2D, 3D. */
static const uint8_t pdi_cut_cell_axis_orders[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1},
                                                       {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/* Circumference [m] at radius r [m] on an axisymmetric grid; 1 on a planar one. */
static double pdi_cut_cell_circumference(const pd_grid *grid, double r)
{
    return grid->circumference ? 2.0 * PD_PI * fabs(r) : 1.0;
}

/* 1: the shape exists (index -1: none) and has a smooth surface. */
static int pdi_cut_cell_is_smooth(const pd_grid *grid, int shape)
{
    return shape >= 0 && pd_shape_is_smooth(grid->shapes, shape);
}

/* Signed distance [m] of x from the nearest of the shapes given by bits (the smaller one): negative inside, 0 within
 * the surface tolerance, HUGE_VAL without shapes, -HUGE_VAL for a closed cell. */
static double pdi_cut_cell_signed_distance(const pd_grid *grid, int shapes, const double *x)
{
    double distance = HUGE_VAL;
    if (shapes == PDI_CUT_CELL_CLOSED) return -HUGE_VAL;
    if (shapes & PDI_CUT_CELL_WALL) distance = pdi_grid_signed_distance(grid, grid->wall, x);
    if (shapes & PDI_CUT_CELL_SOLID) distance = pd_min(distance, pdi_grid_signed_distance(grid, grid->solid, x));
    return fabs(distance) <= pd_shape_surface_tolerance(grid->h, x) ? 0.0 : distance;
}

PDI_FN double pdi_cut_cell_surface_distance(const pd_grid *grid, int32_t node)
{
    double x[PD_DIM], distance = HUGE_VAL;
    pd_grid_position(grid, node, x);
    if (pdi_cut_cell_is_smooth(grid, grid->wall)) distance = fabs(pdi_grid_signed_distance(grid, grid->wall, x));
    if (pdi_cut_cell_is_smooth(grid, grid->solid))
        distance = pd_min(distance, fabs(pdi_grid_signed_distance(grid, grid->solid, x)));
    return distance;
}

/* Bits of the smooth shapes that can cut the cell of a node: for an open node those that it is outside of (one inside
 * which it lies has receded), for a solid or wall node all. PDI_CUT_CELL_CLOSED, the cell is closed as a whole: it lies
 * behind a wall side, or is closed and inside no smooth wall, nor, where it is metal, the smooth metal. 0: open, no
 * smooth shape. */
static int pdi_cut_cell_find_shapes(const pd_grid *grid, int32_t node)
{
    static const int bit[2] = {PDI_CUT_CELL_WALL, PDI_CUT_CELL_SOLID};
    int shape[2], shapes = 0, inside = 0;
    uint8_t kind = grid->kind[node];
    double x[PD_DIM];
    shape[0] = grid->wall;
    shape[1] = grid->solid;
    if (pdi_grid_is_behind_wall(grid, node)) return PDI_CUT_CELL_CLOSED;
    pd_grid_position(grid, node, x);
    for (int k = 0; k < 2; k++) {
        if (!pdi_cut_cell_is_smooth(grid, shape[k])) continue;
        int in = !(pdi_grid_signed_distance(grid, shape[k], x) > pd_shape_surface_tolerance(grid->h, x));
        inside = inside || (in && (k == 0 || kind == PD_SOLID));
        if (!in || !pdi_grid_is_open(kind)) shapes |= bit[k];
    }
    return pdi_grid_is_open(kind) || inside ? shapes : PDI_CUT_CELL_CLOSED;
}

/* ---- simplices ---- */

/* A simplex of dimension `axes`: its vertices [m] and the signed distances there [m]; the first `open` ones are in the
 * fluid. */
typedef struct pdi_cut_cell_simplex {
    double x[PDI_CUT_CELL_VERTICES][PD_DIM], distance[PDI_CUT_CELL_VERTICES];
    int axes, open;
} pdi_cut_cell_simplex;

/* Fraction of the edge from vertex `from` to vertex `to`, an open and a closed one, at which the distance is zero. */
static double pdi_cut_cell_edge_fraction(const pdi_cut_cell_simplex *s, int from, int to)
{
    return s->distance[from] / (s->distance[from] - s->distance[to]);
}

/* Fraction of the volume (area, length) of the simplex that is open (distance > 0), from the linear distance in it: 0
 * or 1 when all vertices are on one side. */
static double pdi_cut_cell_open_fraction(const pdi_cut_cell_simplex *s)
{
    int vertices = s->axes + 1;
    double fraction = 1.0;
    if (s->open == 0 || s->open == vertices) return s->open ? 1.0 : 0.0;
    if (s->open == 1) {
        for (int k = 1; k < vertices; k++) fraction *= pdi_cut_cell_edge_fraction(s, 0, k);
        return fraction;
    }
#if PD_DIM == 3
    if (s->open < s->axes) {
        /* the wedge of two edges, as three tetrahedra */
        double a = pdi_cut_cell_edge_fraction(s, 0, 2), b = pdi_cut_cell_edge_fraction(s, 0, 3);
        double c = pdi_cut_cell_edge_fraction(s, 1, 2), d = pdi_cut_cell_edge_fraction(s, 1, 3);
        return a * b + c * d * (1.0 - b) + c * b * (1.0 - a);
    }
#endif
    for (int k = 0; k < s->axes; k++) fraction *= 1.0 - pdi_cut_cell_edge_fraction(s, k, s->axes);
    return 1.0 - fraction;
}

/* Adds vertex number `count` at x [m] with the signed distance `level` [m]: open ones (> 0) are kept in front of closed
 * ones, and counted in s->open. */
static void pdi_cut_cell_add_vertex(pdi_cut_cell_simplex *s, int count, const double *x, double level)
{
    int at = count;
    if (level > 0.0) {
        at = s->open++;
        memcpy(s->x[count], s->x[at], sizeof s->x[0]);
        s->distance[count] = s->distance[at];
    }
    memcpy(s->x[at], x, sizeof s->x[0]);
    s->distance[at] = level;
}

/* Point x [m] of the surface on the edge between two vertices. */
static void pdi_cut_cell_edge_point(const pdi_cut_cell_simplex *s, int from, int to, double *x)
{
    double t = pdi_cut_cell_edge_fraction(s, from, to);
    for (int d = 0; d < PD_DIM; d++) x[d] = s->x[from][d] + t * (s->x[to][d] - s->x[from][d]);
}

/* Passes the surface piece with the corners p [PD_DIM][PD_DIM] [m] to the callback, which may be NULL: sets area vector
 * and centroid (mean of the corners) of w->piece. `out` points from the fluid into the wall and gives the area vector
 * its sign. 1D: the area is 1; axisymmetric: times the circumference at the centroid. */
static void pdi_cut_cell_add_facet(pdi_cut_cell_work *w, double p[][PD_DIM], const double *out)
{
    pdi_cut_cell_facet *piece = &w->piece;
    double *area = piece->area;
    for (int d = 0; d < PD_DIM; d++) {
        piece->centroid[d] = 0.0;
        for (int k = 0; k < PD_DIM; k++) piece->centroid[d] += p[k][d] / PD_DIM;
    }
#if PD_DIM == 1
    area[0] = 1.0;
#elif PD_DIM == 2
    area[0] = p[1][1] - p[0][1];
    area[1] = p[0][0] - p[1][0];
#else
    for (int d = 0; d < 3; d++) {
        int e = (d + 1) % 3, f = (d + 2) % 3;
        area[d] = 0.5 * ((p[1][e] - p[0][e]) * (p[2][f] - p[0][f]) - (p[1][f] - p[0][f]) * (p[2][e] - p[0][e]));
    }
#endif
    double size = pdi_cut_cell_circumference(w->grid, piece->centroid[PD_DIM - 1]);
    if (pdi_vec_dot(area, out) < 0.0) size = -size;
    for (int d = 0; d < PD_DIM; d++) area[d] *= size;
    if (w->callback) w->callback(w->user, piece);
}

/* Passes on the zero level of the distance in a simplex: a point (1D), an edge (2D), one or two triangles (3D). */
static void pdi_cut_cell_add_zero_level(pdi_cut_cell_work *w, const pdi_cut_cell_simplex *s)
{
    double p[4][PD_DIM], out[PD_DIM];
    int count = 0;
    for (int d = 0; d < PD_DIM; d++) out[d] = s->x[s->open][d] - s->x[0][d];
    for (int i = 0; i < s->open; i++)
        for (int k = s->open; k <= PD_DIM; k++) pdi_cut_cell_edge_point(s, i, k, p[count++]);
    pdi_cut_cell_add_facet(w, p, out);
    if (count == 4) pdi_cut_cell_add_facet(w, p + 1, out); /* the edges of the four go by 0, 1, 3, 2 */
}

/* Mean radius [m] of the open part of a triangle (2D) that is not all closed, by its open fraction `share`. */
static double pdi_cut_cell_open_radius(const pdi_cut_cell_simplex *s, double share)
{
    double all = 0.0, corner, x[PD_DIM];
    int lone = s->open == 1 ? 0 : PD_DIM, r = PD_DIM - 1;
    for (int k = 0; k <= PD_DIM; k++) all += s->x[k][r] / PDI_CUT_CELL_VERTICES;
    if (s->open == PDI_CUT_CELL_VERTICES) return all;
    corner = s->x[lone][r] / PDI_CUT_CELL_VERTICES;
    for (int k = 0; k <= PD_DIM; k++) {
        if (k == lone) continue;
        pdi_cut_cell_edge_point(s, lone ? k : lone, lone ? lone : k, x);
        corner += x[r] / PDI_CUT_CELL_VERTICES;
    }
    return lone ? (all - (1.0 - share) * corner) / share : corner;
}

/* Adds the open volume of the box a .. b [m] to w->volume, and passes on its surface. The box is split into simplices
 * that all begin at the corner `anchor` (bit d: upper end along axis d), so that the parts of a halved box mirror each
 * other. Simplices without an open vertex are skipped; all open ones have no surface. */
static void pdi_cut_cell_integrate_simplices(pdi_cut_cell_work *w, const double *a, const double *b, int anchor)
{
    double level[PDI_CUT_CELL_CORNERS], x[PDI_CUT_CELL_CORNERS][PD_DIM], size = 1.0;
    for (int d = 0; d < PD_DIM; d++) size *= (b[d] - a[d]) / (d + 1);
    for (int c = 0; c < PDI_CUT_CELL_CORNERS; c++) {
        for (int d = 0; d < PD_DIM; d++) x[c][d] = c >> d & 1 ? b[d] : a[d];
        level[c] = pdi_cut_cell_signed_distance(w->grid, w->shapes, x[c]);
    }
    for (int k = 0; k < PDI_CUT_CELL_SIMPLICES; k++) {
        pdi_cut_cell_simplex s;
        int c = anchor;
        s.axes = PD_DIM;
        s.open = 0;
        pdi_cut_cell_add_vertex(&s, 0, x[c], level[c]);
        for (int d = 0; d < PD_DIM; d++) {
            c ^= 1 << pdi_cut_cell_axis_orders[k][d];
            pdi_cut_cell_add_vertex(&s, d + 1, x[c], level[c]);
        }
        if (s.open == 0) continue;
        double share = pdi_cut_cell_open_fraction(&s), circumference = 1.0;
        if (w->grid->circumference)
            circumference = pdi_cut_cell_circumference(w->grid, pdi_cut_cell_open_radius(&s, share));
        w->volume += size * share * circumference;
        if (s.open <= PD_DIM) pdi_cut_cell_add_zero_level(w, &s);
    }
}

/* Returns half of the diagonal [m] of the box a .. b; x: its centre [m]. */
static double pdi_cut_cell_compute_centre(const double *a, const double *b, double *x)
{
    double square = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        x[d] = 0.5 * (a[d] + b[d]);
        square += (b[d] - a[d]) * (b[d] - a[d]);
    }
    return 0.5 * sqrt(square);
}

/* Part k of the box a .. b: low .. high [m], halved at `middle` along all axes but `axis` (-1: along all). Bit d of k:
 * the upper half along axis d. */
static void pdi_cut_cell_compute_part(const double *a, const double *b, const double *middle, int axis, int k,
                                      double *low, double *high)
{
    for (int d = 0; d < PD_DIM; d++) {
        int up = k >> d & 1;
        low[d] = d == axis || !up ? a[d] : middle[d];
        high[d] = d == axis || up ? b[d] : middle[d];
    }
}

/* Adds the open volume of the box a .. b [m] to w->volume, and passes on its surface. As a whole, without surface,
 * where the |distance| of its centre is at least half of its diagonal; else by `halvings` recursive halvings along all
 * axes, and at last by simplices. */
static void pdi_cut_cell_integrate_box(pdi_cut_cell_work *w, const double *a, const double *b, int anchor, int halvings)
{
    double x[PD_DIM], low[PD_DIM], high[PD_DIM], size = 1.0;
    double radius = pdi_cut_cell_compute_centre(a, b, x),
           distance = pdi_cut_cell_signed_distance(w->grid, w->shapes, x);
    if (fabs(distance) >= radius) {
        for (int d = 0; d < PD_DIM; d++) size *= b[d] - a[d];
        if (distance > 0.0) w->volume += size * pdi_cut_cell_circumference(w->grid, x[PD_DIM - 1]);
    } else if (halvings == 0) {
        pdi_cut_cell_integrate_simplices(w, a, b, anchor);
    } else {
        for (int k = 0; k < PDI_CUT_CELL_CORNERS; k++) {
            pdi_cut_cell_compute_part(a, b, x, -1, k, low, high);
            pdi_cut_cell_integrate_box(w, low, high, k, halvings - 1);
        }
    }
}

/* ---- faces of cells ---- */

/* Fraction of the face a .. b of the present axis that is open in the cell and closed in its neighbour, by simplices
 * whose distances are linear. 1D: 1 or 0. */
static double pdi_cut_cell_face_open_fraction(const pdi_cut_cell_work *w, const double *a, const double *b, int anchor)
{
    double sum = 0.0;
    int axes[3], count = 0, orders = 0;
    for (int d = 0; d < PD_DIM; d++)
        if (d != w->axis) axes[count++] = d;
    for (int k = 0; k < PDI_CUT_CELL_SIMPLICES; k++) {
        pdi_cut_cell_simplex mine, both;
        double x[PD_DIM];
        int c = anchor;
        if (count < PD_DIM && pdi_cut_cell_axis_orders[k][PD_DIM - 1] != PD_DIM - 1) continue;
        mine.axes = both.axes = count;
        mine.open = both.open = 0;
        for (int step = 0; step <= count; step++) {
            if (step) c ^= 1 << axes[pdi_cut_cell_axis_orders[k][step - 1]];
            for (int d = 0; d < PD_DIM; d++) x[d] = c >> d & 1 ? b[d] : a[d];
            double level = pdi_cut_cell_signed_distance(w->grid, w->shapes, x);
            pdi_cut_cell_add_vertex(&mine, step, x, level);
            pdi_cut_cell_add_vertex(&both, step, x,
                                    pd_min(level, pdi_cut_cell_signed_distance(w->grid, w->neighbour_shapes, x)));
        }
        sum += pdi_cut_cell_open_fraction(&mine) - pdi_cut_cell_open_fraction(&both);
        orders++;
    }
    return sum / orders;
}

/* Passes on the fraction `share` of the face a .. b [m] as a surface piece, with the centroid of the whole face and the
 * area vector out of the cell (times the circumference of a ring); nothing when that has no area. */
static void pdi_cut_cell_add_face(pdi_cut_cell_work *w, const double *a, const double *b, double share)
{
    pdi_cut_cell_facet *piece = &w->piece;
    double size = w->sign * share;
    for (int d = 0; d < PD_DIM; d++) {
        piece->centroid[d] = 0.5 * (a[d] + b[d]);
        if (d != w->axis) size *= b[d] - a[d];
        piece->area[d] = 0.0;
    }
    piece->area[w->axis] = size * pdi_cut_cell_circumference(w->grid, piece->centroid[PD_DIM - 1]);
    if (fabs(size) > 0.0 && w->callback) w->callback(w->user, piece);
}

/* Passes on the parts of the face a .. b that are open in the cell and closed in its neighbour. With distances at its
 * centre and half its diagonal r: nothing when the cell is closed (<= -r) or the neighbour open (>= r); all of it when
 * the cell is open and the neighbour closed; else by recursive halvings, and at last by simplices. */
static void pdi_cut_cell_integrate_face(pdi_cut_cell_work *w, const double *a, const double *b, int anchor,
                                        int halvings)
{
    double x[PD_DIM], low[PD_DIM], high[PD_DIM], radius = pdi_cut_cell_compute_centre(a, b, x);
    double mine = pdi_cut_cell_signed_distance(w->grid, w->shapes, x),
           other = pdi_cut_cell_signed_distance(w->grid, w->neighbour_shapes, x);
    if (mine <= -radius || (other > 0.0 && other >= radius)) return;
    if (mine > 0.0 && mine >= radius && other <= -radius) pdi_cut_cell_add_face(w, a, b, 1.0);
    else if (halvings == 0) pdi_cut_cell_add_face(w, a, b, pdi_cut_cell_face_open_fraction(w, a, b, anchor));
    else
        for (int k = 0; k < PDI_CUT_CELL_CORNERS; k++) {
            if (k >> w->axis & 1) continue;
            pdi_cut_cell_compute_part(a, b, x, w->axis, k, low, high);
            pdi_cut_cell_integrate_face(w, low, high, k, halvings - 1);
        }
}

/* ---- cells ---- */

/* Clips cell i[] to the box lo .. hi: a .. b [m]. 1: something is left, 0: nothing. */
static int pdi_cut_cell_clip(const pd_grid *grid, const int *i, const double *lo, const double *hi, double *a,
                             double *b)
{
    for (int d = 0; d < PD_DIM; d++) {
        a[d] = pd_max(grid->lo[d] + i[d] * grid->h[d], lo[d]);
        b[d] = pd_min(grid->lo[d] + (i[d] + 1) * grid->h[d], hi[d]);
        if (!(b[d] > a[d])) return 0;
    }
    return 1;
}

PDI_FN double pdi_cut_cell_overlap_fraction(const pd_grid *grid, int32_t node, const double *lo, const double *hi)
{
    double a[PD_DIM], b[PD_DIM], fraction = 1.0;
    int i[PD_DIM];
    pd_grid_index(grid, node, i);
    if (!pdi_cut_cell_clip(grid, i, lo, hi, a, b)) return 0.0;
    for (int d = 0; d < PD_DIM; d++) fraction *= pd_min((b[d] - a[d]) / grid->h[d], 1.0);
    return fraction;
}

PDI_FN double pdi_cut_cell_integrate(const pd_grid *grid, int32_t node, const double *lo, const double *hi,
                                     pdi_cut_cell_fn take, void *user)
{
    pdi_cut_cell_work w;
    double a[PD_DIM], b[PD_DIM];
    int i[PD_DIM];
    memset(&w, 0, sizeof w);
    pd_grid_index(grid, node, i);
    w.grid = grid;
    w.callback = take;
    w.user = user;
    w.shapes = pdi_cut_cell_find_shapes(grid, node);
    if (w.shapes == PDI_CUT_CELL_CLOSED || !pdi_cut_cell_clip(grid, i, lo, hi, a, b)) return 0.0;
    w.piece.closed_node = -1;
    pdi_cut_cell_integrate_box(&w, a, b, 0, PDI_CUT_CELL_HALVINGS);
    for (int side = 0; side < 2 * PD_DIM && take; side++) {
        int d = side / 2, up = side % 2;
        double low[PD_DIM], high[PD_DIM], face = grid->lo[d] + (i[d] + up) * grid->h[d];
        int32_t other = up ? node + grid->stride[d] : node - grid->stride[d];
        w.neighbour_shapes = pdi_cut_cell_find_shapes(grid, other);
        if (w.neighbour_shapes == w.shapes || w.neighbour_shapes == 0 || face < lo[d] || face > hi[d]) continue;
        memcpy(low, a, sizeof low);
        memcpy(high, b, sizeof high);
        low[d] = high[d] = face;
        w.axis = d;
        w.sign = up ? 1.0 : -1.0;
        w.piece.closed_node = other;
        w.piece.is_box_side = pdi_grid_is_behind_wall(grid, other);
        pdi_cut_cell_integrate_face(&w, low, high, 0, PDI_CUT_CELL_HALVINGS);
    }
    return w.volume;
}

#undef PDI_CUT_CELL_HALVINGS
#undef PDI_CUT_CELL_CORNERS
#undef PDI_CUT_CELL_VERTICES
#undef PDI_CUT_CELL_SIMPLICES
#undef PDI_CUT_CELL_WALL
#undef PDI_CUT_CELL_SOLID
#undef PDI_CUT_CELL_CLOSED
