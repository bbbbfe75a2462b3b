/* unit_label: typesets units in labels of pictures: "[um/h]" becomes "[µm/h]", "mol/m3" "mol/m³". */
#ifndef PD_UNIT_LABEL_H
#define PD_UNIT_LABEL_H
#include "core/config.h"

#ifdef PDI_APP_INTERNAL
#define PDI_UNIT_LABEL_SIZE 512 /* [byte] size of a label with its terminating 0 */

/* UTF-8 text of a superscript digit, or of a superscript minus sign for any other character. */
PDI_FN const char *pdi_unit_label_get_superscript(char sign);
/* Typeset a label whose units stand in brackets, into out[PDI_UNIT_LABEL_SIZE], UTF-8; text outside of brackets stays.
 * What does not fit is left out. Returns out. */
PDI_FN const char *pdi_unit_label_format(const char *text, char *out);
/* Typeset a number with its unit, "1.3 um/h", in the same way; the unit begins at the first space. A text without a
 * space is typeset as a label. Returns out. */
PDI_FN const char *pdi_unit_label_format_value(const char *text, char *out);
#endif

#endif
