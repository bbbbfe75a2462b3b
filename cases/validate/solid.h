/* solid: cases of a patch test, of beams, and of metal that dissolves under load. */
#ifndef VAL_SOLID_H
#define VAL_SOLID_H
#include "../elasticity.h"
#include "case.h"

/* ---- solid_patch ---- */

typedef struct patch_block {
    double h;      /* [m] cell */
    uint32_t seed; /* of the shaking */
} patch_block;

static double patch_random(patch_block *b)
{
    b->seed = b->seed * 1664525u + 1013904223u;
    return (b->seed >> 8) / 16777216.0 - 0.5;
}

/* A block with a hole and a corner that is missing; points lie up to a quarter of a cell off the lattice, and have
 * volumes of their own. */
static double patch_block_part(const void *user, double h, double *x)
{
    patch_block *b = (patch_block *)(uintptr_t)user;
    double corner = 1.0, hole = 0.0, share = 1.0 + 0.5 * patch_random(b);
    for (int d = 0; d < PD_DIM; d++) {
        corner = fmin(corner, x[d]);
        hole += (x[d] - 0.35) * (x[d] - 0.35);
        x[d] += 0.5 * h * patch_random(b);
    }
    return PD_DIM > 1 && (corner > 0.6 || hole < 0.02) ? 0.0 : share;
}

/* Hooke's law for the gradient g. */
static void patch_stress(const pd_correspondence *e, const double *g, double *p)
{
    double trace = 0.0;
    for (int d = 0; d < PD_DIM; d++) trace += g[d * PD_DIM + d];
    for (int k = 0; k < SOLID_T; k++) {
        int a = k / PD_DIM, b = k % PD_DIM;
        p[k] = e->mu * (g[k] + g[b * PD_DIM + a]) + (a == b ? e->lambda * trace : 0.0);
    }
}

/* Largest difference of the stress at the displacements of the body from p. */
static double patch_off(val_job *job, const double *p)
{
    val_solid *s = &job->lab->solid;
    double off = 0.0;
    pd_correspondence_stress(job->ctx, &s->elastic, s->u, s->stress);
    for (int32_t k = 0; k < s->body.count * SOLID_T; k++) off = fmax(off, fabs(s->stress[k] - p[k % SOLID_T]));
    return off;
}

static pd_status patch_plane(val_job *job, pd_plane plane)
{
    val_solid *s = &job->lab->solid;
    patch_block block = {0.0, 7u};
    double h = 1.0 / job->level.n, lo[3] = {0.0, 0.0, 0.0}, g[SOLID_T], p[SOLID_T], size = 0.0, off = 0.0;
    int n[3] = {job->level.n, job->level.n, job->level.n};
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, patch_block_part, &block));
#if PD_DIM == 2
    static const double corners[2][2] = {{0.13, 0.62}, {0.48, 0.83}};
    pd_precrack cut = {2, corners[0]};
    PD_TRY(pd_body_apply_precracks(job->ctx, &s->body, &cut, 1, NULL));
#endif
    s->metal.young = 1.0;
    s->metal.poisson = job->level.p;
    s->metal.plane = plane;
    PD_TRY(solid_elastic(job->ctx, s));
    for (int k = 0; k < SOLID_T; k++) g[k] = patch_random(&block);
    patch_stress(&s->elastic, g, p);
    for (int k = 0; k < SOLID_T; k++) size = fmax(size, fabs(p[k]));
    for (int32_t k = 0; k < s->body.count * PD_DIM; k++)
        for (int q = 0; q < PD_DIM; q++) {
            int a = k % PD_DIM;
            s->u[k] += g[a * PD_DIM + q] * s->position[k - a + q];
            s->load[k] -= p[a * PD_DIM + q] * s->elastic.surface_vector[k - a + q];
        }
    pd_correspondence_force(job->ctx, &s->elastic, s->u, s->force);
    for (int32_t k = 0; k < s->body.count * PD_DIM; k++) off = fmax(off, fabs(s->force[k] + s->load[k]));
    job->out->err[0] = fmax(job->out->err[0], patch_off(job, p) / size);
    job->out->err[1] = fmax(job->out->err[1], off * s->desc.horizon / size);
    memset(s->u, 0, (size_t)s->room * PD_DIM * sizeof *s->u);
    PD_TRY(solid_rest(job->ctx, s));
    job->out->err[2] = fmax(job->out->err[2], patch_off(job, p) / size);
    job->out->h = h;
    return PD_OK;
}

static pd_status solid_patch_run(val_job *job)
{
    PD_TRY(patch_plane(job, PD_PLANE_STRAIN));
    solid_free(job->ctx, &job->lab->solid);
    return PD_DIM == 2 ? patch_plane(job, PD_PLANE_STRESS) : PD_OK;
}

#define SOLID_PATCH_N (PD_DIM == 1 ? 40 : PD_DIM == 2 ? 16 : 8)

static const val_part solid_patch_part = {
#if PD_DIM == 1
    "", "", "m", VAL_BY_M, "m", 0.0,
#else
    "", "", "Poisson's ratio", VAL_BY_P, "Poisson's ratio", 0.0,
#endif
    {{"err_stress", "stress"}, {"err_balance", "balance"}, {"err_solved", "stress of the balance"}}, 3,
    {{0, 1e-12, 0.0, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}, {2, 1e-8, 0.0, 0, VAL_GOAL}}, 3,
#if PD_DIM == 1
    {{SOLID_PATCH_N, 1.0, 0.0}, {SOLID_PATCH_N, 2.0, 0.0}, {SOLID_PATCH_N, 3.0, 0.0}}, 3, 3,
#else
    {{SOLID_PATCH_N, 2.0, -0.5}, {SOLID_PATCH_N, 1.5, 0.0}, {SOLID_PATCH_N, 3.0, 0.25}, {SOLID_PATCH_N, 2.0, 0.3},
     {SOLID_PATCH_N, 2.5, 0.45}}, 5, PD_DIM == 3 ? 2 : 5,
#endif
    solid_patch_run, NULL};
static const val_part *const solid_patch_parts[] = {&solid_patch_part};

static const val_case solid_patch_case = {
    "solid_patch", "Patch test of small strains",
    "A body with a hole, a corner that is missing, a crack (2D) and points off the lattice has a uniform strain: the "
    "stress of its points, their balance with the tractions on all surfaces, and the stress when the tractions alone "
    "are given and displacements are found; in 2D in both planes.",
    "Families at a surface that are softer than others, tractions that are spread with a wrong sum or moment, a "
    "Poisson's ratio that bonds prescribe.",
    "Hooke's law",
    solid_patch_parts, 1};

#if PD_DIM == 2
/* ---- gutman ---- */

/* Factor of the speed of iron at 298.15 K (data: gutman). */
static const double gutman_table[3][2] = {{100.0, 1.3311023}, {200.0, 1.7718333}, {300.0, 2.3584913}};

/* Share of a bar that is gone after 20 s; its ends are held apart so that the mean of its normal stresses is this
 * [MPa]. */
static pd_status gutman_loss(val_job *job, double stress, double *loss)
{
    static pd_sim sim;
    char text[1200];
    snprintf(text, sizeof text,
             "[grid] h = %.17g um  m = %g  box = 0 .. 20 um, 0 .. 12 um\n"
             "[shape bar] box = 0 .. 20 um, 0 .. 10 um\n  kind = solid  material = steel304\n"
             "[solid] E = 200 GPa  nu = 0.3  plane = stress\n"
             "dissolution_factor = exp(sigma_h * 7.09e-6 m3/mol / (R * 298.15 K))\n"
             "[side x-] ux = 0 um\n[side y-] uy = 0 um\n[side x+] ux = %.17g um\n"
             "[corrode] rate = 0.1 um/s  Csat = 5.1 mol/L  control = activation\n[run] until = 20 s\n",
             10.0 / job->level.n, job->level.m, 20.0 * 3.0 * stress / 200e3);
    PD_TRY(pd_sim_open(job->ctx, text, NULL, 0, &sim));
    pd_status status = pd_time_loop_run(job->ctx, &sim.model.time_loop, 20.0, 0.0, NULL, NULL);
    *loss = pd_time_loop_volume_loss(&sim.model.time_loop);
    job->out->steps += (long)sim.model.time_loop.steps;
    pd_sim_close(job->ctx, &sim);
    return status;
}

static pd_status gutman_run(val_job *job)
{
    double slow, fast, factor = NAN;
    for (int k = 0; k < 3; k++)
        if (fabs(gutman_table[k][0] - job->level.p) < 1.0) factor = gutman_table[k][1];
    PD_TRY(gutman_loss(job, 0.0, &slow));
    PD_TRY(gutman_loss(job, job->level.p, &fast));
    job->out->h = 10e-6 / job->level.n;
    job->out->err[0] = fabs(fast / slow / factor - 1.0);
    job->out->err[1] = fabs(slow / 0.2 - 1.0);
    return PD_OK;
}

static pd_status gutman_fine_run(val_job *job)
{
    job->level.p = 100.0;
    return gutman_run(job);
}

static const val_part gutman_part = {
    "stress", "20 cells, three stresses", "MPa", VAL_BY_P, "MPa", 0.0,
    {{"err_factor", "factor of the speed"}, {"err_alone", "speed without load"}}, 2,
    {{0, 1e-2, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, 0, VAL_GOAL}}, 2,
    {{20, 2.0, 100.0}, {20, 2.0, 200.0}, {20, 2.0, 300.0}}, 3, 1, gutman_run, NULL};
static const val_part gutman_fine = {
    "cells", "100 MPa", "cells across", VAL_BY_N, NULL, 0.0,
    {{"err_factor", "factor of the speed"}, {"err_alone", "speed without load"}}, 2,
    {{0, 1e-2, 0.0, 20, VAL_GOAL}, {1, 1e-2, 0.0, 20, VAL_GOAL}}, 2,
    {{10, 2.0, 0.0}, {20, 2.0, 0.0}, {40, 2.0, 0.0}}, 3, 0, gutman_fine_run, NULL};
static const val_part *const gutman_parts[] = {&gutman_part, &gutman_fine};

static const val_case gutman_case = {
    "gutman", "Metal that dissolves under load",
    "A bar in plane stress whose ends are held apart dissolves from its side at 0.1 um/s times "
    "exp(sigma_h V/(R T)), with V and T of iron, for 20 s, as a scene: what it loses over what it loses without load.",
    "The stress of the bar as it was where metal is gone, a stress of the wrong sign or of one axis, a factor that is "
    "applied twice.",
    "Gutman 1998: closed form (data: gutman)",
    gutman_parts, 2};
#endif

#if PD_DIM > 1
/* ---- cantilever ---- */

/* The stress along a beam of length 4 that shear at its end bends (1), or moments (2). */
static double cantilever_stress(const double *x, int kind) { return kind == 1 ? -12.0 * (4.0 - x[0]) * x[1] : -x[1]; }

/* The load of that stress and of the shear on the end. Tractions act over two horizons, and a little nearer to the
 * middle than they are given, so a parabola has more than its sum: the load is scaled to the force or to the moment.
 */
static void cantilever_load(val_job *job, int kind)
{
    val_solid *s = &job->lab->solid;
    double sum = 0.0;
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + (int64_t)i * PD_DIM;
        double *load = s->load + (int64_t)i * PD_DIM, edge = s->elastic.surface_vector[(int64_t)i * PD_DIM];
        if (x[0] < 4.0 - 2.0 * (job->level.m + 1.0) / job->level.n) continue;
        load[0] = -cantilever_stress(x, kind) * edge;
        load[1] = kind == 1 ? -6.0 * (0.25 - x[1] * x[1]) * edge : 0.0;
        sum += s->volume[i] * (kind == 1 ? load[1] : -12.0 * x[1] * load[0]);
    }
    for (int32_t k = 0; k < s->body.count * PD_DIM; k++) s->load[k] /= sum;
}

/* Deflection of the middle line at the end, from the last two layers beside it. */
static double cantilever_tip(const val_solid *s, double length, double h)
{
    double sum[2] = {0.0}, volume[2] = {0.0};
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + (int64_t)i * PD_DIM;
        int layer = (int)((length - x[0]) / h);
        if (layer > 1 || fabs(x[1]) > h || (PD_DIM == 3 && fabs(x[PD_DIM - 1]) > h)) continue;
        sum[layer] += s->volume[i] * s->u[(int64_t)i * PD_DIM + 1];
        volume[layer] += s->volume[i];
    }
    return 1.5 * sum[0] / volume[0] - 0.5 * sum[1] / volume[1];
}

/* A beam of length 4 and height (3D: and width) 1; its root is held to the closed form. */
static pd_status cantilever_run(val_job *job)
{
    val_solid *s = &job->lab->solid;
    int kind = (int)job->level.p, root = (int)ceil(2.0 * job->level.m);
    int n[3] = {4 * job->level.n + root, job->level.n, job->level.n};
    double h = 1.0 / job->level.n, length = 4.0, lo[3] = {-root * h, -0.5, -0.5}, end[3] = {4.0, 0.0, 0.0}, tip[3];
    double nu = PD_DIM == 3 && kind == 1 ? 0.0 : 0.3;
    val_squares sum = {0.0, 0.0};
    PD_TRY(solid_cells(job->ctx, s, n, lo, h, job->level.m, NULL, NULL));
    s->metal.young = 1.0;
    s->metal.poisson = nu;
    s->metal.plane = PD_PLANE_STRESS;
    PD_TRY(solid_elastic(job->ctx, s));
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + (int64_t)i * PD_DIM;
        double *u = s->u + (int64_t)i * PD_DIM;
        if (x[0] > 0.0) continue;
        if (kind == 1) elasticity_cantilever(x, length, nu, u);
        else elasticity_bent(x, nu, u);
        memset(s->held + (int64_t)i * PD_DIM, 1, PD_DIM);
    }
    cantilever_load(job, kind);
    PD_TRY(solid_rest(job->ctx, s));
    for (int32_t i = 0; i < s->body.count; i++) {
        const double *x = s->position + (int64_t)i * PD_DIM, *p = s->stress + (int64_t)i * SOLID_T;
        double wanted = cantilever_stress(x, kind);
        if (x[0] < 0.5 || x[0] > 3.5) continue;
        val_squares_add(&sum, s->volume[i], p[0], wanted);
    }
    if (kind == 1) elasticity_cantilever(end, length, nu, tip);
    else elasticity_bent(end, nu, tip);
    job->out->h = h;
    job->out->err[0] = fabs(cantilever_tip(s, length, h) / tip[1] - 1.0);
    job->out->err[1] = val_squares_l2(&sum);
    job->out->evals = s->iterations;
    return PD_OK;
}

#define CANTILEVER_MEASURES {{"err_tip", "deflection"}, {"err_stress", "stress along, rms"}}, 2
#define CANTILEVER_GOALS(from) \
    {{0, 1e-2, 0.0, from, VAL_GOAL}, {0, 0.0, 1.8, 0, VAL_GOAL}, {0, 0.15, 0.0, 0, VAL_GUARD}}, 3
#if PD_DIM == 2
static const val_part cantilever_shear = {
    "shear", "shear at the end, m = 2", "cells across", VAL_BY_N, NULL, 2.0, CANTILEVER_MEASURES, CANTILEVER_GOALS(32),
    {{16, 2.0, 1.0}, {32, 2.0, 1.0}, {64, 2.0, 1.0}}, 3, 2, cantilever_run, NULL};
static const val_part cantilever_nearest = {
    "nearest", "the same with the nearest neighbours, m = 1", "cells across", VAL_BY_N, NULL, 2.0, CANTILEVER_MEASURES,
    CANTILEVER_GOALS(16), {{16, 1.0, 1.0}, {32, 1.0, 1.0}, {64, 1.0, 1.0}}, 3, 2, cantilever_run, NULL};
static const val_part cantilever_bent = {
    "moments", "moments, m = 2", "cells across", VAL_BY_N, NULL, 2.0, CANTILEVER_MEASURES, CANTILEVER_GOALS(32),
    {{16, 2.0, 2.0}, {32, 2.0, 2.0}, {64, 2.0, 2.0}}, 3, 2, cantilever_run, NULL};
static const val_part *const cantilever_parts[] = {&cantilever_shear, &cantilever_nearest, &cantilever_bent};
#else
static const val_part cantilever_shear = {
    "shear", "shear at the end, m = 1", "cells across", VAL_BY_N, NULL, 2.0, CANTILEVER_MEASURES, CANTILEVER_GOALS(16),
    {{4, 1.0, 1.0}, {8, 1.0, 1.0}, {16, 1.0, 1.0}}, 3, 2, cantilever_run, NULL};
static const val_part cantilever_bent = {
    "moments", "moments, m = 1", "cells across", VAL_BY_N, NULL, 2.0, CANTILEVER_MEASURES, CANTILEVER_GOALS(16),
    {{4, 1.0, 2.0}, {8, 1.0, 2.0}, {16, 1.0, 2.0}}, 3, 2, cantilever_run, NULL};
static const val_part *const cantilever_parts[] = {&cantilever_shear, &cantilever_bent};
#endif
static const val_case cantilever_case = {
    "cantilever", "A beam that bends",
    "A beam four times as long as high, in plane stress with a Poisson's ratio of 0.3, in 3D of a square section: its "
    "root has the displacements of the closed form, its end bears shear that is spread as a parabola, or moments. In "
    "3D the closed form of shear holds without contraction, that of moments with 0.3. Loads are scaled to their force "
    "or moment. The deflection of the middle of the end, and the stress along the beam away from both ends.",
    "Families at the free sides that are too stiff or too soft, tractions whose sum or moment is wrong, shear that is "
    "forgotten (4.3 % of the deflection).",
    "Timoshenko and Goodier 1970, secs. 21 and 102 (data: cantilever)",
    cantilever_parts, (int)(sizeof cantilever_parts / sizeof cantilever_parts[0])};
#endif

#endif
