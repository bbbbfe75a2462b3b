/* array_registry: lists of arrays: what is built, freed, counted and kept by them, and the lists of the library.
 * dims: 1 2 3 */
#include "fault.h"
#include "flow/implicit.h"
#include "flow/weakly_compressible.h"
#include "io/archive_file.h"
#include "setup/units.h"
#include "transport/two_stage.h"

typedef struct thing {
    int32_t nodes, rows;
    int moving;     /* 1: it has a speed */
    double *field;  /* [2][nodes] */
    float *work;    /* [nodes] */
    double *speed;  /* [nodes] */
    uint8_t *mark;  /* [rows] */
    int32_t *line;  /* [room] */
    int32_t room;
    double time;
    int64_t steps;
} thing;

static void list_of_thing(pdi_array_visitor *owner, void *object)
{
    thing *it = (thing *)object;
    PDI_ARRAY_STATE(owner, it, field, 2 * (int64_t)it->nodes, "mol/m3");
    PDI_ARRAY(owner, it, work, it->nodes, "1");
    if (it->moving) PDI_ARRAY_STATE(owner, it, speed, it->nodes, "m/s");
    PDI_ARRAY_GROWING(owner, it, line, it->room, "1");
    PDI_SCALAR_STATE(owner, it, time, "s");
    PDI_SCALAR_STATE(owner, it, steps, "1");
}

static void list_of_rows(pdi_array_visitor *owner, void *object)
{
    thing *it = (thing *)object;
    PDI_ARRAY(owner, it, mark, it->rows, "1");
}

static thing make_thing(int moving)
{
    thing it;
    memset(&it, 0, sizeof it);
    it.nodes = 7;
    it.moving = moving;
    return it;
}

/* All arrays are there, hold zeros whatever their pointers held, and are counted before they are built. */
TEST(built_as_counted)
{
    for (int moving = 0; moving < 2; moving++) {
        fault f;
        pd_ctx ctx;
        thing it = make_thing(moving);
        double other = 1.0;
        fault_context(&f, 0, 0, &ctx);
        int64_t bytes = pdi_array_registry_count_bytes(list_of_thing, &it);
        it.field = &other;
        if (!CHECK_OK(&ctx, pdi_array_registry_build(&ctx, list_of_thing, &it))) continue;
        CHECK_INT(f.bytes, (size_t)(7 * (2 * 8 + 4 + 8 * moving)));
        CHECK_INT(bytes, f.bytes + sizeof *it.line); /* an array of no length holds one element */
        CHECK(it.field != &other && it.work && !it.line && !it.speed == !moving);
        for (int k = 0; k < 2 * it.nodes; k++) CHECK(!(it.field[k] < 0.0) && !(it.field[k] > 0.0));
        CHECK_OK(&ctx, PD_NEW(&ctx, "line", 5, it.line));
        it.room = 5;
        for (int twice = 0; twice < 2; twice++) {
            pdi_array_registry_free(&ctx, list_of_thing, &it);
            CHECK(!it.field && !it.work && !it.speed && !it.line);
            CHECK_INT(ctx.in_use, 0);
            CHECK_INT(f.live + f.wrong, 0);
        }
    }
}

/* Whatever allocation fails: nothing is left, and the message names the array. */
TEST(failure_leaves_nothing)
{
    static const char *const names[] = {"it.field:", "it.work:", "it.speed:"};
    for (int n = 0; n < 3; n++) {
        fault f;
        pd_ctx ctx;
        thing it = make_thing(1);
        double other = 1.0;
        it.speed = &other;
        fault_context(&f, n + 1, 1, &ctx);
        CHECK_INT(pdi_array_registry_build(&ctx, list_of_thing, &it), PD_ERR_MEMORY);
        CHECK(strncmp(ctx.message, names[n], strlen(names[n])) == 0);
        CHECK(!it.field && !it.work && !it.speed);
        CHECK_INT(ctx.in_use, 0);
        CHECK_INT(f.live + f.wrong, 0);
    }
    pd_ctx ctx;
    thing it = make_thing(0);
    pd_ctx_init(&ctx);
    it.nodes = -1;
    CHECK_INT(pdi_array_registry_build(&ctx, list_of_thing, &it), PD_ERR_SIZE);
}

/* Rows that come and go; a failure leaves a capacity of 0, so that the next call tries again. */
TEST(renewed_to_another_length)
{
    fault f;
    pd_ctx ctx;
    thing it = make_thing(0);
    fault_context(&f, 3, 0, &ctx);
    CHECK_OK(&ctx, pdi_array_registry_rebuild(&ctx, list_of_rows, &it, &it.rows, 10));
    CHECK_OK(&ctx, pdi_array_registry_rebuild(&ctx, list_of_rows, &it, &it.rows, 1000));
    CHECK_INT(ctx.in_use, 1000);
    CHECK_INT(it.rows, 1000);
    CHECK_INT(pdi_array_registry_rebuild(&ctx, list_of_rows, &it, &it.rows, 2000), PD_ERR_MEMORY);
    CHECK(it.rows == 0 && !it.mark);
    CHECK_INT(ctx.in_use, 0);
    CHECK_OK(&ctx, pdi_array_registry_rebuild(&ctx, list_of_rows, &it, &it.rows, 2000));
    pdi_array_registry_free(&ctx, list_of_rows, &it);
    CHECK_INT(f.live + f.wrong, 0);
}

/* An archive in memory. */
typedef struct memory {
    char names[200];
    unsigned char bytes[400];
    size_t at;
    int refused; /* items from this number on are refused; 0: none */
    int items;
} memory;

static memory kept;
static int reading;

static pd_status memory_item(pd_ctx *ctx, void *user, const char *name, void *data, size_t size, int64_t count)
{
    memory *m = (memory *)user;
    size_t bytes = size * (size_t)count;
    if (++m->items == m->refused) return pd_fail(ctx, PD_ERR_FILE, "memory", "refused");
    pd_append(m->names, sizeof m->names, "%s ", name);
    if (reading) memcpy(data, m->bytes + m->at, bytes);
    else memcpy(m->bytes + m->at, data, bytes);
    m->at += bytes;
    return PD_OK;
}

static pd_status move_thing(pd_ctx *ctx, thing *it, int in, int refused)
{
    pd_archive archive;
    memset(&archive, 0, sizeof archive);
    archive.transfer = memory_item;
    archive.user = &kept;
    archive.is_reading = reading = in;
    kept.at = 0;
    kept.items = 0;
    kept.names[0] = '\0';
    kept.refused = refused;
    return pdi_array_registry_store(ctx, list_of_thing, it, &archive);
}

/* States and values go out and come back in the order of the list; work stays where it is. */
TEST(kept_and_restored)
{
    pd_ctx ctx;
    thing out = make_thing(1), in = make_thing(1);
    pd_ctx_init(&ctx);
    if (!CHECK_OK(&ctx, pdi_array_registry_build(&ctx, list_of_thing, &out)) ||
        !CHECK_OK(&ctx, pdi_array_registry_build(&ctx, list_of_thing, &in)))
        return;
    for (int k = 0; k < 14; k++) out.field[k] = 1.0 / (k + 3);
    for (int k = 0; k < 7; k++) {
        out.speed[k] = 0.1 * k;
        out.work[k] = (float)(k + 1);
    }
    out.time = 0.1;
    out.steps = 41;
    CHECK_OK(&ctx, move_thing(&ctx, &out, 0, 0));
    CHECK_STR(kept.names, "it.field it.speed it.time it.steps ");
    CHECK_INT(kept.at, 14 * 8 + 7 * 8 + 8 + 8);
    CHECK_OK(&ctx, move_thing(&ctx, &in, 1, 0));
    CHECK(memcmp(in.field, out.field, 14 * sizeof *in.field) == 0);
    CHECK(memcmp(in.speed, out.speed, 7 * sizeof *in.speed) == 0);
    CHECK(memcmp(&in.time, &out.time, sizeof in.time) == 0);
    CHECK_INT(in.steps, 41);
    for (int k = 0; k < 7; k++) CHECK(!(in.work[k] > 0.0f));
    /* nothing is moved behind a failure */
    CHECK_INT(move_thing(&ctx, &out, 0, 2), PD_ERR_FILE);
    CHECK_STR(kept.names, "it.field ");
    pdi_array_registry_free(&ctx, list_of_thing, &out);
    pdi_array_registry_free(&ctx, list_of_thing, &in);
    CHECK_INT(ctx.in_use, 0);
}

/* ---- the lists of the library ---- */

/* Names of all entries so far, each between blanks. */
static char seen[8000];

static void look_at(pdi_array_visitor *owner, const pdi_array_entry *entry)
{
    pd_ctx ctx;
    char name[60];
    pd_ctx_init(&ctx);
    owner->bytes += entry->count * (int64_t)entry->element_size;
    snprintf(name, sizeof name, " %s ", entry->name);
    int kept_one = entry->kind == PDI_ARRAY_KIND_STATE || entry->kind == PDI_ARRAY_KIND_SCALAR;
    if (!CHECK(strlen(entry->name) < PD_ARCHIVE_FILE_NAME_SIZE || !kept_one)) NOTE("'%s' is too long", entry->name);
    if (!CHECK(!kept_one || !strstr(seen, name))) NOTE("'%s' is there twice", entry->name);
    if (!CHECK(!entry->unit[0] || pd_units_parse(&ctx, entry->unit, NULL, NULL) == PD_OK))
        NOTE("%s: %s", entry->name, ctx.message);
    CHECK(entry->count >= 0 && entry->address);
    if (kept_one) pd_append(seen, sizeof seen, "%s", name);
}

/* Entries of a list of an object that is not built. */
static int64_t look(pdi_array_list_fn list, void *object)
{
    pdi_array_visitor owner;
    memset(&owner, 0, sizeof owner);
    owner.visit = look_at;
    list(&owner, object);
    return owner.bytes;
}

static double any(void *user, const double *x)
{
    (void)user;
    return x[0];
}

static void still(void *user, const double *x, double *u)
{
    (void)user;
    for (int d = 0; d < PD_DIM; d++) u[d] = 0.0 * x[d];
}

/* Kept names are unique and fit into a checkpoint, units are units. Lists of zeroed objects are allowed. */
TEST(names_and_units)
{
    static pd_flow flow;
    static pd_steady steady;
    static pd_implicit implicit;
    static pd_weakly_compressible unsteady;
    static pd_transport transport;
    static pd_two_stage two_stage;
    static pd_jacobian jacobian;
    static pd_bonds bonds;
    static pd_grid grid;
    static pd_stencil stencil;
    struct {
        pdi_array_list_fn list;
        void *object;
    } lists[] = {{pdi_flow_list, &flow},
                 {pdi_steady_list, &steady},
                 {pdi_implicit_list, &implicit},
                 {pdi_weakly_compressible_list, &unsteady},
                 {pdi_jacobian_list_work, &jacobian},
                 {pdi_transport_list, &transport},
                 {pdi_two_stage_list, &two_stage},
                 {pdi_diffusion_list, &transport.diffusion},
                 {pdi_limiter_list, &transport.limiter},
                 {pdi_flux_list, &transport.flux},
                 {pdi_conductance_list, &transport.flux.conductance},
                 {pdi_bond_diffusivity_list_node_arrays, &transport.diffusion.media},
                 {pdi_bond_diffusivity_list_row_arrays, &transport.diffusion.media},
                 {pdi_compact_operator_list, &transport.inverse.compact},
                 {pdi_multigrid_list, &transport.inverse.mg},
                 {pdi_krylov_list, &transport.krylov},
                 {pdi_bond_list_row_arrays, &bonds}};
    pd_ctx ctx;
    int count = (int)(sizeof lists / sizeof lists[0]);
    pd_ctx_init(&ctx);
    seen[0] = '\0';
    for (int k = 0; k < count; k++) {
        seen[0] = '\0';
        look(lists[k].list, lists[k].object);
        pdi_array_registry_free(&ctx, lists[k].list, lists[k].object);
    }
    CHECK_INT(ctx.in_use, 0);
    grid.total = 1000;
    grid.side[0] = PD_SIDE_PERIODIC;
    grid.solid_count = 1;
    for (int d = 0; d < PD_DIM; d++) {
        grid.n[d] = 10;
        grid.stride[d] = 10;
    }
    stencil.count = 6;
    bonds.grid = &grid;
    bonds.stencil = &stencil;
    bonds.paths.words = 1;
    bonds.capacity = 50;
    flow.grid = &grid;
    flow.bonds = transport.bonds = transport.flux.bonds = &bonds;
    transport.limiter.bonds = transport.diffusion.bonds = transport.flux.conductance.bonds = &bonds;
    flow.wall = flow.body_force_fn = still;
    flow.clock = transport.desc.clock = &flow.time;
    steady.flow = implicit.flow = unsteady.flow = &flow;
    jacobian.flow = transport.flow = transport.flux.flow = &flow;
    transport.grid = transport.diffusion.media.grid = &grid;
    transport.diffusion.media.stencil = &stencil;
    transport.desc.field = transport.diffusion.desc.held = transport.diffusion.media.surface_distance = any;
    two_stage.transport = &transport;
    seen[0] = '\0';
    int64_t all = 0;
    for (int k = 0; k < count; k++) all += look(lists[k].list, lists[k].object);
    CHECK(all > 1000 * 8 * (15 + 15 * PD_DIM)); /* without what the steady flow and transport borrow for a solve */
    CHECK(strstr(seen, " flow.u ") && strstr(seen, " transport.anti ") && strstr(seen, " two_stage.in "));
}

TEST_MAIN(ENTRY(built_as_counted) ENTRY(failure_leaves_nothing) ENTRY(renewed_to_another_length)
          ENTRY(kept_and_restored) ENTRY(names_and_units))
