/* A file of species and reactions: read, and brought to equilibrium. */
#include "fuzz.h"
#include "scene/read_electrolyte.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static pd_electrolyte e;
    pd_electrolyte_state state;
    pd_ctx ctx;
    fuzz_context(4000000, &ctx);
    pd_status status = pd_electrolyte_read(&ctx, fuzz_file(".electrolyte", data, size), NULL, 0, &e);
    if (status == PD_OK) {
        double c[PD_SPECIES_MAX];
        for (int i = 0; i < e.count; i++) FUZZ_EXPECT(e.initial[i] >= 0.0 && e.inlet[i] >= 0.0);
        memcpy(c, e.initial, sizeof c);
        status = pd_electrolyte_solve(&ctx, &e, c, &state);
        for (int i = 0; i < e.count; i++) FUZZ_EXPECT(c[i] >= 0.0 || e.species[i].phase == PD_PHASE_SOLVENT);
    }
    fuzz_settled(&ctx, status);
    return 0;
}
