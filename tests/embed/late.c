/* A mistake: the implementation is asked for when the header has already been read. */
#include "pdcorr.h"
#define PDCORR_IMPLEMENTATION
#include "pdcorr.h"
