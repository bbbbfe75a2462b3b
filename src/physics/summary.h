/* summary: description of a built model in lines of text: physics, unknowns, memory, and what is not modelled. */
#ifndef PD_SUMMARY_H
#define PD_SUMMARY_H
#include "physics/model.h"
#include "physics/summary_text.h"

#define pd_summary_print PD_NAME(pd_summary_print)

/* Print the description of a built model: lattice, each physics, monitors, what is not modelled, memory, then the notes
 * of setup and physics as PD_PRINT_NOTE. print: NULL: nothing. */
PD_API void pd_summary_print(const pd_model *model, pd_print_fn print, void *user);

#endif
