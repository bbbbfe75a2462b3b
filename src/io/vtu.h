/* vtu: reads VTK XML files of unstructured grids as material points.
 *
 * Data arrays may be text, inline base64 or appended (raw or base64), uncompressed or in zlib blocks, in either byte
 * order. Cells of PD_DIM dimensions become points; a grid without any gives its points, with the point data `volume`.
 * The tag of a point is the first of the cell data (point data) tag, region, material and gmsh:physical that there is,
 * else 0.
 */
#ifndef PD_VTU_H
#define PD_VTU_H
#include "lattice/points.h"
#include "io/tokenizer.h"
#include "lattice/boundary_faces.h"

#ifdef PDI_APP_INTERNAL
/* Add the cells or points of all pieces of the grid, and set the boundary faces of `points`; lengths times scale are in
 * metres. On failure some points may have been added. PD_ERR_PARSE with path:line: no unstructured grid, damaged or
 * missing arrays, cells of more than PD_DIM dimensions or not straight, folded or inverted cells, a volume that is not
 * positive. */
PDI_FN pd_status pdi_vtu_read(pdi_tokenizer *scan, double scale, pd_points *points);
#endif

#endif
