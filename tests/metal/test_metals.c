/* Several metals in one run: each has its Cs, law and charge. Fronts and a sealed cell against closed forms, metals
 * that are alike against one metal, salt layers, scenes.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include <math.h>

#if PD_DIM == 1
#define ACROSS(range) ""
#elif PD_DIM == 2
#define ACROSS(range) ", " range
#else
#define ACROSS(range) ", " range ", " range
#endif
#if PD_DIM == 3
#define DEPTH ", 0 .. 8 um"
#else
#define DEPTH ""
#endif

/* Plays a scene to its end and measures each metal: volume left [m], a cell across counts as 1. */
typedef struct played {
    double left[2], start[2]; /* of each metal, in cells */
    double depth[2];          /* of its front: what turns fluid at Csat holds that */
    double low, high;         /* [cell] mean depth of the first and last quarter along y */
    double loss, ledger, fluid;
    int64_t unsolved;
} played;

static int play(const char *text, int threads, played *p)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    memset(p, 0, sizeof *p);
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return 0;
    ctx.threads = threads;
    int good = CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m));
    for (int k = 0; k < 2 && good; k++) {
        if (k) good = CHECK_OK(&ctx, pd_time_loop_start(&ctx, &m.time_loop));
        while (k && good && m.time_loop.time < u.end_time) {
            good = CHECK_OK(&ctx, pd_time_loop_step(&ctx, &m.time_loop, u.end_time));
            p->ledger = fmax(p->ledger, m.time_loop.ledger[0].relative_imbalance);
        }
        for (int32_t i = 0; i < m.grid.total && good; i++) {
            if (m.grid.kind[i] != PD_SOLID) continue;
            int metal = m.metal ? m.metal[i] : 0;
            double solid = u.metal[metal].solid_c, rest = u.has_corrode ? u.saturation : 0.0;
            (k ? p->left : p->start)[metal] += m.transport.c[i] / solid;
            double share = (k ? -1.0 : 1.0) * (m.transport.c[i] - rest) / (solid - rest), x[PD_DIM];
            p->depth[metal] += share;
            pd_grid_position(&m.grid, i, x);
            double rows = m.grid.n[PD_DIM - 1 > 0], y = x[PD_DIM - 1 > 0] / m.grid.h[0], many = 0.25 * rows;
            if (PD_DIM == 3) many *= m.grid.n[PD_DIM - 1];
            if (y < 0.25 * rows) p->low += share / many;
            if (y > 0.75 * rows) p->high += share / many;
        }
    }
    if (good) {
        p->loss = pd_time_loop_volume_loss(&m.time_loop);
        p->unsolved = m.time_loop.unsolved;
        p->fluid = (double)m.grid.fluid_count;
    }
    pd_model_free(&ctx, &m);
    leave(&ctx, &u);
    return good;
}

/* Metal A on the left, B on the right, fluid between: D is so large that both see the same concentration. */
#define CELL "[grid] h = 1 um  m = %d  box = 0 .. 60 um" ACROSS("0 .. 3 um") "\n" \
    "[shape a] box = 0 um .. 20 um" ACROSS("0 um .. 3 um") "  kind = solid  material = mg4ag\n" \
    "[shape b] box = 40 um .. 60 um" ACROSS("0 um .. 3 um") "  kind = solid  material = steel304\n"

/* A sealed cell saturates. What both give has the ratio of their laws, and fills the fluid that there is:
 * Cs_A d_A + Cs_B d_B = Csat times the length of the fluid. */
TEST(sealed_cell)
{
    for (int m = 1; m <= 3; m++)
        for (int bonds = 0; bonds < 2; bonds++) {
            char text[1400];
            played p;
            int used = snprintf(text, sizeof text, CELL, m);
            if (bonds)
                snprintf(text + used, sizeof text - (size_t)used,
                         "[corrode] rate = 1 um/s * (1 - C/Csat)  Cs = 23 mol/L  Csat = 5 mol/L  D = 1e-4 m2/s\n"
                         "[corrode steel304] rate = 0.5 um/s * (1 - C/Csat)  Cs = 10 mol/L\n[run] until = 400 s\n");
            else
                snprintf(text + used, sizeof text - (size_t)used,
                         "[transport] D = 1e-4 m2/s  initial = 0 mol/m3\n"
                         "[dissolve] rate = 1 um/s * (1 - C/Csat)  Cs = 23 mol/L  Csat = 5 mol/L\n"
                         "[dissolve steel304] rate = 0.5 um/s * (1 - C/Csat)  Cs = 10 mol/L\n[run] until = 400 s\n");
            if (!play(text, 1, &p)) return;
            double a = p.start[0] - p.left[0], b = p.start[1] - p.left[1];
            NOTE("m = %d, %s: depths in the ratio %.5f, fill %.6f", m, bonds ? "bonds" : "surface rate",
                 p.depth[0] / p.depth[1],
                 (23.0 * a + 10.0 * b) / (5.0 * p.fluid));
            CHECK_LE(p.ledger, 1e-12);
            CHECK_INT(p.unsolved, 0);
            CHECK_REL(p.depth[0] / p.depth[1], 2.0, 1e-5);
            CHECK_REL(23.0 * a + 10.0 * b, 5.0 * p.fluid, 1e-6);
            CHECK_REL(p.loss, (a + b) / (p.start[0] + p.start[1]), 1e-12);
        }
}

#if PD_DIM > 1
/* Two metals beside each other, below fluid. */
#define BODY "[grid] h = %g um  m = %d  box = 0 .. 16 um, 0 .. 24 um" DEEP "\n" \
    "[shape low] box = 6 um .. 16 um, 0 .. 12 um" DEEP "  kind = solid  material = mg4ag\n" \
    "[shape high] box = 6 um .. 16 um, 12 um .. 24 um" DEEP "  kind = solid  material = %s\n" \
    "[side x-] %s\n[side y-] flow = mirror\n[side y+] flow = mirror\n" SHALLOW
#if PD_DIM == 2
#define DEEP ""
#define SHALLOW ""
#else
#define DEEP ", 0 .. 2 um"
#define SHALLOW "[side z-] flow = mirror\n[side z+] flow = mirror\n"
#endif
#define AT_REST(d) "[transport] D = " d " m2/s  initial = 0 mol/m3\n"

/* A body as one metal, and as two that are alike: nothing differs but that metals hand over nothing to each other,
 * which counts where families are wider than one cell, and there as far as they reach. */
TEST(metals_that_are_alike)
{
    static const char *const laws[] = {"rate = 0.5 um/s * (1 - C/Csat)", "rate = 0.5 um/s",
                                       "rate = 0.5 um/s * (0.1 + 0.9*(C < 0.5*Csat))"};
    for (int k = 0; k < 6; k++) {
        double off[3];
        for (int level = 0; level < 3; level++) { /* m = 1; 2; 2 at half the spacing */
            played p[2];
            int bonds = k >= 3, fine = level == 2;
            if (fine && PD_DIM == 3) continue;
            for (int two = 0; two < 2; two++) {
                char text[2000];
                int used = snprintf(text, sizeof text, BODY "%s[%s] %s  Cs = 20 mol/L  Csat = 5 mol/L%s\n",
                                    fine ? 0.5 : 1.0, level ? 2 : 1, two ? "steel304" : "mg4ag",
                                    bonds ? "flow = open" : "C = 0 mol/m3", bonds ? "" : AT_REST("1e-9"),
                                    bonds ? "corrode" : "dissolve", laws[k % 3],
                                    bonds ? "  D = 1e-9 m2/s" : level ? "  m = 2" : "  m = 1");
                snprintf(text + used, sizeof text - (size_t)used, "%s%s%s[run] until = 7.3 s\n",
                         two ? bonds ? "[corrode steel304] " : "[dissolve steel304] " : "", two ? laws[k % 3] : "",
                         two ? "  Cs = 20 mol/L\n" : "");
                if (!play(text, 1, &p[two])) return;
                CHECK_LE(p[two].ledger, 1e-12);
                CHECK_INT(p[two].unsolved, 0);
            }
            off[level] = fabs(p[1].loss / p[0].loss - 1.0);
            CHECK(p[0].loss > 0.2 && p[0].loss < 0.9);
        }
        NOTE("%s, %s: off by %.1e with m = 1, %.1e with m = 2", k < 3 ? "surface rate" : "bonds", laws[k % 3], off[0],
             off[1]);
        CHECK_LE(off[0], 1e-8);
        CHECK_LE(off[1], 1e-2);
#if PD_DIM == 2
        CHECK_LE(off[2], fmax(0.6 * off[1], 1e-3));
#endif
    }
}

/* Each metal goes at its own speed where the other one is out of reach. */
TEST(side_by_side)
{
    for (int m = 1; m <= 3; m++)
        for (int bonds = 0; bonds < 2; bonds++) {
            char text[2000];
            played p;
            int used = snprintf(text, sizeof text, BODY, 1.0, m, "steel304", bonds ? "flow = open" : "C = 0 mol/m3");
            snprintf(text + used, sizeof text - (size_t)used,
                     "%s[%s] rate = 1 um/s  Cs = 20 mol/L  Csat = 5 mol/L%s\n[%s steel304] rate = 0.4 um/s  "
                     "Cs = 12 mol/L\n[run] until = 7 s\n", bonds ? "" : AT_REST("1e-6"), bonds ? "corrode" : "dissolve",
                     bonds ? "  D = 1e-6 m2/s" : "", bonds ? "corrode" : "dissolve");
            if (!play(text, 1, &p)) return;
            NOTE("m = %d, %s: %.4f and %.4f um go, 7 and 2.8 should", m, bonds ? "bonds" : "surface rate", p.low,
                 p.high);
            CHECK_LE(p.ledger, 1e-12);
            /* a surface rate hands over within wide families, and the edge between the metals roughens that */
            CHECK_REL(p.low, 7.0, bonds ? 5e-3 : 2e-2);
            CHECK_REL(p.high, 2.8, bonds ? 1e-3 : 2e-2);
        }
}
#endif

/* ---- scenes ---- */

#define PAIR \
    "[grid] h = 1 um  m = 2  box = 0 .. 20 um" ACROSS("0 .. 3 um") "\n" \
    "[shape a] box = 0 .. 12 um" ACROSS("0 .. 3 um") "  kind = solid  material = copper\n" \
    "[shape b] box = 4 um .. 8 um" ACROSS("0 .. 3 um") "  kind = solid  material = steel304\n" \
    "[shape c] box = 8 um .. 9 um" ACROSS("0 .. 3 um") "  kind = solid  material = copper\n"

TEST(keys_of_each_metal)
{
    pd_ctx ctx;
    pd_setup u;
    pd_model m;
    double c = 0.0;
    if (!CHECK_OK(&ctx, load(&ctx, PAIR "[corrode] Csat = 5 mol/L  D = 1e-9 m2/s  current = 1 A/cm2\n"
                             "[corrode steel304] Cs = 100 mol/L  charge = 2.5  rate = 1 um/s * Cs/(50 mol/L) * z_m\n"
                             "[run] until = 1 s\n", NULL, 0, &u))) return;
    CHECK_INT(u.metals, 2);
    CHECK(strcmp(u.metal[0].material.name, "copper") == 0 && strcmp(u.metal[1].material.name, "steel304") == 0);
    CHECK_REL(u.metal[0].solid_c, 8960.0 / 0.063546, 1e-12);
    CHECK_REL(u.metal[1].solid_c, 100e3, 1e-15);
    CHECK_REL(u.metal[0].rate_scale * pd_expr_eval(&u.metal[0].rate, &c),
              1e4 / (2.0 * 96485.33212331001 * u.metal[0].solid_c), 1e-12);
    CHECK_REL(u.metal[1].rate_scale * pd_expr_eval(&u.metal[1].rate, &c), 1e-6 * 2.0 * 2.5, 1e-12);
    CHECK_REL(u.metal[1].material.charge, 2.5, 1e-15);
    if (CHECK_OK(&ctx, pd_model_build(&ctx, &u, &m))) { /* a metal that is named later lies on top */
        for (int32_t i = 0; i < m.grid.total; i++) {
            double x[PD_DIM];
            if (m.grid.kind[i] != PD_SOLID) continue;
            pd_grid_position(&m.grid, i, x);
            int second = x[0] > 4e-6 && x[0] < 8e-6;
            CHECK_INT(m.metal[i], second);
            CHECK_REL(m.transport.c[i], second ? 100e3 : u.metal[0].solid_c, 1e-15);
        }
        pd_model_free(&ctx, &m);
    }
    leave(&ctx, &u);
}

TEST(refusals)
{
#define LAWS "[corrode] Csat = 5 mol/L  D = 1e-9 m2/s  rate = 1 um/s\n"
    static const char *const cases[][2] = {
        {LAWS "[corrode mg4ag] rate = 1 um/s\n", "found the metal 'mg4ag', expected a material of the shapes: copper, "
                                                 "steel304"},
        {LAWS "[corrode steel304] Csat = 4 mol/L  rate = 1 um/s\n", "expected it in [corrode], which holds for all"},
        {LAWS "[corrode steel304] Cs = 100 mol/L\n", "found no 'rate'"},
        {LAWS "[corrode steel304] rate = 1 um/s  Cs = 4 mol/L\n", "expected less than Cs = 4000 mol/m3 of steel304"},
        {LAWS "[corrode steel304] rate = -1 um/s\n", "expected 0 to 1 m/s"},
        {LAWS "[corrode steel304] rate = 1 um/s  current = 1 A/m2\n", "expected one of them"},
        {"[corrode steel304] rate = 1 um/s\n[corrode copper] rate = 2 um/s\n", "found no 'Csat'"},
        {"[transport] D = 1e-9 m2/s\n[dissolve steel304] rate = 1 um/s\n", "found no 'rate'"},
        {"[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/s\n[dissolve steel304] threshold = 0.1\n",
         "expected it in [dissolve], which holds for all"},
        {LAWS "[dissolve steel304] rate = 1 um/s\n", "found beside [dissolve]"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[1400];
        snprintf(text, sizeof text, PAIR "%s[run] until = 1 s\n", cases[k][0]);
        refused(text, cases[k][1]);
    }
}

/* Stripes of two metals in the reach of the same fluid, by laws that jump: the same bits for any number of threads, and
 * nothing is lost. */
TEST(stripes)
{
    static const char *const laws[] = {
        "[corrode] rate = 1 um/s  Csat = 5 mol/L  D = 1e-9 m2/s\n[corrode steel304] "
        "rate = 0.5 um/s * (0.2 + 0.8*(C < 0.4*Csat))  Cs = 50 mol/L\n",
        "[corrode] driving_force = difference  rate = 1 um/s * (1 - C/Csat)  Csat = 5 mol/L  "
        "D = 1e-9 m2/s\n[corrode steel304] rate = 0.5 um/s  Cs = 50 mol/L\n",
        "[transport] D = 1e-9 m2/s  initial = 0 mol/m3\n[dissolve] rate = 1 um/s * (1 - "
        "C/Csat)  Csat = 5 mol/L\n[dissolve steel304] rate = 0.5 um/s * (0.2 + 0.8*(C < "
        "0.4*Csat))  Cs = 50 mol/L\n"};
    for (int k = 0; k < 3; k++) {
        played p[2];
        for (int two = 0; two < 2; two++) {
            char text[2000];
            int used = snprintf(text, sizeof text, "[grid] h = 1 um  m = 2  box = 0 .. 24 um" ACROSS("0 .. 8 um") "\n"
                                "[shape base] box = 8 um .. 24 um" ACROSS("0 .. 8 um")
                                "  kind = solid  material = mg4ag\n");
            for (int n = 0; n < 4; n++)
                used += snprintf(text + used, sizeof text - (size_t)used, PD_DIM == 1
                                 ? "[shape s%d] box = %d um .. %d um  kind = solid  material = steel304\n"
                                 : "[shape s%d] box = 8 um .. 24 um, %d um .. %d um" DEPTH "  kind = solid  material = "
                                   "steel304\n", n, (PD_DIM == 1 ? 9 : 0) + 2 * n, (PD_DIM == 1 ? 10 : 1) + 2 * n);
            snprintf(text + used, sizeof text - (size_t)used, "[side x-] %s\n%s[run] until = 6 s\n",
                     k < 2 ? "flow = open" : "C = 0 mol/m3", laws[k]);
            if (!play(text, 1 + two, &p[two])) return;
            CHECK_LE(p[two].ledger, 1e-12);
            CHECK_INT(p[two].unsolved, 0);
        }
        NOTE("law %d: loss %.4f, of both metals %.3f and %.3f of %.0f and %.0f cells", k, p[0].loss,
             p[0].start[0] - p[0].left[0], p[0].start[1] - p[0].left[1], p[0].start[0], p[0].start[1]);
        CHECK(p[0].loss > 0.02 && p[0].loss < 1.0 && p[0].left[0] < p[0].start[0] && p[0].left[1] < p[0].start[1]);
        CHECK_NEAR(p[1].left[0], p[0].left[0], 0.0);
        CHECK_NEAR(p[1].left[1], p[0].left[1], 0.0);
        CHECK_REL(p[0].loss, 1.0 - (p[0].left[0] + p[0].left[1]) / (p[0].start[0] + p[0].start[1]), 1e-12);
    }
}

#if PD_DIM == 1
#define OF_DIM
#else
#define OF_DIM ENTRY(metals_that_are_alike) ENTRY(side_by_side)
#endif

TEST_MAIN(SLOW_ENTRY_IF(PD_DIM == 3, sealed_cell) ENTRY(keys_of_each_metal) ENTRY(refusals)
              SLOW_ENTRY_IF(PD_DIM == 3, stripes) OF_DIM)
