/* body_bonds: bonds of a body that break, at both ends, and what unbroken bonds hold together. */
#ifndef PD_BODY_BONDS_H
#define PD_BODY_BONDS_H
#include "solid/body.h"

#define pd_body_is_intact PD_NAME(pd_body_is_intact)
#define pd_body_family PD_NAME(pd_body_family)
#define pd_body_break PD_NAME(pd_body_break)

/* 1: no bond of the body is broken. */
PD_API int pd_body_is_intact(const pd_body *body);
/* Lists the family of point i: neighbours into to, 1 (broken) or 0 (intact) into broken, an entry for each bond; NULL:
 * not wanted. Each periodic image of a point has an entry. Returns the number of bonds, broken ones too. */
PD_API int32_t pd_body_family(const pd_body *body, int32_t i, int32_t *to, uint8_t *broken);
/* Breaks the bond of two points at both ends; bonds of their images stay. Returns 1: it was intact; 0: it was
 * broken, or there is none. */
PD_API int pd_body_break(pd_body *body, int32_t i, int32_t j);

#ifdef PDI_INTERNAL
/* Number of unbroken bonds of point i. */
PDI_FN int64_t pdi_body_bonds_count_intact(const pd_body *body, int32_t i);
/* Number of the bond to point i within the family of point j (no periodic image); -1: none. */
PDI_FN int32_t pdi_body_bonds_find(const pd_body *body, int32_t i, int32_t j);
/* Number of the current bond of point i within the family of its other end. */
PDI_FN int32_t pdi_body_bonds_find_reverse(const pd_body *body, int32_t i, const pd_bond_iterator *f);
/* Marks bond number n of the family of point i as broken at this end only; the caller has to mark the other end,
 * too. */
PDI_FN void pdi_body_bonds_mark_broken(pd_body *body, int32_t i, int32_t n);
/* Breaks the current bond of point i at both ends. Returns 1: it was intact; 0: it was broken, and nothing changes. */
PDI_FN int pdi_body_bonds_break(pd_body *body, int32_t i, const pd_bond_iterator *f);
/* Breaks all bonds of point i at both ends. Returns how many were intact. */
PDI_FN int64_t pdi_body_bonds_break_all(pd_body *body, int32_t i);
/* Sets felt [count] (0 before) to 1 for real points (no mirror images) and for all points in their families, over
 * broken bonds too. Forces on real points depend on these families alone, so other families need not be computed. */
PDI_FN void pdi_body_bonds_mark_influential(const pd_body *body, uint8_t *felt);
/* Connected component of the bond graph that contains point i: points that unbroken bonds join to it, i first, into the
 * begin of piece [count]. Points with seen [count] set before are left out; those found get seen 1. Returns how
 * many. */
PDI_FN int32_t pdi_body_bonds_find_component(const pd_body *body, int32_t i, uint8_t *seen, int32_t *piece);
#endif

#endif
