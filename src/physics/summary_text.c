/* summary_text: see summary_text.h */
#include "physics/summary_text.h"
#include <stdarg.h>
#include <stdio.h>

PDI_FN void pdi_summary_text_print_line(const pdi_summary_text *s, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    s->print(s->user, PD_PRINT_SUMMARY, text);
}

PDI_FN void pdi_summary_text_print_part(const pdi_summary_text *s, pd_part part, const char *name, const char *what)
{
    const pd_model *m = s->model;
    char unknowns[48] = "";
    if (m->unknowns[part]) snprintf(unknowns, sizeof unknowns, "%.0f unknowns, ", (double)m->unknowns[part]);
    pdi_summary_text_print_line(s, "  %-12s%s; %s%.3g MB", name, what, unknowns, (double)m->bytes[part] * 1e-6);
}
