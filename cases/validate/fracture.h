/* fracture: cases of cracks: J and the energy that they release, specimens, a crack that runs and branches. */
#ifndef VAL_FRACTURE_H
#define VAL_FRACTURE_H
#include "../elasticity.h"
#include "../strip.h"
#include "case.h"

#if PD_DIM == 2
/* Place or vector in the axes of the crack; back: from them. */
static void crack_local(const pd_crack_desc *crack, const double *x, double *y)
{
    double a = x[0] - crack->tip[0], b = x[1] - crack->tip[1];
    y[0] = a * crack->direction[0] + b * crack->direction[1];
    y[1] = b * crack->direction[0] - a * crack->direction[1];
}

/* The bonds that cross a crack of this length [m] break. */
static pd_status crack_cut(val_job *job, const pd_crack_desc *crack, double length)
{
    double corners[4] = {crack->tip[0] - length * crack->direction[0], crack->tip[1] - length * crack->direction[1],
                         crack->tip[0], crack->tip[1]};
    pd_precrack cut = {2, corners};
    return pd_body_apply_precracks(job->ctx, &job->lab->solid.body, &cut, 1, NULL);
}

/* The mean of J over `count` pairs of radii from 0.15 and 0.45 of `size` on, and by how much of it they differ. */
static pd_status crack_contours(val_job *job, pd_crack_desc *crack, int count, double size, double *mean,
                                double *spread)
{
    const val_solid *s = &job->lab->solid;
    double least = HUGE_VAL, most = -HUGE_VAL, j;
    *mean = 0.0;
    for (int n = 0; n < count; n++) {
        crack->inner = size * (0.15 + 0.1 * n);
        crack->outer = size * (0.45 + 0.1 * n);
        PD_TRY(pd_crack_j(job->ctx, &s->table, crack, s->u, &j));
        least = fmin(least, j);
        most = fmax(most, j);
        *mean += j / count;
    }
    *spread = (most - least) / fabs(*mean);
    return PD_OK;
}

/* ---- crack ---- */

/* The displacements of a crack with K = 1e-3 that ends in the middle of a plate of 2 by 2, in plane stress, at its rim;
 * the crack that is cut there is `further` [cells] longer. */
static pd_status crack_plate(val_job *job, double angle, int springs, double further, pd_crack_desc *crack)
{
    val_solid *s = &job->lab->solid;
    static const double k[2] = {1e-3, 0.0};
    double h = 1.0 / job->level.n, lo[2] = {-1.0, -1.0}, y[2], v[2];
    int n[2] = {2 * job->level.n, 2 * job->level.n};
    solid_free(job->ctx, s);
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, NULL, NULL));
    s->metal.young = s->spring.young = 1.0;
    s->metal.poisson = 1.0 / 3.0;
    s->metal.plane = s->spring.plane = PD_PLANE_STRESS;
    memset(crack, 0, sizeof *crack);
    crack->direction[0] = cos(angle);
    crack->direction[1] = sin(angle);
    crack->tip[0] = 0.013 * h; /* no bond passes the tip itself */
    crack->tip[1] = 0.007 * h;
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + i * 2;
        if (fmax(fabs(x[0]), fabs(x[1])) < 1.0 - 2.0 * job->level.m * h) continue;
        crack_local(crack, x, y);
        elasticity_williams(y, 1.0 / 3.0, PD_PLANE_STRESS, k, v);
        s->u[i * 2] = v[0] * crack->direction[0] - v[1] * crack->direction[1];
        s->u[i * 2 + 1] = v[0] * crack->direction[1] + v[1] * crack->direction[0];
        s->held[i * 2] = s->held[i * 2 + 1] = 1;
    }
    for (int d = 0; d < 2; d++) crack->tip[d] += further * h * crack->direction[d];
    PD_TRY(crack_cut(job, crack, 9.0));
    PD_TRY(springs ? solid_springs(job->ctx, s) : solid_elastic(job->ctx, s));
    job->out->h = h;
    return solid_rest(job->ctx, s);
}

/* What a cut through `columns` more columns of bonds sets free, and the mean of J before and after, over K^2/E'; the
 * larger difference of contours. */
static pd_status crack_release(val_job *job, double angle, int springs, double columns, double *g, double *j,
                               double *spread)
{
    const val_solid *s = &job->lab->solid;
    double energy[2], one, differ;
    pd_crack_desc crack;
    *j = *spread = 0.0;
    for (int n = 0; n < 2; n++) {
        PD_TRY(crack_plate(job, angle, springs, (n - 0.5) * columns, &crack));
        energy[n] = s->table.energy(job->ctx, s->table.self, s->u);
        PD_TRY(crack_contours(job, &crack, 4, 1.0, &one, &differ));
        *spread = fmax(*spread, differ);
        *j += 0.5 * one / 1e-6;
    }
    *g = (energy[0] - energy[1]) / (columns * job->out->h) / 1e-6;
    return PD_OK;
}

/* Straight along a row. */
static pd_status crack_run(val_job *job)
{
    double *err = job->out->err, spread, j, g;
    for (int springs = 0; springs < 2; springs++) {
        PD_TRY(crack_release(job, 0.0, springs, 1.0, &g, &j, &spread));
        err[springs] = fabs(j - 1.0);
        err[2] = fmax(err[2], spread);
        err[3] = fmax(err[3], fabs(g - 1.0));
        err[4] = fmax(err[4], fabs(g / j - 1.0));
    }
    return PD_OK;
}

/* In a direction of the lattice. */
static pd_status crack_way_run(val_job *job)
{
    double *err = job->out->err, spread, j, g, angle = job->level.p * val_pi / 180.0;
    pd_crack_desc crack;
    double columns = job->level.p > 40.0 ? 6.0 * sqrt(2.0) : 8.0; /* rows of 45 degrees repeat with sqrt(2) cells */
    for (int springs = 0; springs < 2; springs++) {
        PD_TRY(crack_plate(job, angle, springs, 0.0, &crack));
        PD_TRY(crack_contours(job, &crack, 4, 1.0, &j, &spread));
        err[springs] = fabs(j / 1e-6 - 1.0);
        err[2] = fmax(err[2], spread);
        PD_TRY(crack_release(job, angle, springs, columns, &g, &j, &spread));
        err[3 + springs] = fabs(g - 1.0);
    }
    return PD_OK;
}

static const val_part crack_order = {
    "order", "along a row", "cells from tip to rim", VAL_BY_N, NULL, 1.0,
    {{"err_elastic", "J, small strains"}, {"err_springs", "J, springs"}, {"spread", "contours differ"},
     {"err_release", "energy of a column"}, {"err_column", "that over J"}}, 5,
    {{0, 1e-2, 0.0, 80, VAL_GOAL}, {1, 1e-2, 0.0, 80, VAL_GOAL}, {2, 1e-3, 0.0, 40, VAL_GOAL},
     {3, 1e-2, 0.0, 80, VAL_GOAL}, {4, 5e-3, 0.0, 20, VAL_GOAL}, {0, 0.0, 0.9, 0, VAL_GOAL}}, 6,
    {{10, 2.0, 0.0}, {20, 2.0, 0.0}, {40, 2.0, 0.0}, {80, 2.0, 0.0}}, 4, 2, crack_run, NULL};
static const val_part crack_ways = {
    "ways", "in directions of the lattice, 40 cells from tip to rim", "degrees", VAL_BY_P, "degrees", 0.0,
    {{"err_elastic", "J, small strains"}, {"err_springs", "J, springs"}, {"spread", "contours differ"},
     {"release_elastic", "energy of a cut"}, {"release_springs", "the same of springs"}}, 5,
    {{0, 2e-2, 0.0, 0, VAL_GOAL}, {1, 2e-2, 0.0, 0, VAL_GOAL}, {2, 1e-3, 0.0, 0, VAL_GOAL},
     {3, 5e-2, 0.0, 0, VAL_GOAL}, {4, 5e-2, 0.0, 0, VAL_GOAL}}, 5,
    {{40, 2.0, 0.0}, {40, 2.0, 15.0}, {40, 2.0, 30.0}, {40, 2.0, 45.0}}, 4, 0, crack_way_run, NULL};
static const val_part *const crack_parts[] = {&crack_order, &crack_ways};

static const val_case crack_case = {
    "crack", "Energy release of a crack",
    "A crack in mode I ends in the middle of a plate in plane stress, whose rim has the displacements of the closed "
    "form. J over four contours, along a row the mean of before and after the cut, and the energy that a cut through "
    "one more column of bonds sets free (in directions of the lattice through eight cells, at 45 degrees through six "
    "diagonals), against K^2/E'; for small strains and for springs.",
    "A J that depends on its contour or on the direction of the lattice, bonds across the crack that count half, an "
    "energy that is not the one that forces follow from.",
    "Williams 1957, Irwin: J = G = K^2/E'",
    crack_parts, 2};

/* ---- specimens ---- */

/* J over K^2/E' of the handbook in a strip of width 1 and length 3 that is pulled, with a crack through half of it. */
static pd_status specimen_strip(val_job *job, int cells, double *ratio, double *spread)
{
    val_solid *s = &job->lab->solid;
    double h = 1.0 / cells, lo[2] = {-0.5, -1.5}, k;
    int n[2] = {cells, 3 * cells};
    pd_crack_desc crack;
    memset(&crack, 0, sizeof crack);
    crack.direction[0] = 1.0;
    crack.tip[0] = 0.013 * h;
    crack.tip[1] = 0.007 * h;
    solid_free(job->ctx, s);
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, NULL, NULL));
    PD_TRY(crack_cut(job, &crack, 1.0));
    s->metal.young = 1.0;
    s->metal.poisson = 0.3;
    s->metal.plane = PD_PLANE_STRESS;
    PD_TRY(solid_elastic(job->ctx, s));
    for (int32_t i = 0; i < s->body.count; i++)
        if (fabs(s->position[i * 2 + 1]) > 1.0) s->load[i * 2 + 1] = -s->elastic.surface_vector[i * 2 + 1];
    PD_TRY(solid_rest(job->ctx, s));
    PD_TRY(crack_contours(job, &crack, 2, 0.7, ratio, spread));
    k = elasticity_edge_notch(0.5 + crack.tip[0]);
    *ratio /= k * k;
    return PD_OK;
}

/* The same of a compact specimen of width 1, its pins pulled apart, cells to its width. */
static pd_status specimen_compact(val_job *job, int cells, double *ratio, double *spread)
{
    val_solid *s = &job->lab->solid;
    double h = 1.0 / cells, lo[2] = {-0.25, -0.6}, pull = 0.0, k; /* the pins stand at x = 0 */
    int n[2] = {5 * cells / 4, 6 * cells / 5};
    pd_crack_desc crack;
    memset(&crack, 0, sizeof crack);
    crack.direction[0] = 1.0;
    crack.tip[0] = 0.5 + 0.013 * h;
    crack.tip[1] = 0.007 * h;
    solid_free(job->ctx, s);
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, NULL, NULL));
    PD_TRY(crack_cut(job, &crack, 2.0));
    s->metal.young = 1.0;
    s->metal.poisson = 0.3;
    s->metal.plane = PD_PLANE_STRESS;
    PD_TRY(solid_elastic(job->ctx, s));
    for (int32_t i = 0; i < s->body.count; i++) {
        double x = s->position[i * 2], y = s->position[i * 2 + 1];
        if (x * x + (fabs(y) - 0.275) * (fabs(y) - 0.275) > 0.125 * 0.125) continue;
        s->load[i * 2 + 1] = y > 0.0 ? 1.0 : -1.0;
        if (y > 0.0) pull += s->volume[i];
    }
    PD_TRY(solid_rest(job->ctx, s));
    PD_TRY(crack_contours(job, &crack, 2, 0.5, ratio, spread));
    k = pull * elasticity_compact(crack.tip[0]);
    *ratio /= k * k;
    return PD_OK;
}

/* K by J, of cells h, and by the straight line through those of h and 2 h. */
static pd_status specimen_run(val_job *job)
{
    double fine, coarse, spread;
    int n = job->level.n;
    if (job->level.p < 0.5) {
        PD_TRY(specimen_strip(job, n / 2, &coarse, &spread));
        PD_TRY(specimen_strip(job, n, &fine, &spread));
    } else {
        PD_TRY(specimen_compact(job, n / 2, &coarse, &spread));
        PD_TRY(specimen_compact(job, n, &fine, &spread));
    }
    job->out->h = 1.0 / n;
    job->out->err[0] = fabs(sqrt(fine) - 1.0);
    job->out->err[1] = fabs(sqrt(2.0 * fine - coarse) - 1.0);
    job->out->err[2] = spread;
    return PD_OK;
}

#define SPECIMEN_MEASURES {{"err_k", "K"}, {"err_extrapolated", "K, extrapolated"}, {"spread", "contours differ"}}, 3
#define SPECIMEN_GOALS \
    {{0, 1e-2, 0.0, 160, VAL_GOAL}, {1, 1e-2, 0.0, 40, VAL_GOAL}, {1, 5e-3, 0.0, 160, VAL_GOAL}, \
     {2, 1e-2, 0.0, 40, VAL_GOAL}, {0, 0.0, 0.9, 0, VAL_GOAL}}, 5

static const val_part specimen_notch = {
    "notch", "a strip with an edge notch of half its width", "cells across", VAL_BY_N, NULL, 1.0, SPECIMEN_MEASURES,
    SPECIMEN_GOALS, {{40, 2.0, 0.0}, {80, 2.0, 0.0}, {160, 2.0, 0.0}}, 3, 2, specimen_run, NULL};
static const val_part specimen_pins = {
    "compact", "a compact specimen", "cells to its width", VAL_BY_N, NULL, 1.0, SPECIMEN_MEASURES, SPECIMEN_GOALS,
    {{40, 2.0, 1.0}, {80, 2.0, 1.0}, {160, 2.0, 1.0}}, 3, 2, specimen_run, NULL};
static const val_part *const specimen_parts[] = {&specimen_notch, &specimen_pins};

static const val_case specimen_case = {
    "specimen", "Stress intensities of specimens",
    "K from J, of small strains in plane stress, as it is and by the straight line through the J of cells of h and "
    "2 h.",
    "A tip that lies off by a part of a cell, tractions and pins with a wrong sum or moment.",
    "Tada, Paris and Irwin 2000, 2.10; ASTM E 399: both to 0.5 %",
    specimen_parts, 2};
#endif

#if PD_DIM > 1
/* ---- toughness ---- */

/* A strip of 16 um between its grips, n cells high and p layers thick in 3D, of a metal whose cracks take 0.06 J/m2. */
static pd_status toughness_strip(val_job *job, double nu, int layers)
{
    char solid[64];
    double j, closed;
    strip_case strip = {job->level.n, layers, strip_stiffness(nu), solid};
    snprintf(solid, sizeof solid, "nu = %g  m = %g", nu, job->level.m);
    PD_TRY(strip_run(job->ctx, &strip, &j, &closed));
    job->out->h = STRIP_HIGH / job->level.n;
    job->out->err[0] = fabs(j - 1.0);
    return PD_OK;
}

#if PD_DIM == 2
static pd_status toughness_run(val_job *job) { return toughness_strip(job, job->level.p, 0); }

static const val_part toughness_cells = {
    "cells", "m = 2, nu = 0.3, finer cells", "cells from grip to grip", VAL_BY_N, NULL, 0.0,
    {{"toughness", "J at which it runs"}}, 1, {{0, 0.05, 0.0, 0, VAL_GOAL}}, 1,
    {{16, 2.0, 0.3}, {24, 2.0, 0.3}, {32, 2.0, 0.3}, {48, 2.0, 0.3}}, 4, 1, toughness_run, NULL};
static const val_part toughness_ratios = {
    "ratios", "m = 2, 24 cells, Poisson's ratio", "nu", VAL_BY_P, NULL, 0.0,
    {{"toughness", "J at which it runs"}}, 1, {{0, 0.05, 0.0, 0, VAL_GOAL}}, 1,
    {{24, 2.0, 0.0}, {24, 2.0, 0.2}, {24, 2.0, 0.4}, {24, 2.0, 0.45}}, 4, 1, toughness_run, NULL};
static const val_part toughness_horizons = {
    "horizons", "24 cells, nu = 0.3, horizon", "m", VAL_BY_M, NULL, 0.0,
    {{"toughness", "J at which it runs"}}, 1, {{0, 0.05, 0.0, 0, VAL_GOAL}}, 1,
    {{24, 1.0, 0.3}, {24, 1.5, 0.3}, {24, 2.5, 0.3}, {24, 3.0, 0.3}}, 4, 1, toughness_run, NULL};
static const val_part *const toughness_parts[] = {&toughness_cells, &toughness_ratios, &toughness_horizons};
#else
static pd_status toughness_ratio_run(val_job *job) { return toughness_strip(job, job->level.p, 5); }
static pd_status toughness_layers_run(val_job *job) { return toughness_strip(job, 0.3, (int)job->level.p); }
static pd_status toughness_horizon_run(val_job *job) { return toughness_strip(job, 0.3, 4); }

static const val_part toughness_ratios = {
    "ratios", "m = 2, 16 cells, 5 layers between free sides, Poisson's ratio", "nu", VAL_BY_P, NULL, 0.0,
    {{"toughness", "J at which it runs"}}, 1, {{0, 0.05, 0.0, 0, VAL_GOAL}}, 1,
    {{16, 2.0, 0.0}, {16, 2.0, 0.3}, {16, 2.0, 0.45}}, 3, 0, toughness_ratio_run, NULL};
static const val_part toughness_layers = {
    "layers", "m = 2, 16 cells, nu = 0.3, layers between free sides", "layers", VAL_BY_P, NULL, 0.0,
    {{"toughness", "J at which it runs"}}, 1, {{0, 0.05, 0.0, 0, VAL_GOAL}}, 1,
    {{16, 2.0, 3}, {16, 2.0, 8}}, 2, 0, toughness_layers_run,
    "three layers are one and a half horizons: sides, whose bonds hold more energy and break earlier"};
static const val_part toughness_horizons = {
    "horizons", "16 cells, nu = 0.3, 4 layers between free sides, horizon", "m", VAL_BY_M, NULL, 0.0,
    {{"toughness", "J at which it runs"}}, 1, {{0, 0.05, 0.0, 0, VAL_GOAL}}, 1,
    {{16, 1.5, 0.3}}, 1, 1, toughness_horizon_run, NULL};
static const val_part *const toughness_parts[] = {&toughness_ratios, &toughness_layers, &toughness_horizons};
#endif

static const val_case toughness_case = {
    "toughness", "Energy at which a crack runs",
    "A strip with a cut whose edges are pulled apart, at rest, as a scene with `toughness`: the largest J, by the "
    "domain integral, that the crack bears before it has gone on by 6 um, over the toughness. In 3D the front of the "
    "crack, straight at first, ends at two free sides, and nothing moves along it.",
    "A critical energy of bonds that is that of a cut and not of a crack that runs, or one that depends on the "
    "spacing, on Poisson's ratio or on the horizon; in 3D that of a front that cannot go on by steps.",
    "the toughness that the scene asks for; J of Rice 1968",
    toughness_parts, (int)(sizeof toughness_parts / sizeof toughness_parts[0])};
#endif

#if PD_DIM == 2
/* ---- branching ---- */

/* Points of the crack, the farthest of them, whether it has two branches. */
static double branching_tip(const val_solid *s, int *branched, val_curve *curve)
{
    double tip = 0.0;
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + i * 2;
        int64_t gone = 0;
        for (pd_bond_iterator b = pd_body_bonds_begin(&s->body, i); pd_body_bonds_next(&b);)
            gone += pd_body_bond_is_broken(&b);
        if ((double)gone < 0.35 * (double)(s->body.first_bond[i + 1] - s->body.first_bond[i])) continue;
        tip = fmax(tip, x[0]);
        *branched = *branched || (x[0] > 2e-3 && fabs(x[1]) > 4e-3);
        val_add_point(curve, 1e3 * x[0], 1e3 * x[1]);
    }
    return tip;
}

/* A plate of glass with a notch up to its middle under a tension of 2 MPa that comes at once (data:
 * crack_branching_glass, with a horizon of 3 cells). n cells from side to side. */
static pd_status branching_run(val_job *job)
{
    val_solid *s = &job->lab->solid;
    double h = 0.04 / job->level.n, lo[2] = {-0.05, -0.02}, tip = 0.0, was[4] = {0.0}, fastest = 0.0;
    double off = 0.0, most = 0.0;
    int n[2] = {(int)(2.5 * job->level.n + 0.5), job->level.n}, branched = 0;
    pd_crack_desc notch;
    memset(&notch, 0, sizeof notch);
    notch.direction[0] = 1.0;
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, NULL, NULL));
    PD_TRY(crack_cut(job, &notch, 1.0));
    s->spring.young = 72e9;
    s->spring.fracture = 3.8;
    s->spring.plane = PD_PLANE_STRESS;
    PD_TRY(solid_springs(job->ctx, s));
    s->motion.density = 2440.0;
    s->motion.load = s->load;
    PD_TRY(pd_verlet_build(job->ctx, &s->table, &s->motion, &s->verlet));
    for (int32_t i = 0; i < s->body.count; i++) {
        double y = s->position[i * 2 + 1];
        if (fabs(y) > 0.02 - h) s->load[i * 2 + 1] = copysign(2e6 / h, y);
    }
    for (int frame = 1; frame <= 43; frame++) {
        PD_TRY(pd_physics_run(job->ctx, pd_verlet_process(&s->verlet), frame * 1e-6));
        tip = branching_tip(s, &branched, NULL);
        if (frame > 4) fastest = fmax(fastest, (tip - was[frame % 4]) / 4e-6);
        was[frame % 4] = tip;
    }
    for (int32_t i = 0; i < s->body.count; i++) {
        int32_t mirror = i % n[0] + n[0] * (n[1] - 1 - i / n[0]);
        off = fmax(off, fabs(s->verlet.u[i * 2 + 1] + s->verlet.u[mirror * 2 + 1]));
        most = fmax(most, fabs(s->verlet.u[i * 2 + 1]));
    }
    double energy = pd_verlet_kinetic(&s->verlet) + pd_microelastic_energy(job->ctx, &s->springs, s->verlet.u);
    if (job->profile) {
        job->profile->title = "the crack at 43 us";
        job->profile->x_label = "x [mm]";
        job->profile->y_label = "y [mm]";
    }
    branching_tip(s, &branched, val_add_curve(job, "points that lost a third of their bonds", PD_SERIES_STYLE_MARKERS));
    job->out->h = h;
    job->out->steps = (long)s->verlet.steps;
    job->out->err[0] = fastest / 3100.0;
    job->out->err[1] = fmax(0.0, fmax(1600.0 - fastest, fastest - 2000.0)) / 1600.0;
    job->out->err[2] = branched ? 0.0 : 1.0;
    job->out->err[3] = off / most;
    job->out->err[4] = fabs((energy + s->springs.released) / s->verlet.work - 1.0);
    return PD_OK;
}

static const val_part branching_part = {
    "", "", "cells from side to side", VAL_BY_N, NULL, 0.0,
    {{"of_rayleigh", "speed over Rayleigh's"}, {"beyond", "beyond 1600 to 2000 m/s"}, {"straight", "no branch"},
     {"halves", "halves differ"}, {"energy", "energies"}}, 5,
    {{0, 1.0, 0.0, 0, VAL_GOAL}, {1, 0.0, 0.0, 80, VAL_GOAL}, {2, 0.0, 0.0, 0, VAL_GOAL}, {3, 1e-9, 0.0, 0, VAL_GOAL},
     {4, 2e-3, 0.0, 0, VAL_GOAL}}, 5,
    {{80, 3.0, 0.0}}, 1, 1, branching_run, NULL};
static const val_part *const branching_parts[] = {&branching_part};

static const val_case branching_case = {
    "branching", "A crack that branches",
    "A plate of soda-lime glass of 100 mm by 40 mm, notched up to its middle, under a tension of 2 MPa that comes at "
    "once; 43 us. The fastest 4 us of the tip over the speed of Rayleigh's waves and against the published range, "
    "whether the crack branches (0: it does), how far the halves of the plate differ, and the sum of the energies over "
    "the work.",
    "Bonds that break at a wrong stretch, ends of a bond that do not agree whether it broke, energy that breaking "
    "makes.",
    "Bobaru and Zhang 2015 (data: crack_branching_glass)",
    branching_parts, 1};
#endif

#endif
