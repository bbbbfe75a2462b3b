/* template: commented example scenes that `--new` writes as a start, in the dimension of the program: the files of
 * examples/scenes/templates/ as text.
 */
#ifndef PD_TEMPLATE_H
#define PD_TEMPLATE_H
#include "core/base.h"

typedef struct pd_template {
    const char *name;
    const char *const *line; /* without its end; NULL ends */
} pd_template;

#define pd_templates PD_NAME(pd_templates)

/* All templates of this dimension, by name; *count: their number. One whose name is NULL follows them. */
PD_API const pd_template *pd_templates(int *count);

#endif
