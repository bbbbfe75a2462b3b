/* hard: plays a hard case: a scene as text, step by step, every step held to the balance, the bounds of the
 * concentration, the residuals and an end. Include it behind `#define _XOPEN_SOURCE 700`.
 *
 * Each part of a case ends with a line for tools/report.sh:
 *
 *   result case=TEST dim=2 part=couple outcome=answer err=1e-9 measure=what_err_is ledger=... bounds=... residual=...
 *          steps=... naive=0.5 naive_what=what_a_plain_scheme_does message=text to the end of the line
 *
 * outcome: answer (the run came to its end), refused (with the message), failed (a check of the test did not hold).
 * With PD_HARD=1 in the environment the long sweeps run, for `make test-hard`.
 */
#ifndef HARD_H
#define HARD_H
#include "scene_file.h"

/* Ranges of the axes across x, and the same only in 3D. */
#if PD_DIM == 1
#define ACROSS(range) ""
#define ALONG_Z(range) ""
#elif PD_DIM == 2
#define ACROSS(range) ", " range
#define ALONG_Z(range) ""
#else
#define ACROSS(range) ", " range ", " range
#define ALONG_Z(range) ", " range
#endif

#define LEDGER 1e-12 /* [-] relative to the metal at the start */
#define BOUNDS 1e-9  /* [-] by which concentrations may leave their bounds, over the largest */
#define SALT 6.1e-9  /* [-] as BOUNDS, of bond-based corrosion: what a node is owed, PDI_DISSOLVE_MARGIN at most, and
                      * that of the step before, and rounding */
#define LIMITED 1e-8 /* [-] by which fields of the same scene in other words may differ over Csat with limited
                      * fluxes: the tolerances of the solvers */
#define LEVEL 1e-10  /* [-] by which the flow far up and far down may differ: steady fluxes are free of divergence */

typedef struct hard {
    pd_ctx ctx;
    pd_setup setup;
    pd_model model;
    pd_status status;                /* of what ended it */
    int built, open;                 /* 1: the model, the setup is there */
    int most;                        /* steps that the run may take */
    double low, high;                /* [mol/m3] bounds of the fluid */
    double ledger, excess, residual; /* [-] worst of the run */
    double flux;                     /* [-] mismatch of the flow far up and far down */
    double rounding;                 /* [-] that sums over bonds may leave of the ledger */
    double salt;                     /* [-] what rounding leaves of bond-based corrosion in its longest step */
    int failures;                    /* of the test before this part */
} hard;

static hard hard_one;
static const char *hard_override; /* "m=2": replaces a value of the next scene */

static inline int hard_long(void)
{
    const char *value = getenv("PD_HARD");
    return value && value[0] == '1';
}

/* Three dimensions cost minutes. */
#define NOT_IN_3D() \
    do { \
        if (PD_DIM == 3 && !hard_long()) SKIP("in 3D with PD_HARD=1 alone"); \
    } while (0)

static inline const double *hard_field(const hard *h) { return h->model.transport.c; }

static inline void hard_extremes(const hard *h, double *low, double *high)
{
    const double *c = hard_field(h);
    *low = HUGE_VAL;
    *high = -HUGE_VAL;
    for (int32_t i = 0; i < h->model.grid.total; i++) {
        if (h->model.grid.kind[i] != PD_FLUID) continue;
        *low = fmin(*low, c[i]);
        *high = fmax(*high, c[i]);
    }
}

/* What the start, inlets and held walls bring, and saturation. */
static inline void hard_bounds(hard *h)
{
    const pd_setup *u = &h->setup;
    if (!u->has_transport) return;
    const double origin[PD_DIM] = {0.0}; /* held values are constants here */
    hard_extremes(h, &h->low, &h->high);
    for (int s = 0; s < 2 * PD_DIM; s++) {
        double bring = u->inlet_c;
        if (u->side[s].has_fixed_c) bring = pdi_setup_eval_expr(&u->side[s].fixed_c, origin, 0.0);
        if (!u->side[s].has_fixed_c && !pd_grid_is_inlet_or_outlet(u->side[s].kind)) continue;
        h->low = fmin(h->low, bring);
        h->high = fmax(h->high, bring);
    }
    for (int w = 0; w < u->wall_count; w++) {
        if (!u->wall_shape[w].has_fixed_c) continue;
        double held = pdi_setup_eval_expr(&u->wall_shape[w].fixed_c, origin, 0.0);
        h->low = fmin(h->low, held);
        h->high = fmax(h->high, held);
    }
    if (!u->has_dissolve) return;
    h->low = fmin(h->low, 0.0);
    h->high = fmax(h->high, u->saturation);
    for (int m = 0; m < u->metals; m++) h->high = fmax(h->high, u->threshold * u->metal[m].solid_c);
}

/* Reads and builds; 0: refused, with status and message. */
static inline int hard_open(hard *h, const char *text)
{
    memset(h, 0, sizeof *h);
    h->failures = test_now.failures;
    h->most = 20000;
    h->status = load(&h->ctx, text, &hard_override, hard_override != NULL, &h->setup);
    hard_override = NULL;
    if (h->status < 0) return 0;
    h->open = 1;
    h->status = pd_model_build(&h->ctx, &h->setup, &h->model);
    if (h->status < 0) return 0;
    h->built = 1;
    hard_bounds(h);
    return 1;
}

static inline void hard_watch(hard *h)
{
    const pd_time_loop *c = &h->model.time_loop;
    double low, high, size = fmax(fabs(h->low), fabs(h->high));
    /* over what has been there, or has passed */
    const pd_mass_balance *l = &c->ledger[0];
    double amount = fmax(fmax(l->start, l->solid_start), fmax(l->in, l->out));
    if (amount > 0.0) h->ledger = fmax(h->ledger, fabs(l->imbalance) / amount);
    /* a step rounds what passes each node in it */
    double fastest = 0.0;
    int moves = h->setup.has_flow && h->setup.flow_time != PD_FLOW_PRESCRIBED && h->setup.has_transport;
    for (int32_t i = 0; i < PD_DIM * c->grid->total && moves; i++)
        fastest = fmax(fastest, fabs(h->model.flow.u[i]));
    if (amount > 0.0) h->rounding += 1.1e-16 * c->dt * fastest / c->grid->h[0] * l->dissolved / amount;
    if (h->model.quasi.steady)
        h->residual = fmax(h->residual, h->model.quasi.result.residual_over_tolerance * h->model.steady.desc.tolerance);
    if (h->setup.has_transport) {
        hard_extremes(h, &low, &high);
        if (h->setup.activation) low = high = 0.0;
        h->excess = fmax(h->excess, size > 0.0 ? fmax(h->low - low, high - h->high) / size : fmax(-low, high));
        if (!(low <= high)) h->excess = h->model.grid.fluid_count ? HUGE_VAL : h->excess; /* NaN */
    }
    if (h->setup.has_corrode && !h->setup.activation)
        h->salt = fmax(h->salt, 3.1e-14 * c->dt * h->setup.diffusivity * h->model.dissolve.spread);
    if (!h->setup.has_flow || h->setup.flow_time == PD_FLOW_PRESCRIBED) return;
    if (h->setup.side[0].kind != PD_SIDE_INLET || h->model.grid.n[0] < 4) return;
    double up = pd_flow_integrate_section(&h->ctx, &h->model.flow, 0, 1);
    double down = pd_flow_integrate_section(&h->ctx, &h->model.flow, 0, h->model.grid.n[0] - 1);
    if (fabs(up) > 0.0) h->flux = fmax(h->flux, fabs(down - up) / fabs(up));
}

/* Steps up to t_end [s]. 0: a step failed, with status and message. */
static inline int hard_steps(hard *h, double t_end)
{
    pd_time_loop *c = &h->model.time_loop;
    if (c->steps == 0 && c->time <= 0.0) {
        h->status = pd_time_loop_start(&h->ctx, c);
        if (h->status < 0) return 0;
        hard_watch(h);
    }
    for (int step = 0; c->time < t_end; step++) {
        if (!CHECK(step < h->most)) return 0;
        h->status = pd_time_loop_step(&h->ctx, c, t_end);
        if (h->status < 0) return 0;
        hard_watch(h);
    }
    return 1;
}

/* The worst of the run against what every run is held to. */
static inline int hard_sound(const hard *h)
{
    const pd_setup *u = &h->setup;
    int steady = u->has_flow && u->flow_time == PD_FLOW_STEADY;
    double bound = u->has_flow && !steady ? fmax(BOUNDS, u->steady_tolerance) : BOUNDS;
    if (u->has_corrode) bound = fmax(bound, fmax(SALT, h->salt));
    /* rounding of a step adds up */
    int good = CHECK_LE(h->ledger, fmax(fmax(LEDGER, h->rounding), 2.2e-16 * (double)h->model.time_loop.steps));
    good = CHECK_INT(h->model.time_loop.unsolved, 0) && good;
    /* held fluid has no concentration of its own: it passes on what it takes */
    if (!u->activation) good = CHECK_LE(h->excess, bound) && good;
    if (steady) good = CHECK_LE(h->residual, u->steady_tolerance) && good;
    if (steady) good = CHECK_LE(h->flux, LEVEL) && good;
    return good;
}

/* Reads, builds and runs to the end of the scene, soundly. */
static inline int hard_play(hard *h, const char *text)
{
    if (!CHECK(hard_open(h, text)) || !CHECK(hard_steps(h, h->setup.end_time))) {
        NOTE("status %d: %s", (int)h->status, h->ctx.message);
        return 0;
    }
    CHECK(h->model.time_loop.time >= h->setup.end_time);
    return hard_sound(h);
}

static inline void hard_close(hard *h)
{
    if (h->built) pd_model_free(&h->ctx, &h->model);
    if (h->open) pd_setup_free(&h->ctx, &h->setup);
    h->built = h->open = 0;
    CHECK_INT(h->ctx.in_use, 0);
}

/* The line of a part. measure NULL: no error; naive_what NULL: no naive scheme. The case is the running test. */
static inline void hard_line(const char *part, int failed, const char *message, double err, const char *measure)
{
    printf("result case=%s dim=%d part=%s outcome=%s", test_now.name, PD_DIM, part,
           failed    ? "failed"
           : message ? "refused"
                     : "answer");
    if (measure) printf(" err=%.2e measure=%s", err, measure);
}

static inline void hard_naive(double naive, const char *naive_what, const char *message)
{
    if (naive_what) printf(" naive=%.3g naive_what=%s", naive, naive_what);
    if (message) printf(" message=%s", message);
    printf("\n");
}

/* Prints the line and frees everything. */
static inline void hard_end(hard *h, const char *part, double err, const char *measure, double naive,
                            const char *naive_what)
{
    char message[PD_MESSAGE_SIZE];
    const char *said = h->status < 0 ? message : NULL;
    const char *file = strstr(h->ctx.message, "a.scene"); /* without the folder of the test */
    snprintf(message, sizeof message, "%s", file ? file : h->ctx.message);
    int64_t steps = h->built ? h->model.time_loop.steps : 0;
    hard_close(h);
    hard_line(part, test_now.failures > h->failures, said, err, said ? NULL : measure);
    if (steps)
        printf(" ledger=%.1e bounds=%.1e residual=%.1e steps=%ld", h->ledger, h->excess, h->residual, (long)steps);
    hard_naive(naive, naive_what, said);
}

/* The scene is refused when read, built or run, with a message that holds `part`. */
static inline void hard_refused(hard *h, const char *text, const char *name, const char *part, pd_status status)
{
    if (hard_open(h, text) && hard_steps(h, h->setup.end_time)) CHECK(!"the scene is refused");
    CHECK_INT(h->status, status);
    if (!CHECK(strstr(h->ctx.message, part) != NULL)) NOTE("message: %s; expected: %s", h->ctx.message, part);
    hard_end(h, name, 0.0, NULL, 0.0, NULL);
}

/* A part without a scene, from `failures` of the test before it. */
static inline void hard_done(const char *part, int failures, double err, const char *measure, double naive,
                             const char *naive_what)
{
    hard_line(part, test_now.failures > failures, NULL, err, measure);
    hard_naive(naive, naive_what, NULL);
}

#endif
