/* precrack: bonds that cracks break, against integers, and the damage of points.
 * dims: 1 2 3 */
#include "random.h"
#include "solid/body_bonds.h"
#include "solid/precrack.h"
#include "solid/microelastic.h"
#include "test.h"

#define MOST 4096 /* points */
enum { CORNERS = PD_DIM == 1 ? 1 : PD_DIM == 2 ? 2 : 4 };

/* Points at odd integers times h/2, moved by `shift`. */
typedef struct cut_case {
    pd_ctx ctx;
    pd_body body;
    int n;
    double h, shift;
    double position[MOST * PD_DIM], volume[MOST];
    int64_t at[MOST * PD_DIM]; /* [count][PD_DIM] the integers */
} cut_case;

static cut_case test_case;

static int across(void) { return PD_DIM == 1 ? 40 : PD_DIM == 2 ? 20 : 10; }

static cut_case *block(int n, double m, double h, double shift, double spacing)
{
    cut_case *c = &test_case;
    pd_body_desc desc;
    memset(&desc, 0, sizeof desc);
    memset(c, 0, sizeof *c);
    pd_ctx_init(&c->ctx);
    c->n = n;
    c->h = h;
    c->shift = shift;
    desc.count = 1;
    for (int d = 0; d < PD_DIM; d++) desc.count *= n;
    for (int k = 0; k < desc.count; k++) {
        c->volume[k] = pow(h, PD_DIM);
        for (int d = 0, rest = k; d < PD_DIM; d++, rest /= n) {
            c->at[k * PD_DIM + d] = 2 * (rest % n) + 1;
            c->position[k * PD_DIM + d] = shift + (rest % n + 0.5) * h;
        }
    }
    desc.position = c->position;
    desc.volume = c->volume;
    desc.horizon = m * h;
    desc.spacing = spacing * h;
    return CHECK_OK(&c->ctx, pd_body_build(&c->ctx, &desc, &c->body)) ? c : NULL;
}

static void end(cut_case *c)
{
    pd_body_free(&c->ctx, &c->body);
    CHECK_INT(c->ctx.in_use, 0);
}

static pd_status cut(cut_case *c, int corners, const double *corner, int64_t *broken)
{
    pd_precrack one;
    one.corners = corners;
    one.corner = corner;
    return pd_body_apply_precracks(&c->ctx, &c->body, &one, 1, broken);
}

/* Corners at integers times h/2. */
static void place(const cut_case *c, const int64_t *at, double *corner)
{
    for (int k = 0; k < CORNERS * PD_DIM; k++) corner[k] = c->shift + 0.5 * c->h * (double)at[k];
}

/* ---- the same question in integers ---- */

static int64_t dot(const int64_t *a, const int64_t *b)
{
    int64_t sum = 0;
    for (int d = 0; d < PD_DIM; d++) sum += a[d] * b[d];
    return sum;
}

static void cross(const int64_t *a, const int64_t *b, int64_t *c)
{
    for (int d = 0; d < PD_DIM; d++) {
        int e = (d + 1) % PD_DIM, f = (d + 2) % PD_DIM;
        c[d] = PD_DIM == 3 ? a[e] * b[f] - a[f] * b[e] : 0;
    }
}

static void normal_of(const int64_t *corner, int64_t *n)
{
    int64_t a[PD_DIM], b[PD_DIM];
    for (int d = 0; d < PD_DIM; d++) {
        a[d] = PD_DIM > 1 ? corner[(CORNERS > 1) * PD_DIM + d] - corner[d] : 0;
        b[d] = PD_DIM > 2 ? corner[(CORNERS - 1) * PD_DIM + d] - corner[d] : 0;
        n[d] = 1;
    }
    if (PD_DIM == 2)
        for (int d = 0; d < PD_DIM; d++) n[d] = d ? a[0] : -a[PD_DIM - 1];
    if (PD_DIM == 3) cross(a, b, n);
}

/* Does the bond from p to q cross the cut? Products of small integers are exact. */
static int crosses(const int64_t *corner, const int64_t *p, const int64_t *q)
{
    int64_t n[PD_DIM], from[PD_DIM], to[PD_DIM], last = 0;
    normal_of(corner, n);
    for (int d = 0; d < PD_DIM; d++) {
        if (n[d]) last = n[d];
        from[d] = p[d] - corner[d];
        to[d] = q[d] - corner[d];
    }
    int64_t up = last > 0 ? 1 : -1, own = up * dot(n, from), other = up * dot(n, to);
    if ((own < 0) == (other < 0)) return 0;
    int64_t most = own < 0 ? other - own : own - other; /* times the place, from the first corner */
    for (int k = 0; PD_DIM > 1 && k < CORNERS; k++) {
        const int64_t *first = corner + k * PD_DIM, *next = corner + (k + 1) % CORNERS * PD_DIM;
        int64_t edge[PD_DIM], off[PD_DIM], in[PD_DIM];
        for (int d = 0; d < PD_DIM; d++) {
            int64_t at = own < 0 ? from[d] * other - to[d] * own : to[d] * own - from[d] * other;
            edge[d] = next[d] - first[d];
            off[d] = at - (first[d] - corner[d]) * most;
        }
        cross(n, edge, in);
        if (dot(off, PD_DIM == 3 ? in : edge) < 0) return 0;
    }
    return 1;
}

/* All bonds of the body against the integers; how many pairs cross. */
static int64_t compare(const cut_case *c, const int64_t *corner)
{
    int64_t wrong = 0, pairs = 0;
    for (int32_t i = 0; i < c->body.count; i++)
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); pd_body_bonds_next(&b);) {
            int32_t j = b.neighbour;
            int expected = crosses(corner, c->at + (int64_t)i * PD_DIM, c->at + (int64_t)j * PD_DIM);
            wrong += expected != pd_body_bond_is_broken(&b);
            pairs += expected && j > i;
        }
    CHECK_INT(wrong, 0);
    return pairs;
}

/* A piece of a plane across `axis` at `height`, from lo to hi along the others. */
static void piece(int axis, int height, int lo, int hi, int64_t *corner)
{
    static const int high[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < CORNERS; k++)
        for (int d = 0, other = 0; d < PD_DIM; d++)
            corner[k * PD_DIM + d] = d == axis ? height : high[k][other++ % 2] ? hi : lo;
}

/* Cuts between rows and through rows of points, with ends between and on columns, along every axis and at any scale
 * and place. */
TEST(lattice)
{
    static const double scale[4] = {1e-9, 3.7e-6, 1.0, 1.7e3}, shift[4] = {0.0, -1.3e-4, 1e3, 0.1};
    int64_t at[CORNERS * PD_DIM], counts[4 * PD_DIM], broken;
    double corner[CORNERS * PD_DIM];
    int n = across();
    for (int s = 0; s < 4; s++)
        for (int axis = 0; axis < PD_DIM; axis++)
            for (int k = 0; k < 4; k++) {
                cut_case *c = block(n, 2.0, scale[s], shift[s], s % 2);
                if (!c) return;
                piece(axis, n + k / 2, 3 + k, n + 1 + k, at);
                place(c, at, corner);
                CHECK_OK(&c->ctx, cut(c, CORNERS, corner, &broken));
                CHECK_INT(broken, compare(c, at));
                CHECK(broken > 0);
                int64_t *same = &counts[axis * 4 + k];
                if (s < 2) *same = s == 0 ? broken : *same;
                else if (s == 2) CHECK_INT(broken, *same);
                end(c);
            }
}

/* Oblique cuts through points of the lattice, and through none: the corners are any integers. */
TEST(oblique)
{
    uint32_t seed = 4;
    int64_t at[CORNERS * PD_DIM], broken, all = 0;
    double corner[CORNERS * PD_DIM];
    int n = PD_DIM == 3 ? 8 : across();
    for (int k = 0; k < 60; k++) {
        cut_case *c = block(n, 2.0, k % 2 ? 1e-6 : 0.3, k % 3 ? 0.0 : 7.0, 1.0);
        if (!c) return;
        int64_t step[2][PD_DIM];
        for (int d = 0; d < PD_DIM; d++) {
            at[d] = (int64_t)random_between(&seed, 0.0, n);
            for (int e = 0; e < 2; e++) step[e][d] = (int64_t)random_between(&seed, -n, n);
        }
        for (int p = 1; p < CORNERS; p++) /* a segment, a parallelogram */
            for (int d = 0; d < PD_DIM; d++)
                at[p * PD_DIM + d] = at[d] + (p < 3 ? step[0][d] : 0) + (p > 1 ? step[1][d] : 0);
        int64_t normal[PD_DIM];
        normal_of(at, normal);
        if (dot(normal, normal) > 0) {
            place(c, at, corner);
            CHECK_OK(&c->ctx, cut(c, CORNERS, corner, &broken));
            CHECK_INT(broken, compare(c, at));
            all += broken;
        }
        end(c);
    }
    CHECK(all > 100);
}

/* ---- order ---- */

/* Points anywhere, in two orders, corners in all orders, one and two threads: the same bonds break, at both ends. */
TEST(order)
{
    static double position[2][MOST * PD_DIM], volume[MOST], corner[2][CORNERS * PD_DIM];
    uint32_t seed = 9;
    int count = PD_DIM == 3 ? 800 : 300;
    pd_body_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.count = count;
    desc.volume = volume;
    desc.horizon = PD_DIM == 1 ? 0.02 : PD_DIM == 2 ? 0.12 : 0.2;
    for (int i = 0; i < count; i++) {
        volume[i] = 1.0 + random_share(&seed);
        for (int d = 0; d < PD_DIM; d++)
            position[0][i * PD_DIM + d] = position[1][(count - 1 - i) * PD_DIM + d] = random_share(&seed);
    }
    for (int turn = 0; turn < 2 * CORNERS; turn++) {
        pd_ctx ctx;
        pd_body body[2];
        int64_t broken[2], wrong = 0, uneven = 0;
        int64_t at[CORNERS * PD_DIM];
        pd_ctx_init(&ctx);
        piece(0, 1, 0, 1, at);
        for (int k = 0; k < CORNERS; k++) {
            int of = (turn < CORNERS ? k + turn : 3 * CORNERS - 1 - k - turn) % CORNERS;
            for (int d = 0; d < PD_DIM; d++) {
                corner[0][k * PD_DIM + d] = 0.2 + 0.5 * (double)at[k * PD_DIM + d] - (d ? 0.0 : 0.2);
                corner[1][k * PD_DIM + d] = 0.2 + 0.5 * (double)at[of * PD_DIM + d] - (d ? 0.0 : 0.2);
            }
        }
        for (int k = 0; k < 2; k++) {
            pd_precrack one;
            ctx.threads = 1 + k;
            desc.position = position[k];
            one.corners = CORNERS;
            one.corner = corner[k];
            if (!CHECK_OK(&ctx, pd_body_build(&ctx, &desc, &body[k]))) return;
            CHECK_OK(&ctx, pd_body_apply_precracks(&ctx, &body[k], &one, 1, &broken[k]));
        }
        CHECK_INT(broken[0], broken[1]);
        CHECK(broken[0] > 0);
        for (int32_t i = 0; i < count; i++)
            for (pd_bond_iterator b = pd_body_bonds_begin(&body[0], i),
                                  twin = pd_body_bonds_begin(&body[1], count - 1 - i);
                 pd_body_bonds_next(&b);) {
                pd_bond_iterator back = pd_body_bonds_begin(&body[0], b.neighbour);
                wrong += !pd_body_bonds_next(&twin) || twin.neighbour != count - 1 - b.neighbour;
                wrong += pd_body_bond_is_broken(&twin) != pd_body_bond_is_broken(&b);
                while (pd_body_bonds_next(&back) && back.neighbour != i) continue;
                uneven += pd_body_bond_is_broken(&back) != pd_body_bond_is_broken(&b);
            }
        CHECK_INT(wrong, 0);
        CHECK_INT(uneven, 0);
        for (int k = 0; k < 2; k++) pd_body_free(&ctx, &body[k]);
        CHECK_INT(ctx.in_use, 0);
    }
}

/* ---- pieces ---- */

/* Points that intact bonds join to point `from`. */
static int joined(const pd_body *body, int32_t from, uint8_t *seen)
{
    static int32_t stack[MOST];
    int depth = 1, found = 0;
    memset(seen, 0, (size_t)body->count);
    stack[0] = from;
    seen[from] = 1;
    while (depth) {
        int32_t i = stack[--depth];
        found++;
        for (pd_bond_iterator b = pd_body_bonds_begin(body, i); pd_body_bonds_next(&b);) {
            int32_t j = b.neighbour;
            if (pd_body_bond_is_broken(&b) || seen[j]) continue;
            seen[j] = 1;
            stack[depth++] = j;
        }
    }
    return found;
}

/* Cuts that share their ends leave no gap: a closed line of segments, or the faces of a box, part what is in it from
 * the rest, with corners between points and on points. */
TEST(closed)
{
    static uint8_t seen[MOST];
    int n = PD_DIM == 3 ? 9 : 15;
    for (int on = 0; on < 2; on++) {
        cut_case *c = block(n, 3.0, 1e-3, on ? 0.0 : 2.0, 1.0);
        if (!c) return;
        int64_t low = n / 2 - (n / 2 + on + 1) % 2 - (PD_DIM == 3 ? 0 : 2), high = 2 * n - low - 1;
        for (int axis = 0; axis < PD_DIM; axis++)
            for (int side = 0; side < 2; side++) {
                int64_t at[CORNERS * PD_DIM];
                double corner[CORNERS * PD_DIM];
                piece(axis, (int)(side ? high : low), (int)low, (int)high, at);
                place(c, at, corner);
                CHECK_OK(&c->ctx, cut(c, CORNERS, corner, NULL));
            }
        int middle = 0, inside = 0;
        for (int32_t i = 0; i < c->body.count; i++) {
            int in = 1, mid = 1;
            for (int d = 0; d < PD_DIM; d++) {
                int64_t x = c->at[i * PD_DIM + d];
                in = in && x > low && x < high;
                mid = mid && x == 2 * (n / 2) + 1;
            }
            inside += in;
            if (mid) middle = i;
        }
        int piece_of = joined(&c->body, middle, seen), most = 1;
        CHECK(piece_of >= inside);
        for (int d = 0; d < PD_DIM; d++) most *= (int)(high - low) / 2 + 1;
        CHECK(inside > 1 && piece_of <= most);
        CHECK(!seen[0] && !seen[c->body.count - 1]);
        end(c);
    }
}

#if PD_DIM == 2
/* A closed line of many corners, convex or not, on points and off them, keeps the inside from the outside. */
TEST(rings)
{
    static uint8_t seen[MOST];
    uint32_t seed = 5;
    int n = 24;
    for (int k = 0; k < 40; k++) {
        enum { sides = 7 };
        double corner[2 * sides + 2];
        pd_precrack line[sides];
        cut_case *c = block(n, 3.0, 1e-2, 0.0, 1.0);
        if (!c) return;
        for (int s = 0; s <= sides; s++) {
            double way = 2.0 * 3.14159265358979 * (s % sides) / sides, far = random_between(&seed, 4.0, 10.0);
            for (int d = 0; d < 2; d++) {
                double x = 12.0 + far * (d ? sin(way) : cos(way));
                corner[2 * s + d] = 1e-2 * (k % 2 ? floor(x) + 0.5 : x);
            }
            if (s == sides) memcpy(corner + 2 * s, corner, 2 * sizeof *corner);
        }
        for (int s = 0; s < sides; s++) {
            line[s].corners = 2;
            line[s].corner = corner + 2 * s;
        }
        CHECK_OK(&c->ctx, pd_body_apply_precracks(&c->ctx, &c->body, line, sides, NULL));
        int leaks = 0, middle = 12 * n + 12;
        joined(&c->body, middle, seen);
        for (int32_t i = 0; i < c->body.count; i++) { /* outside of the circle around all corners */
            double x = c->position[2 * i] - 0.12, y = c->position[2 * i + 1] - 0.12;
            leaks += seen[i] && sqrt(x * x + y * y) > 0.108;
        }
        CHECK_INT(leaks, 0);
        end(c);
    }
}
#endif

/* A body that is cut through: its halves move apart without energy, and each one has all its stiffness. */
TEST(halves)
{
    static double u[MOST * PD_DIM], force[MOST * PD_DIM];
    int64_t at[CORNERS * PD_DIM];
    double corner[CORNERS * PD_DIM];
    pd_correspondence_desc desc;
    pd_correspondence elastic;
    int n = across();
    cut_case *c = block(n, 2.0, 1e-3, 0.0, 1.0);
    if (!c) return;
    piece(PD_DIM - 1, n + 1 - n % 2, -n, 4 * n, at); /* through a row */
    place(c, at, corner);
    CHECK_OK(&c->ctx, cut(c, CORNERS, corner, NULL));
    memset(&desc, 0, sizeof desc);
    desc.young = 45e9;
    desc.poisson = PD_DIM == 1 ? 0.0 : 0.3;
    if (!CHECK_OK(&c->ctx, pd_correspondence_build(&c->ctx, &c->body, &desc, &elastic))) return;
    for (int32_t i = 0; i < c->body.count; i++)
        for (int d = 0; d < PD_DIM; d++) {
            int above = c->at[(int64_t)(i + 1) * PD_DIM - 1] >= n + 1 - n % 2;
            u[i * PD_DIM + d] = above ? 1e-6 : 0.0;
        }
    CHECK_LE(pd_correspondence_energy(&c->ctx, &elastic, u), 0.0);
    pd_correspondence_force(&c->ctx, &elastic, u, force);
    double most = 0.0;
    for (int k = 0; k < c->body.count * PD_DIM; k++) most = fmax(most, fabs(force[k]));
    CHECK_LE(most, 0.0);
    pd_correspondence_free(&c->ctx, &elastic);
    end(c);
}

/* ---- energy and damage ---- */

/* The bonds that a cut across axis 0 breaks per area have at the critical stretch the energy of the material. */
TEST(energy)
{
    int n = PD_DIM == 1 ? 40 : PD_DIM == 2 ? 24 : 14;
    int64_t at[CORNERS * PD_DIM];
    double corner[CORNERS * PD_DIM], sum = 0.0, area = 1.0, normal[3] = {1.0, 0.0, 0.0};
    pd_microelastic_desc desc;
    pd_microelastic m;
    cut_case *c = block(n, 2.0, 1e-3, 0.0, 1.0);
    if (!c) return;
    memset(&desc, 0, sizeof desc);
    desc.young = 70e9;
    desc.fracture = 10.0;
    if (!CHECK_OK(&c->ctx, pd_microelastic_build(&c->ctx, &c->body, &desc, &m))) return;
    piece(0, n, -n, 4 * n, at);
    place(c, at, corner);
    CHECK_OK(&c->ctx, cut(c, CORNERS, corner, NULL));
    for (int d = 1; d < PD_DIM; d++) area *= c->h;
    for (int32_t i = 0; i < c->body.count; i++) {
        int column = c->at[i * PD_DIM] < n; /* lower ends in the middle column */
        for (int d = 1; d < PD_DIM; d++) column = column && c->at[i * PD_DIM + d] == 2 * (n / 2) + 1;
        for (pd_bond_iterator b = pd_body_bonds_begin(&c->body, i); column && pd_body_bonds_next(&b);) {
            double xi[PD_DIM], square = 0.0;
            if (!pd_body_bond_is_broken(&b)) continue;
            pdi_body_compute_offset(&c->body, i, b.neighbour, xi);
            for (int d = 0; d < PD_DIM; d++) square += xi[d] * xi[d];
            double weight = (double)pdi_bond_weights_get(&m.weights, i, &b);
            sum += 0.5 * m.modulus * weight * m.critical * m.critical * sqrt(square) * c->volume[0] *
                   c->volume[0];
        }
    }
    CHECK_REL(sum / area, pdi_microelastic_crack_energy(&m, normal), 1e-6); /* weights are of single precision */
    pd_microelastic_free(&c->ctx, &m);
    end(c);
}

/* Damage is the volume of what is lost: by counting beside a plane, 0 far from it, 1 where all is lost. */
TEST(damage)
{
    static double damage[MOST];
    int n = across();
    int64_t at[CORNERS * PD_DIM], wrong = 0;
    double corner[CORNERS * PD_DIM];
    cut_case *c = block(n, 2.0, 1.0, 0.0, 0.0);
    if (!c) return;
    piece(0, n, -n, 4 * n, at);
    place(c, at, corner);
    CHECK_OK(&c->ctx, cut(c, CORNERS, corner, NULL));
    pd_body_damage(&c->ctx, &c->body, damage);
    int32_t middle = n / 2 - 1;
    for (int d = 1, stride = n; d < PD_DIM; d++, stride *= n) middle += n / 2 * stride;
    /* families of m = 2: 4, 12, 32 points; beyond a plane half a cell away 2, 4, 10: (1,0) (1,1) (1,-1) (2,0), .. */
    static const double lost[3] = {2.0 / 4.0, 4.0 / 12.0, 10.0 / 32.0}, next[3] = {1.0 / 4.0, 1.0 / 12.0, 1.0 / 32.0};
    CHECK_REL(damage[middle], lost[PD_DIM - 1], 1e-15);
    CHECK_REL(damage[middle - 1], next[PD_DIM - 1], 1e-15);
    CHECK_LE(fabs(damage[middle - 2]), 0.0);
    for (int32_t i = 0; i < c->body.count; i++) wrong += !(damage[i] >= 0.0 && damage[i] <= 1.0);
    CHECK_INT(wrong, 0);
    for (int32_t i = 0; i < c->body.count; i++) pdi_body_bonds_break_all(&c->body, i);
    pd_body_damage(&c->ctx, &c->body, damage);
    CHECK_NEAR(damage[0], 1.0, 0.0);
    end(c);
}

/* ---- refusals ---- */

static void refused(cut_case *c, int corners, const double *corner, const char *text)
{
    pd_precrack two[2];
    double good[CORNERS * PD_DIM];
    int64_t at[CORNERS * PD_DIM], broken = 7;
    piece(0, c->n, -c->n, 4 * c->n, at);
    place(c, at, good);
    two[0].corners = CORNERS;
    two[0].corner = good;
    two[1].corners = corners;
    two[1].corner = corner;
    CHECK_INT(pd_body_apply_precracks(&c->ctx, &c->body, two, 2, &broken), PD_ERR_ARGUMENT);
    CHECK(strstr(c->ctx.message, "cut 1") && strstr(c->ctx.message, text));
    CHECK_INT(broken, 0);
    CHECK(pd_body_is_intact(&c->body));
}

TEST(refusals)
{
    double good[15] = {0.0}, bad[15];
    cut_case *c = block(across(), 2.0, 1.0, 0.0, 1.0);
    if (!c) return;
    int64_t at[CORNERS * PD_DIM];
    piece(0, c->n, 0, 2 * c->n, at);
    place(c, at, good);
    refused(c, CORNERS, NULL, "expected");
    refused(c, 0, good, "expected");
    refused(c, PD_DIM < 3 ? CORNERS + 1 : 2, good, "expected");
    refused(c, -1, good, "expected");
    for (int k = 0; k < 3; k++) {
        static const double values[3] = {NAN, HUGE_VAL, -1e200};
        memcpy(bad, good, sizeof bad);
        bad[CORNERS * PD_DIM - 1] = values[k];
        refused(c, CORNERS, bad, "finite");
    }
    if (PD_DIM == 2) {
        memset(bad, 0, sizeof bad);
        refused(c, 2, bad, "without length");
        bad[0] = 1e-12;
        refused(c, 2, bad, "without length");
    }
    if (PD_DIM == 3) {
        memset(bad, 0, sizeof bad);
        refused(c, 4, bad, "without area");
        for (int k = 0; k < 12; k++) bad[k] = (double)(k / 3); /* on a line */
        refused(c, 4, bad, "without area");
        memcpy(bad, good, sizeof bad);
        bad[0] += 1e-3;
        refused(c, 4, bad, "in a plane");
        memcpy(bad, good, sizeof bad);
        memcpy(bad + 3, bad, 3 * sizeof *bad);
        refused(c, 4, bad, "convex");
        memcpy(bad, good, sizeof bad); /* a corner drawn in beyond the diagonal */
        for (int d = 0, k = 6 % (CORNERS * PD_DIM); d < 3; d++) bad[k + d] = good[d] + 0.1 * (good[k + d] - good[d]);
        refused(c, 4, bad, "convex");
        for (int k = 0; k < 5; k++) { /* a star goes around twice */
            bad[3 * k] = 3.0;
            bad[3 * k + 1] = 5.0 + 2.0 * cos(0.8 * 3.14159265358979 * k);
            bad[3 * k + 2] = 5.0 + 2.0 * sin(0.8 * 3.14159265358979 * k);
        }
        refused(c, 5, bad, "convex");
    }
    CHECK_INT(pd_body_apply_precracks(&c->ctx, &c->body, NULL, 1, NULL), PD_ERR_ARGUMENT);
    CHECK_INT(pd_body_apply_precracks(&c->ctx, &c->body, NULL, -1, NULL), PD_ERR_ARGUMENT);
    CHECK_OK(&c->ctx, pd_body_apply_precracks(&c->ctx, &c->body, NULL, 0, NULL));
    end(c);
}

#if PD_DIM == 2
#define RINGS ENTRY(rings)
#else
#define RINGS
#endif
TEST_MAIN(ENTRY(lattice) ENTRY(oblique) ENTRY(order) ENTRY(closed) RINGS ENTRY(halves) ENTRY(energy) ENTRY(damage)
              ENTRY(refusals))
