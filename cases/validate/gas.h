/* gas: cases about the ideal gas. */
#ifndef VAL_GAS_H
#define VAL_GAS_H

/* ---- sod ---- */

#define SOD_GAMMA 1.4
#define SOD_END 0.2 /* [s] */

/* G. A. Sod, J. Comput. Phys. 27, 1978: gas at rest left and right of x = 1/2 m. */
static const double sod_rho[2] = {1.0, 0.125}, sod_p[2] = {1.0, 0.1}; /* [kg/m3] [Pa] */

static void sod_start(void *user, const double *x, double *rho, double *v, double *p)
{
    int right = x[0] > 0.5;
    (void)user;
    *rho = sod_rho[right];
    *p = sod_p[right];
    for (int d = 0; d < PD_DIM; d++) v[d] = 0.0;
}

/* The solution of the Riemann problem: a rarefaction to the left, a contact, a shock to the right (Toro, ch. 4). */
typedef struct sod_fan {
    double p, u;                        /* [Pa] [m/s] between the outer waves */
    double head, tail, shock;           /* [m/s] */
    double rho_left, rho_right;         /* [kg/m3] beside the contact */
} sod_fan;

static sod_fan sod_solve(void)
{
    sod_fan fan;
    double g = SOD_GAMMA, c = sqrt(g * sod_p[0] / sod_rho[0]), z = (g - 1.0) / (g + 1.0), lo = sod_p[1], hi = sod_p[0];
    for (int step = 0; step < 100; step++) {
        double p = fan.p = 0.5 * (lo + hi);
        double left = 2.0 * c / (g - 1.0) * (1.0 - pow(p / sod_p[0], 0.5 * (g - 1.0) / g));
        fan.u = (p - sod_p[1]) * sqrt(2.0 / (sod_rho[1] * ((g + 1.0) * p + (g - 1.0) * sod_p[1])));
        if (left > fan.u) lo = p;
        else hi = p;
    }
    double ratio = fan.p / sod_p[1];
    fan.head = -c;
    fan.tail = fan.u - c * pow(fan.p / sod_p[0], 0.5 * (g - 1.0) / g);
    fan.shock = sqrt(0.5 * sod_p[1] / sod_rho[1] * ((g + 1.0) * ratio + g - 1.0));
    fan.rho_left = sod_rho[0] * pow(fan.p / sod_p[0], 1.0 / g);
    fan.rho_right = sod_rho[1] * (ratio + z) / (z * ratio + 1.0);
    return fan;
}

/* Density [kg/m3] on the ray x - 1/2 = speed t. */
static double sod_density(const sod_fan *fan, double speed)
{
    double g = SOD_GAMMA;
    if (speed < fan->head) return sod_rho[0];
    if (speed < fan->tail)
        return sod_rho[0] * pow((2.0 + (g - 1.0) * speed / fan->head) / (g + 1.0), 2.0 / (g - 1.0));
    if (speed < fan->u) return fan->rho_left;
    return speed < fan->shock ? fan->rho_right : sod_rho[1];
}

/* Nodes with a density or a pressure that is not positive, NaN included. */
static double sod_bad(const val_lab *lab)
{
    const double *rho = lab->gas.primitive, *p = rho + (int64_t)(PD_DIM + 1) * lab->grid.total;
    double bad = 0.0;
    for (int32_t i = 0; i < lab->grid.total; i++)
        if (lab->grid.kind[i] == PD_FLUID && !(rho[i] > 0.0 && p[i] > 0.0)) bad += 1.0;
    return bad;
}

/* Runs to the end in steps of at most 0.8 of the limit and counts bad nodes after every one. */
static pd_status sod_steps(val_job *job)
{
    pd_gas *gas = &job->lab->gas;
    while (gas->time < SOD_END) {
        double limit, left = SOD_END - gas->time, from = gas->time;
        PD_TRY(pd_gas_limit(job->ctx, gas, &limit));
        PD_TRY(pd_physics_run(job->ctx, pd_gas_process(gas), from + fmin(0.8 * limit, left)));
        job->out->err[1] += sod_bad(job->lab);
    }
    job->out->steps = (long)gas->steps;
    return PD_OK;
}

/* Mean error of the density; curves along the middle of the tube. */
static void sod_errors(val_job *job)
{
    const val_lab *lab = job->lab;
    sod_fan fan = sod_solve();
    double sum = 0.0;
    val_curve *exact = NULL, *found = NULL;
    if (job->profile) {
        job->profile->title = "Sod's shock tube at t = 0.2 s";
        job->profile->x_label = "x [m]";
        job->profile->y_label = "density [kg/m3]";
        exact = val_add_curve(job, "exact", PD_SERIES_STYLE_LINE);
        found = val_add_curve(job, "computed", PD_SERIES_STYLE_MARKERS);
        for (int k = 0; k <= 1000; k++)
            val_add_point(exact, k / 1000.0, sod_density(&fan, (k / 1000.0 - 0.5) / SOD_END));
    }
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM];
        int middle = 1;
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        sum += fabs(lab->gas.primitive[i] - sod_density(&fan, (x[0] - 0.5) / SOD_END));
        for (int d = 1; d < PD_DIM; d++) middle = middle && x[d] < lab->grid.h[d];
        if (middle) val_add_point(found, x[0], lab->gas.primitive[i]);
    }
    job->out->err[0] = sum / (double)lab->grid.fluid_count;
}

/* A tube with walls at its ends and mirrors along it, two nodes wide in 2D and 3D. */
static pd_status sod_run(val_job *job)
{
    val_lab *lab = job->lab;
    double h = 1.0 / job->level.n;
    lab_box(lab, h, job->level.m, 0.0, 2.0 * h);
    lab->grid_desc.hi[0] = 1.0;
    for (int side = 2; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_MIRROR;
    lab->gas_desc.gamma = SOD_GAMMA;
    lab->gas_desc.initial = sod_start;
    PD_TRY(lab_build(job->ctx, lab, VAL_GAS));
    job->out->h = h;
    PD_TRY(sod_steps(job));
    sod_errors(job);
    return PD_OK;
}

#define SOD_MEASURES {{"err", "density, mean"}, {"negative", "nodes not positive"}}, 2
#define SOD_GOALS {{0, 1.5e-2, 0.0, 400, VAL_GOAL}, {1, 0.0, 0.0, 0, VAL_GOAL}, {0, 1.3e-2, 0.0, 0, VAL_GUARD}}, 3

static const val_part sod_m3 = {
    "m3", "m = 3", "nodes along", VAL_BY_N, NULL, 1.0, SOD_MEASURES, SOD_GOALS,
    {{100, 3.0, 0.0}, {200, 3.0, 0.0}, {400, 3.0, 0.0}, {800, 3.0, 0.0}}, PD_DIM == 1 ? 4 : 3, PD_DIM == 1 ? 3 : 1,
    sod_run, NULL};
static const val_part sod_m1 = {
    "m1", "m = 1", "nodes along", VAL_BY_N, NULL, 1.0, SOD_MEASURES, SOD_GOALS,
    {{100, 1.0, 0.0}, {200, 1.0, 0.0}, {400, 1.0, 0.0}, {800, 1.0, 0.0}}, PD_DIM == 1 ? 4 : 3, PD_DIM == 1 ? 3 : 1,
    sod_run, NULL};
static const val_part *const sod_parts[] = {&sod_m3, &sod_m1};

static const val_case sod_case = {
    "sod", "Shock tube",
    "Gas at 1 and at 0.1 Pa on both sides of a membrane that breaks: a rarefaction, a contact and a shock, until "
    "0.2 s. Mean error of the density; nodes whose density or pressure is not positive, summed over all steps. In 2D "
    "and 3D the tube is two nodes wide, between mirrors.",
    "A shock at the wrong speed because a scheme does not conserve, expansion shocks, oscillations that make a density "
    "negative, mirrors that act as walls.",
    "exact solution of the Riemann problem of G. A. Sod, J. Comput. Phys. 27, 1978",
    sod_parts, 2};

#endif
