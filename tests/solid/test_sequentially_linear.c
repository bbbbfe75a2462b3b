/* test_sequentially_linear: loads in proportion, bond after bond: a bundle of bars, a crack whose load and whose
 * displacement fall as it grows. dims: 1 2 */
#include "solid/correspondence.h"
#include "solid/body_bonds.h"
#include "solid/sequentially_linear.h"
#include "test.h"
#include <math.h>

#define MOST 5000 /* points */
#define YOUNG 70e9
#define CRITICAL 1e-3

static struct {
    pd_ctx ctx;
    pd_body_desc desc;
    pd_body body;
    pd_correspondence elastic;
    pd_material_interface solid;
    pd_sequentially_linear way;
    double position[MOST * PD_DIM], volume[MOST], moved[MOST * PD_DIM], load[MOST * PD_DIM];
    uint8_t held[MOST * PD_DIM];
} c;

static int body(double h, double m)
{
    pd_correspondence_desc d;
    memset(&d, 0, sizeof d);
    c.desc.position = c.position;
    c.desc.volume = c.volume;
    c.desc.horizon = m * h;
    c.desc.spacing = h;
    d.young = YOUNG;
    d.poisson = 0.3;
    d.plane = PD_PLANE_STRESS;
    d.detach_singular = 1;
    if (!CHECK_OK(&c.ctx, pd_body_build(&c.ctx, &c.desc, &c.body))) return 0;
    if (!CHECK_OK(&c.ctx, pd_correspondence_build(&c.ctx, &c.body, &d, &c.elastic))) return 0;
    c.solid = pd_correspondence_material(&c.elastic);
    return 1;
}

static int follow(int by_load)
{
    pd_sequentially_linear_desc d;
    memset(&d, 0, sizeof d);
    d.prescribed = c.held;
    if (by_load) d.load = c.load;
    else d.unit_displacement = c.moved;
    d.criterion.critical = CRITICAL;
    d.rtol = 1e-12;
    return CHECK_OK(&c.ctx, pd_sequentially_linear_build(&c.ctx, &c.solid, &d, &c.way));
}

static void end(void)
{
    pd_sequentially_linear_free(&c.ctx, &c.way);
    pd_correspondence_free(&c.ctx, &c.elastic);
    pd_body_free(&c.ctx, &c.body);
    CHECK_INT(c.ctx.in_use, 0);
}

#if PD_DIM == 1
/* Cells of an even strain that a bar of cells is as stiff as, between points that are held: the last bond has the whole
 * cell of its end and half of the next, so it is 1.5 times as stiff as others. */
static double even(int cells) { return cells - 3 + 2.0 / 1.5; }

/* Once it is done, the analysis stays as it is, and so do the bonds. */
static void ends_once(void)
{
    pd_sequentially_linear way = c.way;
    int64_t intact = 0, left = 0;
    for (int32_t i = 0; i < c.body.count; i++) intact += pdi_body_bonds_count_intact(&c.body, i);
    CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way));
    for (int32_t i = 0; i < c.body.count; i++) left += pdi_body_bonds_count_intact(&c.body, i);
    CHECK(memcmp(&way, &c.way, sizeof way) == 0);
    CHECK_INT(left, intact);
}

/* Bars side by side, one longer than the other: the shortest breaks first. All that it holds then is lost. */
TEST(bundle)
{
    static const int cells[3] = {5, 8, 12};
    const double h = 1e-3;
    double taken = 0.0;
    int32_t at = 0;
    memset(&c, 0, sizeof c);
    pd_ctx_init(&c.ctx);
    for (int b = 0; b < 3; b++)
        for (int k = 0; k < cells[b]; k++, at++) {
            c.position[at] = (50 * b + k) * h;
            c.volume[at] = h;
            c.held[at] = k == 0 || k == cells[b] - 1;
            c.moved[at] = k == cells[b] - 1;
        }
    c.desc.count = at;
    if (!body(h, 1.0) || !follow(0)) return;
    for (int b = 0; b < 3; b++) {
        double wide = even(cells[b]) * h, left = 0.0;
        CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way));
        for (int o = b; o < 3; o++) left += YOUNG / (even(cells[o]) * h);
        CHECK_REL(c.way.factor, CRITICAL * wide, 1e-9);
        CHECK_REL(c.way.force, left * CRITICAL * wide, 1e-9);
        CHECK_REL(c.way.dissipated + 1.0, taken + 1.0, 1e-12);
        CHECK_REL(c.way.work, c.way.stored + taken, 1e-9);
        taken += 0.5 * YOUNG * CRITICAL * CRITICAL * wide;
    }
    CHECK(!c.way.done);
    CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way));
    CHECK(c.way.done);
    CHECK_INT(c.way.events, 3);
    CHECK_REL(c.way.dissipated, taken, 1e-9);
    CHECK_REL(c.way.work, taken, 1e-9);
    ends_once();
    end();
}

/* A bar that a load at its end pulls from a point that is held: the strain under the force N is N/E, and a bond breaks
 * at the critical one. What comes off ends the analysis without an error. */
TEST(pulled_bar)
{
    const double h = 1e-3;
    memset(&c, 0, sizeof c);
    pd_ctx_init(&c.ctx);
    for (int k = 0; k < 9; k++) {
        c.position[k] = k * h;
        c.volume[k] = h;
    }
    c.desc.count = 9;
    c.held[0] = 1;
    c.load[8] = 1.0 / h; /* a force of 1 N/m2 */
    if (!body(h, 1.0) || !follow(1)) return;
    CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way));
    CHECK_REL(c.way.factor, YOUNG * CRITICAL, 1e-9);
    CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way));
    CHECK(c.way.done);
    CHECK_INT(c.way.events, 1);
    CHECK_REL(c.way.dissipated, c.way.work, 1e-12);
    CHECK_INT((int)c.ctx.status, (int)PD_OK);
    CHECK_STR(c.ctx.message, "");
    ends_once();
    end();
}

/* What is refused. */
TEST(refusals)
{
    pd_sequentially_linear_desc d;
    memset(&c, 0, sizeof c);
    memset(&d, 0, sizeof d);
    pd_ctx_init(&c.ctx);
    for (int k = 0; k < 9; k++) {
        c.position[k] = k * 1e-3;
        c.volume[k] = 1e-3;
    }
    c.desc.count = 9;
    if (!body(1e-3, 1.0)) return;
    d.criterion.critical = CRITICAL;
    CHECK_INT(pd_sequentially_linear_build(&c.ctx, &c.solid, &d, &c.way), PD_ERR_ARGUMENT);
    d.unit_displacement = c.moved;
    CHECK_INT(pd_sequentially_linear_build(&c.ctx, &c.solid, &d, &c.way), PD_ERR_ARGUMENT);
    d.prescribed = c.held;
    d.load = c.load;
    CHECK_INT(pd_sequentially_linear_build(&c.ctx, &c.solid, &d, &c.way), PD_ERR_ARGUMENT);
    d.load = NULL;
    d.criterion.critical = 0.0;
    CHECK_INT(pd_sequentially_linear_build(&c.ctx, &c.solid, &d, &c.way), PD_ERR_ARGUMENT);
    pd_correspondence_free(&c.ctx, &c.elastic);
    pd_body_free(&c.ctx, &c.body);
    CHECK_INT(c.ctx.in_use, 0);
}

TEST_MAIN(ENTRY(bundle) ENTRY(pulled_bar) ENTRY(refusals))
#else
#define TOUGH 156.5 /* [J/m2] of a crack along the lattice: of the first load at each length, found here */

/* A plate of n[0] x n[1] cells with a crack across its middle, `half` cells to each side; its ends move apart. */
static int plate(const int *n, int half, double m)
{
    const double h = 1e-3;
    memset(&c, 0, sizeof c);
    pd_ctx_init(&c.ctx);
    if (!CHECK(n[0] * n[1] <= MOST)) return 0;
    for (int k = 0; k < n[0] * n[1]; k++) {
        int end_row = k / n[0] < 2 ? -1 : k / n[0] >= n[1] - 2 ? 1 : 0;
        c.position[2 * k] = (k % n[0] - 0.5 * (n[0] - 1)) * h;
        c.position[2 * k + 1] = (k / n[0] - 0.5 * (n[1] - 1)) * h;
        c.volume[k] = h * h;
        c.held[2 * k] = c.held[2 * k + 1] = end_row != 0;
        c.moved[2 * k + 1] = 0.5 * end_row;
    }
    c.desc.count = n[0] * n[1];
    if (!body(h, m)) return 0;
    for (int32_t i = 0; i < c.body.count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c.body, i); pd_body_bonds_next(&b);) {
            const double *p = c.position + 2 * i, *q = c.position + 2 * b.neighbour;
            if ((p[1] < 0.0) == (q[1] < 0.0)) continue;
            double at = p[0] - p[1] * (q[0] - p[0]) / (q[1] - p[1]);
            if (fabs(at) < half * h + 1e-3 * h) pdi_body_bonds_mark_broken(&c.body, i, b.number);
        }
    CHECK_OK(&c.ctx, c.solid.update(&c.ctx, c.solid.self));
    return 1;
}

/* K over the stress and the root of pi a, of a crack of 2 a in a strip of 2 w (Tada, Paris and Irwin 2000). */
static double shape(double a, double w)
{
    double r = a / w;
    return (1.0 - 0.025 * r * r + 0.06 * r * r * r * r) / sqrt(cos(0.5 * 3.14159265358979323846 * r));
}

/* The crack grows at both ends at once. The largest load of each length follows from one toughness by the closed form,
 * and so does the compliance. The plate is so long that its ends have to go back as the crack grows. */
TEST(snap_back)
{
    static const int n[2] = {40, 120};
    const double h = 1e-3, w = 20e-3, pi = 3.14159265358979323846;
    double peak[20] = {0.0}, soft[20] = {0.0}, tough[20], last = 0.0, mean = 0.0, first = 0.0, grown = 0.0;
    int back = 0, count = 0;
    if (!plate(n, 4, 2.0) || !follow(0)) return;
    while (c.way.events < 2000) {
        if (!CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way)) || c.way.done) break;
        int tip = (int)floor(fabs(c.way.first.midpoint[0]) / h + 0.5); /* [cell] that the crack has reached */
        if (tip >= 20) tip = 19;
        if (c.way.force > peak[tip]) {
            peak[tip] = c.way.force;
            soft[tip] = c.way.displacement / c.way.force;
        }
        back += c.way.displacement < last;
        if (!(first > 0.0)) first = c.way.displacement;
        last = c.way.displacement;
        CHECK_REL(c.way.work, c.way.stored + c.way.dissipated, 1e-9);
    }
    for (int32_t i = 0; i < c.body.count; i++) { /* its mirror image */
        int32_t mirror = n[0] - 1 - i % n[0] + i / n[0] * n[0];
        if (!CHECK_INT((int)pdi_body_bonds_count_intact(&c.body, i), (int)pdi_body_bonds_count_intact(&c.body, mirror)))
            break;
    }
    CHECK(c.way.done && back > 10);
    for (int k = 6; k <= 14; k++) {
        double stress = peak[k] / (2.0 * w), a = k * h, f = shape(a, w);
        tough[k] = stress * stress * pi * a * f * f / YOUNG;
        mean += tough[k] / 9.0;
        count += peak[k] > 0.0;
        NOTE("%d cells: %.4g J/m2, %.4g m2/MN, displacement %.3f of the first", k, tough[k], 1e6 * soft[k],
             soft[k] * peak[k] / first);
    }
    CHECK_INT(count, 9);
    CHECK_REL(mean, TOUGH, 2e-3);
    for (int k = 6; k <= 14; k++) CHECK_REL(tough[k], mean, 0.02);
    /* compliance: E (q/F) grows by the integral of 4 pi a f^2 / (2 w)^2 for both tips */
    for (int k = 6000; k < 14000; k++) {
        double a = (k + 0.5) * 1e-3 * h, f = shape(a, w);
        grown += 4.0 * pi * a * f * f / (4.0 * w * w) * 1e-3 * h;
    }
    NOTE("compliance grows by %.4g, the closed form says %.4g", YOUNG * (soft[14] - soft[6]), grown);
    CHECK_REL(YOUNG * (soft[14] - soft[6]), grown, 0.04);
    end();
}

/* The same plate under loads at its ends, which nothing holds: the first growth takes the same toughness. */
TEST(by_load)
{
    static const int n[2] = {40, 110};
    const double h = 1e-3, w = 20e-3, pi = 3.14159265358979323846;
    double peak = 0.0;
    if (!plate(n, 7, 2.0)) return;
    memset(c.held, 0, sizeof c.held);
    for (int k = 0; k < n[0] * n[1]; k++) c.load[2 * k + 1] = 2.0 * c.moved[2 * k + 1]; /* one in both end rows */
    if (!follow(1)) return;
    while (c.way.events < 400) {
        if (!CHECK_OK(&c.ctx, pd_sequentially_linear_next_event(&c.ctx, &c.way)) || c.way.done) break;
        int tip = (int)floor(fabs(c.way.first.midpoint[0]) / h + 0.5);
        if (tip == 9) peak = fmax(peak, c.way.force);
        if (tip > 10) break;
        CHECK_REL(c.way.work, c.way.stored + c.way.dissipated, 1e-9);
        CHECK_REL(c.way.force * c.way.displacement, 2.0 * c.way.stored, 1e-9);
    }
    CHECK(!c.way.done);
    double stress = peak * 2.0 * h, a = 9.0 * h, f = shape(a, w);
    NOTE("9 cells: %.4g J/m2", stress * stress * pi * a * f * f / YOUNG);
    CHECK_REL(stress * stress * pi * a * f * f / YOUNG, TOUGH, 0.02);
    end();
}

TEST_MAIN(SLOW_ENTRY(snap_back) ENTRY(by_load))
#endif
