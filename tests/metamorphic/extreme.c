/* extreme: see extreme.h */
#include "extreme.h"
#include "invariant.h"
#include "transform.h"
#include "random.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define LENGTHS 9.0 /* decades */
#define TIMES 6.0
#define OTHERS 6.0

void extreme_scene(const scene *x, uint32_t seed, scene *y)
{
    transform t;
    double factor[UNIT_COUNT];
    uint32_t state = seed ^ 0x2545f491u;
    memset(&t, 0, sizeof t);
    t.kind = TRANSFORM_LENGTHS_7;
    for (int d = 0; d < 3; d++) {
        t.to[d] = d;
        t.sign[d] = 1;
    }
    t.unfold = -1;
    t.length = pow(10.0, LENGTHS * random_real(&state));
    t.time = pow(10.0, TIMES * random_real(&state));
    transform_scene(x, &t, y);
    int alone = random_share(&state) < 0.5;
    for (int k = 0; k < UNIT_COUNT; k++) {
        dimension d = unit_dimension((unit)k);
        int kept = k == UNIT_ONE || k == UNIT_LENGTH || k == UNIT_TIME || k == UNIT_TEMPERATURE;
        double decades = OTHERS * random_real(&state);
        factor[k] = !kept && random_share(&state) < 1.0 / 3.0 ? pow(10.0, decades) : 1.0;
        if (alone && k != UNIT_LENGTH && k != UNIT_TIME) factor[k] /= transform_factor(&t, &d);
    }
    for (int k = 0; k < y->tokens; k++)
        if (y->pool[k].kind == TOKEN_NUMBER) y->pool[k].value *= factor[y->pool[k].of];
}

static void found(finding *f, const char *kind, const char *name, const char *detail)
{
    if (f->found) return;
    f->found = 1;
    f->scale = 1.0;
    snprintf(f->kind, sizeof f->kind, "%s", kind);
    snprintf(f->name, sizeof f->name, "%.47s", name);
    snprintf(f->detail, sizeof f->detail, "%s", detail);
}

void extreme_check(const scene *x, const record *r, finding *f)
{
    memset(f, 0, sizeof *f);
    if (r->outcome == OUTCOME_CRASHED) found(f, "crash", "", r->message);
    if (r->outcome == OUTCOME_HUNG) found(f, "hang", "", r->message);
    if (r->outcome == OUTCOME_FAILED && !strchr(r->message, ' ')) found(f, "silent", "", "it fails without a message");
    if (strstr(r->message, "nan") || strstr(r->message, " inf")) found(f, "message", "", r->message);
    for (int k = 0; k < r->figures && r->outcome == OUTCOME_DONE; k++)
        if (isinf(r->figure[k].value)) found(f, "figure", r->figure[k].key, "is not finite");
    if (r->outcome == OUTCOME_DONE && !f->found) check_record(x, r, f);
}
