/* levels: metals that corrode freely, and several electrodes, among ions that migrate: two lines of Tafel, a cell of two
 * plates against a closed form of its ions, oxygen that diffuses to metal, given potentials and currents, laws that
 * jump, plateaus, steps of any length; what is refused.
 * dims: 1 2 */
#include "run/run.h"
#include "scene/scene.h"
#include "../cases/plates.h"
#include "test.h"

#if PD_DIM == 1
#define BOX(from, to) from " .. " to
#define SIDES
#else
#define BOX(from, to) from " .. " to ", 0 um .. 30 um"
#define SIDES "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#endif

/* A figure of the end of a run of a scene; `share`: what balances and currents are off by, together. NaN: it failed. */
static double figure(const char *text, const char *name, double *share)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    pd_figures figures;
    double value = NAN;
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    memset(&figures, 0, sizeof figures);
    desc.dry = 1;
    desc.figures = &figures;
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", text, NULL, 0, &setup))) return NAN;
    if (CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result))) {
        for (int k = 0; k < figures.count; k++) {
            char full[160];
            snprintf(full, sizeof full, "%s.%s.%s", figures.list[k].section, figures.list[k].name,
                     figures.list[k].key);
            if (strcmp(full, name) == 0) value = figures.list[k].value;
        }
        if (strcmp(name, "loss") == 0) value = result.volume_loss;
        *share = fmax(result.ledger, result.current_balance);
    }
    pd_figures_free(&ctx, &figures);
    pd_setup_free(&ctx, &setup);
    CHECK_INT(ctx.in_use, 0);
    return value;
}

/* ---- no resistance: two lines of Tafel ---- */

#define IRON \
    "[shape iron] kind = solid  material = steel304  box = " BOX("0 um", "50 um") "\n" \
    "[chemistry] activity = ideal  migration = yes\n[species Fe2+] D = 0.72e-9 m2/s\n" \
    "[species Na+] D = 1.33e-9 m2/s  initial = 500 mol/m3\n[species Cl-] D = 2.03e-9 m2/s  initial = 500 mol/m3\n" \
    "[species OH-] D = 5.27e-9 m2/s\n[species H2] D = 4.5e-9 m2/s\n[species H2O]\n[potential]\n" SIDES

#define RUSTS \
    "[transport] D = 1e-9 m2/s\n[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-  " \
    "current = 0.01 A/m2*10^((E + 0.6 V)/(60 mV))\n"

/* Iron that gives hydrogen: E and the current density where the lines cross. */
TEST(tafel)
{
    static const char text[] = "[grid] h = 5 um  threads = 1  box = " BOX("0 um", "150 um") "\n" IRON RUSTS
        "[electrode iron] shape = iron  curve = tafel  i0 = 1 mA/m2  E0 = -0.4 V  cathodic_slope = 120 mV\n"
        "reaction = 2 H2O + 2 e- = H2 + 2 OH-\n[run] until = 1 us\n";
    double share, e = (log10(0.1) * 0.12 - 0.4 - 2.0 * 0.6) / 3.0; /* 10 x 10^((E + 0.6)/0.06) = 10^(-(E + 0.4)/0.12) */
    double height = PD_DIM == 1 ? 1.0 : 3e-5;
    CHECK_NEAR(figure(text, "electrode.iron.E", &share), e, 1e-7);
    CHECK_LE(share, 1e-12);
    CHECK_REL(figure(text, "electrode.iron.anodic", &share), height * 0.01 * pow(10.0, (e + 0.6) / 0.06), 1e-5);
}


/* ---- two plates ---- */

#define GAP(h, na, cl, cu) \
    "[grid] h = " h "  threads = 1  box = " BOX("0 um", "200 um") "\n" \
    "[shape anode] kind = solid  material = steel304  box = " BOX("0 um", "50 um") "\n" \
    "[shape cathode] kind = solid  material = steel304  box = " BOX("150 um", "200 um") "\n" SIDES \
    "[chemistry] activity = ideal  migration = yes\n[species Cu2+] D = 0.71e-9 m2/s  initial = " cu " mol/m3\n" \
    "[species Na+] D = 1.33e-9 m2/s  initial = " na " mol/m3\n" \
    "[species Cl-] D = 2.03e-9 m2/s  initial = " cl " mol/m3\n[potential]\n"
#define ANODE \
    "[electrode anode] shape = anode  curve = tafel  i0 = 10 A/m2  anodic_slope = 60 mV\n" \
    "reaction = Cu = Cu2+ + 2 e-\n"
#define CATHODE(step) \
    "[electrode cathode] shape = cathode  curve = tafel  i0 = 10 A/m2  E0 = " step "  cathodic_slope = 120 mV\n" \
    "reaction = Cu2+ + 2 e- = Cu\n"

/* The same by what is on it. */
#define DEPOSITS \
    "[electrode cathode] shape = cathode  curve = expression  reaction = Cu2+ + 2 e- = Cu\n" \
    "i = -10 A/m2*[Cu2+]/(20 mol/m3)*10^(-(E - 0.5 V)/(120 mV))\n"

static const double height = PD_DIM == 1 ? 1.0 : 3e-5;

/* Wired plates, with salt that stays and near the limiting current: current and potential, at rest, and after many times
 * of diffusion. */
TEST(wired)
{
    static const plates mild = {0.71e-9, 1e-4, 50.0, 250.0, 10.0, 0.06, 0.12, 0.1, 0.0};
    static const plates steep = {0.71e-9, 1e-4, 0.5, 40.5, 10.0, 0.06, 0.12, 0.5, 20.0};
    static const char *const text[] = {
        GAP("2.5 um", "50", "250", "100") ANODE "connected = cathode\n" CATHODE("100 mV") "[run] until = 1000 s\n",
        GAP("2.5 um", "0.5", "40.5", "20") ANODE "connected = cathode\n" DEPOSITS "[run] until = 1000 s\n"};
    for (int k = 0; k < 2; k++) {
        plates_state wanted = plates_wired(k ? &steep : &mild);
        double share, off = k ? 1e-3 : 1e-6;
        CHECK_REL(figure(text[k], "electrode.anode.current", &share), height * wanted.current, off);
        CHECK_LE(share, 1e-12);
        CHECK_NEAR(figure(text[k], "electrode.anode.E", &share), wanted.anode, k ? 1e-4 : 1e-6);
        if (k) CHECK_LE(wanted.least, 1.0);
    }
}

TEST_MAIN(ENTRY(tafel) ENTRY(wired))
