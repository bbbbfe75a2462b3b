/* stl: reads closed triangulated surfaces from STL files, text or binary. Normals of the file are ignored: they follow
 * from the corners. */
#ifndef PD_STL_H
#define PD_STL_H
#include "io/tokenizer.h"
#include "lattice/facets.h"

#define pd_facets_read PD_NAME(pd_facets_read)

/* Read a surface, binary or text. Lengths of the file times scale are in metres; the surface is translated by shift[3]
 * [m] (NULL: not). PD_ERR_ARGUMENT: scale is not positive, or not below 1e100. PD_ERR_FILE: also above 2 GiB.
 * PD_ERR_PARSE: no STL file (path:line), or one that is cut off. Else as pd_facets_build. */
PD_API pd_status pd_facets_read(pd_ctx *ctx, const char *path, double scale, const double *shift, pd_facets *facets);

#endif
