/* report: tables on the screen, result lines, and the text and figures of the report. */
#ifndef VAL_REPORT_H
#define VAL_REPORT_H

static int val_shows(const val_result *r, long which)
{
    for (int l = 0; l < r->levels; l++)
        if ((which ? r->out[l].evals : r->out[l].steps) > 0) return 1;
    return 0;
}

static void val_head(const val_result *r, table_row *row)
{
    const val_part *p = r->part;
    row->cells = 0;
    table_cell(row, "%s", p->column);
    table_cell(row, "h [m]");
    if (p->by != VAL_BY_M) table_cell(row, "m");
    for (int k = 0; k < p->measures; k++) {
        table_cell(row, "%s", p->measure[k].label);
        if (p->slope > 0.0) table_cell(row, "order");
    }
    if (val_shows(r, 0)) table_cell(row, "steps");
    if (val_shows(r, 1)) table_cell(row, "evaluations");
    table_cell(row, "wall [s]");
}

static void val_line(const val_result *r, int l, table_row *row)
{
    const val_part *p = r->part;
    const val_outcome *o = &r->out[l];
    row->cells = 0;
    if (p->by == VAL_BY_N) table_cell(row, "%d", r->level[l].n);
    else table_cell(row, "%g", p->by == VAL_BY_M ? r->level[l].m : r->level[l].p);
    table_cell(row, "%.3g", o->h);
    if (p->by != VAL_BY_M) table_cell(row, "%g", r->level[l].m);
    for (int k = 0; k < p->measures; k++) {
        double order = val_order(r, l, k);
        table_cell(row, "%.2e", o->err[k]);
        if (p->slope > 0.0 && isfinite(order)) table_cell(row, "%.2f", order);
        else if (p->slope > 0.0) table_cell(row, "-");
    }
    if (val_shows(r, 0)) table_cell(row, "%ld", o->steps);
    if (val_shows(r, 1)) table_cell(row, "%ld", o->evals);
    table_cell(row, "%.2f", o->wall);
}

/* Why a goal is judged as it is: "goal u, L2 <= 1e-06 (n >= 60): met, 3.1e-09". */
static val_verdict val_goal_text(const val_result *r, const val_goal *g, char *text, size_t size)
{
    static const char *const words[] = {"not judged at these levels", "met", "MISSED"};
    const val_measure *m = &r->part->measure[g->measure];
    char what[160], range[32] = "", number[40] = "";
    double value;
    val_verdict v = val_judge(r, g, &value);
    if (g->order > 0.0) snprintf(what, sizeof what, "order of %s at least %g", m->label, g->order);
    else snprintf(what, sizeof what, "%s at most %g", m->label, g->bound);
    if (g->from > 0) snprintf(range, sizeof range, " (from n = %d)", g->from);
    if (v != VAL_UNJUDGED) snprintf(number, sizeof number, g->order > 0.0 ? ", %.2f" : ", %.2e", value);
    snprintf(text, size, "%s: %s%s: %s%s", g->rank == VAL_GUARD ? "guard" : "goal", what, range, words[v], number);
    return v;
}

/* The worst verdict of a part: a failed run is a miss. */
static val_verdict val_part_verdict(const val_result *r)
{
    val_verdict worst = VAL_UNJUDGED;
    double value;
    if (r->failed) return VAL_MISSED;
    for (int k = 0; k < r->part->goals; k++) {
        val_verdict v = val_judge(r, &r->part->goal[k], &value);
        if (v > worst) worst = v;
    }
    return worst;
}

/* ---- screen ---- */

static void val_print_title(const val_case *c)
{
    printf("\n%s, %dD: %s\n", c->name, PD_DIM, c->title);
    fflush(stdout);
}

static void val_print_part(const val_result *r)
{
    table_row row[VAL_LEVELS + 1];
    if (r->part->name[0]) printf("  %s\n", r->part->title);
    val_head(r, &row[0]);
    for (int l = 0; l < r->levels; l++) val_line(r, l, &row[l + 1]);
    table_print(row, r->levels + 1);
    for (int k = 0; k < r->part->goals; k++) {
        char text[256];
        val_goal_text(r, &r->part->goal[k], text, sizeof text);
        printf("  %s\n", text);
    }
    if (r->failed) printf("  FAILED: %s\n", r->message);
    fflush(stdout);
}

static void val_print_result(const val_result *r, int threads)
{
    for (int l = 0; l < r->levels; l++) {
        const val_outcome *o = &r->out[l];
        printf("result case=%s dim=%d", r->of->name, PD_DIM);
        if (r->part->name[0]) printf(" part=%s", r->part->name);
        printf(" h=%g m=%g", o->h, r->level[l].m);
        if (r->part->by == VAL_BY_N) printf(" n=%d", r->level[l].n);
        if (r->part->by == VAL_BY_P) printf(" level=%g", r->level[l].p);
        for (int k = 0; k < r->part->measures; k++) {
            double order = val_order(r, l, k);
            printf(" %s=%.6g", r->part->measure[k].key, o->err[k]);
            if (!isfinite(order)) continue;
            if (k == 0) printf(" order=%.3f", order);
            else printf(" order_%s=%.3f", r->part->measure[k].key, order);
        }
        if (o->residual > 0.0) printf(" residual=%.3g", o->residual);
        if (o->steps > 0) printf(" steps=%ld", o->steps);
        if (o->evals > 0) printf(" evals=%ld", o->evals);
        printf(" wall_s=%.3f cpu_s=%.3f peak_rss_mb=%.1f threads=%d\n", o->wall, o->cpu, o->peak_rss_mb, threads);
    }
}

/* ---- figures ---- */

/* The measure whose expected slope and bound a figure shows: that of the first goal with an order, else the first. */
static int val_main_measure(const val_part *p)
{
    for (int k = 0; k < p->goals; k++)
        if (p->goal[k].order > 0.0) return p->goal[k].measure;
    return 0;
}

/* Errors against the abscissa; beside them the expected slope, from the finest error of the main measure, and its
 * bound. */
static pd_status val_draw_errors(pd_ctx *ctx, const char *path, const val_result *r)
{
    double x[VAL_LEVELS], e[VAL_MEASURES][VAL_LEVELS], slope[VAL_LEVELS], bound[VAL_LEVELS];
    char title[160], slope_name[32], bound_name[32];
    const val_part *p = r->part;
    int last = r->levels - 1, top = val_main_measure(p);
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    for (int l = 0; l <= last; l++) x[l] = r->out[l].x;
    for (int k = 0; k < p->measures; k++) {
        for (int l = 0; l <= last; l++) e[k][l] = r->out[l].err[k];
        plot_add(&plot, p->measure[k].label, x, e[k], r->levels, PD_SERIES_STYLE_BOTH);
    }
    if (p->slope > 0.0) {
        for (int l = 0; l <= last; l++) slope[l] = e[top][last] * pow(x[l] / x[last], p->slope);
        snprintf(slope_name, sizeof slope_name, "order %g", p->slope);
        plot_add(&plot, slope_name, x, slope, r->levels, PD_SERIES_STYLE_DASHED);
    }
    for (int k = 0; k < p->goals && plot.count < PD_PLOT_MAX_SERIES; k++) {
        if (!(p->goal[k].bound > 0.0) || p->goal[k].measure != top || p->goal[k].rank == VAL_GUARD) continue;
        for (int l = 0; l <= last; l++) bound[l] = p->goal[k].bound;
        snprintf(bound_name, sizeof bound_name, "goal %g", p->goal[k].bound);
        plot_add(&plot, bound_name, x, bound, r->levels, PD_SERIES_STYLE_DASHED);
        break;
    }
    snprintf(title, sizeof title, "%s, %dD%s%s: errors", r->of->name, PD_DIM, p->name[0] ? ", " : "",
             p->name[0] ? p->title : "");
    plot.title = title;
    plot.x_label = p->x_label ? p->x_label : "h [m]";
    plot.y_label = "error [-]";
    plot.x_log = p->by != VAL_BY_M;
    for (int l = 0; l <= last; l++) plot.x_log = plot.x_log && x[l] > 0.0; /* angles begin at 0 */
    plot.y_log = 1;
    return pd_plot_write(ctx, path, &plot);
}

static pd_status val_draw_profile(pd_ctx *ctx, const char *path, const val_profile *p)
{
    pd_plot plot;
    memset(&plot, 0, sizeof plot);
    plot.title = p->title;
    plot.x_label = p->x_label;
    plot.y_label = p->y_label;
    plot.x_log = p->x_log;
    plot.y_log = p->y_log;
    for (int k = 0; k < p->curves; k++) {
        const val_curve *c = &p->curve[k];
        plot_add(&plot, c->name, c->x, c->y, c->count, c->stroke);
    }
    return pd_plot_write(ctx, path, &plot);
}

/* ---- text ---- */

static pd_status val_text_table(pd_ctx *ctx, pd_file *file, const val_result *r)
{
    table_row row[VAL_LEVELS + 1];
    val_head(r, &row[0]);
    for (int l = 0; l < r->levels; l++) val_line(r, l, &row[l + 1]);
    return report_table(ctx, file, row, r->levels + 1);
}

/* Draws one figure of a part into the folder and links it. */
static pd_status val_text_figure(pd_ctx *ctx, const char *folder, pd_file *file, const val_result *r, const char *kind)
{
    char path[PD_PATH_SIZE], name[128];
    snprintf(name, sizeof name, "%s_%dd%s%s_%s.png", r->of->name, PD_DIM, r->part->name[0] ? "_" : "", r->part->name,
             kind);
    PD_TRY(pd_file_join(ctx, folder, name, path));
    if (strcmp(kind, "errors") == 0) PD_TRY(val_draw_errors(ctx, path, r));
    else PD_TRY(val_draw_profile(ctx, path, &r->profile));
    return report_text(ctx, file, "![%s, %dD, %s](%s)\n\n", r->of->name, PD_DIM, kind, name);
}

static pd_status val_text_part(pd_ctx *ctx, const char *folder, pd_file *file, const val_result *r)
{
    if (r->part->name[0]) PD_TRY(report_text(ctx, file, "**%s**\n\n", r->part->title));
    PD_TRY(val_text_table(ctx, file, r));
    for (int k = 0; k < r->part->goals; k++) {
        char text[256];
        val_goal_text(r, &r->part->goal[k], text, sizeof text);
        PD_TRY(report_text(ctx, file, "- %s\n", text));
    }
    if (r->failed) PD_TRY(report_text(ctx, file, "- FAILED: %s\n", r->message));
    PD_TRY(report_text(ctx, file, "\n"));
    if (r->part->miss && val_part_verdict(r) == VAL_MISSED)
        PD_TRY(report_text(ctx, file, "*Why it is missed.* %s\n\n", r->part->miss));
    if (r->levels > 1) PD_TRY(val_text_figure(ctx, folder, file, r, "errors"));
    if (r->profile.curves) PD_TRY(val_text_figure(ctx, folder, file, r, "curves"));
    return PD_OK;
}

/* NAME_2d.md: the section of a case in the report. */
static pd_status val_write_case(pd_ctx *ctx, const char *folder, const val_result *r, int parts)
{
    char path[PD_PATH_SIZE], name[96];
    const val_case *c = r->of;
    pd_file file;
    memset(&file, 0, sizeof file);
    snprintf(name, sizeof name, "%s_%dd.md", c->name, PD_DIM);
    PD_TRY(pd_file_join(ctx, folder, name, path));
    PD_TRY(pdi_file_create(ctx, path, &file));
    pd_status status =
        report_text(ctx, &file,
                 "### %s, %dD: %s\n\n%s\n\n*What it catches.* %s\n\n*Reference.* %s.\n\n*Run.* "
                 "`build/validate%dd %s`\n\n",
                 c->name, PD_DIM, c->title, c->what, c->why, c->source, PD_DIM, c->name);
    for (int k = 0; k < parts && status == PD_OK; k++) status = val_text_part(ctx, folder, &file, &r[k]);
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

/* One row of the summary for every goal of the project that was judged. */
static pd_status val_text_summary(pd_ctx *ctx, pd_file *file, const val_result *r)
{
    for (int k = 0; k < r->part->goals; k++) {
        const val_goal *g = &r->part->goal[k];
        double value;
        val_verdict v = val_judge(r, g, &value);
        if (g->rank == VAL_GUARD || v == VAL_UNJUDGED) continue;
        PD_TRY(report_text(ctx, file, "| %s | [%s, %dD](#%s-%dd) | %s | %s%s | ", v == VAL_MET ? "met" : "**missed**",
                         r->of->name, PD_DIM, r->of->name, PD_DIM, r->part->name[0] ? r->part->title : "",
                         g->order > 0.0 ? "order of " : "", r->part->measure[g->measure].label));
        if (g->order > 0.0) PD_TRY(report_text(ctx, file, "at least %g | %.2f |\n", g->order, value));
        else PD_TRY(report_text(ctx, file, "at most %g | %.2e |\n", g->bound, value));
    }
    if (r->failed)
        PD_TRY(report_text(ctx, file, "| **failed** | [%s, %dD](#%s-%dd) | %s | %s | | |\n", r->of->name, PD_DIM,
                         r->of->name, PD_DIM, r->part->title, r->message));
    return PD_OK;
}

/* summary_2d.md: the rows of the cases that were run. */
static pd_status val_write_summary(pd_ctx *ctx, const char *folder, const val_result *r, int results)
{
    char path[PD_PATH_SIZE], name[32];
    pd_file file;
    pd_status status = PD_OK;
    memset(&file, 0, sizeof file);
    snprintf(name, sizeof name, "summary_%dd.md", PD_DIM);
    PD_TRY(pd_file_join(ctx, folder, name, path));
    PD_TRY(pdi_file_create(ctx, path, &file));
    for (int k = 0; k < results && status == PD_OK; k++) status = val_text_summary(ctx, &file, &r[k]);
    if (status == PD_OK) return pdi_file_commit(ctx, &file);
    pdi_file_abandon(&file);
    return status;
}

#endif
