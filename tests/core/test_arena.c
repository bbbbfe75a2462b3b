/* arena: what is lent and returned, and who may not work at the same time.
 * dims: 2 3 */
#include "fault.h"
#include "fixture.h"

typedef struct thing {
    int32_t nodes;
    double *field; /* [nodes] */
    float *basis;  /* [3][nodes], raw */
    uint8_t *mark; /* [nodes] */
} thing;

static void list_of_thing(pdi_array_visitor *owner, void *object)
{
    thing *it = (thing *)object;
    PDI_ARRAY(owner, it, field, it->nodes, "1");
    PDI_ARRAY_UNINIT(owner, it, basis, 3 * (int64_t)it->nodes, "1");
    PDI_ARRAY(owner, it, mark, it->nodes, "1");
}

static thing make_thing(int32_t nodes)
{
    thing it;
    memset(&it, 0, sizeof it);
    it.nodes = nodes;
    return it;
}

static void fill(thing *it)
{
    for (int32_t i = 0; i < it->nodes; i++) {
        it->field[i] = i + 1.0;
        for (int k = 0; k < 3; k++) it->basis[3 * i + k] = (float)(i + k);
        it->mark[i] = 7;
    }
}

static int all_zero(const thing *it)
{
    int good = 1;
    for (int32_t i = 0; i < it->nodes; i++) good = good && !(fabs(it->field[i]) > 0.0) && !it->mark[i];
    return good;
}

/* Two things use the same memory one after the other. Each finds zeros, on lines of the cache, and the arena is as
 * large as the larger one asks for. */
TEST(lent_in_turns)
{
    pd_ctx ctx;
    pd_arena arena;
    thing small = make_thing(5), large = make_thing(1000);
    pd_ctx_init(&ctx);
    memset(&arena, 0, sizeof arena);
    size_t room = pdi_arena_count_bytes(list_of_thing, &large);
    CHECK(room >= 1000 * (8 + 12 + 1) && room < 1000 * (8 + 12 + 1) + 3 * 64);
    CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, pdi_arena_count_bytes(list_of_thing, &small)));
    CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, room));
    CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, 1));
    CHECK_INT(arena.size, room);
    size_t built = ctx.in_use;
    for (int turn = 0; turn < 4; turn++) {
        thing *it = turn & 1 ? &small : &large;
        if (!CHECK_OK(&ctx, pdi_arena_acquire(&ctx, &arena, list_of_thing, it))) return;
        CHECK((uintptr_t)it->field % 64 == 0 && (uintptr_t)it->basis % 64 == 0 && (uintptr_t)it->mark % 64 == 0);
        CHECK(all_zero(it));
        fill(it);
        CHECK_OK(&ctx, pdi_arena_release(&ctx, &arena, list_of_thing, it, PD_OK));
        CHECK(!it->field && !it->basis && !it->mark);
        CHECK_INT(arena.used, 0);
    }
    CHECK_INT(ctx.in_use, built); /* nothing is taken for it */
    for (int twice = 0; twice < 2; twice++) pd_arena_free(&ctx, &arena);
    CHECK_INT(ctx.in_use, 0);
}

/* One within the other: both keep what they hold. */
TEST(lent_within)
{
    pd_ctx ctx;
    pd_arena arena;
    thing outer = make_thing(40), inner = make_thing(9);
    pd_ctx_init(&ctx);
    memset(&arena, 0, sizeof arena);
    size_t room = pdi_arena_count_bytes(list_of_thing, &outer) + pdi_arena_count_bytes(list_of_thing, &inner);
    CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, room));
    CHECK_OK(&ctx, pdi_arena_acquire(&ctx, &arena, list_of_thing, &outer));
    fill(&outer);
    for (int turn = 0; turn < 2; turn++) {
        if (!CHECK_OK(&ctx, pdi_arena_acquire(&ctx, &arena, list_of_thing, &inner))) return;
        CHECK(all_zero(&inner));
        fill(&inner);
        CHECK_INT(pdi_arena_release(&ctx, &arena, list_of_thing, &inner, PD_NOT_CONVERGED), PD_NOT_CONVERGED);
    }
    for (int32_t i = 0; i < outer.nodes; i++)
        CHECK(!(fabs(outer.field[i] - (i + 1.0)) > 0.0) && outer.mark[i] == 7 && !(outer.basis[3 * i] > (float)i));
    CHECK_OK(&ctx, pdi_arena_release(&ctx, &arena, list_of_thing, &outer, PD_OK));
    pd_arena_free(&ctx, &arena);
}

/* No room, the wrong order, more room while something is lent: PD_ERR_INTERNAL. An error on the way back stays. */
TEST(misuse_is_refused)
{
    pd_ctx ctx;
    pd_arena arena;
    thing a = make_thing(20), b = make_thing(20);
    pd_ctx_init(&ctx);
    memset(&arena, 0, sizeof arena);
    CHECK_INT(pdi_arena_acquire(&ctx, &arena, list_of_thing, &a), PD_ERR_INTERNAL);
    CHECK(!a.field && strstr(ctx.message, "two solvers work at the same time"));
    CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, 2 * pdi_arena_count_bytes(list_of_thing, &a)));
    CHECK_OK(&ctx, pdi_arena_acquire(&ctx, &arena, list_of_thing, &a));
    CHECK_OK(&ctx, pdi_arena_acquire(&ctx, &arena, list_of_thing, &b));
    thing c = make_thing(1);
    CHECK_INT(pdi_arena_acquire(&ctx, &arena, list_of_thing, &c), PD_ERR_INTERNAL);
    CHECK_INT(pdi_arena_reserve(&ctx, &arena, 1), PD_ERR_INTERNAL);
    CHECK_INT(pdi_arena_release(&ctx, &arena, list_of_thing, &a, PD_OK), PD_ERR_INTERNAL);
    CHECK(strstr(ctx.message, "not what was lent last") != NULL);
    CHECK_INT(pdi_arena_release(&ctx, &arena, list_of_thing, &b, PD_ERR_STATE), PD_ERR_STATE);
    pd_arena_free(&ctx, &arena);
    CHECK_INT(ctx.in_use, 0);
}

/* Where there is no memory for more room, what there was stays. */
TEST(no_memory_for_more)
{
    fault f;
    pd_ctx ctx;
    pd_arena arena;
    thing it = make_thing(10);
    memset(&arena, 0, sizeof arena);
    fault_context(&f, 2, 0, &ctx);
    CHECK_OK(&ctx, pdi_arena_reserve(&ctx, &arena, pdi_arena_count_bytes(list_of_thing, &it)));
    CHECK_INT(pdi_arena_reserve(&ctx, &arena, 1000000), PD_ERR_MEMORY);
    CHECK_OK(&ctx, pdi_arena_acquire(&ctx, &arena, list_of_thing, &it));
    fill(&it);
    CHECK_OK(&ctx, pdi_arena_release(&ctx, &arena, list_of_thing, &it, PD_OK));
    pd_arena_free(&ctx, &arena);
    CHECK(f.live == 0 && f.wrong == 0 && ctx.in_use == 0);
}

/* A flow and a transport with one arena give the same bits as with one each, and take less. Neither can solve while the
 * other one holds it. */
TEST(flow_and_transport_share)
{
    double *kept[2];
    size_t bytes[2];
    int64_t n = 0;
    for (int shared = 0; shared < 2; shared++) {
        static scene s;
        static pd_arena arena;
        pd_steady_result flown;
        pd_transport_result result;
        scene_box(&s, 2.0, 0.1, 24, 12, 8);
        s.grid_desc.side[0] = s.grid_desc.side[1] = PD_SIDE_PERIODIC;
        s.with = WITH_FLOW | WITH_STEADY | WITH_TRANSPORT;
        s.flow_desc.rho = 1.0;
        s.flow_desc.mu = 0.1;
        s.flow_desc.force[0] = 1.0;
        s.transport_desc.diffusivity = 1e-3;
        memset(&arena, 0, sizeof arena);
        if (shared) s.steady_desc.arena = s.transport_desc.arena = &arena;
        if (!scene_build(&s)) return;
        bytes[shared] = s.ctx.in_use;
        for (int32_t i = 0; i < s.grid.total; i++)
            if (s.grid.kind[i] == PD_FLUID) s.transport.c[i] = i % 7;
        CHECK_OK(&s.ctx, pd_steady_solve(&s.ctx, &s.steady, &flown));
        CHECK_OK(&s.ctx, pd_transport_implicit(&s.ctx, &s.transport, 1.0, &result));
        CHECK_OK(&s.ctx, pd_steady_solve(&s.ctx, &s.steady, &flown));
        CHECK_OK(&s.ctx, pd_transport_implicit(&s.ctx, &s.transport, 1.0, &result));
        n = s.grid.total;
        kept[shared] = (double *)malloc((size_t)(PD_DIM + 1) * (size_t)n * sizeof **kept);
        if (!CHECK(kept[shared] != NULL)) return;
        memcpy(kept[shared], s.flow.u, PD_DIM * (size_t)n * sizeof **kept);
        memcpy(kept[shared] + PD_DIM * n, s.transport.c, (size_t)n * sizeof **kept);
        if (shared) {
            CHECK_OK(&s.ctx, pdi_steady_begin_solves(&s.ctx, &s.steady));
            CHECK_INT(pd_transport_implicit(&s.ctx, &s.transport, 1.0, &result), PD_ERR_INTERNAL);
            CHECK_OK(&s.ctx, pdi_steady_end_solves(&s.ctx, &s.steady, PD_OK));
            CHECK_OK(&s.ctx, pd_transport_implicit(&s.ctx, &s.transport, 1.0, &result));
        }
        pd_arena_free(&s.ctx, &arena);
        scene_free(&s);
    }
    CHECK(memcmp(kept[0], kept[1], (size_t)(PD_DIM + 1) * (size_t)n * sizeof **kept) == 0);
    free(kept[0]);
    free(kept[1]);
    CHECK(bytes[1] < bytes[0]);
}

TEST_MAIN(ENTRY(lent_in_turns) ENTRY(lent_within) ENTRY(misuse_is_refused) ENTRY(no_memory_for_more)
          ENTRY(flow_and_transport_share))
