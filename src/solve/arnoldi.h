/* arnoldi: makes a vector orthogonal to a basis, by modified Gram-Schmidt in groups. Threads share one region.
 */
#ifndef PD_ARNOLDI_H
#define PD_ARNOLDI_H
#include "core/par.h"

#ifdef PDI_INTERNAL
/* Vectors of a basis from `first` on. */
typedef pdi_par_vectors (*pdi_arnoldi_fn)(const void *user, int first);
/* w [n] is made orthogonal to the vectors 0 .. j of a basis. h [j + 2]: its parts along them, and |w| behind them.
 * Returns |w| before, or NaN. */
PDI_FN double pdi_arnoldi_append(const pd_ctx *ctx, int64_t n, int j, pdi_arnoldi_fn basis, const void *user, double *w,
                                 double *h);
#endif

#endif
