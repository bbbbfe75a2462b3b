/* gmsh: reads Gmsh meshes, MSH 2.2 and 4.1 as text, as material points.
 *
 * Cells of PD_DIM dimensions become points (lines; triangles, quads; tetrahedra, hexahedra, wedges, pyramids); others
 * are ignored. The tag of a point is the physical group of its cell: the first one where there are several, without
 * its sign; 0 where there is none. A cell that a file repeats for each of its groups is one cell.
 */
#ifndef PD_GMSH_H
#define PD_GMSH_H
#include "lattice/points.h"
#include "io/tokenizer.h"
#include "lattice/boundary_faces.h"

#ifdef PDI_APP_INTERNAL
/* Add the cells of the text as points, and set the boundary faces of `points`; lengths times scale are in metres. On
 * failure some points may have been added. PD_ERR_PARSE with path:line: a format error, cells of higher order, folded
 * or inverted cells. */
PDI_FN pd_status pdi_gmsh_read(pdi_tokenizer *scan, double scale, pd_points *points);
#endif

#endif
