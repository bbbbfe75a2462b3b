/* tilt: the speed of flat fronts in any direction, for every model and kernel; walls, mirrors, thin metal, threads.
 * dims: 2 3 */
#include "metal_scene.h"
#include "metal/tilt.h"

enum { CELLS = PD_DIM == 3 ? 32 : 240 };

/* A periodic box, half of which is slabs with fronts of that direction: no side anywhere. */
static scene *slab(const int *direction, double m, pd_metal_model model, pd_kernel kernel)
{
    static uint8_t mask[PD_DIM == 3 ? CELLS * CELLS * CELLS : CELLS * CELLS];
    scene *s = scene_start(CELLS, CELLS, CELLS);
    s->stencil_desc.m = m;
    s->desc.model = model;
    s->desc.kernel = kernel;
    if (model == PD_METAL_SURFACE) s->desc.activation = 0;
    s->transport_desc.diffusivity = 1e-9;
    for (int k = 0; k < 2 * PD_DIM; k++) s->grid_desc.side[k] = PD_SIDE_PERIODIC;
    s->shapes[0].type = PD_SHAPE_VOXELS;
    s->shapes[0].mask = mask;
    for (int d = 0; d < PD_DIM; d++) {
        s->shapes[0].b[d] = H;
        s->shapes[0].mask_size[d] = CELLS;
    }
    for (int k = 0; k < (int)(PD_DIM == 3 ? CELLS * CELLS * CELLS : CELLS * CELLS); k++) {
        int layer = 0;
        for (int d = 0, rest = k; d < PD_DIM; rest /= CELLS, d++) layer += direction[d] * (rest % CELLS);
        mask[k] = layer % CELLS < CELLS / 2;
    }
    return scene_build(s) ? s : NULL;
}

/* Speed of its fronts over that of the law. */
static double speed(scene *s, const int *direction)
{
    double length = 0.0, lost = 0.0, cells = 1.0;
    s->dissolve.time = 0.0;
    CHECK_OK(&s->ctx, pd_dissolve_prepare(&s->ctx, &s->dissolve));
    pdi_dissolve_fastest(&s->ctx, &s->dissolve);
    for (int32_t f = 0; f < s->dissolve.front_count; f++) lost += s->dissolve.rate[s->dissolve.front[f]];
    for (int d = 0; d < PD_DIM; d++) {
        length += direction[d] * direction[d];
        cells *= CELLS;
    }
    return lost * H / SPEED * (CELLS / (2.0 * cells * sqrt(length)));
}

static double found(const int *direction, double m, pd_metal_model model, pd_kernel kernel, double *measure)
{
    scene *s = slab(direction, m, model, kernel);
    double normal[3], length = 0.0, v = 0.0;
    for (int d = 0; d < PD_DIM; d++) length += direction[d] * direction[d];
    for (int d = 0; d < PD_DIM; d++) normal[d] = direction[d] / sqrt(length);
    if (s) v = speed(s, direction);
    *measure = 0.0;
    for (int k = 0; k < s->stencil.count; k++)
        *measure += 0.5 * s->dissolve.weight[k] * fabs(pdi_vec_dot(s->stencil.xi + k * PD_DIM, normal));
    scene_free(s);
    return v;
}

/* Every kernel whose weights are calibrated, along lattice planes of all kinds. Steps of a plane that is nearly normal
 * to an axis are further apart than two families reach. */
TEST(directions)
{
    static const int ways[][3] = {
#if PD_DIM == 2
        {1, 1, 0}, {2, 1, 0}, {3, 1, 0}, {3, 2, 0}, {4, 1, 0}, {5, 1, 0}, {5, 2, 0}, {6, 1, 0}, {8, 1, 0}, {10, 1, 0},
        {12, 1, 0}, {16, 1, 0}
#else
        {1, 1, 0}, {1, 1, 1}, {2, 1, 0}, {2, 1, 1}, {2, 2, 1}, {3, 1, 0}, {3, 2, 1}, {4, 1, 1}
#endif
    };
    static const double bound[4] = {0.018, PD_DIM == 3 ? 1e-3 : 5e-3, PD_DIM == 3 ? 1e-3 : 3e-3, 1.5e-3};
    for (int m = 1; m <= (PD_DIM == 3 ? 3 : 4); m++)
        for (int kernel = 0; kernel < (PD_DIM == 2 || m == 2 ? 3 : 1); kernel++) {
            double worst = 0.0, before = 0.0;
            for (int w = 0; w < (int)(sizeof ways / sizeof *ways); w++) {
                double f, v = found(ways[w], m, PD_METAL_BONDS, (pd_kernel)kernel, &f);
                if (w == 0 || (PD_DIM == 3 && w == 1)) CHECK_NEAR(v, 1.0, 1e-6);
                worst = fmax(worst, fabs(v - 1.0));
                before = fmax(before, fabs(f - 1.0));
            }
            NOTE("m = %d, kernel %d: off by %.5f, %.5f by the weights alone", m, kernel, worst, before);
            CHECK_LE(worst, bound[m - 1]);
        }
}

/* A surface rate gives what bonds give, and fronts normal to an axis are exact. */
TEST(models)
{
    static const int axis[3] = {0, 1, 0}, way[3] = {2, 1, 0};
    double f, bonds = found(way, 2.0, PD_METAL_BONDS, PD_KERNEL_AREA, &f);
    CHECK_NEAR(found(way, 2.0, PD_METAL_SURFACE, PD_KERNEL_AREA, &f), bonds, 1e-9);
    CHECK_NEAR(found(axis, 2.0, PD_METAL_SURFACE, PD_KERNEL_AREA, &f), 1.0, 1e-12);
    CHECK_NEAR(found(axis, 3.0, PD_METAL_BONDS, PD_KERNEL_INVERSE, &f), 1.0, 1e-12);
}

/* A flat front that meets walls and mirrors keeps its direction. A sheet of one node faces both ways. */
TEST(sides)
{
    for (int sheet = 0; sheet < 2; sheet++) {
        scene *s = scene_start(30, 9, 9);
        half_space(s, 15.0 * H);
        s->grid_desc.side[2] = PD_SIDE_MIRROR;
        s->grid_desc.wall = &s->shapes[1];
        s->shapes[1].type = PD_SHAPE_BOX;
        s->shapes[1].b[0] = 30.0 * H;
        s->shapes[1].a[1] = 6.0 * H;
        for (int d = 1; d < PD_DIM; d++) s->shapes[1].b[d] = 9.0 * H;
        if (sheet) {
            s->shapes[0].type = PD_SHAPE_BOX;
            s->shapes[0].a[0] = 15.0 * H;
            s->shapes[0].b[0] = 16.0 * H;
            for (int d = 1; d < PD_DIM; d++) s->shapes[0].b[d] = 9.0 * H;
        }
        if (!scene_build(s)) return;
        CHECK_OK(&s->ctx, pd_dissolve_prepare(&s->ctx, &s->dissolve));
        for (int32_t f = 0; f < s->dissolve.front_count; f++)
            CHECK_NEAR(s->dissolve.tilt[s->dissolve.front[f]], 1.0, 0.0);
        CHECK(s->dissolve.front_count > 0);
        scene_free(s);
    }
}

/* What is found anew where nodes have turned is what is found everywhere, for any number of threads, and the balance
 * holds. */
TEST(step_by_step)
{
    static float one[40000];
    for (int threads = 1; threads <= 2; threads++) {
        scene *s = lump(PD_DRIVE_CONSTANT, threads, NULL);
        if (!s) return;
        for (int step = 0; step < 40; step++)
            if (!scene_step(s, 1e6)) return;
        pd_dissolve *d = &s->dissolve;
        CHECK_OK(&s->ctx, pd_dissolve_prepare(&s->ctx, d));
        int32_t total = s->grid.total < 40000 ? s->grid.total : 40000;
        double most = 0.0;
        for (int32_t j = 0; j < total; j++) {
            if (threads == 2 && d->exposed[j]) CHECK_NEAR(d->tilt[j], one[j], 0.0);
            one[j] = d->tilt[j];
        }
        d->tilted = 0;
        pdi_tilt_update(&s->ctx, d);
        for (int32_t j = 0; j < total; j++) {
            if (d->exposed[j]) CHECK_NEAR(d->tilt[j], one[j], 0.0);
            if (d->exposed[j]) most = fmax(most, fabs(d->tilt[j] - 1.0));
        }
        CHECK(most > 1e-3 && most < 0.03);
        CHECK_LE(s->couple.ledger[0].relative_imbalance, 1e-12);
        scene_free(s);
    }
}

TEST_MAIN(ENTRY(directions) ENTRY(models) ENTRY(sides) ENTRY(step_by_step))
