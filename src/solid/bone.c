/* bone: see bone.h */
#include "solid/bone.h"
#include "core/vec.h"
#include <math.h>

double pd_bone_modulus(pd_bone_site site, double density)
{
    /* a [Pa] at 1 g/cm3, and b: sites by Morgan et al. 2003, the last one by Carter and Hayes 1977 */
    static const double laws[6][2] = {{4730e6, 1.56}, {15520e6, 1.93}, {15010e6, 2.18}, {6850e6, 1.49}, {8920e6, 1.83},
                                      {3790e6, 3.0}};
    int k = (int)site;
    if (k < 0 || k > 5 || !(density > 0.0) || !(density < 1e100)) return NAN;
    double rate = site == PD_BONE_CARTER_HAYES ? pow(0.01, 0.06) : 1.0;
    return laws[k][0] * rate * pow(density * 1e-3, laws[k][1]);
}

double pd_bone_critical_stretch(double young, double poisson, pd_plane plane, double fracture, double horizon)
{
    static const double share[3] = {3.0, PD_PI / 3.0, 5.0 / 9.0}; /* s^2 K d/G in 1D, 2D, 3D */
    double bulk = young;
    if (!(young > 0.0) || !(poisson > -1.0) || !(poisson < 0.5) || !(fracture >= 0.0) || !(horizon > 0.0)) return NAN;
    if (PD_DIM == 2) bulk = 0.5 * young / (plane == PD_PLANE_STRESS ? 1.0 - poisson
                                                                    : (1.0 + poisson) * (1.0 - 2.0 * poisson));
    if (PD_DIM == 3) bulk = young / (3.0 * (1.0 - 2.0 * poisson));
    return sqrt(share[PD_DIM - 1] * fracture / (bulk * horizon));
}
