/* pit: 304 steel that dissolves at a held potential in a pit, by the constants of Chadwick et al. 2018, computed apart:
 * by a quadrature, and in time on a lattice of its own that grows. Included by validate and by test_pit.
 *
 * Metal M gives a share of M2+ and one of M3+, so that 2.2022 electrons stay behind. Na+ and Cl- of the bath do not
 * pass its surface: c_Na = b exp(-psi), c_Cl = b exp(psi), psi = F phi/(R T). Steady, with the flux N of the
 * metal over the way L to the bath (a plane; R ln(Ro/R) beside a cylinder), and S = sum z^2 c:
 *   dc2/dpsi = -2 c2 + p2 S/n,  dc3/dpsi = -3 c3 + p3 S/n,  d(N L/D)/dpsi = S/n.
 * The law gives N for the potential at the metal, up to where a salt film keeps the metal at its saturation.
 */
#ifndef CASES_PIT_H
#define CASES_PIT_H
#include <math.h>
#include <string.h>

#define PIT_FARADAY 96485.33212
#define PIT_GAS 8.314462618
#define PIT_TEMPERATURE 298.15
#define PIT_BATH 1000.0      /* [mol/m3] NaCl */
#define PIT_SATURATION 5100.0 /* [mol/m3] */
#define PIT_SOLID (1.0 / 6.9241e-6) /* [mol/m3] */
#define PIT_ELECTRONS 2.2022 /* of one of the metal */
#define PIT_THIRD 0.2022     /* share of M3+ */
#define PIT_D 6.8957e-10     /* [m2/s] of the metal's ions */
#define PIT_D_NA 1.332e-9
#define PIT_D_CL 2.032e-9
#define PIT_CURRENT 9.9      /* [A/m2] at PIT_REST */
#define PIT_REST (-0.24)     /* [V] */
#define PIT_HELD (-0.075)    /* [V] of the metal */
#define PIT_BETA 0.35
#define PIT_VOLT (PIT_GAS * PIT_TEMPERATURE / PIT_FARADAY) /* [V] */
#define PIT_POINTS 4000

/* Flux of metal [mol/m2/s] at `e` [V], the potential of the metal less that of the solution. */
static inline double pit_law(double e)
{
    return PIT_CURRENT / (PIT_ELECTRONS * PIT_FARADAY) *
           exp(PIT_ELECTRONS * (1.0 - PIT_BETA) * (e - PIT_REST) / PIT_VOLT);
}

typedef struct pit_state {
    double psi, c2, c3; /* [-] [mol/m3] at the metal */
    double way;         /* [mol/m3] N L/D */
    double flux;        /* [mol/m2/s] N */
    int salt;           /* 1: saturated */
} pit_state;

static inline void pit_slope(double psi, const double *y, double *by)
{
    double s = (4.0 * y[0] + 9.0 * y[1] + 2.0 * PIT_BATH * cosh(psi)) / PIT_ELECTRONS;
    by[0] = -2.0 * y[0] + (1.0 - PIT_THIRD) * s;
    by[1] = -3.0 * y[1] + PIT_THIRD * s;
    by[2] = s;
}

/* What belongs to psi at the metal, by Runge and Kutta. */
static inline void pit_at(double psi, pit_state *state)
{
    double y[3] = {0.0, 0.0, 0.0}, k[4][3], part[3], step = psi / PIT_POINTS;
    static const double share[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    for (int n = 0; n < PIT_POINTS; n++) {
        for (int r = 0; r < 4; r++) {
            for (int j = 0; j < 3; j++) part[j] = y[j] + (r ? share[r] * step * k[r - 1][j] : 0.0);
            pit_slope((n + share[r]) * step, part, k[r]);
        }
        for (int j = 0; j < 3; j++)
            for (int r = 0; r < 4; r++) y[j] += step / 6.0 * weight[r] * k[r][j];
    }
    state->psi = psi;
    state->c2 = y[0];
    state->c3 = y[1];
    state->way = y[2];
}

/* The steady state of metal held at `held` [V] behind a way of L [m]. */
static inline pit_state pit_steady(double held, double length)
{
    pit_state s;
    double low = 0.0, high = 20.0;
    for (int k = 0; k < 100; k++) {
        double psi = 0.5 * (low + high);
        pit_at(psi, &s);
        s.flux = PIT_D * s.way / length;
        s.salt = s.c2 + s.c3 > PIT_SATURATION;
        if (s.salt || s.flux > pit_law(held - psi * PIT_VOLT)) high = psi;
        else low = psi;
    }
    pit_at(high, &s);
    s.flux = PIT_D * s.way / length;
    s.salt = s.flux < (1.0 - 1e-9) * pit_law(held - high * PIT_VOLT);
    return s;
}
/* ---- in time ---- */

/* The pit deepens: finite volumes on a lattice that grows with it, central fluxes, backward Euler. u of a node: M2+,
 * M3+, Na+ [mol/m3] and psi; Cl- makes it neutral. Node PIT_CELLS is the metal's surface. */
enum { PIT_CELLS = 200, PIT_NODES = PIT_CELLS + 1 };

typedef struct pit_march {
    double u[PIT_NODES][4], old[PIT_NODES][4];
    double left[PIT_NODES][4][4], own[PIT_NODES][4][4], right[PIT_NODES][4][4], rest[PIT_NODES][4];
    double depth, last; /* [m] from the bath to the metal, and at the start of the step */
} pit_march;

static const double pit_charges[4] = {2.0, 3.0, 1.0, -1.0}, pit_ds[4] = {PIT_D, PIT_D, PIT_D_NA, PIT_D_CL};
static const double pit_neutral[3] = {2.0, 3.0, 1.0}; /* what one of each brings of Cl- */

static inline double pit_ion(const double *u, int i) { return i < 3 ? u[i] : 2.0 * u[0] + 3.0 * u[1] + u[2]; }

/* Slopes of ion i by the unknowns, from that by its concentration. */
static inline void pit_chain(double *row, int i, double by, double by_psi)
{
    for (int k = 0; k < 3; k++) row[k] += i < 3 ? (i == k ? by : 0.0) : by * pit_neutral[k];
    row[3] += by_psi;
}

/* Adds what passes from a to b, `gap` [m] apart, over a face that moves at `speed`, times `sign`, to row i of node n,
 * with its slopes by a and by b. */
static inline void pit_face(pit_march *m, int n, int i, const double *a, const double *b, double gap, double speed,
                            double sign, double *by_a, double *by_b)
{
    double g = pit_ds[i] / gap, z = pit_charges[i], mean = 0.5 * (pit_ion(a, i) + pit_ion(b, i)), rise = b[3] - a[3];
    m->rest[n][i] += sign * (g * (pit_ion(a, i) - pit_ion(b, i) - z * mean * rise) - speed * mean);
    if (by_a) pit_chain(by_a, i, sign * (g * (1.0 - 0.5 * z * rise) - 0.5 * speed), sign * g * z * mean);
    pit_chain(by_b, i, sign * (g * (-1.0 - 0.5 * z * rise) - 0.5 * speed), -sign * g * z * mean);
}

/* Solve a x = b of four equations with `columns` right-hand sides of four numbers each. */
static inline void pit_four(double a[4][4], double *const *b, int columns)
{
    for (int p = 0; p < 4; p++) {
        int best = p;
        for (int i = p + 1; i < 4; i++)
            if (fabs(a[i][p]) > fabs(a[best][p])) best = i;
        for (int j = 0; j < 4 && best != p; j++) {
            double swap = a[p][j];
            a[p][j] = a[best][j];
            a[best][j] = swap;
        }
        for (int j = 0; j < columns && best != p; j++) {
            double swap = b[j][p];
            b[j][p] = b[j][best];
            b[j][best] = swap;
        }
        for (int i = 0; i < 4; i++) {
            double share = i == p ? 0.0 : a[i][p] / a[p][p];
            for (int j = 0; j < 4 && i != p; j++) a[i][j] -= share * a[p][j];
            for (int j = 0; j < columns; j++) b[j][i] -= share * b[j][p];
        }
    }
    for (int j = 0; j < columns; j++)
        for (int p = 0; p < 4; p++) b[j][p] /= a[p][p];
}

/* The largest relative change of a step of Newton for metal that goes at v [m/s] over dt [s]. */
static inline double pit_newton(pit_march *m, double v, double dt)
{
    static const double bath[4] = {0.0, 0.0, PIT_BATH, 0.0};
    double step = m->depth / PIT_CELLS, before = m->last / PIT_CELLS, most = 0.0;
    static double carry[PIT_NODES][4][4];
    memset(m->left, 0, sizeof m->left);
    memset(m->own, 0, sizeof m->own);
    memset(m->right, 0, sizeof m->right);
    memset(m->rest, 0, sizeof m->rest);
    for (int n = 0; n < PIT_CELLS; n++)
        for (int i = 0; i < 4; i++) {
            double shed = i == 0 ? 1.0 - PIT_THIRD : i == 1 ? PIT_THIRD : 0.0, *own = m->own[n][i];
            double speed = v * n / PIT_CELLS;
            m->rest[n][i] -= (step * pit_ion(m->u[n], i) - before * pit_ion(m->old[n], i)) / dt;
            pit_chain(own, i, -step / dt, 0.0);
            if (n) pit_face(m, n, i, m->u[n - 1], m->u[n], step, speed, 1.0, m->left[n][i], own);
            else pit_face(m, n, i, bath, m->u[0], 0.5 * step, 0.0, 1.0, NULL, own);
            if (n + 1 < PIT_CELLS)
                pit_face(m, n, i, m->u[n], m->u[n + 1], step, v * (n + 1) / PIT_CELLS, -1.0, own, m->right[n][i]);
            else m->rest[n][i] += PIT_SOLID * shed * v;
        }
    for (int i = 0; i < 4; i++) { /* what reaches the surface is what it gives, less what it sweeps over */
        double shed = i == 0 ? 1.0 - PIT_THIRD : i == 1 ? PIT_THIRD : 0.0;
        const double *end = m->u[PIT_CELLS - 1], *surface = m->u[PIT_CELLS];
        pit_face(m, PIT_CELLS, i, end, surface, 0.5 * step, 0.0, 1.0, m->left[PIT_CELLS][i], m->own[PIT_CELLS][i]);
        m->rest[PIT_CELLS][i] += PIT_SOLID * shed * v - v * pit_ion(surface, i);
        pit_chain(m->own[PIT_CELLS][i], i, -v, 0.0);
    }
    for (int n = 0; n < PIT_NODES; n++) { /* block elimination: carry = own^-1 right */
        double *columns[5], turned[4][4];
        for (int i = 0; i < 4 && n; i++)
            for (int k = 0; k < 4; k++) {
                for (int j = 0; j < 4; j++) m->own[n][i][j] -= m->left[n][i][k] * carry[n - 1][k][j];
                m->rest[n][i] -= m->left[n][i][k] * m->rest[n - 1][k];
            }
        for (int j = 0; j < 4; j++) {
            for (int i = 0; i < 4; i++) turned[j][i] = m->right[n][i][j];
            columns[j] = turned[j];
        }
        columns[4] = m->rest[n];
        pit_four(m->own[n], columns, 5);
        for (int j = 0; j < 4; j++)
            for (int i = 0; i < 4; i++) carry[n][i][j] = turned[j][i];
    }
    for (int n = PIT_CELLS; n >= 0; n--)
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4 && n < PIT_CELLS; j++) m->rest[n][i] -= carry[n][i][j] * m->rest[n + 1][j];
            m->u[n][i] -= m->rest[n][i];
            most = fmax(most, fabs(m->rest[n][i]) / (i < 3 ? PIT_BATH : 1.0));
        }
    return most;
}

/* What the law or saturation leaves of v [m/s], over v, after dt with metal that goes at v. */
static inline double pit_lacks(pit_march *m, double held, double v, double dt)
{
    m->depth = m->last + v * dt;
    memcpy(m->u, m->old, sizeof m->u);
    for (int k = 0; k < 40 && pit_newton(m, v, dt) > 1e-11; k++) continue;
    const double *surface = m->u[PIT_CELLS];
    return fmin(log(pit_law(held - surface[3] * PIT_VOLT) / PIT_SOLID / v),
                1.0 - (surface[0] + surface[1]) / PIT_SATURATION);
}

/* Depth [m] of a pit after `time` [s], from `depth`, in `steps` steps that grow; *v [m/s]: its speed at the end. */
static inline double pit_deepen(pit_march *m, double held, double depth, double time, int steps, double *v)
{
    double now = 0.0;
    memset(m, 0, sizeof *m);
    m->depth = depth;
    for (int n = 0; n < PIT_NODES; n++) m->u[n][2] = PIT_BATH;
    *v = 0.1 * pit_law(held) / PIT_SOLID;
    for (int k = 1; k <= steps; k++) {
        double dt = time * pow((double)k / steps, 3.0) - now, next = *v;
        double low = 0.0, high = HUGE_VAL, of_low = 0.0, of_high = 0.0;
        memcpy(m->old, m->u, sizeof m->u);
        m->last = m->depth;
        for (int r = 0; r < 60; r++) {
            double lacks = pit_lacks(m, held, next, dt);
            if (!(lacks == lacks)) lacks = -1.0;
            if (lacks > 0.0) {
                low = next;
                of_low = lacks;
            } else {
                high = next;
                of_high = lacks;
            }
            if (fabs(lacks) < 1e-12 || high - low < 1e-12 * high) break;
            if (!(high < HUGE_VAL)) next = 1.2 * low;
            else if (!(low > 0.0)) next = high / 1.2;
            else next = r % 3 == 2 ? 0.5 * (low + high) : low + (high - low) * of_low / (of_low - of_high);
        }
        *v = next;
        now += dt;
    }
    return m->depth;
}
#endif
