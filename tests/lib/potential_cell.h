/* cell: metals, curves and circuits around the electrolyte of a test, beside the objects of the fixture.
 *
 *   scene_box(&S, ...); S.grid_desc...           the grid
 *   begin(kappa);                                no electrode, no circuit
 *   electrode(0, &term, 1, 0.0); circuit(0, PD_CIRCUIT_CURRENT, 0.0);
 *   if (!ready(which) || !solve()) return;       which: electrode of metal at a place
 *   done();
 */
#ifndef POTENTIAL_CELL_H
#define POTENTIAL_CELL_H
#include "fixture.h"
#include "core/vec.h"
#include "potential/distribution.h"

#define PI 3.14159265358979323846
#define CELLS 300000
#define ELECTRODES 4

/* Objects of a test beside those of the fixture. */
static scene S;
static struct cell {
    pd_electrode e[ELECTRODES];
    pd_circuit circuit[ELECTRODES];
    int member[ELECTRODES];
    uint8_t metal[CELLS];
    double field[CELLS];
    pd_potential_desc desc;
    pd_potential p;
    pd_potential_result r;
    pd_status status;
} X;

static inline pd_electrode_term linear(double resistance, double equilibrium)
{
    pd_electrode_term t;
    memset(&t, 0, sizeof t);
    t.kind = PD_ELECTRODE_LINEAR;
    t.resistance = resistance;
    t.equilibrium = equilibrium;
    return t;
}

static inline pd_electrode_term tafel(double exchange, double equilibrium, double anodic, double cathodic)
{
    pd_electrode_term t;
    memset(&t, 0, sizeof t);
    t.exchange = exchange;
    t.equilibrium = equilibrium;
    t.anodic = anodic;
    t.cathodic = cathodic;
    return t;
}

static inline void electrode(int e, const pd_electrode_term *term, int count, double film)
{
    pd_electrode_desc d;
    memset(&d, 0, sizeof d);
    d.term = term;
    d.count = count;
    d.film = film;
    CHECK_OK(&S.ctx, pd_electrode_build(&S.ctx, &d, &X.e[e]));
    X.desc.electrodes = e + 1;
}

static inline void circuit(int n, pd_circuit_control control, double value)
{
    X.circuit[n].control = control;
    X.circuit[n].value = value;
    X.desc.circuits = n + 1;
}

/* After scene_box: nothing of the cell is set. */
static inline void begin(double kappa)
{
    memset(&X.desc, 0, sizeof X.desc);
    memset(X.e, 0, sizeof X.e);
    for (int e = 0; e < ELECTRODES; e++) X.member[e] = e;
    X.desc.conductivity = kappa;
    X.desc.electrode = X.e;
    X.desc.circuit = X.circuit;
    X.desc.member = X.member;
    X.desc.metal = X.metal;
}

static inline void solid(int shape) { S.grid_desc.solid = &S.shapes[shape]; }

/* Which electrode metal at x is. */
typedef int (*which_fn)(const double *x);

static inline int ready(which_fn which)
{
    if (!scene_build(&S)) return 0;
    CHECK_LE(S.grid.total, CELLS);
    for (int32_t i = 0; i < S.grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&S.grid, i, x);
        X.metal[i] = (uint8_t)(which ? which(x) : 0);
    }
    return CHECK_OK(&S.ctx, pd_potential_build(&S.ctx, &S.grid, &S.bonds, &X.desc, &X.p));
}

static inline int solve(void)
{
    X.status = pd_potential_solve(&S.ctx, &X.p, &X.r);
    CHECK_LE(X.r.imbalance, 1e-10);
    return CHECK_OK(&S.ctx, X.status) && CHECK_INT(X.status, PD_OK);
}

static inline void done(void)
{
    for (int twice = 0; twice < 2; twice++) {
        pd_potential_free(&S.ctx, &X.p);
        for (int e = 0; e < ELECTRODES; e++) pd_electrode_free(&S.ctx, &X.e[e]);
    }
    scene_free(&S);
}

/* ---- two plates ---- */

static double plate_lo, plate_hi; /* [m] surfaces */
static inline int is_right(const double *x) { return x[0] > 0.5 * (plate_lo + plate_hi); }

/* Metal up to x = lo and from x = hi on, `cells` in all, mirrors across. */
static inline void plates(double m, double h, int cells, double lo, double hi)
{
    scene_box(&S, m, h, cells, 4, 4);
    for (int d = 0; d < PD_DIM; d++) {
        S.shapes[0].a[d] = S.shapes[1].a[d] = d ? 0.0 : lo * h;
        S.shapes[1].a[d] = d ? 0.0 : hi * h;
        S.shapes[0].b[d] = d ? 0.0 : 1.0;
        S.shapes[1].b[d] = d ? 0.0 : -1.0;
    }
    S.shapes[0].type = S.shapes[1].type = PD_SHAPE_HALF_SPACE;
    S.shapes[2].type = PD_SHAPE_UNION;
    S.shapes[2].child_count = 2;
    S.shapes[2].child[1] = 1;
    for (int s = 2; s < 2 * PD_DIM; s++) S.grid_desc.side[s] = s < 4 ? PD_SIDE_MIRROR : PD_SIDE_PERIODIC;
    solid(2);
    plate_lo = lo * h;
    plate_hi = hi * h;
}

static inline double plate_area(void)
{
    double area = 1.0;
    for (int d = 1; d < PD_DIM; d++) area *= S.grid.hi[d] - S.grid.lo[d];
    return area;
}

#endif
