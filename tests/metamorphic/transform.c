/* transform: see transform.h */
#include "transform.h"
#include "random.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const transform_names[TRANSFORM_COUNT] = {"mirror", "rotate",  "shift", "lengths7", "lengths1e-3",
                                                      "times3", "units",   "order", "half",     "threads",
                                                      "resume", "tighter", "layer", "ring"};

int transform_bits(transform_kind kind) { return kind == TRANSFORM_THREADS || kind == TRANSFORM_RESUME; }

/* What is drawn over places of the lattice is not turned with it: grains, and bonds that break at random. */
static int places_count(const scene *x) { return (x->has & (HAS_GRAINS | HAS_RANDOM)) != 0; }

static int draw_rotation(const scene *x, uint32_t *state, transform *t)
{
    if (PD_DIM == 1 || (x->has & HAS_AXIS)) return 0;
    int k = (int)(random_share(state) * (PD_DIM == 2 ? 2 : 5));
    static const int two[2][3] = {{1, 0, 2}, {1, 0, 2}};
    static const int three[5][3] = {{1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
    for (int d = 0; d < PD_DIM; d++) {
        t->to[d] = PD_DIM == 2 ? two[k][d] : three[k][d];
        t->sign[d] = random_share(state) < 0.5 ? -1 : 1;
    }
    return 1;
}

/* A side that is a plane of symmetry, low or high end. */
static int mirror_side(const scene *x, int axis, int plus)
{
    for (int k = 0; k < x->entries; k++) {
        const entry *e = &x->list[k];
        const section *s = &x->part[e->section];
        if (s->gone || s->axis != axis || s->plus != plus || strcmp(e->key, "flow") != 0) continue;
        return strcmp(x->pool[e->first[0]].text, "mirror") == 0;
    }
    return 0;
}

int transform_draw(transform_kind kind, const scene *x, uint32_t *state, transform *t)
{
    memset(t, 0, sizeof *t);
    t->kind = kind;
    t->length = t->time = 1.0;
    t->unfold = -1;
    t->seed = next_random(state) | 1u;
    for (int d = 0; d < 3; d++) {
        t->to[d] = d;
        t->sign[d] = 1;
    }
    int axes = x->has & HAS_AXIS ? 1 : PD_DIM; /* that may be mirrored and shifted */
    switch (kind) {
    case TRANSFORM_MIRROR:
        if (places_count(x)) return 0;
        t->sign[(int)(random_share(state) * axes)] = -1;
        return 1;
    case TRANSFORM_ROTATE: return !places_count(x) && draw_rotation(x, state, t);
    case TRANSFORM_SHIFT:
        for (int d = 0; d < axes; d++) t->offset[d] = floor(random_between(state, -40.0, 40.0)) * x->h[d];
        return !places_count(x);
    case TRANSFORM_LENGTHS_7: t->length = 7.0; return !places_count(x);
    case TRANSFORM_LENGTHS_MILLI: t->length = 1e-3; return !places_count(x);
    case TRANSFORM_TIMES_3: t->time = 3.0; return 1;
    case TRANSFORM_HALF:
        for (int k = 0; k < x->entries; k++) /* its image is not on the other side of the plane alone */
            if (strcmp(x->list[k].key, "half_space") == 0) return 0;
        for (int d = 0; d < axes; d++)
            if (mirror_side(x, d, 0)) {
                t->unfold = d;
                return !places_count(x);
            }
        return 0;
    case TRANSFORM_RESUME: return x->until > 0.0;
    case TRANSFORM_LAYER: return PD_DIM == 2;
    case TRANSFORM_RING: return PD_DIM == 2;
    case TRANSFORM_TIGHTER: return x->until > 0.0 && !(x->has & HAS_GAS);
    default: return 1;
    }
}

int transform_holds(const transform *t, const scene *x) { return t->unfold < 0 || mirror_side(x, t->unfold, 0); }

double transform_factor(const transform *t, const dimension *d)
{
    /* Amounts and charge go with the volume, energies, too: so concentrations, voltages, pressures, the gas constant
     * and Faraday's constant stay. Exponents of m, kg, s, mol, A. */
    double length = d->e[0] + d->e[1] + 3.0 * d->e[3] + 3.0 * d->e[4], time = 2.0 * d->e[1] + d->e[2] - d->e[4];
    return pow(t->length, length) * pow(t->time, time);
}

static double place(const transform *t, int axis, double at)
{
    return t->length * (t->sign[axis] * at + t->offset[axis]);
}

static void rotate_tokens(const transform *t, scene *y)
{
    for (int k = 0; k < y->tokens; k++) {
        token *p = &y->pool[k];
        if (p->kind == TOKEN_NUMBER) {
            dimension d = unit_dimension(p->of);
            double f = transform_factor(t, &d);
            if (f != 1.0) p->value *= f;
        }
        if (p->kind != TOKEN_PLACE) continue;
        int axis = p->axis;
        p->origin = place(t, axis, p->origin);
        p->plane = place(t, axis, p->plane);
        p->length *= t->length;
        p->sign *= t->sign[axis];
        p->axis = t->to[axis];
    }
}

static void rotate_entry(const transform *t, entry *e)
{
    entry old = *e;
    if (e->kind == ENTRY_COMPONENT || e->kind == ENTRY_PLANE || e->kind == ENTRY_AXIS) e->axis = t->to[old.axis];
    if (e->kind == ENTRY_COMPONENT) e->sign *= t->sign[old.axis];
    if (e->kind == ENTRY_PLANE) e->low[0] = place(t, old.axis, old.low[0]);
    for (int d = 0; d < PD_DIM; d++) {
        int b = t->to[d];
        if (e->kind == ENTRY_VECTOR) {
            e->first[b] = old.first[d];
            e->count[b] = old.count[d];
            e->rotated[b] = old.rotated[d] * t->sign[d];
        }
        if (e->kind == ENTRY_SIZES) e->low[b] = t->length * old.low[d];
        if (e->kind == ENTRY_POINT) e->low[b] = place(t, d, old.low[d]);
        if (e->kind == ENTRY_DIRECTION) e->low[b] = t->sign[d] * old.low[d];
        for (int k = 0; k < e->corners; k++) e->corner[k][b] = place(t, d, old.corner[k][d]);
        if (e->kind == ENTRY_BOX || e->kind == ENTRY_VOXELS) {
            double p = place(t, d, old.low[d]), q = place(t, d, old.high[d]);
            e->low[b] = p < q ? p : q;
            e->high[b] = p < q ? q : p;
        }
    }
}

static void rotate_voxels(const transform *t, voxels *v)
{
    voxels old = *v;
    int at[3], to[3] = {0, 0, 0};
    for (int d = 0; d < PD_DIM; d++) v->n[t->to[d]] = old.n[d];
    for (int d = PD_DIM; d < 3; d++) v->n[d] = old.n[d] = 1;
    for (at[2] = 0; at[2] < old.n[2]; at[2]++)
        for (at[1] = 0; at[1] < old.n[1]; at[1]++)
            for (at[0] = 0; at[0] < old.n[0]; at[0]++) {
                for (int d = 0; d < PD_DIM; d++) to[t->to[d]] = t->sign[d] > 0 ? at[d] : old.n[d] - 1 - at[d];
                v->inside[(to[2] * v->n[1] + to[1]) * v->n[0] + to[0]] =
                    old.inside[(at[2] * old.n[1] + at[1]) * old.n[0] + at[0]];
            }
}

/* ---- the order of sections ---- */

/* Solids of different materials count in their order where they overlap, later electrodes, too; so does what an
 * operation is made of. Sections that may stand anywhere are swapped. */
static void reorder(scene *y, uint32_t state)
{
    static const char *const loose[] = {"species", "reaction", "mineral",   "electrode", "side",  "total",
                                        "plane",   "probe",    "transfer",  "force",     "shape", "transport",
                                        "run",     "output",   "potential", "dissolve",  "flow",  "solid"};
    int mine[SCENE_SECTIONS], count = 0, rank[SCENE_SECTIONS];
    for (int s = 0; s < y->sections; s++) {
        const section *p = &y->part[s];
        int free = 0;
        for (size_t k = 0; k < sizeof loose / sizeof loose[0]; k++) free |= strcmp(p->name, loose[k]) == 0;
        for (int k = 0; k < y->entries; k++) {
            const entry *e = &y->list[k];
            if (e->section == s &&
                (strcmp(e->key, "union") == 0 || strcmp(e->key, "difference") == 0 || strcmp(e->key, "intersect") == 0))
                free = 0;
        }
        /* operands stay in front of what they make */
        const char *label = p->label;
        if (strcmp(p->name, "shape") == 0 && strlen(label) > 2 && label[strlen(label) - 2] == '_') free = 0;
        if (free) mine[count++] = s;
    }
    for (int k = 0; k < SCENE_SECTIONS; k++) rank[k] = k;
    for (int k = count - 1; k > 0; k--) {
        int other = (int)(random_share(&state) * (k + 1)), keep = rank[mine[k]];
        rank[mine[k]] = rank[mine[other]];
        rank[mine[other]] = keep;
    }
    scene old = *y;
    for (int s = 0; s < y->sections; s++) y->part[rank[s]] = old.part[s];
    for (int k = 0; k < y->entries; k++) y->list[k].section = rank[y->list[k].section];
}

/* ---- the whole behind the mirror ---- */

/* Copy the entries of a section to another one, mirrored about the plane. */
static void mirror_copy(scene *y, int from, int to, int axis, double plane, int shapes)
{
    int entries = y->entries;
    for (int k = 0; k < entries; k++) {
        if (y->list[k].section != from) continue;
        if (y->entries == SCENE_ENTRIES) {
            y->full = 1;
            return;
        }
        entry *e = &y->list[y->entries++];
        *e = y->list[k];
        e->section = to;
        if (e->kind == ENTRY_COMPONENT && e->axis == axis) e->sign = -e->sign;
        if (e->kind == ENTRY_VECTOR) e->rotated[axis] = -e->rotated[axis];
        if (!shapes) continue;
        if (e->kind == ENTRY_BOX || e->kind == ENTRY_POINT) {
            double low = e->low[axis], high = e->high[axis];
            e->low[axis] = 2.0 * plane - (e->kind == ENTRY_BOX ? high : low);
            e->high[axis] = 2.0 * plane - low;
        }
        if (e->kind == ENTRY_DIRECTION) e->low[axis] = -e->low[axis];
    }
}

/* 1: a key that says where a shape is, without the operations. */
static int of_geometry(const char *key)
{
    static const char *const keys[] = {"box", "ball", "radius", "cylinder", "centre", "half_space", "point", "normal"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (strcmp(key, keys[k]) == 0) return 1;
    return 0;
}

static int copies(const scene *y, int s)
{
    for (int k = 0; k < y->entries; k++)
        if (y->list[k].section == s && of_geometry(y->list[k].key)) return 1;
    return 0;
}

static void unfold_shape(scene *y, int s, int axis, double plane)
{
    char label[SCENE_NAME], a[SCENE_NAME], b[SCENE_NAME];
    entry *e = scene_find(y, s, "box"), *ball = scene_find(y, s, "ball");
    double slack = 1e-9 * y->h[axis];
    if (e && e->low[axis] <= plane + slack) {
        e->low[axis] = 2.0 * plane - e->high[axis];
        return;
    }
    if (ball && fabs(ball->low[axis] - plane) < slack) return;
    /* The image is a shape of its own, and both are one: the name stays that of the whole. */
    int whole = y->sections, image = whole + 1;
    if (whole + 2 > SCENE_SECTIONS) {
        y->full = 1;
        return;
    }
    snprintf(label, sizeof label, "%.16s", y->part[s].label);
    snprintf(a, sizeof a, "%.16s_p", label);
    snprintf(b, sizeof b, "%.16s_q", label);
    /* sections behind s move up by two, so that the order stays */
    for (int k = y->sections - 1; k > s; k--) y->part[k + 2] = y->part[k];
    for (int k = 0; k < y->entries; k++)
        if (y->list[k].section > s) y->list[k].section += 2;
    y->sections += 2;
    image = s + 1;
    whole = s + 2;
    y->part[image] = y->part[whole] = y->part[s];
    snprintf(y->part[s].label, sizeof y->part[s].label, "%s", a);
    snprintf(y->part[image].label, sizeof y->part[image].label, "%s", b);
    mirror_copy(y, s, image, axis, plane, 1);
    scene_key(y, whole, "union", "%s, %s", a, b);
    for (int k = 0; k < y->entries; k++) {
        entry *q = &y->list[k];
        int geometry = of_geometry(q->key);
        if (q->section == s && !geometry) q->section = whole; /* kind, material */
        else if (q->section == image && !geometry) q->key[0] = '\0';
    }
}

/* The voxels and their image below them. */
static void unfold_voxels(voxels *v, int axis)
{
    voxels old = *v;
    int at[3];
    for (int d = PD_DIM; d < 3; d++) v->n[d] = old.n[d] = 1;
    v->n[axis] *= 2;
    for (at[2] = 0; at[2] < v->n[2]; at[2]++)
        for (at[1] = 0; at[1] < v->n[1]; at[1]++)
            for (at[0] = 0; at[0] < v->n[0]; at[0]++) {
                int from[3] = {at[0], at[1], at[2]}, n = old.n[axis];
                from[axis] = at[axis] < n ? n - 1 - at[axis] : at[axis] - n;
                v->inside[(at[2] * v->n[1] + at[1]) * v->n[0] + at[0]] =
                    old.inside[(from[2] * old.n[1] + from[1]) * old.n[0] + from[0]];
            }
}

static void unfold(scene *y, int axis)
{
    double plane = y->low[axis];
    if (y->mask.n[0]) unfold_voxels(&y->mask, axis);
    for (int s = 0; s < y->sections; s++)
        if (strcmp(y->part[s].name, "shape") == 0 && copies(y, s)) {
            int before = y->sections;
            unfold_shape(y, s, axis, plane);
            s += y->sections - before;
        }
    for (int s = 0; s < y->sections; s++) {
        if (y->part[s].axis != axis || y->part[s].plus) continue;
        for (int k = 0; k < y->entries; k++)
            if (y->list[k].section == s) y->list[k].key[0] = '\0';
        y->part[s].gone = 1;
    }
    for (int s = 0, sections = y->sections; s < sections; s++) {
        if (y->part[s].axis != axis || !y->part[s].plus || y->part[s].gone) continue;
        int low = scene_section(y, "side", "");
        y->part[low].axis = axis;
        mirror_copy(y, s, low, axis, plane, 0);
    }
    for (int k = 0; k < y->entries; k++) {
        entry *e = &y->list[k];
        if (!e->key[0]) continue;
        const char *of = y->part[e->section].name;
        if (strcmp(e->key, "flow_rate") == 0 && y->part[e->section].axis != axis) /* of an opening twice as wide */
            y->pool[e->first[0]].value *= 2.0;
        if (y->part[e->section].axis < 0 &&
            (e->kind == ENTRY_VECTOR || (e->kind == ENTRY_COMPONENT && e->axis == axis))) {
            e->odd = axis + 1;
            e->plane = plane;
        }
        if (e->kind == ENTRY_VOXELS ||
            (e->kind == ENTRY_BOX && strcmp(of, "shape") != 0 && e->low[axis] <= plane + 1e-9 * y->h[axis]))
            e->low[axis] = 2.0 * plane - e->high[axis];
    }
    for (int k = 0; k < y->tokens; k++)
        if (y->pool[k].kind == TOKEN_PLACE && y->pool[k].axis == axis) {
            y->pool[k].fold = 1;
            y->pool[k].plane = plane;
            y->pool[k].origin -= plane;
        }
    y->cells[axis] *= 2;
    y->low[axis] -= y->cells[axis] / 2 * y->h[axis];
}

static void tighten_steps(scene *y)
{
    for (int k = 0; k < y->entries; k++)
        if (strcmp(y->list[k].key, "rtol") == 0 && strcmp(y->part[y->list[k].section].name, "run") == 0)
            y->pool[y->list[k].first[0]].value *= 0.1;
    y->rtol *= 0.1;
}

void transform_scene(const scene *x, const transform *t, scene *y)
{
    *y = *x;
    if (t->unfold >= 0) unfold(y, t->unfold);
    rotate_tokens(t, y);
    if (y->mask.n[0]) rotate_voxels(t, &y->mask);
    for (int k = 0; k < y->entries; k++) rotate_entry(t, &y->list[k]);
    for (int s = 0; s < y->sections; s++) {
        int axis = y->part[s].axis;
        if (axis < 0) continue;
        y->part[s].axis = t->to[axis];
        if (t->sign[axis] < 0) y->part[s].plus = !y->part[s].plus;
    }
    scene old = *y;
    for (int d = 0; d < PD_DIM; d++) {
        int b = t->to[d];
        y->cells[b] = old.cells[d];
        y->h[b] = t->length * old.h[d];
        double p = place(t, d, old.low[d]), q = place(t, d, old.low[d] + old.cells[d] * old.h[d]);
        y->low[b] = p < q ? p : q;
    }
    y->until *= t->time;
    y->time *= t->time;
    if (t->kind == TRANSFORM_UNITS) y->other_units = (int)(t->seed & 0xffffff) | 1;
    if (t->kind == TRANSFORM_ORDER) reorder(y, t->seed);
    if (t->kind == TRANSFORM_TIGHTER) tighten_steps(y);
    if (t->kind == TRANSFORM_LAYER) y->layer = 1;
    if (t->kind == TRANSFORM_RING) y->ring = 1;
}

void transform_refine(const scene *x, int by, scene *y)
{
    *y = *x;
    for (int d = 0; d < PD_DIM; d++) {
        y->cells[d] *= by;
        y->h[d] /= by;
    }
    for (int k = 0; k < y->entries; k++) {
        entry *e = &y->list[k];
        if (e->section != y->grid || strcmp(e->key, "h") != 0) continue;
        if (e->kind == ENTRY_PLAIN) y->pool[e->first[0]].value /= by;
        for (int d = 0; d < PD_DIM && e->kind == ENTRY_SIZES; d++) e->low[d] /= by;
    }
}
