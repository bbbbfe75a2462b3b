/* loops: which metal lies on a closed loop of current among ions that migrate (theory: 9.6).
 *
 * Current leaves the metal of a circuit, passes a pocket of fluid and enters metal, or it passes a side that holds a
 * potential. A surface that carries current one way only, into or out of a pocket or circuit that has no way back,
 * carries none: there the drop of potential has no end. Its speed and flow are 0. What loops do not join to a given
 * potential has a zero of its own: the mean of its fluid.
 */
#ifndef PD_LOOPS_H
#define PD_LOOPS_H
#include "react/etch.h"

#ifdef PDI_INTERNAL
/* For the places and concentrations as they are: etch->open of places, etch->joined, and reactive->migration.idle. */
PDI_FN void pdi_loops_find(pd_reactive *reactive);
/* Potentials of fluid and circuits count from the zero of what loops join. Inside of a step. */
PDI_FN void pdi_loops_level(pd_reactive *reactive);
#endif

#endif
