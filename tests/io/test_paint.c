/* paint: what a pixel of many cells shows.
 * dims: 2 */
#include "io/colour.h"
#include "io/field_plot.h"
#include "test.h"

static const uint32_t flat[4] = {0, 0x9A9DA1, 0x3C4043, 0xFFFFFF}; /* what is no field */

static uint32_t pixel(const pd_image *image, int x, int y)
{
    const uint8_t *p = image->pixels + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
    return (uint32_t)p[0] << 16 | (uint32_t)p[1] << 8 | p[2];
}

/* 1: the column x, or where that is 0 the row y, has much metal. */
static int metal(const pd_image *image, int x, int y)
{
    int count = 0;
    for (int k = 0; k < (x ? image->height : image->width); k++)
        count += (x ? pixel(image, x, k) : pixel(image, k, y)) == flat[1];
    return count > 20;
}

/* Where cells are merged a pixel has the paint of most of them, of the field their mean, or one of their labels. */
TEST(merged_cells)
{
    enum { NX = 599, NY = 501, BX = 3, BY = 2 }; /* the last row and column have fewer cells */
    static double values[NX * NY];
    static uint8_t paint[NX * NY];
    uint32_t table[PDI_COLOUR_TABLE_SIZE], random = 11;
    pd_ctx ctx;
    pd_image image;
    pd_field_plot picture;
    pd_ctx_init(&ctx);
    pdi_colour_fill_table(PD_COLOUR_MAP_GREY, table);
    for (int labels = 0; labels < 2; labels++) {
        int seen[4] = {0, 0, 0, 0}, wrong = 0, left = 0, bottom;
        for (int k = 0; k < NX * NY; k++) {
            int likely = (k % NX / BX + k / NX / BY) % 4;
            random = random * 1664525u + 1013904223u;
            values[k] = labels ? (random >> 12) % 6 : (random >> 12) % 256;
            paint[k] = (uint8_t)(random >> 28 < 4 ? random >> 28 : (unsigned)likely);
        }
        memset(&picture, 0, sizeof picture);
        picture.nx = NX;
        picture.ny = NY;
        picture.values = values;
        picture.cell_paint = paint;
        picture.hi[0] = NX;
        picture.hi[1] = NY;
        picture.width = 200;
        picture.map = labels ? PD_COLOUR_MAP_LABELS : PD_COLOUR_MAP_GREY;
        picture.range_hi = 255;
        if (!CHECK_OK(&ctx, pd_field_plot_draw_image(&ctx, &picture, &image))) return;
        bottom = image.height;
        while (left < 200 && !metal(&image, ++left, 0)) continue;
        while (bottom > 1 && !metal(&image, 0, --bottom)) continue;
        for (int x = 0; x < (NX + BX - 1) / BX; x++)
            for (int y = 0; y < (NY + BY - 1) / BY; y++) {
                int count[4] = {0, 0, 0, 0}, right = 0, most = 0;
                double sum = 0.0;
                uint32_t found = pixel(&image, left + x, bottom - y);
                for (int j = BY * y; j < BY * (y + 1) && j < NY; j++)
                    for (int i = BX * x; i < BX * (x + 1) && i < NX; i++) {
                        int k = j * NX + i;
                        count[paint[k]]++;
                        if (paint[k] == PD_PAINT_FIELD) sum += values[k];
                        right |= labels && !paint[k] && found == pdi_colour_get_label_colour((int)values[k]);
                    }
                for (int k = 0; k < 4; k++) most = count[k] > most ? count[k] : most;
                if (!labels && count[0]) right = found == table[(int)(sum / count[0] + 0.5)];
                right = right && count[0] == most;
                for (int k = 1; k < 4; k++) right |= count[k] == most && found == flat[k];
                for (int k = 0; k < 4; k++) seen[k] += count[k] == most;
                wrong += !right;
            }
        CHECK_INT(wrong, 0);
        CHECK(seen[0] > 5000 && seen[1] > 5000 && seen[2] > 5000 && seen[3] > 5000);
        pd_image_free(&ctx, &image);
    }
    CHECK_INT(ctx.in_use, 0);
}

TEST_MAIN(ENTRY(merged_cells))
