/* clock: orders in time of all integrators, on a wave that the lattice carries in closed form. */
#ifndef VAL_CLOCK_H
#define VAL_CLOCK_H
#if PD_DIM == 2

/* ---- time_order ---- */

/* A wave along y in a periodic unit square, c = cos(k y) [mol/m3], or the same for u [m/s] or the density: an
 * eigenvector of the sums over bonds, so the exact solution in time is exp(lambda t), and only steps are in error. */
#define CLOCK_NU 0.05   /* [m2/s] diffusivity and viscosity */
#define CLOCK_SOUND 1.0 /* [m/s] of the weakly compressible flow */
#define CLOCK_FAINT 1e-3 /* [m/s] amplitude of its velocity */
#define CLOCK_SPEED 3.0 /* [m/s] of the gas, above that of sound */
#define CLOCK_WAVE 0.2  /* [-] amplitude of its density */

static double clock_cosine(const val_lab *lab, int32_t node, double shift)
{
    double x[PD_DIM];
    pd_grid_position(&lab->grid, node, x);
    return cos(2.0 * val_pi * (x[1] - shift));
}

/* Decay rate [1/s] by (1.3): sum a (1 - cos k.xi) times the diffusivity. */
static double clock_rate(const val_lab *lab)
{
    double sum = 0.0;
    for (int k = 0; k < lab->stencil.count; k++)
        sum += lab->stencil.laplacian_weight[k] * (1.0 - cos(2.0 * val_pi * lab->stencil.xi[k * PD_DIM + 1]));
    return CLOCK_NU * sum;
}

static pd_status clock_build(val_job *job, int parts)
{
    val_lab *lab = job->lab;
    lab_box(lab, 1.0 / job->level.n, job->level.m, 0.0, 1.0);
    for (int side = 0; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_PERIODIC;
    enclosed_fluid(lab, CLOCK_NU);
    lab->transport_desc.diffusivity = CLOCK_NU;
    lab->steady_desc.tolerance = 1e-12;
    job->out->h = lab->stencil_desc.h[0];
    job->out->x = 1.0 / job->level.p;
    job->out->steps = (long)job->level.p;
    return lab_build(job->ctx, lab, parts);
}

/* field = (pass 0), or compare it with (pass 1), mean + size cos(k (y - shift)). */
static void clock_field(val_job *job, int pass, double *field, double mean, double size, double shift)
{
    const val_lab *lab = job->lab;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        if (lab->grid.kind[i] != PD_FLUID) continue;
        double wanted = mean + size * clock_cosine(lab, i, shift);
        if (pass) job->out->err[0] = fmax(job->out->err[0], fabs(field[i] - wanted));
        else field[i] = wanted;
    }
}

typedef enum clock_kind {
    CLOCK_IMPLICIT,
    CLOCK_TWO_STAGE,
    CLOCK_EXPLICIT
} clock_kind;

/* Transport to t = 1 s (explicit steps: 0.1 s). */
static pd_status clock_transport(val_job *job, clock_kind kind)
{
    val_lab *lab = job->lab;
    pd_transport_result result;
    pd_two_stage two_stage;
    pd_two_stage_desc desc;
    pd_status status = clock_build(job, VAL_TRANSPORT);
    double end = kind == CLOCK_EXPLICIT ? 0.1 : 1.0, dt = end / job->level.p;
    memset(&two_stage, 0, sizeof two_stage);
    memset(&desc, 0, sizeof desc);
    if (status < 0) return status;
    status = pd_two_stage_build(job->ctx, &lab->transport, &desc, &two_stage);
    clock_field(job, 0, lab->transport.c, 2.0, 1.0, 0.0);
    for (int step = 0; step < (int)job->level.p && status == PD_OK; step++)
        status = kind == CLOCK_IMPLICIT   ? pd_transport_implicit(job->ctx, &lab->transport, dt, &result)
                 : kind == CLOCK_EXPLICIT ? pd_transport_explicit(job->ctx, &lab->transport, dt)
                                          : pd_two_stage_step(job->ctx, &two_stage, dt, &result);
    clock_field(job, 1, lab->transport.c, 2.0, exp(-clock_rate(lab) * end), 0.0);
    pd_two_stage_free(job->ctx, &two_stage);
    return status;
}

static pd_status clock_implicit_run(val_job *job) { return clock_transport(job, CLOCK_IMPLICIT); }
static pd_status clock_two_stage_run(val_job *job) { return clock_transport(job, CLOCK_TWO_STAGE); }
static pd_status clock_explicit_run(val_job *job) { return clock_transport(job, CLOCK_EXPLICIT); }

/* A shear wave: convection and pressure vanish in the sums. */
static pd_status clock_flow_run(val_job *job)
{
    val_lab *lab = job->lab;
    PD_TRY(clock_build(job, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    clock_field(job, 0, lab->flow.u, 0.0, 1.0, 0.0);
    for (int step = 0; step < (int)job->level.p; step++) {
        pd_status status = pd_implicit_step(job->ctx, &lab->implicit, 1.0 / job->level.p);
        if (status != PD_OK) return status < 0 ? status : PD_ERR_STATE;
    }
    clock_field(job, 1, lab->flow.u, 0.0, exp(-clock_rate(lab)), 0.0);
    return PD_OK;
}

/* The same, weakly compressible: its density stays as it is. To t = 0.5 s. */
static pd_status clock_unsteady_run(val_job *job)
{
    val_lab *lab = job->lab;
    pd_weakly_compressible un;
    pd_weakly_compressible_desc desc;
    memset(&un, 0, sizeof un);
    memset(&desc, 0, sizeof desc);
    desc.sound_speed = CLOCK_SOUND;
    PD_TRY(clock_build(job, VAL_FLOW));
    clock_field(job, 0, lab->flow.u, 0.0, CLOCK_FAINT, 0.0);
    pd_status status = pd_weakly_compressible_build(job->ctx, &lab->flow, &desc, &un);
    for (int step = 0; step < (int)job->level.p && status == PD_OK; step++)
        status = pd_weakly_compressible_step(job->ctx, &un, 0.5 / job->level.p);
    clock_field(job, 1, lab->flow.u, 0.0, CLOCK_FAINT * exp(-0.5 * clock_rate(lab)), 0.0);
    job->out->err[0] /= CLOCK_FAINT;
    pd_weakly_compressible_free(job->ctx, &un);
    return status;
}

static void clock_gas_start(void *user, const double *x, double *rho, double *v, double *p)
{
    (void)user;
    *rho = 1.0 + CLOCK_WAVE * cos(2.0 * val_pi * x[1]);
    *p = 1.0;
    v[0] = 0.0;
    v[1] = CLOCK_SPEED;
}

/* A wave of density that moves with a gas of one speed and pressure, first order in space, over a tenth of its length.
 * A flux takes the density of its upwind end (4.3), so the mode has the rate
 * lambda = - sum over g.v > 0 of 2 g.v (1 - exp(-i k.xi)). */
static pd_status clock_gas_run(val_job *job)
{
    val_lab *lab = job->lab;
    double end = 0.1 / CLOCK_SPEED, decay = 0.0, turn = 0.0;
    lab->gas_desc.gamma = 1.4;
    lab->gas_desc.spatial_order = PD_GAS_FIRST;
    lab->gas_desc.initial = clock_gas_start;
    PD_TRY(clock_build(job, VAL_GAS));
    for (int step = 0; step < (int)job->level.p; step++) {
        pd_status status = pd_gas_step(job->ctx, &lab->gas, end / job->level.p);
        if (status != PD_OK) return status < 0 ? status : PD_ERR_STATE;
    }
    for (int k = 0; k < lab->stencil.count; k++) {
        double speed = 2.0 * lab->stencil.gradient_weight[k * PD_DIM + 1] * CLOCK_SPEED;
        double angle = 2.0 * val_pi * lab->stencil.xi[k * PD_DIM + 1];
        if (!(speed > 0.0)) continue;
        decay += speed * (1.0 - cos(angle));
        turn += speed * sin(angle);
    }
    clock_field(job, 1, lab->gas.state, 1.0, CLOCK_WAVE * exp(-decay * end), turn * end / (2.0 * val_pi));
    return PD_OK;
}

/* Metal in one half of the square dissolves into the other one, which is mixed at once: c = Csat (1 - exp(-k t)) with
 * k = 1/s. Too little of it goes for a node to turn fluid. */
static pd_status clock_dissolve_run(val_job *job)
{
    val_lab *lab = job->lab;
    val_law law = {5e-6, 1.0};
    lab_box(lab, 1.0 / job->level.n, job->level.m, 0.0, 1.0);
    lab->grid_desc.side[2] = lab->grid_desc.side[3] = PD_SIDE_PERIODIC;
    lab->grid_desc.solid = &lab->shapes[0];
    lab->shapes[0].type = PD_SHAPE_HALF_SPACE;
    lab->shapes[0].a[0] = 0.5;
    lab->shapes[0].b[0] = 1.0;
    lab->transport_desc.diffusivity = 1e6;
    lab->transport_desc.tolerance = 1e-12;
    lab->dissolve_desc.solid = 1e5;
    lab->dissolve_desc.rate = dissolution_law;
    lab->dissolve_desc.rate_user = &law;
    lab->couple_desc.max_step = 1.0 / job->level.p;
    lab->couple_desc.fraction = 1.0;
    PD_TRY(lab_build(job->ctx, lab, VAL_TRANSPORT | VAL_DISSOLVE | VAL_COUPLE));
    PD_TRY(pd_time_loop_run(job->ctx, &lab->couple, 1.0, 0.0, NULL, NULL));
    for (int32_t i = 0; i < lab->grid.total; i++)
        if (lab->grid.kind[i] == PD_FLUID)
            job->out->err[0] = fmax(job->out->err[0], fabs(lab->transport.c[i] + expm1(-1.0)));
    job->out->h = lab->stencil_desc.h[0];
    job->out->x = 1.0 / job->level.p;
    job->out->steps = (long)lab->couple.steps;
    return PD_OK;
}

#define CLOCK_MEASURE {{"err_max", "largest error"}}, 1
#define CLOCK_PART(name, title, order, least, first, run) \
    {name, title, "steps", VAL_BY_P, "1/steps [-]", order, CLOCK_MEASURE, {{0, 0.0, least, 0, VAL_GOAL}}, 1, \
     {{16, 2.0, first}, {16, 2.0, 2.0 * first}, {16, 2.0, 4.0 * first}, {16, 2.0, 8.0 * first}}, 4, 3, run, NULL}

static const val_part clock_parts_all[] = {
    CLOCK_PART("transport", "transport, implicit step of first order", 1.0, 0.95, 16.0, clock_implicit_run),
    CLOCK_PART("two_stage", "transport, implicit steps of second order", 2.0, 1.95, 8.0, clock_two_stage_run),
    CLOCK_PART("explicit", "transport, explicit step", 1.0, 0.95, 64.0, clock_explicit_run),
    CLOCK_PART("flow", "incompressible flow, implicit", 2.0, 1.95, 8.0, clock_flow_run),
    CLOCK_PART("unsteady", "weakly compressible flow, explicit", 3.0, 2.9, 64.0, clock_unsteady_run),
    CLOCK_PART("gas", "gas, explicit, first order in space", 3.0, 2.9, 16.0, clock_gas_run),
    CLOCK_PART("dissolve", "dissolution", 1.0, 0.95, 16.0, clock_dissolve_run)};
static const val_part *const clock_parts[] = {&clock_parts_all[0], &clock_parts_all[1], &clock_parts_all[2],
                                              &clock_parts_all[3], &clock_parts_all[4], &clock_parts_all[5],
                                              &clock_parts_all[6]};

static const val_case clock_case = {
    "time_order", "Orders in time",
    "A wave in a periodic square, 16 nodes long, m = 2, which the sums over bonds only multiply by a number: "
    "concentration that diffuses, velocity across the wave, the density of a gas of one speed. So the solution in time "
    "is an exponential in closed form, and what is left is the error of the steps: its largest value at the end. The "
    "dissolution of metal into a mixed fluid up to saturation is one, too.",
    "A stage at the wrong time, weights that only look like those of the method, a solver that stops too early to show "
    "the order.",
    "closed form with the sums of the stencil",
    clock_parts, (int)(sizeof clock_parts / sizeof clock_parts[0])};

#endif
#endif
