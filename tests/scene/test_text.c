/* text: the reading rule, typed values, overrides, messages with file and line, hostile files. */
#include "scene/override.h"
#include "scene/text.h"
#include "fault.h"
#include "test.h"
#include <stdlib.h>

static const char sample[] =
    "# Mg pin in a flow cell\n"
    "[grid]      h = 5 um   m = 3   box = -500 um .. 900 um, -150 um .. 150 um\n"
    "[shape pin] box = 0 .. 400 um, -40 um .. 40 um   kind = solid   material = mg4ag   grain_size = 40 um\n"
    "[side x-]   flow = inlet, profile = parabola, mean = 0.236 m/s   C = 0\n"
    "[side x+]   flow = outlet, p = 0\n"
    "[side y-]   flow = noslip\n"
    "[side y+]   flow = noslip\n"
    "[flow]      rho = 1000   mu = 1e-3 Pa s   steady_tolerance = 1e-6\n"
    "[transport] D = 1e-9 m2/s\n"
    "[dissolve]  law = 1e-3 * (1 - C/Csat)   Csat = ...   grain_boundary_factor = 3\n"
    "[run]       until = 9 h   rtol = 1e-3\n"
    "[output]    every = 15 min   fields = C, v, p, kind, grain   images = C\n"
    "[probe a]   at = 100 um, 60 um   fields = C, v\n";

static pd_status load(pd_ctx *ctx, const char *bytes, pd_text *text)
{
    pd_ctx_init(ctx);
    return pdi_text_build(ctx, "pin.scene", bytes, strlen(bytes), text);
}

static void check_message(const pd_ctx *ctx, const char *part, const char *part2)
{
    if (!CHECK(strstr(ctx->message, part) != NULL) || !CHECK(strstr(ctx->message, part2) != NULL))
        NOTE("message: %s; expected: %s ... %s", ctx->message, part, part2);
}

static void leave(pd_ctx *ctx, pd_text *text)
{
    pdi_text_free(ctx, text);
    pdi_text_free(ctx, text);
    CHECK_INT(ctx->in_use, 0);
}

static int at(pd_ctx *ctx, pd_text *text, const char *name, const char *label)
{
    return pdi_text_get_section(ctx, text, name, label);
}

/* Every pair of the sample, in order. */
TEST(pairs_of_the_sample)
{
    static const char *const expected[][4] = {{"grid", "", "h", "5 um"},
                                              {"grid", "", "m", "3"},
                                              {"grid", "", "box", "-500 um .. 900 um, -150 um .. 150 um"},
                                              {"shape", "pin", "box", "0 .. 400 um, -40 um .. 40 um"},
                                              {"shape", "pin", "kind", "solid"},
                                              {"shape", "pin", "material", "mg4ag"},
                                              {"shape", "pin", "grain_size", "40 um"},
                                              {"side", "x-", "flow", "inlet"},
                                              {"side", "x-", "profile", "parabola"},
                                              {"side", "x-", "mean", "0.236 m/s"},
                                              {"side", "x-", "C", "0"},
                                              {"side", "x+", "flow", "outlet"},
                                              {"side", "x+", "p", "0"},
                                              {"side", "y-", "flow", "noslip"},
                                              {"side", "y+", "flow", "noslip"},
                                              {"flow", "", "rho", "1000"},
                                              {"flow", "", "mu", "1e-3 Pa s"},
                                              {"flow", "", "steady_tolerance", "1e-6"},
                                              {"transport", "", "D", "1e-9 m2/s"},
                                              {"dissolve", "", "law", "1e-3 * (1 - C/Csat)"},
                                              {"dissolve", "", "Csat", "..."},
                                              {"dissolve", "", "grain_boundary_factor", "3"},
                                              {"run", "", "until", "9 h"},
                                              {"run", "", "rtol", "1e-3"},
                                              {"output", "", "every", "15 min"},
                                              {"output", "", "fields", "C, v, p, kind, grain"},
                                              {"output", "", "images", "C"},
                                              {"probe", "a", "at", "100 um, 60 um"},
                                              {"probe", "a", "fields", "C, v"}};
    const int count = (int)(sizeof expected / sizeof expected[0]);
    pd_ctx ctx;
    pd_text text;
    if (!CHECK_OK(&ctx, load(&ctx, sample, &text))) return;
    CHECK_INT(text.entry_count, count);
    CHECK(!pdi_text_is_flat(&text));
    for (int k = 0; k < count && k < text.entry_count; k++) {
        const pd_text_entry *e = &text.entry[k];
        CHECK_STR(text.section[e->section].name, expected[k][0]);
        CHECK_STR(text.section[e->section].label, expected[k][1]);
        CHECK_STR(e->key, expected[k][2]);
        CHECK_STR(e->value, expected[k][3]);
    }
    CHECK_INT(text.entry[9].line, 4);
    CHECK_INT(text.entry[9].column, 54);
    leave(&ctx, &text);
}

TEST(values_of_the_sample)
{
    static const char *const kinds[] = {"fluid", "solid", NULL};
    static const pd_expr_symbol vars[] = {{"C", "mol/m3", 0}};
    static const pd_expr_symbol consts[] = {{"Csat", "mol/m3", 2000}};
    pd_ctx ctx;
    pd_text text;
    double value, low[3], high[3], where[3];
    int count, index, yes;
    pd_word_list words;
    pd_expr law;
    const char *material;
    if (!CHECK_OK(&ctx, load(&ctx, sample, &text))) return;
    text.consts = consts;
    text.const_count = 1;
    int grid = at(&ctx, &text, "grid", NULL), pin = at(&ctx, &text, "shape", "pin");
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "h", "m", NULL, &value));
    CHECK_NEAR(value, 5e-6, 0);
    CHECK_OK(&ctx, pdi_text_get_integer(&ctx, &text, grid, "m", 1, 6, NULL, &count));
    CHECK_INT(count, 3);
    CHECK_OK(&ctx, pdi_text_get_ranges(&ctx, &text, grid, "box", "m", NULL, 3, low, high, &count));
    CHECK_INT(count, 2);
    CHECK_NEAR(low[0], -500e-6, 0);
    CHECK_NEAR(high[0], 900e-6, 0);
    CHECK_NEAR(low[1], -150e-6, 0);
    CHECK_NEAR(high[1], 150e-6, 0);
    CHECK_OK(&ctx, pdi_text_get_ranges(&ctx, &text, pin, "box", "m", NULL, 3, low, high, &count));
    CHECK_NEAR(low[0], 0, 0);
    CHECK_NEAR(high[0], 400e-6, 0);
    CHECK_OK(&ctx, pdi_text_get_choice(&ctx, &text, pin, "kind", kinds, NULL, &index));
    CHECK_INT(index, 1);
    CHECK_OK(&ctx, pdi_text_get_string(&ctx, &text, pin, "material", NULL, &material));
    CHECK_STR(material, "mg4ag");
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "side", "x-"), "C", "mol/m3", NULL, &value));
    CHECK_NEAR(value, 0, 0);
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "run", NULL), "until", "s", NULL, &value));
    CHECK_NEAR(value, 32400, 0);
    CHECK_OK(&ctx, pdi_text_get_words(&ctx, &text, at(&ctx, &text, "output", NULL), "fields", NULL, &words));
    CHECK_INT(words.count, 5);
    CHECK_STR(words.word[0], "C");
    CHECK_STR(words.word[4], "grain");
    CHECK_OK(&ctx, pdi_text_get_numbers(&ctx, &text, at(&ctx, &text, "probe", "a"), "at", "m", NULL, 3, where, &count));
    CHECK_INT(count, 2);
    CHECK_NEAR(where[1], 60e-6, 0);
    CHECK_OK(&ctx, pdi_text_get_expr(&ctx, &text, at(&ctx, &text, "dissolve", NULL), "law", NULL, vars, 1, NULL, &law));
    value = 500;
    CHECK_REL(pd_expr_eval(&law, &value), 0.75e-3, 1e-15);
    pd_expr_free(&ctx, &law);
    /* defaults are text too */
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "depth", "m", "2 mm", &value));
    CHECK_NEAR(value, 2e-3, 0);
    CHECK_OK(&ctx, pdi_text_get_bool(&ctx, &text, grid, "axisymmetric", "no", &yes));
    CHECK_INT(yes, 0);
    CHECK(pdi_text_has_key(&ctx, &text, grid, "h") && !pdi_text_has_key(&ctx, &text, grid, "q"));
    CHECK(pdi_text_has_key(&ctx, &text, at(&ctx, &text, "flow", NULL), NULL));
    CHECK(!pdi_text_has_key(&ctx, &text, at(&ctx, &text, "solid", NULL), NULL));
    leave(&ctx, &text);
}

TEST(lists_and_words)
{
    static const pd_expr_symbol vars[] = {{"y", "m", 0}};
    pd_ctx ctx;
    pd_text text;
    pd_expr v[3];
    double y = 2, number[4];
    int count, yes;
    CHECK_OK(&ctx, load(&ctx, "[a] v = 1 1/s*min(y, 1 m), 0, -2 m/s  on = on b1 = true b2 = off,b3=false\n"
                              "n = min(1, 2), max(3,4) w = x-, y+,z_1.vti\n", &text));
    int a = at(&ctx, &text, "a", NULL);
    CHECK_OK(&ctx, pdi_text_get_exprs(&ctx, &text, a, "v", "m/s", vars, 1, NULL, 3, v, &count));
    CHECK_INT(count, 3);
    CHECK_NEAR(pd_expr_eval(&v[0], &y), 1, 0);
    CHECK_NEAR(pd_expr_eval(&v[2], &y), -2, 0);
    for (int k = 0; k < count; k++) pd_expr_free(&ctx, &v[k]);
    CHECK_INT(pdi_text_get_exprs(&ctx, &text, a, "v", "m/s", vars, 1, NULL, 2, v, &count), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:1: column 29: found ','", "at most 2 items");
    CHECK_INT(count, 0);
    CHECK_OK(&ctx, pdi_text_get_bool(&ctx, &text, a, "on", NULL, &yes));
    CHECK_INT(yes, 1);
    CHECK_OK(&ctx, pdi_text_get_bool(&ctx, &text, a, "b1", NULL, &yes));
    CHECK_INT(yes, 1);
    CHECK_OK(&ctx, pdi_text_get_bool(&ctx, &text, a, "b2", NULL, &yes));
    CHECK_INT(yes, 0);
    CHECK_OK(&ctx, pdi_text_get_bool(&ctx, &text, a, "b3", NULL, &yes));
    CHECK_INT(yes, 0);
    CHECK_OK(&ctx, pdi_text_get_numbers(&ctx, &text, a, "n", "", NULL, 4, number, &count));
    CHECK_INT(count, 2);
    CHECK_NEAR(number[0], 1, 0);
    CHECK_NEAR(number[1], 4, 0);
    pd_word_list words;
    CHECK_OK(&ctx, pdi_text_get_words(&ctx, &text, a, "w", NULL, &words));
    CHECK_INT(words.count, 3);
    CHECK_STR(words.word[0], "x-");
    CHECK_STR(words.word[2], "z_1.vti");
    leave(&ctx, &text);
}

TEST(comparisons_do_not_start_pairs)
{
    pd_ctx ctx;
    pd_text text;
    CHECK_OK(&ctx, load(&ctx, "[a]\r\n\tk = if(C <= 1, f(x = 2), 3) l=C >= 2,m =C == 3 # n = 4\r\n\r\n", &text));
    CHECK_INT(text.entry_count, 3);
    CHECK_STR(text.entry[0].value, "if(C <= 1, f(x = 2), 3)");
    CHECK_STR(text.entry[1].value, "C >= 2");
    CHECK_STR(text.entry[2].value, "C == 3");
    leave(&ctx, &text);
}

TEST(flat_files)
{
    pd_ctx ctx;
    pd_text text;
    double value;
    const char *dir;
    CHECK_OK(&ctx, load(&ctx, "\xEF\xBB\xBF# pin\ndx = 5e-6\nQ_flow = 1.667e-8 # 1 mL/min\noutput_dir = out/a b\n"
                              "R_wire = 40 um\nT_final = 9 m", &text));
    CHECK(pdi_text_is_flat(&text));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, 0, "dx", "m", NULL, &value));
    CHECK_NEAR(value, 5e-6, 0);
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, 0, "Q_flow", "m3/s", NULL, &value));
    CHECK_NEAR(value, 1.667e-8, 0);
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, 0, "R_wire", "m", NULL, &value));
    CHECK_NEAR(value, 40e-6, 0);
    CHECK_OK(&ctx, pdi_text_get_string(&ctx, &text, 0, "output_dir", NULL, &dir));
    CHECK_STR(dir, "out/a b");
    CHECK_INT(pdi_text_get_number(&ctx, &text, 0, "T_final", "s", NULL, &value), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:6: column 11", "found a length [m], expected a time [s]");
    CHECK_INT(pdi_text_get_number(&ctx, &text, 0, "L_wire", "m", NULL, &value), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:1: found no 'L_wire' in the file", "expected L_wire = a length [m]");
    leave(&ctx, &text);
    CHECK_OK(&ctx, load(&ctx, "", &text));
    CHECK(pdi_text_is_flat(&text));
    leave(&ctx, &text);
}

static void check_refused(const char *bytes, const char *part, const char *part2)
{
    pd_ctx ctx;
    pd_text text;
    CHECK_INT(load(&ctx, bytes, &text), PD_ERR_PARSE);
    check_message(&ctx, part, part2);
    leave(&ctx, &text);
}

TEST(format_errors)
{
    check_refused("[grid]\nh = 5 um\n m = 3 h = 2 um\n", "pin.scene:3: found 'h' a second time in [grid]",
                  "first on line 2");
    check_refused("[side x-] C = 0\n[grid]\n[side x-]\nC = 1", "pin.scene:4: found 'C' a second time in [side x-]",
                  "first on line 1");
    check_refused("[grid\nh = 1", "pin.scene:1: column 6: found the end", "']'");
    check_refused("[]", "column 2: found ']'", "name of a section");
    check_refused("[a b c]", "column 6: found 'c'", "']'");
    check_refused("[1]", "column 2: found '1'", "name of a section");
    check_refused("[a] 5 um", "column 5: found '5'", "expected key = value");
    check_refused("hello", "pin.scene:1: column 1: found 'hello'", "expected [section] or key = value");
    check_refused("[a]\nk =\n", "pin.scene:2: column 4: found nothing after 'k ='", "expected a value");
    check_refused("[a] k = , l = 3", "found nothing after 'k ='", "expected a value");
    check_refused("[a] k = (1 + 2", "column 9: found '('", "expected its ')' on the same line");
    check_refused("[a] k = 1)", "column 10: found ')'", "expected '('");
    check_refused("[a] k = 1 [b] l = 2", "column 11: found '['", "line of its own");
    check_refused("[a] k == 1", "column 5: found 'k'", "key = value");
    check_refused("a = 1\nb\x01 = 2", "pin.scene:2: found byte 0x01", "expected text");
    check_refused("a = 1\rb = 2", "pin.scene:1: found byte 0x0d", "expected text");
    check_refused("\xC3\xA4 = 1", "column 1: found byte 0xc3", "expected");
}

static void check_number(const char *bytes, const char *unit, const char *part, const char *part2)
{
    pd_ctx ctx;
    pd_text text;
    double value;
    CHECK_OK(&ctx, load(&ctx, bytes, &text));
    CHECK_INT(pdi_text_get_number(&ctx, &text, at(&ctx, &text, "grid", NULL), "h", unit, NULL, &value), PD_ERR_PARSE);
    check_message(&ctx, part, part2);
    leave(&ctx, &text);
}

TEST(value_errors)
{
    static const char *const kinds[] = {"inlet", "outlet", "noslip", NULL};
    pd_ctx ctx;
    pd_text text;
    double low[2], high[2];
    int n;
    check_number("[grid] h = 5", "m", "pin.scene:1: column 12: found a number without unit",
                 "expected a length [m]: write its unit, for example nm, um, mm");
    check_number("[grid]\n  h =  5 s", "m", "pin.scene:2: column 8: found a time [s]", "expected a length [m]");
    check_number("[grid]\n  h = 5 um + z", "m", "pin.scene:2: column 14: found 'z'", "expected a constant");
    check_number("[grid] m = 3", "m", "pin.scene:1: found no 'h' in [grid]", "expected h = a length [m]");
    check_number("[flow] m = 3", "m", "pin.scene:1: found no 'h' in [grid]", "expected h = a length [m]");
    check_number("[grid] h = 1/0", "", "infinite", "expected a finite number");
    CHECK_OK(&ctx, load(&ctx, "[a] i = 2.5 j = 9 k = inlte b = maybe r = 1 um .. 0 q = 1 um - 2 um t = 1...2 w = a b\n"
                              "u = 0 .. 1 um, 0 .. 1 um, 0 .. 1 um d = 1e-3 um, z = 40 .. 80 um", &text));
    int a = at(&ctx, &text, "a", NULL);
    CHECK_INT(pdi_text_get_integer(&ctx, &text, a, "i", 1, 6, NULL, &n), PD_ERR_PARSE);
    check_message(&ctx, "column 9: found 2.5", "a whole number from 1 to 6");
    CHECK_INT(pdi_text_get_integer(&ctx, &text, a, "j", 1, 6, NULL, &n), PD_ERR_PARSE);
    check_message(&ctx, "found 9", "a whole number from 1 to 6");
    CHECK_INT(pdi_text_get_choice(&ctx, &text, a, "k", kinds, NULL, &n), PD_ERR_PARSE);
    check_message(&ctx, "found 'inlte'", "expected one of inlet, outlet, noslip: did you mean 'inlet'?");
    CHECK_INT(pdi_text_get_bool(&ctx, &text, a, "b", NULL, &n), PD_ERR_PARSE);
    check_message(&ctx, "found 'maybe'", "expected one of no, yes");
    CHECK_INT(pdi_text_get_ranges(&ctx, &text, a, "r", "m", NULL, 2, low, high, &n), PD_ERR_PARSE);
    check_message(&ctx, "found a range from 1e-06 to 0", "expected its start below its end");
    CHECK_INT(pdi_text_get_ranges(&ctx, &text, a, "q", "m", NULL, 2, low, high, &n), PD_ERR_PARSE);
    check_message(&ctx, "found the end", "expected '..'");
    CHECK_INT(pdi_text_get_ranges(&ctx, &text, a, "t", "", NULL, 2, low, high, &n), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:1: column", "two dots with blanks");
    CHECK_INT(pdi_text_get_ranges(&ctx, &text, a, "u", "m", NULL, 2, low, high, &n), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:2: column 25: found ','", "at most 2 items");
    CHECK_INT(pdi_text_get_ranges(&ctx, &text, a, "z", "m", NULL, 2, low, high, &n), PD_ERR_PARSE);
    check_message(&ctx, "found a number without unit", "expected a length [m]");
    pd_word_list words;
    CHECK_INT(pdi_text_get_words(&ctx, &text, a, "w", NULL, &words), PD_ERR_PARSE);
    check_message(&ctx, "found 'b'", "expected ',' or the end");
    CHECK_INT(pdi_text_get_integer(&ctx, &text, -1, "i", 1, 6, NULL, &n), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_text_fail_key(&ctx, &text, a, "d", "found %g m, expected at least %g m", 1e-9, 1e-6),
              PD_ERR_ARGUMENT);
    CHECK_STR(ctx.message, "pin.scene:2: d: found 1e-09 m, expected at least 1e-06 m");
    leave(&ctx, &text);
}

TEST(unused_keys_and_sections)
{
    pd_ctx ctx;
    pd_text text;
    double value;
    CHECK_OK(&ctx, load(&ctx, "[grid] h = 1 um\n hh = 2 um\n[side x-] flow = inlet\n[side x+] mean = 1 m/s\n"
                              "[gird]\n[flwo] mu = 1 Pa s", &text));
    int grid = at(&ctx, &text, "grid", NULL), n;
    static const char *const kinds[] = {"inlet", NULL};
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "h", "m", NULL, &value));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "h2", "m", "1 m", &value));
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:2: found the unknown key 'hh' in [grid]", "expected one of h, h2: did you mean 'h");
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "hh", "m", NULL, &value));
    CHECK_OK(&ctx, pdi_text_get_choice(&ctx, &text, at(&ctx, &text, "side", "x-"), "flow", kinds, NULL, &n));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "side", "x-"), "mean", "m/s", "1 m/s", &value));
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:4: found 'mean' in [side x+]", "no effect");
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "side", "x+"), "mean", "m/s", NULL, &value));
    CHECK(at(&ctx, &text, "flow", NULL) >= 0);
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:6: found the section [flwo]",
                  "expected one of grid, side, flow: did you mean 'flow'?");
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "flwo", NULL), "mu", "Pa s", NULL, &value));
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:5: found the section [gird]", "did you mean 'grid'?");
    CHECK(pdi_text_next_section(&ctx, &text, "gird", -1) >= 0);
    CHECK_OK(&ctx, pdi_text_check_unused(&ctx, &text));
    leave(&ctx, &text);
    CHECK_OK(&ctx, load(&ctx, "k = 1\n[grid]", &text));
    CHECK(at(&ctx, &text, "grid", NULL) >= 0);
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:1: found the unknown key 'k' in the lines before the first section", "no key there");
    leave(&ctx, &text);
    /* a name of one letter is a name */
    CHECK_OK(&ctx, load(&ctx, "[grid] y = 1", &text));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "grid", NULL), "x", "m", "1 m", &value));
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "pin.scene:1: found the unknown key 'y' in [grid]", "expected one of x");
    leave(&ctx, &text);
}

TEST(sections_in_order)
{
    pd_ctx ctx;
    pd_text text;
    CHECK_OK(&ctx, load(&ctx, "[shape b] r = 1 um\n[grid]\n[shape a] r = 2 um\n[shape b] k = 3\n", &text));
    int s = pdi_text_next_section(&ctx, &text, "shape", -1);
    if (!CHECK(s >= 0)) return;
    CHECK_STR(text.section[s].label, "b");
    CHECK(pdi_text_has_key(&ctx, &text, s, "r") && pdi_text_has_key(&ctx, &text, s, "k"));
    s = pdi_text_next_section(&ctx, &text, "shape", s);
    if (!CHECK(s >= 0)) return;
    CHECK_STR(text.section[s].label, "a");
    CHECK_INT(pdi_text_next_section(&ctx, &text, "shape", s), -1);
    CHECK_INT(pdi_text_next_section(&ctx, &text, "probe", -1), -1);
    leave(&ctx, &text);
}

TEST(overrides)
{
    pd_ctx ctx;
    pd_text text;
    double value;
    CHECK_OK(&ctx, load(&ctx, sample, &text));
    int grid = at(&ctx, &text, "grid", NULL), run = at(&ctx, &text, "run", NULL);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "h=2 um"));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "h", "m", NULL, &value));
    CHECK_NEAR(value, 2e-6, 0);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, " grid.h = 3um "));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, grid, "h", "m", NULL, &value));
    CHECK_NEAR(value, 3e-6, 0);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "side.x-.mean=1 m/s"));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "side", "x-"), "mean", "m/s", NULL, &value));
    CHECK_NEAR(value, 1, 0);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "shape.grain_size=20 um")); /* the only labelled shape */
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, at(&ctx, &text, "shape", "pin"), "grain_size", "m", NULL, &value));
    CHECK_NEAR(value, 20e-6, 0);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "run.first=1 s")); /* not in the file */
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, run, "first", "s", NULL, &value));
    CHECK_NEAR(value, 1, 0);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "grid.h=x"));
    CHECK_INT(pdi_text_get_number(&ctx, &text, grid, "h", "m", NULL, &value), PD_ERR_PARSE);
    check_message(&ctx, "command line: h: column 8: found 'x'", "expected a constant");
    CHECK_INT(pdi_override_apply(&ctx, &text, "untli=3 s"), PD_ERR_PARSE);
    check_message(&ctx, "command line: found the key 'untli', which no section of pin.scene has",
                  "expected section.key: did you mean 'until'?");
    CHECK_INT(pdi_override_apply(&ctx, &text, "fields=C"), PD_ERR_PARSE);
    check_message(&ctx, "command line: found the key 'fields'", "expected one of output.fields, probe.a.fields");
    CHECK_INT(pdi_override_apply(&ctx, &text, "side.C=0"), PD_ERR_PARSE);
    check_message(&ctx, "command line: found 'side.C'", "side.x-.C, side.x+.C, side.y-.C, side.y+.C");
    CHECK_INT(pdi_override_apply(&ctx, &text, "side.z-.C=0"), PD_ERR_PARSE);
    check_message(&ctx, "found the section [side z-]", "its labels: x-, x+, y-, y+");
    CHECK_INT(pdi_override_apply(&ctx, &text, "h"), PD_ERR_PARSE);
    check_message(&ctx, "command line: column 2: found the end", "expected key=value");
    CHECK_INT(pdi_override_apply(&ctx, &text, "h="), PD_ERR_PARSE);
    CHECK_INT(pdi_override_apply(&ctx, &text, "=3"), PD_ERR_PARSE);
    CHECK_INT(pdi_override_apply(&ctx, &text, "a.b.c.d=3"), PD_ERR_PARSE);
    CHECK_INT(pdi_override_apply(&ctx, &text, "a..c=3"), PD_ERR_PARSE);
    CHECK_INT(pdi_override_apply(&ctx, &text, ""), PD_ERR_PARSE);
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "gird.h=3 um")); /* found by pdi_text_check_unused */
    for (int k = 0; k < text.entry_count - 1; k++) text.entry[k].is_read = 1;
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "command line: found the section [gird]", "did you mean 'grid'?");
    leave(&ctx, &text);
    CHECK_OK(&ctx, load(&ctx, "dx = 5e-6\n", &text));
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "dx=1e-6"));
    CHECK_OK(&ctx, pdi_override_apply(&ctx, &text, "dy=2e-6"));
    CHECK_OK(&ctx, pdi_text_get_number(&ctx, &text, 0, "dx", "m", NULL, &value));
    CHECK_NEAR(value, 1e-6, 0);
    CHECK_INT(pdi_text_check_unused(&ctx, &text), PD_ERR_PARSE);
    check_message(&ctx, "command line: found the unknown key 'dy' in the file", "did you mean 'dx'?");
    leave(&ctx, &text);
}

TEST(files_are_read)
{
    static const char path[] = "test_text.tmp";
    pd_ctx ctx;
    pd_text text;
    FILE *f = fopen(path, "wb");
    if (!CHECK(f != NULL)) return;
    fputs(sample, f);
    fclose(f);
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pdi_text_read(&ctx, path, &text));
    CHECK_INT(text.entry_count, 29);
    leave(&ctx, &text);
    remove(path);
    CHECK_INT(pdi_text_read(&ctx, path, &text), PD_ERR_FILE);
    leave(&ctx, &text);
}

TEST(limits)
{
    pd_ctx ctx;
    pd_text text;
    size_t size = PD_TEXT_SIZE + 1, used = 0;
    char *bytes = (char *)malloc(size);
    if (!CHECK(bytes != NULL)) return;
    pd_ctx_init(&ctx);
    memset(bytes, ' ', size);
    CHECK_INT(pdi_text_build(&ctx, "big", bytes, size, &text), PD_ERR_SIZE);
    leave(&ctx, &text);
    CHECK_OK(&ctx, pdi_text_build(&ctx, "big", bytes, size - 1, &text));
    leave(&ctx, &text);
    memcpy(bytes, "k = ", 4);
    CHECK_INT(pdi_text_build(&ctx, "big", bytes, size - 1, &text), PD_ERR_PARSE); /* no value */
    memset(bytes + 4, '1', size - 4);
    double value;
    CHECK_OK(&ctx, pdi_text_build(&ctx, "big", bytes, size - 1, &text));
    CHECK_INT(pdi_text_get_number(&ctx, &text, 0, "k", "", NULL, &value), PD_ERR_PARSE);
    check_message(&ctx, "big:1: column 5: found an expression of more than 4096", "shorter");
    leave(&ctx, &text);
    for (int k = 0; k <= PD_TEXT_ENTRIES; k++) used += (size_t)sprintf(bytes + used, "[s a%d]\n", k);
    CHECK_INT(pdi_text_build(&ctx, "many", bytes, used, &text), PD_ERR_PARSE);
    check_message(&ctx, "more than 4096 sections", "many:4");
    used = 0;
    for (int k = 0; k <= PD_TEXT_ENTRIES; k++) used += (size_t)sprintf(bytes + used, "k%d = 1 ", k);
    CHECK_INT(pdi_text_build(&ctx, "many", bytes, used, &text), PD_ERR_PARSE);
    check_message(&ctx, "many:1: found more than 4096 pairs", "expected fewer");
    CHECK_INT(ctx.in_use, 0);
    free(bytes);
}

/* Read everything that a scene would read; any answer is fine as long as it is an answer. */
static int read_all(pd_ctx *ctx, pd_text *text)
{
    static const pd_expr_symbol vars[] = {{"C", "mol/m3", 0}, {"x", "m", 0}};
    double low[3], high[3], value;
    int count, good = 0;
    pd_word_list words;
    pd_expr expr[3];
    for (int s = 0; s < text->section_count; s++)
        for (int k = 0; k < text->entry_count; k++) {
            if (text->entry[k].section != s) continue;
            const char *key = text->entry[k].key;
            good += pdi_text_get_number(ctx, text, s, key, "m", NULL, &value) == PD_OK;
            good += pdi_text_get_ranges(ctx, text, s, key, "m", NULL, 3, low, high, &count) == PD_OK;
            good += pdi_text_get_words(ctx, text, s, key, NULL, &words) == PD_OK;
            good += pdi_text_get_bool(ctx, text, s, key, NULL, &count) == PD_OK;
            if (pdi_text_get_exprs(ctx, text, s, key, NULL, vars, 2, NULL, 3, expr, &count) == PD_OK) {
                good++;
                while (count > 0) pd_expr_free(ctx, &expr[--count]);
            }
        }
    good += pdi_text_check_unused(ctx, text) == PD_OK;
    return good;
}

static void hostile(const char *bytes, size_t size, int *good, int *bad)
{
    pd_ctx ctx;
    pd_text text;
    pd_ctx_init(&ctx);
    pd_status status = pdi_text_build(&ctx, "f", bytes, size, &text);
    if (status == PD_OK) *good += read_all(&ctx, &text);
    else ++*bad;
    if (status != PD_OK && !(status == PD_ERR_PARSE && strncmp(ctx.message, "f:", 2) == 0))
        CHECK_STR(ctx.message, "f:line: ...");
    pdi_text_free(&ctx, &text);
    if (ctx.in_use != 0) CHECK_INT(ctx.in_use, 0);
}

TEST(byte_flips_and_truncation)
{
    static const char bytes[] = "[]=(),.#\n \r-\x01\xFF";
    static char t[sizeof sample];
    const size_t size = sizeof sample - 1;
    int good = 0, bad = 0;
    for (size_t k = 0; k <= size; k++) {
        char *exact = (char *)malloc(k ? k : 1); /* the sanitizer sees a read past the end */
        if (!CHECK(exact != NULL)) return;
        memcpy(exact, sample, k);
        hostile(exact, k, &good, &bad);
        free(exact);
    }
    for (size_t k = 0; k < size; k++) {
        memcpy(t, sample, size + 1);
        for (int bit = 0; bit < 8; bit++) {
            t[k] = (char)(sample[k] ^ (1 << bit));
            hostile(t, size, &good, &bad);
        }
        for (size_t b = 0; b < sizeof bytes; b++) { /* the end of the string too: byte 0 */
            t[k] = bytes[b];
            hostile(t, size, &good, &bad);
        }
    }
    NOTE("%d values read, %d files refused", good, bad);
    CHECK(good > 10000);
    CHECK(bad > 1000);
}

TEST(binary_garbage)
{
    unsigned state = 1;
    int good = 0, bad = 0;
    for (int k = 0; k < 2000; k++) {
        char bytes[256];
        size_t size = (size_t)(k % 256);
        for (size_t i = 0; i < size; i++) {
            state = state * 1664525u + 1013904223u;
            bytes[i] = (char)(state >> 24);
            if (k % 2) bytes[i] = (char)("[ab =()\n,.1#"[(state >> 24) % 12]);
        }
        hostile(bytes, size, &good, &bad);
        pd_ctx ctx;
        pd_text text;
        if (CHECK_OK(&ctx, load(&ctx, sample, &text))) {
            bytes[size < 256 ? size : 255] = '\0';
            pd_status status = pdi_override_apply(&ctx, &text, bytes);
            if (status != PD_OK) CHECK_INT(status, PD_ERR_PARSE);
        }
        pdi_text_free(&ctx, &text);
        if (ctx.in_use != 0) CHECK_INT(ctx.in_use, 0);
    }
    CHECK(bad > 1000);
}

static pd_status read_words(pd_ctx *ctx, void *user)
{
    pd_text text;
    pd_word_list words;
    (void)user;
    pd_status status = pdi_text_build(ctx, "pin", sample, sizeof sample - 1, &text);
    if (status == PD_OK) status = pdi_override_apply(ctx, &text, "new.key=3");
    if (status == PD_OK) {
        int s = pdi_text_get_section(ctx, &text, "output", NULL),
            extra = pdi_text_get_section(ctx, &text, "none", NULL);
        status = s < 0 || extra < 0 ? PD_ERR_MEMORY : pdi_text_get_words(ctx, &text, s, "fields", NULL, &words);
    }
    pdi_text_free(ctx, &text);
    return status;
}

TEST(allocation_failures) { CHECK_LE(30, fault_sweep("text", read_words, NULL, 10000, 1)); }

TEST_MAIN(ENTRY(pairs_of_the_sample) ENTRY(values_of_the_sample) ENTRY(lists_and_words)
          ENTRY(comparisons_do_not_start_pairs) ENTRY(flat_files) ENTRY(format_errors) ENTRY(value_errors)
          ENTRY(unused_keys_and_sections) ENTRY(sections_in_order) ENTRY(overrides) ENTRY(files_are_read) ENTRY(limits)
          ENTRY(byte_flips_and_truncation) ENTRY(binary_garbage) ENTRY(allocation_failures))
