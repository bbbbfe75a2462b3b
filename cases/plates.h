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
    s->anode = p->anodic * log10(s->current / p->i0) - PLATES_VOLT * mean;
    double share = p->order > 0.0 ? s->least / p->order : 1.0;
    s->cathode = p->step - p->cathodic * log10(s->current / (p->i0 * fmax(share, 1e-300))) + PLATES_VOLT * (psi - mean);
    return 1;
}

/* With a given current [A/m2]. */
static inline plates_state plates_given(const plates *p, double current)
{
    plates_state s;
    double far = -30.0, near = -1e-9;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < 200; k++) {
        double middle = 0.5 * (far + near);
        if (plates_at(p, middle, &s) && s.current < current) near = middle;
        else far = middle;
    }
    plates_at(p, near, &s);
    return s;
}

/* Wired to each other. */
static inline plates_state plates_wired(const plates *p)
{
    plates_state s;
    double far = -30.0, near = -1e-9;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < 200; k++) {
        double middle = 0.5 * (far + near);
        if (plates_at(p, middle, &s) && s.cathode > s.anode) near = middle;
        else far = middle;
    }
    plates_at(p, near, &s);
    return s;
}
#endif
