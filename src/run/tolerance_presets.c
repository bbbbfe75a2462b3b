/* tolerance_presets: see tolerance_presets.h */
#include "run/tolerance_presets.h"
#include "scene/fingerprint.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The wanted accuracy, and lists of the settings that were set or kept. */
typedef struct pdi_tolerance_presets {
    double accuracy; /* [-] */
    pd_setup *setup;
    char set_text[256], kept_text[256];
} pdi_tolerance_presets;

/* Set a solver setting to `pick`, unless the scene gives it (given: 1), and append "key = value", with the value that
 * counts, to the list of set or kept ones. */
static void pdi_tolerance_presets_set_unless_given(pdi_tolerance_presets *a, const char *key, int given, double pick,
                                                   double *value)
{
    char *list = given ? a->kept_text : a->set_text;
    size_t size = sizeof a->set_text, used = strlen(list);
    if (!given) *value = pick;
    snprintf(list + used, size - used, "%s%s = %.3g", used ? ", " : "", key, *value);
}

/* 1: the scene gives this setting. */
static int pdi_tolerance_presets_is_given(const pdi_tolerance_presets *a, pd_solver_setting knob)
{
    return (int)((a->setup->settings_given >> knob) & 1u);
}

/* Set the tolerances of the physics that the setup has, from the accuracy w: steady flow 0.1 w, implicit flow 0.5 w,
 * rtol of unsteady transport without dissolution 0.5 w (each at most 0.1); dissolved fraction of a step 2.5 w (at most
 * 0.5; kept if rtol is given; not with bond-based corrosion); limiter of limited advection 0.1 w. The factors are
 * measured (guide: 5.3). */
static void pdi_tolerance_presets_set_all(pdi_tolerance_presets *a)
{
    pd_setup *u = a->setup;
    double w = a->accuracy;
    int rtol = pdi_tolerance_presets_is_given(a, PD_SOLVER_SETTING_RTOL),
        fraction = pdi_tolerance_presets_is_given(a, PD_SOLVER_SETTING_FRACTION);
    if (u->has_flow && u->flow_time == PD_FLOW_STEADY)
        pdi_tolerance_presets_set_unless_given(a, "flow.steady_tolerance",
                                               pdi_tolerance_presets_is_given(a, PD_SOLVER_SETTING_STEADY),
                                               pd_min(0.1, 0.1 * w), &u->steady_tolerance);
    if (u->has_flow && u->flow_time == PD_FLOW_IMPLICIT)
        pdi_tolerance_presets_set_unless_given(a, "flow.rtol",
                                               pdi_tolerance_presets_is_given(a, PD_SOLVER_SETTING_FLOW_RTOL),
                                               pd_min(0.1, 0.5 * w), &u->flow_rtol);
    if (u->has_transport && !u->has_dissolve && !u->steady_transport)
        pdi_tolerance_presets_set_unless_given(a, "run.rtol", rtol, pd_min(0.1, 0.5 * w), &u->rtol);
    if (u->has_dissolve && !u->has_corrode)
        pdi_tolerance_presets_set_unless_given(
            a, rtol && !fraction ? "run.max_dissolved_fraction (of rtol)" : "run.max_dissolved_fraction",
            rtol || fraction, pd_min(0.5, 2.5 * w), &u->max_node_fraction);
    if (u->has_transport && u->has_flow && u->advection == PD_ADVECTION_LIMITED)
        pdi_tolerance_presets_set_unless_given(a, "limiter", 0, 0.1 * w, &u->limiter_tolerance);
}

pd_status pd_tolerance_presets_apply(pd_ctx *ctx, double accuracy, pd_setup *setup, char *text, size_t size)
{
    pdi_tolerance_presets a;
    memset(&a, 0, sizeof a);
    if (!(accuracy >= PD_ACCURACY_MIN) || !(accuracy <= PD_ACCURACY_MAX))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "accuracy", "found %g, expected a share from %g to %g", accuracy,
                       PD_ACCURACY_MIN, PD_ACCURACY_MAX);
    a.accuracy = accuracy;
    a.setup = setup;
    pdi_tolerance_presets_set_all(&a);
    snprintf(text, size, "accuracy %g %%: picked %s%s%s", 100.0 * accuracy, a.set_text[0] ? a.set_text : "nothing",
             a.kept_text[0] ? "; the scene sets " : "", a.kept_text);
    snprintf(a.set_text, sizeof a.set_text, "accuracy = %.17g", accuracy);
    return pdi_fingerprint_add_line(ctx, setup, a.set_text);
}
