/* isotropic: see isotropic.h */
#include "flow/isotropic.h"
#include "core/par.h"
#include <math.h>
#include <string.h>

/* Cell Reynolds number at which half of the excess is left: from 2 on central differences of advection waver. */
#define PDI_ISOTROPIC_CELL 2.0

/* L u of component f at `node`, by the bonds of a square that are open (eq. 4.1d). */
static double pdi_isotropic_square(const pd_bonds *bonds, const pd_square *square, int32_t r, const double *f)
{
    int32_t node = bonds->node[r];
    int across = pdi_bond_open(bonds, r, square->across), open[2];
    double sum = across ? f[node + bonds->paths.shift[square->across]] - f[node] : 0.0;
    for (int s = 0; s < 2; s++) {
        open[s] = pdi_bond_open(bonds, r, square->side[s]);
        if (open[s]) sum -= f[node + bonds->paths.shift[square->side[s]]] - f[node];
    }
    return across && open[0] && open[1] ? 0.0 : square->more * sum;
}

PDI_FN double pdi_isotropic_row(const pd_isotropic *isotropic, int32_t r, const double *f)
{
    double lap = 0.0;
    for (int s = 0; s < isotropic->squares; s++)
        lap += pdi_isotropic_square(isotropic->bonds, &isotropic->square[s], r, f);
    return lap;
}

PDI_FN void pdi_isotropic_rows(const pd_ctx *ctx, const pd_isotropic *isotropic, double nu, const double *u,
                               double *ru)
{
    const pd_bonds *bonds = isotropic->bonds;
    if (!bonds) return;
    int64_t total = bonds->grid->total;
    int nt = pdi_par_threads(ctx, (int64_t)bonds->rows * isotropic->squares * PD_DIM * 8);
    (void)nt;
    PDI_PARALLEL_FOR(nt)
    for (int32_t r = 0; r < bonds->rows; r++)
        for (int d = 0; d < PD_DIM; d++)
            ru[d * total + bonds->node[r]] += nu * pdi_isotropic_row(isotropic, r, u + d * total);
}

PDI_COLD_BEGIN
PDI_FN double pdi_isotropic_share(const pd_isotropic *isotropic, double rate)
{
    double longest = 0.0;
    if (!isotropic->bonds) return 0.0;
    for (int d = 0; d < PD_DIM; d++) longest = fmax(longest, isotropic->bonds->stencil->h[d]);
    double times = rate * longest / PDI_ISOTROPIC_CELL;
    return 1.0 / (1.0 + times * times);
}

/* The bond with the offset n; -1: none. */
static int pdi_isotropic_find(const pd_stencil *s, const int *n)
{
    for (int k = 0; k < s->count; k++)
        if (!memcmp(s->offset + k * PD_DIM, n, PD_DIM * sizeof *n)) return k;
    return -1;
}

/* The four squares beside a node in the plane of the axes a and b. 0: the family has no diagonals. */
static int pdi_isotropic_plane(const pd_stencil *s, int a, int b, pd_isotropic *isotropic)
{
    double wanted = (1.0 / (s->h[a] * s->h[a]) + 1.0 / (s->h[b] * s->h[b])) / 12.0;
    for (int which = 0; which < 4; which++) {
        pd_square *square = &isotropic->square[isotropic->squares++];
        int n[PD_DIM];
        memset(n, 0, sizeof n);
        n[a] = which & 1 ? 1 : -1;
        square->side[0] = pdi_isotropic_find(s, n);
        n[b] = which & 2 ? 1 : -1;
        square->across = pdi_isotropic_find(s, n);
        n[a] = 0;
        square->side[1] = pdi_isotropic_find(s, n);
        if (square->across < 0) return 0;
        square->more = wanted - s->lap[square->across];
        isotropic->excess[square->across] += square->more;
        for (int side = 0; side < 2; side++) isotropic->excess[square->side[side]] -= square->more;
    }
    return 1;
}

PDI_FN void pdi_isotropic_build(const pd_bonds *bonds, pd_isotropic *isotropic)
{
    const pd_stencil *s = bonds->stencil;
    memset(isotropic, 0, sizeof *isotropic);
    if (PD_DIM == 1 || s->reach > 1 || s->count != 2 * PD_DIM * PD_DIM || bonds->grid->circumference) return;
    for (int a = 0; a < PD_DIM; a++)
        for (int b = a + 1; b < PD_DIM; b++)
            if (!pdi_isotropic_plane(s, a, b, isotropic)) return;
    isotropic->bonds = bonds;
}
PDI_COLD_END
