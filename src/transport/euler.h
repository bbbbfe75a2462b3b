/* euler: transport without metal as a process, by one backward Euler step at a time; advance.h controls its error. */
#ifndef PD_EULER_H
#define PD_EULER_H
#include "transport/transport.h"

typedef struct pd_euler {
    pd_transport *transport;
    pd_transport_result result; /* of the last step */
    double out, in;             /* [mol] (per m in planar 2D) through outlets, inlets and held walls since the start */
    int64_t krylov;
} pd_euler;

#define pd_euler_process PD_NAME(pd_euler_process)

/* Zeroes `euler`, which must live as long as the process. The transport is borrowed. */
PD_API pd_process pd_euler_process(pd_transport *transport, pd_euler *euler);

#endif
