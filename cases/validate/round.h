/* round: cases of plates and tubes with round surfaces that cut cells. */
#ifndef VAL_ROUND_H
#define VAL_ROUND_H
#include "../elasticity.h"
#include "case.h"

#if PD_DIM == 2
#define CUTS_COLUMN "whole 0, part 1, middle 2, rim 3"

/* ---- kirsch ---- */

/* Stress along the ligament over that far away (data: kirsch_profile). */
static const double kirsch_table[8][2] = {{1.05, 2.6875685}, {1.1, 2.4377433}, {1.2, 2.0706019}, {1.3, 1.8210497},
                                          {1.5, 1.5185185},  {2.0, 1.21875},   {3.0, 1.0740741}, {5.0, 1.0224}};

/* Stress [1] at the place r of the ligament, by the cubic through four cells; h: their width. Columns beside the
 * ligament are its mirror images: one is enough. */
static double kirsch_at(const val_solid *s, double r, double h)
{
    double y[4] = {0.0}, f[4] = {0.0}, sum = 0.0;
    int count = 0;
    for (int32_t i = 0; i < s->body.count && count < 4; i++) { /* rows of a column come in their order */
        const double *x = s->position + i * 2;
        if (x[0] < 0.0 || x[0] > h || x[1] < 1.0 || x[1] < r - 2.0 * h) continue;
        y[count] = x[1];
        f[count++] = s->stress[i * 4];
    }
    for (int a = 0; a < count; a++) {
        double part = f[a];
        for (int b = 0; b < count; b++) part *= a == b ? 1.0 : (r - y[b]) / (y[a] - y[b]);
        sum += part;
    }
    return sum;
}

/* Errors along the ligament: of the first cell, of the third, of all beyond the sixth. */
static void kirsch_ligament(val_job *job, double h)
{
    const val_solid *s = &job->lab->solid;
    if (job->level.m < 1.5 || job->level.p > 2.5) job->profile = NULL; /* one figure is enough */
    val_curve *exact = val_add_curve(job, "Kirsch", PD_SERIES_STYLE_LINE);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
    if (job->profile) {
        job->profile->title = "stress beside a hole, over that far away";
        job->profile->x_label = "r/a [-]";
        job->profile->y_label = "hoop stress [-]";
    }
    for (int k = 0; k <= 200; k++) {
        double x[2] = {0.0, 1.0 + 2.0 * k / 200.0};
        val_add_point(exact, x[1], elasticity_kirsch_stress(x));
    }
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + i * 2;
        if (x[0] < 0.0 || x[0] > h || x[1] < 0.0 || s->held[i * 2]) continue;
        double wanted = elasticity_kirsch_stress(x), cell = (x[1] - 1.0) / h;
        double off = fabs(s->stress[i * 4] / wanted - 1.0);
        int at = cell < 1.0 ? 1 : cell > 2.0 && cell < 3.0 ? 2 : cell > 6.0 ? 3 : 0;
        if (at) job->out->err[at] = fmax(job->out->err[at], off);
        if (x[1] < 3.0) val_add_point(found, x[1], s->stress[i * 4]);
    }
}

/* A plate of three radii around a hole, whose rim has Kirsch's displacements. */
static pd_status kirsch_run(val_job *job)
{
    val_solid *s = &job->lab->solid;
    solid_round hole = {1.0, HUGE_VAL, solid_cut_of(job->level.p)};
    double h = 1.0 / job->level.n, m = job->level.m, half = 3.0, lo[2] = {-3.0, -3.0};
    val_squares sum = {0.0, 0.0};
    int n[2] = {6 * job->level.n, 6 * job->level.n};
    if (job->level.p > 2.5) s->desc.rim = PD_PARTIAL_VOLUME_EXACT;
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, m, solid_round_part, &hole));
    s->metal.young = 1.0;
    s->metal.poisson = 0.3;
    s->metal.plane = PD_PLANE_STRESS;
    PD_TRY(solid_elastic(job->ctx, s));
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + i * 2;
        elasticity_kirsch(x, 0.3, s->u + i * 2);
        s->held[i * 2] = s->held[i * 2 + 1] = fmax(fabs(x[0]), fabs(x[1])) > half - (2.0 * m + 1.0) * h;
        if (!s->held[i * 2]) s->u[i * 2] = s->u[i * 2 + 1] = 0.0;
    }
    PD_TRY(solid_rest(job->ctx, s));
    for (int32_t i = 0; i < s->body.count; i++) {
        double exact[2];
        elasticity_kirsch(s->position + i * 2, 0.3, exact);
        for (int d = 0; d < 2; d++) val_squares_add(&sum, s->volume[i], s->u[i * 2 + d], exact[d]);
    }
    job->out->h = h;
    job->out->err[0] = val_squares_l2(&sum);
    kirsch_ligament(job, h);
    for (int k = 0; k < 8; k++) {
        double r = kirsch_table[k][0];
        if (r > 1.15 && r < 2.5)
            job->out->err[4] = fmax(job->out->err[4], fabs(kirsch_at(s, r, h) / kirsch_table[k][1] - 1.0));
    }
    job->out->evals = s->iterations;
    return PD_OK;
}

#define KIRSCH_MEASURES \
    {{"err_u", "u, rms"}, {"err_first", "stress, first cell"}, {"err_third", "third cell"}, \
     {"err_far", "beyond six cells"}, {"err_table", "stress at 1.2 to 2 radii"}}, 5

static const val_part kirsch_middles = {
    "middles", "cut cells with the middle of their part", "cells to the radius", VAL_BY_N, NULL, 1.0, KIRSCH_MEASURES,
    {{4, 1e-2, 0.0, 24, VAL_GOAL}, {4, 0.0, 1.0, 0, VAL_GOAL}, {4, 5e-2, 0.0, 0, VAL_GUARD}}, 3,
    {{12, 2.0, 2.0}, {24, 2.0, 2.0}, {48, 2.0, 2.0}}, 3, 2, kirsch_run, NULL};
static const val_part kirsch_nearest = {
    "nearest", "the same with the nearest neighbours, m = 1", "cells to the radius", VAL_BY_N, NULL, 1.0,
    KIRSCH_MEASURES,
    {{4, 1e-2, 0.0, 24, VAL_GOAL}, {4, 0.0, 1.0, 0, VAL_GOAL_OF_ALL}, {4, 3e-2, 0.0, 0, VAL_GUARD}}, 3,
    {{12, 1.0, 2.0}, {24, 1.0, 2.0}, {48, 1.0, 2.0}}, 3, 2, kirsch_run, NULL};
static const val_part kirsch_cuts = {
    "cuts", "kinds of cells at the surface, 24 to the radius", CUTS_COLUMN, VAL_BY_P, "kind", 0.0,
    KIRSCH_MEASURES, {{4, 1e-1, 0.0, 0, VAL_GUARD}}, 1,
    {{24, 2.0, 0.0}, {24, 2.0, 1.0}, {24, 2.0, 2.0}, {24, 2.0, 3.0}}, 4, 0, kirsch_run, NULL};
static const val_part *const kirsch_parts[] = {&kirsch_middles, &kirsch_nearest, &kirsch_cuts};

static const val_case kirsch_case = {
    "kirsch", "A plate with a hole",
    "A plate in plane stress around a hole; where it ends, at three radii, it has the displacements of an infinite "
    "plate that is pulled. Displacements, and the stress along the ligament: in the cell next to the hole, in the "
    "third cell, in all beyond the sixth, and at 1.2 to 2 radii. Cells that the hole cuts count wholly (0), with their "
    "part (1), and in its middle (2); 3: with exact parts of cells at the rim of horizons, too.",
    "A stress that is right in the bulk and wrong at a curved surface, a surface that lies a part of a cell off.",
    "Kirsch 1898: closed form (data: kirsch_profile)",
    kirsch_parts, 3};
/* ---- lame ---- */

/* A ring of radii 1 and 2 under pressure inside, plane strain, that nothing holds. */
static pd_status lame_rest(val_job *job, double yield, double pressure, int steps)
{
    val_solid *s = &job->lab->solid;
    solid_round ring = {1.0, 2.0, solid_cut_of(job->level.p)};
    double h = 1.0 / job->level.n, lo[2] = {-2.0, -2.0};
    int n[2] = {4 * job->level.n, 4 * job->level.n};
    if (job->level.p > 2.5) s->desc.rim = PD_PARTIAL_VOLUME_EXACT;
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, solid_round_part, &ring));
    s->metal.young = 1.0;
    s->metal.poisson = 0.3;
    s->metal.yield = yield;
    PD_TRY(solid_elastic(job->ctx, s));
    for (int k = 1; k <= steps; k++) {
        for (int32_t i = 0; i < s->body.count; i++) {
            const double *x = s->position + i * 2, *edge = s->elastic.surface_vector + i * 2;
            double r = solid_radius(x), push = (x[0] * edge[0] + x[1] * edge[1]) / r;
            for (int d = 0; d < 2; d++) s->load[i * 2 + d] = r < 1.5 ? pressure * k / steps * push * x[d] / r : 0.0;
        }
        PD_TRY(solid_rest(job->ctx, s));
        if (s->table.commit) PD_TRY(s->table.commit(job->ctx, s->table.self, s->u));
    }
    job->out->h = h;
    job->out->evals = s->iterations;
    return PD_OK;
}

/* Radial displacement and hoop stress of point i; the body moves as a whole by shift. */
static void lame_polar(const val_solid *s, int32_t i, const double *shift, double *u, double *hoop)
{
    const double *x = s->position + i * 2, *p = s->stress + i * 4;
    double r = solid_radius(x), c = x[0] / r, t = x[1] / r;
    *u = (s->u[i * 2] - shift[0]) * c + (s->u[i * 2 + 1] - shift[1]) * t;
    *hoop = t * t * p[0] - c * t * (p[1] + p[2]) + c * c * p[3];
}

static void lame_shift(const val_solid *s, double *shift)
{
    double volume = 0.0;
    shift[0] = shift[1] = 0.0;
    for (int32_t i = 0; i < s->body.count; i++) {
        volume += s->volume[i];
        for (int d = 0; d < 2; d++) shift[d] += s->volume[i] * s->u[i * 2 + d];
    }
    for (int d = 0; d < 2; d++) shift[d] /= volume;
}

static pd_status lame_run(val_job *job)
{
    const val_solid *s = &job->lab->solid;
    double shift[2], sum[5] = {0.0}, size[5] = {0.0}, u, hoop;
    PD_TRY(lame_rest(job, 0.0, 1.0, 1));
    lame_shift(s, shift);
    for (int32_t i = 0; i < s->body.count; i++) {
        double r = solid_radius(s->position + i * 2), v = s->volume[i];
        double wanted = elasticity_lame(r, 0.3, PD_PLANE_STRAIN), stress = (1.0 + 4.0 / (r * r)) / 3.0;
        lame_polar(s, i, shift, &u, &hoop);
        for (int k = 0; k < 5; k++) {
            int near = k == 1 ? r < 1.0 + job->out->h : r > 2.0 - job->out->h;
            double off = k < 3 ? u / wanted - 1.0 : hoop / stress - 1.0;
            if (k == 4) near = r < 1.0 + job->out->h;
            if (k == 0 || k == 3) sum[k] += v * off * off;
            else if (near) sum[k] += v * off;
            if (k == 0 || k == 3 || near) size[k] += v;
        }
    }
    for (int k = 0; k < 5; k++)
        job->out->err[k] = k == 0 || k == 3 ? sqrt(sum[k] / size[k]) : fabs(sum[k] / size[k]);
    return PD_OK;
}

#define LAME_MEASURES \
    {{"err_u", "u, rms"}, {"err_inner", "u at the bore"}, {"err_outer", "u outside"}, \
     {"err_hoop", "hoop stress, rms"}, {"err_bore", "hoop stress, first cells"}}, 5
#define LAME_GOALS \
    {{1, 1e-2, 0.0, 32, VAL_GOAL}, {2, 1e-2, 0.0, 32, VAL_GOAL}, {3, 1e-2, 0.0, 32, VAL_GOAL}, \
     {0, 0.0, 1.0, 0, VAL_GOAL}, {0, 5e-2, 0.0, 0, VAL_GUARD}}, 5

static const val_part lame_two = {
    "2", "m = 2", "cells across", VAL_BY_N, NULL, 1.0, LAME_MEASURES, LAME_GOALS,
    {{16, 2.0, 2.0}, {32, 2.0, 2.0}, {64, 2.0, 2.0}}, 3, 2, lame_run, NULL};
static const val_part lame_one = {
    "1", "the same with the nearest neighbours, m = 1", "cells across", VAL_BY_N, NULL, 1.0, LAME_MEASURES, LAME_GOALS,
    {{16, 1.0, 2.0}, {32, 1.0, 2.0}, {64, 1.0, 2.0}}, 3, 2, lame_run, NULL};
static const val_part lame_cuts = {
    "cuts", "kinds of cells at the surface, 16 across", CUTS_COLUMN, VAL_BY_P, "kind", 0.0,
    LAME_MEASURES, {{0, 1e-1, 0.0, 0, VAL_GUARD}}, 1,
    {{16, 2.0, 0.0}, {16, 2.0, 1.0}, {16, 2.0, 2.0}, {16, 2.0, 3.0}}, 4, 0, lame_run, NULL};
static const val_part *const lame_parts[] = {&lame_two, &lame_one, &lame_cuts};

static const val_case lame_case = {
    "lame", "A thick tube under pressure",
    "A tube of radii 1 and 2 in plane strain with a Poisson's ratio of 0.3, which pressure widens and nothing holds: "
    "displacements along the radius, over all and next to both surfaces, and the hoop stress. Kinds of cells are those "
    "of kirsch.",
    "Pressure that acts a part of a cell off the bore, a wall that is too thin by the cells it cuts.",
    "Lame's closed form (data: lame_cylinder)",
    lame_parts, 3};

/* ---- hill ---- */

/* Metal flows up to r = 1.5. */
static pd_status hill_run(val_job *job)
{
    const val_solid *s = &job->lab->solid;
    double shift[2], k = 1e-3, flows = 1.5, sum[2] = {0.0}, size[2] = {0.0}, u, hoop;
    PD_TRY(lame_rest(job, k * sqrt(3.0), k * elasticity_hill_pressure(flows), 3));
    lame_shift(s, shift);
    for (int32_t i = 0; i < s->body.count; i++) {
        double r = solid_radius(s->position + i * 2), v = s->volume[i], wanted = k * elasticity_hill(r, flows, 0.3);
        double stress = k * (2.25 / (r * r) + 2.25 / 4.0); /* beyond the metal that flows */
        lame_polar(s, i, shift, &u, &hoop);
        for (int q = 0; q < 2; q++) {
            if (r < (q ? 1.6 : 1.8)) continue;
            sum[q] += v * fabs(q ? hoop / stress - 1.0 : u / wanted - 1.0);
            size[q] += v;
        }
    }
    for (int q = 0; q < 2; q++) job->out->err[q] = sum[q] / size[q];
    return PD_OK;
}

static const val_part hill_part = {
    "", "", "cells across", VAL_BY_N, NULL, 1.0,
    {{"err_u", "u, beyond r = 1.8"}, {"err_hoop", "hoop stress, beyond 1.6"}}, 2,
    {{0, 1e-2, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, 16, VAL_GOAL}}, 2,
    {{8, 2.0, 2.0}, {16, 2.0, 2.0}, {32, 2.0, 2.0}}, 3, 2, hill_run, NULL};
static const val_part *const hill_parts[] = {&hill_part};
static const val_case hill_case = {
    "hill", "A tube whose metal flows",
    "The same tube of metal that does not harden, under the pressure at which the inner half of the wall flows, "
    "reached in three steps: mean errors in the part that stays elastic.",
    "A yield stress of another criterion, strain across the plane that is forgotten, metal that hardens by the "
    "lattice.",
    "Hill 1950, ch. 5: closed form",
    hill_parts, 1};
#endif

#endif
