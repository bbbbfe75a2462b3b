#define PDCORR_IMPLEMENTATION
#include "pdcorr.h"
