/* interval: bounds of expressions hold all values, and close in on them. */
#include "setup/interval.h"
#include "test.h"

static const pd_expr_symbol vars[] = {{"x", "", 0}, {"t", "", 0}};

static const double table_x[] = {0.0, 1.0, 2.0, 3.0}, table_y[] = {0.0, 4.0, 4.0, -1.0};

static pd_status build(pd_ctx *ctx, const char *text, const pd_expr_table *table, pd_expr *expr)
{
    pd_expr_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.vars = vars;
    desc.var_count = 2;
    desc.tables = table;
    desc.table_count = 1;
    return pd_expr_build(ctx, &desc, expr);
}

static const char *const texts[] = {
    "t", "-t", "t + x", "x - t*t", "t/(x + 3)", "1/t", "sin(3*t)", "cos(20*t)*x", "tan(t)", "exp(-t)", "log(t + 5)",
    "log10(t + 5)", "tanh(t)", "sinh(t)", "cosh(t - 1)", "atan(5*t)", "erf(t)", "floor(2*t)", "abs(t - 0.3)",
    "sqrt(t + 6)", "sqrt(t)", "min(t, x)", "max(sin(t), 0.2)", "atan2(t, x)", "atan2(x, t)", "pow(t + 5, x)", "t^2",
    "t^3", "t^-2", "(t + 6)^1.5", "t^0.5", "if(t > 1, 2, -t)", "if(t < x, t, x)", "if(t >= 0, if(t <= 0.01, 7, 1), 0)",
    "(t > 0) + (t < 1)*(x >= t)", "f(t)", "f(t + 1)*x", "if(sin(2*pi*t) > 0.9, 1, 0)", "if(t > 0, log(t), 0)",
    "t - t", "t*t*t - 2*t"};

/* Random intervals: no value lies outside of the bounds. */
TEST(bounds_hold_all_values)
{
    pd_ctx ctx;
    pd_monotone_cubic curve;
    pd_expr_table table;
    uint32_t state = 1;
    int64_t checked = 0;
    pd_ctx_init(&ctx);
    memset(&table, 0, sizeof table);
    CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, table_x, table_y, 4, 0, &curve));
    table.name = "f";
    table.curve = &curve;
    for (int k = 0; k < (int)(sizeof texts / sizeof *texts); k++) {
        pd_expr expr;
        if (!CHECK_OK(&ctx, build(&ctx, texts[k], &table, &expr))) continue;
        for (int trial = 0; trial < 300; trial++) {
            double at[PD_EXPR_VARS], draw[3];
            memset(at, 0, sizeof at);
            for (int n = 0; n < 3; n++) {
                state = state * 1664525u + 1013904223u;
                draw[n] = (double)(state >> 8) / 16777216.0;
            }
            double a = 8.0 * draw[0] - 4.0, b = a + 3.0 * draw[1] * draw[1] * draw[1];
            at[0] = 4.0 * draw[2] - 2.0;
            pdi_interval range = pdi_interval_eval_expr(&expr, at, 1, a, b);
            for (int n = 0; n <= 100; n++) {
                at[1] = a + (b - a) * n / 100.0;
                double value = pd_expr_eval(&expr, at), slack = 1e-12 * fabs(value);
                checked++;
                if (isnan(value)) { /* then any number may come */
                    value = HUGE_VAL;
                    slack = 0.0;
                }
                if (!(value >= range.low - slack) || !(value <= range.high + slack)) {
                    CHECK(0);
                    NOTE("%s at x = %g, t = %g is %g, not from %g to %g", texts[k], at[0], at[1], value, range.low,
                         range.high);
                    break;
                }
            }
        }
        pd_expr_free(&ctx, &expr);
    }
    CHECK(checked > 1000000);
    pdi_monotone_cubic_free(&ctx, &curve);
    CHECK_INT(ctx.in_use, 0);
}

typedef struct known {
    const char *text;
    double a, b, low, high;
} known;

/* What can be said by hand, with x = 0.5. */
TEST(bounds_are_those_of_the_function)
{
    static const known list[] = {
        {"sin(t)", 0.0, 1.0, 0.0, 0.8414709848078965}, {"sin(t)", 1.0, 2.0, 0.8414709848078965, 1.0},
        {"sin(t)", 4.0, 5.0, -1.0, -0.7568024953079282}, {"cos(t)", -1.0, 1.0, 0.5403023058681398, 1.0},
        {"cos(t)", 0.0, 7.0, -1.0, 1.0}, {"cos(t)", 100.0, 101.0, 0.8623188722876839, 1.0},
        {"t^2", -1.0, 3.0, 0.0, 9.0},
        {"t^3", -1.0, 3.0, -1.0, 27.0}, {"abs(t)", -2.0, -1.0, 1.0, 2.0}, {"if(t > 2, 5, 3)", 0.0, 1.0, 3.0, 3.0},
        {"if(t > 2, 5, 3)", 1.0, 3.0, 3.0, 5.0}, {"if(t > 2, 5, 3)", 2.5, 3.0, 5.0, 5.0},
        {"f(t)", 0.0, 3.0, -1.0, 4.0}, {"f(t)", 1.2, 1.8, 4.0, 4.0}, {"floor(t)", 0.5, 2.5, 0.0, 2.0},
        {"t*x", -2.0, 2.0, -1.0, 1.0}, {"1/t", 1.0, 4.0, 0.25, 1.0}, {"min(t, x)", 0.0, 1.0, 0.0, 0.5}};
    pd_ctx ctx;
    pd_monotone_cubic curve;
    pd_expr_table table;
    double at[PD_EXPR_VARS];
    pd_ctx_init(&ctx);
    memset(&table, 0, sizeof table);
    memset(at, 0, sizeof at);
    at[0] = 0.5;
    CHECK_OK(&ctx, pd_monotone_cubic_build(&ctx, table_x, table_y, 4, 0, &curve));
    table.name = "f";
    table.curve = &curve;
    for (int k = 0; k < (int)(sizeof list / sizeof *list); k++) {
        pd_expr expr;
        if (!CHECK_OK(&ctx, build(&ctx, list[k].text, &table, &expr))) continue;
        pdi_interval range = pdi_interval_eval_expr(&expr, at, 1, list[k].a, list[k].b);
        if (!CHECK_NEAR(range.low, list[k].low, 1e-9) || !CHECK_NEAR(range.high, list[k].high, 1e-9))
            NOTE("%s from %g to %g", list[k].text, list[k].a, list[k].b);
        pd_expr_free(&ctx, &expr);
    }
    pdi_monotone_cubic_free(&ctx, &curve);
}

/* Pulse of the caller from 3 to 3.001. */
static double pulse(void *user, const double *at)
{
    (void)user;
    return at[1] > 3.0 && at[1] < 3.001 ? 1.0 : 0.25;
}

TEST(functions_tell_their_breaks)
{
    double at[PD_EXPR_VARS], breaks[2] = {3.0, 3.001};
    pd_expr expr;
    memset(at, 0, sizeof at);
    memset(&expr, 0, sizeof expr);
    expr.fn = pulse;
    expr.variables_used = 2;
    pdi_interval range = pdi_interval_eval_expr(&expr, at, 1, 0.0, 10.0);
    CHECK_NEAR(range.high, 0.25, 0.0);
    expr.discontinuities = breaks;
    expr.discontinuity_count = 2;
    expr.time_variable = 1;
    range = pdi_interval_eval_expr(&expr, at, 1, 0.0, 10.0);
    CHECK(!(range.high < 1e100));
    range = pdi_interval_eval_expr(&expr, at, 1, 3.0004, 3.0006);
    CHECK_NEAR(range.low, 1.0, 0.0);
}

TEST_MAIN(ENTRY(bounds_hold_all_values) ENTRY(bounds_are_those_of_the_function) ENTRY(functions_tell_their_breaks))
