/* evolved_gas: what dissolution evolves is that of the metal that is lost, whether the law reads the species or not.
 * dims: 1 2 */
#define _XOPEN_SOURCE 700
#include "scene_file.h"
#include <math.h>

#if PD_DIM == 1
#define ACROSS
#define AREA 1.0
#else
#define ACROSS ", 0 um .. 20 um"
#define AREA 20e-6
#endif

#define SCENE \
    "[grid] h = 10 um  m = 1  box = 0 um .. 120 um" ACROSS "\n" \
    "[shape slab] box = 0 um .. 40 um" ACROSS "  kind = solid  material = mg4ag\n" \
    "[species H+] D = 9.3e-9 m2/s  initial = 1e-4 mol/m3\n[species OH-] D = 5.3e-9 m2/s  initial = 1e-4 mol/m3\n" \
    "[species Mg2+] D = 7e-10 m2/s\n[reaction water] H2O = H+ + OH-  log10_K = -14\n[transport] D = 1e-9 m2/s\n" \
    "[dissolve] reaction = Mg + 2 H2O = Mg2+ + 2 OH- + H2(g)  "
#define RUN "\n[run] until = 20 min\n[output] every = 10 min\n"

/* [mol] of gas over [mol] of metal that is gone. */
static void gas_of_metal(const char *text)
{
    pd_ctx ctx;
    pd_setup u;
    pd_run_desc desc;
    pd_run_result r;
    memset(&desc, 0, sizeof desc);
    desc.no_files = 1;
    if (!CHECK_OK(&ctx, load(&ctx, text, NULL, 0, &u))) return;
    if (CHECK_OK(&ctx, pd_run(&ctx, &u, &desc, &r))) {
        double lost = r.volume_loss * 40e-6 * AREA * u.metal[0].solid_c;
        CHECK(r.evolves_gas && r.volume_loss > 0.01);
        CHECK_NEAR(r.gas, lost, 1e-11 * lost);
    }
    leave(&ctx, &u);
}

TEST(one_gas_for_one_metal)
{
    gas_of_metal(SCENE "rate = 10 um/h" RUN);
    gas_of_metal(SCENE "rate = 10 um/h * 10^(0.05*(7 - pH))" RUN);
    gas_of_metal(SCENE "rate = 10 um/h * 10^(0.05*(7 - pH))" RUN "[run] rtol = 0.1  max_step = 10 min\n");
}

TEST_MAIN(ENTRY(one_gas_for_one_metal))
