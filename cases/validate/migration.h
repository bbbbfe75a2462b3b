/* migration: ions in the potential that keeps them neutral, against closed forms and their tables. Included by cases.h
 * alone. */
#ifndef VAL_MIGRATION_H
#define VAL_MIGRATION_H
#include "../vessel.h"
#include "../salts.h"
#include "case.h"

static void migration_keep(val_job *job, double h, int at, const salt_found *f)
{
    job->out->h = h;
    job->out->err[at] = f->neutral;
    job->out->err[at + 1] = f->imbalance;
}

/* ---- salts ---- */

static pd_status migration_salt_run(val_job *job)
{
    const salt *a = &salt_table[(int)job->level.p - 1];
    salt_found f;
    PD_TRY(salt_wave(job->ctx, a, job->level.n, job->level.m, job->level.n, PD_SIDE_WALL, &f));
    migration_keep(job, SALT_LENGTH / job->level.n, 2, &f);
    job->out->err[0] = fabs(f.d / a->ambipolar - 1.0);
    job->out->err[1] = fabs(f.share / a->share - 1.0);
    job->out->steps = job->level.n;
    return PD_OK;
}

/* ---- dissolution ---- */

/* np_supported_dissolution.csv: cb/cs; N L/(D cs) and mV of the metal, z = 1 and 2. */
static const double migration_table[][5] = {
    {0.001, 1.998002, 177.4781, 2.998001, 195.2868}, {0.01, 1.980200, 118.3213, 2.980100, 136.1281},
    {0.1, 1.819804, 59.4125, 2.809975, 77.0321},     {1.0, 1.236068, 12.3636, 1.828427, 22.6448},
    {10.0, 1.024984, 1.2841, 1.099751, 2.5650},      {100.0, 1.002500, 0.1285, 1.010000, 0.2569}};
enum { MIGRATION_RATIOS = (int)(sizeof migration_table / sizeof migration_table[0]) };

static pd_status migration_bath_run(val_job *job, int z)
{
    const double *row = NULL;
    salt_found f;
    for (int k = 0; k < MIGRATION_RATIOS; k++)
        if (fabs(migration_table[k][0] / job->level.p - 1.0) < 1e-9) row = migration_table[k];
    if (!row) return pd_fail(job->ctx, PD_ERR_ARGUMENT, "migration", "no row of this ratio");
    PD_TRY(salt_dissolution(job->ctx, z, job->level.p, job->level.n, job->level.m, &f));
    migration_keep(job, SALT_GAP / job->level.n, 3, &f);
    job->out->err[0] = fabs(f.enhancement / row[2 * z - 1] - 1.0);
    job->out->err[1] = fabs(1e3 * f.volts / row[2 * z] - 1.0);
    job->out->err[2] = fmax(f.c, f.psi);
    return PD_OK;
}

static pd_status migration_one_run(val_job *job) { return migration_bath_run(job, 1); }
static pd_status migration_two_run(val_job *job) { return migration_bath_run(job, 2); }

static pd_status migration_blocked_run(val_job *job)
{
    salt_found f;
    PD_TRY(salt_blocked(job->ctx, (int)job->level.p, job->level.n, job->level.m, &f));
    migration_keep(job, SALT_GAP / job->level.n, 2, &f);
    job->out->err[0] = fabs(f.enhancement / (1.0 + job->level.p) - 1.0);
    job->out->err[1] = f.psi;
    return PD_OK;
}

/* ---- what is kept ---- */

/* p: the step [s]; the time of diffusion is 1000 s. */
static pd_status migration_kept_run(val_job *job)
{
    salt_found f;
    PD_TRY(salt_mix(job->ctx, 100.0, 1e-4, job->level.n, job->level.m, job->level.p, &f));
    migration_keep(job, SALT_KEPT_LENGTH / job->level.n, 0, &f);
    job->out->err[2] = f.current;
    job->out->err[3] = fmax(0.0, -f.least);
    return PD_OK;
}

/* ---- parts ---- */

#define MIGRATION_KEPT {"neutral", "charge of a node over its ions"}, {"imbalance", "elements and charge"}
#if PD_DIM == 1
#define MIGRATION_SALTS \
    {{100, 2.0, 1.0}, {100, 2.0, 2.0}, {100, 2.0, 3.0}, {100, 2.0, 4.0}, {100, 2.0, 5.0}, {100, 2.0, 6.0}, \
     {100, 2.0, 7.0}}, 7, 7
#define MIGRATION_BATHS \
    {{6400, 1.0, 0.001}, {1600, 1.0, 0.01}, {400, 1.0, 0.1}, {200, 1.0, 1.0}, {200, 1.0, 10.0}, {200, 1.0, 100.0}}, \
    6, 6
#else
#define MIGRATION_SALTS {{100, 2.0, 4.0}, {100, 2.0, 3.0}}, 2, 1
#define MIGRATION_BATHS {{200, 1.0, 0.1}, {100, 1.0, 1.0}}, 2, 1
#endif

static const val_part migration_salt_part = {
    "salts", "a salt that diffuses: NaCl, KCl, HCl, MgCl2, Mg(OH)2, AlCl3, MgSO4", "salt", VAL_BY_P, "salt", 0.0,
    {{"err_d", "ambipolar D"}, {"err_t", "transference number"}, MIGRATION_KEPT}, 4,
    {{0, 0.001, 0.0, 0, VAL_GOAL}, {1, 0.001, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}}, 4, MIGRATION_SALTS, migration_salt_run, NULL};

#define MIGRATION_BATH_MEASURES \
    {{"err_flux", "flux for a given metal salt"}, {"err_phi", "potential of the metal"}, \
     {"err_profile", "profiles of c and phi, largest"}, MIGRATION_KEPT}, 5, \
    {{0, 0.001, 0.0, 0, VAL_GOAL}, {1, 0.001, 0.0, 0, VAL_GOAL}, {2, 0.001, 0.0, 0, VAL_GOAL}, \
     {3, 1e-12, 0.0, 0, VAL_GOAL}, {4, 1e-12, 0.0, 0, VAL_GOAL}}, 5

static const val_part migration_one_part = {
    "support1", "Ag+ that enters NaCl", "salt of the bath over that of the metal", VAL_BY_P, "ratio", 0.0,
    MIGRATION_BATH_MEASURES, MIGRATION_BATHS, migration_one_run, NULL};

static const val_part migration_two_part = {
    "support2", "Mg2+ that enters NaCl", "salt of the bath over that of the metal", VAL_BY_P, "ratio", 0.0,
    MIGRATION_BATH_MEASURES, MIGRATION_BATHS, migration_two_run, NULL};

static const val_part migration_blocked_part = {
    "blocked", "a metal that enters its own salt, whose anion stays", "charge of the metal", VAL_BY_P, "z", 0.0,
    {{"err_flux", "flux for a given metal salt"}, {"err_phi", "potential"}, MIGRATION_KEPT}, 4,
    {{0, 0.001, 0.0, 0, VAL_GOAL}, {1, 0.001, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}}, 4,
    {{100, 1.0, 1.0}, {100, 1.0, 2.0}, {100, 1.0, 3.0}}, 3, PD_DIM == 1 ? 3 : 1, migration_blocked_run, NULL};

static const val_part migration_kept_part = {
    "kept", "MgCl2 beside NaCl in water, one step of any length", "step [s]", VAL_BY_P, "dt", 0.0,
    {MIGRATION_KEPT, {"divergence", "current that leaves a node over what its ions bring"},
     {"negative", "below zero [mol/m3]"}}, 4,
    {{0, 1e-12, 0.0, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 0.0, 0.0, 0, VAL_GOAL}}, 4,
    {{60, 2.0, 1e-3}, {60, 2.0, 1.0}, {60, 2.0, 1e3}, {60, 2.0, 1e6}, {60, 2.0, 1e9}}, 5,
    PD_DIM == 1 ? 5 : 1, migration_kept_run, NULL};

static const val_part *const migration_parts[] = {&migration_salt_part, &migration_one_part, &migration_two_part,
                                                  &migration_blocked_part, &migration_kept_part};

static const val_case migration_case = {
    "migration", "Ions in the potential that keeps them neutral",
    "A wave of salt between closed ends, whose decay gives its ambipolar diffusivity and whose potential gives the "
    "transference number; ions of a metal that enter a bath of NaCl, from a thousandth to a hundred times as "
    "concentrated, and their own salt, at rest; two salts in water side by side, in steps from 1 ms to 1e9 s.",
    "Ions that diffuse each by itself, currents that do not sum to zero, charge that a step leaves behind, a potential "
    "with the wrong sign.",
    "closed forms of Nernst and Planck with electroneutrality (Newman and Thomas-Alyea, chapter 11), tables "
    "`ambipolar.csv`, `np_supported_dissolution.csv`",
    migration_parts, (int)(sizeof migration_parts / sizeof migration_parts[0])};

#endif
