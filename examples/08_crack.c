/* 08: a crack in a plate of glass runs and branches.
 *
 * 100 x 40 mm of soda-lime glass with a notch from the left side to the middle. At t = 0 both long sides are pulled
 * with 2 MPa. The plate is points with springs between all that are closer than a horizon; springs that are stretched
 * too far break (theory: 15.2). Prints where the tip is and where the work has gone, and draws the damage: crack.png.
 * After F. Bobaru and G. Zhang, Int. J. Fract. 196 (2015), 59.
 *   cc -std=c99 -O3 -fopenmp -I. examples/08_crack.c -o 08_crack -lm && ./08_crack 400
 * The argument is the number of points along the plate; 200 take a second, 1600 some minutes.
 */
#define PD_DIM 2
#ifndef PDCORR_LINKED
#define PDCORR_IMPLEMENTATION
#endif
#include "pdcorr_app.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH 0.1     /* [m] of the plate */
#define TRACTION 2e6   /* [Pa] */
#define END 43e-6      /* [s] */
#define DAMAGED 0.35   /* [-] share of its bonds that a point at the tip has lost */

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

/* The notch: bonds that cross y = 0 left of the middle are broken, and those through the middle are not. */
static void notch(pd_body *body, double h)
{
    double ends[4] = {-LENGTH, 0.0, -0.01 * h, 0.0};
    pd_precrack cut = {2, ends};
    must(pd_body_apply_precracks(&ctx, body, &cut, 1, NULL));
}

int main(int argc, char **argv)
{
    int nx = argc > 1 && atoi(argv[1]) >= 50 ? atoi(argv[1]) : 200, ny = 2 * nx / 5;
    int32_t count = nx * ny;
    double h = LENGTH / nx;
    double *position = (double *)malloc(2 * (size_t)count * sizeof *position);
    double *volume = (double *)malloc((size_t)count * sizeof *volume);
    double *load = (double *)calloc(2 * (size_t)count, sizeof *load);
    double *damage = (double *)malloc((size_t)count * sizeof *damage);
    if (!position || !volume || !load || !damage) return 1;
    for (int32_t i = 0; i < count; i++) {
        position[2 * i] = (i % nx - 0.5 * (nx - 1)) * h;
        position[2 * i + 1] = (i / nx - 0.5 * (ny - 1)) * h;
        volume[i] = h * h;
        if (i / nx == 0) load[2 * i + 1] = -TRACTION / h; /* a force per volume, on the outermost row */
        if (i / nx == ny - 1) load[2 * i + 1] = TRACTION / h;
    }

    pd_body_desc points;
    pd_body body;
    pd_microelastic_desc glass;
    pd_microelastic springs;
    pd_material_interface solid;
    pd_verlet_desc motion;
    pd_verlet verlet;
    pd_ctx_init(&ctx);
    memset(&points, 0, sizeof points);
    points.count = count;
    points.position = position;
    points.volume = volume;
    points.horizon = 3.0 * h;
    points.spacing = h;
    must(pd_body_build(&ctx, &points, &body));
    notch(&body, h);
    memset(&glass, 0, sizeof glass);
    glass.young = 72e9;
    glass.fracture = 3.8;
    glass.plane = PD_PLANE_STRESS;
    must(pd_microelastic_build(&ctx, &body, &glass, &springs));
    memset(&motion, 0, sizeof motion);
    motion.density = 2440.0;
    motion.load = load;
    solid = pd_microelastic_material(&springs);
    must(pd_verlet_build(&ctx, &solid, &motion, &verlet));

    for (int frame = 1; frame <= 10; frame++) {
        double tip = 0.0;
        must(pd_physics_run(&ctx, pd_verlet_process(&verlet), 0.1 * END * frame));
        pd_body_damage(&ctx, &body, damage);
        for (int32_t i = 0; i < count; i++)
            if (damage[i] >= DAMAGED) tip = fmax(tip, position[2 * i]);
        printf("t = %4.1f us: tip at %4.1f mm, %d bonds broken\n", 1e6 * verlet.time, 1e3 * tip, (int)verlet.broken);
    }
    double kinetic = pd_verlet_kinetic(&verlet), elastic = pd_microelastic_energy(&ctx, &springs, verlet.u);
    printf("work %.3f J/m = kinetic %.3f + elastic %.3f + released %.3f, off by %.1e\n", verlet.work, kinetic, elastic,
           springs.released, (kinetic + elastic + springs.released) / verlet.work - 1.0);

    pd_field_plot picture;
    memset(&picture, 0, sizeof picture);
    picture.nx = nx;
    picture.ny = ny;
    picture.values = damage;
    picture.hi[0] = LENGTH;
    picture.hi[1] = LENGTH * ny / nx;
    picture.range_hi = 1.0;
    picture.title = "Notched plate of glass under 2 MPa";
    picture.stamp = "t = 43 us";
    picture.label = "damage [-]";
    must(pd_field_plot_write(&ctx, "crack.png", &picture));
    pd_verlet_free(&ctx, &verlet);
    pd_microelastic_free(&ctx, &springs);
    pd_body_free(&ctx, &body);
    free(position);
    free(volume);
    free(load);
    free(damage);
    return 0;
}
