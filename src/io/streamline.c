/* streamline: see streamline.h */
#include "io/streamline.h"
#include "core/vec.h"
#include "io/canvas.h"
#include <math.h>
#include <string.h>

/* Lengths over the distance between lines, unless another unit is given. */
#define PDI_STREAMLINE_MIN_DISTANCE 0.5 /* a line ends at this distance from another one (d_test of Jobard and Lefer) \
                                         */
#define PDI_STREAMLINE_MIN_SPEED 1e-4   /* speed over the largest speed below which the fluid is at rest */
#define PDI_STREAMLINE_CLOSURE_DISTANCE 0.02 /* a line that returns to its seed within this distance is closed */
#define PDI_STREAMLINE_MIN_LENGTH 1.5        /* minimum length of open lines */
#define PDI_STREAMLINE_FACE_CLEARANCE 0.3 /* minimum distance of a seed from a face without flow, but in a narrow gap \
                                           */
#define PDI_STREAMLINE_MAX_STEP 0.25      /* [cells] maximum length of a step */
#define PDI_STREAMLINE_MIN_STEPS 8.0      /* [-] minimum number of steps over the distance between lines */
#define PDI_STREAMLINE_MAX_STEPS 64.0     /* [-] maximum number of these */
#define PDI_STREAMLINE_STORED_POINTS 12.0 /* [-] stored points over that distance */
#define PDI_STREAMLINE_MAX_HALVINGS 6     /* [-] maximum halvings of a step that leaves the fluid */

/* A point of a line in the bucket grid by which near lines are found. */
typedef struct pdi_streamline_bucket_point {
    double x, y;
    double arc_length; /* [pixel] arc length from the seed, negative upstream */
    int64_t line; /* index of the line */
    int64_t next; /* next point of the bucket, -1: none */
} pdi_streamline_bucket_point;

/* State of the computation. */
typedef struct pdi_streamline_work {
    pd_ctx *ctx;
    const pdi_streamline_field *field;
    pdi_streamlines *lines;
    double step, min_speed;  /* [pixel] length of a step, [pixel/s] minimum speed */
    int store_interval;      /* steps between stored points */
    int columns, rows;       /* of the bucket grid, whose squares are as wide as the distance between lines */
    int64_t *bucket_head;    /* [columns * rows] first point of a bucket, -1: none */
    pdi_streamline_bucket_point *bucket_point;
    int64_t bucket_point_count, bucket_point_capacity;
} pdi_streamline_work;

/* ---- velocity ---- */

/* Index of the cell (i, j), or of the nearest one beyond an open side; -1: no fluid, or beyond a closed side. */
static int64_t pdi_streamline_find_cell(const pdi_streamline_field *f, int i, int j)
{
    if ((i < 0 && f->side_closed[0]) || (i >= f->nx && f->side_closed[1]) || (j < 0 && f->side_closed[2]) ||
        (j >= f->ny && f->side_closed[3]))
        return -1;
    i = i < 0 ? 0 : i >= f->nx ? f->nx - 1 : i;
    j = j < 0 ? 0 : j >= f->ny ? f->ny - 1 : j;
    int64_t cell = (int64_t)j * f->nx + i;
    return isnan(f->velocity[0][cell]) || isnan(f->velocity[1][cell]) ? -1 : cell;
}

/* Velocity component d in the middle of the face between the cells `own` and `next` along an axis. Without fluid in
 * `next` (-1) the normal component is 0 and the tangential one that of `own`. */
static double pdi_streamline_interpolate_face(const pdi_streamline_field *f, int64_t own, int64_t next, int d, int axis)
{
    if (next >= 0) return 0.5 * (f->velocity[d][own] + f->velocity[d][next]);
    return d == axis ? 0.0 : f->velocity[d][own];
}

/* Velocity component d at the corner of four cells, at least one with fluid, cell[k]: of the other column for k & 1, of
 * the other row for k & 2; -1: no fluid. Mean of the cells with fluid; 0 where the face across d between one of these
 * and a cell without fluid meets the corner. */
static double pdi_streamline_interpolate_corner(const pdi_streamline_field *f, const int64_t *cell, int d)
{
    double sum = 0.0;
    int count = 0, other = 1 << d;
    for (int k = 0; k < 4; k++) {
        if (cell[k] < 0) continue;
        if (cell[k ^ other] < 0) return 0.0;
        sum += f->velocity[d][cell[k]];
        count++;
    }
    return sum / count;
}

PDI_FN int pdi_streamline_interpolate_velocity(const pdi_streamline_field *f, const double *position, double *velocity)
{
    double x = position[0] / f->pixel_size[0], y = position[1] / f->pixel_size[1];
    if (!(x >= 0.0 && x <= f->nx && y >= 0.0 && y <= f->ny)) return 0;
    int i = x < f->nx ? (int)x : f->nx - 1, j = y < f->ny ? (int)y : f->ny - 1;
    int di = x - i >= 0.5 ? 1 : -1, dj = y - j >= 0.5 ? 1 : -1;
    double a = 2.0 * fabs(x - i - 0.5), b = 2.0 * fabs(y - j - 0.5); /* 0: middle, 1: face */
    int64_t own = pdi_streamline_find_cell(f, i, j), beside = pdi_streamline_find_cell(f, i + di, j);
    int64_t above = pdi_streamline_find_cell(f, i, j + dj), cell[4];
    if (own < 0) return 0;
    for (int k = 0; k < 4; k++) cell[k] = pdi_streamline_find_cell(f, k & 1 ? i + di : i, k & 2 ? j + dj : j);
    for (int d = 0; d < 2; d++) {
        double value = (1.0 - a) * (1.0 - b) * f->velocity[d][own] +
                       a * (1.0 - b) * pdi_streamline_interpolate_face(f, own, beside, d, 0);
        value += (1.0 - a) * b * pdi_streamline_interpolate_face(f, own, above, d, 1) +
                 a * b * pdi_streamline_interpolate_corner(f, cell, d);
        velocity[d] = value * f->pixel_size[d] / f->cell_size[d];
    }
    return 1;
}

PDI_FN double pdi_streamline_compute_max_speed(const pdi_streamline_field *f)
{
    double fastest = 0.0;
    for (int64_t k = 0; k < (int64_t)f->nx * f->ny; k++)
        fastest = pd_max(fastest, pdi_canvas_hypot(f->velocity[0][k], f->velocity[1][k]));
    return fastest;
}

/* Largest speed in the picture [pixel/s]; *cell: index of its cell, -1: nothing flows. */
static double pdi_streamline_find_fastest_cell(const pdi_streamline_field *f, int64_t *cell)
{
    double fastest = 0.0;
    *cell = -1;
    for (int64_t k = 0; k < (int64_t)f->nx * f->ny; k++) {
        double speed = pdi_canvas_hypot(f->velocity[0][k] * f->pixel_size[0] / f->cell_size[0],
                                        f->velocity[1][k] * f->pixel_size[1] / f->cell_size[1]);
        if (!(speed > fastest)) continue;
        fastest = speed;
        *cell = k;
    }
    return fastest;
}

/* ---- distance to other lines ---- */

/* Head of the bucket that holds the point (x, y) [pixel]; points outside count to the nearest one. */
static int64_t *pdi_streamline_find_bucket(const pdi_streamline_work *s, double x, double y)
{
    int column = (int)(x / s->field->spacing), row = (int)(y / s->field->spacing);
    column = column < 0 ? 0 : column >= s->columns ? s->columns - 1 : column;
    row = row < 0 ? 0 : row >= s->rows ? s->rows - 1 : row;
    return &s->bucket_head[(int64_t)row * s->columns + column];
}

/* Add a point[2] of the current line to its bucket. arc_length [pixel]: from the seed, negative upstream. */
static pd_status pdi_streamline_add_to_bucket(pdi_streamline_work *s, const double *point, double arc_length)
{
    if (s->bucket_point_count == s->bucket_point_capacity) {
        int64_t room = 2 * s->bucket_point_capacity + 1024;
        PD_TRY(PD_GROW(s->ctx, "streamline", s->bucket_point_capacity, room, s->bucket_point));
        s->bucket_point_capacity = room;
    }
    pdi_streamline_bucket_point *mark = &s->bucket_point[s->bucket_point_count];
    int64_t *head = pdi_streamline_find_bucket(s, point[0], point[1]);
    mark->x = point[0];
    mark->y = point[1];
    mark->arc_length = arc_length;
    mark->line = s->lines->count;
    mark->next = *head;
    *head = s->bucket_point_count++;
    return PD_OK;
}

/* Remove the newest points from their buckets until `marks` points are left. */
static void pdi_streamline_remove_from_buckets(pdi_streamline_work *s, int64_t marks)
{
    while (s->bucket_point_count > marks) {
        const pdi_streamline_bucket_point *mark = &s->bucket_point[--s->bucket_point_count];
        *pdi_streamline_find_bucket(s, mark->x, mark->y) = mark->next;
    }
}

/* Returns 1 when a stored point lies nearer than `distance` [pixel], at most the spacing, to the position; else 0. own
 * 1: points of the current line whose arc length differs from arc_length [pixel] by at least that of a half circle of
 * half the spacing as radius; 0: points of other lines. */
static int pdi_streamline_is_point_near(const pdi_streamline_work *s, const double *position, double distance, int own,
                                        double arc_length)
{
    double half_turn = PD_PI * PDI_STREAMLINE_MIN_DISTANCE * s->field->spacing;
    int column = (int)(position[0] / s->field->spacing), row = (int)(position[1] / s->field->spacing);
    for (int j = row - 1; j <= row + 1; j++)
        for (int i = column - 1; i <= column + 1; i++) {
            if (i < 0 || i >= s->columns || j < 0 || j >= s->rows) continue;
            for (int64_t k = s->bucket_head[(int64_t)j * s->columns + i]; k >= 0; k = s->bucket_point[k].next) {
                const pdi_streamline_bucket_point *mark = &s->bucket_point[k];
                if ((mark->line == s->lines->count) != own) continue;
                if (own && fabs(mark->arc_length - arc_length) < half_turn) continue;
                if (pdi_canvas_hypot(mark->x - position[0], mark->y - position[1]) < distance) return 1;
            }
        }
    return 0;
}

/* ---- one line ---- */

/* Unit vector direction[2] of the velocity in the picture, times sense (1 downstream, -1 upstream). Returns 1; 0: no
 * fluid, outside, or a speed of at most min_speed, and direction is unchanged. */
static int pdi_streamline_compute_direction(const pdi_streamline_work *s, const double *position, double sense,
                                            double *direction)
{
    double u[2];
    if (!pdi_streamline_interpolate_velocity(s->field, position, u)) return 0;
    double speed = pdi_canvas_hypot(u[0], u[1]);
    if (!(speed > s->min_speed)) return 0;
    direction[0] = sense * u[0] / speed;
    direction[1] = sense * u[1] / speed;
    return 1;
}

/* A step of this length [pixel] of the classical Runge-Kutta method of order 4 along the line, with unit velocity.
 * Returns 1; 0: a stage or the end lies outside the fluid or where it is at rest. */
static int pdi_streamline_step_rk4(const pdi_streamline_work *s, const double *from, double sense, double step,
                                   double *to)
{
    static const double node[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double direction[2] = {0.0, 0.0}, sum[2] = {0.0, 0.0};
    for (int stage = 0; stage < 4; stage++) {
        double at[2] = {from[0] + node[stage] * step * direction[0], from[1] + node[stage] * step * direction[1]};
        if (!pdi_streamline_compute_direction(s, at, sense, direction)) return 0;
        for (int d = 0; d < 2; d++) sum[d] += weight[stage] * direction[d];
    }
    for (int d = 0; d < 2; d++) to[d] = from[d] + step * sum[d];
    return pdi_streamline_compute_direction(s, to, sense, direction);
}

/* Append a point to the current line and to its bucket. */
static pd_status pdi_streamline_add_point(pdi_streamline_work *s, const double *point, double arc_length)
{
    pdi_streamlines *l = s->lines;
    if (l->point_count == l->point_capacity) {
        int64_t room = 2 * l->point_capacity + 1024;
        PD_TRY(PD_GROW(s->ctx, "streamline", 2 * l->point_capacity, 2 * room, l->point));
        l->point_capacity = room;
    }
    l->point[2 * l->point_count] = point[0];
    l->point[2 * l->point_count++ + 1] = point[1];
    return pdi_streamline_add_to_bucket(s, point, arc_length);
}

/* Returns 1 when the segment a-b passes beside the seed (its foot lies on the segment) nearer than
 * PDI_STREAMLINE_CLOSURE_DISTANCE times the spacing, so that the line is closed; else 0. */
static int pdi_streamline_is_passing_seed(const pdi_streamline_work *s, const double *seed, const double *a,
                                          const double *b)
{
    double dx = b[0] - a[0], dy = b[1] - a[1], x = seed[0] - a[0], y = seed[1] - a[1];
    double fraction = (x * dx + y * dy) / (dx * dx + dy * dy);
    if (!(fraction >= 0.0 && fraction <= 1.0)) return 0;
    return fabs(x * dy - y * dx) < PDI_STREAMLINE_CLOSURE_DISTANCE * s->field->spacing * pdi_canvas_hypot(dx, dy);
}

/* Returns 1 when along an axis a cell without fluid, or a closed side, lies at PDI_STREAMLINE_FACE_CLEARANCE times the
 * spacing on one side alone; a line there would be drawn on that face. In a gap, with one on both sides, 0. */
static int pdi_streamline_is_beside_face(const pdi_streamline_field *f, const double *position)
{
    for (int d = 0; d < 2; d++) {
        int blocked[2];
        for (int up = 0; up < 2; up++) {
            double to[2] = {position[0], position[1]};
            to[d] += (up ? 1 : -1) * PDI_STREAMLINE_FACE_CLEARANCE * f->spacing;
            blocked[up] = pdi_streamline_find_cell(f, (int)floor(to[0] / f->pixel_size[0]),
                                                   (int)floor(to[1] / f->pixel_size[1])) < 0;
        }
        if (blocked[0] != blocked[1]) return 1;
    }
    return 0;
}

/* Returns 1 when another line is nearer than `distance` [pixel], or in a mirrored field the mirror line, so y below
 * half of that; else 0. The current line does not count. */
static int pdi_streamline_is_crowded(const pdi_streamline_work *s, const double *position, double distance)
{
    return pdi_streamline_is_point_near(s, position, distance, 0, 0.0) ||
           (s->field->mirrored && position[1] < 0.5 * distance);
}

/* Trace the line from its seed downstream (sense 1) or upstream (-1) and append its points after the seed. *length
 * [pixel]: its length, *closed 1: it returns to the seed. It ends where steps halved six times still leave the fluid or
 * come to rest, or nearer than half the spacing to another line. Where it comes that near to itself it is traced on by
 * pi times the spacing, since it may close, and cut back there otherwise. */
static pd_status pdi_streamline_trace_half(pdi_streamline_work *s, const double *seed, double sense, double *length,
                                           int *closed)
{
    pdi_streamlines *l = s->lines;
    double at[2] = {seed[0], seed[1]}, to[2], step = s->step, near_self = HUGE_VAL;
    int64_t points = 0, marks = 0;
    *length = 0.0;
    *closed = 0;
    for (int64_t n = 1; step > s->step / (1 << PDI_STREAMLINE_MAX_HALVINGS); n++) {
        if (!pdi_streamline_step_rk4(s, at, sense, step, to)) {
            step *= 0.5;
            continue;
        }
        double arc_length = *length + step;
        if (pdi_streamline_is_crowded(s, to, PDI_STREAMLINE_MIN_DISTANCE * s->field->spacing)) break;
        *closed = arc_length > 4.0 * s->step && pdi_streamline_is_passing_seed(s, seed, at, to);
        if (*closed) {
            *length = arc_length;
            return pdi_streamline_add_point(s, seed, sense * arc_length);
        }
        if (near_self > arc_length &&
            pdi_streamline_is_point_near(s, to, PDI_STREAMLINE_MIN_DISTANCE * s->field->spacing, 1,
                                         sense * arc_length)) {
            near_self = arc_length;
            points = l->point_count;
            marks = s->bucket_point_count;
        }
        if (arc_length > near_self + PD_PI * s->field->spacing) break;
        memcpy(at, to, sizeof at);
        *length = arc_length;
        if (n % s->store_interval == 0 || step < s->step) PD_TRY(pdi_streamline_add_point(s, at, sense * arc_length));
    }
    if (!(near_self < HUGE_VAL)) return PD_OK;
    l->point_count = points;
    pdi_streamline_remove_from_buckets(s, marks);
    *length = near_self;
    return PD_OK;
}

/* Reverse the order of `count` points [2]. */
static void pdi_streamline_reverse_points(double *points, int64_t count)
{
    for (int64_t a = 0, b = count - 1; a < b; a++, b--)
        for (int d = 0; d < 2; d++) {
            double other = points[2 * a + d];
            points[2 * a + d] = points[2 * b + d];
            points[2 * b + d] = other;
        }
}

/* Trace a line through the seed in both directions and add it to the lines. PD_OK, and nothing is added: the fluid is
 * at rest at the seed, another line is nearer than the spacing, a face without flow is near on one side alone, or the
 * line is open and shorter than PDI_STREAMLINE_MIN_LENGTH times the spacing. */
static pd_status pdi_streamline_try_seed(pdi_streamline_work *s, const double *seed)
{
    pdi_streamlines *l = s->lines;
    int64_t first = l->point_count, marks = s->bucket_point_count;
    double direction[2], length[2] = {0.0, 0.0};
    int closed = 0;
    if (!pdi_streamline_compute_direction(s, seed, 1.0, direction) || pdi_streamline_is_beside_face(s->field, seed))
        return PD_OK;
    if (pdi_streamline_is_crowded(s, seed, s->field->spacing)) return PD_OK;
    if (l->count == l->capacity) {
        int64_t room = 2 * l->capacity + 64;
        PD_TRY(PD_GROW(s->ctx, "streamline", l->capacity, room, l->line));
        l->capacity = room;
    }
    PD_TRY(pdi_streamline_add_point(s, seed, 0.0));
    PD_TRY(pdi_streamline_trace_half(s, seed, -1.0, &length[0], &closed));
    pdi_streamline_reverse_points(&l->point[2 * first], l->point_count - first);
    if (!closed) PD_TRY(pdi_streamline_trace_half(s, seed, 1.0, &length[1], &closed));
    if (!closed && length[0] + length[1] < PDI_STREAMLINE_MIN_LENGTH * s->field->spacing) {
        l->point_count = first;
        pdi_streamline_remove_from_buckets(s, marks);
        return PD_OK;
    }
    l->line[l->count].first = first;
    l->line[l->count].count = l->point_count - first;
    l->line[l->count++].is_loop = closed;
    return PD_OK;
}

/* Try seeds at the distance of the spacing on both sides of each point, but the last, of all lines from index `from`
 * on, and of the lines that this adds. */
static pd_status pdi_streamline_seed_beside_lines(pdi_streamline_work *s, int64_t from)
{
    pdi_streamlines *l = s->lines;
    for (int64_t k = from; k < l->count; k++)
        for (int64_t p = l->line[k].first; p + 1 < l->line[k].first + l->line[k].count; p++)
            for (int side = -1; side <= 1; side += 2) {
                double dx = l->point[2 * p + 2] - l->point[2 * p], dy = l->point[2 * p + 3] - l->point[2 * p + 1];
                double out = side * s->field->spacing * (1.0 + 1e-6) / pdi_canvas_hypot(dx, dy);
                double seed[2] = {l->point[2 * p] - dy * out, l->point[2 * p + 1] + dx * out};
                PD_TRY(pdi_streamline_try_seed(s, seed));
            }
    return PD_OK;
}

/* Compute all lines: first through the middle of the cell `fastest` and beside it, then from a grid of seeds, half the
 * spacing apart, in what is not connected with these. */
static pd_status pdi_streamline_trace_all(pdi_streamline_work *s, int64_t fastest)
{
    const pdi_streamline_field *f = s->field;
    double seed[2] = {((double)(fastest % f->nx) + 0.5) * f->pixel_size[0],
                      ((double)(fastest / f->nx) + 0.5) * f->pixel_size[1]};
    PD_TRY(pdi_streamline_try_seed(s, seed));
    PD_TRY(pdi_streamline_seed_beside_lines(s, 0));
    for (int j = 0; j < 2 * s->rows; j++) /* regions that no line so far is connected with */
        for (int i = 0; i < 2 * s->columns; i++) {
            int64_t count = s->lines->count;
            seed[0] = (i + 0.5) * f->nx * f->pixel_size[0] / (2.0 * s->columns);
            seed[1] = (j + 0.5) * f->ny * f->pixel_size[1] / (2.0 * s->rows);
            PD_TRY(pdi_streamline_try_seed(s, seed));
            PD_TRY(pdi_streamline_seed_beside_lines(s, count));
        }
    return PD_OK;
}

PDI_FN pd_status pdi_streamlines_compute(pd_ctx *ctx, const pdi_streamline_field *f, pdi_streamlines *lines)
{
    pdi_streamline_work s;
    int64_t fastest;
    memset(&s, 0, sizeof s);
    s.ctx = ctx;
    s.field = f;
    s.lines = lines;
    s.min_speed = PDI_STREAMLINE_MIN_SPEED * pdi_streamline_find_fastest_cell(f, &fastest);
    if (fastest < 0) return PD_OK;
    s.step = pd_min(f->spacing / PDI_STREAMLINE_MIN_STEPS,
                    PDI_STREAMLINE_MAX_STEP * pd_min(f->pixel_size[0], f->pixel_size[1]));
    s.step = pd_max(f->spacing / PDI_STREAMLINE_MAX_STEPS, s.step);
    s.store_interval = (int)pd_max(1.0, floor(f->spacing / PDI_STREAMLINE_STORED_POINTS / s.step));
    s.columns = (int)ceil(f->nx * f->pixel_size[0] / f->spacing);
    s.rows = (int)ceil(f->ny * f->pixel_size[1] / f->spacing);
    int64_t squares = (int64_t)s.columns * s.rows;
    PD_TRY(PD_NEW(ctx, "streamline", squares, s.bucket_head));
    for (int64_t k = 0; k < squares; k++) s.bucket_head[k] = -1;
    pd_status status = pdi_streamline_trace_all(&s, fastest);
    PD_DELETE(ctx, squares, s.bucket_head);
    PD_DELETE(ctx, s.bucket_point_capacity, s.bucket_point);
    return status;
}

PDI_FN void pdi_streamlines_free(pd_ctx *ctx, pdi_streamlines *lines)
{
    PD_DELETE(ctx, lines->capacity, lines->line);
    PD_DELETE(ctx, 2 * lines->point_capacity, lines->point);
    memset(lines, 0, sizeof *lines);
}

#undef PDI_STREAMLINE_MIN_DISTANCE
#undef PDI_STREAMLINE_MIN_SPEED
#undef PDI_STREAMLINE_CLOSURE_DISTANCE
#undef PDI_STREAMLINE_MIN_LENGTH
#undef PDI_STREAMLINE_FACE_CLEARANCE
#undef PDI_STREAMLINE_MAX_STEP
#undef PDI_STREAMLINE_MIN_STEPS
#undef PDI_STREAMLINE_MAX_STEPS
#undef PDI_STREAMLINE_STORED_POINTS
#undef PDI_STREAMLINE_MAX_HALVINGS
