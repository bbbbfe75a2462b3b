/* test_deformed_plot: pictures of cells that have moved: places, areas, no gap between cells that hold together,
 * cracks. */
/* dims: 2 */
#include "fault.h"
#include "io/deformed_plot.h"
#include <math.h>

enum { NX = 12, NY = 8, CELLS = NX * NY };

typedef struct lab {
    pd_ctx ctx;
    pd_field_plot picture;
    pdi_deformed_plot warp;
    double values[CELLS], move[2 * CELLS];
    uint8_t paint[CELLS];
    int apart; /* cells at either side of this column do not hold together */
} lab;

static lab one;

static int joined(const void *user, int cell, int other)
{
    const lab *l = (const lab *)user;
    return l->apart == 0 || (cell % NX < l->apart) == (other % NX < l->apart);
}

/* Cells of width 1, the number of each as its value; those at the rim, if any, are a wall and stay. */
static lab *begin(int rim)
{
    lab *l = &one;
    memset(l, 0, sizeof *l);
    pd_ctx_init(&l->ctx);
    for (int k = 0; k < CELLS; k++) {
        int x = k % NX, y = k / NX;
        l->values[k] = k + 1;
        if (x >= rim && x < NX - rim && y >= rim && y < NY - rim) continue;
        l->move[k] = l->move[CELLS + k] = (double)NAN;
        l->paint[k] = PD_PAINT_WALL;
    }
    l->picture.nx = NX;
    l->picture.ny = NY;
    l->picture.values = l->values;
    l->picture.cell_paint = l->paint;
    l->picture.hi[0] = NX;
    l->picture.hi[1] = NY;
    l->picture.map = PD_COLOUR_MAP_LABELS;
    l->warp.undeformed = &l->picture;
    l->warp.displacement = l->move;
    l->warp.is_connected = joined;
    l->warp.user = l;
    return l;
}

static uint32_t pixel(const pd_image *image, int x, int y)
{
    const uint8_t *p = image->pixels + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
    return (uint32_t)p[0] << 16 | (uint32_t)p[1] << 8 | p[2];
}

/* The cell of a colour of labels, counted from 1; 0: none. */
static int cell_of(uint32_t colour)
{
    static uint8_t cell[1 << 24];
    for (int k = CELLS; k > 0 && !cell[pdi_colour_get_label_colour(1)]; k--)
        cell[pdi_colour_get_label_colour(k)] = (uint8_t)k;
    return cell[colour];
}

/* Pixels of each cell, and of all. */
static int64_t count(const pd_image *image, int64_t *of)
{
    int64_t all = 0;
    memset(of, 0, CELLS * sizeof *of);
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            int cell = cell_of(pixel(image, x, y));
            if (cell) of[cell - 1]++;
            all += cell > 0;
        }
    return all;
}

/* Blank pixels between two of the body in a row. */
static int64_t gaps(const pd_image *image)
{
    int64_t found = 0;
    for (int y = 0; y < image->height; y++) {
        int64_t blank = -1; /* since the body, -1: there was none */
        for (int x = 0; x < image->width; x++) {
            uint32_t colour = pixel(image, x, y);
            if (cell_of(colour)) found += blank > 0 ? blank : 0, blank = 0;
            else if (blank >= 0 && colour == 0xFFFFFF) blank++;
        }
    }
    return found;
}

/* What does not move is drawn as without: each cell as large. */
TEST(at_rest)
{
    int64_t of[CELLS];
    pd_image image;
    lab *l = begin(2);
    if (!CHECK_OK(&l->ctx, pdi_deformed_plot_draw_image(&l->ctx, &l->warp, &image))) return;
    int64_t all = count(&image, of);
    CHECK_REL((double)all, (NX - 4) * (NY - 4) * 1000.0 * 1000.0 / (NX * NX), 0.01);
    CHECK_INT(gaps(&image), 0);
    pd_image_free(&l->ctx, &image);
    CHECK_INT(l->ctx.in_use, 0);
}

/* A body that moves, turns, is stretched, sheared and mirrored has no gap, and its cells have one shape. */
TEST(no_gap)
{
    static const double way[6][4] = {{1.0, 0.0, 0.0, 1.0}, {0.8, -0.6, 0.6, 0.8}, {0.0, -1.0, 1.0, 0.0},
                                     {1.3, 0.0, 0.0, 0.8}, {1.0, 0.4, 0.0, 1.0}, {-1.0, 0.0, 0.0, 1.0}};
    for (int w = 0; w < 6; w++) {
        int64_t of[CELLS];
            pd_image image;
        lab *l = begin(0);
        memset(l->paint, 0, sizeof l->paint);
        for (int k = 0; k < CELLS; k++) {
            double x = k % NX + 0.5 - 0.5 * NX, y = k / NX + 0.5 - 0.5 * NY;
            l->move[k] = way[w][0] * x + way[w][1] * y - x + 3.0;
            l->move[CELLS + k] = way[w][2] * x + way[w][3] * y - y - 1.0;
        }
        if (!CHECK_OK(&l->ctx, pdi_deformed_plot_draw_image(&l->ctx, &l->warp, &image))) return;
        int64_t all = count(&image, of);
        CHECK_INT(gaps(&image), 0);
        CHECK(all > 100000);
        int64_t least = all, most = 0; /* of cells within, all of which have the same shape */
        for (int k = 0; k < CELLS; k++) {
            if (k % NX == 0 || k % NX == NX - 1 || k / NX == 0 || k / NX == NY - 1) continue;
            least = of[k] < least ? of[k] : least;
            most = of[k] > most ? of[k] : most;
        }
        CHECK(least > 0 && (double)most < 1.05 * (double)least);
        pd_image_free(&l->ctx, &image);
    }
}

/* Halves that do not hold together part by what they move, and cells beside each other hold together. */
TEST(crack)
{
    for (int apart = 0; apart < 2; apart++) {
        pd_image image;
        lab *l = begin(0);
        memset(l->paint, 0, sizeof l->paint);
        l->apart = apart ? NX / 2 : 0;
        for (int k = 0; k < CELLS; k++) {
            l->move[k] = k % NX < NX / 2 ? -1.0 : 1.0;
            l->move[CELLS + k] = 0.0;
        }
        if (!CHECK_OK(&l->ctx, pdi_deformed_plot_draw_image(&l->ctx, &l->warp, &image))) return;
        /* 14 wide on 1000 pixels; the gap is 2 wide and 8 high */
        double wanted = apart ? 2.0 * NY * (1000.0 / (NX + 2)) * (1000.0 / (NX + 2)) : 0.0;
        CHECK_NEAR((double)gaps(&image), wanted, 0.02 * wanted);
        pd_image_free(&l->ctx, &image);
    }
}

/* Walls stay, and metal that moves away leaves blank paper. */
TEST(walls_stay)
{
    int64_t of[CELLS], wall = 0;
    pd_image image;
    lab *l = begin(2);
    for (int k = 0; k < CELLS; k++)
        if (!isnan(l->move[k])) l->move[k] = NX;
    if (!CHECK_OK(&l->ctx, pdi_deformed_plot_draw_image(&l->ctx, &l->warp, &image))) return;
    double size = 22.0 / 1000.0; /* of a pixel: from 0 to 2 NX - 2 */
    int64_t all = count(&image, of);
    for (int y = 0; y < image.height; y++)
        for (int x = 0; x < image.width; x++) wall += pixel(&image, x, y) == 0x3C4043;
    CHECK_REL((double)all * size * size, (NX - 4.0) * (NY - 4.0), 0.02);
    CHECK_REL((double)wall * size * size, NX * NY - (NX - 4.0) * (NY - 4.0), 5e-3);
    pd_image_free(&l->ctx, &image);
}

/* Cells of one axis that do not fit are merged, and those of the other one as well. */
TEST(merged_cells_stay_square)
{
    static double values[1600 * 640];
    static uint8_t paint[1600 * 640];
    pd_ctx ctx;
    pd_image image;
    pd_field_plot picture;
    pd_ctx_init(&ctx);
    memset(&picture, 0, sizeof picture);
    memset(paint, PD_PAINT_WALL, sizeof paint);
    for (int turned = 0; turned < 2; turned++) {
        picture.nx = turned ? 640 : 1600;
        picture.ny = turned ? 1600 : 640;
        picture.values = values;
        picture.cell_paint = paint;
        picture.hi[0] = picture.nx * 1e-4;
        picture.hi[1] = picture.ny * 1e-4;
        if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
        int64_t found = 0;
        for (int y = 0; y < image.height; y++)
            for (int x = 0; x < image.width; x++) found += pixel(&image, x, y) == 0x3C4043;
        CHECK(found >= 800 * 320 && found < 800 * 320 + 400); /* with the sample of the key */
        pd_image_free(&ctx, &image);
    }
}

TEST(what_goes_wrong)
{
    pd_image image;
    lab *l = begin(0);
    memset(l->paint, 0, sizeof l->paint);
    l->move[17] = 1e6;
    CHECK_INT(pdi_deformed_plot_draw_image(&l->ctx, &l->warp, &image), PD_ERR_ARGUMENT);
    CHECK(strstr(l->ctx.message, "smaller factor") != NULL);
    CHECK_INT(l->ctx.in_use, 0);
    l->move[17] = 0.0;
    pd_status status = PD_ERR_MEMORY;
    int failures = 0;
    for (int tries = 0; status != PD_OK && tries < 20; tries++) {
        fault f;
        fault_context(&f, tries + 1, 1, &l->ctx);
        status = pdi_deformed_plot_draw_image(&l->ctx, &l->warp, &image);
        if (status != PD_OK) CHECK_INT(status, PD_ERR_MEMORY);
        failures += status != PD_OK;
        if (status == PD_OK) pd_image_free(&l->ctx, &image);
        CHECK_INT(l->ctx.in_use, 0);
    }
    CHECK_OK(&l->ctx, status);
    CHECK(failures >= 3);
}

TEST_MAIN(ENTRY(at_rest) ENTRY(no_gap) ENTRY(crack) ENTRY(walls_stay) ENTRY(merged_cells_stay_square)
          ENTRY(what_goes_wrong))
