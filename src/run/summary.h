/* summary: description of a built model in lines of text: physics, unknowns, memory, and what is not modelled. */
#ifndef PD_SUMMARY_H
#define PD_SUMMARY_H
#include "run/model.h"

/* Kinds of text that a run hands to its caller. */
typedef enum pd_print_kind {
    PD_PRINT_SUMMARY = 0, /* a line about the scene */
    PD_PRINT_NOTE = 1,    /* a line that the user should know: an ignored key, a conversion */
    PD_PRINT_PROGRESS = 2, /* the share done and the time left; replaces the line before */
    PD_PRINT_RESULT = 3   /* figures for scripts: "result case=... key=value ..." */
} pd_print_kind;

/* Text without newline; valid during the call. */
typedef void (*pd_print_fn)(void *user, pd_print_kind kind, const char *text);

#ifdef PDI_INTERNAL
/* Print the description of a built model. print: NULL: nothing. */
PDI_FN void pdi_summary_print(const pd_model *model, pd_print_fn print, void *user);
#endif

#endif
