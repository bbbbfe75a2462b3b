/* file, csv, progress: complete files or none, paths, numbers, tables, the progress line. dims: 2 */
#define _XOPEN_SOURCE 700
#include "io/csv.h"
#include "io/file.h"
#include "io/progress.h"
#include "fault.h"
#include <locale.h>
#include <sys/resource.h>
#include <unistd.h>

#define DIRECTORY "build/files_of_test_file"

static const char *at(const char *name)
{
    static char path[8][256];
    static int turn;
    turn = (turn + 1) % 8;
    snprintf(path[turn], sizeof path[0], DIRECTORY "/%s", name);
    return path[turn];
}

static void start(pd_ctx *ctx)
{
    pd_ctx_init(ctx);
    CHECK_OK(ctx, pd_file_make_directory(ctx, DIRECTORY));
}

static void put(const char *name, const char *text, size_t size)
{
    FILE *f = fopen(at(name), "wb");
    if (!CHECK(f != NULL)) return;
    CHECK(fwrite(text, 1, size, f) == size);
    fclose(f);
}

static void puts_to(const char *name, const char *text) { put(name, text, strlen(text)); }

static int exists(const char *name)
{
    FILE *f = fopen(at(name), "rb");
    if (f) fclose(f);
    return f != NULL;
}

/* The content of a file by the C library alone. */
static const char *content(const char *name)
{
    static char text[4096];
    FILE *f = fopen(at(name), "rb");
    text[0] = 0;
    if (!f) return "(missing)";
    text[fread(text, 1, sizeof text - 1, f)] = 0;
    fclose(f);
    return text;
}

TEST(a_whole_file_is_read)
{
    pd_ctx ctx;
    char *data;
    size_t size;
    static char big[50001];
    start(&ctx);
    for (size_t i = 0; i < sizeof big; i++) big[i] = (char)(i * 37 % 251);
    put("whole", big, sizeof big);
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, at("whole"), sizeof big, &data, &size))) return;
    CHECK_INT(size, sizeof big);
    CHECK(memcmp(data, big, size) == 0);
    CHECK(data[size] == 0);
    PD_DELETE(&ctx, size + 1, data);
    puts_to("whole", "");
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, at("whole"), 0, &data, &size))) return;
    CHECK_INT(size, 0);
    CHECK_STR(data, "");
    PD_DELETE(&ctx, size + 1, data);
    CHECK_INT(ctx.in_use, 0);
    remove(at("whole"));
}

TEST(a_file_that_cannot_be_read_is_an_error)
{
    pd_ctx ctx;
    char *data, longer[1200];
    size_t size;
    start(&ctx);
    CHECK_INT(pdi_file_read_all(&ctx, at("none"), 10, &data, &size), PD_ERR_FILE);
    CHECK(strstr(ctx.message, DIRECTORY "/none") && strstr(ctx.message, "No such file"));
    CHECK(data == NULL);
    CHECK_INT(pdi_file_read_all(&ctx, DIRECTORY, 10, &data, &size), PD_ERR_FILE);
    puts_to("eleven", "12345678901");
    CHECK_INT(pdi_file_read_all(&ctx, at("eleven"), 10, &data, &size), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "larger than 10 bytes") != NULL);
    CHECK_INT(pdi_file_read_all(&ctx, "", 10, &data, &size), PD_ERR_ARGUMENT);
    memset(longer, 'a', sizeof longer);
    longer[sizeof longer - 1] = 0;
    CHECK_INT(pdi_file_read_all(&ctx, longer, 10, &data, &size), PD_ERR_SIZE);
    CHECK_INT(ctx.in_use, 0);
    remove(at("eleven"));
}

/* Folders and devices, which have no end. */
TEST(only_plain_files_are_read)
{
    static const char *const found[] = {DIRECTORY, "/dev/zero", "/dev/null"};
    pd_ctx ctx;
    pd_file file;
    char *data;
    size_t size;
    start(&ctx);
    for (int k = 0; k < 3; k++) {
        CHECK_INT(pdi_file_read_all(&ctx, found[k], 1 << 30, &data, &size), PD_ERR_FILE);
        CHECK(strstr(ctx.message, found[k]) != NULL);
        CHECK(!k || strstr(ctx.message, "it is a device, expected a file") || strstr(ctx.message, "No such file"));
        CHECK(data == NULL);
        CHECK_INT(pdi_file_open_read(&ctx, found[k], &file), PD_ERR_FILE);
        CHECK(file.stream == NULL);
    }
    CHECK_INT(pdi_file_open_append(&ctx, "/dev/null", &file), PD_ERR_FILE);
    CHECK_INT(pdi_file_open_append(&ctx, at("none"), &file), PD_ERR_FILE);
    CHECK_INT(ctx.in_use, 0);
    CHECK_LE((double)ctx.peak, 0.0);
}

/* A file counts towards the limit of memory, with its size. */
TEST(reading_counts)
{
    static char big[100000];
    pd_ctx ctx;
    char *data;
    size_t size;
    start(&ctx);
    put("big", big, sizeof big);
    ctx.alloc.limit = sizeof big;
    CHECK_INT(pdi_file_read_all(&ctx, at("big"), 1 << 20, &data, &size), PD_ERR_LIMIT);
    CHECK_LE((double)ctx.peak, (double)sizeof big);
    ctx.alloc.limit = sizeof big + 1;
    if (CHECK_OK(&ctx, pdi_file_read_all(&ctx, at("big"), 1 << 20, &data, &size))) PD_DELETE(&ctx, size + 1, data);
    CHECK_INT(ctx.in_use, 0);
    remove(at("big"));
}

TEST(the_final_name_holds_a_complete_file_or_the_old_one)
{
    pd_ctx ctx;
    pd_file file;
    start(&ctx);
    puts_to("result", "old");
    if (!CHECK_OK(&ctx, pdi_file_create(&ctx, at("result"), &file))) return;
    CHECK_OK(&ctx, pdi_file_write_text(&ctx, &file, "new "));
    CHECK_OK(&ctx, pdi_file_flush(&ctx, &file));
    CHECK_STR(content("result"), "old");
    CHECK_STR(content("result.part"), "new ");
    CHECK_OK(&ctx, pdi_file_write(&ctx, &file, "content", 7));
    CHECK_OK(&ctx, pdi_file_commit(&ctx, &file));
    CHECK_STR(content("result"), "new content");
    CHECK(!exists("result.part"));
    if (!CHECK_OK(&ctx, pdi_file_create(&ctx, at("result"), &file))) return;
    CHECK_OK(&ctx, pdi_file_write_text(&ctx, &file, "unfinished"));
    pdi_file_abandon(&file);
    pdi_file_abandon(&file);
    CHECK_STR(content("result"), "new content");
    CHECK(!exists("result.part"));
    CHECK_INT(pdi_file_write_text(&ctx, &file, "late"), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_file_commit(&ctx, &file), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_file_create(&ctx, at("no/such/place"), &file), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "no/such/place") != NULL);
    remove(at("result"));
}

TEST(a_commit_onto_a_directory_fails_and_leaves_nothing)
{
    pd_ctx ctx;
    pd_file file;
    start(&ctx);
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, at("occupied")));
    if (!CHECK_OK(&ctx, pdi_file_create(&ctx, at("occupied"), &file))) return;
    CHECK_INT(pdi_file_commit(&ctx, &file), PD_ERR_FILE);
    CHECK(strstr(ctx.message, "occupied") != NULL);
    CHECK(!exists("occupied.part"));
    remove(at("occupied"));
}

TEST(a_full_disk_is_noticed)
{
    pd_ctx ctx;
    pd_file file;
    pd_ctx_init(&ctx);
    memset(&file, 0, sizeof file);
    strcpy(file.path, "/dev/full");
    file.stream = fopen(file.path, "ab");
    if (!file.stream) SKIP("no /dev/full here");
    pd_status written = pdi_file_write_text(&ctx, &file, "row\n");
    pd_status flushed = pdi_file_flush(&ctx, &file);
    CHECK(written == PD_ERR_FILE || flushed == PD_ERR_FILE);
    CHECK(strstr(ctx.message, "/dev/full") && strstr(ctx.message, "No space"));
    CHECK_INT(pdi_file_commit(&ctx, &file), PD_ERR_FILE); /* the error is not forgotten */
}

TEST(directories_are_made_with_their_parents)
{
    pd_ctx ctx;
    start(&ctx);
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, at("a/b/c/")));
    puts_to("a/b/c/leaf", "x");
    CHECK(exists("a/b/c/leaf"));
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, at("a/b/c")));
    CHECK_INT(pd_file_make_directory(&ctx, at("a/b/c/leaf")), PD_ERR_FILE);
    CHECK_INT(pd_file_make_directory(&ctx, at("a/b/c/leaf/more")), PD_ERR_FILE);
    CHECK_INT(pd_file_make_directory(&ctx, ""), PD_ERR_ARGUMENT);
    remove(at("a/b/c/leaf"));
    remove(at("a/b/c"));
    remove(at("a/b"));
    remove(at("a"));
}

TEST(names_are_joined_and_numbered)
{
    pd_ctx ctx;
    char path[PD_PATH_SIZE], longer[1010];
    pd_ctx_init(&ctx);
    CHECK_OK(&ctx, pd_file_join(&ctx, "out", "a.vti", path));
    CHECK_STR(path, "out/a.vti");
    CHECK_OK(&ctx, pd_file_join(&ctx, "out/", "a.vti", path));
    CHECK_STR(path, "out/a.vti");
    CHECK_OK(&ctx, pd_file_join(&ctx, "", "a.vti", path));
    CHECK_STR(path, "a.vti");
    memset(longer, 'n', sizeof longer);
    longer[sizeof longer - 1] = 0;
    CHECK_INT(pd_file_join(&ctx, "a_directory_name", longer, path), PD_ERR_SIZE);
    CHECK_OK(&ctx, pdi_file_format_frame_name(&ctx, "corr", 12, 6.1, "vti", path));
    CHECK_STR(path, "corr_000012_t6.1s.vti");
    CHECK_OK(&ctx, pdi_file_format_frame_name(&ctx, "C", 999999, 32400, "png", path));
    CHECK_STR(path, "C_999999_t32400.0s.png");
    CHECK_OK(&ctx, pdi_file_format_frame_name(&ctx, "v", 3, 0.025, "vti", path));
    CHECK_STR(path, "v_000003_t0.025s.vti");
    CHECK_OK(&ctx, pdi_file_format_frame_name(&ctx, "v", 3, 2.0 / 3.0, "vti", path));
    CHECK_STR(path, "v_000003_t0.666667s.vti");
    CHECK_INT(pdi_file_format_frame_name(&ctx, "C", 1000000, 0, "png", path), PD_ERR_ARGUMENT);
    CHECK_STR(path, ""); /* a name that is refused is empty */
    CHECK_INT(pdi_file_format_frame_name(&ctx, "C", -1, 0, "png", path), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_file_format_frame_name(&ctx, "C", 1, -0.5, "png", path), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_file_format_frame_name(&ctx, "C", 1, NAN, "png", path), PD_ERR_ARGUMENT);
}

static double bits_to_double(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void numbers_come_back(void)
{
    char text[PDI_FILE_NUMBER_SIZE];
    double back;
    uint64_t x = 88172645463325252u;
    int wrong = 0, finite = 0;
    for (int k = 0; k < 20000; k++) {
        x ^= x << 13; /* xorshift64 (Marsaglia 2003) */
        x ^= x >> 7;
        x ^= x << 17;
        double value = bits_to_double(x);
        if (isnan(value) || isinf(value)) continue;
        finite++;
        pdi_file_format_number(value, text);
        wrong += !pdi_file_parse_number(text, strlen(text), &back) || memcmp(&back, &value, sizeof back) != 0;
        wrong += strpbrk(text, ", ") != NULL;
    }
    CHECK(finite > 19000);
    CHECK_INT(wrong, 0);
}

TEST(numbers_are_short_and_come_back_bit_for_bit)
{
    static const struct {
        double value;
        const char *text;
    } cases[] = {{0.1, "0.1"},
                 {1.0 / 3, "0.3333333333333333"},
                 {-0.0, "-0"},
                 {1e-9, "1e-09"},
                 {71500, "71500"},
                 {5e-324, "4.94065645841247e-324"},
                 {1.7976931348623157e308, "1.7976931348623157e+308"},
                 {INFINITY, "inf"},
                 {-INFINITY, "-inf"},
                 {NAN, "nan"}};
    char text[PDI_FILE_NUMBER_SIZE];
    double value;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        pdi_file_format_number(cases[k].value, text);
        CHECK_STR(text, cases[k].text);
    }
    numbers_come_back();
    CHECK(pdi_file_parse_number("-2.5e3", 6, &value) && value == -2500);
    CHECK(pdi_file_parse_number("nan", 3, &value) && isnan(value));
    CHECK(pdi_file_parse_number("12345", 2, &value) && value == 12);
    static const char *const bad[] = {"", " 1", "1 ", "1.2.3", "0x10", "1,5", "1e", "--1", "abc", "nan(1)", "1\n"};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
        CHECK(!pdi_file_parse_number(bad[k], strlen(bad[k]), &value));
}

TEST(decimal_numbers_at_the_start_of_a_text)
{
    static const struct {
        const char *text;
        size_t length;
    } cases[] = {{"", 0},      {"-", 0},      {".", 0},       {" 1", 0},   {"inf", 0},   {"nan", 0},   {"+-1", 0},
                 {".e1", 0},   {"5", 1},      {"0x10", 1},    {"1,5", 1},  {"1e", 1},    {"1e+ 2", 1}, {"1.", 2},
                 {"1.5.2", 3}, {"-.5 um", 3}, {"+2.e-3s", 6}, {"1e3m", 3}, {"12E05", 5}, {"2m/s", 1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        if (!CHECK(pdi_file_find_number_length(cases[k].text, strlen(cases[k].text)) == cases[k].length))
            NOTE("'%s'", cases[k].text);
    CHECK(pdi_file_find_number_length("12345", 2) == 2); /* nothing behind the text counts */
    CHECK(pdi_file_find_number_length("1e+5", 3) == 1);
    CHECK(pdi_file_find_number_length("1.5", 1) == 1);
}

TEST(numbers_do_not_follow_the_locale)
{
    static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "de_DE", "fr_FR.UTF-8", "fr_FR.utf8"};
    char text[PDI_FILE_NUMBER_SIZE], path[PD_PATH_SIZE], probe[16];
    double value = 0;
    pd_ctx ctx;
    pd_ctx_init(&ctx);
    const char *found = NULL;
    for (size_t k = 0; k < sizeof names / sizeof names[0] && !found; k++) found = setlocale(LC_ALL, names[k]);
    snprintf(probe, sizeof probe, "%.1f", 0.5);
    if (!found || strcmp(probe, "0,5") != 0) {
        setlocale(LC_ALL, "C");
        SKIP("no locale with a decimal comma is installed");
    }
    pdi_file_format_number(0.1, text);
    CHECK_STR(text, "0.1");
    CHECK(pdi_file_parse_number("0.25", 4, &value) && value == 0.25);
    numbers_come_back();
    CHECK_OK(&ctx, pdi_file_format_frame_name(&ctx, "corr", 12, 6.1, "vti", path));
    CHECK_STR(path, "corr_000012_t6.1s.vti");
    setlocale(LC_ALL, "C");
}

TEST(rows_are_in_the_file_as_soon_as_they_are_written)
{
    static const char *const names[] = {"time [s]", "volume loss [-]", "a,b \"c\""};
    pd_ctx ctx;
    pd_csv csv;
    start(&ctx);
    puts_to("run.csv", "rows of an older run\n");
    if (!CHECK_OK(&ctx, pd_csv_create(&ctx, at("run.csv"), names, 3, &csv))) return;
    CHECK_STR(content("run.csv"), "time [s],volume loss [-],\"a,b \"\"c\"\"\"\n");
    CHECK(!exists("run.csv.part"));
    double row[3] = {0.1, 1.0 / 3, -1e-30};
    CHECK_OK(&ctx, pd_csv_write_row(&ctx, &csv, row));
    CHECK(strstr(content("run.csv"), "\n0.1,0.3333333333333333,-1e-30\n") != NULL);
    row[0] = NAN;
    CHECK_OK(&ctx, pd_csv_write_row(&ctx, &csv, row));
    CHECK(strstr(content("run.csv"), "\nnan,0.3333333333333333,-1e-30\n") != NULL);
    CHECK_OK(&ctx, pd_csv_close(&ctx, &csv));
    CHECK_OK(&ctx, pd_csv_close(&ctx, &csv));
    CHECK_INT(pd_csv_write_row(&ctx, &csv, row), PD_ERR_ARGUMENT);
    CHECK_INT(ctx.in_use, 0);
    remove(at("run.csv"));
}

TEST(a_table_needs_proper_names)
{
    static const char *const twice[] = {"a", "a"}, *const empty[] = {"a", ""}, *const broken[] = {"a\nb"};
    pd_ctx ctx;
    pd_csv csv;
    start(&ctx);
    CHECK_INT(pd_csv_create(&ctx, at("bad.csv"), twice, 2, &csv), PD_ERR_ARGUMENT);
    CHECK_INT(pd_csv_create(&ctx, at("bad.csv"), empty, 2, &csv), PD_ERR_ARGUMENT);
    CHECK_INT(pd_csv_create(&ctx, at("bad.csv"), broken, 1, &csv), PD_ERR_ARGUMENT);
    CHECK_INT(pd_csv_create(&ctx, at("bad.csv"), twice, 0, &csv), PD_ERR_ARGUMENT);
    CHECK_INT(pd_csv_create(&ctx, at("none/bad.csv"), twice, 1, &csv), PD_ERR_FILE);
    CHECK(!exists("bad.csv") && !exists("bad.csv.part"));
}

TEST(a_written_table_is_read_back)
{
    static const char *const names[] = {"t", " q\"uo,te ", "#c"};
    pd_ctx ctx;
    pd_csv csv;
    pd_table table;
    double row[3], column[500];
    start(&ctx);
    if (!CHECK_OK(&ctx, pd_csv_create(&ctx, at("back.csv"), names, 3, &csv))) return;
    for (int k = 0; k < 500; k++) {
        row[0] = k / 7.0;
        row[1] = exp(k);
        row[2] = -sqrt((double)k);
        CHECK_OK(&ctx, pd_csv_write_row(&ctx, &csv, row));
    }
    CHECK_OK(&ctx, pd_csv_close(&ctx, &csv));
    if (!CHECK_OK(&ctx, pd_table_read(&ctx, at("back.csv"), &table))) return;
    CHECK_INT(table.rows, 500);
    CHECK_INT(table.columns, 3);
    for (int c = 0; c < 3; c++) {
        CHECK_INT(pd_table_find_column(&table, names[c]), c);
        CHECK_OK(&ctx, pd_table_parse_column(&ctx, &table, names[c], column));
        int wrong = 0;
        for (int k = 0; k < 500; k++) wrong += column[k] != (c == 0 ? k / 7.0 : c == 1 ? exp(k) : -sqrt((double)k));
        CHECK_INT(wrong, 0);
    }
    pd_table_free(&ctx, &table);
    pd_table_free(&ctx, &table);
    CHECK_INT(ctx.in_use, 0);
    remove(at("back.csv"));
}

TEST(tables_of_others_are_read)
{
    pd_ctx ctx;
    pd_table table;
    double values[4];
    start(&ctx);
    puts_to("others.csv", "\xEF\xBB\xBF# source, with a comma\r\n\r\n x , \"name, \"\"quoted\"\"\",units\r\n"
                          "1e3, plate  ,mm\r\n   # between\n-2,\"E, Young\" , \n\n3,,GPa");
    if (!CHECK_OK(&ctx, pd_table_read(&ctx, at("others.csv"), &table))) return;
    CHECK_INT(table.columns, 3);
    CHECK_INT(table.rows, 3);
    CHECK_STR(pd_table_get_text(&table, -1, 0), "x");
    CHECK_STR(pd_table_get_text(&table, -1, 1), "name, \"quoted\"");
    CHECK_STR(pd_table_get_text(&table, 0, 1), "plate");
    CHECK_STR(pd_table_get_text(&table, 1, 1), "E, Young");
    CHECK_STR(pd_table_get_text(&table, 1, 2), "");
    CHECK_STR(pd_table_get_text(&table, 2, 1), "");
    CHECK_STR(pd_table_get_text(&table, 2, 2), "GPa");
    CHECK_OK(&ctx, pd_table_parse_column(&ctx, &table, "x", values));
    CHECK(values[0] == 1000 && values[1] == -2 && values[2] == 3);
    CHECK_INT(pd_table_parse_column(&ctx, &table, "units", values), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "others.csv:4: column 'units': 'mm'") != NULL);
    CHECK_INT(pd_table_parse_column(&ctx, &table, "y", values), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "'y'") && strstr(ctx.message, "'x'"));
    pd_table_free(&ctx, &table);
    puts_to("others.csv", ",b\n"); /* an empty first field must not run into the second */
    CHECK_INT(pd_table_read(&ctx, at("others.csv"), &table), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, ":1: a column has no name") != NULL);
    CHECK_INT(ctx.in_use, 0);
    remove(at("others.csv"));
}

TEST(a_broken_table_names_its_line)
{
    static const struct {
        const char *text, *message;
    } cases[] = {{"a,b\n1,2\n3\n", ":3: 1 fields, expected 2"}, {"a,b\n1,2,3\n", ":2: 3 fields, expected 2"},
                 {"a,b\n1,\"2\n", ":2: a quote is not closed"}, {"a,b\n\n\"1\"x,2\n", ":3: text behind a closing"},
                 {"# only\n", "no line of column names"},       {"", "no line of column names"},
                 {"a,b,a\n", ":1: two columns are named 'a'"},  {"a,\n", ":1: a column has no name"}};
    pd_ctx ctx;
    pd_table table;
    start(&ctx);
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        puts_to("broken.csv", cases[k].text);
        CHECK_INT(pd_table_read(&ctx, at("broken.csv"), &table), PD_ERR_PARSE);
        if (!CHECK(strstr(ctx.message, cases[k].message) != NULL)) NOTE("%s", ctx.message);
    }
    put("broken.csv", "a,b\n1,\0\n", 8);
    CHECK_INT(pd_table_read(&ctx, at("broken.csv"), &table), PD_ERR_PARSE);
    CHECK(strstr(ctx.message, "not a text file") != NULL);
    CHECK_INT(pd_table_read(&ctx, at("none.csv"), &table), PD_ERR_FILE);
    CHECK_INT(ctx.in_use, 0);
    remove(at("broken.csv"));
}

TEST(every_failing_allocation_is_reported)
{
    pd_ctx ctx;
    pd_table table;
    static char text[40000];
    size_t used = 4;
    start(&ctx);
    memcpy(text, "a,b\n", 4);
    for (int k = 0; used < sizeof text - 64; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%d,%d\n", k, k * k);
    put("many.csv", text, used);
    fault f;
    pd_status status = PD_ERR_MEMORY;
    int tries = 0;
    for (; status != PD_OK && tries < 100; tries++) {
        fault_context(&f, tries + 1, 1, &ctx);
        status = pd_table_read(&ctx, at("many.csv"), &table);
        if (status != PD_OK) CHECK_INT(status, PD_ERR_MEMORY);
        if (status != PD_OK) CHECK_INT(ctx.in_use, 0);
    }
    CHECK_OK(&ctx, status);
    CHECK(tries > 5);
    pd_table_free(&ctx, &table);
    remove(at("many.csv"));
}

/* Any bytes: read or refused, never a crash or a leak. */
TEST(damaged_tables_do_no_harm)
{
    static const char sample[] = "# c\n\"a \"\"q\"\"\",b,c\n1,2,3\n\"4\", 5 ,6\r\n\n7,8,9";
    char text[sizeof sample];
    pd_ctx ctx;
    pd_table table;
    int read = 0, refused = 0, wrong = 0;
    start(&ctx);
    for (size_t cut = 0; cut < sizeof sample; cut++)
        for (int flip = 0; flip < 9; flip++) {
            memcpy(text, sample, sizeof sample);
            if (flip && cut < sizeof sample - 1) text[cut] = (char)(text[cut] ^ 1 << (flip - 1));
            put("hurt.csv", text, flip ? sizeof sample - 1 : cut);
            pd_status status = pd_table_read(&ctx, at("hurt.csv"), &table);
            if (status == PD_OK) {
                read++;
                for (int r = -1; r < table.rows; r++)
                    for (int c = 0; c < table.columns; c++)
                        wrong += strchr(pd_table_get_text(&table, r, c), '\n') != NULL;
                pd_table_free(&ctx, &table);
            } else refused++;
            wrong += status != PD_OK && status != PD_ERR_PARSE;
            wrong += ctx.in_use != 0;
        }
    CHECK_INT(wrong, 0);
    CHECK(read > 100 && refused > 50);
    remove(at("hurt.csv"));
}

TEST(times_are_printed_in_the_unit_that_suits)
{
    static const struct {
        double seconds;
        const char *text;
    } cases[] = {{0, "0.00 s"},
                 {0.25, "0.25 s"},
                 {9.996, "10.0 s"},
                 {12.34, "12.3 s"},
                 {59.94, "59.9 s"},
                 {59.96, "1 min 00 s"},
                 {125, "2 min 05 s"},
                 {3599.4, "59 min 59 s"},
                 {3599.6, "1 h 00 min"},
                 {11220, "3 h 07 min"},
                 {1051200, "12 d 4 h"},
                 {-1, "?"},
                 {NAN, "?"},
                 {INFINITY, "?"}};
    char text[64];
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        pdi_progress_format_duration(cases[k].seconds, text, sizeof text);
        CHECK_STR(text, cases[k].text);
    }
}

TEST(the_progress_line_shows_the_time_left)
{
    char line[128], small[12];
    pdi_progress_format_line(0.25, 100, "dissolve", line, sizeof line);
    CHECK_STR(line, "dissolve [###.........]  25.0 %  1 min 40 s, 5 min 00 s left");
    pdi_progress_format_line(0, 5, "flow", line, sizeof line);
    CHECK_STR(line, "flow [............]   0.0 %  5.00 s");
    pdi_progress_format_line(1, 61, "flow", line, sizeof line);
    CHECK_STR(line, "flow [############] 100.0 %  1 min 01 s");
    pdi_progress_format_line(NAN, 5, "flow", line, sizeof line);
    CHECK(strstr(line, "  0.0 %") != NULL);
    pdi_progress_format_line(7, 5, "flow", line, sizeof line);
    CHECK(strstr(line, "100.0 %") != NULL);
    pdi_progress_format_line(0.5, 5, "flow", small, sizeof small);
    CHECK_STR(small, "flow [#####");
    remove(DIRECTORY);
}

/* Nothing is appended to a file that is reached by a link, soft or hard, and the refusal leaves no file open. */
TEST(links_are_not_appended_to)
{
    struct rlimit all, few;
    pd_ctx ctx;
    pd_file file;
    start(&ctx);
    memset(&file, 0, sizeof file);
    put("own", "a\n", 2);
    remove(at("hard"));
    remove(at("soft"));
    CHECK(getrlimit(RLIMIT_NOFILE, &all) == 0);
    few = all;
    few.rlim_cur = 32;
    CHECK(setrlimit(RLIMIT_NOFILE, &few) == 0);
    if (CHECK(link(at("own"), at("hard")) == 0) && CHECK(symlink("own", at("soft")) == 0))
        for (int k = 0; k < 100; k++) {
            const char *name = k % 2 ? "hard" : "soft";
            CHECK_INT(pdi_file_open_append(&ctx, at(name), &file), PD_ERR_FILE);
            if (!CHECK(strstr(ctx.message, "it is a link") != NULL)) NOTE("%s: %s", name, ctx.message);
        }
    remove(at("hard"));
    remove(at("soft"));
    CHECK_OK(&ctx, pdi_file_open_append(&ctx, at("own"), &file));
    pdi_file_abandon(&file);
    CHECK(setrlimit(RLIMIT_NOFILE, &all) == 0);
}

TEST_MAIN(ENTRY(a_whole_file_is_read) ENTRY(a_file_that_cannot_be_read_is_an_error) ENTRY(only_plain_files_are_read)
              ENTRY(reading_counts) ENTRY(the_final_name_holds_a_complete_file_or_the_old_one)
                  ENTRY(a_commit_onto_a_directory_fails_and_leaves_nothing) ENTRY(a_full_disk_is_noticed)
                      ENTRY(directories_are_made_with_their_parents) ENTRY(names_are_joined_and_numbered)
                          ENTRY(numbers_are_short_and_come_back_bit_for_bit)
                              ENTRY(decimal_numbers_at_the_start_of_a_text) ENTRY(numbers_do_not_follow_the_locale)
                                  ENTRY(rows_are_in_the_file_as_soon_as_they_are_written)
                                      ENTRY(a_table_needs_proper_names) ENTRY(a_written_table_is_read_back)
                                          ENTRY(tables_of_others_are_read) ENTRY(a_broken_table_names_its_line)
                                              ENTRY(every_failing_allocation_is_reported)
                                                  ENTRY(damaged_tables_do_no_harm)
                                                      ENTRY(times_are_printed_in_the_unit_that_suits)
                                                          ENTRY(the_progress_line_shows_the_time_left)
                                                              ENTRY(links_are_not_appended_to))
