/* physics: species, electrodes, solids and gas of random scenes; see generate.h */
#include "generate.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static void draw_species(draw *g, const char *name, double D, double initial, double inlet)
{
    scene *x = g->x;
    int s = scene_section(x, "species", name);
    scene_key(x, s, "D", "%q", D, UNIT_DIFFUSIVITY);
    if (initial > 0.0) scene_key(x, s, "initial", "%q", initial, UNIT_CONCENTRATION);
    if (inlet > 0.0) scene_key(x, s, "inlet", "%q", inlet, UNIT_CONCENTRATION);
}

void generate_chemistry(draw *g)
{
    scene *x = g->x;
    int c = scene_section(x, "chemistry", ""), s;
    double salt = draw_decade(g, 1.0, 150.0), enters = draw_chance(g, 0.5) ? salt * draw_between(g, 0.3, 2.0) : salt;
    double drop = draw_chance(g, 0.25) ? salt * draw_between(g, 0.3, 3.0) : 0.0;
    /* Diffusivities in proportion to the length squared over the time, so that any spacing will do. */
    double size = g->D / 1.5e-9;
    /* Davies' equation ends at 500 mol/m3. Metal makes ten times as much, but where a mineral takes it up at once and
     * never fills its room. */
    int metal = (x->has & HAS_DISSOLVE) != 0, dilute = !metal || (x->has & HAS_MINERAL);
    int davies = !draw_chance(g, 0.5) && dilute;
    scene_key(x, c, "activity", davies ? "davies" : "ideal");
    if (x->has & HAS_MIGRATION) scene_key(x, c, "migration", "yes");
    if ((x->has & HAS_MINERAL) && (x->has & HAS_DISSOLVE) && !(x->has & (HAS_POTENTIAL | HAS_MIGRATION)) &&
        draw_chance(g, 0.3))
        scene_key(x, c, "covering_thickness", "%q", draw_between(g, 0.02, 1.0) * x->h[0], UNIT_LENGTH);
    if ((x->has & HAS_MINERAL) && draw_chance(g, 0.3)) scene_key(x, c, "tortuosity", "%g", draw_between(g, 1.0, 3.0));
    draw_species(g, "H+", 9.31e-9 * size, 1e-4, 1e-4);
    draw_species(g, "OH-", 5.27e-9 * size, 1e-4, 1e-4);
    draw_species(g, "Na+", 1.33e-9 * size, salt, enters);
    draw_species(g, "Cl-", 2.03e-9 * size, salt, enters);
    if (drop > 0.0) {
        for (int k = x->sections - 2; k < x->sections; k++) scene_key(x, k, "inside", "%q", drop, UNIT_CONCENTRATION);
        double low[3], high[3];
        s = scene_section(x, "shape", "drop");
        for (int d = 0; d < PD_DIM; d++) {
            low[d] = x->low[d] + floor(draw_between(g, 0.1, 0.5) * x->cells[d]) * x->h[d];
            high[d] = low[d] + floor(0.4 * x->cells[d] + 1.0) * x->h[d];
        }
        scene_box(x, s, "box", low, high);
        scene_key(x, s, "kind", "solution");
    }
    draw_species(g, "Mg2+", 7.05e-10 * size, 0.0, 0.0);
    if (x->has & (HAS_POTENTIAL | HAS_MIGRATION)) draw_species(g, "O2", 2.0e-9 * size, 0.25, 0.25);
    s = scene_section(x, "reaction", "water");
    if (draw_chance(g, 0.93)) scene_key(x, s, "=", "H2O = H+ + OH-   log10_K = -14");
    else
        scene_key(x, s, "=", "H+ + OH- = H2O   K = 1e14 L2/mol2   forward = %q", 1.4e8 * draw_decade(g, 1e-6, 1.0),
                  UNIT_SECOND_ORDER);
    if (draw_chance(g, 0.25)) {
        draw_species(g, "MgOH+", 7.05e-10 * size, 0.0, 0.0);
        s = scene_section(x, "reaction", "pair");
        scene_key(x, s, "=", "Mg2+ + OH- = MgOH+   log10_K = 2.6");
    }
    if (x->has & HAS_MINERAL) {
        s = scene_section(x, "species", "Mg(OH)2(s)");
        if (draw_chance(g, 0.7) && !(davies && metal)) scene_key(x, s, "volume", "%q", 24.63e-6, UNIT_MOLAR_VOLUME);
        s = scene_section(x, "reaction", "brucite");
        scene_key(x, s, "=", "Mg(OH)2(s) + 2 H+ = Mg2+ + 2 H2O   log10_K = 16.84");
        s = scene_section(x, "mineral", "Mg(OH)2(s)");
        if (draw_chance(g, 0.5) && !(davies && metal)) {
            double area = 0.1 / x->h[0];
            scene_key(x, s, "rate", "%q", draw_decade(g, 0.01, 1.0) / (area * x->time), UNIT_GROWTH);
            scene_key(x, s, "area", "%q", area, UNIT_SPECIFIC);
        }
        if (draw_chance(g, 0.4)) scene_key(x, s, "nucleation", "%g", draw_between(g, 0.0, 1.0));
    }
    if (x->has & HAS_STATE) {
        s = scene_section(x, "surface", "theta");
        scene_key(x, s, "initial", "0.05 + 0.02*sin(0.3*%p)", draw_whole(g, 0, PD_DIM - 1));
        scene_key(x, s, "max", "1");
        scene_key(x, s, "min", "0");
        scene_key(x, s, "rate", "(1 - theta)*[Mg2+]/(%q + [Mg2+])/%q", STATE_HALF, UNIT_CONCENTRATION, x->time,
                  UNIT_TIME);
    }
}

void generate_potential(draw *g)
{
    scene *x = g->x;
    int migrates = (x->has & HAS_MIGRATION) != 0, ions = (x->has & HAS_CHEMISTRY) != 0;
    int s = scene_section(x, "potential", "");
    double conductivity = draw_decade(g, 0.1, 10.0);
    /* Currents that take about a cell of metal in the time: i = z F Cs h/until, else a voltage over the cell. */
    double i = x->until > 0.0 ? 2.0 * 96485.0 * 7e4 * x->h[0] / x->until * draw_decade(g, 0.1, 1.0) : 0.0;
    double ohmic = conductivity * 0.1 / (4.0 * x->h[0]);
    if (!(i > 0.0)) i = ohmic * draw_decade(g, 0.01, 3.0);
    if (migrates) i = draw_decade(g, 0.05, 2.0) * 1e-3 / x->h[0] * 1e-3;
    else
        scene_key(x, s, "conductivity", "%q",
                  migrates              ? 1.0
                  : draw_chance(g, 0.5) ? i * 4.0 * x->h[0] / 0.1
                                        : conductivity,
                  UNIT_CONDUCTIVITY);
    x->current = i;
    for (int k = 0; k < g->metals; k++) {
        char name[16];
        snprintf(name, sizeof name, "m%d", k);
        s = scene_section(x, "electrode", name);
        scene_key(x, s, "shape", "%s", name);
        double E0 = k ? draw_between(g, -0.2, 0.1) : draw_between(g, -0.6, -0.3);
        int curve = draw_whole(g, 0, 2);
        if (migrates) {
            scene_key(x, s, "curve", "expression");
            scene_key(x, s, "i", "-%q*[O2]/%q*10^(-(E + %q)/%q)", i, UNIT_CURRENT_DENSITY, 0.25, UNIT_CONCENTRATION,
                      -E0, UNIT_VOLT, draw_between(g, 0.1, 0.15), UNIT_VOLT);
            scene_key(x, s, "reaction", "O2 + 2 H2O + 4 e- = 4 OH-");
            if (k) scene_key(x, s, "connected", "m0"); /* it has no anodic current of its own */
            continue;
        }
        if (curve == 0) {
            scene_key(x, s, "curve", "linear");
            scene_key(x, s, "polarisation_resistance", "%q", draw_decade(g, 0.01, 1.0) / i, UNIT_RESISTANCE);
        } else {
            scene_key(x, s, "curve", "butler_volmer");
            scene_key(x, s, "i0", "%q", 0.3 * i, UNIT_CURRENT_DENSITY);
            scene_key(x, s, "anodic_slope", "%q", draw_between(g, 0.06, 0.15), UNIT_VOLT);
            scene_key(x, s, "cathodic_slope", "%q", draw_between(g, 0.08, 0.16), UNIT_VOLT);
            if (draw_chance(g, 0.4)) scene_key(x, s, "cathodic_limit", "%q", 3.0 * i, UNIT_CURRENT_DENSITY);
            if (draw_chance(g, 0.3)) scene_key(x, s, "film_resistance", "%q", 0.01 / i, UNIT_RESISTANCE);
        }
        scene_key(x, s, "E0", "%q", E0, UNIT_VOLT);
        if (draw_chance(g, 0.6) && !ions)
            scene_key(x, s, "potential", "%q", E0 + (k ? 0.0 : draw_between(g, 0.0, 0.15)), UNIT_VOLT);
        else if (k && draw_chance(g, 0.3)) scene_key(x, s, "connected", "m0");
        if (ions) scene_key(x, s, "reaction", k ? "2 H2O + 2 e- = H2(g) + 2 OH-" : "Mg = Mg2+ + 2 e-");
    }
    int held = 0;
    for (int d = 0; d < PD_DIM && !migrates; d++)
        for (int plus = 0; plus < 2; plus++) {
            if (g->periodic[d] || (d == 1 && !plus && (x->has & HAS_AXIS))) continue;
            if ((x->has & HAS_SOLID) && d == g->holds && !(g->loose && plus)) continue;
            int side = scene_side(x, d, plus), needs = !held && d == PD_DIM - 1 && plus && g->metals < 2;
            entry *flow = scene_find(x, side, "flow");
            int may = !flow || (strcmp(x->pool[flow->first[0]].text, "inlet") == 0 && !(x->has & HAS_CHEMISTRY));
            if ((needs || draw_chance(g, 0.3)) && may && !scene_find(x, side, "species") && ++held)
                scene_key(x, side, "potential", "%q", draw_between(g, -0.6, 0.1), UNIT_VOLT);
        }
}

/* From a free side of the bar into it, between two rows of nodes or across them. */
static void draw_cut(draw *g)
{
    scene *x = g->x;
    int axis = g->holds, across = (axis + 1) % PD_DIM, s = scene_section(x, "crack", "c"),
        slanted = draw_chance(g, 0.4);
    double n = x->cells[axis], place = floor(n * draw_between(g, 0.35, 0.65)), at[3] = {0.0, 0.0, 0.0};
    double depth = x->cells[across] * draw_between(g, 0.35, 0.6);
    at[axis] = x->low[axis] + place * x->h[axis];
    if (PD_DIM == 1) {
        scene_corner(x, s, "points", at);
        return;
    }
    double tilt = slanted ? draw_between(g, -1.3, 1.3) * x->h[axis] : 0.0;
    int third = 3 - axis - across;
    for (int k = 0; k < (PD_DIM == 2 ? 2 : 4); k++) {
        int deep = k == 1 || k == 2, far = k >= 2;
        at[axis] = x->low[axis] + place * x->h[axis] + (deep ? tilt : 0.0);
        at[across] = x->low[across] + (deep ? depth * x->h[across] : 0.0);
        if (PD_DIM == 3) at[third] = x->low[third] + (far ? x->cells[third] * x->h[third] : 0.0);
        scene_corner(x, s, "points", at);
    }
}

/* A ball of metal that is held where it is, or moved. */
static void draw_grip(draw *g, const char *name, double place, double size)
{
    scene *x = g->x;
    int axis = g->holds, s = scene_section(x, "shape", name);
    double at[3];
    for (int d = 0; d < PD_DIM; d++)
        at[d] = x->low[d] + x->h[d] * (d == axis ? place * x->cells[axis] : floor(0.5 * x->cells[d]) + 0.37);
    scene_point(x, s, "ball", at);
    scene_key(x, s, "radius", "%q", 1.8 * x->h[0], UNIT_LENGTH);
    scene_key(x, s, "kind", "grip");
    x->moved = fmax(x->moved, fabs(size));
    for (int d = 0; d < PD_DIM; d++)
        if (d == axis || draw_chance(g, 0.6))
            scene_component(x, s, "u", d, "%q",
                            d == axis || draw_chance(g, 0.5) ? size * draw_between(g, 0.3, 1.0) : 0.0, UNIT_LENGTH);
}

/* What pulls at the end of a bar. */
static void draw_load(draw *g, int alone)
{
    scene *x = g->x;
    int axis = g->holds, high = g->loose ? -1 : scene_side(x, axis, 1), shear = PD_DIM > 1 ? (axis + 1) % PD_DIM : axis;
    double length = x->cells[axis] * x->h[axis], stretch = draw_between(g, -1e-3, 2e-3) * length;
    int how = g->loose ? 3 + draw_whole(g, 0, 1) : draw_whole(g, 0, 3), in_time = !alone || (x->has & HAS_MOTION) != 0;
    if (how == 0) {
        x->moved = fmax(x->moved, fmax(fabs(stretch), 0.01 * x->h[axis]));
        if (in_time && draw_chance(g, 0.5))
            scene_component(x, high, "u", axis, "%q*t/%q", stretch, UNIT_LENGTH, x->until, UNIT_TIME);
        else scene_component(x, high, "u", axis, "%q", stretch, UNIT_LENGTH);
        if (PD_DIM > 1 && draw_chance(g, 0.5))
            scene_component(x, high, "u", shear, "%q", 0.01 * x->h[axis], UNIT_LENGTH);
    } else if (how == 1) {
        for (int d = 0; d < PD_DIM; d++)
            scene_vector(x, high, "traction", d, "%q",
                         d == axis || draw_chance(g, 0.4) ? draw_between(g, -1e7, 5e7) : 0.0, UNIT_PRESSURE);
    } else if (how == 2) {
        if (PD_DIM > 1 && draw_chance(g, 0.5))
            scene_key(x, high, "pressure", "%q*(1 + 0.5*sin(0.3*%p))", draw_between(g, -2e7, 2e7), UNIT_PRESSURE,
                      shear);
        else scene_key(x, high, "pressure", "%q", draw_between(g, -2e7, 2e7), UNIT_PRESSURE);
    } else if (how == 3) draw_grip(g, "pulls", g->loose ? 0.7 : 0.8, stretch);
    else {
        int s = -1;
        for (int k = 0; k < x->sections; k++)
            if (strcmp(x->part[k].name, "solid") == 0) s = k;
        for (int d = 0; d < PD_DIM; d++)
            scene_vector(x, s, "body_force", d, "%q*(1 + 0.2*sin(0.4*%p))", draw_between(g, -1e7, 2e7) / length,
                         UNIT_FORCE, axis);
    }
}

void generate_solid(draw *g)
{
    scene *x = g->x;
    int s = scene_section(x, "solid", ""), alone = !(x->has & (HAS_TRANSPORT | HAS_CORRODE)), axis = g->holds;
    static const char *const materials[] = {"correspondence", "ordinary", "neo_hookean", "hencky", "bond_based"};
    int springs = (x->has & HAS_SPRINGS) != 0, rests = alone && !(x->has & HAS_MOTION);
    int material = springs ? 4 : rests ? draw_whole(g, 0, 3) : draw_whole(g, 0, 1);
    double E = 45e9;
    scene_key(x, s, "E", "%q", E, UNIT_PRESSURE);
    int stress = PD_DIM == 2 && draw_chance(g, 0.3) && g->of != CLASS_RING && !(x->has & HAS_AXIS);
    if (PD_DIM > 1 && !springs) scene_key(x, s, "nu", "%g", draw_between(g, 0.1, 0.4));
    else if (PD_DIM > 1) scene_key(x, s, "nu", stress ? "1/3" : "0.25");
    scene_key(x, s, "model", "%s", materials[material]);
    if (g->solid_m != (springs ? 3 : 2) || draw_chance(g, 0.5)) scene_key(x, s, "m", "%i", g->solid_m);
    if (stress) scene_key(x, s, "plane", "stress");
    if (x->has & HAS_MOTION) {
        scene_key(x, s, "dynamics", "yes");
        scene_key(x, s, "density", "%q", 1800.0, UNIT_DENSITY);
    } else scene_key(x, s, "rtol", draw_exact(g) ? "1e-12" : "1e-8");
    if (draw_chance(g, 0.2)) scene_key(x, s, "influence", draw_chance(g, 0.5) ? "inverse" : "linear");
    if (rests && material == 0 && draw_chance(g, 0.2) && PD_DIM > 1 && !stress) { /* it flows */
        scene_key(x, s, "yield_stress", "%q", draw_between(g, 1e7, 1e8), UNIT_PRESSURE);
        scene_key(x, s, "hardening_modulus", "%q", 1e9, UNIT_PRESSURE);
    }
    if (draw_chance(g, 0.85)) {
        int low = scene_side(x, axis, 0);
        for (int d = 0; d < PD_DIM; d++) scene_component(x, low, "u", d, "%q", 0.0, UNIT_LENGTH);
    } else draw_grip(g, "holds", 0.1, 0.0);
    draw_load(g, alone);
    if (x->has & HAS_CRACK) draw_cut(g);
    if (!alone && draw_chance(g, 0.5)) scene_key(x, s, "dissolution_factor", "exp(sigma_h/%q)", 1e8, UNIT_PRESSURE);
}

void generate_gas(draw *g)
{
    scene *x = g->x;
    int s = scene_section(x, "gas", "");
    double width = x->cells[0] * x->h[0];
    /* rho = 1 kg/m3 at 1 Pa: a speed of about 1 m/s, for a box as wide as it takes in a second. */
    scene_key(x, s, "rho", "%q*(1 + %g*sin(%g*%p))", 1.0, UNIT_DENSITY, draw_between(g, 0.0, 0.4),
              draw_between(g, 0.2, 0.8), draw_whole(g, 0, PD_DIM - 1));
    scene_key(x, s, "p", "%q*(1 + %g*sin(%g*%p))", 1.0, UNIT_PRESSURE, draw_between(g, 0.0, 0.4),
              draw_between(g, 0.2, 0.8), draw_whole(g, 0, PD_DIM - 1));
    for (int d = 0; d < PD_DIM; d++)
        if (draw_chance(g, 0.6)) scene_component(x, s, "v", d, "%q", draw_between(g, -0.4, 0.4), UNIT_SPEED);
    if (draw_chance(g, 0.3)) scene_key(x, s, "order", "first");
    for (int d = 0; d < PD_DIM; d++) {
        g->periodic[d] = draw_chance(g, 0.2);
        for (int plus = 0; plus < 2; plus++) {
            static const char *const kinds[] = {"slip", "mirror", "outlet", "inlet", "slip"};
            scene_key(x, scene_side(x, d, plus), "flow", "%s",
                      g->periodic[d] ? "periodic" : kinds[draw_whole(g, 0, 4)]);
        }
    }
    if (PD_DIM > 1 && draw_chance(g, 0.3)) {
        double at[3];
        s = scene_section(x, "shape", "w");
        for (int d = 0; d < PD_DIM; d++) at[d] = x->low[d] + draw_between(g, 0.35, 0.65) * x->cells[d] * x->h[d];
        scene_point(x, s, "ball", at);
        scene_key(x, s, "radius", "%q", 0.2 * width, UNIT_LENGTH);
        scene_key(x, s, "kind", "wall");
    }
    x->until = width * draw_between(g, 0.1, 0.6);
    s = scene_section(x, "run", "");
    scene_key(x, s, "until", "%q", x->until, UNIT_TIME);
    s = scene_section(x, "output", "");
    scene_key(x, s, "every", "%q", 0.5 * x->until, UNIT_TIME);
}
