/* plates: two plates of one metal with a gap of its salt and of a salt that stays between them, at rest. Included by
 * validate and by test_levels.
 *
 * M2+ goes from plate to plate, Na+ and Cl- do not pass: c_Na = a exp(-psi), c_Cl = b exp(psi), psi = F phi/(R T), 0 at
 * the anode, and c_M = (c_Cl - c_Na)/2. With the flux N of M2+,
 *   N/D dx = -(dc_M + 2 c_M dpsi),    so    N x/D = 3/2 b (1 - exp(psi)) + 1/2 a (1 - exp(-psi)).
 * What is in the gap gives a and b, psi at the cathode the rest, and the curves of the plates that: i = 2 F N at both.
 */
#ifndef CASES_PLATES_H
#define CASES_PLATES_H
#include <math.h>
#include <string.h>

#define PLATES_FARADAY 96485.33212
#define PLATES_VOLT (8.314462618 * 298.15 / PLATES_FARADAY) /* [V] */

/* Tafel's lines: i0 10^(u/anodic) leaves the anode, i0 10^((step - u)/cathodic) reaches the cathode, or that times c_M
 * on it over `order`. */
typedef struct plates {
    double d, gap;           /* [m2/s] [m] */
    double na, cl;           /* [mol/m3] means */
    double i0;               /* [A/m2] */
    double anodic, cathodic; /* [V] a decade */
    double step;             /* [V] of the cathode over the anode */
    double order;            /* [mol/m3] i0 of the cathode is that at so much M2+ on it; 0: at any */
} plates;

typedef struct plates_state {
    double current;         /* [A/m2] */
    double anode, cathode;  /* [V] of the metals against the mean of phi */
    double drop;            /* [V] of phi from plate to plate */
    double least;           /* [mol/m3] of M2+, at the cathode */
    double a, b;            /* [mol/m3] of Na+ and Cl- at the anode */
} plates_state;

/* What belongs to psi at the cathode, with dx in proportion to 3/2 b exp(psi) - 1/2 a exp(-psi). 0: there is more than
 * the limiting current. */
static inline int plates_at(const plates *p, double psi, plates_state *s)
{
    double end = exp(psi), low = 0.0, high = end * end, whole = 0.0, na = 0.0, cl = 0.0;
    for (int k = 0; k < 200; k++) { /* a/b, which what is in the gap rises with */
        double ratio = k ? 0.5 * (low + high) : high;
        whole = -1.5 * expm1(psi) - 0.5 * ratio * expm1(-psi);
        na = -1.5 * psi - 0.25 * ratio * expm1(-2.0 * psi);
        cl = -0.75 * expm1(2.0 * psi) + 0.5 * ratio * psi;
        int enough = ratio * na > cl * p->na / p->cl;
        if (!k && !enough) return 0;
        if (enough) high = ratio;
        else low = ratio;
    }
    double b = p->cl * whole / cl, a = high * b;
    double mean = (1.5 * (-1.0 - (psi - 1.0) * end) - 0.5 * high * (-1.0 + (psi + 1.0) / end)) / whole;
    s->current = 2.0 * PLATES_FARADAY * p->d / p->gap * b * whole;
    s->drop = -PLATES_VOLT * psi;
    s->least = 0.5 * (b * end - a / end);
    s->a = a;
    s->b = b;
    s->anode = p->anodic * log10(s->current / p->i0) - PLATES_VOLT * mean;
    double share = p->order > 0.0 ? s->least / p->order : 1.0;
    s->cathode = p->step - p->cathodic * log10(s->current / (p->i0 * fmax(share, 1e-300))) + PLATES_VOLT * (psi - mean);
    return 1;
}

/* The psi nearest to 0 up to which `goes` of it is 1; the state of `user` is that of it. */
static inline void plates_bisect(int (*goes)(void *user, double psi), void *user)
{
    double far = -30.0, near = -1e-9;
    for (int k = 0; k < 200; k++) {
        double middle = 0.5 * (far + near);
        if (goes(user, middle)) near = middle;
        else far = middle;
    }
    goes(user, near);
}

typedef struct plates_search {
    const plates *p;
    double current; /* [A/m2] that is given */
    plates_state s;
} plates_search;

static inline int plates_below(void *user, double psi)
{
    plates_search *q = (plates_search *)user;
    return plates_at(q->p, psi, &q->s) && q->s.current < q->current;
}

static inline int plates_apart(void *user, double psi)
{
    plates_search *q = (plates_search *)user;
    return plates_at(q->p, psi, &q->s) && q->s.cathode > q->s.anode;
}

/* With a given current [A/m2]. */
static inline plates_state plates_given(const plates *p, double current)
{
    plates_search q;
    memset(&q, 0, sizeof q);
    q.p = p;
    q.current = current;
    plates_bisect(plates_below, &q);
    return q.s;
}

/* Wired to each other. */
static inline plates_state plates_wired(const plates *p)
{
    plates_search q;
    memset(&q, 0, sizeof q);
    q.p = p;
    plates_bisect(plates_apart, &q);
    return q.s;
}

/* Two metals that exchange their ions, both of two charges: metal 0 at x = 0 dissolves to ion 0 and takes up ion 1,
 * metal 1 the other way round. The sum S of both ions obeys what c_M did above, with the sum of both N/D in the place
 * of N/D, and each ion
 *   (c exp(2 psi))' = -N/D exp(2 psi),    dx = -(3/2 b exp(psi) - 1/2 a exp(-psi)) dpsi / (sum of N/D).
 * Laws: i0 10^((u - from)/slope) dissolves, taken c/order 10^((rest - u)/fall) is taken up. */
typedef struct plates_exchange {
    plates salt;                     /* gap, na and cl of it */
    double d[2];                     /* [m2/s] */
    double i0[2], from[2], slope[2]; /* [A/m2] [V] [V] of metals */
    double taken[2], rest[2], fall[2];
    double order;                    /* [mol/m3] */
} plates_exchange;

typedef struct plates_exchanged {
    double current[2]; /* [A/m2] by which the metals dissolve */
    double potential;  /* [V] of both against the mean of phi */
    double amount[2];  /* [mol/m2] of the ions in the gap */
} plates_exchanged;

/* State for psi at metal 1. Returns what metal 1 takes up of ion 0 beyond what comes [A/m2]; -1e300: there is no such
 * state. Amounts and the mean of psi are by Simpson's rule. */
static inline double plates_exchange_off(const plates_exchange *p, double psi, plates_exchanged *s)
{
    plates salt = p->salt;
    plates_state state;
    double low = -3.0, high = 3.0, v[2] = {0.0, 0.0}, u[2] = {0.0, 0.0}, end = exp(psi), f2 = 2.0 * PLATES_FARADAY;
    salt.d = 1.0;
    salt.i0 = salt.anodic = salt.cathodic = 1.0;
    salt.order = 0.0;
    if (!plates_at(&salt, psi, &state)) return -1e300;
    double sum = state.current / f2; /* [mol/m4] of N/D */
    for (int k = 0; k < 200; k++) {
        u[0] = 0.5 * (low + high);
        u[1] = u[0] - PLATES_VOLT * psi;
        for (int m = 0; m < 2; m++) v[m] = p->i0[m] * pow(10.0, (u[m] - p->from[m]) / p->slope[m]) / f2;
        if (v[0] / p->d[0] - v[1] / p->d[1] > sum) high = u[0];
        else low = u[0];
    }
    double a = state.a, b = state.b;
    double other = v[1] * f2 * p->order / (p->taken[0] * pow(10.0, (p->rest[0] - u[0]) / p->fall[0])); /* ion 1 at 0 */
    double first = 0.5 * (b - a) - other, share = v[0] / p->d[0] / sum;
    double last = (first + share * (0.5 * b * (end * end * end - 1.0) - 0.5 * a * (end - 1.0))) / (end * end);
    s->potential = u[0];
    for (int m = 0; m < 2; m++) s->current[m] = v[m] * f2;
    double mean = 0.0;
    s->amount[0] = s->amount[1] = 0.0;
    for (int k = 0; k <= 2000; k++) {
        double at = psi * k / 2000.0, e = exp(at), weight = k % 2000 == 0 ? 1.0 : k % 2 ? 4.0 : 2.0;
        double dx = -(1.5 * b * e - 0.5 * a / e) / sum * weight * psi / 6000.0;
        double c = (first + share * (0.5 * b * (e * e * e - 1.0) - 0.5 * a * (e - 1.0))) / (e * e);
        s->amount[0] += c * dx;
        s->amount[1] += (0.5 * (b * e - a / e) - c) * dx;
        mean += at * dx / p->salt.gap;
    }
    s->potential -= PLATES_VOLT * mean;
    if (!(first > 0.0)) return -1e300;
    return p->taken[1] * last / p->order * pow(10.0, (p->rest[1] - u[1]) / p->fall[1]) - s->current[0];
}

typedef struct plates_exchange_search {
    const plates_exchange *p;
    plates_exchanged s;
} plates_exchange_search;

static inline int plates_exchange_apart(void *user, double psi)
{
    plates_exchange_search *q = (plates_exchange_search *)user;
    return plates_exchange_off(q->p, psi, &q->s) > 0.0;
}

static inline plates_exchanged plates_exchange_at(const plates_exchange *p)
{
    plates_exchange_search q;
    memset(&q, 0, sizeof q);
    q.p = p;
    plates_bisect(plates_exchange_apart, &q);
    return q.s;
}
#endif
