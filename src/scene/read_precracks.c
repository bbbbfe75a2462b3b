/* read_precracks: see read_precracks.h */
#include "scene/read_precracks.h"
#include <math.h>
#include <string.h>

/* Smallest number of corners; largest number of coordinates. */
enum { PDI_READ_PRECRACKS_MIN_CORNERS = PD_DIM, PDI_READ_PRECRACKS_MAX_COORDINATES = PD_SETUP_CORNERS * PD_DIM };

/* Read the corners [m] of the crack, all coordinates of one after the other: a point (1D), a polyline (2D), a polygon
 * (3D). PD_ERR_ARGUMENT: fewer than PD_DIM corners, in 1D more than one, a number of coordinates that PD_DIM does not
 * divide, or a corner at the place of the one before it. */
static pd_status pdi_read_precracks_corners(pdi_reader *s, int section, pd_setup_precrack *cut)
{
    static const char *const what[] = {"one place", "2 or more corners of a line", "3 or more corners of a polygon"};
    int count;
    PD_TRY(pdi_text_get_numbers(s->ctx, s->text, section, "points", "m", NULL, PDI_READ_PRECRACKS_MAX_COORDINATES,
                                cut->corner, &count));
    cut->corners = count / PD_DIM;
    if (count % PD_DIM || cut->corners < PDI_READ_PRECRACKS_MIN_CORNERS || (PD_DIM == 1 && count > 1))
        return pdi_text_fail_key(s->ctx, s->text, section, "points", "found %d number%s, expected %s, %d number%s each",
                                 count, count > 1 ? "s" : "", what[PD_DIM - 1], PD_DIM, PD_DIM > 1 ? "s" : "");
    for (int k = 0; PD_DIM > 1 && k + 1 < cut->corners; k++) {
        double square = 0.0;
        for (int d = 0; d < PD_DIM; d++) {
            double step = cut->corner[(k + 1) * PD_DIM + d] - cut->corner[k * PD_DIM + d];
            square += step * step;
        }
        if (!(square > 0.0))
            return pdi_text_fail_key(s->ctx, s->text, section, "points",
                                     "found corner %d at the place of corner %d, "
                                     "expected another place",
                                     k + 2, k + 1);
    }
    return PD_OK;
}

/* Read the growth direction of the crack, not normalised; default in 2D: its last corner less the one before. In 2D,
 * and in 3D with a direction, is_recorded becomes 1: the crack gets a table. In 1D, and in 3D without the key, it
 * becomes 0. PD_ERR_ARGUMENT of a recorded crack: a zero vector, or fewer than PD_DIM numbers. */
static pd_status pdi_read_precracks_direction(pdi_reader *s, int section, pd_setup_precrack *cut)
{
    double square = 0.0;
    int count = PD_DIM;
    cut->is_recorded = PD_DIM == 2;
    if (pdi_text_has_key(s->ctx, s->text, section, "direction")) {
        cut->is_recorded = PD_DIM > 1;
        PD_TRY(pdi_text_get_numbers(s->ctx, s->text, section, "direction", "", NULL, PD_DIM, cut->direction, &count));
    } else if (cut->is_recorded)
        for (int d = 0; d < PD_DIM; d++)
            cut->direction[d] =
                cut->corner[(cut->corners - 1) * PD_DIM + d] - cut->corner[(cut->corners - 2) * PD_DIM + d];
    for (int d = 0; d < PD_DIM; d++) square += cut->direction[d] * cut->direction[d];
    if (!cut->is_recorded || (count == PD_DIM && square > 0.0 && square < PD_KEY_MAX_NUMBER)) return PD_OK;
    return pdi_text_fail_key(s->ctx, s->text, section, "direction",
                             "expected a direction, %d numbers that are not all zero", PD_DIM);
}

/* Read the three radii [m] about the tip that bound the two domains of the J-integral, if they are given; then
 * j_domains is 2. PD_ERR_ARGUMENT: not in 2D, dynamics, a yield stress, a bond-based material or one of large strains,
 * another number of radii than 3, a negative one, or steps between them below one horizon m h. */
static pd_status pdi_read_precracks_j_contours(pdi_reader *s, int section, pd_setup_precrack *cut)
{
    const pd_setup_mechanics *b = &s->setup->metal_body;
    double least = b->m * s->setup->h[0];
    int count;
    if (!pdi_text_has_key(s->ctx, s->text, section, "contour_radii")) return PD_OK;
    PD_TRY(pdi_text_get_numbers(s->ctx, s->text, section, "contour_radii", "m", NULL, 3, cut->radius, &count));
    if (b->material > PD_SOLID_COUPLING_ORDINARY_STATE || b->material == PD_SOLID_COUPLING_BOND_BASED ||
        b->density > 0.0 || b->yield > 0.0)
        return pdi_text_fail_key(s->ctx, s->text, section, "contour_radii",
                                 "found with %s, expected small strains in balance:"
                                 " J is theirs",
                                 b->material == PD_SOLID_COUPLING_BOND_BASED ? "model = bond_based"
                                 : b->density > 0.0                          ? "dynamics = yes"
                                 : b->yield > 0.0                            ? "yield_stress"
                                                                             : "a material of large strains");
    if (PD_DIM != 2)
        return pdi_text_fail_key(s->ctx, s->text, section, "contour_radii", "found in %dD, expected 2D", PD_DIM);
    if (count != 3)
        return pdi_text_fail_key(s->ctx, s->text, section, "contour_radii",
                                 "found %d length%s, expected 3: J is taken between"
                                 " the first two, and between the last two",
                                 count, count > 1 ? "s" : "");
    for (int k = 0; k < 2; k++)
        if (!(cut->radius[k + 1] - cut->radius[k] >= least * (1.0 - 1e-9)) || !(cut->radius[0] >= 0.0))
            return pdi_text_fail_key(s->ctx, s->text, section, "contour_radii",
                                     "found %.6g and %.6g m, expected growing radii"
                                     " a horizon m h or more apart, here %.6g m",
                                     cut->radius[k], cut->radius[k + 1], least);
    cut->j_domains = 2;
    return PD_OK;
}

/* Append a monitor of the tip of the crack that was appended last, if it is recorded; else do nothing. PD_ERR_ARGUMENT:
 * too many monitors. */
static pd_status pdi_read_precracks_add_monitor(pdi_reader *s, const pd_setup_precrack *cut)
{
    pd_setup *u = s->setup;
    if (!cut->is_recorded) return PD_OK;
    if (u->monitors == PD_SETUP_MONITORS)
        return pdi_text_fail_key(s->ctx, s->text, pdi_text_get_section(s->ctx, s->text, "crack", cut->name), "crack",
                                 "found more than %d tables", PD_SETUP_MONITORS);
    pd_setup_monitor *m = &u->monitor[u->monitors++];
    memset(m, 0, sizeof *m);
    m->kind = PD_MONITOR_PRECRACK;
    m->index = u->metal_body.precracks - 1;
    m->line = cut->line;
    memcpy(m->name, cut->name, sizeof m->name);
    return PD_OK;
}

/* Read one [crack NAME] section and append the crack, with its monitor. PD_ERR_ARGUMENT: there is no [solid] section,
 * too many cracks, no name, or one of PD_SETUP_NAME - 24 bytes or more. */
static pd_status pdi_read_precracks_section(pdi_reader *s, int section)
{
    pd_setup_mechanics *b = &s->setup->metal_body;
    const char *label = s->text->section[section].label;
    if (!s->setup->has_solid)
        return pdi_text_fail_key(s->ctx, s->text, section, "crack", "found no [solid] section, expected one");
    if (b->precracks == PD_SETUP_PRECRACKS)
        return pdi_text_fail_key(s->ctx, s->text, section, "crack", "found more than %d of them", PD_SETUP_PRECRACKS);
    if (label[0] == '\0' || strlen(label) >= PD_SETUP_NAME - 24)
        return pdi_text_fail_key(s->ctx, s->text, section, "crack", "expected a short name: [crack NAME]");
    pd_setup_precrack *cut = &b->precrack[b->precracks++];
    memcpy(cut->name, label, strlen(label) + 1);
    cut->line = s->text->section[section].line;
    PD_TRY(pdi_read_precracks_corners(s, section, cut));
    PD_TRY(pdi_read_precracks_direction(s, section, cut));
    PD_TRY(pdi_read_precracks_j_contours(s, section, cut));
    return pdi_read_precracks_add_monitor(s, cut);
}

PDI_FN pd_status pdi_read_precracks_read(pdi_reader *s)
{
    for (int k = pdi_text_next_section(s->ctx, s->text, "crack", -1); k >= 0;
         k = pdi_text_next_section(s->ctx, s->text, "crack", k))
        PD_TRY(pdi_read_precracks_section(s, k));
    return PD_OK;
}
