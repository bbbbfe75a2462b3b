/* field_info: the list of fields that front ends show: each field of a scene once, with what a view of it says; what is
 * not in the list cannot be viewed.
 * dims: 1 2 3 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include "setup/fields.h"
#include "run/sim.h"
#include <math.h>

#define BOX "[grid] h = 10 um  box = 0 um .. 80 um" TIMES "\n"
#if PD_DIM == 1
#define TIMES ""
#elif PD_DIM == 2
#define TIMES ", 0 um .. 40 um"
#else
#define TIMES ", 0 um .. 40 um, 0 um .. 30 um"
#endif
#define METAL "[shape m] box = 40 um .. 80 um" TIMES "  kind = solid\n"
#if PD_DIM == 1
#define NU ""
#else
#define NU "  nu = 0.3"
#endif
#define DISSOLVE \
    "[dissolve] rate = 1 um/h * (1 - C/Csat)  Csat = 500 mol/m3  Cs = 70000 mol/m3\n[transport] D = 1e-9 m2/s\n"
#define END "[run] until = 1 s\n"

/* The names of the list, "C, kind", into text [400]; every row agrees with a view of the field, and no other field can
 * be viewed. */
static void list(const char *scene, char *text)
{
    pd_ctx ctx;
    pd_sim sim;
    pd_field_info info;
    int listed = 0, found = 0;
    text[0] = '\0';
    pd_ctx_init(&ctx);
    ctx.threads = 1;
    put("a.scene", scene, strlen(scene));
    if (!CHECK_OK(&ctx, pd_sim_open(&ctx, path_of("a.scene"), NULL, 0, &sim))) return;
    for (; pd_field_info_get(&sim.setup, listed, &info); listed++) {
        pd_field_view view;
        if (!CHECK_OK(&ctx, pd_sim_field(&ctx, &sim, info.name, &view))) continue;
        CHECK_INT(view.components, info.components);
        CHECK_STR(view.label, info.label);
        CHECK(strncmp(info.label, info.name, strlen(info.name)) == 0);
        int is_category = strcmp(info.name, "kind") == 0 || strcmp(info.name, "phase") == 0;
        CHECK_INT(info.scale == PD_FIELD_SCALE_CATEGORY, is_category);
        snprintf(text + strlen(text), 400 - strlen(text), "%s%s", listed ? ", " : "", info.name);
    }
    for (int field = 0; field < PD_FIELD_COUNT; field++) {
        pd_field_view view;
        const char *name = pd_fields_get_name(&sim.setup, (pd_field)field);
        if (name[0] && pd_sim_field(&ctx, &sim, name, &view) == PD_OK) found++;
    }
    CHECK_INT(found, listed);
    pd_sim_close(&ctx, &sim);
    CHECK_INT(ctx.in_use, 0);
}

TEST(fields_of_scenes)
{
    char text[400];
    list(BOX METAL DISSOLVE END, text);
    CHECK_STR(text, "C, kind, phase, D, rate, density");
    list(BOX METAL
         "[species H+] initial = 1e-4 mol/m3  D = 9e-9 m2/s\n[species OH-] initial = 1e-4 mol/m3  D = 5e-9 m2/s\n"
         "[species Mg2+] D = 7e-10 m2/s\n"
         "[reaction water] H2O = H+ + OH-  log10_K = -14\n"
         "[transport] D = 1e-9 m2/s\n[dissolve] rate = 1 um/h  Cs = 70000 mol/m3  reaction = Mg + 2 H2O = Mg2+ + 2 OH- "
         "+ H2(g)\n"
         "[surface theta] initial = 0  rate = (1 - theta)/(1 h)\n" END,
         text);
    CHECK_STR(text, "C, kind, phase, D, rate, density, pH, H+, OH-, Mg2+, theta");
    list(BOX "[shape m] box = 0 um .. 80 um" TIMES "  kind = solid\n"
             "[side x-] ux = 0 m\n[side x+] ux = 1 nm\n[solid] E = 45 GPa  m = 1" NU "\n" END,
         text);
    CHECK_STR(text,
              PD_DIM == 1 ? "kind, phase, u, mises, sigma_h, broken, strain_energy, sigma_xx"
              : PD_DIM == 2
                  ? "kind, phase, u, mises, sigma_h, broken, strain_energy, sigma_xx, sigma_yy, sigma_zz, sigma_xy"
                  : "kind, phase, u, mises, sigma_h, broken, strain_energy, sigma_xx, sigma_yy, sigma_zz, "
                    "sigma_xy, sigma_yz, sigma_zx");
}

/* A message for a name that is none lists the fields of the scene. */
TEST(names_in_messages)
{
    refused(BOX METAL DISSOLVE "[output] fields = T\n" END,
            "fields: found 'T', expected some of C, kind, phase, D, rate, density, or none");
}

/* Values stand in the cells of the place that the row names: elsewhere is 0, -1 or nothing. */
TEST(places)
{
    static const pd_setup none; /* without physics of the program */
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_C), PD_FIELD_IN_FLUID);
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_PHI), PD_FIELD_IN_FLUID);
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_SPECIES), PD_FIELD_IN_FLUID);
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_GRAIN), PD_FIELD_IN_METAL);
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_SIGMA_ZX), PD_FIELD_IN_METAL);
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_DENSITY), PD_FIELD_IN_BOTH);
    CHECK_INT(pd_fields_get_place(&none, PD_FIELD_KIND), PD_FIELD_IN_ALL);
    CHECK_INT(pd_fields_count_components(PD_FIELD_V), PD_DIM);
    CHECK_STR(pd_fields_get_axis(PD_FIELD_V, 0), "x"); /* in 1D, too: the key of a column knows no dimension */
    CHECK_STR(pd_fields_get_axis(PD_FIELD_V, PD_DIM - 1), PD_DIM == 1 ? "x" : PD_DIM == 2 ? "y" : "z");
    CHECK_STR(pd_fields_get_axis(PD_FIELD_P, 0), "");
    CHECK_INT(pd_fields_is_scalar(PD_FIELD_U), 0);
    CHECK_INT(pd_fields_get_scale(PD_FIELD_SIGMA_XX), PD_FIELD_SCALE_SIGNED);
    CHECK_INT(pd_fields_get_scale(PD_FIELD_MISES), PD_FIELD_SCALE_PLAIN);
}

TEST_MAIN(ENTRY(fields_of_scenes) ENTRY(names_in_messages) ENTRY(places))
