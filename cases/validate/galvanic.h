/* galvanic: scenes with an electric potential: mixed potentials, couples, a disc, metal that dissolves by current. */
#ifndef VAL_GALVANIC_H
#define VAL_GALVANIC_H
#include "../film.h"
#if PD_DIM > 1

/* A scene as text, run up to its end; its figures. */
static pd_status galvanic_solve(val_job *job, const char *text, pd_scalar_outputs *figures, pd_run_result *result)
{
    pd_setup setup;
    pd_run_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(figures, 0, sizeof *figures);
    desc.no_files = 1;
    desc.figures = figures;
    PD_TRY(pd_scene_parse(job->ctx, "case", text, NULL, 0, &setup));
    pd_status status = pd_run(job->ctx, &setup, &desc, result);
    pd_setup_free(job->ctx, &setup);
    job->out->h = result->h;
    job->out->steps = (long)result->steps;
    return status;
}

/* electrode.NAME.key; NaN: there is none. */
static double galvanic_figure(const pd_scalar_outputs *figures, const char *name, const char *key)
{
    for (int k = 0; k < figures->count; k++)
        if (strcmp(figures->list[k].name, name) == 0 && strcmp(figures->list[k].key, key) == 0)
            return figures->list[k].value;
    return NAN;
}

#if PD_DIM == 2
/* ---- two metals in a good conductor ---- */

/* Magnesium and aluminium in front of each other, equal areas. */
static pd_status galvanic_mixed_run(val_job *job)
{
    char text[2048];
    double e = film_potential(1.0);
    pd_scalar_outputs f;
    pd_run_result r;
    snprintf(text, sizeof text,
             "[grid] h = %.17g mm  m = %g  box = 0 .. 3 mm, 0 .. 1 mm\n"
             "[side y-] flow = mirror\n[side y+] flow = mirror\n"
             "[shape mg] box = 0 .. 1 mm, 0 .. 1 mm  kind = solid\n[shape al] box = 2 mm .. 3 mm, 0 .. 1 mm  kind = "
             "solid\n[potential] conductivity = 1e4 S/m\n[electrode mg] shape = mg  connected = al  " FILM_MG
             "[electrode al] shape = al  " FILM_AL, 1.0 / job->level.n, job->level.m);
    pd_status status = galvanic_solve(job, text, &f, &r);
    if (status >= 0) {
        job->out->err[0] = fabs(galvanic_figure(&f, "mg", "E") - e);
        job->out->err[1] = fabs(e + 1.462456);
        job->out->err[2] = fabs(galvanic_figure(&f, "mg", "density") / film_mg(e) - 1.0);
        job->out->err[3] = r.current_balance;
    }
    pd_scalar_outputs_free(job->ctx, &f);
    return status;
}

/* ---- coplanar couple ---- */

/* Current density at x over kappa U/c, by Waber's series. */
static double galvanic_waber(double length, double x)
{
    double i = 0.0;
    for (int w = 1; w < 20000; w++) {
        double q = w * val_pi;
        i += 2.0 * sin(0.5 * q) / q * q * tanh(q) / (1.0 + length * q * tanh(q)) * cos(q * x);
    }
    return i;
}

static pd_status galvanic_coplanar_run(val_job *job)
{
    static const double wagner[] = {1.0, 0.1, 0.01}, total[] = {0.19787, 0.77648, 1.50366};
    char text[2048];
    int which = job->level.p > 0.5 ? 0 : job->level.p > 0.05 ? 1 : 2;
    double h = 1.0 / job->level.n;
    pd_scalar_outputs f;
    pd_run_result r;
    snprintf(text, sizeof text,
             "[grid] h = %.17g m  m = %g  box = 0 .. 1 m, %.17g m .. 1 m\n"
             "[side x-] flow = mirror\n[side x+] flow = mirror\n"
             "[shape a] box = 0 .. 0.5 m, %.17g m .. 0 m  kind = solid\n"
             "[shape b] box = 0.5 m .. 1 m, %.17g m .. 0 m  kind = solid\n[potential] conductivity = 1 S/m\n"
             "[electrode a] shape = a  curve = linear  E0 = -1 V  polarisation_resistance = %g ohm m2\n"
             "[electrode b] shape = b  curve = linear  E0 = 0 V  polarisation_resistance = %g ohm m2\n",
             h, job->level.m, -4.0 * h, -4.0 * h, -4.0 * h, wagner[which], wagner[which]);
    pd_status status = galvanic_solve(job, text, &f, &r);
    if (status >= 0) {
        job->out->err[0] = fabs(galvanic_figure(&f, "a", "current") / total[which] - 1.0);
        job->out->err[1] = r.current_balance;
        double outer = galvanic_figure(&f, "a", "least");
        job->out->err[2] = fabs(outer / galvanic_waber(wagner[which], 0.5 * h) - 1.0);
    }
    pd_scalar_outputs_free(job->ctx, &f);
    return status;
}

/* ---- a disc that dissolves ---- */

#define GALVANIC_SPEED (24.305e-3 / 1738.0 / (2.0 * 96485.33212)) /* [m3/C] of magnesium */
#define GALVANIC_TIME (20.0 * 86400.0) /* [s] */

/* Loss of area of a disc of 0.5 mm radius, n cells to it, that corrodes freely with 1 A/m2. */
static pd_status galvanic_circle_loss(val_job *job, double conductivity, double *loss)
{
    char text[2048];
    pd_scalar_outputs f;
    pd_run_result r;
    snprintf(text, sizeof text,
             "[grid] h = %.17g mm  m = %g  box = -0.8 mm .. 0.8 mm, -0.8 mm .. 0.8 mm\n"
             "[shape disc] ball = 0, 0  radius = 0.5 mm  kind = solid  material = mg4ag\n"
             "[potential] conductivity = %g S/m\n[electrode disc] shape = disc  curve = butler_volmer  i0 = 1 A/m2\n"
             "E0 = -1.5 V  anodic_slope = 60 mV  cathodic_slope = 120 mV\n[transport] D = 1e-9 m2/s\n"
             "[dissolve] current = 1 A/m2*10^((E + 1.5 V)/(60 mV))\n[run] until = %g s\n", 0.5 / job->level.n,
             job->level.m, conductivity, GALVANIC_TIME);
    pd_status status = galvanic_solve(job, text, &f, &r);
    if (status >= 0) job->out->err[2] = fmax(job->out->err[2], fmax(r.mass_balance_error, r.current_balance));
    *loss = r.volume_loss;
    pd_scalar_outputs_free(job->ctx, &f);
    return status;
}

static pd_status galvanic_circle_run(val_job *job)
{
    double loss[2];
    PD_TRY(galvanic_circle_loss(job, 1e-3, &loss[0]));
    PD_TRY(galvanic_circle_loss(job, 10.0, &loss[1]));
    double recession = 0.5e-3 * (1.0 - sqrt(1.0 - loss[0]));
    job->out->err[0] = fabs(recession / (GALVANIC_SPEED * GALVANIC_TIME) - 1.0);
    job->out->err[1] = fabs(loss[1] / loss[0] - 1.0);
    return PD_OK;
}
#endif

/* ---- Newman's disc ---- */

#define GALVANIC_FAR 3.0 /* [-] radius of the hemisphere over that of the disc */

/* A disc of 1 m in an insulating plane, 1 S/m, in a hemisphere of three radii whose current goes like that of a point:
 * what lies beyond adds 1/(2 pi kappa r). 3D: a quarter of it. */
static pd_status galvanic_disc_run(val_job *job)
{
    static const double total[] = {0.58592, 0.29115};
    char text[2048], box[256], mirrors[128] = "";
    int which = job->level.p > 5.0, layer = 4;
    double h = 1.0 / job->level.n, end = GALVANIC_FAR + layer * h;
    pd_scalar_outputs f;
    pd_run_result r;
#if PD_DIM == 3
    snprintf(box, sizeof box, "box = %.17g m .. %.17g m, 0 .. %.17g m, 0 .. %.17g m", -layer * h, end, end, end);
    snprintf(mirrors, sizeof mirrors, "[side y-] flow = mirror\n[side z-] flow = mirror\n");
#else
    snprintf(box, sizeof box, "geometry = axisymmetric  box = %.17g m .. %.17g m, 0 .. %.17g m", -layer * h, end, end);
#endif
    snprintf(text, sizeof text,
             "[grid] h = %.17g m  m = %g  %s\n%s[shape round] cylinder = x  radius = 1 m\n"
             "[shape behind] half_space = yes  point = 0 m, 0 m%s  normal = 1, 0%s\n"
             "[shape disc] intersect = behind, round  kind = solid\n"
             "[shape plane] difference = behind, round  kind = wall\n"
             "[shape beyond] ball = 0 m, 0 m%s  radius = %g m  outside = yes\n"
             "[shape far] difference = beyond, behind  kind = solid\n[potential] conductivity = 1 S/m\n"
             "[electrode disc] shape = disc  curve = linear  polarisation_resistance = %g ohm m2  potential = 1 V\n"
             "[electrode far] shape = far  curve = primary  potential = 0 V\n",
             h, job->level.m, box, mirrors, PD_DIM == 3 ? ", 0 m" : "", PD_DIM == 3 ? ", 0" : "",
             PD_DIM == 3 ? ", 0 m" : "", GALVANIC_FAR, 1.0 / job->level.p);
    pd_status status = galvanic_solve(job, text, &f, &r);
    if (status >= 0) {
        double current = galvanic_figure(&f, "disc", "current") * (PD_DIM == 3 ? 4.0 : 1.0);
        double resistance = 1.0 / current + 1.0 / (2.0 * val_pi * GALVANIC_FAR);
        job->out->err[0] = fabs(resistance / total[which] - 1.0);
        job->out->err[1] = r.current_balance;
    }
    pd_scalar_outputs_free(job->ctx, &f);
    return status;
}

#if PD_DIM == 2
static const val_part galvanic_mixed_part = {
    "mixed", "Mg and Al, equal areas", "cells to 1 mm", VAL_BY_N, NULL, 0.0,
    {{"err_potential", "potential [V]"}, {"err_table", "reference against the table [V]"},
     {"err_current", "current density"}, {"balance", "balance of currents"}}, 4,
    {{0, 1e-4, 0.0, 0, VAL_GOAL}, {1, 1e-6, 0.0, 0, VAL_GOAL}, {2, 1e-3, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}}, 4,
    {{8, 1.0, 0.0}, {8, 3.0, 0.0}}, 2, 2, galvanic_mixed_run, NULL};

static const val_part galvanic_coplanar_part = {
    "coplanar", "two metals side by side, linear kinetics", "Wagner length over the width", VAL_BY_P,
    "Wagner length over the width", 0.0,
    {{"err_total", "total current"}, {"balance", "balance of currents"}, {"err_outer", "density at the outer edge"}}, 3,
    {{0, 0.01, 0.0, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}, {2, 0.01, 0.0, 0, VAL_GOAL}}, 3,
    {{64, 1.0, 1.0}, {64, 1.0, 0.1}, {256, 1.0, 0.01}}, 3, 2, galvanic_coplanar_run, NULL};

static const val_part galvanic_circle_part = {
    "circle", "a disc that corrodes freely with 1 A/m2 for 20 days", "cells to the radius", VAL_BY_N, NULL, 1.0,
    {{"err_recession", "recession"}, {"err_conductivity", "loss in 1e-3 against 10 S/m"}, {"balance", "balances"}}, 3,
    {{0, 0.01, 0.0, 20, VAL_GOAL}, {1, 1e-6, 0.0, 0, VAL_GOAL}, {2, 1e-10, 0.0, 0, VAL_GOAL},
     {0, 0.03, 0.0, 0, VAL_GUARD}}, 4,
    {{10, 1.0, 0.0}, {20, 1.0, 0.0}, {40, 1.0, 0.0}}, 3, 1, galvanic_circle_run, NULL};
#endif

static const val_part galvanic_disc_part = {
    "disc", "disc in an insulating plane", "J, the radius over the Wagner length", VAL_BY_P,
    "radius over the Wagner length", 0.0,
    {{"err_resistance", "total resistance"}, {"balance", "balance of currents"}}, 2,
    {{0, 0.01, 0.0, 0, VAL_GOAL}, {1, 1e-11, 0.0, 0, VAL_GOAL}}, 2,
    {{PD_DIM == 3 ? 16 : 32, 1.0, 1.0}, {PD_DIM == 3 ? 16 : 32, 1.0, 10.0}}, 2, 2, galvanic_disc_run, NULL};

static const val_part *const galvanic_parts[] = {
#if PD_DIM == 2
    &galvanic_mixed_part, &galvanic_coplanar_part, &galvanic_circle_part,
#endif
    &galvanic_disc_part};

static const val_case galvanic_case = {
    "galvanic", "Potentials, couples, a disc electrode",
    "Scenes with [potential]: the mixed potential of magnesium and aluminium with equal areas; the currents of two "
    "metals side by side whose kinetics are linear; the resistance of a disc in an insulating plane, on rings and in "
    "space; a disc that corrodes freely, which shrinks at V_m i0/(z F) whatever the conductivity.",
    "Signs of currents, areas of surfaces on the lattice, distances to them, circuits that are not one, potentials "
    "that count from elsewhere, Faraday's law with the wrong charge.",
    "Waber 1954 (finite depth), Newman 1966 (40 terms), curves of Hoeche 2015 with the root found by halves; tables "
    "`coplanar_galvanic_equal_wagner.csv`, `disc_current_distribution.csv`, `mg_al_galvanic_hoeche.csv`",
    galvanic_parts, (int)(sizeof galvanic_parts / sizeof galvanic_parts[0])};

#endif
#endif
