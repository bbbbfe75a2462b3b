/* strip: a crack in a strip of metal whose clamped edges are pulled apart, and J at which it runs, for validation cases
 * and tests. Include pdcorr.h, or run/sim.h and solid/crack.h, before. */
#ifndef CASES_STRIP_H
#define CASES_STRIP_H
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if PD_DIM > 1
#define STRIP_HIGH 16e-6     /* [m] from grip to grip */
#define STRIP_CRACK 16e-6    /* [m] length of the crack at the start */
#define STRIP_END 22e-6      /* [m] a tip that is here has run */
#define STRIP_TOUGHNESS 0.06 /* [J/m2] */

typedef struct strip_case {
    int cells;         /* from grip to grip */
    int layers;        /* along the front, in 3D: the strip does not get thinner (plane strain), its sides are free */
    double stiffness;  /* [-] (lambda + 2 mu)/E of its plane */
    const char *solid; /* keys of its section [solid] besides E, rtol and toughness */
} strip_case;

static inline double strip_stiffness(double nu) { return (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)); }

/* The scene of it: the upper grip moves by 1 nm a second. */
static inline void strip_scene(const strip_case *strip, char *text, size_t size)
{
    char deep[64] = "";
    double h = 1e6 * STRIP_HIGH / strip->cells;
    if (PD_DIM == 3) snprintf(deep, sizeof deep, ", 0 um .. %.9g um", h * strip->layers);
    snprintf(text, size,
             "[grid] h = %.9g um  box = 0 um .. 40 um, -10 um .. 10 um%s\n"
             "[shape bar] box = 0 um .. 40 um, -10 um .. 10 um%s  kind = solid\n"
             "[shape low] box = 0 um .. 40 um, -10 um .. -8 um%s  kind = grip  ux = 0 um  uy = 0 um\n"
             "[shape up] box = 0 um .. 40 um, 8 um .. 10 um%s  kind = grip  ux = 0 um  uy = 1 nm * t/(1 s)\n"
             "%s%s%s[solid] E = 45 GPa  fracture_energy = %g J/m2  rtol = 1e-6  %s\n",
             h, deep, deep, deep, deep, PD_DIM == 3 ? "[shape all] box = 0 um .. 40 um, -10 um .. 10 um" : "", deep,
             PD_DIM == 3 ? "  kind = grip  uz = 0 um\n" : "", STRIP_TOUGHNESS, strip->solid);
    size_t used = strlen(text);
    if (PD_DIM == 2)
        snprintf(text + used, size - used, "[crack a] points = 0 um, 0 um, 16 um, 0 um\n[run] until = 99 s\n");
    else
        snprintf(text + used, size - used,
                 "[crack a] points = 0 um, 0 um, 0 um, 16 um, 0 um, 0 um, 16 um, 0 um, %g um, 0 um, 0 um, %g um  "
                 "direction = 1, 0, 0\n[run] until = 99 s\n",
                 h * strip->layers, h * strip->layers);
}

/* At rest at time t: where the tip is, and J while it has not run; others begin where the grips end. */
static inline pd_status strip_at(pd_ctx *ctx, const strip_case *strip, pd_sim *sim, double t, double *tip, double *j)
{
    static const double way[PD_DIM] = {1.0};
    pd_solid_coupling *s = &sim->model.solid;
    pd_crack_desc crack;
    memset(&crack, 0, sizeof crack);
    pd_status status = pd_quasi_static_solve_at(ctx, &s->static_solver, t);
    if (status < 0) return status;
    const pd_setup_precrack *cut = &sim->setup.metal_body.precrack[0];
    status = pd_crack_find_tip(ctx, &s->body, cut->corners, cut->corner, s->stiffness_factor, way, tip);
    if (status < 0 || tip[0] > STRIP_END) return status;
    memcpy(crack.tip, tip, sizeof crack.tip);
    crack.direction[0] = 1.0;
    crack.inner = 0.15 * STRIP_HIGH;
    crack.outer = 0.45 * STRIP_HIGH;
    crack.front[PD_DIM - 1] = 1.0;
    crack.thickness = STRIP_HIGH / strip->cells * strip->layers;
    return pd_crack_j(ctx, &s->solid, &crack, s->static_solver.u, j);
}

/* Steps of 1 % of the load until the crack has gone on by 6 um: *j, the largest J at rest on the way, and *closed, that
 * of a long strip under the same load, both over the toughness. */
static inline pd_status strip_run(pd_ctx *ctx, const strip_case *strip, double *j, double *closed)
{
    char text[2048];
    double tip[PD_DIM] = {0.0}, now = 0.0;
    double asked = STRIP_HIGH * sqrt(2.0 * STRIP_TOUGHNESS / (strip->stiffness * 45e9 * STRIP_HIGH)) / 1e-9;
    pd_sim *sim = (pd_sim *)calloc(1, sizeof *sim);
    *j = *closed = 0.0;
    if (!sim) return PD_ERR_MEMORY;
    strip_scene(strip, text, sizeof text);
    pd_status status = pd_sim_open(ctx, text, NULL, 0, sim);
    for (double t = 0.8 * asked; status == PD_OK && t < 2.0 * asked; t *= 1.01) {
        status = strip_at(ctx, strip, sim, t, tip, &now);
        if (tip[0] > STRIP_END) break;
        if (now > *j * STRIP_TOUGHNESS) *closed = t / asked * (t / asked);
        *j = fmax(*j, now / STRIP_TOUGHNESS);
    }
    pd_sim_close(ctx, sim);
    free(sim);
    return status;
}
#endif

#endif
