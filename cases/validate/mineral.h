/* mineral: solids that form and dissolve in a lattice, against closed forms and a table. Included by cases.h alone. */
#ifndef VAL_MINERAL_H
#define VAL_MINERAL_H
#include "../vessel.h"
#include "../minerals.h"
#include "case.h"

static void mineral_out(val_job *job, double h, int at, const mineral_found *f)
{
    job->out->h = h;
    job->out->err[at] = f->room;
    job->out->err[at + 1] = f->imbalance;
    job->out->err[at + 2] = fmax(0.0, -f->least);
}

/* brucite_ph.csv at 25 C: log10 K, NaCl [mol/m3], pH ideal without MgOH+, pH with Davies and MgOH+. */
static const double mineral_brucites[][4] = {
    {16.298, 0.0, 10.200, 10.212}, {16.750, 0.0, 10.350, 10.365},   {16.792, 0.0, 10.364, 10.380},
    {16.840, 0.0, 10.380, 10.396}, {16.840, 145.0, 10.380, 10.502}, {17.100, 0.0, 10.467, 10.485}};

/* Ideal in one step of 1e6 s, with Davies in forty of 100 s. */
static pd_status mineral_brucite_run(val_job *job)
{
    const double *b = mineral_brucites[(int)job->level.p - 1];
    mineral_found ideal, davies;
    PD_TRY(mineral_brucite(job->ctx, b[0], PD_ACTIVITY_IDEAL, b[1], 0.0, 1e6, 1, &ideal));
    PD_TRY(mineral_brucite(job->ctx, b[0], PD_ACTIVITY_DAVIES, b[1], 1e-3, 100.0, 2, &davies));
    mineral_out(job, 1e-5, 2, &davies);
    job->out->err[0] = fmax(fabs(ideal.ph - b[2]), fabs(davies.ph - b[3]));
    job->out->err[1] = fmax(ideal.drift, davies.drift);
    return PD_OK;
}

static pd_status mineral_speed_run(val_job *job)
{
    mineral_found f;
    PD_TRY(mineral_speed(job->ctx, job->level.n, &f));
    mineral_out(job, 1e-5, 1, &f);
    job->out->x = 1.0 / job->level.n;
    job->out->err[0] = f.value;
    job->out->steps = job->level.n;
    return PD_OK;
}

static pd_status mineral_front_run(val_job *job)
{
    const mineral_couple *c = &mineral_couples[(int)job->level.p - 1];
    mineral_found f;
    PD_TRY(mineral_front(job->ctx, c, job->level.n, 0.02, 1, &f));
    mineral_out(job, 2.0 * mineral_half(c) / job->level.n, 2, &f);
    job->out->err[0] = f.value;
    job->out->err[1] = f.product;
    return PD_OK;
}

static pd_status mineral_pores_run(val_job *job)
{
    mineral_found f;
    PD_TRY(mineral_pores(job->ctx, job->level.n, job->level.m, 1e6, &f));
    mineral_out(job, MINERAL_LENGTH / job->level.n, 1, &f);
    job->out->err[0] = f.value;
    return PD_OK;
}

#define MINERAL_KEPT \
    {"err_room", "room of solids against their volumes"}, {"imbalance", "elements and charge"}, \
    {"negative", "below zero [mol/m3]"}

static const val_part mineral_brucite_part = {
    "brucite", "pH of water over brucite of six constants", "row of the table", VAL_BY_P, "row", 0.0,
    {{"err_ph", "pH"}, {"drift", "pH in later steps of 1 ms to 1e9 s"}, MINERAL_KEPT}, 5,
    {{0, 0.002, 0.0, 0, VAL_GOAL}, {1, 1e-9, 0.0, 0, VAL_GOAL}, {2, 1e-12, 0.0, 0, VAL_GOAL},
     {3, 1e-12, 0.0, 0, VAL_GOAL}, {4, 0.0, 0.0, 0, VAL_GOAL}}, 5,
    {{6, 2.0, 1.0}, {6, 2.0, 2.0}, {6, 2.0, 3.0}, {6, 2.0, 4.0}, {6, 2.0, 5.0}, {6, 2.0, 6.0}}, 6,
    PD_DIM == 1 ? 6 : 1, mineral_brucite_run, NULL};

static const val_part mineral_speed_part = {
    "speed", "a solid that dissolves by a law of the third order in a closed volume", "steps", VAL_BY_N, "1/steps", 2.0,
    {{"err_time", "time"}, MINERAL_KEPT}, 4,
    {{0, 1e-4, 0.0, 0, VAL_GOAL}, {0, 0.0, 1.7, 0, VAL_GOAL}, {1, 1e-12, 0.0, 0, VAL_GOAL},
     {2, 1e-12, 0.0, 0, VAL_GOAL}, {3, 0.0, 0.0, 0, VAL_GOAL}}, 5,
    {{40, 2.0, 0.0}, {80, 2.0, 0.0}, {160, 2.0, 0.0}}, 3, PD_DIM == 1 ? 3 : 2, mineral_speed_run, NULL};

#if PD_DIM == 1
#define MINERAL_FRONTS {{240, 2.0, 1.0}, {240, 2.0, 2.0}, {240, 2.0, 3.0}}, 3, 3
#else
#define MINERAL_FRONTS {{240, 2.0, 3.0}}, 1, 1
#endif

static const val_part mineral_front_part = {
    "fronts", "fronts at which A + n B become a solid at once", "couple", VAL_BY_P, "couple", 0.0,
    {{"err_place", "place of the front"}, {"err_product", "amount of the solid"}, MINERAL_KEPT}, 5,
    {{0, 0.005, 0.0, 0, VAL_GOAL}, {1, 0.01, 0.0, 0, VAL_GOAL}, {3, 1e-12, 0.0, 0, VAL_GOAL},
     {4, 0.0, 0.0, 0, VAL_GOAL}}, 4, MINERAL_FRONTS, mineral_front_run, NULL};

static const val_part mineral_pores_part = {
    "pores", "diffusion through water and pores of a solid", "cells", VAL_BY_N, NULL, 1.0,
    {{"err_field", "concentration over the largest"}, MINERAL_KEPT}, 4,
    {{0, 0.001, 0.0, 160, VAL_GOAL}, {0, 0.005, 0.0, 0, VAL_GUARD}, {1, 1e-12, 0.0, 0, VAL_GOAL},
     {2, 1e-12, 0.0, 0, VAL_GOAL}, {3, 0.0, 0.0, 0, VAL_GOAL}}, 5,
    {{40, 2.0, 0.0}, {80, 2.0, 0.0}, {160, 2.0, 0.0}}, 3, PD_DIM == 1 ? 3 : 2, mineral_pores_run,
    NULL};

static const val_part *const mineral_parts[] = {&mineral_brucite_part, &mineral_speed_part, &mineral_front_part,
                                                &mineral_pores_part};

static const val_case mineral_case = {
    "mineral", "Solids that form and dissolve",
    "Brucite of six constants in water and in saline, with and without activities and a complex, until it is "
    "saturated; a solid that dissolves with a speed in a closed volume; fronts of two species that become a solid "
    "where they meet; diffusion through a layer whose pores a solid leaves.",
    "Solids that form below saturation, equilibria that move with the step, a front that sticks to nodes, pores that "
    "count twice, room that does not belong to what is there.",
    "table `brucite_ph.csv`, an integral in closed form, similarity solutions of instantaneous reactions, layers in "
    "series",
    mineral_parts, (int)(sizeof mineral_parts / sizeof mineral_parts[0])};

#endif
