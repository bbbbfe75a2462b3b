/* Kernels alone: core, lattice, solve; the rest is left out. */
#define PDCORR_NO_PHYSICS
#define PDCORR_IMPLEMENTATION
#include "pdcorr.h"
