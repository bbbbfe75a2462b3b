/* generate: see generate.h */
#include "generate.h"
#include "random.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

double draw_fraction(draw *g) { return random_share(&g->state); }
double draw_between(draw *g, double low, double high) { return random_between(&g->state, low, high); }
double draw_decade(draw *g, double low, double high) { return exp(draw_between(g, log(low), log(high))); }
int draw_chance(draw *g, double chance) { return draw_fraction(g) < chance; }
int draw_exact(const draw *g) { return g->of == CLASS_EXACT || g->of == CLASS_RING; }
int draw_whole(draw *g, int low, int high) { return low + (int)(draw_fraction(g) * (high - low + 1)); }

/* ---- shapes ---- */

/* A face on the lattice, through nodes, or anywhere. */
static double draw_face(double cell, int how)
{
    if (how == 0) return floor(cell + 0.5);
    if (how == 1) return floor(cell) + 0.5;
    return cell;
}

/* A box or a ball within `low` and `high` [cells]; 0 for one that is too small. */
static void draw_body(draw *g, int s, const double *low, const double *high)
{
    scene *x = g->x;
    int how = draw_chance(g, 0.55) ? 0 : draw_chance(g, g->through) ? 1 : 2;
    double a[3] = {0}, b[3] = {0}, least = 1e9;
    for (int d = 0; d < PD_DIM; d++)
        if ((high[d] - low[d]) * x->h[d] < least) least = (high[d] - low[d]) * x->h[d];
    if (draw_chance(g, PD_DIM == 1 ? 0.1 : 0.4)) {
        double r = least * draw_between(g, 0.3, 0.49);
        for (int d = 0; d < PD_DIM; d++) {
            double mid = draw_between(g, low[d] + r / x->h[d], high[d] - r / x->h[d]);
            a[d] = x->low[d] + x->h[d] * (how == 2 ? mid : draw_face(mid, how));
            if (how != 2 && (a[d] - r < x->low[d] + low[d] * x->h[d] || a[d] + r > x->low[d] + high[d] * x->h[d]))
                a[d] = x->low[d] + x->h[d] * mid;
        }
        if ((x->has & HAS_AXIS) && draw_chance(g, 0.7)) a[1] = 0.0;
        if (PD_DIM == 3 && draw_chance(g, 0.3)) {
            scene_axis(x, s, "cylinder", draw_whole(g, 0, 2));
            scene_point(x, s, "centre", a);
        } else scene_point(x, s, "ball", a);
        scene_key(x, s, "radius", "%q", r, UNIT_LENGTH);
        return;
    }
    for (int d = 0; d < PD_DIM; d++) {
        double room = high[d] - low[d], size = room * draw_between(g, 0.35, 0.95);
        double from = low[d] + (room - size) * draw_fraction(g), to = from + size;
        if (draw_chance(g, 0.12)) from = low[d];
        if (draw_chance(g, 0.12)) to = high[d];
        double p = draw_face(from, how), q = draw_face(to, how);
        if (p < low[d]) p = low[d];
        if (q > high[d]) q = high[d];
        if (q - p < 1.0) q = p + 1.0 < high[d] ? p + 1.0 : high[d];
        if (q - p < 0.9) p = q - 1.0;
        a[d] = x->low[d] + p * x->h[d];
        b[d] = x->low[d] + q * x->h[d];
    }
    if ((x->has & HAS_AXIS) && draw_chance(g, 0.7)) a[1] = 0.0;
    scene_box(x, s, "box", a, b);
}

/* Faces of boxes that touch or overlap lie on the lattice. */
static void draw_two_boxes(draw *g, int s, const double *low, const double *high)
{
    scene *x = g->x;
    double a[2][3], b[2][3];
    int axis = draw_whole(g, 0, PD_DIM - 1), touch = draw_chance(g, 0.5);
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < PD_DIM; d++) {
            double room = high[d] - low[d], from = floor(low[d] + room * draw_between(g, 0.0, 0.3)),
                   to = ceil(high[d] - room * draw_between(g, 0.0, 0.3)), mid = floor(0.5 * (from + to));
            if (d == axis && k == 0) to = mid + 1.0;
            if (d == axis && k == 1) from = touch ? (b[0][d] - x->low[d]) / x->h[d] : mid;
            if (to - from < 1.0) to = from + 1.0;
            if ((x->has & HAS_AXIS) && d == 1 && draw_chance(g, 0.7)) from = 0.0;
            a[k][d] = x->low[d] + from * x->h[d];
            b[k][d] = x->low[d] + to * x->h[d];
        }
    a[1][axis] = touch ? b[0][axis] : a[1][axis];
    for (int k = 0; k < 2; k++) scene_box(x, s + k, "box", a[k], b[k]);
}

/* A slanted face. */
static void draw_half_space(draw *g, int s, const double *low, const double *high)
{
    scene *x = g->x;
    double at[3], normal[3];
    for (int d = 0; d < PD_DIM; d++) {
        at[d] = x->low[d] + x->h[d] * (low[d] + (high[d] - low[d]) * draw_between(g, 0.4, 0.7));
        normal[d] = draw_between(g, 0.1, 1.0) * (draw_chance(g, 0.5) ? -1.0 : 1.0);
    }
    scene_key(x, s, "half_space", "yes");
    scene_point(x, s, "point", at);
    scene_direction(x, s, "normal", normal);
}

/* Voxels of the box, of one cell or two, in which some balls are. */
static void draw_voxels(draw *g, const double *low, const double *high)
{
    scene *x = g->x;
    voxels *v = &x->mask;
    int coarse = draw_chance(g, 0.3), balls = draw_whole(g, 1, 3), size[3] = {1, 1, 1}, at[3];
    double mid[3][3], radius[3];
    for (int d = 0; d < 3; d++) v->n[d] = 1;
    for (int d = 0; d < PD_DIM; d++) size[d] = coarse && x->cells[d] % 2 == 0 ? 2 : 1;
    for (int d = 0; d < PD_DIM; d++) v->n[d] = x->cells[d] / size[d];
    for (int k = 0; k < balls; k++) {
        double least = 1e9;
        for (int d = 0; d < PD_DIM; d++) {
            mid[k][d] = draw_between(g, low[d] + 1.0, high[d] - 1.0);
            if (high[d] - low[d] < least) least = high[d] - low[d];
        }
        radius[k] = least * draw_between(g, 0.2, 0.5);
    }
    for (at[2] = 0; at[2] < v->n[2]; at[2]++)
        for (at[1] = 0; at[1] < v->n[1]; at[1]++)
            for (at[0] = 0; at[0] < v->n[0]; at[0]++) {
                int in = 0, may = 1;
                double p[3];
                for (int d = 0; d < PD_DIM; d++) {
                    p[d] = (at[d] + 0.5) * size[d];
                    may = may && p[d] > low[d] && p[d] < high[d];
                }
                for (int k = 0; k < balls; k++) {
                    double r2 = 0.0;
                    for (int d = 0; d < PD_DIM; d++) r2 += (p[d] - mid[k][d]) * (p[d] - mid[k][d]);
                    if (r2 < radius[k] * radius[k]) in = 1;
                }
                v->inside[(at[2] * v->n[1] + at[1]) * v->n[0] + at[0]] = (unsigned char)(in && may);
            }
}

static void draw_solid(draw *g, const char *name, const char *material, const double *low, const double *high)
{
    scene *x = g->x;
    char a[24], b[24];
    int s, how = PD_DIM == 1 ? 0 : draw_whole(g, 0, 19), count = 1;
    for (int d = 0; d < PD_DIM; d++) count *= x->cells[d];
    int fits = count <= SCENE_VOXELS / 2 && !x->mask.n[0];
    if (fits && (how == 9 || how == 10 || (PD_DIM == 1 && draw_chance(g, 0.1)))) {
        draw_voxels(g, low, high);
        s = scene_section(x, "shape", name);
        scene_voxels(x, s, draw_chance(g, 0.5));
    } else if (how < 8 && PD_DIM > 1) {
        static const char *const operations[] = {"union", "union", "union", "union", "union", "difference",
                                                 "intersect", "intersect"};
        snprintf(a, sizeof a, "%s_a", name);
        snprintf(b, sizeof b, "%s_b", name);
        s = scene_section(x, "shape", a);
        scene_section(x, "shape", b);
        if (how < 3) draw_two_boxes(g, s, low, high);
        else {
            draw_body(g, s, low, high);
            if (how == 7) draw_half_space(g, s + 1, low, high);
            else draw_body(g, s + 1, low, high);
        }
        entry *first = scene_find(x, s, "box");
        if (how >= 5 && how < 7) /* something is left */
            for (int d = 0; d < PD_DIM && first; d++) {
                first->low[d] = x->low[d] + low[d] * x->h[d];
                first->high[d] = x->low[d] + high[d] * x->h[d];
            }
        s = scene_section(x, "shape", name);
        scene_key(x, s, (how == 5 || how == 6) && !first ? "union" : operations[how], "%s, %s", a, b);
    } else {
        s = scene_section(x, "shape", name);
        draw_body(g, s, low, high);
    }
    scene_key(x, s, "kind", "solid");
    scene_key(x, s, "material", "%s", material);
    if (x->has & HAS_GRAINS) scene_key(x, s, "grain_size", "%q", g->grain * x->h[0], UNIT_LENGTH);
}

/* A bar from side to side, with a hole now and then; a loose one ends in the fluid. */
static void draw_bar(draw *g)
{
    scene *x = g->x;
    double a[3], b[3];
    int axis = g->holds, hole = PD_DIM > 1 && draw_chance(g, 0.4);
    for (int d = 0; d < PD_DIM; d++) {
        double n = x->cells[d], p = floor(draw_between(g, 0.0, 0.3) * n), q = ceil(draw_between(g, 0.7, 1.0) * n);
        a[d] = x->low[d] + x->h[d] * (d == axis ? 0.0 : p);
        b[d] = x->low[d] + x->h[d] * (d == axis ? (g->loose ? floor(0.75 * n) : n) : q);
    }
    int s = scene_section(x, "shape", hole ? "m0_a" : "m0");
    scene_box(x, s, "box", a, b);
    if (hole) {
        double low[3], high[3];
        for (int d = 0; d < PD_DIM; d++) {
            low[d] = 0.3 * x->cells[d];
            high[d] = 0.75 * x->cells[d];
        }
        draw_body(g, scene_section(x, "shape", "m0_b"), low, high);
        s = scene_section(x, "shape", "m0");
        scene_key(x, s, "difference", "m0_a, m0_b");
    }
    scene_key(x, s, "kind", "solid");
    scene_key(x, s, "material", "mg4ag");
    if (x->has & HAS_GRAINS) scene_key(x, s, "grain_size", "%q", g->grain * x->h[0], UNIT_LENGTH);
    g->metals = 1;
}

void generate_shapes(draw *g)
{
    scene *x = g->x;
    if (g->given) return;
    double low[3], high[3];
    int metal = x->has & (HAS_DISSOLVE | HAS_CORRODE | HAS_POTENTIAL | HAS_SOLID);
    int edge = draw_chance(g, 0.6) ? 1 : 0;
    for (int d = 0; d < PD_DIM; d++) {
        low[d] = edge;
        high[d] = x->cells[d] - edge;
    }
    if (x->has & HAS_AXIS) low[1] = 0.0;
    if (g->flow_axis >= 0) {
        double n = x->cells[g->flow_axis];
        low[g->flow_axis] = floor(0.25 * n);
        high[g->flow_axis] = ceil(0.7 * n);
        for (int d = 0; d < PD_DIM; d++)
            if (d != g->flow_axis) high[d] = low[d] + ceil(0.6 * (high[d] - low[d]));
    }
    if (x->has & HAS_SOLID) draw_bar(g);
    else if (metal) {
        int two = draw_chance(g, x->has & HAS_POTENTIAL ? 0.7 : 0.3);
        int one_metal =
            (x->has & (HAS_CHEMISTRY | HAS_DISSOLVE)) == (HAS_CHEMISTRY | HAS_DISSOLVE) && !(x->has & HAS_POTENTIAL);
        int axis = draw_whole(g, 0, PD_DIM - 1);
        double split = low[axis] + floor((high[axis] - low[axis]) * draw_between(g, 0.4, 0.6)), end = high[axis];
        int gap = draw_chance(g, 0.3) ? 0 : draw_chance(g, 0.5) ? 1 : 2;
        if (x->has & HAS_AXIS) axis = 0;
        if (two) high[axis] = split;
        draw_solid(g, "m0", "mg4ag", low, high);
        g->metals = 1;
        if (two) {
            low[axis] = split + gap;
            high[axis] = end;
            if (high[axis] - low[axis] < 2.0) low[axis] = high[axis] - 2.0;
            draw_solid(g, "m1", (draw_chance(g, 0.6) && !one_metal) || (x->has & HAS_POTENTIAL) ? "steel304" : "mg4ag",
                       low, high);
            g->metals = 2;
        }
    }
    if (draw_chance(g, metal ? 0.25 : 0.5) && !(x->has & HAS_SOLID)) {
        for (int d = 0; d < PD_DIM; d++) {
            low[d] = floor(draw_between(g, 0.0, 0.7) * x->cells[d]);
            high[d] = low[d] + 2.0 + floor(0.25 * x->cells[d]);
            if (high[d] > x->cells[d]) high[d] = x->cells[d];
        }
        if (PD_DIM > 1) {
            int s = scene_section(x, "shape", "w");
            draw_body(g, s, low, high);
            scene_key(x, s, "kind", "wall");
            if ((x->has & HAS_TRANSPORT) && !(x->has & HAS_CHEMISTRY) && draw_chance(g, 0.3))
                scene_key(x, s, "C", "%q", draw_between(g, 0.0, 500.0), UNIT_CONCENTRATION);
        }
    }
    if (x->has & HAS_MEDIUM) {
        for (int d = 0; d < PD_DIM; d++) {
            low[d] = 0.1 * x->cells[d];
            high[d] = 0.9 * x->cells[d];
        }
        int s = scene_section(x, "shape", "med");
        draw_body(g, s, low, high);
        scene_key(x, s, "kind", "medium");
        scene_key(x, s, "D", "%q", g->D * draw_decade(g, 0.1, 5.0), UNIT_DIFFUSIVITY);
    }
}

/* ---- sides ---- */

void generate_sides(draw *g)
{
    scene *x = g->x;
    int last = -1, found = 0; /* a side that holds species */
    int needs = (x->has & HAS_CHEMISTRY) != 0 || ((x->has & HAS_STEADY) && (x->has & HAS_TRANSPORT));
    for (int d = 0; d < PD_DIM; d++) {
        int held = (x->has & HAS_SOLID) && d == g->holds && !g->loose;
        if (d == g->flow_axis || held) continue;
        last = d;
    }
    for (int d = 0; d < PD_DIM; d++) {
        if (d == g->flow_axis) continue;
        int solid = (x->has & HAS_SOLID) != 0;
        g->periodic[d] = !solid && draw_chance(g, 0.2) && !(d == 1 && ((x->has & HAS_AXIS) || g->of == CLASS_RING)) &&
                         !(needs && d == last && g->flow_axis < 0);
        for (int plus = 0; plus < 2; plus++) {
            if (d == 1 && !plus && (x->has & HAS_AXIS)) continue;
            if (g->periodic[d]) {
                scene_key(x, scene_side(x, d, plus), "flow", "periodic");
                continue;
            }
            if (solid && d == g->holds && !(g->loose && plus)) continue;
            int held = needs && !found && d == last && plus; /* the last one that may */
            if (!held && draw_chance(g, 0.35) && !((x->has & HAS_AXIS) && d == 1) && !(x->has & HAS_CRACK) &&
                g->of != CLASS_RING) {
                scene_key(x, scene_side(x, d, plus), "flow", "mirror");
                continue;
            }
            if ((x->has & HAS_FLOW) && PD_DIM > 1 && !(x->has & HAS_AXIS) && !g->given && draw_chance(g, 0.15)) {
                int s = scene_side(x, d, plus);
                for (int k = 0; k < PD_DIM; k++)
                    scene_vector(x, s, "velocity", k, "%q",
                                 k == d ? 0.0 : draw_between(g, -1.0, 1.0) * g->D / x->h[k], UNIT_SPEED);
            }
            if ((x->has & HAS_CHEMISTRY) && (held || draw_chance(g, 0.35))) {
                scene_key(x, scene_side(x, d, plus), "species", "inlet");
                found = 1;
            } else if ((x->has & HAS_CORRODE) && !(x->has & HAS_FLOW) && draw_chance(g, 0.4)) {
                scene_key(x, scene_side(x, d, plus), "flow", "open");
            } else if ((x->has & HAS_TRANSPORT) && !(x->has & (HAS_CHEMISTRY | HAS_CORRODE)) &&
                       (held || draw_chance(g, 0.4))) {
                found++;
                int s = scene_side(x, d, plus);
                double C = draw_between(g, 0.0, 800.0);
                if (draw_chance(g, 0.6) || (x->has & HAS_STEADY)) scene_key(x, s, "C", "%q", C, UNIT_CONCENTRATION);
                else
                    scene_key(x, s, "C", "%q*(1 + 0.9*sin(%g*%p + t/%q))", C, UNIT_CONCENTRATION,
                              draw_between(g, 0.2, 0.5), (d + 1) % PD_DIM, x->time, UNIT_TIME);
            }
        }
    }
}

/* ---- flow ---- */

/* A given flow along its axis, from open side to open side. */
static void given_flow(draw *g)
{
    scene *x = g->x;
    int s = scene_section(x, "flow", ""), axis = g->flow_axis, other = (axis + 1) % PD_DIM;
    double speed = draw_between(g, 0.2, 6.0) * g->D / x->h[axis];
    scene_key(x, s, "rho", "%q", 1000.0, UNIT_DENSITY);
    scene_key(x, s, "mu", "%q", 1e-3, UNIT_VISCOSITY);
    scene_key(x, s, "time", "prescribed");
    scene_component(x, s, "v", axis, "%q*(1 + %g*sin(%g*%p))", draw_chance(g, 0.5) ? speed : -speed, UNIT_SPEED,
                    draw_between(g, 0.0, 0.9), draw_between(g, 0.2, 0.6), other);
    for (int plus = 0; plus < 2; plus++) {
        int side = scene_side(x, axis, plus);
        scene_key(x, side, "flow", "open");
        scene_key(x, side, "C", "%q", 200.0, UNIT_CONCENTRATION);
    }
}

void generate_flow(draw *g)
{
    if (g->given) {
        given_flow(g);
        return;
    }
    scene *x = g->x;
    int s = scene_section(x, "flow", ""), axis = g->flow_axis, plus = x->has & HAS_AXIS ? 1 : draw_whole(g, 0, 1);
    double speed = draw_between(g, 0.2, 3.0) * g->D / x->h[axis];
    double mu = 1e-3, rho = mu / (speed * g->length) * draw_decade(g, 0.01, 5.0);
    scene_key(x, s, "rho", "%q", rho, UNIT_DENSITY);
    scene_key(x, s, "mu", "%q", mu, UNIT_VISCOSITY);
    x->pressure = 1e-3 * mu * speed / x->h[axis];
    int in = scene_side(x, axis, !plus), out = scene_side(x, axis, plus);
    int in_time = x->until > 0.0 && draw_chance(g, 0.25);
    scene_key(x, in, "flow", "inlet");
    scene_key(x, out, "flow", "outlet");
    int other = (axis + 1) % PD_DIM;
    if (PD_DIM == 2 && g->of < CLASS_LATTICE && draw_chance(g, 0.4) && !g->periodic[other])
        scene_key(x, in, "profile", "parabola");
    else if (PD_DIM > 1 && draw_chance(g, 0.3)) {
        scene_key(x, in, "profile", "expression");
        scene_component(x, in, "v", axis, "%q*(1 + %g*sin(%g*%p))", plus ? speed : -speed, UNIT_SPEED,
                        draw_between(g, 0.0, 0.6), draw_between(g, 0.2, 0.6), other);
    } else scene_key(x, in, "profile", "uniform");
    entry *e = scene_find(x, in, "profile");
    if (strcmp(x->pool[e->first[0]].text, "expression") != 0) {
        if (in_time && draw_chance(g, 0.5))
            scene_key(x, in, "mean", "%q*(1 + 0.4*sin(t/%q))", speed, UNIT_SPEED, x->time, UNIT_TIME);
        else if (PD_DIM == 3 && draw_chance(g, 0.3))
            scene_key(x, in, "flow_rate", "%q", speed * 10.0 * x->h[0] * x->h[0], UNIT_FLOW_RATE);
        else scene_key(x, in, "mean", "%q", speed, UNIT_SPEED);
    }
    if (draw_chance(g, 0.15)) scene_key(x, out, "p", "%q", 5.0 * mu * speed / x->h[axis], UNIT_PRESSURE);
    if ((x->has & HAS_TRANSPORT) && !(x->has & HAS_CHEMISTRY) && draw_chance(g, 0.7))
        scene_key(x, in, "C", "%q", draw_between(g, 0.0, 400.0), UNIT_CONCENTRATION);
    if (in_time && draw_chance(g, 0.6)) {
        scene_key(x, s, "time", "implicit");
        x->has |= HAS_FLOW_IN_TIME;
        if (draw_exact(g)) scene_key(x, s, "rtol", "0.1");
    } else scene_key(x, s, "steady_tolerance", g->of != CLASS_TOLERANCE ? "1e-10" : "1e-6");
    if (draw_chance(g, 0.15))
        scene_vector(x, s, "body_force", 0, "%q", 0.1 * speed * mu / (rho * g->length * g->length), UNIT_ACCELERATION);
    entry *force = scene_find(x, s, "body_force");
    for (int d = 1; d < PD_DIM && force; d++) scene_vector(x, s, "body_force", d, "%q", 0.0, UNIT_ACCELERATION);
}

/* ---- transport and metal ---- */

void generate_transport(draw *g)
{
    scene *x = g->x;
    int s = scene_section(x, "transport", "");
    scene_key(x, s, "D", "%q", g->D, UNIT_DIFFUSIVITY);
    if ((x->has & HAS_CHEMISTRY)) return;
    if (draw_chance(g, 0.5) && !(x->has & HAS_STEADY))
        scene_key(x, s, "initial", "%q*(1 + 0.8*sin(%g*%p))", draw_between(g, 10.0, 500.0), UNIT_CONCENTRATION,
                  draw_between(g, 0.2, 1.0), draw_whole(g, 0, PD_DIM - 1));
    if (draw_chance(g, 0.3)) scene_key(x, s, "advection", "upwind");
    else if (g->flow_axis >= 0) x->has |= HAS_LIMITED;
    if (x->has & HAS_STEADY) scene_key(x, s, "time", "steady");
}

/* A law: a size, and factors of place, time, concentration. */
static void draw_law(draw *g, int s, const char *key, double size, unit of, const char *more)
{
    scene *x = g->x;
    int axis = draw_whole(g, 0, PD_DIM - 1);
    double wave = draw_between(g, 0.2, 0.6);
    if (g->of == CLASS_TOLERANCE && draw_chance(g, 0.3)) { /* what steps may not see */
        if (draw_chance(g, 0.5))
            scene_key(x, s, key, "%q*(0.2 + if(abs(t/%q - %g) < %g, 10, 0))%s", size, of, x->until, UNIT_TIME,
                      draw_between(g, 0.2, 0.8), draw_decade(g, 1e-3, 0.05), more);
        else
            scene_key(x, s, key, "%q*(1 + sin(%g*t/%q))%s", size, of, draw_decade(g, 5.0, 300.0), x->until, UNIT_TIME,
                      more);
        return;
    }
    switch (draw_whole(g, 0, 3)) {
    case 0: scene_key(x, s, key, "%q*(1 + 0.5*sin(%g*%p))%s", size, of, wave, axis, more); break;
    case 1: scene_key(x, s, key, "%q*(1 + 0.3*sin(t/%q))%s", size, of, x->time, UNIT_TIME, more); break;
    default: scene_key(x, s, key, "%q%s", size, of, more); break;
    }
}

void generate_metal(draw *g)
{
    scene *x = g->x;
    double speed = draw_between(g, 0.1, 1.6) * x->h[0] / x->until;
    int current =
        (x->has & HAS_POTENTIAL) && !(x->has & HAS_MIGRATION) && (draw_chance(g, 0.6) || (x->has & HAS_CHEMISTRY));
    int s = scene_section(x, x->has & HAS_CORRODE ? "corrode" : "dissolve", "");
    char more[96] = "";
    double Csat = draw_decade(g, 50.0, 6000.0);
    if ((x->has & HAS_CORRODE) && Csat < 1000.0) Csat = 5100.0;
    if (x->has & HAS_STATE) snprintf(more, sizeof more, "*(1 - 0.8*theta)");
    if ((x->has & HAS_MIGRATION) && (x->has & HAS_POTENTIAL) && g->metals == 2) {
        s = scene_section(x, "dissolve", "mg4ag");
        scene_key(x, s, "current", "%q*10^((E + %q)/%q)%s", draw_decade(g, 0.05, 2.0) * 1e-6 / x->h[0],
                  UNIT_CURRENT_DENSITY, draw_between(g, -0.05, 0.05), UNIT_VOLT, draw_between(g, 0.06, 0.15), UNIT_VOLT,
                  more);
        scene_key(x, s, "reaction", "Mg = Mg2+ + 2 e-");
        s = scene_section(x, "dissolve", "steel304");
        scene_key(x, s, "rate", "0");
        s -= 2;
    } else if (x->has & HAS_MIGRATION) {
        double i = draw_decade(g, 0.05, 2.0) * 1e-3 / x->h[0] * 1e-3;
        if (!(x->has & HAS_POTENTIAL)) x->current = i;
        scene_key(x, s, "current", "%q*10^((E + %q)/%q)%s", i, UNIT_CURRENT_DENSITY, draw_between(g, -0.05, 0.05),
                  UNIT_VOLT, draw_between(g, 0.06, 0.15), UNIT_VOLT, more);
        scene_key(x, s, "charge", "2");
        scene_key(x, s, "reaction", "Mg = Mg2+ + 2 e-");
        if (!(x->has & HAS_POTENTIAL)) scene_key(x, s, "potential", "%q", draw_between(g, -0.05, 0.1), UNIT_VOLT);
    } else if (current) {
        scene_key(x, s, "current", "i");
    } else if (x->has & HAS_CHEMISTRY) {
        if (draw_chance(g, 0.5)) snprintf(more + strlen(more), sizeof more - strlen(more), "*10^(0.1*(7 - pH))");
        draw_law(g, s, "rate", speed, UNIT_SPEED, more);
        scene_key(x, s, "reaction", "Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)");
    } else {
        int saturates = draw_chance(g, 0.6);
        if (saturates) snprintf(more + strlen(more), sizeof more - strlen(more), "*(1 - C/Csat)");
        draw_law(g, s, "rate", speed, UNIT_SPEED, more);
        if (saturates && !(x->has & HAS_CORRODE)) scene_key(x, s, "Csat", "%q", Csat, UNIT_CONCENTRATION);
    }
    if (x->has & HAS_CORRODE) {
        scene_key(x, s, "Csat", "%q", Csat, UNIT_CONCENTRATION);
        if (!(x->has & HAS_FLOW)) {
            scene_key(x, s, "D", "%q", g->D, UNIT_DIFFUSIVITY);
            if (draw_chance(g, 0.3)) scene_key(x, s, "bulk", "%q", 0.2 * Csat, UNIT_CONCENTRATION);
        }
        if (draw_chance(g, 0.3)) scene_key(x, s, "kernel", draw_chance(g, 0.5) ? "square" : "inverse");
        if (draw_chance(g, 0.5)) scene_key(x, s, "m", "%i", draw_whole(g, 2, 3));
    } else {
        if (draw_chance(g, 0.25)) scene_key(x, s, "threshold", "%g", draw_between(g, 0.05, 0.4));
        if (draw_chance(g, 0.4)) {
            int m = draw_whole(g, 2, 4);
            scene_key(x, s, "m", "%i", m < (int)ceil(g->m) ? (int)ceil(g->m) : m);
        }
    }
    if ((x->has & HAS_GRAINS) && draw_chance(g, 0.7))
        scene_key(x, s, "grain_boundary_factor", "%g", draw_between(g, 1.5, 8.0));
    if (x->has & HAS_RANDOM) {
        scene_key(x, s, "breaking", "stochastic");
        scene_key(x, s, "seed", "%i", draw_whole(g, 1, 1000));
    }
}

/* ---- all ---- */

static const double D_OF_IONS = 1.5e-9; /* [m2/s] */
static const double WAVES = 5000.0;     /* [m/s] speed of sound in the metal */

static void draw_grid(draw *g, int equal)
{
    static const int low[3] = {12, 8, 5}, high[3] = {36, 16, 7};
    scene *x = g->x;
    /* A solid in 3D takes most of the time of a scene: bonds and iterations of each step. */
    int small = PD_DIM == 3 && (x->has & HAS_SOLID), most = small ? low[PD_DIM - 1] : high[PD_DIM - 1];
    double h = draw_decade(g, 1e-6, 4e-4);
    for (int d = 0; d < PD_DIM; d++) {
        x->cells[d] = draw_whole(g, low[PD_DIM - 1], most);
        x->h[d] = h;
    }
    if (x->has & HAS_SOLID) { /* rows that the sides hold, and some between */
        int least = g->loose ? (8 * g->solid_m + 20) / 3 : 4 * g->solid_m + 4;
        if (x->cells[g->holds] < least) x->cells[g->holds] = least;
    }
    if (!equal)
        for (int d = 1; d < PD_DIM; d++) x->h[d] = h * draw_between(g, 0.6, 1.7);
    if (draw_chance(g, 0.4))
        for (int d = 0; d < PD_DIM; d++) x->low[d] = -draw_whole(g, 1, x->cells[d]) * x->h[d];
    if (x->has & HAS_AXIS) x->low[1] = 0.0;
    g->length = 3.0 * h;
}

static void write_grid(draw *g)
{
    scene *x = g->x;
    double high[3], m = draw_chance(g, 0.5) ? 1.0 : draw_chance(g, 0.6) ? 2.0 : draw_chance(g, 0.5) ? 3.0 : 1.5;
    int s = x->grid, unequal = 0;
    for (int d = 0; d < PD_DIM; d++) {
        high[d] = x->low[d] + x->cells[d] * x->h[d];
        unequal |= x->h[d] < x->h[0] || x->h[d] > x->h[0];
    }
    if (unequal) scene_sizes(x, s, "h", x->h);
    else scene_key(x, s, "h", "%q", x->h[0], UNIT_LENGTH);
    if ((x->has & HAS_FLOW) || PD_DIM == 3) m = m > 2.0 ? 2.0 : m;
    if (PD_DIM == 3 && (x->has & HAS_CHEMISTRY)) m = 1.0;
    g->m = 1.0;
    if (draw_chance(g, 0.8)) {
        scene_key(x, s, "m", "%g", m);
        g->m = m;
    }
    scene_box(x, s, "box", x->low, high);
    if (x->has & HAS_AXIS) scene_key(x, s, "geometry", "axisymmetric");
}

/* Metal alone: at rest, with cracks, in motion. */
static uint32_t draw_metal_alone(draw *g)
{
    uint32_t has = HAS_SOLID | (draw_chance(g, 0.35) ? HAS_MOTION : HAS_STEADY);
    if (draw_chance(g, 0.4)) has |= HAS_CRACK;
    if (draw_chance(g, has & HAS_MOTION ? 0.6 : 0.2)) has |= HAS_SPRINGS;
    return has;
}

/* Which physics a scene has: three of them in more than half of the scenes. */
static uint32_t draw_physics(draw *g)
{
    double kind = draw_fraction(g);
    uint32_t has = 0;
    if (kind < 0.05) return HAS_POTENTIAL | HAS_STEADY;
    if (kind < 0.12) return draw_metal_alone(g);
    if (kind < 0.15) return HAS_GAS;
    if (kind < 0.19 && PD_DIM > 1) return HAS_FLOW | HAS_STEADY;
    if (kind < 0.24)
        return HAS_TRANSPORT | HAS_STEADY | (PD_DIM > 1 && draw_chance(g, 0.7) ? HAS_FLOW : 0) |
               (draw_chance(g, 0.5) ? HAS_MEDIUM : 0);
    if (kind < 0.33) {
        has = HAS_CORRODE;
        if (PD_DIM > 1 && draw_chance(g, 0.45)) has |= HAS_FLOW | HAS_TRANSPORT;
        if (draw_chance(g, 0.4)) has |= HAS_SOLID;
        if (draw_chance(g, 0.35)) has |= HAS_GRAINS;
        if (draw_chance(g, 0.15) && !(has & HAS_SOLID)) has |= HAS_RANDOM;
        return has;
    }
    has = HAS_TRANSPORT;
    if (draw_chance(g, 0.93)) has |= HAS_DISSOLVE;
    if (draw_chance(g, 0.4) && PD_DIM > 1) has |= HAS_FLOW;
    if (draw_chance(g, PD_DIM == 1 ? 0.65 : 0.55)) {
        has |= HAS_CHEMISTRY;
        if (draw_chance(g, 0.45)) has |= HAS_MINERAL;
        if ((has & HAS_DISSOLVE) && draw_chance(g, 0.3)) has |= HAS_STATE;
        if (draw_chance(g, 0.35)) has |= HAS_MIGRATION;
    } else if (draw_chance(g, 0.35)) has |= HAS_MEDIUM;
    if ((has & HAS_DISSOLVE) && draw_chance(g, 0.35)) has |= HAS_POTENTIAL;
    if ((has & HAS_DISSOLVE) && draw_chance(g, 0.25)) has |= HAS_SOLID;
    if ((has & HAS_DISSOLVE) && draw_chance(g, 0.15)) has |= HAS_GRAINS;
    return has;
}

static void write_run(draw *g)
{
    scene *x = g->x;
    if (!(x->until > 0.0)) return;
    int s = scene_section(x, "run", "");
    scene_key(x, s, "until", "%q", x->until, UNIT_TIME);
    if (x->has & HAS_MOTION) return; /* its steps are those that are stable */
    if (g->of != CLASS_TOLERANCE) {
        scene_key(x, s, "rtol", "0.1");
        scene_key(x, s, "max_step", "%q", x->until / draw_whole(g, 4, 9), UNIT_TIME);
        if (x->has & (HAS_DISSOLVE | HAS_CORRODE)) scene_key(x, s, "max_dissolved_fraction", "1");
    }
    if (g->of == CLASS_TOLERANCE) {
        x->rtol = x->has & (HAS_DISSOLVE) ? 4e-3 : 1e-3; /* what they are without the key */
        scene_key(x, s, "rtol", "%q", x->rtol, UNIT_ONE);
    }
    s = scene_section(x, "output", "");
    scene_key(x, s, "every", "%q", 0.5 * x->until, UNIT_TIME);
}

static void write_watches(draw *g)
{
    scene *x = g->x;
    double at[3];
    if (x->has & HAS_GAS) return;
    if (x->has & HAS_MOTION) {
        scene_section(x, "total", "all");
        return;
    }
    if (draw_chance(g, 0.7)) scene_section(x, "total", "all");
    if ((x->has & (HAS_TRANSPORT | HAS_FLOW)) && draw_chance(g, 0.4)) {
        int axis = draw_whole(g, 0, PD_DIM - 1);
        scene_plane(x, scene_section(x, "plane", "cut"), "at", axis,
                    x->low[axis] + draw_whole(g, 1, x->cells[axis] - 1) * x->h[axis]);
    }
    if (g->flow_axis >= 0 && draw_chance(g, 0.5)) {
        int d = g->flow_axis;
        scene_plane(x, scene_section(x, "plane", "up"), "at", d, x->low[d] + x->h[d]);
        scene_plane(x, scene_section(x, "plane", "down"), "at", d, x->low[d] + (x->cells[d] - 1) * x->h[d]);
    }
    if ((x->has & HAS_TRANSPORT) && !(x->has & HAS_CHEMISTRY) && draw_chance(g, 0.3)) {
        int s = scene_section(x, "transfer", "here");
        if (draw_chance(g, 0.5)) scene_axis(x, s, "along", draw_whole(g, 0, PD_DIM - 1));
    }
    if (draw_chance(g, 0.3)) {
        for (int d = 0; d < PD_DIM; d++) at[d] = x->low[d] + draw_between(g, 0.05, 0.95) * x->cells[d] * x->h[d];
        int bare = !(x->has & (HAS_TRANSPORT | HAS_CORRODE | HAS_FLOW));
        if (bare && draw_chance(g, 0.9)) return;
        if (!bare && draw_chance(g, 0.5)) return; /* it may stand in a wall, which is refused */
        int s = scene_section(x, "probe", "here");
        scene_point(x, s, "at", at);
        if (bare && draw_chance(g, 0.5)) scene_key(x, s, "fields", "%s", x->has & HAS_POTENTIAL ? "phi" : "u");
    }
}

void generate_scene(uint32_t seed, scene_class of, double through, scene *x)
{
    draw g;
    memset(&g, 0, sizeof g);
    scene_begin(x);
    g.x = x;
    g.state = seed * 2654435761u + 12345u;
    g.of = of;
    x->first_order = seed % 2;
    g.through = through;
    g.grain = draw_between(&g, 2.5, 5.0);
    g.flow_axis = -1;
    x->has = draw_physics(&g);
    /* Speeds of fronts and bonds of metal are those of their lattice at any h: not what two lattices have in common. */
    const uint32_t of_lattice = HAS_DISSOLVE | HAS_CORRODE | HAS_SOLID | HAS_STATE | HAS_MINERAL | HAS_MIGRATION |
                                HAS_CRACK | HAS_GRAINS | HAS_RANDOM | HAS_MOTION | HAS_SPRINGS;
    if (of == CLASS_LATTICE) x->has &= ~of_lattice;
    if (of == CLASS_LATTICE && !(x->has & (HAS_POTENTIAL | HAS_TRANSPORT | HAS_GAS | HAS_FLOW))) x->has = HAS_TRANSPORT;
    if (of == CLASS_LATTICE && (x->has & HAS_POTENTIAL)) x->has = HAS_POTENTIAL | HAS_STEADY;
    if (of == CLASS_RING && (x->has & (HAS_GAS | HAS_GRAINS | HAS_RANDOM))) x->has = HAS_TRANSPORT | HAS_DISSOLVE;
    if (of == CLASS_RING && (x->has & HAS_SOLID)) /* it is refused around an axis */
        x->has = x->has & (HAS_TRANSPORT | HAS_CORRODE)
                     ? x->has & ~(uint32_t)HAS_SOLID
                     : (uint32_t)(HAS_TRANSPORT | HAS_DISSOLVE | HAS_CHEMISTRY | HAS_MINERAL);
    if (of == CLASS_RING && (x->has & HAS_FLOW)) x->has &= ~of_lattice; /* the flow is that of the lattice, too */
    if (PD_DIM == 2 && of < CLASS_LATTICE && !(x->has & (HAS_SOLID | HAS_GAS)) && draw_chance(&g, 0.12))
        x->has |= HAS_AXIS;
    if (x->has & HAS_SOLID) {
        int wet = (x->has & (HAS_TRANSPORT | HAS_CORRODE)) != 0;
        g.holds = draw_whole(&g, 0, PD_DIM - 1);
        if (of == CLASS_RING) g.holds = 0;
        g.loose = (PD_DIM == 1 && wet) || draw_chance(&g, 0.3);
        g.solid_m = x->has & HAS_SPRINGS ? 3 : draw_whole(&g, 2, PD_DIM == 3 ? 2 : 3);
    }
    draw_grid(&g, (x->has & (HAS_SOLID | HAS_CORRODE | HAS_GRAINS)) || draw_chance(&g, 0.7));
    g.D = x->has & HAS_CHEMISTRY ? D_OF_IONS : draw_decade(&g, 1e-11, 1e-8);
    x->D = g.D;
    x->time = g.length * g.length / g.D * draw_decade(&g, 0.3, 3.0);
    if (x->has & HAS_MOTION) x->time = x->cells[g.holds] * x->h[0] / WAVES;
    if (!(x->has & HAS_STEADY)) x->until = x->time * draw_decade(&g, 0.3, 3.0);
    x->grid = scene_section(x, "grid", "");
    write_grid(&g);
    if (x->has & HAS_FLOW) {
        g.flow_axis = (x->has & HAS_AXIS) || of == CLASS_RING ? 0 : draw_whole(&g, 0, PD_DIM - 1);
        if (x->has & HAS_SOLID) g.flow_axis = PD_DIM > 1 ? (g.holds + 1) % PD_DIM : -1;
    }
    if (x->has & HAS_GAS) {
        generate_gas(&g);
        return;
    }
    uint32_t stands = HAS_DISSOLVE | HAS_CORRODE | HAS_POTENTIAL | HAS_SOLID | HAS_MEDIUM | HAS_CHEMISTRY | HAS_AXIS;
    g.given = (x->has & HAS_FLOW) && (x->has & HAS_TRANSPORT) && !(x->has & stands) && draw_chance(&g, 0.4);
    generate_shapes(&g);
    generate_sides(&g);
    if (x->has & HAS_CHEMISTRY) generate_chemistry(&g);
    if (x->has & HAS_FLOW) generate_flow(&g);
    if (x->has & HAS_TRANSPORT) generate_transport(&g);
    if (x->has & (HAS_DISSOLVE | HAS_CORRODE)) generate_metal(&g);
    if (x->has & HAS_POTENTIAL) generate_potential(&g);
    if (x->has & HAS_SOLID) generate_solid(&g);
    write_run(&g);
    write_watches(&g);
}
