/* entry: see entry.h */
#include "metal/entry.h"
#include <string.h>

/* Node at `at`, or that which a ghost stands for. *flip (or NULL): as of pd_grid_find_source. */
static int32_t pdi_entry_home(const pd_bond_paths *paths, int32_t at, int *flip)
{
    uint8_t kind = paths->grid->kind[at];
    if (flip) *flip = 0;
    return kind == PD_FLUID || kind == PD_SOLID ? at : pd_grid_find_source(paths->grid, at, flip);
}

/* 1: no node of the box is a wall. */
static int pdi_entry_unwalled(const pd_grid *grid)
{
    int64_t cells = 1;
    for (int d = 0; d < PD_DIM; d++) cells *= grid->n[d];
    return grid->fluid_count + grid->solid_count == cells;
}

PDI_FN int pdi_entry_free(const pd_bond_paths *paths, int32_t i, int k)
{
    const pd_stencil *s = paths->stencil;
    if (pdi_entry_unwalled(paths->grid)) return 1;
    for (int g = s->group_first[k]; g < s->group_first[k + 1] - 1; g++) {
        int walled = 1;
        for (int c = s->group_cell[g]; c < s->group_cell[g + 1] && walled; c++) {
            uint8_t kind = paths->grid->kind[pdi_entry_home(paths, i + paths->cell_shift[c], NULL)];
            walled = kind != PD_FLUID && kind != PD_SOLID;
        }
        if (walled) return 0;
    }
    return 1;
}

PDI_FN void pdi_entry_find(const pd_bond_paths *paths, int32_t j, int k, pdi_entry *entry)
{
    const pd_stencil *s = paths->stencil;
    const uint8_t *kind = paths->grid->kind;
    entry->count = 0;
    entry->open = 1;
    entry->last[0] = j;
    entry->lasts = 1;
    entry->far = pdi_entry_far(paths, j, k);
    if (kind[entry->far] != PD_FLUID || !pdi_entry_free(paths, j, k)) return;
    for (int g = s->group_first[k]; g < s->group_first[k + 1]; g++) {
        int behind = entry->count, fluid = 0, metals = 0;
        int32_t metal[PDI_ENTRY_NODES];
        for (int c = s->group_cell[g]; c < s->group_cell[g + 1]; c++) {
            int flip;
            int32_t at = pdi_entry_home(paths, j + paths->cell_shift[c], &flip);
            fluid |= kind[at] == PD_FLUID;
            if (behind) continue;
            if (kind[at] == PD_FLUID && entry->count < PDI_ENTRY_NODES) {
                entry->cell[entry->count] = c;
                entry->flip[entry->count] = flip;
                entry->node[entry->count++] = at;
            } else if (kind[at] == PD_SOLID && metals < PDI_ENTRY_NODES) metal[metals++] = at;
        }
        if (!entry->count && metals) {
            memcpy(entry->last, metal, (size_t)metals * sizeof *metal);
            entry->lasts = metals;
        }
        if (behind && !fluid) entry->open = 0;
    }
}

PDI_FN void pdi_entry_mirror(const pdi_entry *entry, int e, const double *v, double *seen)
{
    for (int d = 0; d < PD_DIM; d++) seen[d] = entry->flip[e] >> d & 1 ? -v[d] : v[d];
}

PDI_FN double pdi_entry_beyond(const pd_bond_paths *paths, int k, const pdi_entry *entry, int e, const double *axis)
{
    const pd_stencil *s = paths->stencil;
    double sum = 0.0;
    for (int d = 0; d < PD_DIM; d++) {
        int steps = s->offset[k * PD_DIM + d] - s->cell[entry->cell[e] * PD_DIM + d];
        sum += steps * s->h[d] * axis[d];
    }
    return sum;
}
