/* result_line: the line of figures that a run ends with. */
#ifndef PD_RESULT_LINE_H
#define PD_RESULT_LINE_H
#include "core/base.h"

#ifdef PDI_APP_INTERNAL
/* Remove all pairs " key=value" whose value is NaN or infinite from the string `figures`, in place: unknown results are
 * not printed. */
PDI_FN void pdi_result_line_remove_nonfinite(char *figures);
#endif

#endif
