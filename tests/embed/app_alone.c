/* Scenes, files and pictures; another file has the rest. */
#define PDCORR_APP_IMPLEMENTATION
#include "pdcorr_app.h"
