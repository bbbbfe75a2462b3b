/* film: a plate of magnesium and one of aluminium, equal areas, FILM_GAP apart, and the film of Mg(OH)2 that grows on
 * the magnesium. Curves and laws are those of Hoeche 2015: as text for scenes, and computed apart in a solution that
 * mixes at once. Included by validate, and by test_coat, test_coat_ions and test_galvanic.
 *
 * States: theta, the cover; eps, the pores; l [m], the thickness, which ends at 1 mm. They change with the product
 * [Mg2+] [OH-]^2 beyond that of the solid. The current has the root of theta.
 */
#ifndef CASES_FILM_H
#define CASES_FILM_H
#include <math.h>
#include <string.h>

#define FILM_FARADAY 96485.33212
#define FILM_GAP 2e-3 /* [m] */

#define FILM_RANGE "curve = expression  range = -1.8 V .. -1.25 V\n"
#define FILM_MG \
    FILM_RANGE "  i = 0.28 A/m2*(exp(39.31786*0.4*(E + 1.517 V)/(1 V)) - exp(-39.31786*0.32*(E + 1.517 V)/(1 V)))\n"
#define FILM_AL \
    FILM_RANGE "  i = -0.104 A/m2/(0.012 + exp(-2*(E + 0.595 V)/(1 V))) - 0.18 A/m2*10^(-(E + 1.41 V)/(0.118 V))\n"
#define FILM_STATES(of) \
    "[constants] Vm = 2.457627e-5 m3/mol  k = 3.7e-7 m7/mol2/s  q = 7.4e-4 m6/mol2/s  w = 0.45 mol3/m9\n" \
    "[surface theta] of = " of "  initial = 0.1  max = 1\n" \
    "  rate = (1 - theta)/((1 - eps)*l)*k*Vm*max([Mg2+]*[OH-]^2 - w, 0)\n" \
    "[surface eps] of = " of "  initial = 0.55  min = 0  rate = -eps*q*Vm*max([Mg2+]*[OH-]^2 - w, 0)\n" \
    "[surface l] of = " of "  initial = 0.1 um  max = 1 mm  rate = k*Vm*max([Mg2+]*[OH-]^2 - w, 0)/(0.45*theta)\n"

/* Curves [A/m2] of both metals at e [V], positive, and the potential where `share` times one is the other. */
static inline double film_mg(double e)
{
    return 0.28 * (exp(39.31786 * 0.4 * (e + 1.517)) - exp(-39.31786 * 0.32 * (e + 1.517)));
}

static inline double film_al(double e)
{
    double x = exp(2.0 * (e + 0.595));
    return 0.104 * x / (0.012 * x + 1.0) + 0.18 * pow(10.0, -(e + 1.41) / 0.118);
}

static inline double film_potential(double share)
{
    double lo = -1.8, hi = -1.25;
    for (int k = 0; k < 60; k++) {
        double e = 0.5 * (lo + hi);
        if (share * film_mg(e) > film_al(e)) hi = e;
        else lo = e;
    }
    return 0.5 * (lo + hi);
}

/* Rates of theta, eps, l with the concentrations [mol/m3] of Mg2+ and OH- at the surface. */
static inline void film_rates(const double *y, double mg, double oh, double *rate)
{
    double volume = 2.457627e-5, chi = volume * fmax(mg * oh * oh - 0.45, 0.0);
    rate[0] = (1.0 - y[0]) / ((1.0 - y[1]) * y[2]) * 3.7e-7 * chi;
    rate[1] = -y[1] * 7.4e-4 * chi;
    rate[2] = y[2] < 1e-3 ? 3.7e-7 * chi / ((1.0 - 0.55) * y[0]) : 0.0;
}

enum {
    FILM_COVER,
    FILM_PORES,
    FILM_THICKNESS,
    FILM_MG2,    /* [mol/m3] */
    FILM_OH,     /* [mol/m3] */
    FILM_PASSED, /* [C/m2] */
    FILM_COUNT
};

/* y [FILM_COUNT] after t [s] from a new film in a solution with `mg` mol/m3 of Mg(OH)2, by Runge and Kutta's method of
 * order 4. both: the currents of both metals have the root of theta, as published, and the potential stays. */
static inline void film_mixed(double t, int steps, double mg, int both, double *y)
{
    static const double start[FILM_COUNT] = {0.1, 0.55, 1e-7, 0.0, 0.0, 0.0};
    double k[4][FILM_COUNT], at[FILM_COUNT], h = t / steps;
    memcpy(y, start, sizeof start);
    y[FILM_MG2] = mg;
    y[FILM_OH] = 2.0 * mg;
    for (int s = 0; s < steps; s++) {
        for (int j = 0; j < 4; j++) {
            double go = j == 0 ? 0.0 : j == 3 ? h : 0.5 * h;
            for (int m = 0; m < FILM_COUNT; m++) at[m] = y[m] + (j ? go * k[j - 1][m] : 0.0);
            film_rates(at, at[FILM_MG2], at[FILM_OH], k[j]);
            double share = sqrt(at[FILM_COVER]);
            double i = both ? share * film_al(film_potential(1.0)) : film_al(film_potential(share));
            k[j][FILM_MG2] = i / (2.0 * FILM_FARADAY * FILM_GAP);
            k[j][FILM_OH] = i / (FILM_FARADAY * FILM_GAP);
            k[j][FILM_PASSED] = i;
        }
        for (int m = 0; m < FILM_COUNT; m++) y[m] += h / 6.0 * (k[0][m] + 2.0 * k[1][m] + 2.0 * k[2][m] + k[3][m]);
    }
}

#endif
