/* film: states of surfaces: the couple of magnesium and aluminium of Hoeche with the film that grows on it. */
#ifndef VAL_FILM_H
#define VAL_FILM_H
#include "../film.h"
#if PD_DIM == 1

#define FILM_MODES 200

/* A solution at rest: cosines in x, with Mg2+ from x = 0 and OH- from x = L; what the modes beyond the last one would
 * add at the surface is that of a steady flux. */
typedef struct film_layer {
    double d[2], mode[2][FILM_MODES + 1], rest;
} film_layer;

/* Concentration of species s (Mg2+, OH-) at x = 0, with the flux [mol/m2/s] of it. */
static double film_surface(const film_layer *f, int s, double flux)
{
    double sum = 0.0;
    for (int n = FILM_MODES; n >= 0; n--) sum += f->mode[s][n];
    return s ? sum : sum + 2.0 * flux * FILM_GAP / (f->d[s] * val_pi * val_pi) * f->rest;
}

/* dt [s] with constant fluxes. */
static void film_diffuse(film_layer *f, double dt, double current)
{
    for (int s = 0; s < 2; s++) {
        double flux = current / FILM_FARADAY / (s ? 1.0 : 2.0);
        f->mode[s][0] += dt * flux / FILM_GAP;
        for (int n = 1; n <= FILM_MODES; n++) {
            double k = n * val_pi / FILM_GAP, rate = f->d[s] * k * k, sign = s && n % 2 ? -1.0 : 1.0;
            double keeps = exp(-rate * dt);
            f->mode[s][n] = f->mode[s][n] * keeps + sign * 2.0 * flux / FILM_GAP * (1.0 - keeps) / rate;
        }
    }
}

/* Heun's method. */
static void film_rest(double t, int steps, double *y)
{
    film_layer f, next;
    double dt = t / steps, a[3], b[3], at[3];
    memset(&f, 0, sizeof f);
    f.d[0] = 0.71e-9;
    f.d[1] = 5.27e-9;
    f.rest = val_pi * val_pi / 6.0;
    for (int n = FILM_MODES; n > 0; n--) f.rest -= 1.0 / ((double)n * n);
    for (int s = 0; s < steps; s++) {
        double i = film_al(film_potential(sqrt(y[0]))), flux = i / (2.0 * FILM_FARADAY);
        film_rates(y, film_surface(&f, 0, flux), film_surface(&f, 1, 0.0), a);
        next = f;
        film_diffuse(&next, dt, i);
        for (int m = 0; m < 3; m++) at[m] = y[m] + dt * a[m];
        double j = film_al(film_potential(sqrt(at[0])));
        film_rates(at, film_surface(&next, 0, j / (2.0 * FILM_FARADAY)), film_surface(&next, 1, 0.0), b);
        for (int m = 0; m < 3; m++) y[m] += 0.5 * dt * (a[m] + b[m]);
        film_diffuse(&f, dt, 0.5 * (i + j));
    }
}

/* ---- runs ---- */

static double film_figure(const pd_scalar_outputs *figures, const char *section, const char *name, const char *key)
{
    for (int k = 0; k < figures->count; k++)
        if (strcmp(figures->list[k].section, section) == 0 && strcmp(figures->list[k].name, name) == 0 &&
            strcmp(figures->list[k].key, key) == 0)
            return figures->list[k].value;
    return NAN;
}

/* The couple for p hours, with the diffusivities of Mg2+ and OH-, against y at its end. */
static pd_status film_solve(val_job *job, const char *mg, const char *oh, const double *y)
{
    char text[4096];
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    pd_scalar_outputs f;
    memset(&desc, 0, sizeof desc);
    memset(&f, 0, sizeof f);
    snprintf(text, sizeof text,
             "[grid] h = %.17g mm  m = %g  box = 0 .. 4 mm\n[shape mg] box = 0 .. 1 mm  kind = solid\n"
             "[shape al] box = 3 mm .. 4 mm  kind = solid\n[potential] conductivity = 1e6 S/m\n"
             "[electrode mg] shape = mg  current_factor = sqrt(theta)  " FILM_MG "reaction = Mg = Mg2+ + 2 e-\n"
             "[electrode al] shape = al  connected = mg  " FILM_AL "reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n"
             "[chemistry] activity = ideal\n[species Mg2+] D = %s m2/s\n[species OH-] D = %s m2/s\n" FILM_STATES(
                 "mg") "[run] until = %.17g h  rtol = 1e-3\n",
             1.0 / job->level.n, job->level.m, mg, oh, job->level.p);
    desc.no_files = 1;
    desc.figures = &f;
    PD_TRY(pd_scene_parse(job->ctx, "case", text, NULL, 0, &setup));
    pd_status status = pd_run(job->ctx, &setup, &desc, &result);
    pd_setup_free(job->ctx, &setup);
    if (status >= 0) {
        job->out->h = result.h;
        job->out->steps = (long)result.steps;
        job->out->err[0] = fabs(film_figure(&f, "electrode", "mg", "E") - film_potential(sqrt(y[0])));
        job->out->err[1] = fabs(film_figure(&f, "surface", "theta", "mean") / y[0] - 1.0);
        job->out->err[2] = fabs(film_figure(&f, "surface", "eps", "mean") - y[1]) / 0.55;
        job->out->err[3] = fabs(film_figure(&f, "surface", "l", "mean") / y[2] - 1.0);
        job->out->err[4] = result.mass_balance_error;
    }
    pd_scalar_outputs_free(job->ctx, &f);
    return status;
}

static pd_status film_mixed_run(val_job *job)
{
    double y[FILM_COUNT];
    film_mixed(job->level.p * 3600.0, 40000, 0.0, 0, y);
    return film_solve(job, "1e-2", "1e-2", y);
}

static pd_status film_rest_run(val_job *job)
{
    double y[3] = {0.1, 0.55, 1e-7};
    film_rest(job->level.p * 3600.0, (int)(job->level.p * 18000.0), y);
    return film_solve(job, "0.71e-9", "5.27e-9", y);
}

#define FILM_MEASURES \
    {{"err_potential", "potential [V]"}, {"err_cover", "cover"}, {"err_pores", "pores, of those of the start"}, \
     {"err_thickness", "thickness"}, {"balance", "balances"}}, 5
#define FILM_GOALS(from) \
    {{0, 1e-4, 0.0, from, VAL_GOAL}, {1, 5e-3, 0.0, from, VAL_GOAL}, {2, 5e-3, 0.0, from, VAL_GOAL}, \
     {3, 5e-3, 0.0, from, VAL_GOAL}, {4, 1e-10, 0.0, 0, VAL_GOAL}}, 5

static const val_part film_mixed_part = {
    "mixed", "a solution that mixes at once", "hours", VAL_BY_P, "hours", 0.0, FILM_MEASURES, FILM_GOALS(0),
    {{5, 1.0, 0.25}, {5, 1.0, 0.5}, {5, 1.0, 1.0}, {5, 1.0, 2.0}, {5, 1.0, 4.0}, {5, 1.0, 8.0}}, 6, 3,
    film_mixed_run, NULL};

static const val_part film_rest_part = {
    "rest", "a solution at rest, after 1 h", "cells to a millimetre", VAL_BY_N, NULL, 2.0, FILM_MEASURES,
    FILM_GOALS(20),
    {{10, 1.0, 1.0}, {20, 1.0, 1.0}, {40, 1.0, 1.0}}, 3, 2, film_rest_run, NULL};

static const val_part *const film_parts[] = {&film_mixed_part, &film_rest_part};

static const val_case film_case = {
    "film", "A couple with a film that grows",
    "Plates of magnesium and aluminium 2 mm apart with a film of Mg(OH)2 on the magnesium: its cover, pores and "
    "thickness by laws of the scene in the concentrations at the surface, currents with the root of the cover, and the "
    "mixed potential.",
    "Steps of states beside those of species, concentrations of the node in the place of those at the surface, factors "
    "of currents, potentials that lag, bounds that are passed.",
    "Equations of Hoeche 2015 and Shariati, Weber and Hoeche 2021 in a volume, by Runge and Kutta's method of order 4 "
    "with 40000 steps; with diffusion by 200 cosines whose rest is summed, and steps of 0.2 s",
    film_parts, (int)(sizeof film_parts / sizeof film_parts[0])};

#endif
#endif
