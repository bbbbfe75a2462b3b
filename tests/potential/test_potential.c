/* potential: metals in front of each other, whose currents have closed forms: given potentials and currents, couples,
 * held sides, several circuits; what starts, lengths and references do not change; refusals.
 * dims: 1 2 3 */
#include "potential/pieces.h"
#include "potential_cell.h"

/* Current density i between two curves and a gap: E0 - u0(i) - i R = E1 - u1(-i), by halves. */
static double gap_current(const pd_electrode *a, const pd_electrode *b, double drop, double resist)
{
    double lo = -1e9, hi = 1e9;
    for (int n = 0; n < 300; n++) {
        double i = 0.5 * (lo + hi), u[2];
        for (int side = 0; side < 2; side++) {
            double from = -1e4, to = 1e4;
            for (int k = 0; k < 200; k++) {
                double at = 0.5 * (from + to);
                if (pd_electrode_current(side ? b : a, at, NULL) < (side ? -i : i)) from = at;
                else to = at;
            }
            u[side] = 0.5 * (from + to);
        }
        if (u[0] + i * resist - u[1] < drop) lo = i;
        else hi = i;
    }
    return 0.5 * (lo + hi);
}

/* A field that is linear is exact for surfaces anywhere, any horizon, any curve, given potentials or currents. */
TEST(plates_anywhere)
{
    static const double lo[4] = {3.0, 3.1, 2.6, 3.3333}, hi[4] = {15.0, 15.2, 14.5, 15.6667};
    for (int m = 1; m < 4; m++)
        for (int k = 0; k < 4; k++)
            for (int given = 0; given < 3; given++) {
                double h = 1e-4, kappa = 1.3;
                pd_electrode_term a[2], b;
                a[0] = tafel(2.0, -0.9, 0.03, 0.0);
                a[1] = linear(2.0, -0.4);
                b = tafel(1.0, -0.3, 0.04, 0.02);
                plates(m, h, 19, lo[k], hi[k]);
                begin(kappa);
                electrode(0, a, 2, 0.0);
                electrode(1, &b, 1, 1e-4);
                circuit(0, given == 1 ? PD_CIRCUIT_POTENTIAL : PD_CIRCUIT_CURRENT, given == 1 ? 0.2 : 0.0);
                if (given == 0) X.member[1] = 0;
                else circuit(1, PD_CIRCUIT_POTENTIAL, -0.1);
                if (!ready(is_right)) return;
                if (given == 2) X.circuit[0].value = -3.0 * plate_area();
                double resist = (hi[k] - lo[k]) * h / kappa + 1e-4;
                double i = given == 2 ? -3.0 : gap_current(&X.e[0], &X.e[1], given == 1 ? 0.3 : 0.0, resist);
                if (!solve()) return;
                CHECK_NEAR(X.p.total[0] / plate_area(), given == 0 ? 0.0 : i, 1e-9 * fabs(i));
                for (int32_t n = 0; n < X.p.contacts.count; n++) {
                    const pd_contact *c = &X.p.contacts.list[n];
                    CHECK_REL(X.p.current[n], c->electrode ? -i : i, 1e-8);
                }
                if (given) CHECK_REL(X.p.total[1] / plate_area(), -i, 1e-9);
                CHECK_LE(X.r.newton, 40);
                done();
            }
}

/* A plate against a side that holds a potential, and through two conductivities that meet halfway between nodes. */
TEST(held_sides_and_layers)
{
    for (int inlet = 0; inlet < 2; inlet++)
        for (int layers = 0; layers < 2; layers++) {
            double h = 2e-3, kappa = 0.7;
            pd_electrode_term a = linear(1e-3, -0.3);
            plates(1.0, h, 20, 4.25, 1000.0);
            S.shapes[2].child_count = 1;
            if (inlet) S.grid_desc.side[1] = PD_SIDE_INLET;
            begin(kappa);
            electrode(0, &a, 1, 0.0);
            circuit(0, PD_CIRCUIT_POTENTIAL, -1.0);
            X.desc.held[1] = 1;
            X.desc.hold[1] = -0.2;
            if (layers) X.desc.field = X.field;
            for (int32_t i = 0; i < CELLS; i++) X.field[i] = kappa;
            plate_hi = plate_lo;
            if (!scene_build(&S)) return;
            for (int32_t i = 0; i < S.grid.total; i++) {
                double x[PD_DIM];
                pd_grid_position(&S.grid, i, x);
                if (x[0] > 12.0 * h) X.field[i] = 3.0 * kappa;
                X.metal[i] = 0;
            }
            if (!CHECK_OK(&S.ctx, pd_potential_build(&S.ctx, &S.grid, &S.bonds, &X.desc, &X.p))) return;
            if (!solve()) return;
            double resist = 1e-3 + (layers ? 7.75 + 8.0 / 3.0 : 15.75) * h / kappa, i = (-1.0 + 0.3 + 0.2) / resist;
            CHECK_REL(X.p.total[0] / plate_area(), i, 1e-10);
            CHECK_REL(X.r.through / plate_area(), -i, 1e-10);
            done();
        }
}

/* kappa is no limit: mixed potentials of two straight Tafel lines and of the Mg/Al couple of Hoeche 2015. */
TEST(mixed_potentials)
{
    double e0 = -1.4, e1 = -0.2, i0 = 1e-3, i1 = 1e-5, a = 0.026, b = 0.05;
    pd_electrode_term t[2];
    plates(1.0, 1e-5, 12, 3.0, 9.0);
    begin(1e7);
    t[0] = tafel(i0, e0, a, 0.0);
    t[1] = tafel(i1, e1, 0.0, b);
    electrode(0, t, 2, 0.0);
    circuit(0, PD_CIRCUIT_CURRENT, 0.0);
    X.desc.metal = NULL;
    if (!ready(NULL) || !solve()) return;
    double u = (log(i1 / i0) + e0 / a + e1 / b) / (1.0 / a + 1.0 / b);
    CHECK_NEAR(X.p.metal[0], u, 1e-12);
    CHECK_NEAR(X.p.total[0] / plate_area(), 0.0, 1e-10 * i0 * exp((u - e0) / a));
    for (int32_t n = 0; n < X.p.contacts.count; n++) CHECK_NEAR(X.p.current[n], 0.0, 1e-9);
    done();

    double v[701], i[701]; /* the cathodic curve has a part that falls far above */
    plates(1.0, 1e-5, 12, 3.0, 9.0);
    begin(1e7);
    t[0] = tafel(0.28, -1.517, 1.0 / (39.31786 * 0.4), 1.0 / (39.31786 * 0.32));
    electrode(0, t, 1, 0.0);
    memset(&t[1], 0, sizeof t[1]);
    for (int k = 0; k < 701; k++) {
        v[k] = -1.9 + 1e-3 * k;
        double e = exp(2.0 * (v[k] + 0.595));
        i[k] = -(0.104 * e / (0.012 * e + 1.0) + 0.18 * pow(10.0, -(v[k] + 1.41) / 0.118));
    }
    t[1].kind = PD_ELECTRODE_TABLE;
    t[1].points = 601;
    t[1].potential = v;
    t[1].current = i;
    electrode(1, &t[1], 1, 0.0);
    X.member[1] = 0;
    circuit(0, PD_CIRCUIT_CURRENT, 0.0);
    if (!ready(is_right) || !solve()) return;
    CHECK_NEAR(X.p.metal[0], -1.462456, 1e-6);
    CHECK_NEAR(X.r.anodic / plate_area(), 0.51928, 1e-5);
    done();
}

/* Cathodes at their limiting current: the plateau carries the current, whatever the overpotential. */
TEST(limiting_currents)
{
    pd_electrode_term t[2];
    plates(1.0, 1e-4, 12, 3.0, 9.0);
    begin(2.0);
    t[0] = tafel(1e-3, -1.4, 0.025, 0.0);
    t[1] = tafel(1e-3, -0.2, 0.0, 0.03);
    t[1].cathodic_limit = 1.7;
    electrode(0, t, 1, 0.0);
    electrode(1, t + 1, 1, 0.0);
    X.member[1] = 0;
    circuit(0, PD_CIRCUIT_CURRENT, 0.0);
    if (!ready(is_right) || !solve()) return;
    CHECK_REL(X.r.anodic / plate_area(), 1.7, 1e-8);
    /* E less phi at the surface of the anode */
    CHECK_NEAR(X.p.surface[0], -1.4 + 0.025 * log(1.7e3), 1e-8);
    done();
}

/* Currents far below 1 A/m2 and 1 A/m3 of a node: metal that can carry them both ways does, whether idle metal is
 * allowed or not, at the current that both curves and the gap give. */
TEST(faint_currents)
{
    for (int idle = 0; idle < 2; idle++) {
        pd_electrode_term a = tafel(1e-9, -0.9, 0.03, 0.0), b = tafel(1e-9, -0.3, 0.0, 0.04);
        a.anodic_limit = 2e-6;
        b.cathodic_limit = 1e-6;
        plates(1.0, 1e-4, 12, 3.0, 9.0);
        begin(2.0);
        X.desc.idle = idle;
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        X.member[1] = 0;
        circuit(0, PD_CIRCUIT_CURRENT, 0.0);
        if (!ready(is_right) || !solve()) return;
        CHECK_INT(X.p.contacts.idle, 0);
        CHECK_REL(X.r.anodic / plate_area(), gap_current(&X.e[0], &X.e[1], 0.0, 6e-4 / 2.0), 1e-8);
        CHECK_LE(0.9e-6, X.r.anodic / plate_area());
        done();
    }
}

/* Starts that are volts off, on either side, in the electrolyte, the metal or both, end at the same potentials. */
TEST(far_starts)
{
    pd_electrode_term a = tafel(1e-4, -1.4, 0.013, 0.02), b = tafel(1e-2, -0.2, 0.011, 0.017);
    double most = 0.0;
    for (int k = 0; k < 10; k++) {
        plates(1.0, k < 5 ? 1e-4 : 1e-7, 12, 3.0, 9.3);
        begin(k < 5 ? 0.5 : 20.0);
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        circuit(0, PD_CIRCUIT_CURRENT, 0.0);
        circuit(1, PD_CIRCUIT_POTENTIAL, 0.0);
        if (k % 5 == 4) circuit(1, PD_CIRCUIT_POTENTIAL, 10.0);
        X.desc.held[0] = 0;
        X.member[1] = 1;
        if (!ready(is_right)) return;
        for (int32_t i = 0; i < S.grid.total; i++) {
            double start[5] = {0.0, 10.0, -10.0, 0.0, 0.0};
            start[3] = i % 7 - 3.0;
            if (S.grid.kind[i] == PD_FLUID) X.p.phi[i] = start[k % 5];
        }
        X.p.metal[0] = k % 5 == 3 ? -10.0 : k % 5 == 2 ? 10.0 : 0.0;
        if (!solve()) return;
        most = fmax(most, X.r.newton);
        double more = k % 5 == 4 ? 10.0 : 0.0;
        CHECK_NEAR(X.p.metal[0], more - 1.2, 1e-10);
        for (int32_t i = 0; i < S.grid.total; i++)
            if (S.grid.kind[i] == PD_FLUID) CHECK_NEAR(X.p.phi[i] - more, 0.2, 1e-9);
        done();
    }
    CHECK_LE(most, 50);
}

/* 10 V between two plates, exponentials all the way: the gap takes what the curves leave. */
TEST(high_voltage)
{
    pd_electrode_term a = tafel(1e-4, -1.4, 0.013, 0.02), b = tafel(1e-2, -0.2, 0.011, 0.017);
    for (int sign = -1; sign < 2; sign += 2) {
        plates(1.0, 1e-4, 12, 3.0, 9.3);
        begin(0.5);
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        circuit(0, PD_CIRCUIT_POTENTIAL, sign * 10.0);
        circuit(1, PD_CIRCUIT_POTENTIAL, 0.0);
        if (!ready(is_right) || !solve()) return;
        CHECK_REL(X.p.total[0] / plate_area(), gap_current(&X.e[0], &X.e[1], sign * 10.0, 6.3e-4 / 0.5), 1e-9);
        CHECK_LE(X.r.newton, 40);
        done();
    }
}

/* Lengths from nanometres to kilometres with the same Wagner number give the same figures. */
TEST(scales)
{
    double first = 0.0;
    for (int k = 0; k < 4; k++) {
        double h = pow(10.0, -9.0 + 4.0 * k), kappa = 2.0;
        pd_electrode_term a = linear(3.0 * h / kappa, -0.3), b = linear(5.0 * h / kappa, 0.2);
        plates(2.0, h, 18, 3.1, 12.2);
        begin(kappa);
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        X.member[1] = 0;
        circuit(0, PD_CIRCUIT_CURRENT, 0.0);
        if (!ready(is_right) || !solve()) return;
        CHECK_REL(X.r.anodic / plate_area(), 0.5 * kappa / (17.1 * h), 1e-9);
        if (k == 0) first = X.p.metal[0];
        CHECK_NEAR(X.p.metal[0], first, 1e-10);
        done();
    }
}

/* A constant on all potentials changes none of the currents, and adds to all potentials. */
TEST(any_reference)
{
    double current[2] = {0.0, 0.0}, metal[2] = {0.0, 0.0};
    for (int k = 0; k < 2; k++) {
        double add = 7.0 * k;
        pd_electrode_term a = tafel(1.0, -0.9 + add, 0.03, 0.05), b = tafel(2.0, -0.1 + add, 0.02, 0.06);
        plates(1.0, 1e-4, 12, 3.0, 1000.0);
        S.shapes[2].child_count = 1;
        begin(0.5);
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        circuit(0, PD_CIRCUIT_POTENTIAL, -0.2);
        X.member[1] = 0;
        X.desc.held[1] = 1;
        X.desc.hold[1] = 0.3 - add;
        if (!ready(NULL) || !solve()) return;
        current[k] = X.p.total[0];
        metal[k] = X.p.phi[X.p.contacts.list[0].node];
        done();
    }
    CHECK_REL(current[1], current[0], 1e-11);
    CHECK_NEAR(metal[1], metal[0] - 7.0, 1e-11);
}

/* With all signs turned round, of potentials and of currents, everything is the same but for signs, in the same
 * iterations: those of a potential far from zero, too, whose rounding decides what is solved. */
TEST(other_polarity)
{
    for (int k = 0; k < 6; k++) {
        static double phi[2][CELLS];
        double far = 40.0 * (k % 3 - 1), current[2] = {0.0, 0.0}, anodic[2] = {0.0, 0.0}, level[2] = {0.0, 0.0};
        int newton[2] = {0, 0}, krylov[2] = {0, 0};
        int32_t total = 0;
        for (int other = 0; other < 2; other++) {
            double sign = other ? -1.0 : 1.0;
            pd_electrode_term a = other ? tafel(1.0, 0.9 - far, 0.05, 0.03) : tafel(1.0, -0.9 + far, 0.03, 0.05);
            pd_electrode_term b = other ? tafel(2.0, 0.1 - far, 0.06, 0.02) : tafel(2.0, -0.1 + far, 0.02, 0.06);
            if (k >= 3) a = b = linear(1e-5, 0.0);
            plates(1.0, 1e-4, 12, 3.0, 9.0);
            begin(0.5);
            electrode(0, &a, 1, 0.0);
            electrode(1, &b, 1, 1e-5);
            X.member[1] = k < 3 ? 0 : 1;
            circuit(0, k < 3 ? PD_CIRCUIT_CURRENT : PD_CIRCUIT_POTENTIAL, k < 3 ? 0.0 : sign * 1e3 * far);
            if (k >= 3) circuit(1, PD_CIRCUIT_POTENTIAL, 0.0);
            X.desc.tolerance = 1e-16;
            if (!ready(is_right) || !solve()) return;
            total = S.grid.total;
            for (int32_t i = 0; i < total; i++) phi[other][i] = sign * X.p.phi[i];
            current[other] = sign * X.p.total[0];
            level[other] = sign * X.p.metal[0];
            anodic[other] = X.r.anodic;
            newton[other] = X.r.newton;
            krylov[other] = X.r.krylov;
            done();
        }
        double off = 0.0;
        for (int32_t i = 0; i < total; i++) off = fmax(off, fabs(phi[1][i] - phi[0][i]));
        CHECK_NEAR(off, 0.0, 0.0);
        CHECK_NEAR(level[1], level[0], 0.0);
        CHECK_NEAR(current[1], current[0], 0.0);
        CHECK_REL(anodic[1], anodic[0], 1e-12); /* the currents that enter metal, in the other run */
        CHECK_INT(newton[1], newton[0]);
        CHECK_INT(krylov[1], krylov[0]);
    }
}

/* Metal recedes: cells turn fluid, and those behind them have lost a part. The gap is what is left, exactly. */
TEST(receding)
{
    static double left[CELLS];
    static int32_t turned[64];
    double h = 1e-4, kappa = 1.3;
    for (int m = 1; m < 3; m++) {
        pd_electrode_term a = linear(1e-4, -0.4), b = linear(2e-4, 0.3);
        int count = 0;
        plates(m, h, 19, 6.0, 14.0);
        begin(kappa);
        electrode(0, &a, 1, 0.0);
        electrode(1, &b, 1, 0.0);
        X.member[1] = 0;
        circuit(0, PD_CIRCUIT_CURRENT, 0.0);
        for (int32_t i = 0; i < CELLS; i++) left[i] = 0.8;
        X.desc.left = left;
        if (!ready(is_right) || !solve()) return;
        CHECK_REL(X.r.anodic / plate_area(), 0.7 / (3e-4 + 8.4 * h / kappa), 1e-9);
        for (int32_t i = 0; i < S.grid.total; i++) {
            double x[PD_DIM];
            int at[PD_DIM];
            pd_grid_position(&S.grid, i, x);
            pd_grid_index(&S.grid, i, at);
            if (at[0] == 5 && pd_grid_is_inside(&S.grid, at)) turned[count++] = i;
            if (is_right(x)) left[i] = 1.0;
        }
        for (int k = 0; k < count; k++) pdi_grid_set_fluid(&S.grid, turned[k]);
        CHECK_OK(&S.ctx, pd_bonds_update(&S.ctx, turned, count, &S.bonds));
        if (!CHECK_OK(&S.ctx, pd_potential_update(&S.ctx, &X.p)) || !solve()) return;
        CHECK_REL(X.r.anodic / plate_area(), 0.7 / (3e-4 + 9.2 * h / kappa), 1e-9);
        done();
    }
}

/* ---- refusals ---- */

static void refuse(pd_status status, const char *says)
{
    pd_status got;
    if (!scene_build(&S)) return;
    for (int32_t i = 0; i < S.grid.total; i++) {
        double x[PD_DIM];
        pd_grid_position(&S.grid, i, x);
        X.metal[i] = (uint8_t)is_right(x);
    }
    got = pd_potential_build(&S.ctx, &S.grid, &S.bonds, &X.desc, &X.p);
    if (got >= 0) got = pd_potential_solve(&S.ctx, &X.p, &X.r);
    CHECK_INT(got, status);
    if (!CHECK(strstr(S.ctx.message, says) != NULL)) NOTE("%s", S.ctx.message);
    done();
}

static void two(const pd_electrode_term *a, const pd_electrode_term *b, double kappa)
{
    plates(1.0, 1e-4, 12, 3.0, 9.0);
    begin(kappa);
    electrode(0, a, 1, 0.0);
    electrode(1, b, 1, 0.0);
    circuit(0, PD_CIRCUIT_CURRENT, 0.0);
    circuit(1, PD_CIRCUIT_CURRENT, 0.0);
}

TEST(refusals)
{
    pd_electrode_term a = tafel(1.0, -0.9, 0.03, 0.05), b = a, only = tafel(1.0, -0.9, 0.03, 0.0);
    two(&a, &b, 1.0);
    X.circuit[0].value = 1e-9;
    refuse(PD_ERR_STATE, "add up to 1e-09 A");
    two(&only, &only, 1.0);
    refuse(PD_ERR_STATE, "expected a cathodic reaction");
    only = tafel(1.0, -0.9, 0.0, 0.03);
    two(&only, &only, 1.0);
    refuse(PD_ERR_STATE, "expected an anodic reaction");
    b.anodic_limit = 1.0;
    two(&a, &b, 1.0);
    X.circuit[1].value = 1e3;
    X.circuit[0].value = -1e3;
    refuse(PD_ERR_STATE, "electrode 1 is to give 1000 A");
    two(&a, &a, 0.0);
    refuse(PD_ERR_ARGUMENT, "conductivity 0");
    two(&a, &a, 1.0);
    X.member[1] = 2;
    refuse(PD_ERR_ARGUMENT, "electrode 1 is in circuit 2 of 2");
    two(&a, &a, 1.0);
    X.desc.electrodes = 1;
    refuse(PD_ERR_ARGUMENT, "is electrode 1 of 1");
    two(&a, &a, 1.0);
    X.circuit[0].value = (double)NAN;
    refuse(PD_ERR_ARGUMENT, "electrode 0: the given current is nan");
#if PD_DIM > 1
    two(&a, &a, 1.0);
    X.desc.held[2] = 1;
    refuse(PD_ERR_ARGUMENT, "side 2 cannot hold");
#endif
    two(&a, &a, 1.0);
    for (int32_t i = 0; i < CELLS; i++) X.field[i] = -1.0;
    X.desc.field = X.field;
    refuse(PD_ERR_ARGUMENT, "conductivity -1");
    two(&a, &a, 1.0);
    X.desc.electrodes = 0;
    refuse(PD_ERR_ARGUMENT, "0 electrodes and 2 circuits, expected 1 to");
    two(&a, &a, 1.0);
    X.desc.held[0] = 1;
    X.desc.hold[0] = -2e6;
    refuse(PD_ERR_ARGUMENT, "side 0 holds -2e+06 V, expected between -1e6 and 1e6");
    static pd_stencil wide;
    two(&a, &a, 1.0);
    wide.reach = 50;
    X.desc.wide = &wide;
    refuse(PD_ERR_ARGUMENT, "the wide family reaches over 50 cells, the grid has");
    /* a drop of 1 kA/m2 at 1 GOhm m2 or so */
    pd_electrode_term shut = linear(1e9, 0.0);
    two(&shut, &shut, 1.0);
    X.circuit[0].value = 1e3;
    X.circuit[1].value = -1e3;
    refuse(PD_ERR_STATE, "leaves every bound: there is no solution");
}

#if PD_DIM > 1
/* ---- several pieces ---- */

static int by_thirds(const double *x) { return (int)(3.0 * x[0]); }

#if PD_DIM == 2
/* Two metals that touch, a particle, and one that periodic sides cut in two: three pieces, four electrodes. */
TEST(pieces)
{
    static const double from[4][2] = {{2, 3}, {5, 3}, {9, 9}, {0, 5}}, to[4][2] = {{5, 6}, {7, 5}, {11, 12}, {1, 7}};
    static uint8_t material[CELLS], electrode[CELLS];
    pd_pieces p;
    scene_box(&S, 1.0, 1.0, 16, 14, 1);
    S.grid_desc.side[0] = S.grid_desc.side[1] = PD_SIDE_PERIODIC;
    static pd_shape shapes[6];
    memset(shapes, 0, sizeof shapes);
    for (int k = 0; k < 4; k++) {
        scene_solid_box(&shapes[k], from[k], to[k]);
        shapes[5].child[k] = k;
    }
    double far[2] = {14.0, 5.0}, end[2] = {16.0, 7.0};
    scene_solid_box(&shapes[4], far, end);
    shapes[5].type = PD_SHAPE_UNION;
    shapes[5].child_count = 5;
    shapes[5].child[4] = 4;
    S.grid_desc.shapes = shapes;
    S.grid_desc.solid = &shapes[5];
    if (!scene_grid(&S)) return;
    for (int32_t i = 0; i < S.grid.total; i++) {
        double x[2];
        pd_grid_position(&S.grid, i, x);
        material[i] = x[0] > 5.0 && x[0] < 8.0 ? 3 : 1;
    }
    CHECK_OK(&S.ctx, pd_pieces_find(&S.ctx, &S.grid, material, electrode, &p));
    CHECK_INT(p.circuits, 3);
    CHECK_INT(p.electrodes, 4);
    int at[5][2] = {{2, 3}, {6, 4}, {10, 10}, {0, 6}, {15, 5}}, found[5];
    for (int k = 0; k < 5; k++) found[k] = electrode[pd_grid_node(&S.grid, at[k])];
    for (int k = 0; k < 5; k++) CHECK_INT(p.material[found[k]], k == 1 ? 3 : 1);
    CHECK_INT(p.member[found[0]], p.member[found[1]]);
    CHECK(found[0] != found[1] && p.member[found[2]] != p.member[found[0]]);
    CHECK_INT(found[3], found[4]);
    CHECK(p.member[found[3]] != p.member[found[0]] && p.member[found[3]] != p.member[found[2]]);
    CHECK_OK(&S.ctx, pd_pieces_find(&S.ctx, &S.grid, NULL, electrode, &p));
    CHECK_INT(p.electrodes, 3);
    for (int32_t i = 0; i < S.grid.total; i++) material[i] = 0;
    scene_free(&S);
    /* 16 times 19 particles are too many */
    static uint8_t mask[32 * 38];
    for (int k = 0; k < 32 * 38; k++) mask[k] = (uint8_t)(k % 32 % 2 && k / 32 % 2);
    scene_box(&S, 1.0, 1.0, 32, 38, 1);
    S.shapes[0].type = PD_SHAPE_VOXELS;
    S.shapes[0].mask = mask;
    for (int d = 0; d < 2; d++) {
        S.shapes[0].b[d] = 1.0;
        S.shapes[0].mask_size[d] = d ? 38 : 32;
    }
    solid(0);
    if (!scene_grid(&S)) return;
    CHECK_INT(pd_pieces_find(&S.ctx, &S.grid, NULL, electrode, &p), PD_ERR_SIZE);
    scene_free(&S);
}
#endif

/* A plate between two others has no net current: it passes what it gets (bipolar), and its potential is the mean of
 * theirs. A fourth circuit touches nothing. */
TEST(bipolar)
{
    pd_electrode_term a = linear(1e-2, 0.0);
    double lo[3] = {0.0, 14.0, 28.0}, hi[3] = {3.0, 17.0, 31.0}, h = 1.0 / 31.0;
    scene_box(&S, 1.0, h, 31, 5, 5);
    for (int k = 0; k < 3; k++) {
        double from[PD_DIM], to[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) {
            from[d] = d ? 0.0 : lo[k] * h;
            to[d] = d ? 5.0 * h : hi[k] * h;
        }
        scene_solid_box(&S.shapes[k], from, to);
        S.shapes[3].child[k] = k;
    }
    S.shapes[3].type = PD_SHAPE_UNION;
    S.shapes[3].child_count = 3;
    for (int side = 2; side < 2 * PD_DIM; side++) S.grid_desc.side[side] = PD_SIDE_MIRROR;
    solid(3);
    begin(0.4);
    for (int e = 0; e < 4; e++) electrode(e, &a, 1, 0.0);
    circuit(0, PD_CIRCUIT_POTENTIAL, 1.0);
    circuit(1, PD_CIRCUIT_CURRENT, 0.0);
    circuit(2, PD_CIRCUIT_CURRENT, 0.0);
    circuit(3, PD_CIRCUIT_CURRENT, 0.0);
    if (!ready(by_thirds)) return;
    X.circuit[2].value = -2.0 * plate_area();
    if (!solve()) return;
    CHECK_REL(X.p.total[0] / plate_area(), 2.0, 1e-9);
    CHECK_NEAR(X.p.total[1] / plate_area(), 0.0, 1e-9);
    double resist = 2e-2 + 11.0 * h / 0.4;
    CHECK_NEAR(X.p.metal[1], 1.0 - 2.0 * resist, 1e-9);
    CHECK_NEAR(X.p.metal[2], 1.0 - 4.0 * resist, 1e-9);
    done();
}
#if PD_DIM == 2
#define PIECES ENTRY(bipolar) ENTRY(pieces)
#else
#define PIECES ENTRY(bipolar)
#endif
#else
#define PIECES
#endif

TEST_MAIN(ENTRY(plates_anywhere) ENTRY(held_sides_and_layers) ENTRY(mixed_potentials) ENTRY(limiting_currents)
          ENTRY(faint_currents) ENTRY(other_polarity) ENTRY(far_starts) ENTRY(high_voltage) ENTRY(scales)
          ENTRY(any_reference) ENTRY(receding) ENTRY(refusals) PIECES)
