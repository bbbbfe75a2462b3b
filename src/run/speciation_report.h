/* speciation_report: chemical equilibrium (speciation) of an electrolyte as text, or its titration by a reagent as a
 * table. */
#ifndef PD_SPECIATION_REPORT_H
#define PD_SPECIATION_REPORT_H
#include "scene/read_electrolyte.h"
#include "physics/summary.h"

typedef struct pd_speciation_report_desc {
    const char *path; /* of a scene, or of a file of species and reactions */
    const char *const *overrides;
    int count;
    const char *titrate; /* "Na+ + OH- 0..1 mM 21": a neutral reagent, how much, rows; NULL: the equilibrium alone */
    pd_print_fn print;
    void *user;
} pd_speciation_report_desc;

#define pd_speciation_report_print PD_NAME(pd_speciation_report_print)

/* Print pH, ionic strength, species, saturation of minerals and elements of the start in equilibrium, and a line of
 * results; or, with a reagent, the rows of a table (CSV) and a line of results. Failures as those of
 * pd_electrolyte_read and pd_electrolyte_solve. PD_ERR_PARSE: the text of the reagent; PD_ERR_ARGUMENT: it takes more
 * than there is. *bad_input: 1: the file or the text is refused, and not for lack of memory. */
PD_API pd_status pd_speciation_report_print(pd_ctx *ctx, const pd_speciation_report_desc *desc, int *bad_input);

#endif
