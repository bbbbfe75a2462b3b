/* front: speed of flat fronts of bond-based corrosion, along axes and diagonals. */
#ifndef VAL_FRONT_H
#define VAL_FRONT_H

#define FRONT_SPEED (1e-3 / 31557600.0) /* [m/s] 1 mm/year */
#define FRONT_CELLS (PD_DIM == 3 ? 48 : 80)
/* Layers that a front passes before its speed is taken, and up to when: it begins unlike it goes on. */
#define FRONT_FROM (PD_DIM == 3 ? 9 : 12)
#define FRONT_TO (PD_DIM == 3 ? 15 : 24)
#define FRONT_SHARE 0.005 /* [-] of Cs - Csat that a node with fluid all around loses in a step */

static double front_law(void *user, const pd_rate_at *at)
{
    (void)at;
    return *(const double *)user;
}

/* A periodic box of which the layers `direction . index` (modulo its cells) below three quarters are metal: a slab with
 * two flat fronts of that normal, and no side anywhere. */
static void front_slab(val_job *job, const int *direction, double h, double *speed, uint8_t *mask)
{
    val_lab *lab = job->lab;
    int cells = 1;
    lab_box(lab, h, job->level.m, 0.0, FRONT_CELLS * h);
    lab->grid_desc.solid = &lab->shapes[0];
    lab->shapes[0].type = PD_SHAPE_VOXELS;
    lab->shapes[0].mask = mask;
    for (int d = 0; d < PD_DIM; d++) {
        lab->grid_desc.side[2 * d] = lab->grid_desc.side[2 * d + 1] = PD_SIDE_PERIODIC;
        lab->shapes[0].b[d] = h;
        lab->shapes[0].mask_size[d] = direction[d] ? FRONT_CELLS : 2;
        lab->grid_desc.hi[d] = lab->shapes[0].mask_size[d] * h;
        cells *= lab->shapes[0].mask_size[d];
    }
    for (int k = 0; k < cells; k++) {
        int layer = 0;
        for (int d = 0, rest = k; d < PD_DIM; rest /= lab->shapes[0].mask_size[d++])
            layer += direction[d] * (rest % lab->shapes[0].mask_size[d]);
        mask[k] = layer % FRONT_CELLS < 3 * FRONT_CELLS / 4;
    }
    lab->dissolve_desc.model = PD_METAL_BONDS;
    lab->dissolve_desc.solid = 1e5;
    lab->dissolve_desc.saturation = 5e3;
    lab->dissolve_desc.activation = lab->transport_desc.given = 1;
    lab->dissolve_desc.rate = front_law;
    lab->dissolve_desc.uniform = 1;
    lab->dissolve_desc.rate_user = speed;
}

/* Speed of both fronts between the times at which they have passed a few layers and some more. */
static pd_status front_run(val_job *job, const int *direction, pd_kernel kernel, double h, double *found)
{
    static uint8_t mask[PD_DIM == 3 ? FRONT_CELLS * FRONT_CELLS * FRONT_CELLS : FRONT_CELLS * FRONT_CELLS];
    val_lab *lab = job->lab;
    double speed = FRONT_SPEED, begin = 0.0, length = 0.0;
    int64_t layer = 2, gone = 0;
    memset(lab, 0, sizeof *lab);
    front_slab(job, direction, h, &speed, mask);
    lab->dissolve_desc.kernel = kernel;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE));
    for (int d = 0; d < PD_DIM; d++) length += direction[d];
    for (int d = 1; d < PD_DIM; d++) layer *= lab->grid.n[d];
    double step = FRONT_SHARE / (speed * lab->dissolve.kernel.total);
    PD_TRY(pd_time_loop_start(job->ctx, &lab->couple));
    while (gone < FRONT_TO * layer) {
        PD_TRY(pd_time_loop_step(job->ctx, &lab->couple, lab->couple.time + step));
        gone += lab->dissolve.changed_count;
        if (!(begin > 0.0) && gone >= FRONT_FROM * layer) begin = lab->couple.time;
    }
    *found = (FRONT_TO - FRONT_FROM) * h / sqrt(length) / (lab->couple.time - begin);
    job->out->h = h;
    job->out->steps += (long)lab->couple.steps;
    lab_free(job->ctx, lab);
    return PD_OK;
}

enum { FRONT_WAYS = PD_DIM };
static const int front_way[3][3] = {{1, 0, 0}, {1, 1, 0}, {1, 1, 1}};

/* The worst of all kernels (along (1,1,1) area weights alone, for the time it takes). */
static pd_status front_speed_run(val_job *job)
{
    for (int way = 0; way < FRONT_WAYS; way++)
        for (int kernel = 0; kernel < (way < 2 ? 3 : 1); kernel++) {
            double found;
            PD_TRY(front_run(job, front_way[way], (pd_kernel)kernel, 1e-6, &found));
            job->out->err[way] = fmax(job->out->err[way], fabs(found / FRONT_SPEED - 1.0));
        }
    return PD_OK;
}

/* With h, h/2 and h/4. */
static pd_status front_rate_run(val_job *job)
{
    for (int way = 0; way < FRONT_WAYS; way++) {
        double found;
        PD_TRY(front_run(job, front_way[way], PD_KERNEL_AREA, 8e-6 / job->level.n, &found));
        job->out->err[way] = fabs(found / FRONT_SPEED - 1.0);
    }
    return PD_OK;
}

#if PD_DIM == 1
#define FRONT_MEASURES {{"err_x", "along x"}}, 1, {{0, 3e-3, 0.0, 0, VAL_GOAL}}, 1
#elif PD_DIM == 2
#define FRONT_MEASURES \
    {{"err_x", "along x"}, {"err_xy", "along (1,1)"}}, 2, \
    {{0, 3e-3, 0.0, 0, VAL_GOAL}, {1, 3e-3, 0.0, 0, VAL_GOAL}}, 2
#else
#define FRONT_MEASURES \
    {{"err_x", "along x"}, {"err_xy", "along (1,1,0)"}, {"err_xyz", "along (1,1,1)"}}, 3, \
    {{0, 3e-3, 0.0, 0, VAL_GOAL}, {1, 3e-3, 0.0, 0, VAL_GOAL}, {2, 3e-3, 0.0, 0, VAL_GOAL}}, 3
#endif

static const val_part front_speed_part = {
    "speed", "1 mm/year with three kernels", "m", VAL_BY_M, "m", 0.0, FRONT_MEASURES,
#if PD_DIM == 3
    {{FRONT_CELLS, 2.0, 0.0}, {FRONT_CELLS, 3.0, 0.0}}, 2, 1,
#else
    {{FRONT_CELLS, 1.0, 0.0}, {FRONT_CELLS, 2.0, 0.0}, {FRONT_CELLS, 3.0, 0.0}, {FRONT_CELLS, 4.0, 0.0}}, 4, 4,
#endif
    front_speed_run, NULL};

static const val_part front_rate_part = {
    "rate", "1 mm/year with area weights, m = 3", "8 um/h", VAL_BY_N, NULL, 0.0, FRONT_MEASURES,
#if PD_DIM == 3
    {{8, 3.0, 0.0}}, 1, 0,
#else
    {{2, 3.0, 0.0}, {4, 3.0, 0.0}, {8, 3.0, 0.0}}, 3, 3,
#endif
    front_rate_run, NULL};

static const val_part *const front_parts[] = {&front_speed_part, &front_rate_part};

static const val_case front_case = {
    "front", "Fronts of bond-based corrosion",
    "A slab in a periodic box dissolves under activation control, its fronts normal to an axis or a diagonal. Their "
    "speed, from the times at which layers turn fluid, against the 1 mm/year that was asked for: the worst of area "
    "weights, inverse squares and inverse distances (along (1,1,1) area weights only), and area weights with h, h/2 "
    "and h/4 (3D: one h).",
    "Rates found from a trial run, which hold for its direction, spacing and horizon only; loss that differs between "
    "the ends of a bond.",
    "theory, equations 10.6 and 11.2",
    front_parts, 2};

#endif
