/* pit: 304 steel that dissolves by its potential against migrating ions, against a quadrature and a growing lattice of
 * finite volumes (../pit.h). Included by cases.h alone. */
#ifndef VAL_PIT_H
#define VAL_PIT_H
#include "reaction.h"
#include "../pit.h"

#if PD_DIM < 3
/* Speed [m/s] under the law, 0 beyond saturation. The metal's ions are the first two solutes. */
static double pit_speed(void *user, int32_t node, const double *c, double ph, double phi, double t)
{
    (void)user;
    (void)node;
    (void)ph;
    (void)t;
    return c[0] + c[1] < PIT_SATURATION ? pit_law(PIT_HELD - phi) / PIT_SOLID : 0.0;
}

static double pit_bath(void *user, const double *x)
{
    return x[0] > 0.9999 * *(const double *)user ? 1.0 : (double)NAN;
}

/* A pit of a given depth, in one step of a million times of diffusion. */
static pd_status pit_steady_solve(val_job *job, reaction_lab *r)
{
    static const char *const names[] = {"Fe2+", "Fe3+", "Na+", "Cl-"};
    static const double ds[] = {PIT_D, PIT_D, PIT_D_NA, PIT_D_CL};
    double bath[4] = {0.0, 0.0, PIT_BATH, PIT_BATH}, shed[4] = {1.0 - PIT_THIRD, PIT_THIRD, 0.0, 0.0}, x[PD_DIM];
    double length = job->level.p, h = length / job->level.n, speed = 0.0, phi = 0.0;
    pit_state wanted = pit_steady(PIT_HELD, length);
    pd_reactive_desc d;
    pd_etch_desc e;
    pd_etch etch;
    memset(&d, 0, sizeof d);
    memset(&e, 0, sizeof e);
    for (int k = 0; k < 4; k++) PD_TRY(reaction_species(job->ctx, r, names[k], NULL, ds[k]));
    d.initial = d.wall = bath;
    d.held = pit_bath;
    d.user = &length;
    d.migration = 1;
    PD_TRY(reaction_build(job, r, job->level.n, h, &d));
    e.law = pit_speed;
    e.shed = shed;
    e.reads = 3;
    e.reads_phi = 1;
    PD_TRY(pd_etch_build(job->ctx, &r->reactive, &e, &etch));
    for (int32_t i = 0; i < job->lab->grid.total; i++) {
        if (job->lab->grid.kind[i] != PD_FLUID) continue;
        pd_grid_position(&job->lab->grid, i, x);
        if (x[0] < h)
            pd_etch_put(&etch, i, PIT_SOLID / h, PIT_SOLID * 0.5 * h / r->reactive.diffusion.desc.diffusivity);
    }
    pd_status status = reaction_step(job, r, 1e6 * length * length / PIT_D);
    for (int32_t p = 0; p < etch.count && status == PD_OK; p++) {
        speed = fmax(speed, etch.speed[etch.node[p]]);
        phi = pd_reactive_potential(&r->reactive, etch.node[p]);
    }
    job->out->err[0] = fabs(speed * PIT_SOLID / wanted.flux - 1.0);
    job->out->err[1] = reaction_imbalance(job, r);
    job->out->err[2] = phi < wanted.psi * PIT_VOLT ? 0.0 : 1.0; /* half a cell off the metal it is lower */
    pd_etch_free(job->ctx, &etch);
    return status;
}

static pd_status pit_steady_run(val_job *job) { return reaction_run(job, pit_steady_solve); }

#define PIT_SCENE \
    "[shape steel] kind = solid  material = steel304  box = %g um .. %g um%s\n[side x-] species = inlet\n%s" \
    "[chemistry] activity = ideal  migration = yes\n[species Fe2+] D = 6.8957e-10 m2/s\n" \
    "[species Fe3+] D = 6.8957e-10 m2/s\n[species Na+] D = 1.332e-9 m2/s  initial = 1000 mol/m3\n" \
    "[species Cl-] D = 2.032e-9 m2/s  initial = 1000 mol/m3\n[transport] D = 6.8957e-10 m2/s\n" \
    "[constants] volt = 25.692579 mV\n" \
    "[dissolve] potential = -75 mV  Cs = 144423.1 mol/m3  charge = 2.2022\n" \
    "current = if([Fe2+] + [Fe3+] < 5100 mol/m3, 9.9 A/m2*exp(2.2022*0.65*(E + 240 mV)/volt), 0 A/m2)\n" \
    "reaction = Fe = 0.7978 Fe2+ + 0.2022 Fe3+ + 2.2022 e-\n"

/* Growth of a pit of so many um over so many seconds, in metal `solid` [um] thick, and of the finite volumes. */
static pd_status pit_deepen_by(val_job *job, double depth, double solid, double seconds, double rtol)
{
    static pit_march march;
    char text[2048], grid[256], box[64] = "";
    double h = depth / job->level.n, v, coarse, fine, across = 3.0 * h;
    pd_run_result result;
    pd_setup setup;
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    if (PD_DIM > 1) snprintf(box, sizeof box, ", 0 um .. %.17g um", across);
    snprintf(grid, sizeof grid, "[grid] h = %.17g um  m = %g  box = 0 um .. %.17g um%s\n", h, job->level.m,
             depth + solid, box);
    snprintf(text, sizeof text, "%s" PIT_SCENE "[run] until = %g s  rtol = %g\n", grid, depth, depth + solid, box,
             PD_DIM == 1 ? "" : "[side y-] flow = mirror\n[side y+] flow = mirror\n", seconds, rtol);
    desc.no_files = 1;
    PD_TRY(pd_scene_parse(job->ctx, "case", text, NULL, 0, &setup));
    pd_status status = pd_run(job->ctx, &setup, &desc, &result);
    pd_setup_free(job->ctx, &setup);
    PD_TRY(status);
    depth *= 1e-6;
    coarse = pit_deepen(&march, PIT_HELD, depth, seconds, 120, &v);
    fine = 2.0 * pit_deepen(&march, PIT_HELD, depth, seconds, 240, &v) - coarse; /* of first order in time */
    job->out->h = result.h;
    job->out->steps = (long)result.steps;
    job->out->err[0] = fabs(result.volume_loss * 1e-6 * solid / (fine - depth) - 1.0);
    job->out->err[1] = result.mass_balance_error;
    return PD_OK;
}

static pd_status pit_deepen_run(val_job *job) { return pit_deepen_by(job, 20.0, 6.0, 3.0, 0.002); }

static pd_status pit_film_run(val_job *job) { return pit_deepen_by(job, 1000.0, 200.0, 2000.0, 0.002); }

static const val_part pit_law_part = {
    "law", "a pit 0.1 mm deep, under the law", "cells", VAL_BY_N, NULL, 2.0,
    {{"err_current", "current"}, {"imbalance", "elements and charge"}, {"err_sign", "potential"}}, 3,
    {{0, 2e-4, 0.0, 80, VAL_GOAL}, {0, 0.0, 1.7, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL},
     {2, 0.0, 0.0, 0, VAL_GUARD}}, 4,
    {{20, 1.0, 1e-4}, {40, 1.0, 1e-4}, {80, 1.0, 1e-4}}, 3, 3, pit_steady_run, NULL};

static const val_part pit_salt_part = {
    "salt", "a pit 1 mm deep, under a salt film", "cells", VAL_BY_N, NULL, 2.0,
    {{"err_current", "current"}, {"imbalance", "elements and charge"}, {"err_sign", "potential"}}, 3,
    {{0, 5e-4, 0.0, 80, VAL_GOAL}, {0, 0.0, 1.7, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL},
     {2, 0.0, 0.0, 0, VAL_GUARD}}, 4,
    {{20, 1.0, 1e-3}, {40, 1.0, 1e-3}, {80, 1.0, 1e-3}}, 3, 3, pit_steady_run, NULL};

static const val_part pit_deepen_part = {
    "deepening", "a pit 20 um deep for 3 s", "cells", VAL_BY_N, NULL, 1.0,
    {{"err_depth", "loss of metal"}, {"ledger", "amounts"}}, 2,
    {{0, 2e-3, 0.0, 40, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}}, 2,
    {{20, 1.0, 0.0}, {40, 1.0, 0.0}}, 2, 1, pit_deepen_run, NULL};

static const val_part pit_film_part = {
    "film", "a pit 1 mm deep for 2000 s, half of it under a salt film", "cells", VAL_BY_N, NULL, 2.0,
    {{"err_depth", "loss of metal"}, {"ledger", "amounts"}}, 2,
    {{0, 1e-3, 0.0, 80, VAL_GOAL}, {0, 0.0, 1.5, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}}, 3,
    {{20, 1.0, 0.0}, {40, 1.0, 0.0}, {80, 1.0, 0.0}}, 3, 2, pit_film_run, NULL};

static const val_part *const pit_parts[] = {&pit_law_part, &pit_salt_part, &pit_deepen_part, &pit_film_part};

static const val_case pit_case = {
    "pit", "304 steel held at a potential in a pit",
    "Steel at -75 mV in brine of 1 mol/L dissolves by its potential against the ions at its surface, which carry the "
    "current out, up to a salt film at 5.1 mol/L: the steady current of pits of two depths, in one step of a million "
    "times of diffusion; the depth of a pit that deepens from 20 um for 3 s, and of one from 1 mm for 2000 s.",
    "A law that is asked once a step, a potential without that of diffusion, the fall of the potential in the last "
    "half cell, charge that is lost, a salt film that is a clamp, cells that turn without what fills them.",
    "constants of Chadwick et al. 2018; steady Nernst-Planck in the potential by quadrature, and in time in finite "
    "volumes that grow with the pit, both derived apart (theory: eq. 9.3)",
    pit_parts, 4};
#endif
#endif
