/* active_range: vectors of nodes in ranges, packed and back.
 * dims: 2 */
#include "lattice/active_range.h"
#include "test.h"

/* Two components go into packed vectors and back: all nodes outside of the ranges become zero, also where there are no
 * ranges. */
TEST(pack_and_unpack)
{
    pd_ctx ctx;
    int32_t first[2] = {2, 5}, start[2] = {0, 1}, length[2] = {1, 2};
    pd_active_ranges spans = {2, 2, first, start, length, 3, 9};
    pd_ctx_init(&ctx);
    for (int none = 0; none < 2; none++) {
        double full[19], packed[7];
        for (int i = 0; i < 19; i++) full[i] = 1.0 + i;
        for (int i = 0; i < 7; i++) packed[i] = -1.0;
        if (none) spans.count = spans.packed_length = 0;
        pdi_active_range_pack(&ctx, &spans, 2, full, packed);
        for (int i = 0; i < 6; i++) {
            static const double nodes[6] = {3.0, 6.0, 7.0, 12.0, 15.0, 16.0};
            CHECK_NEAR(packed[i], none ? -1.0 : nodes[i], 0.0);
        }
        CHECK_NEAR(packed[6], -1.0, 0.0);
        pdi_active_range_unpack(&ctx, &spans, 2, packed, full);
        for (int i = 0; i < 18; i++) {
            int node = i % 9, in = !none && (node == 2 || node == 5 || node == 6);
            CHECK_NEAR(full[i], in ? 1.0 + i : 0.0, 0.0);
        }
        CHECK_NEAR(full[18], 19.0, 0.0);
    }
}

TEST_MAIN(ENTRY(pack_and_unpack))
