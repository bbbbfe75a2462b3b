/* arnoldi: the orthogonalisation of GMRES: blocked modified Gram-Schmidt against a basis, in one parallel region.
 */
#ifndef PD_ARNOLDI_H
#define PD_ARNOLDI_H
#include "core/par.h"

#ifdef PDI_INTERNAL
/* Access to a basis: its vectors from number `first` on, up to PDI_PAR_GROUP. */
typedef pdi_par_vector_group (*pdi_arnoldi_basis_fn)(const void *user, int first);
/* Orthogonalise w [n], in place, against the orthonormal vectors 0 .. j of a basis; w is not normalised. h [j + 2] is
 * overwritten by column j of the Hessenberg matrix: the projections on them, and then |w| after. One second pass
 * follows where the first one leaves less than a tenth of |w|; its projections are added to h. Returns |w| before, not
 * finite where w is not. Bitwise reproducible for any number of threads. */
PDI_FN double pdi_arnoldi_orthogonalise(const pd_ctx *ctx, int64_t n, int j, pdi_arnoldi_basis_fn basis,
                                        const void *user, double *w, double *h);
#endif

#endif
