/* damage: mechanical bonds of metal that dissolves, broken at random as it goes (theory: 11.5).
 *
 * A node that has lost the share d_c of its metal, d_c = (Cs - C)/(Cs - Csat), breaks each bond that it still has with
 * the probability P = (d_c' - d_c)/(1 - d_c) on the way to d_c': a bond is then intact with the probability 1 - d_c,
 * whatever steps have led there. So every bond gets one number in (0, 1), drawn from seed, node and bond, and is broken
 * while d_c is not below it. Nothing is stored, and neither steps nor threads change what breaks. Each node has its own
 * end of a bond.
 * Sources: Chen and Bobaru 2015; Jafarzadeh, Zhao, Shakouri and Bobaru 2021, eq. 3 to 5 and 10.
 */
#ifndef PD_DAMAGE_H
#define PD_DAMAGE_H
#include "core/base.h"

#ifdef PDI_INTERNAL
/* Share of `bonds` bonds of the node that are broken at the expected damage d_c [-]; d_c itself when it has none. */
PDI_FN double pdi_damage_broken(uint64_t seed, int32_t node, int bonds, double expected);
/* The expected damage [-] at which the last of them breaks, in (0, 1); 1 when it has none. */
PDI_FN double pdi_damage_last(uint64_t seed, int32_t node, int bonds);
#endif

#endif
