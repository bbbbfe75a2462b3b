/* All of both headers. */
#define PDCORR_IMPLEMENTATION
#include "pdcorr_app.h"
