/* A table: read, and every column as text and numbers. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pd_ctx ctx;
    pd_table table;
    fuzz_context(10000000, &ctx);
    pd_status status = pd_table_read(&ctx, fuzz_file(".csv", data, size), &table);
    for (int c = 0; status == PD_OK && c < table.columns; c++) {
        size_t length = 0;
        double *values = (double *)calloc((size_t)table.rows + 1, sizeof *values);
        for (int r = -1; r < table.rows; r++) length += strlen(pd_table_get_text(&table, r, c));
        FUZZ_EXPECT(length <= size);
        FUZZ_EXPECT(pd_table_find_column(&table, pd_table_get_text(&table, -1, c)) == c);
        if (values) (void)pd_table_parse_column(&ctx, &table, pd_table_get_text(&table, -1, c), values);
        free(values);
    }
    pd_table_free(&ctx, &table);
    fuzz_settled(&ctx, status);
    return 0;
}
