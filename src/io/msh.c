/* msh: see msh.h */
#include "io/msh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Largest number (id) of a node or an entity. */
#define PDI_MSH_MOST 999999999999999

/* A node of the mesh. */
typedef struct pdi_msh_node {
    int64_t id;
    double x[3]; /* in units of the file */
} pdi_msh_node;

/* A geometric entity of PD_DIM dimensions and its physical group. */
typedef struct pdi_msh_entity {
    int64_t id;
    int32_t tag;
} pdi_msh_entity;

/* Key of a cell in the hash table: its nodes, as indices in the list of nodes plus 1, ascending; 0: unused. */
typedef struct pdi_msh_cell_key {
    int32_t node[8];
} pdi_msh_cell_key;

/* State of reading a file. */
typedef struct pdi_msh {
    pdi_scan *scan;
    pdi_cells cells; /* conversion of cells to points */
    pdi_skin skin;   /* faces of the cells */
    int version;     /* 2: format 2.2, 4: format 4.1 */
    int64_t nodes, entities; /* number of them */
    pdi_msh_node *node;     /* [nodes] by id */
    pdi_msh_entity *entity; /* [entities] by id */
    int has_nodes, has_entities, has_elements; /* number of these sections so far */
    int64_t surface; /* entity of the previous cell */
    int64_t known, slots; /* number of cells in the hash table, and its size, a power of two */
    pdi_msh_cell_key *slot; /* [slots] hash table of cells by their nodes, at most half full */
} pdi_msh;

/* Order of nodes by id, for qsort and bsearch. */
static int pdi_msh_compare(const void *a, const void *b)
{
    const pdi_msh_node *p = (const pdi_msh_node *)a, *q = (const pdi_msh_node *)b;
    return (p->id > q->id) - (p->id < q->id);
}

/* Order of entities by id, for qsort and bsearch. */
static int pdi_msh_compare_entities(const void *a, const void *b)
{
    const pdi_msh_entity *p = (const pdi_msh_entity *)a, *q = (const pdi_msh_entity *)b;
    return (p->id > q->id) - (p->id < q->id);
}

/* Skip `count` numbers. what: their name for messages. */
static pd_status pdi_msh_pass(pdi_msh *m, const char *what, int64_t count)
{
    double value;
    for (int64_t k = 0; k < count; k++) PDI_TRY(pdi_scan_number(m->scan, what, &value));
    return PD_OK;
}

/* ---- $MeshFormat, $Entities, $Nodes ---- */

/* Read the section $MeshFormat: version and file type. */
static pd_status pdi_msh_format(pdi_msh *m)
{
    const char *at = m->scan->at;
    double version;
    int64_t binary, bytes;
    PDI_TRY(pdi_scan_number(m->scan, "the version", &version));
    m->version = fabs(version - 2.2) < 1e-9 ? 2 : fabs(version - 4.1) < 1e-9 ? 4 : 0;
    if (!m->version) return pdi_scan_fail(m->scan, at, "MSH version %g, expected 2.2 or 4.1", version);
    PDI_TRY(pdi_scan_integer(m->scan, "the file type", 0, 1, &binary));
    PDI_TRY(pdi_scan_integer(m->scan, "the size of numbers", 1, 16, &bytes));
    if (binary) return pdi_scan_fail(m->scan, at, "a binary file, expected text: save it with Mesh.Binary = 0");
    return pdi_scan_expect(m->scan, "$EndMeshFormat");
}

/* Read the list of physical groups of an entity; *tag: the first one, 0 without any. */
static pd_status pdi_msh_groups(pdi_msh *m, int64_t *tag)
{
    int64_t count, group;
    *tag = 0;
    PDI_TRY(pdi_scan_count(m->scan, "the number of groups", 2, &count));
    for (int64_t k = 0; k < count; k++) {
        PDI_TRY(pdi_scan_integer(m->scan, "a group", -INT32_MAX, INT32_MAX, &group));
        if (k == 0) *tag = group < 0 ? -group : group;
    }
    return PD_OK;
}

/* Read the section $Entities of format 4.1, and keep the groups of entities of PD_DIM dimensions. */
static pd_status pdi_msh_entities(pdi_msh *m)
{
    int64_t count[4], id, tag, bounds;
    pdi_scan *s = m->scan;
    const char *begin = s->at;
    if (m->has_entities++) return pdi_scan_fail(s, begin, "a second section $Entities");
    for (int d = 0; d < 4; d++) PDI_TRY(pdi_scan_count(s, "the number of entities", 10, &count[d]));
    m->entities = count[PD_DIM];
    PDI_TRY(PDI_NEW(s->ctx, "msh", m->entities, m->entity));
    for (int d = 0; d < 4; d++)
        for (int64_t k = 0; k < count[d]; k++) {
            PDI_TRY(pdi_scan_integer(s, "an entity", -PDI_MSH_MOST, PDI_MSH_MOST, &id));
            PDI_TRY(pdi_msh_pass(m, "the extent of an entity", d ? 6 : 3));
            PDI_TRY(pdi_msh_groups(m, &tag));
            if (d) PDI_TRY(pdi_scan_count(s, "the number of its bounds", 2, &bounds));
            if (d) PDI_TRY(pdi_msh_pass(m, "a bound of an entity", bounds));
            if (d != PD_DIM) continue;
            m->entity[k].id = id;
            m->entity[k].tag = (int32_t)tag;
        }
    qsort(m->entity, (size_t)m->entities, sizeof *m->entity, pdi_msh_compare_entities);
    return pdi_scan_expect(s, "$EndEntities");
}

/* Read the three coordinates of a node. */
static pd_status pdi_msh_place(pdi_msh *m, pdi_msh_node *node)
{
    for (int d = 0; d < 3; d++) {
        PDI_TRY(pdi_scan_number(m->scan, "a coordinate", &node->x[d]));
        if (!(fabs(node->x[d]) < 1e100))
            return pdi_scan_fail(m->scan, m->scan->at, "the coordinate %g, expected less than 1e100", node->x[d]);
    }
    return PD_OK;
}

/* Read the blocks of nodes of format 4.1: ids, then coordinates, which parameters may follow on their line. */
static pd_status pdi_msh_node_blocks(pdi_msh *m, int64_t blocks)
{
    int64_t value, count, done = 0;
    pdi_scan *s = m->scan;
    for (int64_t b = 0; b < blocks; b++) {
        PDI_TRY(pdi_scan_integer(s, "the dimension of a block", 0, 3, &value));
        PDI_TRY(pdi_scan_integer(s, "the entity of a block", -PDI_MSH_MOST, PDI_MSH_MOST, &value));
        PDI_TRY(pdi_scan_integer(s, "whether a block has parameters", 0, 1, &value));
        const char *at = s->at;
        PDI_TRY(pdi_scan_integer(s, "the number of nodes of a block", 0, PDI_MSH_MOST, &count));
        if (count > m->nodes - done)
            return pdi_scan_fail(s, at, "blocks with more than the %.0f nodes of the section", (double)m->nodes);
        for (int64_t k = 0; k < count; k++)
            PDI_TRY(pdi_scan_integer(s, "a node", 1, PDI_MSH_MOST, &m->node[done + k].id));
        for (int64_t k = 0; k < count; k++) {
            PDI_TRY(pdi_msh_place(m, &m->node[done + k]));
            pdi_scan_line(s);
        }
        done += count;
    }
    if (done == m->nodes) return PD_OK;
    return pdi_scan_fail(s, s->at, "%.0f nodes in blocks, expected %.0f", (double)done, (double)m->nodes);
}

/* Read the section $Nodes, and sort the nodes by id. */
static pd_status pdi_msh_nodes(pdi_msh *m)
{
    int64_t blocks = 0, bound;
    pdi_scan *s = m->scan;
    const char *begin = s->at;
    if (m->has_nodes++) return pdi_scan_fail(s, begin, "a second section $Nodes");
    if (m->version == 4) PDI_TRY(pdi_scan_count(s, "the number of blocks", 4, &blocks));
    PDI_TRY(pdi_scan_count(s, "the number of nodes", 8, &m->nodes));
    for (int k = 0; m->version == 4 && k < 2; k++)
        PDI_TRY(pdi_scan_integer(s, "the bounds of nodes", 0, PDI_MSH_MOST, &bound));
    PDI_TRY(PDI_NEW(s->ctx, "msh", m->nodes, m->node));
    if (m->version == 4) PDI_TRY(pdi_msh_node_blocks(m, blocks));
    for (int64_t k = 0; m->version == 2 && k < m->nodes; k++) {
        PDI_TRY(pdi_scan_integer(s, "a node", 1, PDI_MSH_MOST, &m->node[k].id));
        PDI_TRY(pdi_msh_place(m, &m->node[k]));
    }
    PDI_TRY(pdi_scan_expect(s, "$EndNodes"));
    qsort(m->node, (size_t)m->nodes, sizeof *m->node, pdi_msh_compare);
    for (int64_t k = 0; k < m->nodes; k++) {
        if (k && m->node[k].id == m->node[k - 1].id)
            return pdi_scan_fail(s, begin, "two nodes with the number %.0f", (double)m->node[k].id);
        for (int d = 0; d < 3; d++)
            m->cells.extent = pdi_max(m->cells.extent, fabs(m->node[k].x[d] - m->node[0].x[d]));
    }
    return PD_OK;
}

/* ---- $Elements ---- */

/* Cell type of a Gmsh element type, and its dimension, -1 when unknown. PDI_CELL_NONE: not supported. */
static pdi_cell_form pdi_msh_form(int64_t type, int *dimension)
{
    static const int8_t of[32] = {-1, 1, 2, 2, 3, 3, 3, 3, 1, 2, 2, 3, 3, 3, 3, 0,
                                  2,  3, 3, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 3, 3, 3};
    *dimension = type > 0 && type < 32 ? of[type] : -1;
    return type >= 1 && type <= 7 ? (pdi_cell_form)type : PDI_CELL_NONE;
}

/* *is_used 1: elements of this type become points. PD_ERR_PARSE: unknown, of higher dimension or of higher order. */
static pd_status pdi_msh_counts(pdi_msh *m, const char *position, int64_t type, int *is_used)
{
    int dimension;
    pdi_cell_form form = pdi_msh_form(type, &dimension);
    *is_used = dimension == PD_DIM;
    if (dimension < 0)
        return pdi_scan_fail(m->scan, position, "elements of type %.0f, which is not known", (double)type);
    if (dimension > PD_DIM)
        return pdi_scan_fail(m->scan, position, "elements of %dD in a program of %dD", dimension, PD_DIM);
    if (*is_used && form == PDI_CELL_NONE)
        return pdi_scan_fail(m->scan, position,
                             "elements of type %.0f, expected straight ones: save the mesh with order 1",
                             (double)type);
    return PD_OK;
}

/* Slot of the hash table that holds a cell, or the empty one where it belongs. */
static pdi_msh_cell_key *pdi_msh_slot(const pdi_msh *m, const pdi_msh_cell_key *key)
{
    uint64_t hash = 0;
    for (int k = 0; k < 8; k++) hash = (hash ^ (uint64_t)key->node[k]) * UINT64_C(0x9e3779b97f4a7c15);
    int64_t at = (int64_t)(hash >> 20) & (m->slots - 1);
    while (m->slot[at].node[0] && memcmp(&m->slot[at], key, sizeof *key) != 0) at = (at + 1) & (m->slots - 1);
    return &m->slot[at];
}

/* Make room for one more cell in the hash table: double it when it is half full. */
static pd_status pdi_msh_widen(pdi_msh *m)
{
    pdi_msh larger = *m;
    if (2 * m->known < m->slots) return PD_OK;
    larger.slots = m->slots ? 2 * m->slots : 1024;
    larger.slot = NULL;
    PDI_TRY(PDI_NEW(m->scan->ctx, "mesh", larger.slots, larger.slot));
    for (int64_t k = 0; k < m->slots; k++)
        if (m->slot[k].node[0]) *pdi_msh_slot(&larger, &m->slot[k]) = m->slot[k];
    PDI_DELETE(m->scan->ctx, m->slots, m->slot);
    m->slots = larger.slots;
    m->slot = larger.slot;
    return PD_OK;
}

/* Enter a cell into the hash table. *is_repeated 1: a cell of these nodes has been read before (Gmsh repeats a cell for
 * each of its groups). */
static pd_status pdi_msh_repeats(pdi_msh *m, pdi_cell_form form, const int32_t *node_index, int *is_repeated)
{
    pdi_msh_cell_key key;
    memset(&key, 0, sizeof key);
    PDI_TRY(pdi_msh_widen(m));
    for (int k = 0; k < pdi_points_corners(form); k++) {
        int to = k;
        for (; to > 0 && key.node[to - 1] > node_index[k]; to--) key.node[to] = key.node[to - 1];
        key.node[to] = node_index[k];
    }
    pdi_msh_cell_key *slot = pdi_msh_slot(m, &key);
    *is_repeated = slot->node[0] != 0;
    if (!*is_repeated) m->known++;
    *slot = key;
    return PD_OK;
}

/* Read the nodes of a cell from the rest of its line, and add its point and faces. surface: its entity; within one
 * entity all cells have one orientation. */
static pd_status pdi_msh_cell(pdi_msh *m, pdi_cell_form form, int64_t surface, int32_t tag)
{
    const double *corner[8];
    int64_t node[8];
    int32_t node_index[8];
    int again;
    const char *begin = m->scan->at, *fault;
    for (int k = 0; k < pdi_points_corners(form); k++) {
        pdi_msh_node key;
        PDI_TRY(pdi_scan_integer(m->scan, "a node of an element", 1, PDI_MSH_MOST, &key.id));
        const void *found = m->nodes ? bsearch(&key, m->node, (size_t)m->nodes, sizeof key, pdi_msh_compare) : NULL;
        if (!found) return pdi_scan_fail(m->scan, begin, "an element with the unknown node %.0f", (double)key.id);
        corner[k] = ((const pdi_msh_node *)found)->x;
        node[k] = key.id;
        node_index[k] = (int32_t)((const pdi_msh_node *)found - m->node) + 1;
    }
    PDI_TRY(pdi_msh_repeats(m, form, node_index, &again));
    if (surface != m->surface) m->cells.sign = 0.0;
    m->surface = surface;
    PDI_TRY(pdi_cells_add(m->scan->ctx, &m->cells, form, corner, 0, tag, &fault));
    if (fault) return pdi_scan_fail(m->scan, begin, "%s", fault);
    if (again) m->cells.points->count--; /* it was added to check its orientation only */
    else PDI_TRY(pdi_skin_add(m->scan->ctx, &m->skin, form, node, corner, m->cells.points->count - 1));
    if (pdi_scan_line(m->scan)) return PD_OK;
    return pdi_scan_fail(m->scan, begin, "an element that does not end with its node %d", pdi_points_corners(form));
}

/* Read an element of format 2.2: number, type, tags (physical group first), nodes. */
static pd_status pdi_msh_element(pdi_msh *m)
{
    int64_t id, type, count, tag[2] = {0, 0}, value;
    int counts;
    PDI_TRY(pdi_scan_integer(m->scan, "an element", 0, PDI_MSH_MOST, &id));
    const char *at = m->scan->at;
    PDI_TRY(pdi_scan_integer(m->scan, "the type of an element", 0, PDI_MSH_MOST, &type));
    PDI_TRY(pdi_msh_counts(m, at, type, &counts));
    if (counts) {
        PDI_TRY(pdi_scan_count(m->scan, "the number of tags", 2, &count));
        for (int64_t k = 0; k < count; k++) {
            PDI_TRY(pdi_scan_integer(m->scan, "a tag", -INT32_MAX, INT32_MAX, &value));
            if (k < 2) tag[k] = value < 0 ? -value : value;
        }
        return pdi_msh_cell(m, pdi_msh_form(type, &counts), tag[1], (int32_t)tag[0]);
    }
    pdi_scan_line(m->scan);
    return PD_OK;
}

/* Read a block of elements of format 4.1; *remaining: number of elements that remain in the section. */
static pd_status pdi_msh_block(pdi_msh *m, int64_t *remaining)
{
    int64_t dimension, type, count, id;
    int counts, known;
    pdi_msh_entity key, *found = NULL;
    pdi_scan *s = m->scan;
    PDI_TRY(pdi_scan_integer(s, "the dimension of a block", 0, 3, &dimension));
    const char *at = s->at;
    PDI_TRY(pdi_scan_integer(s, "the entity of a block", -PDI_MSH_MOST, PDI_MSH_MOST, &key.id));
    PDI_TRY(pdi_scan_integer(s, "the type of elements", 0, PDI_MSH_MOST, &type));
    PDI_TRY(pdi_msh_counts(m, at, type, &counts));
    PDI_TRY(pdi_scan_integer(s, "the number of elements of a block", 0, PDI_MSH_MOST, &count));
    if (count > *remaining) return pdi_scan_fail(s, at, "blocks with more elements than their section");
    *remaining -= count;
    if (counts && m->entities)
        found = (pdi_msh_entity *)bsearch(&key, m->entity, (size_t)m->entities, sizeof key, pdi_msh_compare_entities);
    if (counts && m->has_entities && !found)
        return pdi_scan_fail(s, at, "elements of the entity %.0f, which $Entities does not have", (double)key.id);
    for (int64_t k = 0; k < count; k++) {
        PDI_TRY(pdi_scan_integer(s, "an element", 0, PDI_MSH_MOST, &id));
        if (counts) PDI_TRY(pdi_msh_cell(m, pdi_msh_form(type, &known), key.id, found ? found->tag : 0));
        else pdi_scan_line(s);
    }
    return PD_OK;
}

/* Read the section $Elements. */
static pd_status pdi_msh_elements(pdi_msh *m)
{
    int64_t blocks = 0, count, bound;
    pdi_scan *s = m->scan;
    if (!m->has_nodes) return pdi_scan_fail(s, s->at, "$Elements before $Nodes");
    if (m->has_elements++) return pdi_scan_fail(s, s->at, "a second section $Elements");
    m->surface = -1;
    if (m->version == 4) PDI_TRY(pdi_scan_count(s, "the number of blocks", 4, &blocks));
    PDI_TRY(pdi_scan_count(s, "the number of elements", 4, &count));
    for (int k = 0; m->version == 4 && k < 2; k++)
        PDI_TRY(pdi_scan_integer(s, "the bounds of elements", 0, PDI_MSH_MOST, &bound));
    for (int64_t b = 0; b < blocks; b++) PDI_TRY(pdi_msh_block(m, &count));
    for (int64_t k = 0; m->version == 2 && k < count; k++) PDI_TRY(pdi_msh_element(m));
    if (m->version == 4 && count) return pdi_scan_fail(s, s->at, "%.0f elements too few in blocks", (double)count);
    return pdi_scan_expect(s, "$EndElements");
}

/* ---- sections ---- */

/* Skip an unused section to its end. */
static pd_status pdi_msh_skip(pdi_msh *m, const char *name, size_t size)
{
    const char *word;
    for (size_t length; (length = pdi_scan_word(m->scan, &word)) > 0;)
        if (length == size + 3 && memcmp(word, "$End", 4) == 0 && memcmp(word + 4, name + 1, size - 1) == 0)
            return PD_OK;
    return pdi_scan_fail(m->scan, name, "the section %.*s has no end", size < 40 ? (int)size : 40, name);
}

/* Read all sections of the file. */
static pd_status pdi_msh_sections(pdi_msh *m)
{
    const char *word;
    PDI_TRY(pdi_scan_expect(m->scan, "$MeshFormat"));
    PDI_TRY(pdi_msh_format(m));
    for (size_t size; (size = pdi_scan_word(m->scan, &word)) > 0;) {
        if (word[0] != '$') return pdi_scan_fail(m->scan, word, "text outside of sections");
        if (pdi_scan_is(m->scan, word, size, "$Nodes")) PDI_TRY(pdi_msh_nodes(m));
        else if (pdi_scan_is(m->scan, word, size, "$Elements")) PDI_TRY(pdi_msh_elements(m));
        else if (pdi_scan_is(m->scan, word, size, "$Entities") && m->version == 4) PDI_TRY(pdi_msh_entities(m));
        else if (pdi_scan_is(m->scan, word, size, "$ParametricNodes"))
            return pdi_scan_fail(m->scan, word, "$ParametricNodes, expected $Nodes: save the mesh with "
                                 "Mesh.SaveParametric = 0");
        else if (pdi_scan_is(m->scan, word, size, "$PartitionedEntities"))
            return pdi_scan_fail(m->scan, word, "a partitioned mesh, expected one in one piece");
        else PDI_TRY(pdi_msh_skip(m, word, size));
    }
    if (!m->has_elements) return pdi_scan_fail(m->scan, m->scan->end, "the file has no section $Elements");
    return PD_OK;
}

PDI_FN pd_status pdi_msh_read(pdi_scan *scan, double scale, pd_points *points)
{
    pdi_msh m;
    memset(&m, 0, sizeof m);
    m.scan = scan;
    m.cells.points = points;
    m.cells.scale = scale;
    pd_status status = pdi_msh_sections(&m);
    if (status == PD_OK) status = pdi_skin_close(scan->ctx, &m.skin, scale, points);
    pdi_skin_free(scan->ctx, &m.skin);
    PDI_DELETE(scan->ctx, m.nodes, m.node);
    PDI_DELETE(scan->ctx, m.entities, m.entity);
    PDI_DELETE(scan->ctx, m.slots, m.slot);
    return status;
}

#undef PDI_MSH_MOST
