/* dissolving: transport together with a dissolving metal, one implicit system, as a process.
 *
 * A step is as long as no solid node loses more than a set fraction and the error in time of what is lost allows. What
 * a law knows of time holds at the middle of the step, which is of second order.
 */
#ifndef PD_DISSOLVING_H
#define PD_DISSOLVING_H
#include "metal/dissolve.h"
#include "solve/process.h"

typedef struct pd_dissolving {
    pd_dissolve *dissolve;
    pd_transport_result result; /* of the last step */
    double first;               /* [s] longest attempt at the step at hand */
    double out, in;             /* [mol] (per m in planar 2D) through outlets, inlets and held walls since the start */
    int64_t krylov;
} pd_dissolving;

#define pd_dissolving_process PD_NAME(pd_dissolving_process)

/* Zeroes `dissolving`, which must live as long as the process. The metal is borrowed, and its transport. */
PD_API pd_process pd_dissolving_process(pd_dissolve *dissolve, pd_dissolving *dissolving);

#endif
