/* label: units in texts of pictures as they are printed: "[um/h]" becomes "[µm/h]", "mol/m3" "mol/m³". */
#ifndef PD_LABEL_H
#define PD_LABEL_H
#include "core/config.h"

#ifdef PDI_INTERNAL
#define PDI_LABEL_SIZE 512 /* [byte] of a label with its end */

/* UTF-8 of a raised digit or minus. */
PDI_FN const char *pdi_label_raised(char sign);
/* out[PDI_LABEL_SIZE], UTF-8, of a text with units in brackets; what does not fit is cut off. Returns out. */
PDI_FN const char *pdi_label_print(const char *text, char *out);
/* The same of a number and its unit, "1.3 um/h". */
PDI_FN const char *pdi_label_value(const char *text, char *out);
#endif

#endif
