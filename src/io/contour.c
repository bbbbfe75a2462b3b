/* contour: see contour.h */
#include "io/contour.h"
#include <math.h>

/* Value of the cell (i, j); NaN: it has none, or lies outside. */
static double pdi_contour_get_value(const pdi_contour *c, int i, int j)
{
    if (i < 0 || i >= c->nx || j < 0 || j >= c->ny) return (double)NAN;
    return c->value[(size_t)j * (size_t)c->nx + (size_t)i];
}

/* Value in the middle of the face of a cell with a value towards its neighbour (di, dj), one of them 1 or -1, the other
 * 0: mean with the neighbour; where that has none, extrapolated linearly from the cell on the opposite side; where that
 * has none either, the value of the cell. */
static double pdi_contour_interpolate_face(const pdi_contour *c, int i, int j, int di, int dj)
{
    double own = pdi_contour_get_value(c, i, j), next = pdi_contour_get_value(c, i + di, j + dj);
    if (!isnan(next)) return 0.5 * (own + next);
    double back = pdi_contour_get_value(c, i - di, j - dj);
    return isnan(back) ? own : own + 0.5 * (own - back);
}

/* Value in the corner of a cell with a value towards (di, dj), each 1 or -1, from the four cells there. All have
 * values: their mean. Three: the mean of the two on one diagonal. The cell and one that shares a face: mean of what
 * both extrapolate to. Else the cell extrapolates alone, along both axes. All cells with a value that share a face get
 * the same value. */
static double pdi_contour_interpolate_corner(const pdi_contour *c, int i, int j, int di, int dj)
{
    double own = pdi_contour_get_value(c, i, j), x = pdi_contour_get_value(c, i + di, j),
           y = pdi_contour_get_value(c, i, j + dj);
    double across = pdi_contour_get_value(c, i + di, j + dj);
    if (!isnan(x) && !isnan(y)) return isnan(across) ? 0.5 * (x + y) : 0.25 * (own + x + y + across);
    if (!isnan(across) && (!isnan(x) || !isnan(y))) return 0.5 * (own + across);
    if (!isnan(x))
        return 0.5 * (pdi_contour_interpolate_face(c, i, j, 0, dj) + pdi_contour_interpolate_face(c, i + di, j, 0, dj));
    if (!isnan(y))
        return 0.5 * (pdi_contour_interpolate_face(c, i, j, di, 0) + pdi_contour_interpolate_face(c, i, j + dj, di, 0));
    return pdi_contour_interpolate_face(c, i, j, di, 0) + pdi_contour_interpolate_face(c, i, j, 0, dj) - own;
}

/* A square for marching squares: its corners in turn, at x, y [cells]. */
typedef struct pdi_contour_square {
    double x[4], y[4], value[4];
} pdi_contour_square;

/* Point[2] [cells] where the contour crosses the side from corner k to the next one, by linear interpolation. */
static void pdi_contour_interpolate_crossing(const pdi_contour_square *s, double level, int k, double *point)
{
    int next = (k + 1) % 4;
    double fraction = (level - s->value[k]) / (s->value[next] - s->value[k]);
    point[0] = s->x[k] + fraction * (s->x[next] - s->x[k]);
    point[1] = s->y[k] + fraction * (s->y[next] - s->y[k]);
}

/* Call add_segment for the segments of a contour in one square, none to two (marching squares). A corner is inside
 * where its value >= level; at a saddle the corners that agree in that with the mean of the four are connected. */
static void pdi_contour_march_square(const pdi_contour_square *s, double level, pdi_contour_segment_fn add_segment,
                                     void *user)
{
    double at[4][2];
    int in[4], side[4], count = 0;
    for (int k = 0; k < 4; k++) in[k] = s->value[k] >= level;
    for (int k = 0; k < 4; k++) {
        if (in[k] == in[(k + 1) % 4]) continue;
        pdi_contour_interpolate_crossing(s, level, k, at[count]);
        side[count++] = k;
    }
    if (count == 2) add_segment(user, at[0], at[1]);
    if (count < 4) return;
    /* A saddle: the mean decides which pair of opposite corners is connected. */
    int mean_in = 0.25 * (s->value[0] + s->value[1] + s->value[2] + s->value[3]) >= level;
    int shift = mean_in == in[side[0]] ? 0 : 3; /* corners 1 and 3 are cut off, else 0 and 2 */
    add_segment(user, at[shift], at[(shift + 1) % 4]);
    add_segment(user, at[(shift + 2) % 4], at[(shift + 3) % 4]);
}

/* Call add_segment for the segments in the quarter of the cell (i, j) with a value towards (di, dj), each 1 or -1. */
static void pdi_contour_march_quarter_cell(const pdi_contour *c, int i, int j, int di, int dj, double level,
                                           pdi_contour_segment_fn add_segment, void *user)
{
    pdi_contour_square s;
    double x = i + 0.5, y = j + 0.5;
    s.x[0] = s.x[3] = x;
    s.x[1] = s.x[2] = x + 0.5 * di;
    s.y[0] = s.y[1] = y;
    s.y[2] = s.y[3] = y + 0.5 * dj;
    s.value[0] = pdi_contour_get_value(c, i, j);
    s.value[1] = pdi_contour_interpolate_face(c, i, j, di, 0);
    s.value[2] = pdi_contour_interpolate_corner(c, i, j, di, dj);
    s.value[3] = pdi_contour_interpolate_face(c, i, j, 0, dj);
    pdi_contour_march_square(&s, level, add_segment, user);
}

PDI_FN void pdi_contour_find_segments(const pdi_contour *c, double level, pdi_contour_segment_fn add_segment,
                                      void *user)
{
    for (int j = 0; j < c->ny; j++)
        for (int i = 0; i < c->nx; i++) {
            if (isnan(pdi_contour_get_value(c, i, j))) continue;
            for (int k = 0; k < 4; k++)
                pdi_contour_march_quarter_cell(c, i, j, k & 1 ? 1 : -1, k & 2 ? 1 : -1, level, add_segment, user);
        }
}
