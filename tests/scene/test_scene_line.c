/* scene in one dimension: diffusion from a side, with its files, and refusals.
 * dims: 1 */
#define _XOPEN_SOURCE 700
#include "io/png.h"
#include "scene_file.h"

/* A closed rod held at 2 mol/m3 on one end fills up to that; its picture is a curve. */
TEST(diffusion_in_one_dimension)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result r;
    pd_image image;
    pd_table table;
    double c[100];
    memset(&table, 0, sizeof table);
    memset(&desc, 0, sizeof desc);
    memset(&image, 0, sizeof image);
    if (!CHECK_OK(&ctx, load(&ctx,
                             "[grid] h = 10 um  box = 0 .. 400 um\n[side x-] C = 2 mol/m3\n"
                             "[transport] D = 1e-9 m2/s\n[run] until = 1 h  max_step = 60 s\n"
                             "[output] images = C  every = 1 h\n"
                             "[probe end] at = 395 um\n",
                             NULL, 0, &u)))
        return;
    CHECK(u.side[0].kind == PD_SIDE_WALL && u.side[0].has_fixed_c);
    desc.folder = path_of("line");
    CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &r));
    CHECK_LE(r.mass_balance_error, 1e-11);
    CHECK_OK(&ctx, pd_png_read(&ctx, path_of("line/C_000001_t3600.0s.png"), &image));
    CHECK(image.width > 200);
    pd_image_free(&ctx, &image);
    if (CHECK_OK(&ctx, pd_table_read(&ctx, path_of("line/probes.csv"), &table)) && table.rows < 100) {
        CHECK_INT(table.rows, 61);
        CHECK_OK(&ctx, pd_table_parse_column(&ctx, &table, "end_C", c));
        CHECK_NEAR(c[0], 0.0, 0.0);
        CHECK_REL(c[60], 2.0, 1e-6);
    }
    pd_table_free(&ctx, &table);
    leave(&ctx, &u);
}

TEST(refusals)
{
    refused("[grid] h = 10 um  box = 0 .. 400 um\n[side y-] C = 2 mol/m3\n"
            "[transport] D = 1e-9 m2/s\n[run] until = 1 h\n",
            "a.scene:2: side: found [side y-], expected one of x-, x+");
    refused("dx = 1e-6\n", "which describes a pin in 2D or 3D");
}

TEST_MAIN(ENTRY(diffusion_in_one_dimension) ENTRY(refusals))
