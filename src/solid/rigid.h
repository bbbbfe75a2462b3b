/* rigid: motions of a piece of a body as a whole that what is held allows. */
#ifndef PD_RIGID_H
#define PD_RIGID_H
#include "solid/body.h"

#define PD_RIGID_MOTIONS (PD_DIM * (PD_DIM + 1) / 2)

typedef struct pd_rigid {
    const pd_body *body;
    const int32_t *piece; /* [count] points. Borrowed */
    int32_t count;
    double origin[PD_DIM]; /* [m] */
    double size;           /* [m] by which places are about 1 */
    int motions;
    double motion[PD_RIGID_MOTIONS][PD_RIGID_MOTIONS]; /* [motions][..] [-] parts of the shifts and turns */
} pd_rigid;

#ifdef PDI_INTERNAL
/* held [count][PD_DIM] of the body; NULL: nothing is held. piece is borrowed. */
PDI_FN void pdi_rigid_find(const pd_body *body, const uint8_t *held, const int32_t *piece, int32_t count,
                           pd_rigid *rigid);
/* Of all motions the largest work of forces V load over the sum of their sizes [-]; load [count][PD_DIM] [N/m3] of the
 * body, where nothing is held. */
PDI_FN double pdi_rigid_work(const pd_rigid *rigid, const uint8_t *held, const double *load);
/* Take the mean of all motions, by volume, from u [count][PD_DIM] [m] of the body. */
PDI_FN void pdi_rigid_remove(const pd_rigid *rigid, double *u);
#endif

#endif
