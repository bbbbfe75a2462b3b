/* dissolution: cases about receding metal and its balance. */
#ifndef VAL_DISSOLUTION_H
#define VAL_DISSOLUTION_H

/* Recession speed that falls to zero at saturation. saturation 0: constant. */
typedef struct val_law {
    double speed;      /* [m/s] */
    double saturation; /* [mol/m3] */
} val_law;

static double dissolution_law(void *user, const pd_rate_at *at)
{
    const val_law *law = (const val_law *)user;
    return law->saturation > 0.0 ? law->speed * (1.0 - at->c / law->saturation) : law->speed;
}

/* ---- rate ---- */

#define RATE_YEAR 31557600.0             /* [s] */
#define RATE_SPEED (1e-3 / RATE_YEAR)    /* [m/s] 1 mm/year */
#define RATE_EDGE 200e-6                 /* [m] of the box */
#define RATE_DEPTH (0.2 * RATE_EDGE)     /* [m] that the metal loses */

#define RATE_MOST (PD_DIM == 3 ? 52 * 52 * 52 : 180 * 180)

/* Content of all metal in intact cells. */
static double rate_content(const val_lab *lab)
{
    double sum = 0.0;
    for (int32_t j = 0; j < lab->grid.total; j++)
        if (lab->grid.kind[j] == PD_SOLID) sum += lab->transport.c[j] / lab->dissolve_desc.solid;
    return sum;
}

/* A half-space of metal in a box that is thin along the other axes. */
static void rate_half_space(val_lab *lab, const int *direction, int n)
{
    lab->shapes[0].type = PD_SHAPE_HALF_SPACE;
    for (int d = 0; d < PD_DIM; d++) {
        lab->shapes[0].a[d] = direction[d] ? 0.55 * RATE_EDGE : 0.0;
        lab->shapes[0].b[d] = direction[d];
        if (!direction[d]) lab->grid_desc.hi[d] = 2.0 * RATE_EDGE / n; /* mirrored there, so thin is enough */
    }
}

/* A slab of metal in a periodic box, whose cells along each axis of the direction are returned: the layers below three
 * quarters of them. No side is anywhere. */
static int rate_slab(val_lab *lab, const int *direction, int n, uint8_t *mask)
{
    int edge = n + 20, cells = 1;
    lab->shapes[0].type = PD_SHAPE_VOXELS;
    lab->shapes[0].mask = mask;
    for (int d = 0; d < PD_DIM; d++) {
        lab->grid_desc.side[2 * d] = lab->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        lab->shapes[0].b[d] = RATE_EDGE / n;
        lab->shapes[0].mask_size[d] = direction[d] ? edge : 2;
        lab->grid_desc.hi[d] = lab->shapes[0].mask_size[d] * (RATE_EDGE / n);
        cells *= lab->shapes[0].mask_size[d];
    }
    for (int k = 0; k < cells; k++) {
        int layer = 0;
        for (int d = 0, rest = k; d < PD_DIM; rest /= lab->shapes[0].mask_size[d++])
            layer += direction[d] * (rest % lab->shapes[0].mask_size[d]);
        mask[k] = layer % edge < 3 * edge / 4;
    }
    return edge;
}

/* Relative error of the recession of flat fronts with that normal, along an axis or a diagonal. */
static pd_status rate_front(val_job *job, const int *direction, double *error)
{
    static uint8_t mask[RATE_MOST];
    val_lab *lab = job->lab;
    val_law law = {RATE_SPEED, 0.0};
    int ones = 0, edge = 0, n = job->level.n;
    double area = 1.0; /* of all fronts, in faces of cells */
    memset(lab, 0, sizeof *lab);
    lab_box(lab, RATE_EDGE / n, 1.0, 0.0, RATE_EDGE);
    lab->surface_m = job->level.m;
    lab->grid_desc.solid = &lab->shapes[0];
    for (int d = 0; d < PD_DIM; d++) ones += direction[d];
    if (ones > 1) edge = rate_slab(lab, direction, n, mask);
    else rate_half_space(lab, direction, n);
    lab->dissolve_desc.solid = 1e5;
    lab->dissolve_desc.rate = dissolution_law;
    lab->dissolve_desc.rate_user = &law;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE));
    for (int d = 0; d < PD_DIM; d++)
        if (edge || !direction[d]) area *= lab->grid.n[d];
    if (edge) area *= 2.0 * sqrt((double)ones) / edge;
    double before = rate_content(lab);
    PD_TRY(pd_time_loop_run(job->ctx, &lab->couple, RATE_DEPTH / RATE_SPEED, 0.0, NULL, NULL));
    *error = fabs((before - rate_content(lab)) / area * lab->grid.h[0] / RATE_DEPTH - 1.0);
    job->out->h = lab->grid.h[0];
    job->out->steps += (long)lab->couple.steps;
    return PD_OK;
}

static pd_status rate_run(val_job *job)
{
    static const int directions[4][3] = {{1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 1, 1}};
    for (int k = 0; k < (PD_DIM == 1 ? 1 : PD_DIM == 2 ? 3 : 4); k++) {
        if (k) lab_free(job->ctx, job->lab);
        PD_TRY(rate_front(job, directions[k], &job->out->err[k]));
    }
    return PD_OK;
}

static const val_part rate_part = {
    "", "", "cells", VAL_BY_N, NULL, 0.0,
#if PD_DIM == 1
    {{"err_x", "along x"}}, 1, {{0, 3e-3, 0.0, 0, VAL_GOAL}}, 1, {{20, 3.0, 0.0}, {40, 3.0, 0.0}, {80, 3.0, 0.0}}, 3, 3,
#elif PD_DIM == 2
    {{"err_x", "along x"}, {"err_y", "along y"}, {"err_xy", "along (1,1)"}}, 3,
    {{0, 3e-3, 0.0, 0, VAL_GOAL}, {1, 3e-3, 0.0, 0, VAL_GOAL}, {2, 3e-3, 0.0, 0, VAL_GOAL_OF_ALL},
     {2, 6e-3, 0.0, 0, VAL_GUARD}}, 4,
    {{40, 3.0, 0.0}, {80, 3.0, 0.0}, {160, 3.0, 0.0}}, 3, 1,
#else
    {{"err_x", "along x"}, {"err_y", "along y"}, {"err_xy", "along (1,1,0)"}, {"err_xyz", "along (1,1,1)"}}, 4,
    {{0, 3e-3, 0.0, 0, VAL_GOAL}, {1, 3e-3, 0.0, 0, VAL_GOAL}, {2, 3e-3, 0.0, 0, VAL_GOAL_OF_ALL},
     {3, 3e-3, 0.0, 0, VAL_GOAL_OF_ALL}, {3, 6e-3, 0.0, 0, VAL_GUARD}}, 5,
    {{8, 3.0, 0.0}, {16, 3.0, 0.0}, {32, 3.0, 0.0}}, 3, 1,
#endif
    rate_run, NULL};
static const val_part *const rate_parts[] = {&rate_part};

static const val_case rate_case = {
    "rate", "Uniform corrosion in mm/year",
    "Flat fronts along the axes and the diagonals recede at 1 mm/year, by 40 um of 200 um, with h, h/2 and h/4. Those "
    "along diagonals bound slabs in a periodic box: no side is felt.",
    "A rate of the exposed layer in place of a speed, which makes the speed proportional to 1/h and different along a "
    "diagonal.",
    "the speed itself",
    rate_parts, 1};

/* ---- ledger ---- */

/* Remembers the worst imbalance of all steps. */
static int ledger_watch(void *user, const pd_time_loop *couple)
{
    double *worst = (double *)user;
    *worst = fmax(*worst, couple->ledger[0].relative_imbalance);
    return 0;
}

#if PD_DIM > 1
static double ledger_mean = 0.236; /* [m/s] */

static void ledger_scene(val_job *job, val_law *law)
{
    val_lab *lab = job->lab;
    double um = 1e-6;
    flow_channel(lab, 300.0 * um / job->level.n, job->level.m, -75.0 * um, 150.0 * um, &ledger_mean, 1e-6);
    lab->grid_desc.solid = &lab->shapes[0];
    lab->shapes[0].type = PD_SHAPE_BOX;
    lab->shapes[0].b[0] = 75.0 * um;
    for (int d = 1; d < PD_DIM; d++) {
        lab->shapes[0].a[d] = -50.0 * um;
        lab->shapes[0].b[d] = 50.0 * um;
    }
    law->speed = 4e-9; /* 14 um/h */
}
#else
/* Without flow; metal leaves through a side that is held at c = 0. */
static void ledger_scene(val_job *job, val_law *law)
{
    val_lab *lab = job->lab;
    lab_box(lab, 300e-6 / job->level.n, job->level.m, 0.0, 300e-6);
    lab->grid_desc.side[0] = PD_SIDE_INLET;
    lab->grid_desc.solid = &lab->shapes[0];
    lab->shapes[0].type = PD_SHAPE_HALF_SPACE;
    lab->shapes[0].a[0] = 150e-6;
    lab->shapes[0].b[0] = -1.0;
    law->speed = 4e-9;
}
#endif

static pd_status ledger_run(val_job *job)
{
    val_lab *lab = job->lab;
    val_law law = {0.0, 1000.0};
    pd_material metal;
    if (!pd_material_find("mg4ag", &metal)) return PD_ERR_ARGUMENT;
    ledger_scene(job, &law);
    lab->surface_m = 3.0;
    lab->transport_desc.diffusivity = 1e-9;
    lab->dissolve_desc.solid = pd_material_concentration(&metal);
    lab->dissolve_desc.rate = dissolution_law;
    lab->dissolve_desc.rate_user = &law;
    PD_TRY(lab_build(job->ctx, lab,
                     VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE | (PD_DIM > 1 ? VAL_FLOW | VAL_STEADY : 0)));
    PD_TRY(pd_time_loop_run(job->ctx, &lab->couple, job->level.p, 0.0, ledger_watch, &job->out->err[0]));
    job->out->h = lab->grid.h[0];
    job->out->err[1] = pd_time_loop_volume_loss(&lab->couple);
    job->out->residual = fmax(lab->quasi.result.momentum, lab->quasi.result.continuity);
    job->out->steps = (long)lab->couple.steps;
    job->out->evals = (long)lab->quasi.evaluations;
    return PD_OK;
}

static const val_part ledger_part = {
    "", "", "time [s]", VAL_BY_P, "t [s]", 0.0, {{"ledger", "imbalance"}, {"volume_loss", "volume loss"}}, 2,
    {{0, 1e-12, 0.0, 0, VAL_GOAL}}, 1,
#if PD_DIM == 3
    {{12, 2.0, 3600.0}, {12, 2.0, 7200.0}}, 2, 1,
#else
    {{24, 1.0, 3600.0}, {24, 1.0, 7200.0}}, 2, 2,
#endif
    ledger_run, NULL};
static const val_part *const ledger_parts[] = {&ledger_part};

static const val_case ledger_case = {
    "ledger", "Balance of all amounts",
    "A pin dissolves in a flow (1D: a slab in fluid at rest, with a side held at c = 0), nodes turn fluid, the flow is "
    "solved again. The worst imbalance of metal left, dissolved, carried over and gone of all steps, over the metal at "
    "the start.",
    "Clamps, contents that are dropped when a node turns fluid, a linear solver whose residual is mass, exchange that "
    "is not antisymmetric.",
    "conservation of mass",
    ledger_parts, 1};

#endif
