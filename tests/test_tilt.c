/* tilt: the speed of flat fronts in any direction, for every model and kernel; walls, mirrors, thin metal, threads.
 * dims: 2 3 */
#include "metal_scene.h"
#include "metal/tilt.h"

enum { CELLS = PD_DIM == 3 ? 48 : 160 };

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
        s->shapes[0].n[d] = CELLS;
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
    CHECK_OK(&s->ctx, pdi_dissolve_prepare(&s->ctx, &s->dissolve));
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

TEST(directions)
{
    static const int ways[][3] = {
#if PD_DIM == 2
        {1, 0, 0}, {1, 1, 0}, {2, 1, 0}, {3, 1, 0}, {3, 2, 0}, {4, 1, 0}, {5, 1, 0}, {5, 2, 0}, {6, 1, 0}, {8, 1, 0}
#else
        {1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {2, 1, 0}, {2, 1, 1}, {2, 2, 1}, {3, 1, 0}, {3, 2, 1}, {4, 1, 1}
#endif
    };
    for (int m = 1; m <= (PD_DIM == 3 ? 3 : 4); m++)
        for (int kernel = 0; kernel < 3; kernel++) {
            double worst = 0.0, before = 0.0;
            for (int w = 0; w < (int)(sizeof ways / sizeof *ways); w++) {
                double f, v = found(ways[w], m, PD_METAL_BONDS, (pd_kernel)kernel, &f);
                if (getenv("ALL")) NOTE("%d %d %d: %.5f f %.5f", ways[w][0], ways[w][1], ways[w][2], v, f);
                worst = fmax(worst, fabs(v - 1.0));
                before = fmax(before, fabs(f - 1.0));
            }
            NOTE("m = %d, kernel %d: off by %.5f, %.5f without", m, kernel, worst, before);
        }
}

TEST_MAIN(ENTRY(directions))
