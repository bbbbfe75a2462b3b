/* summary: description of a built model in lines of text: physics, unknowns, memory, and what is not modelled. */
#ifndef PD_SUMMARY_H
#define PD_SUMMARY_H
#include "physics/model.h"
#include "physics/summary_text.h"

#ifdef PDI_INTERNAL
/* Print the description of a built model. print: NULL: nothing. */
PDI_FN void pdi_summary_print(const pd_model *model, pd_print_fn print, void *user);
#endif

#endif
