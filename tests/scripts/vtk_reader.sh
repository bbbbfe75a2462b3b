#!/bin/sh
# slow: yes
# VTI and PVD files opened with VTK itself (vtk_reader.py). Skipped without VTK for Python (Debian: python3-vtk9).
. tests/lib/script.sh
CC=${CC:-cc}
find_python 'import vtkmodules.vtkIOXML'
[ "$python" ] || skip_all "VTK for Python is not installed"
cd "$dir" || exit 1

# Two frames and their collection; vtk_reader.py knows the same formulas.
cat > program.c <<'END'
#include "pdcorr_app.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define NODES 4096

static double c[NODES], v[NODES * PD_DIM];
static uint8_t kind[NODES];
static int32_t grain[NODES];

int main(void)
{
    static const int cells[3] = {7, 5, 4};
    static const double spacing[3] = {5e-6, 2.5e-6, 1e-3};
    static const char *const codes[3] = {"none", "a < b & c", "metal"};
    pd_vti_field fields[5] = {{"C", PD_VTI_FLOAT64, 0, c, "mol/m3", NULL, 0},
                              {"C & <half>", PD_VTI_FLOAT32, 0, c, "a<b>&", NULL, 0},
                              {"kind", PD_VTI_UINT8, 0, kind, NULL, codes, 3},
                              {"grain", PD_VTI_INT32, 0, grain, NULL, NULL, 0},
                              {"v", PD_VTI_FLOAT64, 1, v, "m/s", NULL, 0}};
    pd_ctx ctx;
    pd_grid grid;
    pd_pvd pvd;
    char name[PD_PATH_SIZE], path[PD_PATH_SIZE];
    memset(&grid, 0, sizeof grid);
    grid.ghost = 3;
    grid.total = 1;
    for (int d = 0; d < PD_DIM; d++) {
        grid.n[d] = cells[d];
        grid.padded[d] = cells[d] + 6;
        grid.stride[d] = grid.total;
        grid.total *= grid.padded[d];
        grid.h[d] = spacing[d];
        grid.lo[d] = -0.1 * (d + 1);
    }
    pd_ctx_init(&ctx);
    if (pd_file_make_directory(&ctx, "out") != PD_OK || pdi_pvd_init(&ctx, "out/run.pvd", &pvd) != PD_OK) goto failed;
    for (int frame = 0; frame < 2; frame++) {
        for (int32_t node = 0; node < grid.total; node++) {
            int i[3] = {0, 0, 0}, inside = 1;
            for (int d = 0; d < PD_DIM; d++) {
                i[d] = node / grid.stride[d] % grid.padded[d] - 3;
                inside = inside && i[d] >= 0 && i[d] < cells[d];
            }
            double value = i[0] + 100 * i[1] + 10000 * i[2] + 0.1 + frame;
            c[node] = inside ? value : NAN;
            kind[node] = (uint8_t)(inside ? (i[0] + 2 * i[1] + 3 * i[2]) % 6 : 99);
            grain[node] = inside ? -i[0] - 1000 * i[1] - 1000000 * i[2] : 99;
            for (int d = 0; d < PD_DIM; d++) v[d * grid.total + node] = inside ? (d + 1) * value : NAN;
        }
        if (pdi_file_format_frame_name(&ctx, "corr", frame, 6.1 * frame, "vti", name) != PD_OK) goto failed;
        if (pd_file_join(&ctx, "out", name, path) != PD_OK) goto failed;
        if (pd_vti_write(&ctx, path, &grid, 6.1 * frame, fields, 5) != PD_OK) goto failed;
        if (pdi_pvd_add_file(&ctx, &pvd, 6.1 * frame, path) != PD_OK) goto failed;
    }
    pdi_pvd_free(&ctx, &pvd);
    return ctx.in_use != 0;
failed:
    printf("%s\n", ctx.message);
    return 1;
}
END

for dim in 1 2 3; do
    rm -rf out
    linked $dim
    # shellcheck disable=SC2086
    if $CC -std=c99 ${OMP:-} -DPD_DIM=$dim -DPDCORR_LINKED -DPDI_SPLIT -I"$root" program.c \
        $library -o program -lm > log 2>&1 && ./program >> log 2>&1; then
        $python "$root/tests/vtk_reader.py" out $dim > log 2>&1
    else
        echo "the program that writes the files failed" >> log
    fi
    result=$(sed -n 's/^\([0-9]*\) passed, \([0-9]*\) failed$/\1 \2/p' log)
    [ -z "$result" ] && result='0 1'
    passed=$((passed + ${result% *})) failed=$((failed + ${result#* }))
    [ "${result#* }" = 0 ] || cat log
done
score
