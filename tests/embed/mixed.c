/* A mistake: two dimensions in one source file. */
#define PD_DIM 2
#include "pdcorr.h"
#undef PD_DIM
#define PD_DIM 3
#include "pdcorr.h"
