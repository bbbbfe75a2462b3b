/* Points of a table or a mesh, whichever the first bytes say. */
#include "fuzz.h"
#include "io/points_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pd_ctx ctx;
    pd_points points;
    fuzz_context(50000000, &ctx);
    pd_status status = pd_points_read(&ctx, fuzz_file(".any", data, size), 1.0, &points);
    FUZZ_EXPECT(status == PD_OK ? points.count > 0 : points.count == 0);
    for (int32_t k = 0; k < points.count; k++) {
        FUZZ_EXPECT(points.volume[k] > 0.0 && points.volume[k] < 1e100);
        for (int d = 0; d < PD_DIM; d++) FUZZ_EXPECT(points.position[k * PD_DIM + d] * 0.0 >= 0.0);
    }
    pd_points_free(&ctx, &points);
    fuzz_settled(&ctx, status);
    return 0;
}
