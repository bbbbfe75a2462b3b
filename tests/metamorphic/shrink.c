/* shrink: see shrink.h */
#include "shrink.h"
#include <math.h>
#include <string.h>

typedef struct shrinker {
    compare_pair_fn compare;
    void *user;
    const transform *t;
    double end; /* [s] of the processor */
    scene *x;
    finding *f;
} shrinker;

static int of_values(const finding *f) { return strcmp(f->kind, "field") == 0 || strcmp(f->kind, "figure") == 0; }

static double difference(const finding *f)
{
    double d = fabs(f->a - f->b) / f->scale;
    return isnan(d) ? 1.0 : d;
}

/* It is of the same kind, and does not fade away into rounding. */
static int same(const finding *a, const finding *b)
{
    if (!b->found) return 0;
    if (of_values(a)) return of_values(b) && difference(b) >= 0.2 * difference(a);
    if (strcmp(a->kind, b->kind) != 0) return 0;
    if (strcmp(a->kind, "invariant") == 0)
        return strcmp(a->name, b->name) == 0 && strncmp(a->detail, b->detail, 6) == 0;
    if (strcmp(a->kind, "outcome") == 0) return a->a == b->a && a->b == b->b && strncmp(a->detail, b->detail, 12) == 0;
    return strncmp(a->detail, b->detail, 120) == 0;
}

/* 1: the candidate shows the same and takes the place of the scene. */
static int accept(shrinker *s, const scene *candidate)
{
    finding f;
    if (processor_seconds() > s->end || !transform_holds(s->t, candidate)) return 0;
    s->compare(s->user, candidate, s->t, &f);
    if (!same(s->f, &f)) return 0;
    *s->x = *candidate;
    *s->f = f;
    return 1;
}

static int without_sections(shrinker *s)
{
    static scene y;
    int done = 0;
    for (int k = s->x->sections - 1; k > 0; k--) {
        if (s->x->part[k].gone) continue;
        y = *s->x;
        y.part[k].gone = 1;
        for (int j = 0; j < y.entries; j++)
            if (y.list[j].section == k) y.list[j].key[0] = '\0';
        done |= accept(s, &y);
    }
    return done;
}

/* Prescribed steps and tolerances stay: without them pairs differ by what they allow. */
static int of_steps(const entry *e)
{
    static const char *const keys[] = {"max_step", "rtol", "max_dissolved_fraction", "steady_tolerance"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (strcmp(e->key, keys[k]) == 0) return 1;
    return 0;
}

static int without_keys(shrinker *s)
{
    static scene y;
    int done = 0;
    for (int j = s->x->entries - 1; j >= 0; j--) {
        entry *e = &s->x->list[j];
        if (!e->key[0] || e->section == s->x->grid || of_steps(e)) continue;
        y = *s->x;
        y.list[j].key[0] = '\0';
        if (accept(s, &y)) {
            done = 1;
            continue;
        }
        if (e->kind == ENTRY_PLAIN && e->count[0] > 1 && s->x->pool[e->first[0]].kind == TOKEN_NUMBER) {
            y = *s->x;
            y.list[j].count[0] = 1;
            done |= accept(s, &y);
        }
    }
    return done;
}

/* Fewer cells, from either end. */
static int with_fewer_cells(shrinker *s)
{
    static scene y;
    int done = 0;
    for (int d = 0; d < PD_DIM; d++)
        for (int low = 0; low < 2; low++)
            for (int part = 2; part <= 16; part *= 2) {
                int less = s->x->cells[d] / part;
                if (less < 1 || s->x->cells[d] - less < 2) continue;
                y = *s->x;
                entry *box = scene_find(&y, y.grid, "box");
                if (!box || ((y.has & HAS_AXIS) && d == 1 && low)) continue;
                y.cells[d] -= less;
                if (low) box->low[d] += less * y.h[d];
                else box->high[d] -= less * y.h[d];
                y.low[d] = box->low[d];
                if (accept(s, &y)) {
                    done = 1;
                    part /= 2;
                }
            }
    return done;
}

/* An earlier end. */
static int with_less_time(shrinker *s)
{
    static scene y;
    int done = 0;
    for (int k = 0; k < 4; k++) {
        y = *s->x;
        scene_shorten(&y, 0.5);
        if (!(y.until > 0.0) || !accept(s, &y)) break;
        done = 1;
    }
    return done;
}

void shrink_scene(compare_pair_fn compare, void *user, const transform *t, double limit, scene *x, finding *f)
{
    shrinker s = {compare, user, t, processor_seconds() + limit, x, f};
    for (int round = 0; round < 4 && processor_seconds() < s.end; round++) {
        int done = without_sections(&s);
        done |= with_less_time(&s);
        done |= with_fewer_cells(&s);
        done |= without_keys(&s);
        if (!done) break;
    }
}
