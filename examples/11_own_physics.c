/* 11: a physics of one's own: heat conduction with a section [heat], a field T that the law of the metal reads.
 *
 *     cc -std=c99 -O2 -I. examples/11_own_physics.c -o 11_own_physics -lm
 *
 * A strip of metal between a hot and a cold side dissolves faster where it is hot. T is written, drawn and probed, and
 * kept in checkpoints, as the fields of the library are. */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { KEY_D, KEY_D_METAL, KEY_INITIAL, KEYS };

static const pd_key keys[KEYS] = {
    {"D", "m2/s", "1.4e-7 m2/s", "thermal diffusivity of the fluid", PD_KEY_EXPRESSION_POSITIVE},
    {"D_metal", "m2/s", "8.8e-5 m2/s", "that of the metal, whose heat capacity per volume is that of the fluid",
     PD_KEY_EXPRESSION_POSITIVE},
    {"initial", "K", "293.15 K", "temperature at the start", PD_KEY_EXPRESSION_POSITIVE}};
static const pd_physics_field fields[] = {{"T", "K", PD_FIELD_IN_BOTH}};

typedef struct heat {
    const pd_physics_view *view;
    pd_krylov solver;
    double *T, *b;   /* [total] [K] temperature, right-hand side; in one block */
    double time, dt; /* [s] */
} heat;

/* Diffusivity [m2/s] of a node; 0: no heat passes. */
static double diffusivity(const heat *s, int32_t node)
{
    double x[PD_DIM];
    int kind = s->view->grid->kind[node];
    if (kind != PD_FLUID && kind != PD_SOLID) return 0.0;
    pd_grid_position(s->view->grid, node, x);
    return s->view->value(s->view, kind == PD_SOLID ? KEY_D_METAL : KEY_D, x, s->time);
}

static void heat_free(pd_ctx *ctx, void *self)
{
    heat *s = (heat *)self;
    pd_krylov_free(ctx, &s->solver);
    free(s->T);
    free(s);
}

static pd_status heat_build(pd_ctx *ctx, const pd_physics_view *view, void **state)
{
    size_t n = (size_t)view->grid->total;
    heat *s = (heat *)calloc(1, sizeof *s);
    pd_krylov_desc cg = {0};
    if (!s) return PD_ERR_MEMORY;
    s->view = view;
    s->T = (double *)calloc(2 * n, sizeof *s->T);
    s->b = s->T + n;
    cg.method = PD_KRYLOV_CG;
    cg.n = view->grid->total;
    cg.rtol = 1e-12;
    cg.max_iterations = 10000;
    pd_status status = s->T ? pd_krylov_build(ctx, &cg, &s->solver) : PD_ERR_MEMORY;
    for (int32_t i = 0; i < view->grid->total && status == PD_OK; i++) {
        double x[PD_DIM];
        pd_grid_position(view->grid, i, x);
        s->T[i] = view->value(view, KEY_INITIAL, x, 0.0);
    }
    if (status < 0) heat_free(ctx, s);
    *state = status == PD_OK ? s : NULL;
    return status;
}

/* y = T - dt times the heat that flows in, by the harmonic mean of the diffusivities at a face. held: add to y what
 * sides give in that time, in place of what they take. */
static void conduct(const heat *s, const double *T, double *y, int held)
{
    const pd_grid *g = s->view->grid;
    for (int32_t i = 0; i < g->total; i++) {
        double x[PD_DIM], sum = 0.0, value, own = diffusivity(s, i);
        if (!(own > 0.0)) continue;
        pd_grid_position(g, i, x);
        for (int side = 0; side < 2 * PD_DIM; side++) {
            int d = side / 2, up = side % 2;
            int32_t j = i + (up ? 1 : -1) * g->stride[d];
            double over = s->dt / (g->h[d] * g->h[d]);
            if (up ? x[d] + g->h[d] > g->lo[d] + g->n[d] * g->h[d] : x[d] - g->h[d] < g->lo[d]) {
                if (s->view->prescribed(s->view, side, x, s->time, &value))
                    sum += 2.0 * own * over * (held ? -value : T[i]);
            } else if (!held) {
                double other = diffusivity(s, j);
                sum += 2.0 * own * other / (own + other) * over * (T[i] - T[j]);
            }
        }
        y[i] = T[i] + (held ? -sum : sum);
    }
}

static void apply(void *self, const double *x, double *y) { conduct((const heat *)self, x, y, 0); }

/* One implicit step; `max_step` of the scene bounds it. */
static pd_status heat_attempt(pd_ctx *ctx, void *self, pd_step *step)
{
    heat *s = (heat *)self;
    pd_krylov_result result;
    s->time = step->end;
    s->dt = step->end - step->time;
    conduct(s, s->T, s->b, 1);
    return pd_krylov_solve(ctx, &s->solver, apply, NULL, s, s->b, s->T, &result);
}

static pd_status heat_checkpoint(pd_ctx *ctx, void *self, pd_archive *archive)
{
    heat *s = (heat *)self;
    pd_status status = archive->transfer(ctx, archive->user, "heat.time", &s->time, sizeof s->time, 1);
    if (status < 0) return status;
    return archive->transfer(ctx, archive->user, "heat.T", s->T, sizeof *s->T, s->view->grid->total);
}

static void heat_set_process(void *self, pd_physics *p)
{
    p->name = "heat";
    p->self = self;
    p->has_substeps = 1;
    p->attempt = heat_attempt;
    p->checkpoint = heat_checkpoint;
}

static const double *heat_values(const void *self, int field) { return field == 0 ? ((const heat *)self)->T : NULL; }

int main(int argc, char **argv)
{
    const pd_physics_type type = {{"heat", "", "conduction of heat in fluid and metal", keys, KEYS}, fields, 1,
                                  heat_build, heat_free, heat_set_process, heat_values, 56.0};
    pd_ctx ctx;
    pd_setup setup;
    pd_run_result result;
    pd_run_desc desc = {0};
    pd_ctx_init(&ctx);
    pd_status status = pd_physics_type_register(&ctx, &type);
    if (status >= 0)
        status = pd_scene_read(&ctx, argc > 1 ? argv[1] : "examples/11_own_physics.scene", NULL, 0, &setup);
    if (status >= 0) {
        status = pd_run(&ctx, &setup, &desc, &result);
        if (status >= 0) printf("%.4g %% of the strip is lost after %g s\n", 100.0 * result.volume_loss, result.time);
        pd_setup_free(&ctx, &setup);
    }
    if (status < 0) fprintf(stderr, "%s\n", ctx.message);
    return status < 0 || ctx.in_use != 0;
}
