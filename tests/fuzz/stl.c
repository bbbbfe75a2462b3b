/* A closed surface, and distances to it. */
#include "fuzz.h"
#include "io/stl.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pd_ctx ctx;
    pd_facets facets;
    fuzz_context(50000000, &ctx);
    pd_status status = pd_facets_read(&ctx, fuzz_file(".stl", data, size), 1.0, NULL, &facets);
    FUZZ_EXPECT(status == PD_OK ? facets.count > 3 : facets.count == 0);
    for (int k = 0; status == PD_OK && k < 8; k++) {
        double x[3] = {k & 1 ? 0.1 : 2.0, k & 2 ? 0.2 : -1.0, k & 4 ? 0.3 : 0.0};
        FUZZ_EXPECT(pdi_facets_distance(&facets, x) * 0.0 >= 0.0);
    }
    pd_facets_free(&ctx, &facets);
    fuzz_settled(&ctx, status);
    return 0;
}
