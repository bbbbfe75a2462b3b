/* quasi_steady: a flow that is steady at every instant of a run, as a process. Acoustics take ns, advection ms,
 * dissolution h: the flow is the steady one for the present geometry and boundary data. It is solved again when metal
 * has turned fluid, or when inlets, walls and forces have changed by more than the tolerance of the solver (theory:
 * chapter 13). */
#ifndef PD_QUASI_STEADY_H
#define PD_QUASI_STEADY_H
#include "flow/steady_newton.h"
#include "solve/physics.h"

typedef struct pd_quasi_steady {
    pd_flow *flow;
    pd_steady *steady;
    pd_steady_result result; /* of the last solve */
    int is_out_of_date;      /* 1: geometry or boundary data have changed since: solve again */
    double boundary_change;  /* [-] accumulated change of the boundary data, see pdi_flow_set_time */
    double time;             /* [s] of the boundary data */
    int64_t solves, krylov, evaluations;
} pd_quasi_steady;

#define pd_quasi_steady_process PD_NAME(pd_quasi_steady_process)

/* Zeroes `quasi`, which must live as long as the process, and marks it out of date: the first solve is at the start of
 * a run. Flow and solver are borrowed. A solve that does not converge ends the run with PD_ERR_DIVERGED, one without an
 * open path or with a wrong inflow with PD_ERR_GEOMETRY. */
PD_API pd_physics pd_quasi_steady_process(pd_flow *flow, pd_steady *steady, pd_quasi_steady *quasi);

#endif
