/* salts: ions in the potential that keeps them neutral, against closed forms (theory: 8.7): a salt that diffuses, a
 * metal that enters a salt, salts side by side. For validation cases and tests. Include vessel.h before. */
#ifndef CASES_SALTS_H
#define CASES_SALTS_H

#define SALT_VOLT (8.314462618 * 298.15 / 96485.33212) /* [V] of kT/e at 25 C */

typedef struct salt {
    const char *plus, *minus;
    double zp, zm, dp, dm; /* [-], [m2/s] */
    double ambipolar, share, enhancement; /* [m2/s] D, [-] t+ and 1 - z+/z- of the table */
} salt;

/* Diffusivities of phreeqc.dat (ion_diffusivities.csv), and what ambipolar.csv says of them. */
static const salt salt_table[] = {
    {"Na+", "Cl-", 1.0, -1.0, 1.33e-9, 2.033e-9, 1.608e-9, 0.39548, 2.0},
    {"K+", "Cl-", 1.0, -1.0, 1.96e-9, 2.033e-9, 1.9958e-9, 0.49086, 2.0},
    {"H+", "Cl-", 1.0, -1.0, 9.31e-9, 2.033e-9, 3.3373e-9, 0.82077, 2.0},
    {"Mg2+", "Cl-", 2.0, -1.0, 0.705e-9, 2.033e-9, 1.2489e-9, 0.40953, 3.0},
    {"Mg2+", "OH-", 2.0, -1.0, 0.705e-9, 5.27e-9, 1.6686e-9, 0.21108, 3.0},
    {"Al3+", "Cl-", 3.0, -1.0, 0.559e-9, 2.033e-9, 1.2253e-9, 0.45202, 4.0},
    {"Mg2+", "SO4-2", 2.0, -2.0, 0.705e-9, 1.07e-9, 8.4997e-10, 0.39718, 2.0}};
enum { SALTS = (int)(sizeof salt_table / sizeof salt_table[0]) };

static inline double salt_ambipolar(const salt *a)
{
    return a->dp * a->dm * (a->zp - a->zm) / (a->zp * a->dp - a->zm * a->dm);
}

/* What a case found, over its closed form. */
typedef struct salt_found {
    double d, share;           /* [m2/s], [-] of the cation in a current, from the potential between two salts */
    double c, psi;             /* [-] largest errors of c and of psi over their values at the metal */
    double enhancement, volts; /* [-] N L/(D cs), [V] of the metal above the bath */
    double neutral, imbalance, least, current;
    int newton, krylov;
} salt_found;

static inline void salt_keep(vessel *v, salt_found *f)
{
    if (v->status < 0) return;
    f->imbalance = vessel_imbalance(v);
    f->neutral = pd_reactive_neutrality(&v->reactive);
    f->least = vessel_least(v);
    f->newton = v->result.newton;
    f->krylov = v->result.krylov;
}

/* ---- a binary salt ---- */

#define SALT_LENGTH 1e-3 /* [m] */

static inline void salt_pour(void *user, double x, double *c)
{
    const salt *a = (const salt *)user;
    c[0] = 100.0 + 50.0 * cos(3.14159265358979324 * x / SALT_LENGTH);
    c[1] = -a->zp / a->zm * c[0];
}

static inline double salt_wave_of(vessel *v)
{
    double sum = 0.0;
    for (int k = 0; k < v->n; k++)
        sum += vessel_field(v, 0)[vessel_node(v, k)] * cos(3.14159265358979324 * vessel_place(v, k) / SALT_LENGTH);
    return sum;
}

/* A wave of salt between closed ends decays for one of its times: D from its decay, t+ from phi between the ends,
 * (t+/z+ + t-/z-) kT/e ln of the concentrations there. */
static inline pd_status salt_wave(pd_ctx *ctx, const salt *a, int n, double m, int steps, pd_side side, salt_found *f)
{
    static vessel v;
    salt of = *a;
    double pi = 3.14159265358979324, end = SALT_LENGTH * SALT_LENGTH / (pi * pi * salt_ambipolar(a)), first = 1.0;
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, n, SALT_LENGTH / n, m);
    v.side = side;
    vessel_species(&v, a->plus, NULL, a->dp, 100.0);
    vessel_species(&v, a->minus, NULL, a->dm, -a->zp / a->zm * 100.0);
    v.desc.migration = 1;
    v.desc.order = 2;
    vessel_fill(&v);
    vessel_pour(&v, salt_pour, &of);
    if (v.status >= 0) first = salt_wave_of(&v);
    for (int k = 0; k < steps; k++) vessel_step(&v, end / steps);
    if (v.status >= 0) {
        int32_t left = vessel_node(&v, 0), right = vessel_node(&v, n - 1);
        double rise = pd_reactive_potential(&v.reactive, right) - pd_reactive_potential(&v.reactive, left);
        double mean = -rise / (SALT_VOLT * log(vessel_field(&v, 0)[right] / vessel_field(&v, 0)[left]));
        f->d = -log(salt_wave_of(&v) / first) * salt_ambipolar(a);
        f->share = (mean - 1.0 / a->zm) / (1.0 / a->zp - 1.0 / a->zm);
    }
    salt_keep(&v, f);
    return vessel_end(&v);
}

/* ---- a metal that enters a salt ---- */

#define SALT_GAP 1e-4 /* [m] from the metal to the bath */

static inline double salt_bath(void *user, const double *x)
{
    (void)user;
    return x[0] > SALT_GAP - 1e-9 ? 1.0 : (double)NAN;
}

/* Its ions of charge z leave with N, salt of cb stays: N (L - x)/(D cb) for y = exp(psi), and cs = cb (y - 1/y)/z. */
static inline double salt_supported(int z, double y)
{
    return z == 1 ? 2.0 * (y - 1.0) : 1.5 * (y - 1.0) - 0.5 * (1.0 - 1.0 / y);
}

static inline double salt_surface(int z, double ratio)
{
    return 0.5 * z / ratio + sqrt(0.25 * z * z / (ratio * ratio) + 1.0); /* y */
}

static inline double salt_y(int z, double flow, double high)
{
    double low = 1.0;
    for (int k = 0; k < 200; k++) {
        double y = 0.5 * (low + high);
        if (salt_supported(z, y) < flow) low = y;
        else high = y;
    }
    return low;
}

/* Steady: two steps of 1e12 s. ratio: cb/cs. */
static inline pd_status salt_dissolution(pd_ctx *ctx, int z, double ratio, int n, double m, salt_found *f)
{
    static vessel v;
    double cs = 100.0, cb = ratio * cs, d = 0.705e-9, y0 = salt_surface(z, ratio), flow = salt_supported(z, y0);
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, n, SALT_GAP / n, m);
    vessel_species(&v, z == 1 ? "Ag+" : "Mg2+", NULL, d, 0.0);
    vessel_species(&v, "Na+", NULL, 1.33e-9, cb);
    vessel_species(&v, "Cl-", NULL, 2.033e-9, cb);
    v.desc.migration = 1;
    v.desc.wall = v.initial;
    v.desc.held = salt_bath;
    vessel_fill(&v);
    vessel_enter(&v, 0, flow * cb * d / SALT_GAP);
    for (int k = 0; k < 2; k++) vessel_step(&v, 1e12);
    for (int k = n - 1; k >= 0 && v.status >= 0; k--) {
        double y = salt_y(z, flow * (1.0 - vessel_place(&v, k) / SALT_GAP), 2.0 * y0), exact = cb * (y - 1.0 / y) / z;
        double c = vessel_field(&v, 0)[vessel_node(&v, k)];
        double psi = pd_reactive_potential(&v.reactive, vessel_node(&v, k)) / SALT_VOLT;
        f->c = fmax(f->c, fabs(c - exact) / cs);
        f->psi = fmax(f->psi, fabs(psi - log(y)) / log(y0));
        f->enhancement = flow * cb / (cs + c - exact); /* half a cell away from the metal; the last one stays */
        f->volts = (psi + log(y0) - log(y)) * SALT_VOLT;
    }
    salt_keep(&v, f);
    return vessel_end(&v);
}

/* The metal enters its own salt, whose anion stays: c is linear, and N L/D is (1 - z+/z-) times the difference. */
static inline pd_status salt_blocked(pd_ctx *ctx, int z, int n, double m, salt_found *f)
{
    static vessel v;
    static const char *const names[3] = {"Ag+", "Mg2+", "Al3+"};
    double cs = 100.0, cb = 10.0, d = 0.6e-9, flow = (1.0 + z) * (cs - cb);
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, n, SALT_GAP / n, m);
    vessel_species(&v, names[z - 1], NULL, d, cb);
    vessel_species(&v, "Cl-", NULL, 2.033e-9, cb * z);
    v.desc.migration = 1;
    v.desc.wall = v.initial;
    v.desc.held = salt_bath;
    vessel_fill(&v);
    vessel_enter(&v, 0, flow * d / SALT_GAP);
    vessel_step(&v, 1e12);
    for (int k = n - 1; k >= 0 && v.status >= 0; k--) {
        double exact = cb + (cs - cb) * (1.0 - vessel_place(&v, k) / SALT_GAP);
        double c = vessel_field(&v, 0)[vessel_node(&v, k)], psi = log(exact / cb);
        double found = pd_reactive_potential(&v.reactive, vessel_node(&v, k)) / SALT_VOLT;
        f->c = fmax(f->c, fabs(c - exact) / cs);
        f->psi = fmax(f->psi, fabs(found - psi) / log(cs / cb));
        f->enhancement = flow / (cs - cb + c - exact);
    }
    salt_keep(&v, f);
    return vessel_end(&v);
}

/* ---- salts side by side ---- */

#define SALT_KEPT_LENGTH 1e-3 /* [m] */

/* Water with its ions, MgCl2 on the left and NaCl on the right, in both a share of the other. */
static inline void salt_beside(void *user, double x, double *c)
{
    const double *of = (const double *)user; /* high, low */
    int left = x < 0.5 * SALT_KEPT_LENGTH;
    c[3] = left ? of[0] : of[1];
    c[4] = left ? of[1] : of[0];
    c[5] = 2.0 * c[3] + c[4];
}

/* One step of any length. current: what the charge of a node changes by, over what its ions bring. */
static inline pd_status salt_mix(pd_ctx *ctx, double high, double low, int n, double m, double dt, salt_found *f)
{
    static vessel v;
    static const char *const names[] = {"H2O", "H+", "OH-", "Mg2+", "Na+", "Cl-"};
    static const double d[] = {0.0, 9.31e-9, 5.27e-9, 0.705e-9, 1.33e-9, 2.033e-9};
    static const double z[] = {0.0, 1.0, -1.0, 2.0, 1.0, -1.0}, initial[] = {55344.0, 1e-4, 1e-4, 0.0, 0.0, 0.0};
    double of[2], before[6][1024], most = 0.0;
    of[0] = high;
    of[1] = low;
    memset(f, 0, sizeof *f);
    vessel_begin(ctx, &v, n, SALT_KEPT_LENGTH / n, m);
    for (int s = 0; s < 6; s++) vessel_species(&v, names[s], NULL, d[s], initial[s]);
    vessel_reaction(&v, "H2O = H+ + OH-", -14.0);
    v.desc.migration = 1;
    vessel_fill(&v);
    vessel_pour(&v, salt_beside, of);
    for (int k = 0; k < n && v.status >= 0; k++)
        for (int s = 1; s < 6; s++) before[s][k] = vessel_field(&v, s)[vessel_node(&v, k)];
    vessel_step(&v, dt);
    for (int k = 0; k < n && v.status >= 0; k++) {
        double charge = 0.0, moved = 0.0;
        for (int s = 1; s < 6; s++) {
            double change = vessel_field(&v, s)[vessel_node(&v, k)] - before[s][k];
            charge += z[s] * change;
            moved += fabs(z[s] * change);
        }
        f->current = fmax(f->current, fabs(charge));
        most = fmax(most, moved);
    }
    if (most > 0.0) f->current /= most;
    salt_keep(&v, f);
    return vessel_end(&v);
}

#endif
