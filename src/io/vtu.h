/* vtu: cells or points of VTK files of unstructured grids (XML) as points.
 *
 * Data may stand as text, as base64 in place, or appended (raw or base64), as it is or in blocks of zlib, in either
 * byte order. Cells of PD_DIM dimensions count; a grid that has none gives its points, with the point data `volume`.
 * The tag of a point is the first of the cell data (point data) tag, region, material and gmsh:physical that there is,
 * else 0.
 */
#ifndef PD_VTU_H
#define PD_VTU_H
#include "io/points.h"
#include "io/scan.h"
#include "io/skin.h"

#ifdef PDI_INTERNAL
/* All pieces of the grid, whose lengths are times scale in metres. PD_ERR_PARSE with path:line. */
PDI_FN pd_status pdi_vtu_read(pdi_scan *scan, double scale, pd_points *points);
#endif

#endif
