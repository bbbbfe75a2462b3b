/* turn: a step of concentration that a stream carries through half a turn. */
#ifndef VAL_TURN_H
#define VAL_TURN_H
#if PD_DIM == 2

/* ---- smith_hutton ---- */

#define TURN_WALL (1.0 - tanh(10.0)) /* [mol/m3] held on the walls */
#define TURN_FROM 0.1 /* x on the outlet from which it is judged */
#define TURN_TO 0.8   /* and up to which an early end of the inlet is felt */

/* The stream enters where x < 0, or a cell further to the left. */
static double turn_end;

static int turn_enters(void *user, int side, const double *x)
{
    (void)user, (void)side;
    return x[0] < turn_end;
}

static double turn_inlet(void *user, const double *x)
{
    (void)user;
    return 1.0 + tanh(10.0 * (2.0 * x[0] + 1.0));
}

static double turn_held(void *user, const double *x)
{
    (void)user, (void)x;
    return TURN_WALL;
}

static void turn_velocity(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = 2.0 * x[1] * (1.0 - x[0] * x[0]);
    u[1] = -2.0 * x[0] * (1.0 - x[1] * x[1]);
}

/* -1 < x < 1 and 0 < y < 1; the stream enters and leaves through y = 0, the other sides are walls that it follows. */
static pd_status turn_build(val_job *job)
{
    val_lab *lab = job->lab;
    lab_box(lab, 1.0 / job->level.n, job->level.m, 0.0, 1.0);
    lab->grid_desc.lo[0] = -1.0;
    lab->grid_desc.side[2] = PD_SIDE_INLET;
    lab->grid_desc.is_inlet = turn_enters;
    enclosed_fluid(lab, 1.0);
    lab->flow_desc.inlet = turn_velocity;
    lab->transport_desc.diffusivity = 1.0 / job->level.p;
    lab->transport_desc.held = turn_held;
    lab->transport_desc.entering = turn_inlet;
    PD_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_TRANSPORT));
    for (int32_t i = 0; i < lab->grid.total; i++) {
        double x[PD_DIM], u[PD_DIM];
        if (lab->grid.kind[i] == PD_INACTIVE) continue;
        pd_grid_position(&lab->grid, i, x);
        turn_velocity(NULL, x, u);
        for (int d = 0; d < PD_DIM; d++) lab->flow.u[(int64_t)d * lab->grid.total + i] = u[d];
    }
    pdi_flow_update_derived_fields(job->ctx, &lab->flow);
    job->out->h = lab->grid.h[0];
    return PD_OK;
}

/* Values on the outlet, and the wall. The gradient across the outlet is zero, by the condition there and along streams
 * that leave at right angles: the parabola through the two rows next to it has its summit on the side. */
static int turn_outlet(const val_lab *lab, double *s, double *f)
{
    int i[PD_DIM], count = 0;
    i[1] = 0;
    for (i[0] = lab->grid.n[0] / 2; i[0] < lab->grid.n[0]; i[0]++) {
        double x[PD_DIM];
        int32_t node = pd_grid_node(&lab->grid, i);
        pd_grid_position(&lab->grid, node, x);
        s[count] = x[0];
        i[1] = 1;
        f[count++] = (9.0 * lab->transport.c[node] - lab->transport.c[pd_grid_node(&lab->grid, i)]) / 8.0;
        i[1] = 0;
    }
    s[count] = 1.0;
    f[count++] = TURN_WALL;
    return count;
}

static const turn_table *turn_of(double peclet)
{
    const turn_table *table = turn_tables;
    while (table->peclet < peclet) table++;
    return table;
}

/* The table at x, by eight of its places. */
static double turn_reference(const turn_table *table, double x)
{
    double place[TURN_PLACES];
    for (int k = 0; k < TURN_PLACES; k++) place[k] = k / (TURN_PLACES - 1.0);
    return enclosed_between(place, table->c, TURN_PLACES, 8, x);
}

/* Largest error of the values f at s. */
static double turn_error(const turn_table *table, const double *s, const double *f, int count)
{
    double most = 0.0;
    for (int k = 0; k < count; k++)
        if (s[k] >= TURN_FROM) most = fmax(most, fabs(f[k] - turn_reference(table, s[k])));
    return most;
}

static pd_status turn_run(val_job *job)
{
    val_lab *lab = job->lab;
    double s[VAL_POINTS], f[VAL_POINTS];
    pd_transport_result result;
    const turn_table *table = turn_of(job->level.p);
    PD_TRY(turn_build(job));
    PD_TRY(pd_transport_steady(job->ctx, &lab->transport, &result));
    int count = turn_outlet(lab, s, f);
    job->out->err[0] = turn_error(table, s, f, count);
    val_curve *found = val_add_curve(job, "computed", PD_SERIES_STYLE_LINE);
    val_curve *wanted = val_add_curve(job, "reference", PD_SERIES_STYLE_MARKERS);
    for (int k = 0; k < TURN_PLACES; k += 4) val_add_point(wanted, k / (TURN_PLACES - 1.0), table->c[k]);
    for (int k = 0; k < count; k++) val_add_point(found, s[k], f[k]);
    for (int32_t i = 0; i < lab->grid.total; i++)
        if (lab->grid.kind[i] == PD_FLUID)
            job->out->err[1] = fmax(job->out->err[1], fmax(lab->transport.c[i] - (1.0 + tanh(10.0)),
                                                           TURN_WALL - lab->transport.c[i]));
    job->out->err[2] = result.change;
    job->out->steps = result.krylov;
    if (job->profile) {
        job->profile->title = job->level.p < 50.0    ? "Concentration at the outlet, Peclet number 10"
                              : job->level.p < 1e3 ? "Concentration at the outlet, Peclet number 100"
                                                   : "Concentration at the outlet, Peclet number 1e6";
        job->profile->x_label = "x [-]";
        job->profile->y_label = "c [-]";
    }
    return PD_OK;
}

/* The outlet at the nodes s of a lattice whose inlet ends `cells` early. Returns their number in *count. */
static pd_status turn_solved(val_job *job, int cells, double *s, double *c, int *count)
{
    pd_transport_result result;
    turn_end = -(double)cells / job->level.n;
    pd_status status = turn_build(job);
    turn_end = 0.0;
    if (status == PD_OK) status = pd_transport_steady(job->ctx, &job->lab->transport, &result);
    if (status != PD_OK) return status;
    *count = turn_outlet(job->lab, s, c);
    lab_free(job->ctx, job->lab);
    memset(job->lab, 0, sizeof *job->lab);
    return PD_OK;
}

/* The error, and over what an inlet that ends a cell early makes of the field. */
static pd_status turn_edge_run(val_job *job)
{
    double s[VAL_POINTS], here[VAL_POINTS], early[VAL_POINTS];
    int count;
    const turn_table *table = turn_of(job->level.p);
    PD_TRY(turn_solved(job, 0, s, here, &count));
    PD_TRY(turn_solved(job, 1, s, early, &count));
    for (int k = 0; k < count; k++) {
        if (s[k] < TURN_FROM || s[k] > TURN_TO) continue;
        double error = here[k] - turn_reference(table, s[k]);
        job->out->err[0] = fmax(job->out->err[0], fabs(error / (early[k] - here[k])));
        job->out->err[1] = fmax(job->out->err[1], fabs(error));
    }
    job->out->h = 1.0 / job->level.n;
    return PD_OK;
}

#define TURN_MEASURES {{"err_max", "c, largest"}, {"overshoot", "overshoot"}, {"change", "change of the last step"}}, 3
#define TURN_PART(m, guard) \
    "Peclet", VAL_BY_P, "Peclet number [-]", 0.0, TURN_MEASURES, \
    {{0, 2e-3, 0.0, 0, VAL_GOAL}, {1, 1e-8, 0.0, 0, VAL_GOAL}, {0, guard, 0.0, 0, VAL_GUARD}, \
     {2, 1e-6, 0.0, 0, VAL_GUARD}}, 4, \
    {{40, m, 10.0}, {40, m, 100.0}, {40, m, 1e6}}, 3

static const val_part turn_near = {
    "m1", "m = 1", TURN_PART(1.0, 0.07), 1, turn_run,
    "At 1e6 nothing but the lattice smears the step, of which four fifths lie within four and a half cells. Linear "
    "fluxes of fifth order in a straight stream of as many cells, 63, leave 7.5e-2 of it, of third order 0.19; plain "
    "finite volumes of second order leave 8.4e-2 here (`bench2d horizon`). With 80 and 160 cells a unit the error is "
    "1.6e-2 and 3.0e-3. At 100 it is of second order: 8.8e-4 with 80 cells."};
static const val_part turn_far = {
    "m3", "m = 3", TURN_PART(3.0, 0.25), 0, turn_run,
    "At 100 and 1e6 most of the step lies within four and a half cells, and a horizon is three: its curvature seen "
    "along bonds that cross it leaves the error of m = 1 times up to nine. At 10 the end of the inlet is smeared over "
    "the horizon."};
static const val_part turn_edge = {
    "edge", "the end of the inlet at Pe = 10, m = 1", "cells a unit", VAL_BY_N, NULL, 1.0,
    {{"edge", "error in cells by which the inlet is short"}, {"err_max", "c, largest"}}, 2,
    {{0, 0.1, 0.0, 40, VAL_GOAL}, {1, 1e-3, 0.0, 40, VAL_GOAL}, {1, 0.0, 0.9, 0, VAL_GUARD}}, 3,
    {{20, 1.0, 10.0}, {40, 1.0, 10.0}, {80, 1.0, 10.0}}, 3, 2, turn_edge_run, NULL};
static const val_part *const turn_parts[] = {&turn_near, &turn_far, &turn_edge};

static const val_case turn_case = {
    "smith_hutton", "A step of concentration through half a turn",
    "Smith and Hutton's problem on 80 x 40 nodes, steady: a stream enters through the left half of the lower side with "
    "a steep step of concentration, turns, and leaves through the right half. Largest error of a node on the "
    "outlet from x = 0.1 on; how far the field leaves the range of inlet and walls.",
    "Upwinding across the stream, oscillations, limiters that do not settle, inlets that smear what enters.",
    "R. M. Smith, A. G. Hutton, Numer. Heat Transfer 5, 1982; solved by finite elements of order 9 "
    "(`tests/scripts/half_turn.sh`), which agree with the table of the paper to 3e-3",
    turn_parts, 3};

#endif
#endif
