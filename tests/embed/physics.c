/* All physics, without scenes and files: offers them to other files. */
#define PDCORR_NO_SCENE
#define PDCORR_NO_IO
#define PDCORR_IMPLEMENTATION
#include "pdcorr.h"
