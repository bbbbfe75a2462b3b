/* All physics, without setups: offers them to other files. */
#define PDCORR_NO_MODEL
#define PDCORR_IMPLEMENTATION
#include "pdcorr.h"
