/* 09: a ring from a mesh, under pressure in its bore.
 *
 * Cells of a mesh become points of a body with their volumes. The bore of 10 mm carries 10 MPa, the outside of 20 mm is
 * free, nothing is held. Prints how far the bore opens and the hoop stress there, beside Lame's closed form.
 *   cc -std=c99 -O3 -fopenmp -I. examples/09_mesh.c -o 09_mesh -lm && ./09_mesh examples/ring.msh
 * Any other ring about the origin does as well: Gmsh 2.2 and 4.1 as text, VTU, CSV, in millimetres.
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

#define YOUNG 45e9     /* [Pa] magnesium */
#define POISSON 0.3
#define PRESSURE 10e6  /* [Pa] in the bore */
#define INNER 5e-3     /* [m] radii */
#define OUTER 10e-3

static pd_ctx ctx;

static void must(pd_status status)
{
    if (status == PD_OK) return;
    fprintf(stderr, "%s: %s\n", pd_status_name(status), ctx.message);
    exit(1);
}

int main(int argc, char **argv)
{
    pd_points points;
    pd_body_desc family;
    pd_body body;
    pd_correspondence_desc metal;
    pd_correspondence elastic;
    pd_material_interface solid;
    pd_equilibrium_desc rest;
    pd_equilibrium_result result;
    pd_ctx_init(&ctx);
    must(pd_points_read(&ctx, argc > 1 ? argv[1] : "examples/ring.msh", 1e-3, &points));

    double area = 0.0, size = 0.0;
    for (int32_t i = 0; i < points.count; i++) {
        area += points.volume[i];
        size = fmax(size, sqrt(points.volume[i]));
    }
    memset(&family, 0, sizeof family);
    family.count = points.count;
    family.position = points.position;
    family.volume = points.volume;
    family.horizon = 2.0 * size; /* twice the edge of the largest cell */
    family.faces = points.face_count; /* bonds do not cross the surface of the mesh */
    family.face = points.face_corner;
    if (points.coincident_nodes)
        printf("note: %.0f nodes lie where others do: parts that touch there are not joined. Merge the nodes of the "
               "mesh if they are one body.\n",
               (double)points.coincident_nodes);
    must(pd_body_build(&ctx, &family, &body));
    memset(&metal, 0, sizeof metal);
    metal.young = YOUNG;
    metal.poisson = POISSON;
    metal.plane = PD_PLANE_STRESS;
    must(pd_correspondence_build(&ctx, &body, &metal, &elastic));

    /* Faces of the bore point inwards. A pressure p on them is the load -p surface/volume of their cell. */
    double *load = (double *)calloc(2 * (size_t)points.count, sizeof *load);
    double *u = (double *)calloc(2 * (size_t)points.count, sizeof *u);
    double *stress = (double *)malloc(4 * (size_t)points.count * sizeof *stress);
    if (!load || !u || !stress) return 1;
    for (int32_t i = 0; i < points.count; i++) {
        const double *x = points.position + 2 * (size_t)i, *face = points.boundary_area + 2 * (size_t)i;
        if (face[0] * x[0] + face[1] * x[1] > 0.0) continue;
        for (int d = 0; d < 2; d++) load[2 * (size_t)i + d] = -PRESSURE * face[d] / points.volume[i];
    }
    memset(&rest, 0, sizeof rest);
    solid = pd_correspondence_material(&elastic);
    must(pd_equilibrium_solve(&ctx, &solid, &rest, load, u, &result));
    pd_correspondence_stress(&ctx, &elastic, u, stress);

    int32_t first = 0; /* the point next to the bore */
    for (int32_t i = 1; i < points.count; i++)
        if (hypot(body.position[2 * i], body.position[2 * i + 1]) <
            hypot(body.position[2 * first], body.position[2 * first + 1]))
            first = i;
    double x = body.position[2 * first], y = body.position[2 * first + 1], r = hypot(x, y);
    double opens = (u[2 * first] * x + u[2 * first + 1] * y) / r;
    const double *s = stress + 4 * (size_t)first;
    double hoop = (s[0] * y * y - (s[1] + s[2]) * x * y + s[3] * x * x) / (r * r);
    double a = PRESSURE * INNER * INNER / (OUTER * OUTER - INNER * INNER), b = a * OUTER * OUTER / (r * r);
    double exact = r / YOUNG * ((1.0 - POISSON) * a + (1.0 + POISSON) * b);
    printf("%d points, %.2f mm2, %d iterations\n", (int)points.count, 1e6 * area, result.iterations);
    printf("at r = %.3f mm: opens by %.4f um, Lame %.4f; hoop stress %.3f MPa, Lame %.3f\n", 1e3 * r, 1e6 * opens,
           1e6 * exact, 1e-6 * hoop, 1e-6 * (a + b));
    pd_correspondence_free(&ctx, &elastic);
    pd_body_free(&ctx, &body);
    pd_points_free(&ctx, &points);
    free(load);
    free(u);
    free(stress);
    return 0;
}
