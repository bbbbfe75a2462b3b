/* gmsh: see gmsh.h */
#include "io/gmsh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Largest number (id) of a node or an entity. */
#define PDI_GMSH_MAX_ID 999999999999999

/* A node of the mesh. */
typedef struct pdi_gmsh_node {
    int64_t id;
    double x[3]; /* in units of the file */
} pdi_gmsh_node;

/* A geometric entity of PD_DIM dimensions and its physical group. */
typedef struct pdi_gmsh_entity {
    int64_t id;
    int32_t tag;
} pdi_gmsh_entity;

/* Key of a cell in the hash table: its nodes, as indices in the list of nodes plus 1, ascending; 0: unused. */
typedef struct pdi_gmsh_cell_key {
    int32_t node[8];
} pdi_gmsh_cell_key;

/* State of reading a file. */
typedef struct pdi_gmsh_reader {
    pdi_tokenizer *tokenizer;
    pd_points_converter cells;                /* conversion of cells to points */
    pd_boundary_faces faces;                  /* faces of the cells */
    int version;                               /* 2: format 2.2, 4: format 4.1 */
    int64_t node_count, entity_count;          /* number of them */
    pdi_gmsh_node *node;                       /* [nodes] by id */
    pdi_gmsh_entity *entity;                   /* [entities] by id */
    int has_nodes, has_entities, has_elements; /* number of these sections so far */
    int64_t previous_entity;                   /* entity of the previous cell */
    int64_t key_count, slot_count;             /* number of cells in the hash table, and its size, a power of two */
    pdi_gmsh_cell_key *slot;                   /* [slots] hash table of cells by their nodes, at most half full */
} pdi_gmsh_reader;

/* Order of nodes by ascending id, for qsort and bsearch. */
static int pdi_gmsh_compare_nodes(const void *a, const void *b)
{
    const pdi_gmsh_node *p = (const pdi_gmsh_node *)a, *q = (const pdi_gmsh_node *)b;
    return (p->id > q->id) - (p->id < q->id);
}

/* Order of entities by ascending id, for qsort and bsearch. */
static int pdi_gmsh_compare_entities(const void *a, const void *b)
{
    const pdi_gmsh_entity *p = (const pdi_gmsh_entity *)a, *q = (const pdi_gmsh_entity *)b;
    return (p->id > q->id) - (p->id < q->id);
}

/* Skip `count` numbers. what: their name for messages. */
static pd_status pdi_gmsh_skip_numbers(pdi_gmsh_reader *m, const char *what, int64_t count)
{
    double value;
    for (int64_t k = 0; k < count; k++) PD_TRY(pdi_tokenizer_read_number(m->tokenizer, what, &value));
    return PD_OK;
}

/* ---- $MeshFormat, $Entities, $Nodes ---- */

/* Read the section $MeshFormat to its end mark and set the version: 2 for 2.2, 4 for 4.1. PD_ERR_PARSE: another
 * version, or a binary file. */
static pd_status pdi_gmsh_read_format(pdi_gmsh_reader *m)
{
    const char *at = m->tokenizer->position;
    double version;
    int64_t binary, bytes;
    PD_TRY(pdi_tokenizer_read_number(m->tokenizer, "the version", &version));
    m->version = fabs(version - 2.2) < 1e-9 ? 2 : fabs(version - 4.1) < 1e-9 ? 4 : 0;
    if (!m->version) return pdi_tokenizer_fail(m->tokenizer, at, "MSH version %g, expected 2.2 or 4.1", version);
    PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "the file type", 0, 1, &binary));
    PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "the size of numbers", 1, 16, &bytes));
    if (binary)
        return pdi_tokenizer_fail(m->tokenizer, at, "a binary file, expected text: save it with Mesh.Binary = 0");
    return pdi_tokenizer_expect_word(m->tokenizer, "$EndMeshFormat");
}

/* Read the list of physical groups of an entity; *tag: the first one without its sign, 0 without any. */
static pd_status pdi_gmsh_read_groups(pdi_gmsh_reader *m, int64_t *tag)
{
    int64_t count, group;
    *tag = 0;
    PD_TRY(pdi_tokenizer_read_count(m->tokenizer, "the number of groups", 2, &count));
    for (int64_t k = 0; k < count; k++) {
        PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "a group", -INT32_MAX, INT32_MAX, &group));
        if (k == 0) *tag = group < 0 ? -group : group;
    }
    return PD_OK;
}

/* Read the section $Entities of format 4.1 to its end mark, and keep ids (with their sign) and groups of the entities
 * of PD_DIM dimensions, sorted by id, in new memory; bounds and extents are skipped. PD_ERR_PARSE: a fault, or a second
 * such section. */
static pd_status pdi_gmsh_read_entities(pdi_gmsh_reader *m)
{
    int64_t count[4], id, tag, bounds;
    pdi_tokenizer *s = m->tokenizer;
    const char *begin = s->position;
    if (m->has_entities++) return pdi_tokenizer_fail(s, begin, "a second section $Entities");
    for (int d = 0; d < 4; d++) PD_TRY(pdi_tokenizer_read_count(s, "the number of entities", 10, &count[d]));
    m->entity_count = count[PD_DIM];
    PD_TRY(PD_NEW(s->ctx, "msh", m->entity_count, m->entity));
    for (int d = 0; d < 4; d++)
        for (int64_t k = 0; k < count[d]; k++) {
            PD_TRY(pdi_tokenizer_read_integer(s, "an entity", -PDI_GMSH_MAX_ID, PDI_GMSH_MAX_ID, &id));
            PD_TRY(pdi_gmsh_skip_numbers(m, "the extent of an entity", d ? 6 : 3));
            PD_TRY(pdi_gmsh_read_groups(m, &tag));
            if (d) PD_TRY(pdi_tokenizer_read_count(s, "the number of its bounds", 2, &bounds));
            if (d) PD_TRY(pdi_gmsh_skip_numbers(m, "a bound of an entity", bounds));
            if (d != PD_DIM) continue;
            m->entity[k].id = id;
            m->entity[k].tag = (int32_t)tag;
        }
    qsort(m->entity, (size_t)m->entity_count, sizeof *m->entity, pdi_gmsh_compare_entities);
    return pdi_tokenizer_expect_word(s, "$EndEntities");
}

/* Read the three coordinates of a node, in units of the file. PD_ERR_PARSE: one is no number, or its magnitude is not
 * below 1e100. */
static pd_status pdi_gmsh_read_coordinates(pdi_gmsh_reader *m, pdi_gmsh_node *node)
{
    for (int d = 0; d < 3; d++) {
        PD_TRY(pdi_tokenizer_read_number(m->tokenizer, "a coordinate", &node->x[d]));
        if (!(fabs(node->x[d]) < 1e100))
            return pdi_tokenizer_fail(m->tokenizer, m->tokenizer->position,
                                      "the coordinate %g, expected less than 1e100", node->x[d]);
    }
    return PD_OK;
}

/* Read the blocks of nodes of format 4.1, node_count in all, in the order of the file: ids, then coordinates, which
 * parameters may follow on their line; these are skipped. PD_ERR_PARSE: more or fewer nodes than node_count, or a
 * fault. */
static pd_status pdi_gmsh_read_node_blocks(pdi_gmsh_reader *m, int64_t blocks)
{
    int64_t value, count, done = 0;
    pdi_tokenizer *s = m->tokenizer;
    for (int64_t b = 0; b < blocks; b++) {
        PD_TRY(pdi_tokenizer_read_integer(s, "the dimension of a block", 0, 3, &value));
        PD_TRY(pdi_tokenizer_read_integer(s, "the entity of a block", -PDI_GMSH_MAX_ID, PDI_GMSH_MAX_ID, &value));
        PD_TRY(pdi_tokenizer_read_integer(s, "whether a block has parameters", 0, 1, &value));
        const char *at = s->position;
        PD_TRY(pdi_tokenizer_read_integer(s, "the number of nodes of a block", 0, PDI_GMSH_MAX_ID, &count));
        if (count > m->node_count - done)
            return pdi_tokenizer_fail(s, at, "blocks with more than the %.0f nodes of the section",
                                      (double)m->node_count);
        for (int64_t k = 0; k < count; k++)
            PD_TRY(pdi_tokenizer_read_integer(s, "a node", 1, PDI_GMSH_MAX_ID, &m->node[done + k].id));
        for (int64_t k = 0; k < count; k++) {
            PD_TRY(pdi_gmsh_read_coordinates(m, &m->node[done + k]));
            pdi_tokenizer_skip_line(s);
        }
        done += count;
    }
    if (done == m->node_count) return PD_OK;
    return pdi_tokenizer_fail(s, s->position, "%.0f nodes in blocks, expected %.0f", (double)done,
                              (double)m->node_count);
}

/* Read the section $Nodes to its end mark into new memory, sort the nodes by id, and set the extent of the cells: the
 * largest distance from the node of the lowest id along an axis, in units of the file. PD_ERR_PARSE: an id twice, a
 * second such section, or a fault. */
static pd_status pdi_gmsh_read_nodes(pdi_gmsh_reader *m)
{
    int64_t blocks = 0, bound;
    pdi_tokenizer *s = m->tokenizer;
    const char *begin = s->position;
    if (m->has_nodes++) return pdi_tokenizer_fail(s, begin, "a second section $Nodes");
    if (m->version == 4) PD_TRY(pdi_tokenizer_read_count(s, "the number of blocks", 4, &blocks));
    PD_TRY(pdi_tokenizer_read_count(s, "the number of nodes", 8, &m->node_count));
    for (int k = 0; m->version == 4 && k < 2; k++)
        PD_TRY(pdi_tokenizer_read_integer(s, "the bounds of nodes", 0, PDI_GMSH_MAX_ID, &bound));
    PD_TRY(PD_NEW(s->ctx, "msh", m->node_count, m->node));
    if (m->version == 4) PD_TRY(pdi_gmsh_read_node_blocks(m, blocks));
    for (int64_t k = 0; m->version == 2 && k < m->node_count; k++) {
        PD_TRY(pdi_tokenizer_read_integer(s, "a node", 1, PDI_GMSH_MAX_ID, &m->node[k].id));
        PD_TRY(pdi_gmsh_read_coordinates(m, &m->node[k]));
    }
    PD_TRY(pdi_tokenizer_expect_word(s, "$EndNodes"));
    qsort(m->node, (size_t)m->node_count, sizeof *m->node, pdi_gmsh_compare_nodes);
    for (int64_t k = 0; k < m->node_count; k++) {
        if (k && m->node[k].id == m->node[k - 1].id)
            return pdi_tokenizer_fail(s, begin, "two nodes with the number %.0f", (double)m->node[k].id);
        for (int d = 0; d < 3; d++) m->cells.extent = pd_max(m->cells.extent, fabs(m->node[k].x[d] - m->node[0].x[d]));
    }
    return PD_OK;
}

/* ---- $Elements ---- */

/* Cell type of a Gmsh element type, and its dimension, -1 when unknown. PD_POINTS_CELL_NONE: not supported. */
static pd_points_cell_type pdi_gmsh_find_cell_type(int64_t type, int *dimension)
{
    static const int8_t of[32] = {-1, 1, 2, 2, 3, 3, 3, 3, 1, 2, 2, 3, 3, 3, 3, 0,
                                  2,  3, 3, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 3, 3, 3};
    *dimension = type > 0 && type < 32 ? of[type] : -1;
    return type >= 1 && type <= 7 ? (pd_points_cell_type)type : PD_POINTS_CELL_NONE;
}

/* *is_used 1: elements of this type have PD_DIM dimensions and become points; 0: they have fewer and are skipped.
 * position: for the message. PD_ERR_PARSE: an unknown type, one of more dimensions, or a used one of higher order. */
static pd_status pdi_gmsh_check_element_type(pdi_gmsh_reader *m, const char *position, int64_t type, int *is_used)
{
    int dimension;
    pd_points_cell_type form = pdi_gmsh_find_cell_type(type, &dimension);
    *is_used = dimension == PD_DIM;
    if (dimension < 0)
        return pdi_tokenizer_fail(m->tokenizer, position, "elements of type %.0f, which is not known", (double)type);
    if (dimension > PD_DIM)
        return pdi_tokenizer_fail(m->tokenizer, position, "elements of %dD in a program of %dD", dimension, PD_DIM);
    if (*is_used && form == PD_POINTS_CELL_NONE)
        return pdi_tokenizer_fail(m->tokenizer, position,
                                  "elements of type %.0f, expected straight ones: save the mesh with order 1",
                                  (double)type);
    return PD_OK;
}

/* Slot of the hash table that holds a cell, or the empty one where it belongs. */
static pdi_gmsh_cell_key *pdi_gmsh_find_slot(const pdi_gmsh_reader *m, const pdi_gmsh_cell_key *key)
{
    uint64_t hash = 0;
    for (int k = 0; k < 8; k++) hash = (hash ^ (uint64_t)key->node[k]) * UINT64_C(0x9e3779b97f4a7c15);
    int64_t at = (int64_t)(hash >> 20) & (m->slot_count - 1);
    while (m->slot[at].node[0] && memcmp(&m->slot[at], key, sizeof *key) != 0) at = (at + 1) & (m->slot_count - 1);
    return &m->slot[at];
}

/* Make room for one more cell in the hash table: where it is half full, enter all cells into a new one of twice the
 * size (1024 at first). */
static pd_status pdi_gmsh_grow_hash_table(pdi_gmsh_reader *m)
{
    pdi_gmsh_reader larger = *m;
    if (2 * m->key_count < m->slot_count) return PD_OK;
    larger.slot_count = m->slot_count ? 2 * m->slot_count : 1024;
    larger.slot = NULL;
    PD_TRY(PD_NEW(m->tokenizer->ctx, "mesh", larger.slot_count, larger.slot));
    for (int64_t k = 0; k < m->slot_count; k++)
        if (m->slot[k].node[0]) *pdi_gmsh_find_slot(&larger, &m->slot[k]) = m->slot[k];
    PD_DELETE(m->tokenizer->ctx, m->slot_count, m->slot);
    m->slot_count = larger.slot_count;
    m->slot = larger.slot;
    return PD_OK;
}

/* Enter a cell into the hash table. node_index: indices of its corners in the list of nodes, plus 1. *is_repeated 1: a
 * cell of these nodes has been read before (Gmsh repeats a cell for each of its groups). */
static pd_status pdi_gmsh_add_cell_key(pdi_gmsh_reader *m, pd_points_cell_type form, const int32_t *node_index,
                                       int *is_repeated)
{
    pdi_gmsh_cell_key key;
    memset(&key, 0, sizeof key);
    PD_TRY(pdi_gmsh_grow_hash_table(m));
    for (int k = 0; k < pd_points_count_corners(form); k++) {
        int to = k;
        for (; to > 0 && key.node[to - 1] > node_index[k]; to--) key.node[to] = key.node[to - 1];
        key.node[to] = node_index[k];
    }
    pdi_gmsh_cell_key *slot = pdi_gmsh_find_slot(m, &key);
    *is_repeated = slot->node[0] != 0;
    if (!*is_repeated) m->key_count++;
    *slot = key;
    return PD_OK;
}

/* Read the nodes of a cell from the rest of its line, and add its point and faces; of a cell that has been read before
 * orientation and shape are checked alone. surface: its entity; the orientation that later cells must share begins anew
 * where it changes. PD_ERR_PARSE: an unknown node, text behind the nodes, or what pd_points_add_cell refuses: folded,
 * without volume, off the line or plane, of the other orientation. */
static pd_status pdi_gmsh_read_cell(pdi_gmsh_reader *m, pd_points_cell_type form, int64_t surface, int32_t tag)
{
    const double *corner[8];
    int64_t node[8];
    int32_t node_index[8];
    int again;
    const char *begin = m->tokenizer->position, *fault;
    for (int k = 0; k < pd_points_count_corners(form); k++) {
        pdi_gmsh_node key;
        PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "a node of an element", 1, PDI_GMSH_MAX_ID, &key.id));
        const void *found =
            m->node_count ? bsearch(&key, m->node, (size_t)m->node_count, sizeof key, pdi_gmsh_compare_nodes) : NULL;
        if (!found)
            return pdi_tokenizer_fail(m->tokenizer, begin, "an element with the unknown node %.0f", (double)key.id);
        corner[k] = ((const pdi_gmsh_node *)found)->x;
        node[k] = key.id;
        node_index[k] = (int32_t)((const pdi_gmsh_node *)found - m->node) + 1;
    }
    PD_TRY(pdi_gmsh_add_cell_key(m, form, node_index, &again));
    if (surface != m->previous_entity) m->cells.orientation = 0.0;
    m->previous_entity = surface;
    PD_TRY(pd_points_add_cell(m->tokenizer->ctx, &m->cells, form, corner, 0, tag, &fault));
    if (fault) return pdi_tokenizer_fail(m->tokenizer, begin, "%s", fault);
    if (again) m->cells.points->count--; /* it was added to check its orientation only */
    else
        PD_TRY(
            pd_boundary_faces_add_cell(m->tokenizer->ctx, &m->faces, form, node, corner, m->cells.points->count - 1));
    if (pdi_tokenizer_skip_line(m->tokenizer)) return PD_OK;
    return pdi_tokenizer_fail(m->tokenizer, begin, "an element that does not end with its node %d",
                              pd_points_count_corners(form));
}

/* Read an element of format 2.2: number, type, tags (physical group, then entity, taken without sign; 0 where missing),
 * nodes. It becomes a point where it has PD_DIM dimensions; one of fewer is skipped. PD_ERR_PARSE: its type or its cell
 * is refused. */
static pd_status pdi_gmsh_read_element(pdi_gmsh_reader *m)
{
    int64_t id, type, count, tag[2] = {0, 0}, value;
    int counts;
    PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "an element", 0, PDI_GMSH_MAX_ID, &id));
    const char *at = m->tokenizer->position;
    PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "the type of an element", 0, PDI_GMSH_MAX_ID, &type));
    PD_TRY(pdi_gmsh_check_element_type(m, at, type, &counts));
    if (counts) {
        PD_TRY(pdi_tokenizer_read_count(m->tokenizer, "the number of tags", 2, &count));
        for (int64_t k = 0; k < count; k++) {
            PD_TRY(pdi_tokenizer_read_integer(m->tokenizer, "a tag", -INT32_MAX, INT32_MAX, &value));
            if (k < 2) tag[k] = value < 0 ? -value : value;
        }
        return pdi_gmsh_read_cell(m, pdi_gmsh_find_cell_type(type, &counts), tag[1], (int32_t)tag[0]);
    }
    pdi_tokenizer_skip_line(m->tokenizer);
    return PD_OK;
}

/* Read a block of elements of format 4.1; those of PD_DIM dimensions become points with the group of their entity (0
 * without a section $Entities), those of fewer are skipped. *remaining: number of elements that remain in the section,
 * reduced by those of the block. PD_ERR_PARSE: more than remain, an entity that $Entities lacks, or a type or cell that
 * is refused. */
static pd_status pdi_gmsh_read_element_block(pdi_gmsh_reader *m, int64_t *remaining)
{
    int64_t dimension, type, count, id;
    int counts, known;
    pdi_gmsh_entity key, *found = NULL;
    pdi_tokenizer *s = m->tokenizer;
    PD_TRY(pdi_tokenizer_read_integer(s, "the dimension of a block", 0, 3, &dimension));
    const char *at = s->position;
    PD_TRY(pdi_tokenizer_read_integer(s, "the entity of a block", -PDI_GMSH_MAX_ID, PDI_GMSH_MAX_ID, &key.id));
    PD_TRY(pdi_tokenizer_read_integer(s, "the type of elements", 0, PDI_GMSH_MAX_ID, &type));
    PD_TRY(pdi_gmsh_check_element_type(m, at, type, &counts));
    PD_TRY(pdi_tokenizer_read_integer(s, "the number of elements of a block", 0, PDI_GMSH_MAX_ID, &count));
    if (count > *remaining) return pdi_tokenizer_fail(s, at, "blocks with more elements than their section");
    *remaining -= count;
    if (counts && m->entity_count)
        found =
            (pdi_gmsh_entity *)bsearch(&key, m->entity, (size_t)m->entity_count, sizeof key, pdi_gmsh_compare_entities);
    if (counts && m->has_entities && !found)
        return pdi_tokenizer_fail(s, at, "elements of the entity %.0f, which $Entities does not have", (double)key.id);
    for (int64_t k = 0; k < count; k++) {
        PD_TRY(pdi_tokenizer_read_integer(s, "an element", 0, PDI_GMSH_MAX_ID, &id));
        if (counts)
            PD_TRY(pdi_gmsh_read_cell(m, pdi_gmsh_find_cell_type(type, &known), key.id, found ? found->tag : 0));
        else pdi_tokenizer_skip_line(s);
    }
    return PD_OK;
}

/* Read the section $Elements to its end mark. PD_ERR_PARSE: it comes before $Nodes or a second time, its blocks hold
 * more or fewer elements than it says, or an element is refused. */
static pd_status pdi_gmsh_read_elements(pdi_gmsh_reader *m)
{
    int64_t blocks = 0, count, bound;
    pdi_tokenizer *s = m->tokenizer;
    if (!m->has_nodes) return pdi_tokenizer_fail(s, s->position, "$Elements before $Nodes");
    if (m->has_elements++) return pdi_tokenizer_fail(s, s->position, "a second section $Elements");
    m->previous_entity = -1;
    if (m->version == 4) PD_TRY(pdi_tokenizer_read_count(s, "the number of blocks", 4, &blocks));
    PD_TRY(pdi_tokenizer_read_count(s, "the number of elements", 4, &count));
    for (int k = 0; m->version == 4 && k < 2; k++)
        PD_TRY(pdi_tokenizer_read_integer(s, "the bounds of elements", 0, PDI_GMSH_MAX_ID, &bound));
    for (int64_t b = 0; b < blocks; b++) PD_TRY(pdi_gmsh_read_element_block(m, &count));
    for (int64_t k = 0; m->version == 2 && k < count; k++) PD_TRY(pdi_gmsh_read_element(m));
    if (m->version == 4 && count)
        return pdi_tokenizer_fail(s, s->position, "%.0f elements too few in blocks", (double)count);
    return pdi_tokenizer_expect_word(s, "$EndElements");
}

/* ---- sections ---- */

/* Skip an unused section name[size], with its '$', up to its end mark. PD_ERR_PARSE: it has none. */
static pd_status pdi_gmsh_skip_section(pdi_gmsh_reader *m, const char *name, size_t size)
{
    const char *word;
    for (size_t length; (length = pdi_tokenizer_read_word(m->tokenizer, &word)) > 0;)
        if (length == size + 3 && memcmp(word, "$End", 4) == 0 && memcmp(word + 4, name + 1, size - 1) == 0)
            return PD_OK;
    return pdi_tokenizer_fail(m->tokenizer, name, "the section %.*s has no end", size < 40 ? (int)size : 40, name);
}

/* Read all sections of the file, $MeshFormat first; unknown ones are skipped, as is $Entities of format 2.2.
 * PD_ERR_PARSE: no section $Elements, text outside of sections, a section without an end, a partitioned or parametric
 * mesh. */
static pd_status pdi_gmsh_read_sections(pdi_gmsh_reader *m)
{
    const char *word;
    PD_TRY(pdi_tokenizer_expect_word(m->tokenizer, "$MeshFormat"));
    PD_TRY(pdi_gmsh_read_format(m));
    for (size_t size; (size = pdi_tokenizer_read_word(m->tokenizer, &word)) > 0;) {
        if (word[0] != '$') return pdi_tokenizer_fail(m->tokenizer, word, "text outside of sections");
        if (pdi_tokenizer_is_word(m->tokenizer, word, size, "$Nodes")) PD_TRY(pdi_gmsh_read_nodes(m));
        else if (pdi_tokenizer_is_word(m->tokenizer, word, size, "$Elements")) PD_TRY(pdi_gmsh_read_elements(m));
        else if (pdi_tokenizer_is_word(m->tokenizer, word, size, "$Entities") && m->version == 4)
            PD_TRY(pdi_gmsh_read_entities(m));
        else if (pdi_tokenizer_is_word(m->tokenizer, word, size, "$ParametricNodes"))
            return pdi_tokenizer_fail(m->tokenizer, word,
                                      "$ParametricNodes, expected $Nodes: save the mesh with "
                                      "Mesh.SaveParametric = 0");
        else if (pdi_tokenizer_is_word(m->tokenizer, word, size, "$PartitionedEntities"))
            return pdi_tokenizer_fail(m->tokenizer, word, "a partitioned mesh, expected one in one piece");
        else PD_TRY(pdi_gmsh_skip_section(m, word, size));
    }
    if (!m->has_elements)
        return pdi_tokenizer_fail(m->tokenizer, m->tokenizer->end, "the file has no section $Elements");
    return PD_OK;
}

PDI_FN pd_status pdi_gmsh_read(pdi_tokenizer *scan, double scale, pd_points *points)
{
    pdi_gmsh_reader m;
    memset(&m, 0, sizeof m);
    m.tokenizer = scan;
    m.cells.points = points;
    m.cells.scale = scale;
    pd_status status = pdi_gmsh_read_sections(&m);
    if (status == PD_OK) status = pd_boundary_faces_finish(scan->ctx, &m.faces, scale, points);
    pd_boundary_faces_free(scan->ctx, &m.faces);
    PD_DELETE(scan->ctx, m.node_count, m.node);
    PD_DELETE(scan->ctx, m.entity_count, m.entity);
    PD_DELETE(scan->ctx, m.slot_count, m.slot);
    return status;
}

#undef PDI_GMSH_MAX_ID
