/* cases: the integrators, each with the box that shows its limit. Lengths are in cells and h = 1. */
#ifndef STABILITY_CASES_H
#define STABILITY_CASES_H

enum { STAB_POINTS = 12 };

/* What was measured at one m and one abscissa. Times in units in which the box of the case is written. */
typedef struct stab_point {
    double step;    /* that the integrator chooses, its safety factor left out */
    double stable;  /* longest one that lets no wave grow; 0: not asked */
    double bounded; /* longest one that keeps every node within its neighbours; 0: it is not there for that */
    double growth;  /* [-] implicit: largest disturbance after a step over that before */
    double unit;    /* makes a step the ordinate of the map */
} stab_point;

typedef struct stab_case {
    const char *name, *title, *what;
    const char *key; /* of the abscissa in result lines */
    const char *x_label, *y_label;
    double least; /* [-] of step over limit */
    int implicit;
    double x[STAB_POINTS];
    int count;
    pd_status (*run)(pd_ctx *ctx, val_lab *lab, double m, double x, stab_point *point);
} stab_case;

/* A periodic box that is wider than twice the reach of a step that looks `looks` families far. */
static void stab_box(val_lab *lab, double m, int looks)
{
    int n = 2 * looks * (int)m + 2;
    lab_box(lab, 1.0, m, 0.0, n);
    for (int s = 0; s < 2 * PD_DIM; s++) lab->grid_desc.side[s] = PD_SIDE_PERIODIC;
}

/* The node in the middle, and the offset of another one from it. */
static int32_t stab_middle(const pd_grid *grid)
{
    int i[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) i[d] = grid->n[d] / 2;
    return pd_grid_node(grid, i);
}

static void stab_offset(const pd_grid *grid, int32_t node, int *n)
{
    pd_grid_index(grid, node, n);
    for (int d = 0; d < PD_DIM; d++) n[d] -= grid->n[d] / 2;
}

/* Responses of all fields to an impulse in field b: rate [fields][total] times `factor`. */
static void stab_collect(const pd_grid *grid, int fields, const double *rate, int b, double factor, symbol *s)
{
    for (int a = 0; a < fields; a++)
        for (int32_t i = 0; i < grid->total; i++) {
            int n[PD_DIM];
            if (grid->kind[i] != PD_FLUID) continue;
            stab_offset(grid, i, n);
            symbol_add(s, a, b, n, factor * rate[(int64_t)a * grid->total + i]);
        }
}

/* Components of a direction that is no axis. */
static double stab_along(int d)
{
    static const double along[3] = {0.8, 0.52, 0.3};
    double square = 0.0;
    for (int e = 0; e < PD_DIM; e++) square += along[e] * along[e];
    return along[d] / sqrt(square);
}

static void stab_stream(pd_flow *flow, double speed)
{
    for (int32_t i = 0; i < flow->grid->total; i++)
        for (int d = 0; d < PD_DIM; d++)
            flow->u[(int64_t)d * flow->grid->total + i] =
                pdi_grid_is_open(flow->grid->kind[i]) ? speed * stab_along(d) : 0.0;
}

static uint32_t stab_noise(double *x, const pd_grid *grid, double mean, double size)
{
    uint32_t seed = 77;
    for (int32_t i = 0; i < grid->total; i++) {
        seed = seed * 1664525u + 1013904223u;
        if (grid->kind[i] == PD_FLUID) x[i] = mean + size * (2.0 * (seed / 4294967296.0) - 1.0);
    }
    return seed;
}

/* ---- explicit transport ---- */

/* x: cell Peclet number U h/D. D = 1. The operator is found from a step of the code at its limit, so nothing is divided
 * by a small number. Bounded: every coefficient of the step is at least 0. */
static pd_status stab_transport(pd_ctx *ctx, val_lab *lab, double m, double x, stab_point *point)
{
    symbol s;
    double centre = 0.0, least = 0.0;
    stab_box(lab, m, 1);
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.report_speed = lab->flow_desc.report_length = 1.0;
    lab->transport_desc.diffusivity = 1.0;
    lab->transport_desc.advection = PD_ADVECTION_UPWIND;
    PD_TRY(lab_build(ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    stab_stream(&lab->flow, x);
    pdi_flow_update_derived_fields(ctx, &lab->flow);
    pd_transport *t = &lab->transport;
    int32_t middle = stab_middle(&lab->grid);
    PD_TRY(pd_transport_update(ctx, t));
    t->c[middle] = 1.0;
    double limit = pd_transport_limit(ctx, t);
    PD_TRY(pd_transport_explicit(ctx, t, limit));
    t->c[middle] -= 1.0;
    for (int32_t i = 0; i < lab->grid.total; i++) {
        if (lab->grid.kind[i] != PD_FLUID) continue;
        if (i == middle) centre = t->c[i] / limit;
        else least = fmin(least, t->c[i] / limit);
    }
    if (!symbol_build(&s, 1)) return pd_fail(ctx, PD_ERR_MEMORY, "stability", "out of memory");
    stab_collect(&lab->grid, 1, t->c, 0, 1.0 / limit, &s);
    point->step = limit;
    point->stable = symbol_limit(&s, 1, limit);
    point->bounded = least < -1e-12 * fabs(centre) ? 0.0 : -1.0 / centre;
    point->unit = 1.0; /* D/h2 */
    symbol_free(&s);
    return PD_OK;
}

/* ---- weakly compressible flow ---- */

static pd_weakly_compressible stab_un;

/* Rates at a state that a step too short to change anything starts from. */
static pd_status stab_unsteady_rates(pd_ctx *ctx, const val_lab *lab, double size, int b, double *rate)
{
    pd_weakly_compressible *un = &stab_un;
    int32_t total = lab->grid.total, middle = stab_middle(&lab->grid);
    stab_stream(un->flow, 0.1);
    for (int32_t i = 0; i < total; i++) un->density[i] = 1.0;
    if (b < PD_DIM) un->flow->u[(int64_t)b * total + middle] += size;
    else un->density[middle] += size;
    PD_TRY(pd_weakly_compressible_step(ctx, un, 1e-12));
    memcpy(rate, un->time_derivative, (size_t)(PD_DIM + 1) * (size_t)total * sizeof *rate);
    return PD_OK;
}

/* x: kinematic viscosity over sound speed times spacing; sound speed and spacing 1, a stream at a tenth of it. The
 * linear step about the stream, by central differences of an equation of state that is linear. */
static pd_status stab_unsteady(pd_ctx *ctx, val_lab *lab, double m, double x, stab_point *point)
{
    pd_weakly_compressible_desc desc;
    symbol s;
    memset(&desc, 0, sizeof desc);
    memset(&stab_un, 0, sizeof stab_un);
    stab_box(lab, m, 2);
    lab->flow_desc.rho = lab->flow_desc.report_speed = lab->flow_desc.report_length = 1.0;
    lab->flow_desc.mu = x;
    desc.eos = PD_EOS_LINEAR;
    desc.sound_speed = 1.0;
    PD_TRY(lab_build(ctx, lab, VAL_FLOW));
    PD_TRY(lab_fields(ctx, lab, 2, PD_DIM + 1));
    pd_status status = pd_weakly_compressible_build(ctx, &lab->flow, &desc, &stab_un);
    if (!symbol_build(&s, PD_DIM + 1)) status = pd_fail(ctx, PD_ERR_MEMORY, "stability", "out of memory");
    for (int b = 0; b <= PD_DIM && status == PD_OK; b++) {
        const double size = 1e-4;
        status = stab_unsteady_rates(ctx, lab, size, b, lab->field[0]);
        if (status == PD_OK) status = stab_unsteady_rates(ctx, lab, -size, b, lab->field[1]);
        for (size_t k = 0; k < lab->field_size; k++) {
            lab->field[0][k] -= lab->field[1][k];
            if (fabs(lab->field[0][k]) < 1e-13) lab->field[0][k] = 0.0; /* rounding */
        }
        stab_collect(&lab->grid, PD_DIM + 1, lab->field[0], b, 0.5 / size, &s);
    }
    if (status == PD_OK) {
        stab_stream(&lab->flow, 0.1);
        point->step = pd_weakly_compressible_limit(ctx, &stab_un);
        point->stable = symbol_limit(&s, 3, point->step);
        point->unit = 1.0; /* c/h */
    }
    symbol_free(&s);
    pd_weakly_compressible_free(ctx, &stab_un);
    return status;
}

/* ---- gas ---- */

/* A stream of Mach number *user in a gas of density 1 and sound speed 1, gamma = 1.4. */
static void stab_gas_state(void *user, const double *x, double *rho, double *v, double *p)
{
    (void)x;
    *rho = 1.0;
    *p = 1.0 / 1.4;
    for (int d = 0; d < PD_DIM; d++) v[d] = *(const double *)user * stab_along(d);
}

/* Longest Euler step [s] that keeps density and pressure of a node positive; *limit: what the code says of that state.
 * Away: all others have a million times its density and run away from it at a hundred times its speed of sound, else
 * they have a millionth of it and are at rest. */
static pd_status stab_gas_emptied(pd_ctx *ctx, pd_gas *gas, double mach, int away, double *limit, double *longest)
{
    int64_t total = gas->grid->total;
    int32_t middle = stab_middle(gas->grid);
    double low = 0.0, high;
    for (int32_t i = 0; i < total; i++) {
        double rho = i == middle ? 1.0 : away ? 1e6 : 1e-6, p = i == middle || away ? 1.0 : rho;
        double v[PD_DIM], size = 0.0;
        int n[PD_DIM];
        if (gas->grid->kind[i] != PD_FLUID) continue;
        stab_offset(gas->grid, i, n);
        for (int d = 0; d < PD_DIM; d++) size += n[d] * n[d];
        for (int d = 0; d < PD_DIM; d++)
            v[d] = i == middle ? mach * stab_along(d) : away ? 100.0 * n[d] / sqrt(size) : 0.0;
        gas->state[i] = rho;
        gas->state[(PD_DIM + 1) * total + i] = p / 1.4 / 0.4;
        for (int d = 0; d < PD_DIM; d++) {
            gas->state[(d + 1) * total + i] = rho * v[d];
            gas->state[(PD_DIM + 1) * total + i] += 0.5 * rho * v[d] * v[d];
        }
    }
    PD_TRY(pd_gas_limit(ctx, gas, limit));
    *limit = 1.0 / gas->time_derivative[middle]; /* that of the node itself */
    PD_TRY(pd_gas_step(ctx, gas, 1e-14));
    high = 64.0 * *limit;
    for (int step = 0; step < 60; step++) {
        double dt = 0.5 * (low + high), u[PD_GAS_FIELDS], energy;
        for (int c = 0; c < PD_GAS_FIELDS; c++)
            u[c] = gas->state[c * total + middle] + dt * gas->time_derivative[c * total + middle];
        energy = u[PD_DIM + 1];
        for (int d = 0; d < PD_DIM; d++) energy -= 0.5 * u[d + 1] * u[d + 1] / u[0];
        if (u[0] > 0.0 && energy > 0.0) low = dt;
        else high = dt;
    }
    *longest = low;
    return PD_OK;
}

/* x: Mach number. First order, where the limit is one of positivity. */
static pd_status stab_gas(pd_ctx *ctx, val_lab *lab, double m, double x, stab_point *point)
{
    static double mach;
    symbol s;
    pd_gas *gas = &lab->gas;
    mach = x;
    stab_box(lab, m, 1);
    lab->gas_desc.gamma = 1.4;
    lab->gas_desc.spatial_order = PD_GAS_FIRST;
    lab->gas_desc.initial = stab_gas_state;
    lab->gas_desc.initial_user = &mach;
    PD_TRY(lab_build(ctx, lab, VAL_GAS));
    PD_TRY(lab_fields(ctx, lab, 3, PD_GAS_FIELDS));
    int32_t middle = stab_middle(&lab->grid);
    int64_t total = lab->grid.total;
    PD_TRY(pd_gas_limit(ctx, gas, &point->step));
    memcpy(lab->field[2], gas->state, lab->field_size * sizeof *gas->state);
    if (!symbol_build(&s, PD_GAS_FIELDS)) return pd_fail(ctx, PD_ERR_MEMORY, "stability", "out of memory");
    pd_status status = PD_OK;
    for (int b = 0; b < PD_GAS_FIELDS && status == PD_OK; b++) {
        const double size = 1e-5;
        for (int sign = 0; sign < 2 && status == PD_OK; sign++) {
            memcpy(gas->state, lab->field[2], lab->field_size * sizeof *gas->state);
            gas->state[b * total + middle] += sign ? -size : size;
            status = pd_gas_step(ctx, gas, 1e-12);
            memcpy(lab->field[sign], gas->time_derivative, lab->field_size * sizeof *gas->time_derivative);
        }
        for (size_t k = 0; k < lab->field_size; k++) {
            lab->field[0][k] -= lab->field[1][k];
            if (fabs(lab->field[0][k]) < 1e-13) lab->field[0][k] = 0.0; /* rounding */
        }
        stab_collect(&lab->grid, PD_GAS_FIELDS, lab->field[0], b, 0.5 / size, &s);
    }
    if (status == PD_OK) {
        point->stable = symbol_limit(&s, 3, point->step);
        point->bounded = HUGE_VAL;
        for (int away = 0; away < 2 && status == PD_OK; away++) {
            double limit = 1.0, longest = 0.0;
            status = stab_gas_emptied(ctx, gas, x, away, &limit, &longest);
            point->bounded = fmin(point->bounded, longest / limit * point->step); /* at the limit of that state */
        }
    }
    point->unit = 1.0;
    symbol_free(&s);
    return status;
}

/* ---- implicit steps ---- */

static double stab_spread(const pd_grid *grid, const double *c, double mean)
{
    double worst = 0.0;
    for (int32_t i = 0; i < grid->total; i++)
        if (grid->kind[i] == PD_FLUID) worst = fmax(worst, fabs(c[i] - mean));
    return worst;
}

/* x: step over the explicit limit. Random values at cell Peclet number 100, in a periodic box. */
static pd_status stab_two_stage(pd_ctx *ctx, val_lab *lab, double m, double x, stab_point *point)
{
    pd_two_stage two_stage;
    pd_two_stage_desc desc;
    pd_transport_result result;
    memset(&desc, 0, sizeof desc);
    stab_box(lab, m, 1);
    lab->flow_desc.rho = lab->flow_desc.mu = lab->flow_desc.report_speed = lab->flow_desc.report_length = 1.0;
    lab->transport_desc.diffusivity = 1.0;
    PD_TRY(lab_build(ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    stab_stream(&lab->flow, 100.0);
    pdi_flow_update_derived_fields(ctx, &lab->flow);
    PD_TRY(pd_transport_update(ctx, &lab->transport));
    stab_noise(lab->transport.c, &lab->grid, 2.0, 1.0);
    double mean = pd_transport_stock(ctx, &lab->transport) / (double)lab->grid.fluid_count;
    double before = stab_spread(&lab->grid, lab->transport.c, mean);
    PD_TRY(pd_two_stage_build(ctx, &lab->transport, &desc, &two_stage));
    point->step = x * pd_transport_limit(ctx, &lab->transport);
    pd_status status = pd_two_stage_step(ctx, &two_stage, point->step, &result);
    point->growth = stab_spread(&lab->grid, lab->transport.c, mean) / before;
    point->unit = 1.0;
    pd_two_stage_free(ctx, &two_stage);
    return status < 0 ? status : PD_OK;
}

static double stab_energy(const pd_flow *flow)
{
    double sum = 0.0;
    for (int32_t i = 0; i < flow->grid->total; i++)
        for (int d = 0; d < PD_DIM && flow->grid->kind[i] == PD_FLUID; d++)
            sum += pow(flow->u[(int64_t)d * flow->grid->total + i], 2.0);
    return sqrt(sum);
}

/* x: step over the explicit limit of viscosity. Random velocities, cell Reynolds number 10, between walls. */
static pd_status stab_implicit(pd_ctx *ctx, val_lab *lab, double m, double x, stab_point *point)
{
    lab_box(lab, 1.0, m, 0.0, PD_DIM == 3 ? 10.0 : 16.0);
    lab->flow_desc.rho = lab->flow_desc.report_speed = 1.0;
    lab->flow_desc.report_length = 10.0;
    lab->flow_desc.mu = 0.1;
    PD_TRY(lab_build(ctx, lab, VAL_FLOW | VAL_STEADY | VAL_IMPLICIT));
    for (int d = 0; d < PD_DIM; d++)
        stab_noise(lab->flow.u + (int64_t)d * lab->grid.total, &lab->grid, 0.0, 1.0 / (d + 1));
    double before = stab_energy(&lab->flow);
    point->step = x / (2.0 * lab->stencil.lap_sum * lab->flow.nu);
    PD_TRY(pd_implicit_step(ctx, &lab->implicit, point->step));
    point->growth = stab_energy(&lab->flow) / before;
    point->unit = 1.0;
    return PD_OK;
}

/* ---- the table ---- */

static const stab_case stab_cases[] = {
    {"transport",
     "explicit transport",
     "Forward Euler steps of upwinded advection and diffusion in a uniform stream that is no axis, on a periodic box. "
     "The"
     " step of the code is one of bounds: it keeps every node within its neighbours, which is what the limiter builds "
     "on,"
     " and it is refused above. `stable to` says how far a step could go without any wave growing, overshoots allowed.",
     "peclet",
     "cell Peclet number U h/D [-]",
     "diffusion number D dt/h2 [-]",
     0.9,
     0,
     {1e-2, 1e-1, 1.0, 3.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6},
     10,
     stab_transport},
    {"unsteady",
     "explicit weakly compressible flow",
     "Three-stage Runge-Kutta steps about a uniform stream at a tenth of the speed of sound, linear equation of "
     "state, on a periodic box. The limit is that of the worst wave of the stencil with all its parts at once, "
     "sound, stream, viscosity and density diffusion (eq. 3.38), less 2 %; a run takes 0.8 of it. Beside walls "
     "there are no waves, the true limit is lower (by a quarter in a channel, to a third in gaps of one node), and "
     "the code takes norms instead (eq. 3.39): 0.65 to 0.98 of the longest step, since no state has all of the "
     "largest sound without the damping that goes with it, which norms do not know (`test_weakly_compressible` asserts "
     "that "
     "these steps are stable, and twice as long ones not).",
     "viscosity",
     "viscosity nu/(c h) [-]",
     "acoustic number c dt/h [-]",
     0.9,
     0,
     {1e-3, 1e-2, 1e-1, 0.3, 1.0, 3.0, 10.0, 1e2},
     8,
     stab_unsteady},
    {"gas",
     "explicit ideal gas",
     "Three-stage Runge-Kutta steps of first order. The limit of the code keeps density and pressure positive from "
     "any state of the neighbours (eq. 4.10), and no step that does so is longer by more than 1 %: `bounded to` is "
     "what a node needs whose neighbours, a million times as heavy, run away from it at a hundred times its speed "
     "of sound, or which runs out into a millionth of its density (which alone would let pass 2.4 times the limit "
     "at rest). `stable to`, for small waves about a uniform stream, is 2 to 5 times as long, but says nothing of "
     "what is not small. A run takes 0.8 of the limit.",
     "mach",
     "Mach number [-]",
     "acoustic number c dt/h [-]",
     0.9,
     0,
     {0.05, 0.1, 0.3, 0.5, 0.8, 1.2, 2.0, 5.0},
     8,
     stab_gas},
    {"two_stage",
     "implicit transport of second order",
     "One step of any length on random values in a stream, limited advection.",
     "times",
     "step over the explicit limit [-]",
     "",
     0.0,
     1,
     {1.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6, 1e8},
     8,
     stab_two_stage},
#if PD_DIM > 1
    {"implicit",
     "implicit flow",
     "One step of any length on random velocities between walls: neither solenoidal nor at rest on them.",
     "times",
     "step over the explicit viscous limit [-]",
     "",
     0.0,
     1,
     {1.0, 10.0, 1e2, 1e3, 1e4, 1e6},
     6,
     stab_implicit},
#endif
};

enum { STAB_CASE_COUNT = (int)(sizeof stab_cases / sizeof stab_cases[0]) };

#endif
