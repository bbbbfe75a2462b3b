/* minerals: solids that form and dissolve, against closed forms and tables (theory: 7.7, 8): brucite in water, a
 * speed, fronts where a solid forms at once, the room that it takes. For validation cases and tests. Include vessel.h
 * before. */
#ifndef CASES_MINERALS_H
#define CASES_MINERALS_H

/* Relative errors, and what is kept. */
typedef struct mineral_found {
    double ph, drift;      /* pH, and its largest change in later steps of any length */
    double index;          /* [-] log10 of the saturation, where it is 0 */
    double value, product; /* [-] errors */
    double room;           /* [-] largest difference of the share of a cell from the volume of what it holds */
    double amount, imbalance, least;
    double newton, krylov; /* a step */
    int parts;
} mineral_found;

/* The share of each cell that solids take, against their amounts. */
static inline double mineral_room(vessel *v)
{
    double worst = 0.0;
    for (int32_t i = 0; i < v->grid.total && v->status >= 0; i++) {
        double volume = 0.0;
        if (v->grid.kind[i] != PD_FLUID) continue;
        for (int s = 0; s < v->minerals; s++)
            volume += v->mineral[s].volume * vessel_field(v, v->mineral[s].species)[i];
        worst = fmax(worst, fabs(pd_reactive_film(&v->reactive, i) - volume));
    }
    return worst;
}

static inline void mineral_keep(vessel *v, mineral_found *f)
{
    if (v->status < 0) return;
    f->imbalance = vessel_imbalance(v);
    f->least = vessel_least(v);
    f->room = mineral_room(v);
    f->newton /= v->steps > 0 ? v->steps : 1;
    f->krylov /= v->steps > 0 ? v->steps : 1;
}

static inline void mineral_step(vessel *v, double dt, mineral_found *f)
{
    vessel_step(v, dt);
    f->newton += v->result.newton;
    f->krylov += v->result.krylov;
    f->parts += v->result.parts;
}

/* ---- brucite in water ---- */

/* The pH over brucite of a log10 K, with salt [mol/m3]: dissolved with a speed [mol/m3/s] in 40 steps of dt, or (rate
 * 0) in one step in equilibrium; and then in steps from 1 ms to 10^9 s, which change nothing. */
static inline pd_status mineral_brucite(pd_ctx *ctx, double log_k, pd_activity activity, double salt, double rate,
                                        double dt, int order, mineral_found *f)
{
    static vessel v;
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, 6, 1e-5, 2.0);
    vessel_species(&v, "H2O", NULL, 0.0, 0.0);
    vessel_species(&v, "H+", NULL, 9.31e-9, 1e-4);
    vessel_species(&v, "OH-", NULL, 5.27e-9, 1e-4);
    vessel_species(&v, "Mg2+", NULL, 0.705e-9, 0.0);
    vessel_species(&v, "Na+", NULL, 1.33e-9, salt);
    vessel_species(&v, "Cl-", NULL, 2.03e-9, salt);
    pd_mineral *of = vessel_mineral(&v, "Mg(OH)2(s)", 1.0);
    of->rate = rate;
    of->volume = 24.63e-6;
    if (activity != PD_ACTIVITY_IDEAL) vessel_species(&v, "MgOH+", NULL, 0.7e-9, 0.0);
    vessel_reaction(&v, "H2O = H+ + OH-", -14.0);
    vessel_reaction(&v, "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O", log_k);
    if (activity != PD_ACTIVITY_IDEAL) vessel_reaction(&v, "Mg2+ + H2O = MgOH+ + H+", -11.44);
    v.desc.activity = activity;
    v.desc.order = order;
    vessel_fill(&v);
    for (int k = 0; k < (rate > 0.0 ? 40 : 1); k++) mineral_step(&v, dt, f);
    if (v.status >= 0) {
        int32_t i = vessel_node(&v, 3);
        f->ph = pd_reactive_ph(&v.reactive, i);
        f->index = fabs(pd_reactive_saturation(&v.reactive, 0, i));
        f->amount = vessel_field(&v, of->species)[i];
        for (double more = 1e-3; more < 1e10 && v.status >= 0; more *= 1e4) {
            mineral_step(&v, more, f);
            f->drift = fmax(f->drift, fabs(pd_reactive_ph(&v.reactive, i) - f->ph));
        }
    }
    mineral_keep(&v, f);
    return vessel_end(&v);
}

/* ---- a speed ---- */

/* n' = k ((c/c0)^3 - 1) with c of Mg2+ and 2 c of OH- has t = c0/k int dx/(1 - x^3): error of the time that belongs to
 * the concentration at 500 s. */
static inline pd_status mineral_speed(pd_ctx *ctx, int steps, mineral_found *f)
{
    static vessel v;
    double k = 1e-3, c0 = cbrt(0.25), pi = 3.14159265358979324, end = 500.0;
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, 4, 1e-5, 2.0);
    vessel_species(&v, "Aa2+", "Mg", 1e-9, 0.0);
    vessel_species(&v, "Bb-", "OH", 1e-9, 0.0);
    pd_mineral *of = vessel_mineral(&v, "Mg(OH)2(s)", 5.0);
    of->rate = k;
    of->volume = 24.63e-6;
    vessel_reaction(&v, "Mg(OH)2(s) = Aa2+ + 2 Bb-", -9.0);
    v.desc.order = 2;
    vessel_fill(&v);
    for (int step = 0; step < steps; step++) mineral_step(&v, end / steps, f);
    if (v.status >= 0) {
        double c = vessel_field(&v, 0)[vessel_node(&v, 2)] / c0;
        double sum = log((c * c + c + 1.0) / ((1.0 - c) * (1.0 - c))) / 6.0;
        sum += (atan((2.0 * c + 1.0) / sqrt(3.0)) - pi / 6.0) / sqrt(3.0);
        f->value = fabs(c0 / k * sum / end - 1.0);
        f->amount = vessel_field(&v, 0)[vessel_node(&v, 2)] + vessel_field(&v, of->species)[vessel_node(&v, 2)];
    }
    mineral_keep(&v, f);
    return vessel_end(&v);
}

/* ---- fronts ---- */

/* a (x < 0) and b (x > 0) of A + n B = solid at once: concentrations [mol/m3], diffusivities [m2/s]. */
typedef struct mineral_couple {
    double a, b, da, db, n;
} mineral_couple;

static const mineral_couple mineral_couples[] = {{300.0, 100.0, 1e-9, 1e-9, 1.0},
                                                 {100.0, 100.0, 9.31e-9, 5.27e-9, 1.0},
                                                 {10.0, 100.0, 0.705e-9, 5.27e-9, 2.0}};

#define MINERAL_END 100.0 /* [s] */

static inline double mineral_half(const mineral_couple *c) { return 4.0 * sqrt(fmax(c->da, c->db) * MINERAL_END); }

static inline void mineral_pour(void *user, double x, double *c)
{
    const mineral_couple *of = (const mineral_couple *)user;
    c[0] = x < mineral_half(of) ? of->a : 0.0;
    c[1] = x < mineral_half(of) ? 0.0 : of->b;
}

/* s of x_f = 2 s sqrt(t): n a sqrt(Da) exp(-s^2/Da)/(1 + erf(s/sqrt Da)) = b sqrt(Db) exp(-s^2/Db)/erfc(s/sqrt Db). */
static inline double mineral_front_of(const mineral_couple *c)
{
    double low = -4.0 * sqrt(fmax(c->da, c->db)), high = -low;
    for (int k = 0; k < 200; k++) {
        double s = 0.5 * (low + high);
        double left = c->n * c->a * sqrt(c->da) * exp(-s * s / c->da) / (1.0 + erf(s / sqrt(c->da)));
        if (left > c->b * sqrt(c->db) * exp(-s * s / c->db) / erfc(s / sqrt(c->db))) low = s;
        else high = s;
    }
    return 0.5 * (low + high);
}

/* Where n Da a - Db b, which is smooth across the front, is 0, from where it began; and the solid over the width. */
static inline void mineral_where(vessel *v, const mineral_couple *c, double *where, double *sum)
{
    double before = 0.0;
    *where = *sum = 0.0;
    for (int k = 0; k < v->n; k++) {
        int32_t i = vessel_node(v, k);
        double u = c->n * c->da * vessel_field(v, 0)[i] - c->db * vessel_field(v, 1)[i];
        if (k && before > 0.0 && u <= 0.0)
            *where = vessel_place(v, k) - mineral_half(c) - v->h * (1.0 - before / (before - u));
        before = u;
        *sum += vessel_field(v, 2)[i] * v->h;
    }
}

/* Errors of the place of the front and of the amount of solid at 100 s; steps are a share of the time. */
static inline pd_status mineral_front(pd_ctx *ctx, const mineral_couple *c, int n, double share, int order,
                                      mineral_found *f)
{
    static vessel v;
    mineral_couple of = *c;
    double time = 0.0, s = mineral_front_of(c), pi = 3.14159265358979324, where, sum;
    double flux = 2.0 * c->a * sqrt(c->da / pi) * exp(-s * s / c->da) / (1.0 + erf(s / sqrt(c->da)));
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, n, 2.0 * mineral_half(c) / n, 2.0);
    vessel_species(&v, "Aa", "Na", c->da, 0.0);
    vessel_species(&v, "Bb", "K", c->db, 0.0);
    vessel_mineral(&v, c->n > 1.5 ? "NaK2(s)" : "NaK(s)", 0.0);
    vessel_reaction(&v, c->n > 1.5 ? "NaK2(s) = Aa + 2 Bb" : "NaK(s) = Aa + Bb", -20.0);
    v.desc.order = order;
    vessel_fill(&v);
    vessel_pour(&v, mineral_pour, &of);
    for (double dt = 1e-2; time < MINERAL_END && v.status >= 0; dt = share * time) {
        dt = fmin(dt, MINERAL_END - time);
        mineral_step(&v, dt, f);
        time = MINERAL_END - time - dt < 1e-9 ? MINERAL_END : time + dt;
    }
    if (v.status >= 0) {
        mineral_where(&v, c, &where, &sum);
        f->value = fabs(where / (2.0 * s * sqrt(MINERAL_END)) - 1.0);
        f->product = fabs(sum / (flux * sqrt(MINERAL_END)) - 1.0);
        f->amount = sum;
    }
    mineral_keep(&v, f);
    return vessel_end(&v);
}

/* ---- pores ---- */

#define MINERAL_LENGTH 4e-4 /* [m] */

static inline double mineral_ends(void *user, const double *x)
{
    (void)user;
    return x[0] < 1e-6 || x[0] > MINERAL_LENGTH - 1e-6 ? 1.0 : (double)NAN;
}

/* Pores of eps and tau on the right, where the solid stands [mol/m3]. */
static inline void mineral_half_full(void *user, double x, double *c)
{
    c[0] = 0.0;
    c[1] = x > 0.5 * MINERAL_LENGTH ? *(const double *)user : 0.0;
}

/* A source q everywhere between walls of 0: D1 c'' = -q on the left, D2 c'' = -q with D2 = D1 eps/tau on the right, c
 * and flux the same in the middle. Largest error of c over its largest value. */
static inline pd_status mineral_pores(pd_ctx *ctx, int n, double m, double dt, mineral_found *f)
{
    static vessel v;
    double eps = 0.3, tau = 2.0, d1 = 1e-9, d2 = d1 * eps / tau, q = 1e-3, l = 0.5 * MINERAL_LENGTH, held[2], full;
    double most = 0.0;
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, n, MINERAL_LENGTH / n, m);
    vessel_species(&v, "Aa", "Na", d1, 0.0);
    pd_mineral *of = vessel_mineral(&v, "Na(s)", 0.0);
    of->volume = 1e-4;
    of->rate = 1e-30;
    vessel_reaction(&v, "Na(s) = Aa", 0.0);
    full = (1.0 - eps) / of->volume;
    held[0] = 0.0;
    held[1] = NAN;
    v.desc.wall = held;
    v.desc.held = mineral_ends;
    v.desc.tortuosity = tau;
    vessel_fill(&v);
    vessel_pour(&v, mineral_half_full, &full);
    for (int32_t i = 0; i < v.grid.total && v.status >= 0; i++)
        if (v.grid.kind[i] == PD_FLUID) pd_reactive_source(&v.reactive, 0)[i] = q;
    for (int k = 0; k < 3; k++) mineral_step(&v, dt, f);
    for (int k = 0; k < n && v.status >= 0; k++) {
        double x = vessel_place(&v, k), from = x < l ? x : MINERAL_LENGTH - x, at = x < l ? d1 : d2;
        double exact = q * l * l / (d1 + d2) * from / l + 0.5 * q / at * from * (l - from);
        f->value = fmax(f->value, fabs(vessel_field(&v, 0)[vessel_node(&v, k)] - exact));
        most = fmax(most, exact);
    }
    if (most > 0.0) f->value /= most;
    mineral_keep(&v, f);
    return vessel_end(&v);
}

#endif
