/* msh: cells of Gmsh files as points: MSH 2.2 and 4.1, as text.
 *
 * Cells of PD_DIM dimensions count (lines; triangles, quads; tetrahedra, hexahedra, wedges, pyramids), those of fewer
 * are left out. The tag of a point is the physical group of its cell: the first one where there are several, without
 * its sign; 0 where there is none. A cell that a file has once for each of its groups is one cell.
 */
#ifndef PD_MSH_H
#define PD_MSH_H
#include "io/points.h"
#include "io/scan.h"
#include "io/skin.h"

#ifdef PDI_INTERNAL
/* All cells of the text, whose lengths are times scale in metres. PD_ERR_PARSE with path:line: what the format does not
 * allow, cells of higher order, folded or turned cells. */
PDI_FN pd_status pdi_msh_read(pdi_scan *scan, double scale, pd_points *points);
#endif

#endif
