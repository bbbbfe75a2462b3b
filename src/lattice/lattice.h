/* lattice: stencil, grid and bonds as one object that owns its fields, for programs that use the operators alone.
 *
 * A diffusion loop:
 *     pd_lattice_desc desc = {0};
 *     for (int d = 0; d < PD_DIM; d++) desc.stencil.h[d] = 1e-6, desc.grid.hi[d] = 100e-6;
 *     pd_lattice_build(&ctx, &desc, &lattice);
 *     pd_lattice_add_field(&ctx, &lattice, 1, &c);
 *     pd_lattice_add_field(&ctx, &lattice, 1, &lap);
 *     for (int step = 0; step < steps; step++) {
 *         pd_ghosts_set_scalar(&lattice.bonds.ghosts, c);
 *         pd_op_laplacian(&ctx, &lattice.bonds, c, lap);
 *         for (int32_t i = 0; i < lattice.grid.total; i++) c[i] += dt * diffusivity * lap[i];
 *     }
 *     pd_lattice_free(&ctx, &lattice);
 */
#ifndef PD_LATTICE_H
#define PD_LATTICE_H
#include "lattice/bond.h"

/* All zero but for h and a corner of the box: calibrated weights, m = 3, walls all round, no shapes. */
typedef struct pd_lattice_desc {
    pd_stencil_desc stencil;
    pd_grid_desc grid;
} pd_lattice_desc;

/* The parts point to each other: a built lattice must not be copied or moved. */
typedef struct pd_lattice {
    pd_stencil stencil;
    pd_grid grid;
    pd_bonds bonds;
    int fields, capacity;
    int *components; /* [capacity] of each field */
    double **field;  /* [capacity] [components][total] [unit that the caller gives it] */
} pd_lattice;

#define pd_lattice_build PD_NAME(pd_lattice_build)
#define pd_lattice_add_field PD_NAME(pd_lattice_add_field)
#define pd_lattice_free PD_NAME(pd_lattice_free)

/* Builds stencil, grid and bonds (options 0), without fields. `lattice` is overwritten, and all zero after a failure.
 * Failures: those of pd_stencil_build, pd_grid_build and pd_bonds_build. */
PD_API pd_status pd_lattice_build(pd_ctx *ctx, const pd_lattice_desc *desc, pd_lattice *lattice);
/* Allocates a field: *field [components][total], all zero, freed with the lattice. Pointers to earlier fields stay
 * valid. On failure *field is NULL and the fields are as before. PD_ERR_ARGUMENT: components outside 1 .. 1024. */
PD_API pd_status pd_lattice_add_field(pd_ctx *ctx, pd_lattice *lattice, int components, double **field);
PD_API void pd_lattice_free(pd_ctx *ctx, pd_lattice *lattice);

#endif
