/* cylinder: the benchmark of a cylinder in a channel. */
#ifndef VAL_CYLINDER_H
#define VAL_CYLINDER_H
#if PD_DIM == 2

/* dfg_cylinder_2d1.csv: Schaefer and Turek 1996, benchmark 2D-1, Re = 20. */
#define CYLINDER_DRAG 5.57953523384
#define CYLINDER_LIFT 0.010618948146
#define CYLINDER_DROP 0.11752016697 /* [Pa] */
#define CYLINDER_D 0.1              /* [m] */
#define CYLINDER_MEAN 0.2           /* [m/s] */
#define CYLINDER_HEIGHT 0.41        /* [m] */

static void cylinder_profile(void *user, const double *x, double *u)
{
    (void)user;
    u[0] = 6.0 * CYLINDER_MEAN * x[1] * (CYLINDER_HEIGHT - x[1]) / (CYLINDER_HEIGHT * CYLINDER_HEIGHT);
    u[1] = 0.0;
}

/* Pressure [Pa] on the surface where it meets the axis y = 0.2 m: `side` -1 in front, 1 behind. The parabola through
 * three nodes away from the surface, and the mean of the rows beside the axis by the cubic. */
static double cylinder_pressure(const val_lab *lab, int side)
{
    static const double out[3] = {15.0 / 8.0, -10.0 / 8.0, 3.0 / 8.0};
    static const double rows[4] = {-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0};
    double h = lab->grid.h[0], sum = 0.0;
    int face = (int)floor((0.2 + side * 0.5 * CYLINDER_D) / h + 0.5), axis = (int)floor(0.2 / h + 0.5), i[PD_DIM];
    for (int k = 0; k < 3; k++)
        for (int r = 0; r < 4; r++) {
            i[0] = side < 0 ? face - 1 - k : face + k;
            i[1] = axis - 2 + r;
            sum += out[k] * rows[r] * lab->flow.p[pd_grid_node(&lab->grid, i)];
        }
    return sum * lab->flow.rho;
}

/* Cylinder and channel on a lattice of n cells to the diameter, and the box around the cylinder. */
static void cylinder_setup(val_job *job, double *lo, double *hi)
{
    val_lab *lab = job->lab;
    lab_box(lab, CYLINDER_D / job->level.n, job->level.m, 0.0, CYLINDER_HEIGHT);
    lab->grid_desc.hi[0] = 2.2;
    lab->grid_desc.side[0] = PD_SIDE_INLET;
    lab->grid_desc.side[1] = PD_SIDE_OUTLET;
    lab->grid_desc.solid = 0;
    lab->shapes[0].type = PD_SHAPE_BALL;
    lab->shapes[0].r = 0.5 * CYLINDER_D;
    for (int d = 0; d < PD_DIM; d++) {
        lab->shapes[0].a[d] = 0.2;
        lo[d] = 0.1;
        hi[d] = 0.3;
    }
    lab->flow_desc.rho = 1.0;
    lab->flow_desc.mu = 1e-3;
    lab->flow_desc.speed = CYLINDER_MEAN;
    lab->flow_desc.length = CYLINDER_D;
    lab->flow_desc.inlet = cylinder_profile;
    lab->steady_desc.tolerance = 1e-6;
}

static pd_status cylinder_run(val_job *job)
{
    val_lab *lab = job->lab;
    double lo[PD_DIM], hi[PD_DIM], force[PD_DIM], around[PD_DIM];
    double scale = 2.0 / (CYLINDER_MEAN * CYLINDER_MEAN * CYLINDER_D);
    if (job->level.n % 10 != 0)
        return pdi_fail(job->ctx, PD_ERR_ARGUMENT, "validate", "the cylinder takes a multiple of 10 cells for D");
    cylinder_setup(job, lo, hi);
    PDI_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PDI_TRY(flow_solve(job));
    pd_force_surface(job->ctx, &lab->flow, lo, hi, force, NULL, NULL);
    PDI_TRY(pd_force_balance(job->ctx, &lab->flow, lo, hi, around));
    job->out->h = lab->grid.h[0];
    job->out->err[0] = fabs(scale * force[0] / CYLINDER_DRAG - 1.0);
    job->out->err[1] = fabs(scale * around[0] / CYLINDER_DRAG - 1.0);
    job->out->err[2] = fabs((cylinder_pressure(lab, -1) - cylinder_pressure(lab, 1)) / CYLINDER_DROP - 1.0);
    job->out->err[3] = fabs(scale * around[1] - CYLINDER_LIFT);
    return PD_OK;
}

/* The lattice cuts the cylinder elsewhere: p cells along each axis more than fit it. */
static pd_status cylinder_offset_run(val_job *job)
{
    val_lab *lab = job->lab;
    double lo[PD_DIM], hi[PD_DIM], force[PD_DIM], around[PD_DIM];
    double scale = 2.0 / (CYLINDER_MEAN * CYLINDER_MEAN * CYLINDER_D);
    cylinder_setup(job, lo, hi);
    lab->stencil_desc.h[0] = 2.2 / (22 * job->level.n + job->level.p);
    lab->stencil_desc.h[1] = CYLINDER_HEIGHT / (41 * job->level.n / 10 + job->level.p);
    PDI_TRY(lab_build(job->ctx, lab, VAL_FLOW | VAL_STEADY));
    PDI_TRY(flow_solve(job));
    pd_force_surface(job->ctx, &lab->flow, lo, hi, force, NULL, NULL);
    PDI_TRY(pd_force_balance(job->ctx, &lab->flow, lo, hi, around));
    job->out->h = lab->grid.h[0];
    job->out->err[0] = fabs(scale * force[0] / CYLINDER_DRAG - 1.0);
    job->out->err[1] = fabs(scale * around[0] / CYLINDER_DRAG - 1.0);
    job->out->err[2] = fabs(scale * force[1] / CYLINDER_LIFT - 1.0);
    job->out->err[3] = fabs(scale * around[1] / CYLINDER_LIFT - 1.0);
    return PD_OK;
}

static const val_part cylinder_part = {
    "aligned", "lattice that fits the cylinder", "D/h", VAL_BY_N, NULL, 2.0,
    {{"err_drag", "drag, surface"}, {"err_drag_box", "drag, box"}, {"err_dp", "pressure"}, {"err_lift", "lift, box"}},
    4,
    {{0, 2e-3, 0.0, 20, VAL_GOAL}, {1, 2e-3, 0.0, 20, VAL_GOAL}, {2, 3e-3, 0.0, 20, VAL_GOAL},
     {1, 0.0, 2.0, 0, VAL_GOAL}, {2, 0.0, 2.0, 0, VAL_GOAL}, {1, 2e-2, 0.0, 0, VAL_GUARD}}, 6,
    {{10, 3.0, 0.0}, {20, 3.0, 0.0}, {40, 3.0, 0.0}}, 3, 1, cylinder_run,
    "The gradient of the pressure is of first order in the rows beside the wall, and the pressure on the surface is "
    "extrapolated with it. The inlet acts half a cell outside of the box, which alone takes 0.26 % of the drag with 20 "
    "cells and 0.13 % with 40."};
static const val_part cylinder_offset_part = {
    "offset", "lattice that cuts the cylinder anywhere", "cells more", VAL_BY_P, "cells more than fit", 0.0,
    {{"err_drag", "drag, surface"}, {"err_drag_box", "drag, box"}, {"err_lift", "lift, surface"},
     {"err_lift_box", "lift, box"}}, 4,
    {{0, 2e-3, 0.0, 20, VAL_GOAL}, {1, 2e-3, 0.0, 20, VAL_GOAL}, {2, 5e-2, 0.0, 20, VAL_GOAL},
     {3, 5e-2, 0.0, 20, VAL_GOAL}, {2, 4e-1, 0.0, 20, VAL_GUARD}, {3, 4e-1, 0.0, 20, VAL_GUARD}}, 6,
    {{10, 3.0, 1.0}, {20, 3.0, 1.0}, {20, 3.0, 2.0}, {20, 3.0, 3.0}}, 4, 1, cylinder_offset_run,
    "The lift is 0.2 % of the drag: what is left of it is the first-order gradient of the pressure in the rows beside "
    "the wall, and the inlet half a cell outside of the box."};
static const val_part *const cylinder_parts[] = {&cylinder_part, &cylinder_offset_part};

static const val_case cylinder_case = {
    "cylinder", "Cylinder in a channel",
    "Steady flow from rest past a cylinder slightly below the middle of a channel, Re = 20, to a residual of 1e-6. "
    "Relative errors of the drag from what the bonds exchange with the surface, and from what passes a box of two "
    "diameters around it, and of the difference of the pressure between front and back; absolute error of the lift "
    "coefficient, 0.0106.",
    "Curved walls of first order, pressure that is wrong at a wall, forces that depend on how they are measured.",
    "M. Schaefer and S. Turek, Notes Numer. Fluid Mech. 52, 1996, benchmark 2D-1, and later reference values to ten "
    "digits: `dfg_cylinder_2d1.csv`",
    cylinder_parts, 2};

#endif
#endif
