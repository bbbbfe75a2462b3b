/* pit: 304 steel that dissolves at a held potential in a pit, by the constants of Chadwick et al. 2018, computed apart:
 * by a quadrature, without a lattice. Included by validate and by test_pit.
 *
 * Metal M gives a share of M2+ and one of M3+, so that 2.2022 electrons stay behind. Na+ and Cl- of the bath do not pass
 * its surface: c_Na = b exp(-psi), c_Cl = b exp(psi), psi = F phi/(R T). Steady, with the flux N of the metal over the
 * way L to the bath (a plane; R ln(Ro/R) beside a cylinder), and S = sum z^2 c:
 *   dc2/dpsi = -2 c2 + p2 S/n,  dc3/dpsi = -3 c3 + p3 S/n,  d(N L/D)/dpsi = S/n.
 * The law gives N for the potential at the metal, up to where a salt film keeps the metal at its saturation.
 */
#ifndef CASES_PIT_H
#define CASES_PIT_H
#include <math.h>

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
#endif
