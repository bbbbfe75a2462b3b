/* points_file: reads the material points of a body from a file: a table of points, or a mesh.
 *
 *   .csv   a table with a header line: x, y, z (as many as there are dimensions), volume, and tag if there is one;
 *          a unit in brackets behind a name and other columns are ignored
 *   .msh   Gmsh 2.2 and 4.1 as text (gmsh.h)
 *   .vtu   VTK XML of an unstructured grid (vtu.h)
 *
 * With another extension the first bytes decide. Cells become points at their centroids with their volumes.
 * Coordinates beyond PD_DIM have to be the same everywhere.
 */
#ifndef PD_POINTS_FILE_H
#define PD_POINTS_FILE_H
#include "lattice/points.h"

#define pd_points_read PD_NAME(pd_points_read)

/* Read points from a file. scale: lengths of the file times scale are in metres (1e-3: millimetres), and volumes times
 * scale^d. The points are zeroed on failure. PD_ERR_ARGUMENT: scale is not positive, or not below 1e100. PD_ERR_FILE:
 * unreadable or too large. PD_ERR_PARSE with path:line: a format error, a point or cell without positive volume, a cell
 * that is folded or inverted, no point at all. */
PD_API pd_status pd_points_read(pd_ctx *ctx, const char *path, double scale, pd_points *points);

#endif
