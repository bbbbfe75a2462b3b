/* read_metal: see read_metal.h */
#include "scene/read_metal.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The law at C = 0 tells the size of the speed, and a rate that is negative there never dissolves anything. */
static pd_status pdi_read_metal_check(pdi_reader *s, int section, const char *key)
{
    double v = pdi_setup_speed(s->setup);
    char slow[PD_UNITS_TEXT];
    if (s->setup->rate.uses <= 1 && (!(v >= 0.0) || v > 1.0))
        return pdi_text_refuse(s->ctx, s->text, section, key,
                               "found a recession speed of %.6g m/s at C = 0, expected 0 to 1 m/s", v);
    if (strcmp(key, "law") != 0) return PD_OK;
    pdi_setup_show(s->setup->h[0], "m", slow);
    pdi_setup_note(s->setup, "law: one layer of %s a unit of the rate: %.6g um/h = %.6g mm/year at C = 0", slow,
                   v * 1e6 * 3600.0, v * 1e3 * 31557600.0);
    return PD_OK;
}

/* Speed, or current density through Faraday's law, as an expression in C, t, x, y and z. */
static pd_status pdi_read_metal_rate(pdi_reader *s, int section, const char *key, const char *other, const char *unit)
{
    double factor;
    if (pdi_text_has(s->ctx, s->text, section, other) && strcmp(key, other) != 0)
        return pdi_text_refuse(s->ctx, s->text, section, key, "found beside '%s', expected one of them", other);
    PDI_TRY(pdi_text_expr(s->ctx, s->text, section, key, unit, pdi_setup_law(), PDI_SETUP_LAW, NULL, &s->setup->rate));
    PDI_TRY(pdi_reader_within(s, section, "rate_scale", "", "1", 0.0, 1e6, 0, &factor));
    s->setup->rate_scale *= factor;
    return pdi_read_metal_check(s, section, key);
}

static pd_status pdi_read_metal_boundaries(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    PDI_TRY(pdi_reader_within(s, section, "gb_factor", "", "1", 0.0, 1e6, 0, &u->gb_factor));
    if (!(fabs(u->gb_factor - 1.0) > 0.0) || u->has_grains) return PD_OK;
    return pdi_text_refuse(s->ctx, s->text, section, "gb_factor",
                           "found %.6g without grains, expected grains = SIZE in a solid [shape ...]", u->gb_factor);
}

PDI_FN pd_status pdi_read_metal_dissolve(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_section(s->ctx, s->text, "dissolve", NULL);
    if (!u->has_dissolve || u->has_corrode) return PD_OK;
    if (!u->has_transport)
        return pdi_text_refuse(s->ctx, s->text, section, "dissolve",
                               "found no [transport] section, expected one: the metal goes into the fluid");
    if (u->solid < 0)
        return pdi_text_refuse(s->ctx, s->text, section, "dissolve", "found no solid, expected a [shape ...] with "
                               "kind = solid");
    int layers = pdi_text_has(s->ctx, s->text, section, "law");
    const char *key = layers ? "law" : "rate";
    for (int d = 1; d < PD_DIM && layers; d++)
        if (fabs(u->h[d] - u->h[0]) > 1e-9 * u->h[0])
            return pdi_text_refuse(s->ctx, s->text, section, "law",
                                   "found different spacings of the axes, expected rate = speed there");
    u->rate_scale = layers ? u->h[0] : 1.0;
    PDI_TRY(pdi_read_metal_rate(s, section, key, "rate", layers ? "1/s" : "m/s"));
    PDI_TRY(pdi_read_metal_boundaries(s, section));
    return pdi_reader_within(s, section, "threshold", "", "0", 0.0, 0.99, 0, &u->threshold);
}

/* Before anything of the other sections is read. */
PDI_FN pd_status pdi_read_metal_first(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_section(s->ctx, s->text, "corrode", NULL);
    if (!u->has_corrode) return PD_OK;
    if (u->has_dissolve)
        return pdi_text_refuse(s->ctx, s->text, section, "corrode",
                               "found beside [dissolve], expected one of them: both tell how the metal goes");
    u->has_transport = u->has_dissolve = 1;
    return PD_OK;
}

static pd_status pdi_read_metal_forms(pdi_reader *s, int section)
{
    static const char *const controls[] = {"diffusion", "activation", NULL};
    static const char *const drives[] = {"constant", "difference", NULL};
    static const char *const kernels[] = {"area", "square", "inverse", NULL};
    static const char *const weights[] = {"calibrated", "printed", NULL};
    static const char *const breakings[] = {"deterministic", "stochastic", NULL};
    pd_setup *u = s->setup;
    int drive, kernel, printed;
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "control", controls, "diffusion", &u->activation));
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "drive", drives, "constant", &drive));
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "kernel", kernels, "area", &kernel));
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "weights", weights, "calibrated", &printed));
    u->drive = (pd_drive)drive;
    u->kernel = (pd_kernel)kernel;
    u->weights = printed ? PD_WEIGHTS_PRINTED : PD_WEIGHTS_CALIBRATED;
    if (u->activation && u->has_flow)
        return pdi_text_refuse(s->ctx, s->text, section, "control",
                               "found 'activation' beside [flow], expected diffusion: with activation all fluid holds"
                               " bulk");
    if (printed && u->has_flow)
        return pdi_text_refuse(s->ctx, s->text, section, "weights",
                               "found 'printed' beside [flow], expected calibrated: no flow is exact with others");
    PDI_TRY(pdi_text_choice(s->ctx, s->text, section, "breaking", breakings, "deterministic", &u->stochastic));
    if (u->stochastic) return pdi_text_integer(s->ctx, s->text, section, "seed", 0, 2147483647, "1", &u->seed);
    if (!pdi_text_has(s->ctx, s->text, section, "seed")) return PD_OK;
    return pdi_text_refuse(s->ctx, s->text, section, "seed", "found without breaking = stochastic, expected both");
}

/* D and the field at the start, unless [transport] has them. */
static pd_status pdi_read_metal_fluid(pdi_reader *s, int section)
{
    static const char *const keys[] = {"D", "initial"};
    pd_setup *u = s->setup;
    int transport = pdi_text_has(s->ctx, s->text, pdi_text_section(s->ctx, s->text, "transport", NULL), NULL);
    for (int k = 0; k < 2 && transport; k++)
        if (pdi_text_has(s->ctx, s->text, section, keys[k]))
            return pdi_text_refuse(s->ctx, s->text, section, keys[k],
                                   "found beside a [transport] section, expected it there");
    if (!transport) {
        PDI_TRY(pdi_reader_not_negative(s, section, "D", "m2/s", u->activation ? "0" : NULL, &u->diffusivity));
        PDI_TRY(pdi_reader_initial(s, section));
    }
    if (u->activation && (u->diffusivity > 0.0 || pdi_text_has(s->ctx, s->text, section, "initial")))
        pdi_setup_note(u, "D and initial belong to control = diffusion; with activation all fluid holds bulk");
    return pdi_reader_within(s, section, "bulk", "mol/m3", "0", 0.0, u->saturation, 0, &u->bulk);
}

/* The speed of a current density of 1 A/m2 makes a current a rate. */
static pd_status pdi_read_metal_current(pdi_reader *s, int section)
{
    pd_setup *u = s->setup;
    pd_material metal = u->material;
    int current = pdi_text_has(s->ctx, s->text, section, "current");
    metal.density = u->solid_c * metal.molar_mass;
    u->rate_scale = current ? pd_material_speed(&metal, 1.0) : 1.0;
    return pdi_read_metal_rate(s, section, current ? "current" : "rate", "rate", current ? "A/m2" : "m/s");
}

/* A concentration of the fluid: metal begins at Cs. */
PDI_FN pd_status pdi_read_metal_corrode(pdi_reader *s)
{
    pd_setup *u = s->setup;
    int section = pdi_text_section(s->ctx, s->text, "corrode", NULL);
    double saturation;
    if (!u->has_corrode) return PD_OK;
    if (u->solid < 0)
        return pdi_text_refuse(s->ctx, s->text, section, "corrode",
                               "found no solid, expected a [shape ...] with kind = solid");
    PDI_TRY(pdi_read_metal_forms(s, section));
    PDI_TRY(pdi_reader_within(s, section, "Csat", "mol/m3", NULL, 0.0, u->solid_c, 1, &saturation));
    PDI_TRY(pdi_read_metal_current(s, section));
    PDI_TRY(pdi_read_metal_boundaries(s, section));
    PDI_TRY(pdi_read_metal_fluid(s, section));
    if (pdi_text_has(s->ctx, s->text, section, "repassivation"))
        PDI_TRY(pdi_reader_within(s, section, "repassivation", "mol/m3", NULL, 0.0, u->saturation, 1,
                                 &u->repassivation));
    if (u->activation && u->repassivation > 0.0)
        return pdi_text_refuse(s->ctx, s->text, section, "repassivation",
                               "found beside control = activation, expected diffusion: there all fluid holds bulk");
    return PD_OK;
}
