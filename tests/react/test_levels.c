/* levels: metals that corrode freely, and several electrodes, among ions that migrate: two lines of Tafel, a cell of
 * two plates against a closed form of its ions, oxygen that diffuses to metal, given potentials and currents, laws that
 * jump, plateaus, steps of any length; what is refused.
 * dims: 1 2 */
#include "run/run.h"
#include "scene/scene.h"
#include "cases/plates.h"
#include "test.h"

#if PD_DIM == 1
#define BOX(from, to) from " .. " to
#define SIDES
#define PER(amperes) amperes " A"
#define FINE "1 um"
#else
#define BOX(from, to) from " .. " to ", 0 um .. 30 um"
#define SIDES "[side y-] flow = mirror\n[side y+] flow = mirror\n"
#define PER(amperes) amperes " A*3e-5"
#define FINE "2.5 um"
#endif

/* A figure of the end of a run of a scene; `share`: what balances and currents are off by, together. NaN: it failed. */
static double figure(const char *text, const char *name, double *share)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_run_desc desc;
    pd_run_result result;
    pd_scalar_outputs figures;
    double value = NAN;
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    memset(&figures, 0, sizeof figures);
    desc.no_files = 1;
    desc.figures = &figures;
    if (!CHECK_OK(&ctx, pd_scene_parse(&ctx, "a.scene", text, NULL, 0, &setup))) return NAN;
    if (CHECK_OK(&ctx, pd_run(&ctx, &setup, &desc, &result))) {
        for (int k = 0; k < figures.count; k++) {
            char full[160];
            snprintf(full, sizeof full, "%s.%s.%s", figures.list[k].section, figures.list[k].name,
                     figures.list[k].key);
            if (strcmp(full, name) == 0) value = figures.list[k].value;
        }
        *share = fmax(result.mass_balance_error, result.current_balance);
    }
    pd_scalar_outputs_free(&ctx, &figures);
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
        "reaction = 2 H2O + 2 e- = H2 + 2 OH-\n[run] until = 1 ms\n";
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

/* Wired plates, with salt that stays and near the limiting current: current and potential after many times of
 * diffusion. */
TEST(wired)
{
    static const plates mild = {0.71e-9, 1e-4, 50.0, 250.0, 10.0, 0.06, 0.12, 0.1, 0.0};
    static const plates steep = {0.71e-9, 1e-4, 0.5, 40.5, 10.0, 0.06, 0.12, 0.5, 20.0};
    static const char *const text[] = {
        GAP("2.5 um", "50", "250", "100") ANODE "connected = cathode\n" CATHODE("100 mV") "[run] until = 1000 s\n",
        GAP(FINE, "0.5", "40.5", "20") ANODE "connected = cathode\n" DEPOSITS "[run] until = 1000 s\n"};
    for (int k = 0; k < 2; k++) {
        plates_state wanted = plates_wired(k ? &steep : &mild);
        double share, off = k ? (PD_DIM == 1 ? 1e-3 : 4e-3) : 1e-6;
        CHECK_REL(figure(text[k], "electrode.anode.current", &share), height * wanted.current, off);
        CHECK_LE(share, 1e-12);
        CHECK_NEAR(figure(text[k], "electrode.anode.E", &share), wanted.anode, k ? 2e-4 : 1e-6);
        if (k) CHECK_LE(wanted.least, 1.0);
    }
}


/* Given currents: both potentials, which float. Given potentials: the same current, whatever they count from. */
TEST(given)
{
    static const plates mild = {0.71e-9, 1e-4, 50.0, 250.0, 10.0, 0.06, 0.12, 0.1, 0.0};
    static const char amperes[] =
        GAP("5 um", "50", "250", "100") ANODE "current = " PER("20") "\n" CATHODE("100 mV") "current = " PER("-20")
        "\n[run] until = 1000 s\n";
    plates_state wanted = plates_given(&mild, 20.0), wired = plates_wired(&mild);
    double share;
    char volts[2048];
    CHECK_NEAR(figure(amperes, "electrode.anode.E", &share), wanted.anode, 1e-7);
    CHECK_NEAR(figure(amperes, "electrode.cathode.E", &share), wanted.cathode, 1e-7);
    CHECK_LE(share, 1e-12);
    snprintf(volts, sizeof volts, "%s%spotential = %.17g V\n%spotential = %.17g V\n[run] until = 1000 s\n",
             GAP("5 um", "50", "250", "100"), ANODE, 1.0 + wired.anode, CATHODE("100 mV"), 1.0 + wired.cathode);
    CHECK_REL(figure(volts, "electrode.cathode.current", &share), -height * wired.current, 1e-6);
    CHECK_LE(share, 1e-12);
}

/* ---- laws that jump, end or reach a limit ---- */

#define OPEN(law, curve, until) \
    "[grid] h = 5 um  threads = 1  box = " BOX("0 um", "150 um") "\n[side x+] species = inlet\n" IRON \
    "[species O2] D = 2e-9 m2/s  initial = 0.25 mol/m3\n[transport] D = 1e-9 m2/s\n" \
    "[dissolve] charge = 2  reaction = Fe = Fe2+ + 2 e-  current = " law "\n" \
    "[electrode iron] shape = iron  " curve "\n[run] until = " until "\n"
#define HYDROGEN \
    "curve = tafel  i0 = 1 mA/m2  E0 = -0.4 V  cathodic_slope = 120 mV\nreaction = 2 H2O + 2 e- = H2 + 2 OH-"
#define OXYGEN \
    "curve = expression  i = -1 mA/m2*[O2]/(0.25 mol/m3)*10^(-(E + 0.1 V)/(120 mV))\n" \
    "reaction = O2 + 2 H2O + 4 e- = 4 OH-"

TEST(jumps)
{
    static const char jump[] = OPEN("if(E < -0.5 V, 0 A/m2, 1 A/m2)", HYDROGEN, "10 ms");
    static const char limit[] = OPEN("0.01 A/m2*10^((E + 0.6 V)/(60 mV))", HYDROGEN "\ncathodic_limit = 0.5 mA/m2",
                                     "1 us");
    double share, wanted = 0.001 * pow(10.0, 0.1 / 0.12);
    CHECK_NEAR(figure(jump, "electrode.iron.E", &share), -0.5, 1e-4); /* and the potential at its surface */
    CHECK_REL(figure(jump, "electrode.iron.anodic", &share), height * wanted, 1e-13);
    CHECK_LE(share, 1e-12);
    CHECK_LE(figure(limit, "electrode.iron.anodic", &share), height * 0.5e-3);
    CHECK_LE(height * 0.4e-3, figure(limit, "electrode.iron.anodic", &share));
    CHECK_LE(share, 1e-12);
}

/* Oxygen diffuses to iron: it does not migrate, so the current follows from E - phi alone. */
TEST(oxygen)
{
    static const char text[] = OPEN("0.01 A/m2*10^((E + 0.6 V)/(60 mV))", OXYGEN, "100 s");
    double low = -1.0, high = 0.0, share, most = 4.0 * PLATES_FARADAY * 2e-9 * 0.25 / 1e-4, i = 0.0;
    for (int k = 0; k < 100; k++) {
        double u = 0.5 * (low + high), curve = 0.001 * pow(10.0, -(u + 0.1) / 0.12);
        i = most * curve / (most + curve);
        if (0.01 * pow(10.0, (u + 0.6) / 0.06) > i) high = u;
        else low = u;
    }
    CHECK_REL(figure(text, "electrode.iron.anodic", &share), height * i, 1e-4);
    CHECK_LE(share, 1e-12);
}

/* One step of any length, in a gap that nothing leaves and in an open one: balances close. */
TEST(any_step)
{
    static const char *const until[] = {"1 ns", "1 s", "1e6 s", "1e9 s"};
    for (int k = 0; k < 4; k++) {
        char text[2048];
        double share;
        snprintf(text, sizeof text, "%s%sconnected = cathode\n%s[run] until = %s  rtol = 0.1\n",
                 GAP("5 um", "0.5", "40.5", "20"), ANODE, DEPOSITS, until[k]);
        CHECK(figure(text, "electrode.anode.current", &share) > 0.0);
        CHECK_LE(share, 1e-12);
    }
}

#if PD_DIM == 2
/* A gap along metal that is held over its mouth: a line with losses, phi'' = (phi - E)/(R kappa w). */
TEST(gap)
{
    static const char text[] =
        "[grid] h = 12.5 um  threads = 1  box = 0 mm .. 2 mm, -50 um .. 50 um\n[side x+] species = inlet\n"
        "[shape metal] kind = solid  material = steel304  box = 0 mm .. 2 mm, -50 um .. 0 um\n"
        "[chemistry] activity = ideal  migration = yes\n[species Cu2+] D = 0.71e-9 m2/s\n"
        "[species Na+] D = 1.33e-9 m2/s  initial = 500 mol/m3\n"
        "[species Cl-] D = 2.03e-9 m2/s  initial = 500 mol/m3\n[potential]\n"
        "[electrode metal] shape = metal  curve = linear  polarisation_resistance = 8e-4 ohm*m2  potential = 10 mV\n"
        "reaction = Cu = Cu2+ + 2 e-\n[run] until = 1 ms\n";
    double share, kappa = PLATES_FARADAY / PLATES_VOLT * (1.33e-9 + 2.03e-9) * 500.0, w = 5e-5, length = 2e-3;
    double resist = 8e-4 + w / (3.0 * kappa), wide = sqrt(resist * kappa * w); /* a third of the way across */
    CHECK_REL(figure(text, "electrode.metal.current", &share), 0.01 / resist * wide * tanh(length / wide), 2e-3);
    CHECK_LE(share, 1e-12);
}
#define GAPS ENTRY(gap)
#else
#define GAPS
#endif

/* ---- refused ---- */

#define READS \
    "[electrode anode] material = steel304  curve = expression  i = 1 A/m2*[Cu2+]/(1 mol/m3)*(1 + E/(1 V))\n" \
    "reaction = Cu = Cu2+ + 2 e-  "

TEST(refused)
{
    static const char *const bad[][2] = {
        {GAP("5 um", "50", "250", "100") "conductivity = 1 S/m\n" ANODE CATHODE("0 V") "[run] until = 1 s\n",
         "it is that of the ions"},
        {GAP("5 um", "50", "250", "100") "[electrode anode] material = steel304  curve = tafel  i0 = 1 A/m2  "
                                         "anodic_slope = 60 mV\n[run] until = 1 s\n",
         "the half-reaction by which"},
        {GAP("5 um", "50", "250", "100") "[electrode anode] material = steel304  curve = primary\n"
                                         "reaction = Cu = Cu2+ + 2 e-\n[run] until = 1 s\n",
         "expected another curve"},
        {GAP("5 um", "50", "250",
             "100") "[electrode anode] material = steel304  curve = expression\n"
                    "i = -1 A/m2*[Cu2+]/(1 mol/m3)*E/(1 V)  reaction = Cu = Cu2+ + 2 e-\n[run] until = 1 s\n",
         "a current that falls"},
        {GAP("5 um", "50", "250", "100") "[electrode anode] material = steel304  curve = expression\n"
                                         "i = 1 A/m2*(pH + E/(1 V))  reaction = Cu = Cu2+ + 2 e-\n[run] until = 1 s\n",
         "without the species H+"},
        {GAP("5 um", "50", "250", "100") READS "film = 0.5 ohm m2\n[run] until = 1 s\n",
         "film_resistance: found beside a curve in"},
        {GAP("5 um", "50", "250", "100") READS "range = -1 V .. 1 V\n[run] until = 1 s\n",
         "range: found beside a curve in"},
        {GAP("5 um", "50", "250", "100") ANODE CATHODE("0 V") "[side x-] potential = 1 V\n[run] until = 1 s\n",
         "at the potential 0"},
        {OPEN("i", HYDROGEN, "1 s"), "the anodic law itself"},
        {OPEN("0.1 A/m2", HYDROGEN, "1 s"), "a law without E"},
        {OPEN("0.1 A/m2*E/(1 V)", HYDROGEN, "1 s") "[dissolve] potential = 0 V\n", "potential"},
        {"[constants] E = 1 V\n" OPEN("0.1 A/m2*E/(1 V)", HYDROGEN, "1 s"), "name 'E'"}};
    static const char *const lost[][2] = {
        {OPEN("0 A/m2*E/(1 V)", HYDROGEN, "1 s"), "no potential was found that gives the metal of iron"},
        {GAP("5 um", "50", "250", "100") ANODE "current = " PER("20") "\n" CATHODE("0 V") "current = " PER("-10")
         "\n[run] until = 1 s\n",
         "sum to "}};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0] + sizeof lost / sizeof lost[0]; k++) {
        int runs = k >= sizeof bad / sizeof bad[0];
        const char *const *each = runs ? lost[k - sizeof bad / sizeof bad[0]] : bad[k];
        pd_ctx ctx;
        pd_setup setup;
        pd_run_desc desc;
        pd_run_result result;
        pd_ctx_init(&ctx);
        memset(&desc, 0, sizeof desc);
        desc.no_files = 1;
        pd_status status = pd_scene_parse(&ctx, "a.scene", each[0], NULL, 0, &setup);
        if (status == PD_OK) {
            status = runs ? pd_run(&ctx, &setup, &desc, &result) : PD_OK;
            pd_setup_free(&ctx, &setup);
        }
        CHECK(status < 0);
        if (!CHECK(strstr(ctx.message, each[1]) != NULL)) NOTE("%d: %s", (int)k, ctx.message);
        CHECK_INT(ctx.in_use, 0);
    }
}

/* A circuit that no potential gives its current to has a message, with fluid beside its metal and without. */
TEST(lost_circuits_are_named)
{
    static pd_setup setup;
    static pd_etch etch;
    int member[3] = {0, 1, 1};
    int32_t at[1] = {2};
    pd_etch_circuit circuit[2];
    pd_species_electrodes electrodes;
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    memset(circuit, 0, sizeof circuit);
    memset(&electrodes, 0, sizeof electrodes);
    setup.potential.electrodes = 3;
    for (int e = 0; e < 3; e++) snprintf(setup.potential.electrode[e].name, 8, "metal%c", 'A' + e);
    etch.desc.electrodes.member = member;
    etch.desc.electrodes.circuit = circuit;
    etch.desc.electrodes.circuits = 2;
    etch.electrode = at;
    electrodes.setup = &setup;
    electrodes.etch = &etch;
    CHECK_OK(&ctx, pdi_species_electrodes_check_solved(&ctx, &electrodes));
    etch.lost = 2;
    for (int places = 0; places < 2; places++) {
        etch.count = places;
        CHECK_INT(pdi_species_electrodes_check_solved(&ctx, &electrodes), PD_ERR_STATE);
        CHECK(strstr(ctx.message, places ? "the metal of metalC a" : "the metal of metalB a") != NULL);
    }
}

TEST_MAIN(ENTRY(tafel) ENTRY(wired) ENTRY(given) ENTRY(jumps) ENTRY(oxygen) ENTRY(any_step) GAPS ENTRY(refused)
              ENTRY(lost_circuits_are_named))
