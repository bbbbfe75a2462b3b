/* body_bonds: see body_bonds.h */
#include "solid/body_bonds.h"

PDI_FN int64_t pdi_body_bonds_count_intact(const pd_body *body, int32_t i)
{
    pd_bond_iterator f = pd_body_bonds_begin(body, i);
    int64_t bonds = f.bonds;
    for (int32_t byte = 0; byte < (f.bonds + 7) / 8; byte++)
        for (unsigned bits = f.broken[byte]; bits; bits &= bits - 1) bonds--;
    return bonds;
}

int pd_body_is_intact(const pd_body *body)
{
    int64_t bytes = (body->bonds + 7 * (int64_t)body->count) / 8, byte = 0;
    while (byte < bytes && !body->broken[byte]) byte++;
    return byte == bytes;
}

/* Number, within the family of point j, of the bond to periodic image number `image` of point i; -1: none. */
static int32_t pdi_body_bonds_find_image(const pd_body *body, int32_t i, int32_t j, int image)
{
    for (pd_bond_iterator f = pd_body_bonds_begin(body, j); pd_body_bonds_next(&f);)
        if (f.neighbour == i && pdi_body_bond_image(&f) == image) return f.number;
    return -1;
}

PDI_FN int32_t pdi_body_bonds_find(const pd_body *body, int32_t i, int32_t j)
{
    return pdi_body_bonds_find_image(body, i, j, 0);
}

PDI_FN int32_t pdi_body_bonds_find_reverse(const pd_body *body, int32_t i, const pd_bond_iterator *f)
{
    return pdi_body_bonds_find_image(body, i, f->neighbour, -pdi_body_bond_image(f));
}

PDI_FN void pdi_body_bonds_mark_broken(pd_body *body, int32_t i, int32_t n)
{
    uint8_t *bits = body->broken + (pd_body_bonds_begin(body, i).broken - body->broken);
    bits[n >> 3] = (uint8_t)(bits[n >> 3] | 1u << (n & 7));
}

int32_t pd_body_family(const pd_body *body, int32_t i, int32_t *to, uint8_t *broken)
{
    pd_bond_iterator f = pd_body_bonds_begin(body, i);
    while (pd_body_bonds_next(&f)) {
        if (to) to[f.number] = f.neighbour;
        if (broken) broken[f.number] = (uint8_t)pd_body_bond_is_broken(&f);
    }
    return f.bonds;
}

PDI_FN int pdi_body_bonds_break(pd_body *body, int32_t i, const pd_bond_iterator *f)
{
    if (pd_body_bond_is_broken(f)) return 0;
    pdi_body_bonds_mark_broken(body, i, f->number);
    pdi_body_bonds_mark_broken(body, f->neighbour, pdi_body_bonds_find_reverse(body, i, f));
    return 1;
}

int pd_body_break(pd_body *body, int32_t i, int32_t j)
{
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
        if (f.neighbour == j && !pdi_body_bond_image(&f)) return pdi_body_bonds_break(body, i, &f);
    return 0;
}

PDI_FN int64_t pdi_body_bonds_break_all(pd_body *body, int32_t i)
{
    int64_t bonds = 0;
    for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);)
        bonds += pdi_body_bonds_break(body, i, &f);
    return bonds;
}

PDI_FN void pdi_body_bonds_mark_influential(const pd_body *body, uint8_t *felt)
{
    for (int32_t i = 0; i < body->real_count; i++) {
        felt[i] = 1;
        for (pd_bond_iterator f = pd_body_bonds_begin(body, i); pd_body_bonds_next(&f);) felt[f.neighbour] = 1;
    }
}

PDI_FN int32_t pdi_body_bonds_find_component(const pd_body *body, int32_t i, uint8_t *seen, int32_t *piece)
{
    int32_t count = 1;
    piece[0] = i;
    seen[i] = 1;
    for (int32_t n = 0; n < count; n++)
        for (pd_bond_iterator f = pd_body_bonds_begin(body, piece[n]); pd_body_bonds_next(&f);) {
            if (seen[f.neighbour] || pd_body_bond_is_broken(&f)) continue;
            seen[f.neighbour] = 1;
            piece[count++] = f.neighbour;
        }
    return count;
}
