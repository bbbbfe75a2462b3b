/* msh: see msh.h */
#include "io/msh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Largest number of a node or an entity. */
#define PDI_MSH_MOST 999999999999999

typedef struct pdi_msh_node {
    int64_t id;
    double x[3];
} pdi_msh_node;

/* An entity of PD_DIM dimensions and its group. */
typedef struct pdi_msh_entity {
    int64_t id;
    int32_t tag;
} pdi_msh_entity;

/* The nodes of a cell: their places in the list plus 1, ascending; 0: there are no more. */
typedef struct pdi_msh_cell_key {
    int32_t node[8];
} pdi_msh_cell_key;

typedef struct pdi_msh {
    pdi_scan *scan;
    pdi_cells cells;
    pdi_skin skin;
    int version; /* 2 or 4 */
    int64_t nodes, entities;
    pdi_msh_node *node;     /* [nodes] by id */
    pdi_msh_entity *entity; /* [entities] by id */
    int has_nodes, has_entities, has_elements;
    int64_t surface; /* of the cell before */
    int64_t known, slots;
    pdi_msh_cell_key *slot; /* [slots] cells by a hash of their nodes, at most half of them in use */
} pdi_msh;

static int pdi_msh_compare(const void *a, const void *b)
{
    const pdi_msh_node *p = (const pdi_msh_node *)a, *q = (const pdi_msh_node *)b;
    return (p->id > q->id) - (p->id < q->id);
}

static int pdi_msh_compare_entities(const void *a, const void *b)
{
    const pdi_msh_entity *p = (const pdi_msh_entity *)a, *q = (const pdi_msh_entity *)b;
    return (p->id > q->id) - (p->id < q->id);
}

/* Whole numbers and others that are read and left. */
static pd_status pdi_msh_pass(pdi_msh *m, const char *what, int64_t count)
{
    double value;
    for (int64_t k = 0; k < count; k++) PDI_TRY(pdi_scan_number(m->scan, what, &value));
    return PD_OK;
}

/* ---- $MeshFormat, $Entities, $Nodes ---- */

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

/* Numbers of groups, the first one of them into *tag. */
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

static pd_status pdi_msh_place(pdi_msh *m, pdi_msh_node *node)
{
    for (int d = 0; d < 3; d++) {
        PDI_TRY(pdi_scan_number(m->scan, "a coordinate", &node->x[d]));
        if (!(fabs(node->x[d]) < 1e100))
            return pdi_scan_fail(m->scan, m->scan->at, "the coordinate %g, expected less than 1e100", node->x[d]);
    }
    return PD_OK;
}

/* Blocks of 4.1: ids, then places, which parameters may follow on their line. */
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

/* The form of a type of elements, and its dimension: -1 where it is not known. */
static pdi_cell_form pdi_msh_form(int64_t type, int *dimension)
{
    static const int8_t of[32] = {-1, 1, 2, 2, 3, 3, 3, 3, 1, 2, 2, 3, 3, 3, 3, 0,
                                  2,  3, 3, 3, 2, 2, 2, 2, 2, 2, 1, 1, 1, 3, 3, 3};
    *dimension = type > 0 && type < 32 ? of[type] : -1;
    return type >= 1 && type <= 7 ? (pdi_cell_form)type : PDI_CELL_NONE;
}

/* 1: cells of this type count. PD_ERR_PARSE: they ought to, and cannot. */
static pd_status pdi_msh_counts(pdi_msh *m, const char *at, int64_t type, int *counts)
{
    int dimension;
    pdi_cell_form form = pdi_msh_form(type, &dimension);
    *counts = dimension == PD_DIM;
    if (dimension < 0) return pdi_scan_fail(m->scan, at, "elements of type %.0f, which is not known", (double)type);
    if (dimension > PD_DIM) return pdi_scan_fail(m->scan, at, "elements of %dD in a program of %dD", dimension, PD_DIM);
    if (*counts && form == PDI_CELL_NONE)
        return pdi_scan_fail(m->scan, at, "elements of type %.0f, expected straight ones: save the mesh with order 1",
                             (double)type);
    return PD_OK;
}

/* Where a cell is, or would be. */
static pdi_msh_cell_key *pdi_msh_slot(const pdi_msh *m, const pdi_msh_cell_key *key)
{
    uint64_t hash = 0;
    for (int k = 0; k < 8; k++) hash = (hash ^ (uint64_t)key->node[k]) * UINT64_C(0x9e3779b97f4a7c15);
    int64_t at = (int64_t)(hash >> 20) & (m->slots - 1);
    while (m->slot[at].node[0] && memcmp(&m->slot[at], key, sizeof *key) != 0) at = (at + 1) & (m->slots - 1);
    return &m->slot[at];
}

/* Room for one more cell. */
static pd_status pdi_msh_widen(pdi_msh *m)
{
    pdi_msh wider = *m;
    if (2 * m->known < m->slots) return PD_OK;
    wider.slots = m->slots ? 2 * m->slots : 1024;
    wider.slot = NULL;
    PDI_TRY(PDI_NEW(m->scan->ctx, "mesh", wider.slots, wider.slot));
    for (int64_t k = 0; k < m->slots; k++)
        if (m->slot[k].node[0]) *pdi_msh_slot(&wider, &m->slot[k]) = m->slot[k];
    PDI_DELETE(m->scan->ctx, m->slots, m->slot);
    m->slots = wider.slots;
    m->slot = wider.slot;
    return PD_OK;
}

/* *again: a cell of these nodes has been read: files of Gmsh repeat a cell for each group that it is in. */
static pd_status pdi_msh_repeats(pdi_msh *m, pdi_cell_form form, const int32_t *place, int *again)
{
    pdi_msh_cell_key key;
    memset(&key, 0, sizeof key);
    PDI_TRY(pdi_msh_widen(m));
    for (int k = 0; k < pdi_points_corners(form); k++) {
        int to = k;
        for (; to > 0 && key.node[to - 1] > place[k]; to--) key.node[to] = key.node[to - 1];
        key.node[to] = place[k];
    }
    pdi_msh_cell_key *slot = pdi_msh_slot(m, &key);
    *again = slot->node[0] != 0;
    if (!*again) m->known++;
    *slot = key;
    return PD_OK;
}

/* The rest of a line: the corners of a cell of `surface`, and the cell. */
static pd_status pdi_msh_cell(pdi_msh *m, pdi_cell_form form, int64_t surface, int32_t tag)
{
    const double *corner[8];
    int64_t node[8];
    int32_t place[8];
    int again;
    const char *begin = m->scan->at, *fault;
    for (int k = 0; k < pdi_points_corners(form); k++) {
        pdi_msh_node key;
        PDI_TRY(pdi_scan_integer(m->scan, "a node of an element", 1, PDI_MSH_MOST, &key.id));
        const void *found = m->nodes ? bsearch(&key, m->node, (size_t)m->nodes, sizeof key, pdi_msh_compare) : NULL;
        if (!found) return pdi_scan_fail(m->scan, begin, "an element with the unknown node %.0f", (double)key.id);
        corner[k] = ((const pdi_msh_node *)found)->x;
        node[k] = key.id;
        place[k] = (int32_t)((const pdi_msh_node *)found - m->node) + 1;
    }
    PDI_TRY(pdi_msh_repeats(m, form, place, &again));
    if (surface != m->surface) m->cells.sign = 0.0;
    m->surface = surface;
    PDI_TRY(pdi_cells_add(m->scan->ctx, &m->cells, form, corner, 0, tag, &fault));
    if (fault) return pdi_scan_fail(m->scan, begin, "%s", fault);
    if (again) m->cells.points->count--; /* it had to be looked at: it may be turned */
    else PDI_TRY(pdi_skin_add(m->scan->ctx, &m->skin, form, node, corner, m->cells.points->count - 1));
    if (pdi_scan_line(m->scan)) return PD_OK;
    return pdi_scan_fail(m->scan, begin, "an element that does not end with its node %d", pdi_points_corners(form));
}

/* Lines of 2.2: number, type, groups, nodes. */
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

/* A block of 4.1; *left: elements that the section still has. */
static pd_status pdi_msh_block(pdi_msh *m, int64_t *left)
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
    if (count > *left) return pdi_scan_fail(s, at, "blocks with more elements than their section");
    *left -= count;
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

/* Go behind the end of a section that nothing is wanted from. */
static pd_status pdi_msh_skip(pdi_msh *m, const char *name, size_t size)
{
    const char *word;
    for (size_t length; (length = pdi_scan_word(m->scan, &word)) > 0;)
        if (length == size + 3 && memcmp(word, "$End", 4) == 0 && memcmp(word + 4, name + 1, size - 1) == 0)
            return PD_OK;
    return pdi_scan_fail(m->scan, name, "the section %.*s has no end", size < 40 ? (int)size : 40, name);
}

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
