/* summary_text: where the description of a model is printed, line by line. */
#ifndef PD_SUMMARY_TEXT_H
#define PD_SUMMARY_TEXT_H
#include "physics/model_data.h"

/* Kinds of text that a run hands to its caller. */
typedef enum pd_print_kind {
    PD_PRINT_SUMMARY = 0,  /* a line about the scene */
    PD_PRINT_NOTE = 1,     /* a line that the user should know: an ignored key, a conversion */
    PD_PRINT_PROGRESS = 2, /* the share done and the time left; replaces the line before */
    PD_PRINT_RESULT = 3    /* figures for scripts: "result case=... key=value ..." */
} pd_print_kind;

/* Text without newline; valid during the call. */
typedef void (*pd_print_fn)(void *user, pd_print_kind kind, const char *text);

#ifdef PDI_INTERNAL
/* The model and where its description is printed. */
typedef struct pdi_summary_text {
    const pd_model *model;
    pd_print_fn print;
    void *user;
} pdi_summary_text;

/* Print a formatted line as PD_PRINT_SUMMARY; more than 511 characters are cut off. */
PDI_FN void pdi_summary_text_print_line(const pdi_summary_text *s, const char *format, ...) PD_PRINTF_LIKE(2, 3);
/* Print a line such as "flow what it is" with the number of unknowns of the part, unless that is 0, and its memory
 * [MB]. */
PDI_FN void pdi_summary_text_print_part(const pdi_summary_text *s, pd_part part, const char *name, const char *what);
#endif

#endif
