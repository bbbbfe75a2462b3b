/* units and expr: values against closed forms and the C library, dimensions, messages, hostile text. */
#include "setup/expr.h"
#include "fault.h"

typedef struct sample {
    const char *text, *unit;
    double value;
} sample;

static const pd_expr_symbol vars[] = {{"x", "m", 0}, {"y", "m", 0}, {"t", "s", 0}, {"C", "mol/m3", 0}, {"n", "", 0}};
static const pd_expr_symbol consts[] = {{"Csat", "mol/m3", 5600}, {"U", "m/s", 0.25}};
enum { VARS = 5, CONSTS = 2 };
static const double at[VARS] = {3e-6, 4e-6, 10, 1400, 7};

static pd_status build(pd_ctx *ctx, const char *text, const char *unit, int bare, pd_expr *expr)
{
    pd_expr_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.text = text;
    desc.vars = vars;
    desc.var_count = VARS;
    desc.consts = consts;
    desc.const_count = CONSTS;
    desc.unit = unit;
    desc.allow_bare = bare;
    return pd_expr_build(ctx, &desc, expr);
}

static void check_value(const char *text, const char *unit, double value, double tol)
{
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    if (CHECK_OK(&ctx, build(&ctx, text, unit, 0, &expr)) && !CHECK_REL(pd_expr_eval(&expr, at), value, tol))
        NOTE("in '%s'", text);
    pd_expr_free(&ctx, &expr);
    CHECK_INT(ctx.in_use, 0);
}

/* The message must contain every given part. */
static void check_error(const char *text, const char *unit, const char *part, const char *part2)
{
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    CHECK_INT(build(&ctx, text, unit, 0, &expr), PD_ERR_PARSE);
    if (!CHECK(strstr(ctx.message, part) != NULL) || !CHECK(strstr(ctx.message, part2) != NULL))
        NOTE("'%s' gave: %s (expected %s %s)", text, ctx.message, part, part2);
    CHECK(expr.code == NULL);
    CHECK_INT(ctx.in_use, 0);
}

/* A unit rounds once: the literal in SI has the same bits. */
TEST(literals_with_units)
{
    static const sample list[] = {
        {"80 um", "m", 80e-6},
        {"80um", "m", 80e-6},
        {"80 \xC2\xB5m", "m", 80e-6},
        {"5 um", "m", 5e-6},
        {"0.1 kg", "kg", 0.1},
        {"1738 kg/m3", "kg/m3", 1738},
        {"1738 kg m-3", "kg/m3", 1738},
        {"1738 kg/m^3", "kg/m3", 1738},
        {"1.7 g/cm3", "kg/m3", 1700},
        {"0.236 m/s", "m/s", 0.236},
        {"1 mL/min", "m3/s", 1e-6 / 60},
        {"1e-3 Pa s", "Pa s", 1e-3},
        {"1e-3 Pa*s", "Pa s", 1e-3},
        {"1 cP", "Pa s", 1e-3},
        {"1e-9 m2/s", "m2/s", 1e-9},
        {"720 um2/s", "m2/s", 720e-12},
        {"71.5 mol/m3", "mol/m3", 71.5},
        {"1 kmol/m^3", "mol/m3", 1e3},
        {"5.6 M", "mol/m3", 5600},
        {"2 mmol/L", "mol/m3", 2},
        {"5 A/cm2", "A/m2", 5e4},
        {"200 mV", "V", 0.2},
        {"12 kJ/mol", "J/mol", 12e3},
        {"8 J/(mol K)", "J/mol/K", 8},
        {"8 J mol-1 K-1", "J/mol/K", 8},
        {"9 h", "s", 32400},
        {"15 min", "s", 900},
        {"1 year", "s", 31557600},
        {"1 mm/year", "m/s", 1e-3 / 31557600},
        {"1 mpy", "m/s", 25.4e-6 / 31557600},
        {"1.3 um/h", "m/s", 1.3 / 3.6e9},
        {"3 MPa m^0.5", "kg m^-0.5 s-2", 3e6},
        {"50 %", "", 0.5},
        {"180 deg", "", 3.14159265358979323846},
        {"2 1/s", "1/s", 2},
        {"2 /s", "1/s", 2},
        {"1/min", "1/s", 1.0 / 60},
        {"6/2/s", "1/s", 3},
        {"2 1/s m", "m/s", 2},
        {"1e-3 m-1", "1/m", 1e-3},
        {".5 m", "m", 0.5},
        {"5. m", "m", 5},
        {"1E+3 m", "m", 1000},
        {"0.000000000000000000000000000000000001e36 m", "m", 1},
        {"123456789012345678901234567890 m", "m", 1.2345678901234568e29},
        {"0 um", "m", 0},
        {"0", "m/s", 0},
        {"-0", "K", 0}};
    for (int k = 0; k < (int)(sizeof list / sizeof list[0]); k++)
        check_value(list[k].text, list[k].unit, list[k].value, 2.3e-16);
    /* one rounding: bit for bit */
    check_value("80 um", "m", 80e-6, 0);
    check_value("5 um", "m", 5e-6, 0);
    check_value("0.7 um", "m", 0.7e-6, 0);
    check_value("0.3 mm", "m", 0.3e-3, 0);
    check_value("1e-9 m2/s", "m2/s", 1e-9, 0);
    check_value("0.1 kg", "kg", 0.1, 0);
    check_value("720 um2/s", "m2/s", 720e-12, 0);
}

/* Numbers are read as strtod reads them. */
TEST(numbers_as_strtod)
{
    static const char *const list[] = {"0.1", "3.141592653589793238462643383279", "1e-300", "4.9e-324", "2.5e-310",
                                       "1.7e300", "9007199254740993", "0.30000000000000004", "1e23", "5e-5"};
    for (int k = 0; k < (int)(sizeof list / sizeof list[0]); k++) check_value(list[k], "", strtod(list[k], NULL), 0);
}

TEST(operators_and_functions)
{
    static const sample list[] = {
        {"1 + 2*3", "", 7},
        {"2^3^2", "", 512},
        {"-2^2", "", -4},
        {"2^-1", "", 0.5},
        {"- -3", "", 3},
        {"-+3", "", -3},
        {"2*-3", "", -6},
        {"8/4/2", "", 1},
        {"7 - 2 - 1", "", 4},
        {"(1 + 2)*3", "", 9},
        {"1 < 2", "", 1},
        {"2 <= 2", "", 1},
        {"2 > 2", "", 0},
        {"2 >= 3", "", 0},
        {"1 + 1 < 3", "", 1},
        {"if(n > 5, 10, 20)", "", 10},
        {"if(n < 5, 10, 20)", "", 20},
        {"if(x > y, 1 m, 0)", "m", 0},
        {"min(3, 2) + max(3, 2)", "", 5},
        {"max(0, y - x)", "m", 1e-6},
        {"max(0, x - y)", "m", 0},
        {"abs(x - y)", "m", 1e-6},
        {"sqrt(x^2 + y^2)", "m", 5e-6},
        {"sqrt(16 um2)", "m", 4e-6},
        {"pow(2 um, 2)", "m2", 4e-12},
        {"3 m^2", "m2", 3},
        {"(3 m)^2", "m2", 9},
        {"x^2", "m2", 9e-12},
        {"atan2(x, y)", "", 0.64350110879328438680},
        {"sin(0.5)", "", 0.47942553860420300027},
        {"cos(0.5)", "", 0.87758256189037271612},
        {"tan(0.5)", "", 0.54630248984379051326},
        {"exp(1)", "", 2.71828182845904523536},
        {"log(10)", "", 2.30258509299404568402},
        {"log10(1000)", "", 3},
        {"tanh(0.5)", "", 0.46211715726000975850},
        {"sinh(0.5)", "", 0.52109530549374736162},
        {"cosh(0.5)", "", 1.12762596520638078523},
        {"atan(1)", "", 0.78539816339744830962},
        {"erf(0.5)", "", 0.52049987781304653768},
        {"floor(-1.5)", "", -2},
        {"pi", "", 3.14159265358979323846},
        {"R*300 K/F", "V", 0.025851999786435527},
        {"1 - C/Csat", "", 0.75},
        {"1.3 um/h*(1 - C/Csat)", "m/s", 0.75 * 1.3 / 3.6e9},
        {"1.5*U*(1 - (y/8 um)^2)", "m/s", 0.28125},
        {"U*t", "m", 2.5},
        {"x/s", "m/s", 3e-6},
        {"(x + y)/(m s)", "1/s", 7e-6},
        {"x/(2 s)", "m/s", 1.5e-6},
        {"15 min/min(2, 3)", "s", 450},
        {"0*x", "K", 0},
        {"n*min(1, 2)", "", 7}};
    for (int k = 0; k < (int)(sizeof list / sizeof list[0]); k++)
        check_value(list[k].text, list[k].unit, list[k].value, 3 * 2.22e-16); /* a few roundings */
    check_value("(8 um3)^(1/3)", "m", 2e-6, 1e-15); /* ln(8e-18) times the rounding of 1/3 */
}

TEST(dimensions_are_checked)
{
    check_error("3 um + 2 s", "m", "column 8: found a time [s]", "expected a length [m] as on the left of '+'");
    check_error("3 um", "m/s", "column 1: found a length [m]", "expected a speed [m/s]");
    check_error("1 + 2 um", "", "column 5: found a length [m]", "expected a plain number");
    check_error("exp(x)", "", "column 5: found a length [m]", "expected a plain number as the argument of exp");
    check_error("min(x, t)", "m", "column 8: found a time [s]",
                "expected a length [m] as in the first argument of min");
    check_error("if(x, 1, 2)", "", "column 4: found a length [m]", "plain number");
    check_error("if(n, x, t)", "m", "column 10: found a time [s]", "other branch of if");
    check_error("x < t", "", "column 5: found a time [s]", "left of the comparison");
    check_error("2^x", "", "column 3: found a length [m]", "exponent");
    check_error("x^n", "m", "column 3", "exponent must be a constant");
    check_error("5", "m", "without unit, expected a length [m]", "um");
    check_error("1000", "kg/m3", "without unit, expected a density [kg/m3]", "for example kg/m3");
    check_error("1e-3*(1 - C/Csat)", "m/s", "without unit, expected a speed", "um/h");
    check_error("x*t", "m", "found a quantity [m s]", "expected a length [m]");
    check_error("1 C", "mol/m3", "found 'C'", "expected an operator");
    check_error("37 degC", "K", "column 4", "write the temperature in K");
    check_error("37 \xC2\xB0" "C", "K", "column 4", "write the temperature in K");
    check_error("3 m ^ 2", "m2", "column", "write '^' directly after the unit");
    check_error("3 m^x", "m2", "the exponent of a unit is a number", "(3 m)^2");
    check_error("3 m^99", "m", "exponent of a unit lies outside", "12");
}

TEST(messages_name_the_place)
{
    check_error("", "m", "column 1: found the end", "expected a number");
    check_error("   ", "m", "column 4: found the end", "expected a number");
    check_error("1 +", "", "column 4: found the end", "expected a number");
    check_error("(1 + 2", "", "column 7: found the end", "')'");
    check_error("1)", "", "column 2: found ')'", "expected an operator or the end");
    check_error("3 x", "m", "column 3: found 'x'", "expected an operator");
    check_error("3 umm", "m", "column 3: found 'umm'", "did you mean 'um'?");
    check_error("C/Csta", "", "column 3: found 'Csta'", "did you mean 'Csat'?");
    check_error("sqr(4)", "", "column 1: found 'sqr'", "did you mean 'sqrt'?");
    check_error("um", "m", "column 1: found the unit 'um'", "expected a number before it");
    check_error("atan2(1)", "", "column 8: found ')'", "atan2 takes 2 arguments");
    check_error("sin(1, 2)", "", "column 6: found ','", "sin takes 1 argument");
    check_error("sin 1", "", "column 1: found the function 'sin'", "expected '(' after it");
    check_error("1 < 2 < 3", "", "column 7", "comparisons do not chain");
    check_error("1 == 2", "", "column 3: found '=='", "expected an operator");
    check_error("1 \x07", "", "column 3: found byte 0x07", "expected an operator");
    check_error("1.2.3", "", "column 4: found '.3'", "expected an operator");
    check_error("1e999", "", "above 1e308", "column 1");
    check_error("1/0", "", "infinite", "expected a finite number");
    check_error("log(-1)", "", "not a number", "expected a finite number");
    check_error("$", "", "column 1: found '$'", "expected");
}

TEST(place_and_unit_of_the_caller)
{
    pd_ctx ctx;
    pd_expr expr;
    pd_expr_desc desc;
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    desc.text = "3 um + y";
    desc.unit = "mm/year";
    desc.location = "pin.scene:7";
    desc.column = 20;
    CHECK_INT(pd_expr_build(&ctx, &desc, &expr), PD_ERR_PARSE);
    CHECK_STR(ctx.message, "pin.scene:7: column 27: found 'y', expected a constant: no variable has a value here");
    desc.text = "1.3 um/h";
    CHECK_OK(&ctx, pd_expr_build(&ctx, &desc, &expr));
    CHECK_REL(pd_expr_eval(&expr, NULL), 1.3 / 3.6e9, 1e-15); /* SI although the unit was mm/year */
    pd_expr_free(&ctx, &expr);
    desc.unit = "nonsense";
    CHECK_INT(pd_expr_build(&ctx, &desc, &expr), PD_ERR_ARGUMENT);
    desc.unit = NULL; /* any dimension; the result has it */
    CHECK_OK(&ctx, pd_expr_build(&ctx, &desc, &expr));
    CHECK_NEAR(expr.dims.exponent[0], 1, 0);
    CHECK_NEAR(expr.dims.exponent[2], -1, 0);
    pd_expr_free(&ctx, &expr);
    desc.var_count = 33;
    CHECK_INT(pd_expr_build(&ctx, &desc, &expr), PD_ERR_ARGUMENT);
    desc.var_count = 0;
    desc.text = NULL;
    CHECK_INT(pd_expr_build(&ctx, &desc, &expr), PD_ERR_ARGUMENT);
    CHECK(pd_expr_eval(&expr, NULL) != pd_expr_eval(&expr, NULL));
}

TEST(bare_numbers_when_allowed)
{
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, build(&ctx, "5e-6", "m", 1, &expr));
    CHECK_NEAR(pd_expr_eval(&expr, NULL), 5e-6, 0);
    pd_expr_free(&ctx, &expr);
    CHECK_OK(&ctx, build(&ctx, "1e-3*(1 - C/Csat)", "1/s", 1, &expr));
    CHECK_REL(pd_expr_eval(&expr, at), 0.75e-3, 1e-15);
    pd_expr_free(&ctx, &expr);
    CHECK_INT(build(&ctx, "5 s", "m", 1, &expr), PD_ERR_PARSE);
}

/* Names: variables before constants before units; a built-in gives way. */
TEST(names_win_over_units)
{
    pd_ctx ctx;
    pd_expr expr;
    static const pd_expr_symbol own[] = {{"h", "m", 0}, {"R", "m", 0}};
    pd_expr_desc desc;
    const double value[2] = {2, 3};
    pd_ctx_init(&ctx);
    memset(&desc, 0, sizeof desc);
    desc.vars = own;
    desc.var_count = 2;
    desc.text = "6 m/h + R/h";
    desc.unit = "";
    CHECK_OK(&ctx, pd_expr_build(&ctx, &desc, &expr));
    CHECK_NEAR(pd_expr_eval(&expr, value), 4.5, 1e-15);
    pd_expr_free(&ctx, &expr);
}

TEST(constants_are_folded)
{
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, build(&ctx, "2*(3 + sin(0.5))^2/Csat", NULL, 0, &expr));
    CHECK(pd_expr_is_constant(&expr));
    CHECK_INT(expr.code_count, 1);
    pd_expr_free(&ctx, &expr);
    CHECK_OK(&ctx, build(&ctx, "x + t*0 m/s", "m", 0, &expr));
    CHECK(!pd_expr_is_constant(&expr));
    CHECK_INT(expr.variables_used, 1 | 4);
    pd_expr_free(&ctx, &expr);
    pd_expr_free(&ctx, &expr);
    CHECK_INT(ctx.in_use, 0);
}

/* Corrosion of alloy 625 at 200 mV: 8.9e-8 A/cm2 at C = 0, 1e-4 at 5.14 M, 3.2e-4 at 5.6 M (two digits printed). */
TEST(kinetics_of_alloy_625)
{
    static const double C[3] = {0, 5140, 5600}, i[3] = {8.9e-4, 1.0, 3.2};
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, build(&ctx, "10^(1.151*exp(-0.723*(7.405*exp(-0.08036*C/(1 M)) - 6.498)) - 7.647) * 1 A/cm2",
                              "A/m2", 0, &expr)))
        return;
    for (int k = 0; k < 3; k++) {
        double v[VARS] = {0, 0, 0, 0, 0};
        v[3] = C[k];
        CHECK_REL(pd_expr_eval(&expr, v), i[k], 0.06);
    }
    pd_expr_free(&ctx, &expr);
}

TEST(limits_are_refused)
{
    static char text[PD_EXPR_LENGTH + 10];
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    memset(text, ' ', PD_EXPR_LENGTH + 1);
    text[0] = '1';
    CHECK_INT(build(&ctx, text, "", 0, &expr), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "longer than 4096") != NULL);
    memset(text, '(', 4000);
    text[4000] = '\0';
    CHECK_INT(build(&ctx, text, "", 0, &expr), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "deeper than 64") != NULL);
    memset(text, '-', 4000);
    memcpy(text + 4000, "1", 2);
    CHECK_OK(&ctx, build(&ctx, text, "", 0, &expr));
    CHECK_NEAR(pd_expr_eval(&expr, NULL), 1, 0);
    pd_expr_free(&ctx, &expr);
    for (int k = 0; k < 1300; k++) memcpy(text + 2 * k, "n^", 3);
    text[2599] = '\0';
    CHECK_INT(build(&ctx, text, "", 0, &expr), PD_ERR_PARSE);
    for (int k = 0; k < 1300; k++) memcpy(text + 2 * k, "n+", 3);
    text[2599] = '\0';
    CHECK_INT(build(&ctx, text, "", 0, &expr), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "more than 1024 instructions") != NULL);
    text[2 * 512 - 1] = '\0'; /* 512 n and 511 + */
    CHECK_OK(&ctx, build(&ctx, text, "", 0, &expr));
    CHECK_NEAR(pd_expr_eval(&expr, at), 512 * 7, 0);
    pd_expr_free(&ctx, &expr);
    /* wide in every level: a^b*(a^b*( ... needs more than two operands a level */
    size_t used = 0;
    for (int k = 0; k < 60; k++) used += (size_t)sprintf(text + used, "n+n*(");
    CHECK_INT(build(&ctx, text, "", 0, &expr), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "operands wait") != NULL);
    CHECK_INT(ctx.in_use, 0);
}

/* Allocation failure at every request: clean failure, nothing left. */
TEST(allocation_failures)
{
    int failed = 0;
    for (int n = 1;; n++) {
        pd_ctx ctx;
        pd_expr expr;
        fault f;
        fault_context(&f, n, 1, &ctx);
        pd_status status = build(&ctx, "x + 1 um", "m", 0, &expr);
        pd_expr_free(&ctx, &expr);
        CHECK_INT(ctx.in_use, 0);
        if (status == PD_OK) break;
        CHECK_INT(status, PD_ERR_MEMORY);
        failed++;
    }
    CHECK(failed >= 3);
}

/* Bytes of the letter at c: printable ASCII, or one of UTF-8. 0: neither. */
static int letter(const char *c)
{
    unsigned char first = (unsigned char)*c;
    int more = first >= 0xf0 && first < 0xf5 ? 3 : first >= 0xe0 ? 2 : first >= 0xc2 ? 1 : 0;
    if (first < 0x80) return first >= 0x20 && first < 0x7f;
    if (!more || first >= 0xf5) return 0;
    for (int k = 1; k <= more; k++)
        if (((unsigned char)c[k] & 0xc0) != 0x80) return 0;
    return 1 + more;
}

/* Every truncation and every replaced byte: an answer or an error with a message, nothing left behind. */
static void hostile(const char *text, int *good, int *bad)
{
    pd_ctx ctx;
    pd_expr expr;
    pd_ctx_init(&ctx);
    pd_status status = build(&ctx, text, NULL, 0, &expr);
    if (status == PD_OK) {
        (*good)++;
        double value = pd_expr_eval(&expr, at);
        if (pd_expr_is_constant(&expr)) CHECK(isfinite(value));
    } else {
        (*bad)++;
        if (!(status == PD_ERR_PARSE && strncmp(ctx.message, "expr: column ", 13) == 0))
            CHECK_STR(ctx.message, "expr: column ...");
        for (const char *c = ctx.message; *c;) {
            int bytes = letter(c);
            if (!bytes) CHECK_INT((unsigned char)*c, 0x20);
            c += bytes ? bytes : 1;
        }
    }
    pd_expr_free(&ctx, &expr);
    if (ctx.in_use != 0) CHECK_INT(ctx.in_use, 0);
}

TEST(byte_flips_and_truncation)
{
    static const char *const seeds[] = {
        "1.3 um/h * (1 - C/Csat)^2 + if(x >= y, 2 um/s, max(0, -U)) - 8 J/(mol K)*0",
        "10^(1.151*exp(-0.723*(7.405*exp(-0.08036*C/(1 M)) - 6.498)) - 7.647) * 1 A/cm2",
        "atan2(x, y)*sqrt(x^2 + y^2) / min(1 s, t) - 1e-3 mol m-2 s^-1 * 3 \xC2\xB5m/mol*1 m^2 + 1/min*2 %"};
    static const char bytes[] = "()+-*/^,.<=>0e19 mx%_\t\n\r\x01\x7f\xC2\xB5\xff";
    int good = 0, bad = 0;
    for (int s = 0; s < 3; s++) {
        size_t size = strlen(seeds[s]);
        for (size_t k = 0; k < size; k++) {
            char text[256];
            memcpy(text, seeds[s], size + 1);
            text[k] = '\0';
            hostile(text, &good, &bad);
            for (int bit = 0; bit < 8; bit++) {
                memcpy(text, seeds[s], size + 1);
                text[k] = (char)(text[k] ^ (1 << bit));
                hostile(text, &good, &bad);
            }
            for (size_t b = 0; b < sizeof bytes - 1; b++) {
                text[k] = bytes[b];
                hostile(text, &good, &bad);
            }
        }
    }
    CHECK(good > 100);
    CHECK(bad > 1000);
    NOTE("%d accepted, %d refused", good, bad);
}

/* Random token soup from a fixed generator. */
TEST(token_soup)
{
    static const char *const tokens[] = {"(", ")", "+", "-", "*", "/", "^", ",", "<", ">=", "x", "t", "n", "C", "um",
                                         "s", "1", "2.5", "0", "1e-3", "sin(", "if(", "min(", "m2", "m-1", "%", " ",
                                         "Csat", "h", "/s", "1/s", "pi", "R"};
    unsigned state = 12345;
    int good = 0, bad = 0;
    for (int k = 0; k < 20000; k++) {
        char text[128] = "";
        state = state * 1664525u + 1013904223u;
        int n = 1 + (int)(state >> 16) % 12;
        for (int i = 0; i < n; i++) {
            state = state * 1664525u + 1013904223u;
            strcat(text, tokens[(state >> 16) % (sizeof tokens / sizeof tokens[0])]);
            strcat(text, (state >> 8) & 1 ? " " : "");
        }
        hostile(text, &good, &bad);
    }
    CHECK(good > 500);
    CHECK(bad > 5000);
}

static void check_format(double value, const char *unit, const char *expected)
{
    pd_ctx ctx;
    pd_dims dims;
    char text[PD_UNITS_TEXT];
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_units_parse(&ctx, unit, NULL, &dims));
    pdi_units_format_value(value, &dims, text);
    CHECK_STR(text, expected);
}

TEST(values_with_units)
{
    check_format(80e-6, "m", "80 um");
    check_format(-150e-6, "m", "-150 um");
    check_format(1.4e-3, "m", "1.4 mm");
    check_format(32400, "s", "9 h");
    check_format(900, "s", "15 min");
    check_format(10, "s", "10 s");
    check_format(1.3 / 3.6e9, "m/s", "1.3 um/h");
    check_format(0.5e-3 / 31557600, "m/s", "0.5 mm/year");
    check_format(0.236, "m/s", "236 mm/s");
    check_format(1e-6 / 60, "m3/s", "1 mL/min");
    check_format(1e-3, "Pa s", "1 mPa s");
    check_format(1738, "kg/m3", "1738 kg/m3");
    check_format(1e-9, "m2/s", "1e-09 m2/s");
    check_format(0, "m", "0 m");
    check_format(0.25, "", "0.25");
    check_format(3, "m s", "3 m s");
    check_format(1.0 / 3600, "1/s", "1 /h");
}

/* What is printed reads back to the six digits printed, for every decade of every dimension. */
TEST(printed_values_read_back)
{
    static const char *const units[] = {"m", "m2", "m3", "s", "1/s", "m/s", "m/s2", "m3/s", "m2/s", "kg", "kg/m3",
                                        "kg/s", "kg/m2/s", "Pa", "Pa s", "N", "N/m", "N/m3", "J", "W", "J/mol",
                                        "J/mol/K", "mol", "mol/m3", "kg/mol", "mol/m2/s", "mol/m3/s", "K", "A", "A/m2",
                                        "C/mol", "V", "Ohm", "S", "S/m", "", "A s", "m^0.5", "kg^-1.5 m7", "m12 A-10"};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int k = 0; k < (int)(sizeof units / sizeof units[0]); k++)
        for (int decade = -14; decade <= 14; decade++) {
            pd_dims dims;
            char text[PD_UNITS_TEXT];
            pd_expr_desc desc;
            pd_expr expr;
            double value = 1.2345 * pow(10, decade);
            memset(&desc, 0, sizeof desc);
            CHECK_OK(&ctx, pd_units_parse(&ctx, units[k], NULL, &dims));
            pdi_units_format_value(value, &dims, text);
            desc.text = text;
            desc.unit = units[k];
            if (!CHECK_OK(&ctx, pd_expr_build(&ctx, &desc, &expr))) NOTE("%s", text);
            else CHECK_REL(pd_expr_eval(&expr, NULL), value, 5.1e-6);
            pd_expr_free(&ctx, &expr);
        }
}

/* Derived units against their definitions in base units. */
TEST(unit_definitions)
{
    static const char *const same[][2] = {
        {"N", "kg m/s2"}, {"Pa", "N/m2"}, {"J", "N m"}, {"W", "J/s"}, {"C", "A s"}, {"V", "W/A"}, {"Ohm", "V/A"},
        {"S", "A/V"}, {"Hz", "1/s"}, {"L", "dm3"}, {"M", "mol/L"}, {"bar", "hPa"}, {"kg", "g"},
        {"mol m-2 s-1", "mol/m2/s"},
        {"J/(mol K)", "J/mol/K"}, {"/s", "1/s"}, {"um/h", "m/s"}, {"%", "1"}, {"eV", "J"}, {"mpy", "m/s"}};
    static const double ratio[] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1000, 1000, 1, 1, 1, 1 / 3.6e9, 0.01,
                                   1.602176634e-19, 25.4e-6 / 31557600};
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    for (int k = 0; k < (int)(sizeof ratio / sizeof ratio[0]); k++) {
        double a, b;
        pd_dims da, db;
        CHECK_OK(&ctx, pd_units_parse(&ctx, same[k][0], &a, &da));
        CHECK_OK(&ctx, pd_units_parse(&ctx, same[k][1], &b, &db));
        CHECK_REL(a / b, ratio[k], 5e-16);
        if (!CHECK(pd_units_is_same(&da, &db))) NOTE("%s", same[k][0]);
    }
    CHECK_INT(pd_units_parse(&ctx, "furlong", NULL, NULL), PD_ERR_PARSE);
    CHECK_INT(pd_units_parse(&ctx, "m/", NULL, NULL), PD_ERR_PARSE);
    CHECK_INT(pd_units_parse(&ctx, "2 m", NULL, NULL), PD_ERR_PARSE);
    CHECK_INT(pd_units_parse(&ctx, "degC", NULL, NULL), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "in K") != NULL);
}

TEST_MAIN(ENTRY(literals_with_units) ENTRY(numbers_as_strtod) ENTRY(operators_and_functions)
          ENTRY(dimensions_are_checked) ENTRY(messages_name_the_place) ENTRY(place_and_unit_of_the_caller)
          ENTRY(bare_numbers_when_allowed) ENTRY(names_win_over_units) ENTRY(constants_are_folded)
          ENTRY(kinetics_of_alloy_625) ENTRY(limits_are_refused) ENTRY(allocation_failures)
          ENTRY(byte_flips_and_truncation) ENTRY(token_soup) ENTRY(values_with_units)
          ENTRY(printed_values_read_back) ENTRY(unit_definitions))
