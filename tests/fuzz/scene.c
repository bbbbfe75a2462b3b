/* A scene or flat file: read, and built when it is small. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pd_ctx ctx;
    pd_setup setup;
    pd_model model;
    pd_memory_estimate budget;
    fuzz_context(4000000, &ctx);
    pd_status status = pd_scene_read(&ctx, fuzz_file(".scene", data, size), NULL, 0, &setup);
    if (status == PD_OK) {
        pd_memory_estimate_compute(&setup, &budget);
        FUZZ_EXPECT(pdi_file_is_subpath(setup.folder));
        FUZZ_EXPECT(budget.total_bytes > 0.0);
        if (budget.total_bytes - budget.output_bytes < 1e6 && setup.fluid_m < 4.0)
            status = pd_model_build(&ctx, &setup, &model);
        else memset(&model, 0, sizeof model);
        if (status >= 0) pd_model_free(&ctx, &model);
        pd_setup_free(&ctx, &setup);
    }
    fuzz_settled(&ctx, status);
    return 0;
}
