/* invariant: see invariant.h */
#include "invariant.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Porosity that minerals leave unless the scene says otherwise (guide: 2.20). */
#define POROSITY 0.1
/* Share of the largest amount that next steps may owe (react/advance). */
#define OWED 1e-9
/* Share of what is dissolved that fluid owes at most beyond the metal that there was (react/reclaim). */
#define RECLAIMED 0.5

static void broken(finding *f, const char *name, double a, double b, double scale, const char *detail)
{
    if (f->found) return;
    memset(f, 0, sizeof *f);
    f->found = 1;
    snprintf(f->kind, sizeof f->kind, "invariant");
    snprintf(f->name, sizeof f->name, "%s", name);
    snprintf(f->detail, sizeof f->detail, "%s", detail);
    f->a = a;
    f->b = b;
    f->scale = scale > 0.0 ? scale : 1.0;
}

static const run_field *field_of(const record *r, const char *name)
{
    for (int k = 0; k < r->fields; k++)
        if (strcmp(r->field[k].name, name) == 0) return &r->field[k];
    return NULL;
}

static double value_of(const record *r, const char *section_name, const char *name, const char *key)
{
    const run_figure *g = record_figure(r, section_name, name, key);
    return g ? g->value : NAN;
}

/* 1: fluid may be without a value of it, without a solid, off surfaces, or where no current enters. */
static int has_blanks(const char *name)
{
    static const char *const names[] = {"SI", "theta", "rate", "i", "phi", "potential"};
    for (size_t k = 0; k < sizeof names / sizeof names[0]; k++)
        if (strcmp(name, names[k]) == 0) return 1;
    return 0;
}

/* What has been fluid from the start has a finite value of all that fluid has. */
static void check_finite(const record *r, finding *f)
{
    const run_field *kind = field_of(r, "kind"), *first = field_of(r, FIRST_KIND);
    for (int k = 0; k < r->fields && kind && first; k++) {
        const run_field *g = &r->field[k];
        for (int64_t i = 0; i < r->cells; i++) {
            double v = g->data[i];
            int fluid = kind->data[i] == 1.0 && first->data[i] == 1.0;
            if (isinf(v) || (isnan(v) && fluid && strchr(g->label, '[') && !has_blanks(g->name))) {
                broken(f, g->name, v, 0.0, 1.0, "is not finite in a fluid cell");
                return;
            }
        }
    }
}

static void check_bounds(const scene *x, const record *r, finding *f)
{
    const run_field *film = field_of(r, "film");
    for (int k = 0; k < r->fields; k++) {
        const run_field *g = &r->field[k];
        int amount = strstr(g->label, "mol/m3") != NULL;
        double most = 0.0;
        for (int64_t i = 0; i < r->cells && amount; i++)
            if (fabs(g->data[i]) > most) most = fabs(g->data[i]);
        for (int64_t i = 0; i < r->cells && amount; i++)
            if (g->data[i] < -1e-6 * most) broken(f, g->name, g->data[i], 0.0, most, "is negative");
    }
    for (int64_t i = 0; i < r->cells && film && (x->has & HAS_MINERAL); i++)
        if (film->data[i] > 1.0 - POROSITY + 1e-6)
            broken(f, "film", film->data[i], 1.0 - POROSITY, 1.0, "leaves less than the porosity");
}

/* [mol] Metal that the scene has lost; all that could be where none is left. */
static double lost_metal(const record *r)
{
    double solid = value_of(r, "total", "all", "solid"), loss = value_of(r, "result", "", "volume_loss");
    if (!(loss > 0.0)) return 0.0;
    return loss < 1.0 ? solid * loss / (1.0 - loss) : HUGE_VAL;
}

/* The sum of an element is that of the amounts it is made of. The solution that fills what metal has left of its cells
 * counts in the sum and in no species (guide: 2.16). All magnesium comes from metal: it holds no more than that has
 * lost. What nodes have got in a step beyond the metal that there was, all fluid owes: at most half of what is
 * dissolved (react/reclaim). */
static void check_sums(const record *r, finding *f)
{
    double sum = value_of(r, "total", "all", "sum_Mg"), parts = 0.0, most = 0.0, dissolved = 0.0;
    static const char *const of[] = {"Mg2+", "MgOH+", "Mg(OH)2(s)"};
    if (isnan(sum)) return;
    for (int k = 0; k < 3; k++) {
        double n = value_of(r, "total", "all", of[k]);
        if (!isnan(n)) parts += n;
        if (!isnan(n) && !strstr(of[k], "(s)")) dissolved += fabs(n);
    }
    double owes = lost_metal(r) > 0.0 ? fmin(RECLAIMED * dissolved, lost_metal(r)) : 0.0;
    for (int k = 0; k < r->figures; k++)
        if (strncmp(r->figure[k].key, "sum_", 4) == 0 && strcmp(r->figure[k].name, "all") == 0)
            most = fmax(most, fabs(r->figure[k].value));
    double rounds = 1e-6 * (fabs(parts) + fabs(sum)) + OWED * most;
    if (sum - parts < -rounds - owes || sum - parts > rounds + lost_metal(r))
        broken(f, "total.all.sum_Mg", sum, parts, fabs(parts), "is not the sum of its species");
}

static void check_balances(const scene *x, const record *r, finding *f)
{
    double ledger = value_of(r, "result", "", "ledger"), currents = value_of(r, "result", "", "current_balance");
    double flux = value_of(r, "result", "", "flux"), up = value_of(r, "plane", "up", "flow");
    double down = value_of(r, "plane", "down", "flow");
    if (fabs(ledger) > 1e-8) broken(f, "result.ledger", ledger, 0.0, 1.0, "the balance is open");
    double current = value_of(r, "result", "", "current"), size = x->current;
    for (int d = 1; d < PD_DIM; d++) size *= x->h[0];
    if (fabs(currents) > 1e-6 && fabs(current) > 1e-6 * size)
        broken(f, "result.current_balance", currents, 0.0, 1.0, "currents lack something");
    if (fabs(flux) > 1e-5 && x->until <= 0.0) broken(f, "result.flux", flux, 0.0, 1.0, "what enters does not leave");
    if (fabs(up - down) > 1e-5 * fabs(up))
        broken(f, "plane.down.flow", up, down, fabs(up), "planes pass different flows");
}

void check_record(const scene *x, const record *r, finding *f)
{
    static const char *const broken_runs[] = {"misses the start", "expected it to fall with the step", "an imbalance"};
    memset(f, 0, sizeof *f);
    for (size_t k = 0; k < sizeof broken_runs / sizeof broken_runs[0] && r->outcome == OUTCOME_FAILED; k++)
        if (strstr(r->message, broken_runs[k])) broken(f, "run", 0.0, 1.0, 1.0, r->message);
    if (r->outcome != OUTCOME_DONE) return;
    check_finite(r, f);
    check_bounds(x, r, f);
    check_sums(r, f);
    check_balances(x, r, f);
}
