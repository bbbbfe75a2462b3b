/* vti: the bytes of ImageData files, PVD collections. (vtk_reader.sh opens such files with VTK itself.) */
/* dims: 1 2 3 */
#include "io/file.h"
#include "test.h"
#include "io/vti.h"
#include <stdlib.h>

#define TEXT2(x) #x
#define TEXT1(x) TEXT2(x)
#define DIRECTORY "build/files_of_test_vti_" TEXT1(PD_DIM) "d" /* the three programs may run at once */
#define MAX_NODES 4096

typedef struct sample {
    pd_grid grid;
    double c[MAX_NODES], v[MAX_NODES * PD_DIM];
    uint8_t kind[MAX_NODES];
    int32_t grain[MAX_NODES];
} sample;

/* The value of component d in cell i; ghosts hold -1, which must not show up. */
static double value(const int *i, int d)
{
    double x = 0.25 + 1000 * d;
    for (int a = 0; a < PD_DIM; a++) x += i[a] * pow(10.0, a);
    return x;
}

static void fill(sample *s)
{
    static const int cells[3] = {4, 3, 5};
    static const double spacing[3] = {0.5e-6, 2e-6, 0.1};
    memset(s, 0, sizeof *s);
    s->grid.ghost = 2;
    s->grid.total = 1;
    for (int d = 0; d < PD_DIM; d++) {
        s->grid.n[d] = cells[d];
        s->grid.padded[d] = cells[d] + 4;
        s->grid.stride[d] = s->grid.total;
        s->grid.total *= s->grid.padded[d];
        s->grid.h[d] = spacing[d];
        s->grid.lo[d] = -1e-6 * (d + 1);
    }
    for (int32_t node = 0; node < s->grid.total; node++) {
        int index[3] = {0, 0, 0}, inside = 1;
        for (int d = 0; d < PD_DIM; d++) {
            index[d] = node / s->grid.stride[d] % s->grid.padded[d] - 2;
            inside = inside && index[d] >= 0 && index[d] < cells[d];
        }
        s->c[node] = inside ? value(index, 0) : -1;
        s->kind[node] = (uint8_t)(inside ? value(index, 0) : 255);
        s->grain[node] = inside ? (int32_t)(value(index, 0) - 500) : -1;
        for (int d = 0; d < PD_DIM; d++) s->v[d * s->grid.total + node] = inside ? value(index, d) : -1;
    }
}

enum { FIELDS = 5 };

static void describe(const sample *s, pd_vti_field *f)
{
    static const char *const names[FIELDS] = {"C [mol/m3]", "C single", "kind", "grain", "a<\"v\">&b"};
    static const pd_vti_type types[FIELDS] = {PD_VTI_FLOAT64, PD_VTI_FLOAT32, PD_VTI_UINT8, PD_VTI_INT32,
                                              PD_VTI_FLOAT64};
    const void *data[FIELDS] = {s->c, s->c, s->kind, s->grain, s->v};
    for (int k = 0; k < FIELDS; k++) {
        memset(&f[k], 0, sizeof f[k]);
        f[k].name = names[k];
        f[k].type = types[k];
        f[k].vector = k == 4;
        f[k].data = data[k];
    }
}

static void start(pd_ctx *ctx)
{
    pd_ctx_init(ctx);
    CHECK_OK(ctx, pd_file_make_directory(ctx, DIRECTORY));
}

/* The number behind `offset="` of the array of this name. */
static long offset_of(const char *text, const char *name)
{
    const char *at = strstr(text, name);
    at = at ? strstr(at, "offset=\"") : NULL;
    return at ? strtol(at + 8, NULL, 10) : -1;
}

/* Compare an appended array with the formula. */
static void check_array(const char *base, long offset, const sample *s, int type)
{
    static const size_t sizes[FIELDS] = {8, 4, 1, 4, 8};
    int cells = 1, components = type == 4 ? 3 : 1, wrong = 0;
    uint64_t bytes;
    for (int d = 0; d < PD_DIM; d++) cells *= s->grid.n[d];
    if (!CHECK(offset >= 0)) return;
    const char *at = base + offset;
    memcpy(&bytes, at, 8);
    CHECK_INT(bytes, (size_t)(cells * components) * sizes[type]);
    at += 8;
    for (int k = 0; k < cells; k++) {
        int index[3] = {0, 0, 0}, rest = k;
        for (int d = 0; d < PD_DIM; d++) {
            index[d] = rest % s->grid.n[d];
            rest /= s->grid.n[d];
        }
        for (int c = 0; c < components; c++, at += sizes[type]) {
            double wide, expected = c < PD_DIM ? value(index, c) : 0;
            float narrow;
            int32_t whole;
            memcpy(&narrow, at, 4);
            memcpy(&whole, at, 4);
            memcpy(&wide, at, 8);
            if (type == 0 || type == 4) wrong += wide != expected;
            if (type == 1) wrong += narrow != (float)expected;
            if (type == 2) wrong += (uint8_t)*at != (uint8_t)expected;
            if (type == 3) wrong += whole != (int32_t)(expected - 500);
        }
    }
    CHECK_INT(wrong, 0);
}

TEST(every_value_stands_where_the_head_says)
{
    static sample s;
    static const char *const keys[FIELDS] = {"Name=\"C [mol/m3]\"", "Name=\"C single\"", "Name=\"kind\"",
                                             "Name=\"grain\"", "Name=\"a&lt;&quot;v&quot;&gt;&amp;b\""};
    static const char *const extent[3] = {"WholeExtent=\"0 4 0 1 0 1\"", "WholeExtent=\"0 4 0 3 0 1\"",
                                          "WholeExtent=\"0 4 0 3 0 5\""};
    static const char *const spacing[3] = {"Origin=\"-1e-06 0 0\" Spacing=\"5e-07 5e-07 5e-07\"",
                                           "Origin=\"-1e-06 -2e-06 0\" Spacing=\"5e-07 2e-06 5e-07\"",
                                           "Origin=\"-1e-06 -2e-06 -3e-06\" Spacing=\"5e-07 2e-06 0.1\""};
    pd_ctx ctx;
    pd_vti_field fields[FIELDS];
    char *data;
    size_t size;
    start(&ctx);
    fill(&s);
    describe(&s, fields);
    if (!CHECK_OK(&ctx, pd_vti_write(&ctx, DIRECTORY "/a.vti", &s.grid, 6.1, fields, FIELDS))) return;
    CHECK_INT(ctx.in_use, 0);
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, DIRECTORY "/a.vti", 1 << 20, &data, &size))) return;
    CHECK(strstr(data, extent[PD_DIM - 1]) && strstr(data, spacing[PD_DIM - 1]));
    CHECK(strstr(data, "header_type=\"UInt64\"") && strstr(data, ">6.1</DataArray>"));
    const char *base = strstr(data, "<AppendedData encoding=\"raw\">\n_");
    if (!CHECK(base != NULL)) return;
    base = strchr(base, '_') + 1;
    for (int k = 0; k < FIELDS; k++) check_array(base, offset_of(data, keys[k]), &s, k);
    size_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) cells *= (size_t)s.grid.n[d];
    const char *end = base + FIELDS * 8 + cells * (8 + 4 + 1 + 4 + 24);
    CHECK_STR(end, "\n  </AppendedData>\n</VTKFile>\n");
    PD_DELETE(&ctx, size + 1, data);
    remove(DIRECTORY "/a.vti");
}

TEST(a_float_beyond_its_range_is_infinite)
{
    static sample s;
    pd_ctx ctx;
    pd_vti_field fields[FIELDS];
    char *data;
    size_t size;
    start(&ctx);
    fill(&s);
    describe(&s, fields);
    int32_t node = 0;
    for (int d = 0; d < PD_DIM; d++) node += 2 * s.grid.stride[d];
    s.c[node] = -1e200;
    s.c[node + 1] = NAN;
    if (!CHECK_OK(&ctx, pd_vti_write(&ctx, DIRECTORY "/b.vti", &s.grid, 0, fields + 1, 1))) return;
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, DIRECTORY "/b.vti", 1 << 20, &data, &size))) return;
    const char *base = strchr(strstr(data, "<AppendedData"), '_');
    float got[3];
    memcpy(got, base + 1 + 8, sizeof got);
    CHECK(isinf(got[0]) && got[0] < 0 && isnan(got[1]) && got[2] == 2.25f);
    PD_DELETE(&ctx, size + 1, data);
    remove(DIRECTORY "/b.vti");
}

TEST(wrong_fields_are_refused)
{
    static sample s;
    pd_ctx ctx;
    pd_vti_field fields[FIELDS];
    start(&ctx);
    fill(&s);
    describe(&s, fields);
    CHECK_INT(pd_vti_write(&ctx, DIRECTORY "/c.vti", &s.grid, NAN, fields, FIELDS), PD_ERR_ARGUMENT);
    fields[3].name = "kind";
    CHECK_INT(pd_vti_write(&ctx, DIRECTORY "/c.vti", &s.grid, 0, fields, FIELDS), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "two fields are named 'kind'") != NULL);
    describe(&s, fields);
    fields[1].data = NULL;
    CHECK_INT(pd_vti_write(&ctx, DIRECTORY "/c.vti", &s.grid, 0, fields, FIELDS), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "'C single' has no data") != NULL);
    describe(&s, fields);
    fields[2].name = "a\nb";
    CHECK_INT(pd_vti_write(&ctx, DIRECTORY "/c.vti", &s.grid, 0, fields, FIELDS), PD_ERR_ARGUMENT);
    describe(&s, fields);
    CHECK_INT(pd_vti_write(&ctx, DIRECTORY "/none/c.vti", &s.grid, 0, fields, FIELDS), PD_ERR_FILE);
    ctx.alloc.limit = 10;
    CHECK_INT(pd_vti_write(&ctx, DIRECTORY "/c.vti", &s.grid, 0, fields, FIELDS), PD_ERR_LIMIT);
    CHECK_INT(ctx.in_use, 0);
    CHECK(fopen(DIRECTORY "/c.vti", "rb") == NULL && fopen(DIRECTORY "/c.vti.part", "rb") == NULL);
}

static void collection_holds(pd_ctx *ctx, const char *lines)
{
    char *data, *from, *to;
    size_t size;
    if (!CHECK_OK(ctx, pdi_file_read_all(ctx, DIRECTORY "/run.pvd", 1 << 20, &data, &size))) return;
    from = strstr(data, "<Collection>\n");
    to = strstr(data, "  </Collection>\n</VTKFile>\n");
    CHECK(strncmp(data, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"", 48) == 0);
    if (CHECK(from && to)) {
        *to = 0;
        CHECK_STR(from + 13, lines);
    }
    PD_DELETE(ctx, size + 1, data);
}

TEST(a_collection_lists_times_that_increase)
{
    pd_ctx ctx;
    pd_pvd pvd;
    start(&ctx);
    memset(&pvd, 0, sizeof pvd);
    CHECK_INT(pdi_pvd_add_file(&ctx, &pvd, 0, "a.vti"), PD_ERR_ARGUMENT);
    if (!CHECK_OK(&ctx, pdi_pvd_init(&ctx, DIRECTORY "/run.pvd", &pvd))) return;
    CHECK_OK(&ctx, pdi_pvd_add_file(&ctx, &pvd, 0, DIRECTORY "/a.vti"));
    CHECK_OK(&ctx, pdi_pvd_add_file(&ctx, &pvd, 0.1, "elsewhere/b&c.vti"));
    CHECK_INT(pdi_pvd_add_file(&ctx, &pvd, 0.1, "same.vti"), PD_ERR_ARGUMENT);
    CHECK(strstr(ctx.message, "times must increase") != NULL);
    CHECK_INT(pdi_pvd_add_file(&ctx, &pvd, 0.05, "back.vti"), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_pvd_add_file(&ctx, &pvd, NAN, "nan.vti"), PD_ERR_ARGUMENT);
    CHECK_INT(pdi_pvd_add_file(&ctx, &pvd, 1, "a\nb.vti"), PD_ERR_ARGUMENT);
    CHECK_INT(pvd.count, 2);
    collection_holds(&ctx, "    <DataSet timestep=\"0\" group=\"\" part=\"0\" file=\"a.vti\"/>\n"
                           "    <DataSet timestep=\"0.1\" group=\"\" part=\"0\" file=\"elsewhere/b&amp;c.vti\"/>\n");
    pdi_pvd_free(&ctx, &pvd);
    pdi_pvd_free(&ctx, &pvd);
    CHECK_INT(ctx.in_use, 0);
    CHECK_INT(pdi_pvd_init(&ctx, "", &pvd), PD_ERR_ARGUMENT);
    remove(DIRECTORY "/run.pvd");
}

/* An entry that could not be written is not in the collection later either. */
TEST(a_failed_entry_changes_nothing)
{
    pd_ctx ctx;
    pd_pvd pvd;
    start(&ctx);
    remove(DIRECTORY "/later/run.pvd");
    remove(DIRECTORY "/later");
    if (!CHECK_OK(&ctx, pdi_pvd_init(&ctx, DIRECTORY "/later/run.pvd", &pvd))) return;
    CHECK_INT(pdi_pvd_add_file(&ctx, &pvd, 5, "lost.vti"), PD_ERR_FILE);
    CHECK_OK(&ctx, pd_file_make_directory(&ctx, DIRECTORY "/later"));
    for (int k = 0; k < 100; k++) CHECK_OK(&ctx, pdi_pvd_add_file(&ctx, &pvd, k, "x.vti"));
    char *data;
    size_t size;
    if (!CHECK_OK(&ctx, pdi_file_read_all(&ctx, DIRECTORY "/later/run.pvd", 1 << 20, &data, &size))) return;
    int entries = 0;
    for (const char *at = data; (at = strstr(at, "<DataSet ")) != NULL; at++) entries++;
    CHECK_INT(entries, 100);
    CHECK(strstr(data, "lost") == NULL);
    PD_DELETE(&ctx, size + 1, data);
    pdi_pvd_free(&ctx, &pvd);
    CHECK_INT(ctx.in_use, 0);
    remove(DIRECTORY "/later/run.pvd");
    remove(DIRECTORY "/later");
    remove(DIRECTORY);
}

TEST_MAIN(ENTRY(every_value_stands_where_the_head_says) ENTRY(a_float_beyond_its_range_is_infinite)
          ENTRY(wrong_fields_are_refused) ENTRY(a_collection_lists_times_that_increase)
          ENTRY(a_failed_entry_changes_nothing))
