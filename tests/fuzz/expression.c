/* An expression in x and C: compiled and evaluated. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const pd_expr_symbol vars[] = {{"x", "m", 0.0}, {"C", "mol/m3", 0.0}};
    static const pd_expr_symbol consts[] = {{"Csat", "mol/m3", 56.0}};
    const double at[2] = {1e-4, 10.0};
    pd_ctx ctx;
    pd_expr expr;
    pd_expr_desc desc;
    char *text = (char *)malloc(size + 1);
    if (!text) return 0;
    memcpy(text, data, size);
    text[size] = '\0';
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.vars = vars;
    desc.var_count = 2;
    desc.consts = consts;
    desc.const_count = 1;
    desc.unit = size % 2 ? "m/s" : NULL;
    fuzz_context(1000000, &ctx);
    pd_status status = pd_expr_build(&ctx, &desc, &expr);
    if (status == PD_OK) {
        double value = pd_expr_eval(&expr, at);
        FUZZ_EXPECT(!pd_expr_is_constant(&expr) || (value - value == 0.0 && value == pd_expr_eval(&expr, NULL)));
    }
    pd_expr_free(&ctx, &expr);
    fuzz_settled(&ctx, status);
    free(text);
    return 0;
}
