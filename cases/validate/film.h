/* film: states of surfaces: the couple of magnesium and aluminium of Hoeche with the film that grows on it. */
#ifndef VAL_FILM_H
#define VAL_FILM_H
#if PD_DIM == 1

#define FILM_FARADAY 96485.33212
#define FILM_GAP 2e-3 /* [m] between plates of equal area */

/* Curves [A/m2] of both metals, positive, and the potential [V] where `share` times one is the other. */
static double film_mg(double e)
{
    return 0.28 * (exp(39.31786 * 0.4 * (e + 1.517)) - exp(-39.31786 * 0.32 * (e + 1.517)));
}

static double film_al(double e)
{
    double x = exp(2.0 * (e + 0.595));
    return 0.104 * x / (0.012 * x + 1.0) + 0.18 * pow(10.0, -(e + 1.41) / 0.118);
}

static double film_potential(double share)
{
    double lo = -1.8, hi = -1.25;
    for (int k = 0; k < 60; k++) {
        double e = 0.5 * (lo + hi);
        if (share * film_mg(e) > film_al(e)) hi = e;
        else lo = e;
    }
    return 0.5 * (lo + hi);
}

/* Rates of theta, eps, l with the concentrations of Mg2+ and OH- at the surface; l ends at 1 mm. */
static void film_rates(const double *y, double mg, double oh, double *rate)
{
    double volume = 2.457627e-5, chi = volume * fmax(mg * oh * oh - 0.45, 0.0);
    rate[0] = (1.0 - y[0]) / ((1.0 - y[1]) * y[2]) * 3.7e-7 * chi;
    rate[1] = -y[1] * 7.4e-4 * chi;
    rate[2] = y[2] < 1e-3 ? 3.7e-7 * chi / ((1.0 - 0.55) * y[0]) : 0.0;
}

/* ---- references ---- */

/* A solution that mixes at once: y has theta, eps, l, Mg2+, OH-. Runge and Kutta's method of order 4. */
static void film_mixed(double t, int steps, double *y)
{
    double k[4][5], at[5], h = t / steps;
    for (int s = 0; s < steps; s++) {
        for (int j = 0; j < 4; j++) {
            double go = j == 0 ? 0.0 : j == 3 ? h : 0.5 * h;
            for (int m = 0; m < 5; m++) at[m] = y[m] + (j ? go * k[j - 1][m] : 0.0);
            film_rates(at, at[3], at[4], k[j]);
            k[j][4] = film_al(film_potential(sqrt(at[0]))) / (FILM_FARADAY * FILM_GAP);
            k[j][3] = 0.5 * k[j][4];
        }
        for (int m = 0; m < 5; m++) y[m] += h / 6.0 * (k[0][m] + 2.0 * k[1][m] + 2.0 * k[2][m] + k[3][m]);
    }
}

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
    y[3] = y[4] = 0.0;
}

/* ---- runs ---- */

static double film_figure(const pd_figures *figures, const char *section, const char *name, const char *key)
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
    pd_figures f;
    memset(&desc, 0, sizeof desc);
    memset(&f, 0, sizeof f);
    snprintf(text, sizeof text,
             "[grid] h = %.17g mm  m = %g  box = 0 .. 4 mm\n[shape mg] box = 0 .. 1 mm  kind = solid\n"
             "[shape al] box = 3 mm .. 4 mm  kind = solid\n[potential] conductivity = 1e6 S/m\n"
             "[electrode mg] shape = mg  curve = expression  range = -1.8 V .. -1.25 V  factor = sqrt(theta)\n"
             "i = 0.28 A/m2*(exp(39.31786*0.4*(E + 1.517 V)/(1 V)) - exp(-39.31786*0.32*(E + 1.517 V)/(1 V)))\n"
             "reaction = Mg = Mg2+ + 2 e-\n"
             "[electrode al] shape = al  connected = mg  curve = expression  range = -1.8 V .. -1.25 V\n"
             "i = -0.104 A/m2/(0.012 + exp(-2*(E + 0.595 V)/(1 V))) - 0.18 A/m2*10^(-(E + 1.41 V)/(118 mV))\n"
             "reaction = 2 H2O + 2 e- = H2(g) + 2 OH-\n"
             "[chemistry] activity = ideal\n[species Mg2+] D = %s m2/s\n[species OH-] D = %s m2/s\n"
             "[constants] Vm = 2.457627e-5 m3/mol  k = 3.7e-7 m7/mol2/s  q = 7.4e-4 m6/mol2/s  w = 0.45 mol3/m9\n"
             "[surface theta] of = mg  initial = 0.1  max = 1\n"
             "rate = (1 - theta)/((1 - eps)*l)*k*Vm*max([Mg2+]*[OH-]^2 - w, 0)\n"
             "[surface eps] of = mg  initial = 0.55  min = 0  rate = -eps*q*Vm*max([Mg2+]*[OH-]^2 - w, 0)\n"
             "[surface l] of = mg  initial = 0.1 um  max = 1 mm  rate = k*Vm*max([Mg2+]*[OH-]^2 - w, 0)/(0.45*theta)\n"
             "[run] until = %.17g h  rtol = 1e-3\n", 1.0 / job->level.n, job->level.m, mg, oh, job->level.p);
    desc.dry = 1;
    desc.figures = &f;
    PDI_TRY(pd_scene_parse(job->ctx, "case", text, NULL, 0, &setup));
    pd_status status = pd_run(job->ctx, &setup, &desc, &result);
    pd_setup_free(job->ctx, &setup);
    if (status >= 0) {
        job->out->h = result.h;
        job->out->steps = (long)result.steps;
        job->out->err[0] = fabs(film_figure(&f, "electrode", "mg", "E") - film_potential(sqrt(y[0])));
        job->out->err[1] = fabs(film_figure(&f, "surface", "theta", "mean") / y[0] - 1.0);
        job->out->err[2] = fabs(film_figure(&f, "surface", "eps", "mean") - y[1]) / 0.55;
        job->out->err[3] = fabs(film_figure(&f, "surface", "l", "mean") / y[2] - 1.0);
        job->out->err[4] = result.ledger;
    }
    pd_figures_free(job->ctx, &f);
    return status;
}

static pd_status film_mixed_run(val_job *job)
{
    double y[5] = {0.1, 0.55, 1e-7, 0.0, 0.0};
    film_mixed(job->level.p * 3600.0, 40000, y);
    return film_solve(job, "1e-2", "1e-2", y);
}

static pd_status film_rest_run(val_job *job)
{
    double y[5] = {0.1, 0.55, 1e-7, 0.0, 0.0};
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
