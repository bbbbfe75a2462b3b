/* rotation: shapes that a stream carries round without diffusion. */
#ifndef VAL_ROTATION_H
#define VAL_ROTATION_H
#if PD_DIM < 3

/* ---- rotation ---- */

/* A field of peak 1 at x in a periodic unit square. */
typedef double (*rotation_field_fn)(const double *x);
typedef void (*rotation_stream_fn)(void *user, const double *x, double *u);

static pd_status rotation_build(val_job *job, rotation_field_fn field, rotation_stream_fn stream)
{
    val_lab *lab = job->lab;
    lab_box(lab, 1.0 / job->level.n, job->level.m, 0.0, 1.0);
    for (int side = 0; side < 2 * PD_DIM; side++) lab->grid_desc.side[side] = PD_SIDE_PERIODIC;
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.report_speed = lab->flow_desc.report_length = 1.0;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    PD_TRY(lab_fields(job->ctx, lab, 2, 1));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&lab->grid, i, x);
        stream(NULL, x, u);
        for (int d = 0; d < PD_DIM; d++) lab->flow.u[(int64_t)d * lab->grid.total + i] = u[d];
        lab->field[0][i] = lab->transport.c[i] = field(x);
    }
    pdi_flow_update_derived_fields(job->ctx, &lab->flow);
    job->out->h = lab->grid.h[0];
    return pd_transport_update(job->ctx, &lab->transport);
}

/* c = keep start + (1 - keep) c */
static void rotation_mix(val_job *job, double keep)
{
    val_lab *lab = job->lab;
    for (int32_t i = 0; i < lab->grid.total; i++)
        if (lab->grid.kind[i] == PD_FLUID)
            lab->transport.c[i] = keep * lab->field[1][i] + (1.0 - keep) * lab->transport.c[i];
}

static double rotation_beyond(const val_lab *lab, double *peak)
{
    double beyond = 0.0;
    *peak = 0.0;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        if (lab->grid.kind[i] != PD_FLUID) continue;
        *peak = fmax(*peak, lab->transport.c[i]);
        beyond = fmax(beyond, -lab->transport.c[i]);
    }
    return beyond;
}

/* Steps of third order to t = 1: means of explicit steps (Shu and Osher 1988), which keep what each of them keeps. They
 * are as long as explicit ones may be, so that the error in time is small beside that in space. */
static pd_status rotation_steps(val_job *job, double most)
{
    val_lab *lab = job->lab;
    pd_transport *t = &lab->transport;
    double peak;
    int steps = (int)ceil(1.0 / pd_transport_limit(job->ctx, t));
    for (int step = 0; step < steps; step++) {
        for (int32_t i = 0; i < lab->grid.total; i++) lab->field[1][i] = t->c[i];
        PD_TRY(pd_transport_explicit(job->ctx, t, 1.0 / steps));
        PD_TRY(pd_transport_explicit(job->ctx, t, 1.0 / steps));
        rotation_mix(job, 0.75);
        PD_TRY(pd_transport_explicit(job->ctx, t, 1.0 / steps));
        rotation_mix(job, 1.0 / 3.0);
        double below = rotation_beyond(lab, &peak);
        job->out->err[2] = fmax(job->out->err[2], fmax(below, peak - most));
    }
    job->out->steps = steps;
    return PD_OK;
}

/* What of the peak is lost, and the sum of the differences over that of the field. */
static pd_status rotation_run(val_job *job, rotation_field_fn field, rotation_stream_fn stream)
{
    const val_lab *lab = job->lab;
    double most, peak, off = 0.0, size = 0.0;
    PD_TRY(rotation_build(job, field, stream));
    rotation_beyond(lab, &most);
    PD_TRY(rotation_steps(job, most));
    rotation_beyond(lab, &peak);
    for (int32_t i = 0; i < lab->grid.total; i++) {
        if (lab->grid.kind[i] != PD_FLUID) continue;
        off += fabs(lab->transport.c[i] - lab->field[0][i]);
        size += lab->field[0][i];
    }
    job->out->err[0] = fmax(1.0 - peak / most, 0.0);
    job->out->err[1] = off / size;
    return PD_OK;
}

static void rotation_along(void *user, const double *x, double *u)
{
    (void)user, (void)x;
    for (int d = 0; d < PD_DIM; d++) u[d] = 1.0;
}

/* A wave along the diagonal. */
static double rotation_wave(const double *x)
{
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) sum += x[d];
    return 0.5 + 0.5 * sin(2.0 * val_pi * sum);
}

static pd_status rotation_wave_run(val_job *job) { return rotation_run(job, rotation_wave, rotation_along); }

#define ROTATION_MEASURES {{"lost", "peak lost"}, {"err", "c, L1"}, {"overshoot", "overshoot"}}, 3

static const val_part rotation_wave_part = {
    "wave", "Wave along the diagonal of a uniform stream", "cells", VAL_BY_N, NULL, 2.0, ROTATION_MEASURES,
    {{1, 0.0, 1.9, 0, VAL_GOAL_OF_ALL}, {2, 1e-14, 0.0, 0, VAL_GOAL}, {1, 0.3, 0.0, 0, VAL_GUARD}}, 3,
    {{16, 1.0, 0.0}, {32, 1.0, 0.0}, {64, 1.0, 0.0}, {128, 1.0, 0.0}}, 4, 2, rotation_wave_run,
    "Summits lose what limits take from them: the field is held within what it began with, node by node."};

#if PD_DIM == 2
static void rotation_turn(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = 2.0 * val_pi * (0.5 - x[1]);
    u[1] = 2.0 * val_pi * (x[0] - 0.5);
}

static double rotation_cone(const double *x) { return fmax(1.0 - hypot(x[0] - 0.5, x[1] - 0.25) / 0.15, 0.0); }

static double rotation_disc(const double *x)
{
    int slot = fabs(x[0] - 0.5) < 0.025 && x[1] < 0.85;
    return hypot(x[0] - 0.5, x[1] - 0.75) < 0.15 && !slot ? 1.0 : 0.0;
}

static pd_status rotation_cone_run(val_job *job) { return rotation_run(job, rotation_cone, rotation_turn); }
static pd_status rotation_disc_run(val_job *job) { return rotation_run(job, rotation_disc, rotation_turn); }

static const val_part rotation_cone_part = {
    "cone", "Cone, one turn", "cells", VAL_BY_N, NULL, 1.0, ROTATION_MEASURES,
    {{0, 0.05, 0.0, 100, VAL_GOAL}, {1, 0.05, 0.0, 100, VAL_GOAL}, {2, 1e-14, 0.0, 0, VAL_GOAL},
     {0, 0.4, 0.0, 0, VAL_GUARD}, {1, 0.3, 0.0, 0, VAL_GUARD}}, 5,
    {{50, 1.0, 0.0}, {100, 1.0, 0.0}}, 2, 1, rotation_cone_run,
    "The summit is a corner, which no polynomial follows; limits add nothing (theory: eq. 6.17 to 6.19)."};
static const val_part rotation_disc_part = {
    "disc", "Zalesak's disc, one turn", "cells", VAL_BY_N, NULL, 1.0, ROTATION_MEASURES,
    {{0, 0.02, 0.0, 100, VAL_GOAL}, {1, 0.25, 0.0, 100, VAL_GOAL}, {2, 1e-14, 0.0, 0, VAL_GOAL},
     {0, 0.3, 0.0, 0, VAL_GUARD}, {1, 0.9, 0.0, 0, VAL_GUARD}}, 5,
    {{50, 1.0, 0.0}, {100, 1.0, 0.0}}, 2, 1, rotation_disc_run,
    "The slot is five cells wide: its edges smear over one or two cells on either side."};
static const val_part *const rotation_parts[] = {&rotation_wave_part, &rotation_cone_part, &rotation_disc_part};
#else
static const val_part *const rotation_parts[] = {&rotation_wave_part};
#endif

static const val_case rotation_case = {
    "rotation", "Shapes in a stream without diffusion",
    "A wave goes once through a periodic box, along the diagonal in 2D. In 2D a cone of radius 0.15 and Zalesak's "
    "slotted disc of the same radius turn once about the middle of a unit square. What of the peak is lost, the sum of "
    "the differences over that of the field, and how far the field leaves its bounds at any step. Steps are of third "
    "order in time and short.",
    "Upwinding across the stream, limiters that clip summits, oscillations, fluxes of low order.",
    "the start of each; S. T. Zalesak, J. Comput. Phys. 31, 1979; R. J. LeVeque, SIAM J. Numer. Anal. 33, 1996",
    rotation_parts, (int)(sizeof rotation_parts / sizeof rotation_parts[0])};

#endif
#endif
