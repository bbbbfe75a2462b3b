/* rigid_modes: rigid motions (translations and rotations) of a component of a body that its supports leave free. */
#ifndef PD_RIGID_MODES_H
#define PD_RIGID_MODES_H
#include "solid/body.h"

#define PD_RIGID_MODE_COUNT (PD_DIM * (PD_DIM + 1) / 2)

typedef struct pd_rigid_modes {
    const pd_body *body;
    const int32_t *component; /* [count] points. Borrowed */
    int32_t count;
    double origin[PD_DIM]; /* [m] */
    double size;           /* [m] by which places are about 1 */
    int motions;
    double motion[PD_RIGID_MODE_COUNT][PD_RIGID_MODE_COUNT]; /* [motions][..] [-] coefficients of translations and
                                                              * rotations */
} pd_rigid_modes;

#ifdef PDI_INTERNAL
/* Finds the free rigid motions of a component piece [count], which is borrowed, into rigid; motions: how many. held
 * [count of the body][PD_DIM]: 1: prescribed displacement; NULL: none. A motion is free where its mean square over the
 * prescribed components is at most 1e-9; without prescribed ones all are. */
PDI_FN void pdi_rigid_modes_compute(const pd_body *body, const uint8_t *held, const int32_t *piece, int32_t count,
                                    pd_rigid_modes *rigid);
/* Largest work of the forces V load along a free motion, which moves points by about 1, over the sum of their absolute
 * values [-]; 0: no motion or no force. load [count][PD_DIM] [N/m3] of the body, at free components; held: NULL:
 * none. */
PDI_FN double pdi_rigid_modes_relative_work(const pd_rigid_modes *rigid, const uint8_t *held, const double *load);
/* Subtracts all free motions, by a volume-weighted least-squares fit over the component, from u [count][PD_DIM] [m] of
 * the body, at prescribed components too; other points stay. Nothing changes without free motions, or where they are
 * linearly dependent on these points. */
PDI_FN void pdi_rigid_modes_remove(const pd_rigid_modes *rigid, double *u);
#endif

#endif
