/* A mistake: the library cannot be offered to other files and be private. */
#define PDCORR_IMPLEMENTATION
#define PDCORR_STATIC
#include "pdcorr.h"
