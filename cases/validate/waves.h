/* waves: cases of bodies in motion: dispersion of a chain, waves in bars. */
#ifndef VAL_WAVES_H
#define VAL_WAVES_H
#include "../elasticity.h"
#include "case.h"

/* A body of cells of width 1 with E = 1 and density 1, of small strains or of springs. */
static pd_status wave_bar(val_job *job, const int *n, double m, int springs, double share)
{
    val_solid *s = &job->lab->solid;
    double lo[3];
    for (int d = 0; d < 3; d++) lo[d] = d < PD_DIM ? -0.5 * n[d] : 0.0;
    PD_TRY(solid_cells(job->ctx, s, n, lo, 1.0, m, NULL, NULL));
    s->metal.young = s->spring.young = 1.0;
    s->metal.poisson = 0.3;
    s->metal.plane = s->spring.plane = PD_PLANE_STRESS;
    PD_TRY(springs ? solid_springs(job->ctx, s) : solid_elastic(job->ctx, s));
    s->motion.density = 1.0;
    s->motion.step_fraction = share;
    return pd_verlet_build(job->ctx, &s->table, &s->motion, &s->verlet);
}

#if PD_DIM == 1
/* ---- dispersion ---- */

/* rho w^2 = sum c V (1 - cos k p)/p over all p of both sides: springs all alike, or of E/r^2. */
static double dispersion_square(int m, double k, int springs)
{
    double sum = 0.0, all = 0.0;
    for (int p = 1; p <= m; p++) {
        double part = p == m ? 0.5 : 1.0, r = springs ? p : (double)p * p;
        sum += 2.0 * part * (1.0 - cos(k * p)) / r;
        all += part * (springs ? p : 1.0);
    }
    return sum / all;
}

/* Largest difference of the middle of a standing wave from the closed form over 80 steps, over its amplitude; *phase:
 * its velocity by the first force. */
static pd_status dispersion_wave(val_job *job, int m, double k, int springs, double *off, double *phase)
{
    val_solid *s = &job->lab->solid;
    int n[3] = {80 * m * 2 + 1, 1, 1};
    int32_t middle = 80 * m;
    double size = 1e-6, square = dispersion_square(m, k, springs);
    solid_free(job->ctx, s);
    PD_TRY(wave_bar(job, n, m, springs, 0.8));
    for (int32_t i = 0; i < s->body.count; i++) s->verlet.u[i] = size * cos(k * s->position[i]);
    PD_TRY(s->table.force(job->ctx, s->table.self, s->verlet.u, s->force));
    *phase = sqrt(-s->force[middle] / size) / k;
    double dt = s->verlet.max_step, slow = 2.0 / dt * asin(0.5 * dt * sqrt(square));
    *off = 0.0;
    for (int step = 1; step <= 80; step++) {
        PD_TRY(pd_physics_run(job->ctx, pd_verlet_process(&s->verlet), step * dt));
        *off = fmax(*off, fabs(s->verlet.u[middle] / size - cos(slow * step * dt)));
    }
    return PD_OK;
}

static pd_status dispersion_run(val_job *job)
{
    int m = (int)job->level.m;
    double *err = job->out->err, off, phase;
    for (int j = 0; j < 8; j++)
        for (int springs = 0; springs < 2; springs++) {
            double k = elasticity_waves[j];
            PD_TRY(dispersion_wave(job, m, k, springs, &off, &phase));
            err[springs ? 2 : 3] = fmax(err[springs ? 2 : 3], off);
            double wanted = sqrt(dispersion_square(m, k, springs)) / k;
            err[0] = fmax(err[0], fabs(phase / wanted - 1.0));
            for (int r = 0; r < 4 && springs; r++)
                if (elasticity_dispersion[r].m == m)
                    err[1] = fmax(err[1], fabs(phase / elasticity_dispersion[r].phase[j] - 1.0));
        }
    job->out->h = 1.0;
    return PD_OK;
}

static const val_part dispersion_part = {
    "", "", "m", VAL_BY_M, "m", 0.0,
    {{"err_phase", "phase velocity"}, {"err_table", "against the table of springs"},
     {"err_springs", "springs in motion"}, {"err_elastic", "small strains in motion"}}, 4,
    {{0, 1e-10, 0.0, 0, VAL_GOAL}, {1, 2e-8, 0.0, 0, VAL_GOAL}, {2, 1e-8, 0.0, 0, VAL_GOAL},
     {3, 1e-10, 0.0, 0, VAL_GOAL}}, 4,
    {{0, 2.0, 0.0}, {0, 3.0, 0.0}, {0, 4.0, 0.0}, {0, 6.0, 0.0}}, 4, 4, dispersion_run, NULL};
static const val_part *const dispersion_parts[] = {&dispersion_part};

static const val_case dispersion_case = {
    "dispersion", "Waves in a chain",
    "Standing waves of eight lengths, from 63 cells to two, in a chain of springs and in one of small strains, whose "
    "bonds are springs of E/r^2: the phase velocity by the force on the middle, and the motion of the middle over 80 "
    "steps, before it hears of the ends, against the frequency of the steps, sin(w' dt/2) = w dt/2.",
    "Parts of cells at the horizon that count wholly, a modulus of the integral in place of the lattice, steps of "
    "first order.",
    "rho w^2 = sum c V (1 - cos k p)/p, and its table of eight digits (data: dispersion_1d)",
    dispersion_parts, 1};
#endif

/* ---- bar_wave ---- */

/* Speed of the slowest stretching of a free bar, from half a period of its end, over sqrt(E/rho). */
static pd_status bar_wave_speed(val_job *job, const int *n, int springs, double *speed, double *drift)
{
    val_solid *s = &job->lab->solid;
    double crossed[3] = {0.0, 0.0, 0.0}, before = 1.0;
    int found = 0;
    PD_TRY(wave_bar(job, n, job->level.m, springs, 0.8));
    for (int32_t i = 0; i < s->body.count; i++)
        s->verlet.v[(int64_t)i * PD_DIM] = 1e-3 * sin(val_pi * s->position[(int64_t)i * PD_DIM] / n[0]);
    double start = pd_verlet_kinetic(&s->verlet), dt = s->verlet.max_step;
    for (int k = 0; found < 3 && k * dt < 3.0 * n[0]; k++) {
        PD_TRY(pd_physics_run(job->ctx, pd_verlet_process(&s->verlet), (k + 1) * dt));
        double now = s->verlet.v[((int64_t)s->body.count - 1) * PD_DIM];
        if (k && (before > 0.0) != (now > 0.0)) crossed[found++] = (k + before / (before - now)) * dt;
        before = now;
        if (k % 20) continue;
        double energy = pd_verlet_kinetic(&s->verlet) + s->table.energy(job->ctx, s->table.self, s->verlet.u);
        *drift = fmax(*drift, fabs(energy / start - 1.0));
    }
    *speed = n[0] / (crossed[2] - crossed[1]);
    job->out->steps += (long)s->verlet.steps;
    return PD_OK;
}

/* A bar twelve times as long as wide. What it stretches along it contracts across, which has inertia: the
 * speed is lower by (nu k K)^2/2, with the polar radius K of inertia (Rayleigh; Love 1927, sec. 278). */
static pd_status bar_wave_run(val_job *job)
{
    int wide = job->level.n, n[3] = {PD_DIM == 1 ? wide : 12 * wide, wide, wide};
    for (int springs = 0; springs < 2; springs++) {
        double speed, drift = 0.0, nu = !springs ? 0.3 : PD_DIM == 3 ? 0.25 : 1.0 / 3.0;
        double thin = val_pi / n[0] * nu * wide, inertia = PD_DIM == 1 ? 0.0 : thin * thin * (PD_DIM - 1) / 24.0;
        solid_free(job->ctx, &job->lab->solid);
        PD_TRY(bar_wave_speed(job, n, springs, &speed, &drift));
        job->out->err[springs] = fabs(speed / (1.0 - inertia) - 1.0);
        job->out->err[2 + springs] = drift;
    }
    job->out->h = 1.0 / wide;
    return PD_OK;
}

#define BAR_WAVE_MEASURES \
    {{"err_elastic", "small strains"}, {"err_springs", "springs"}, {"energy_elastic", "energy"}, \
     {"energy_springs", "energy of springs"}}, 4
#define BAR_WAVE_GOALS(from) \
    {{0, 1e-2, 0.0, 0, VAL_GOAL}, {1, 1e-2, 0.0, from, VAL_GOAL}, {2, 1e-3, 0.0, from, VAL_GOAL}, \
     {3, 1e-3, 0.0, from, VAL_GOAL}, {1, 8e-2, 0.0, 0, VAL_GUARD}, {3, 2e-3, 0.0, 0, VAL_GUARD}}, 6

static const val_part bar_wave_part = {
    "", "", PD_DIM == 1 ? "cells" : "cells across", VAL_BY_N, "cells", PD_DIM == 1 ? 0.0 : 1.0, BAR_WAVE_MEASURES,
#if PD_DIM == 1
    BAR_WAVE_GOALS(0), {{50, 2.0, 0.0}, {100, 2.0, 0.0}, {200, 2.0, 0.0}}, 3, 3,
#elif PD_DIM == 2
    BAR_WAVE_GOALS(12), {{4, 2.0, 0.0}, {8, 2.0, 0.0}, {12, 2.0, 0.0}}, 3, 2,
#else
    BAR_WAVE_GOALS(5), {{3, 2.0, 0.0}, {4, 2.0, 0.0}, {5, 2.0, 0.0}}, 3, 2,
#endif
    bar_wave_run, NULL};
static const val_part *const bar_wave_parts[] = {&bar_wave_part};

static const val_case bar_wave_case = {
    "bar_wave", "A wave in a bar",
    "The slowest stretching of a free bar by Verlet's steps: half a period of its end gives the speed of waves, less "
    "the inertia of what it contracts across. And how far the sum of its energies strays.",
    "Moduli or a density that are wrong by a constant, sides that are too stiff, a step that loses energy.",
    "sqrt(E/rho), with the inertia across the bar by Rayleigh (Love 1927, sec. 278)",
    bar_wave_parts, 1};

#endif
