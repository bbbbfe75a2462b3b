/* archive_file: see archive_file.h */
#include "io/archive_file.h"
#include "io/zlib.h"
#include <string.h>

#define PDI_ARCHIVE_FILE_MAGIC "PDSTORE\n"
#define PDI_ARCHIVE_FILE_BYTE_ORDER_MARK 0x01020304u /* byte order mark */
#define PDI_ARCHIVE_FILE_SWAPPED_MARK 0x04030201u    /* that mark in the other byte order */
#define PDI_ARCHIVE_FILE_HEADER_SIZE 64              /* [byte] length of the file header */
#define PDI_ARCHIVE_FILE_ITEM_HEADER_SIZE 64         /* [byte] length of an item header, before the elements */
#define PDI_ARCHIVE_FILE_END_NAME "end"

/* Offsets [byte] of the numbers in the file header and in item headers; each header ends with its checksum. */
enum {
    PDI_ARCHIVE_FILE_OFFSET_ORDER = 8,
    PDI_ARCHIVE_FILE_OFFSET_FORMAT = 12,
    PDI_ARCHIVE_FILE_OFFSET_DIM = 16,
    PDI_ARCHIVE_FILE_OFFSET_VERSION = 24
};
enum { PDI_ARCHIVE_FILE_OFFSET_COUNT = PD_ARCHIVE_FILE_NAME_SIZE, PDI_ARCHIVE_FILE_OFFSET_SIZE = 56 };

/* Header of an item. */
typedef struct pdi_archive_file_item {
    char name[PD_ARCHIVE_FILE_NAME_SIZE];
    uint64_t count;        /* number of elements */
    uint32_t element_size; /* [byte] of an element */
} pdi_archive_file_item;

/* ---- file header and item headers ---- */

/* Read a 32-bit number in the byte order of the machine. */
static uint32_t pdi_archive_file_get_u32(const uint8_t *bytes)
{
    uint32_t word;
    memcpy(&word, bytes, sizeof word);
    return word;
}

/* Write a 32-bit number in the byte order of the machine. */
static void pdi_archive_file_put_u32(uint8_t *bytes, uint32_t word) { memcpy(bytes, &word, sizeof word); }

/* Set the CRC-32 in the last four bytes of a header of `size` bytes. */
static void pdi_archive_file_set_checksum(uint8_t *head, size_t size)
{
    pdi_archive_file_put_u32(head + size - 4, pdi_zlib_crc32(0, head, size - 4));
}

/* Returns 1 when the CRC-32 in the last four bytes of a header of `size` bytes is right, else 0. */
static int pdi_archive_file_is_checksum_valid(const uint8_t *head, size_t size)
{
    return pdi_archive_file_get_u32(head + size - 4) == pdi_zlib_crc32(0, head, size - 4);
}

/* Fill in the file header of this version, dimension and byte order. */
static void pdi_archive_file_init_header(uint8_t head[PDI_ARCHIVE_FILE_HEADER_SIZE])
{
    memset(head, 0, PDI_ARCHIVE_FILE_HEADER_SIZE);
    for (int k = 0; k < 8; k++) head[k] = (uint8_t)PDI_ARCHIVE_FILE_MAGIC[k];
    pdi_archive_file_put_u32(head + PDI_ARCHIVE_FILE_OFFSET_ORDER, PDI_ARCHIVE_FILE_BYTE_ORDER_MARK);
    pdi_archive_file_put_u32(head + PDI_ARCHIVE_FILE_OFFSET_FORMAT, PD_ARCHIVE_FILE_FORMAT);
    pdi_archive_file_put_u32(head + PDI_ARCHIVE_FILE_OFFSET_DIM, PD_DIM);
    memcpy(head + PDI_ARCHIVE_FILE_OFFSET_VERSION, PD_VERSION, sizeof PD_VERSION);
    pdi_archive_file_set_checksum(head, PDI_ARCHIVE_FILE_HEADER_SIZE);
}

/* Report as PD_ERR_ARGUMENT that a number of the file header differs from the expected one. what: "format" or
 * "dimension". */
static pd_status pdi_archive_file_fail_mismatch(pd_ctx *ctx, const pd_archive_file *s, const char *what, unsigned found,
                                                unsigned expected)
{
    return pd_fail(ctx, PD_ERR_ARGUMENT, "store", "'%s' is of %s %u, expected %u", s->file.path, what, found,
                   expected);
}

/* Report a damaged file as PD_ERR_FILE: "'<path>' <what>". */
static pd_status pdi_archive_file_fail_damaged(pd_ctx *ctx, const pd_archive_file *s, const char *what)
{
    return pd_fail(ctx, PD_ERR_FILE, "store", "'%s' %s", s->file.path, what);
}

/* Report as PD_ERR_FILE that the file is `what` ("cut off", "damaged") in the item `name`. */
static pd_status pdi_archive_file_fail_damaged_item(pd_ctx *ctx, const pd_archive_file *s, const char *what,
                                                    const char *name)
{
    return pd_fail(ctx, PD_ERR_FILE, "store", "'%s' is %s in the item '%s'", s->file.path, what, name);
}

/* Read the file header at the start of the file. PD_ERR_FILE: no checkpoint, cut off or damaged. PD_ERR_ARGUMENT:
 * another format, dimension, byte order or version of pdcorr. */
static pd_status pdi_archive_file_read_header(pd_ctx *ctx, pd_archive_file *s)
{
    uint8_t head[PDI_ARCHIVE_FILE_HEADER_SIZE], wanted[PDI_ARCHIVE_FILE_HEADER_SIZE];
    size_t got;
    PD_TRY(pdi_file_read_bytes(ctx, &s->file, head, sizeof head, &got));
    if (got >= 8 && memcmp(head, PDI_ARCHIVE_FILE_MAGIC, 8) != 0)
        return pdi_archive_file_fail_damaged(ctx, s, "does not begin like a checkpoint: it is none, or damaged");
    if (got < sizeof head) return pdi_archive_file_fail_damaged(ctx, s, "is cut off in its head");
    if (pdi_archive_file_get_u32(head + PDI_ARCHIVE_FILE_OFFSET_ORDER) == PDI_ARCHIVE_FILE_SWAPPED_MARK)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "store", "'%s' was written on a machine of the other byte order",
                       s->file.path);
    if (!pdi_archive_file_is_checksum_valid(head, sizeof head))
        return pdi_archive_file_fail_damaged(ctx, s, "is damaged in its head");
    uint32_t format = pdi_archive_file_get_u32(head + PDI_ARCHIVE_FILE_OFFSET_FORMAT),
             dim = pdi_archive_file_get_u32(head + PDI_ARCHIVE_FILE_OFFSET_DIM);
    if (format != PD_ARCHIVE_FILE_FORMAT)
        return pdi_archive_file_fail_mismatch(ctx, s, "format", format, PD_ARCHIVE_FILE_FORMAT);
    if (dim != PD_DIM) return pdi_archive_file_fail_mismatch(ctx, s, "dimension", dim, PD_DIM);
    pdi_archive_file_init_header(wanted);
    if (memcmp(head, wanted, sizeof head) != 0)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "store",
                       "'%s' was written by pdcorr %.31s, expected %s: versions may differ in their steps",
                       s->file.path, (const char *)head + PDI_ARCHIVE_FILE_OFFSET_VERSION, PD_VERSION);
    return PD_OK;
}

/* Read the next item header into *item and verify its CRC-32. after: name in the message: of the item before it, or of
 * the item that is expected. PD_ERR_FILE: cut off or damaged. */
static pd_status pdi_archive_file_read_item_header(pd_ctx *ctx, pd_archive_file *s, const char *after,
                                                   pdi_archive_file_item *item)
{
    uint8_t head[PDI_ARCHIVE_FILE_ITEM_HEADER_SIZE];
    size_t got;
    PD_TRY(pdi_file_read_bytes(ctx, &s->file, head, sizeof head, &got));
    if (got < sizeof head) return pdi_archive_file_fail_damaged_item(ctx, s, "cut off", after);
    if (!pdi_archive_file_is_checksum_valid(head, sizeof head))
        return pdi_archive_file_fail_damaged_item(ctx, s, "damaged behind what is", after);
    memcpy(item->name, head, sizeof item->name);
    item->name[PD_ARCHIVE_FILE_NAME_SIZE - 1] = '\0';
    memcpy(&item->count, head + PDI_ARCHIVE_FILE_OFFSET_COUNT, sizeof item->count);
    item->element_size = pdi_archive_file_get_u32(head + PDI_ARCHIVE_FILE_OFFSET_SIZE);
    return PD_OK;
}

/* ---- check of a whole file ---- */

/* Read the elements of an item without keeping them, and verify their CRC-32. PD_ERR_FILE: cut off or damaged. */
static pd_status pdi_archive_file_check_elements(pd_ctx *ctx, pd_archive_file *s, const pdi_archive_file_item *item)
{
    uint8_t bytes[4096];
    uint32_t crc = 0;
    size_t got;
    for (uint64_t left = item->count * item->element_size; left > 0; left -= got) {
        size_t wanted = left < sizeof bytes ? (size_t)left : sizeof bytes;
        PD_TRY(pdi_file_read_bytes(ctx, &s->file, bytes, wanted, &got));
        if (got < wanted) return pdi_archive_file_fail_damaged_item(ctx, s, "cut off", item->name);
        crc = pdi_zlib_crc32(crc, bytes, got);
    }
    PD_TRY(pdi_file_read_bytes(ctx, &s->file, bytes, 4, &got));
    if (got < 4) return pdi_archive_file_fail_damaged_item(ctx, s, "cut off", item->name);
    return pdi_archive_file_get_u32(bytes) == crc ? PD_OK
                                                  : pdi_archive_file_fail_damaged_item(ctx, s, "damaged", item->name);
}

/* Read a whole file from its start; verify the header, all checksums, the number of items, and that nothing follows the
 * last one. The elements are not kept. PD_ERR_FILE: cut off, damaged, items lost, bytes behind the end; PD_ERR_ARGUMENT
 * as of the header. */
static pd_status pdi_archive_file_check_file(pd_ctx *ctx, pd_archive_file *s)
{
    pdi_archive_file_item item;
    char more;
    size_t got;
    memset(&item, 0, sizeof item);
    PD_TRY(pdi_archive_file_read_header(ctx, s));
    for (uint64_t items = 0;; items++) {
        char after[PD_ARCHIVE_FILE_NAME_SIZE];
        memcpy(after, items ? item.name : "head", items ? sizeof after : 5);
        PD_TRY(pdi_archive_file_read_item_header(ctx, s, after, &item));
        if (strcmp(item.name, PDI_ARCHIVE_FILE_END_NAME) == 0) {
            if (item.count != items) return pdi_archive_file_fail_damaged(ctx, s, "has lost items");
            break;
        }
        PD_TRY(pdi_archive_file_check_elements(ctx, s, &item));
    }
    PD_TRY(pdi_file_read_bytes(ctx, &s->file, &more, 1, &got));
    return got ? pdi_archive_file_fail_damaged(ctx, s, "goes on behind its end") : PD_OK;
}

/* ---- in memory ---- */

/* Append bytes to the file; where in_memory is 1, to the checkpoint in memory, whose buffer grows to 9/8 of what is
 * needed when it is full. */
static pd_status pdi_archive_file_write_bytes(pd_ctx *ctx, pd_archive_file *s, const void *data, size_t size)
{
    if (!s->in_memory) return pdi_file_write(ctx, &s->file, data, size);
    if (size > s->capacity - s->length) {
        size_t wanted = s->length + size + (s->length + size) / 8;
        PD_TRY(PD_GROW(ctx, "store", s->capacity, wanted, s->memory));
        s->capacity = wanted;
    }
    if (size) memcpy(s->memory + s->length, data, size); /* an empty array may have no address */
    s->length += size;
    return PD_OK;
}

/* ---- callbacks of the archive ---- */

/* Write an item: header, `count` elements of `size` bytes, and their CRC-32 (in memory: 0, computed when it goes to
 * disk). name: shorter than PD_ARCHIVE_FILE_NAME_SIZE. */
static pd_status pdi_archive_file_write_item(pd_ctx *ctx, pd_archive_file *s, const char *name, const void *data,
                                             size_t size, int64_t count)
{
    uint8_t head[PDI_ARCHIVE_FILE_ITEM_HEADER_SIZE], tail[4];
    uint64_t number = (uint64_t)count;
    size_t bytes = (size_t)count * size;
    PD_ASSERT(strlen(name) < PD_ARCHIVE_FILE_NAME_SIZE);
    memset(head, 0, sizeof head);
    memcpy(head, name, strlen(name) + 1);
    memcpy(head + PDI_ARCHIVE_FILE_OFFSET_COUNT, &number, sizeof number);
    pdi_archive_file_put_u32(head + PDI_ARCHIVE_FILE_OFFSET_SIZE, (uint32_t)size);
    pdi_archive_file_set_checksum(head, sizeof head);
    pdi_archive_file_put_u32(tail, s->in_memory ? 0 : pdi_zlib_crc32(0, (const uint8_t *)data, bytes));
    PD_TRY(pdi_archive_file_write_bytes(ctx, s, head, sizeof head));
    PD_TRY(pdi_archive_file_write_bytes(ctx, s, data, bytes));
    return pdi_archive_file_write_bytes(ctx, s, tail, sizeof tail);
}

/* Read the next item into data, `count` elements of `size` bytes. PD_ERR_ARGUMENT: another name, count or element size
 * than expected. PD_ERR_FILE: cut off or damaged. */
static pd_status pdi_archive_file_read_item(pd_ctx *ctx, pd_archive_file *s, const char *name, void *data, size_t size,
                                            int64_t count)
{
    pdi_archive_file_item item;
    uint8_t tail[4];
    size_t bytes = (size_t)count * size, got;
    PD_TRY(pdi_archive_file_read_item_header(ctx, s, name, &item));
    if (strcmp(item.name, name) != 0 || item.element_size != size || item.count != (uint64_t)count)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "store",
                       "'%s' holds '%s' of %.0f elements of %u bytes, expected '%s' of %.0f of %.0f: it is of another "
                       "run",
                       s->file.path, item.name, (double)item.count, (unsigned)item.element_size, name, (double)count,
                       (double)size);
    PD_TRY(pdi_file_read_bytes(ctx, &s->file, data, bytes, &got));
    if (got < bytes) return pdi_archive_file_fail_damaged_item(ctx, s, "cut off", name);
    PD_TRY(pdi_file_read_bytes(ctx, &s->file, tail, sizeof tail, &got));
    if (got < sizeof tail || pdi_archive_file_get_u32(tail) != pdi_zlib_crc32(0, (const uint8_t *)data, bytes))
        return pdi_archive_file_fail_damaged_item(ctx, s, "damaged", name);
    return PD_OK;
}

/* Callback of the archive: write or read an item, whichever the store (`user`) is open for. item_count is incremented
 * first, also where that fails. */
static pd_status pdi_archive_file_item_callback(pd_ctx *ctx, void *user, const char *name, void *data, size_t size,
                                                int64_t count)
{
    pd_archive_file *s = (pd_archive_file *)user;
    s->item_count++;
    return s->archive.is_reading ? pdi_archive_file_read_item(ctx, s, name, data, size, count)
                                 : pdi_archive_file_write_item(ctx, s, name, data, size, count);
}

/* Callback of the archive: write a number as an item of one double; or read it and compare its bits with those of
 * `value`, so that NaN equals itself and 0 differs from -0. PD_ERR_ARGUMENT: they differ. */
static pd_status pdi_archive_file_check_callback(pd_ctx *ctx, void *user, const char *name, double value)
{
    pd_archive_file *s = (pd_archive_file *)user;
    char was[PDI_FILE_NUMBER_SIZE], is[PDI_FILE_NUMBER_SIZE];
    double kept = value;
    PD_TRY(pdi_archive_file_item_callback(ctx, s, name, &kept, sizeof kept, 1));
    uint64_t bits, expected; /* what is no number equals itself */
    memcpy(&bits, &kept, sizeof bits);
    memcpy(&expected, &value, sizeof expected);
    if (bits == expected) return PD_OK;
    pdi_file_format_number(kept, was);
    pdi_file_format_number(value, is);
    return pd_fail(ctx, PD_ERR_ARGUMENT, "store", "'%s' is of another run: %s = %s, expected %s", s->file.path, name,
                   was, is);
}

/* Set the callbacks of the archive and its name, the path of the file. reading 1: they read, 0: they write. */
static void pdi_archive_file_set_callbacks(pd_archive_file *s, int reading)
{
    s->archive.transfer = pdi_archive_file_item_callback;
    s->archive.verify = pdi_archive_file_check_callback;
    s->archive.user = s;
    s->archive.is_reading = reading;
    s->archive.name = s->file.path;
}

/* ---- begin and end ---- */

PDI_FN pd_status pdi_archive_file_begin_in_memory(pd_ctx *ctx, pd_archive_file *s)
{
    uint8_t head[PDI_ARCHIVE_FILE_HEADER_SIZE];
    pdi_archive_file_set_callbacks(s, 0);
    s->in_memory = 1;
    s->length = 0;
    s->item_count = 0;
    pdi_archive_file_init_header(head);
    return pdi_archive_file_write_bytes(ctx, s, head, sizeof head);
}

/* Set the CRC-32 behind the elements of all items held in memory, which are written with 0. The checkpoint has its end
 * item. */
static void pdi_archive_file_compute_checksums(pd_archive_file *s)
{
    uint64_t count;
    for (uint8_t *item = s->memory + PDI_ARCHIVE_FILE_HEADER_SIZE;
         strcmp((const char *)item, PDI_ARCHIVE_FILE_END_NAME) != 0;) {
        memcpy(&count, item + PDI_ARCHIVE_FILE_OFFSET_COUNT, sizeof count);
        size_t size = (size_t)count * pdi_archive_file_get_u32(item + PDI_ARCHIVE_FILE_OFFSET_SIZE);
        item += PDI_ARCHIVE_FILE_ITEM_HEADER_SIZE;
        pdi_archive_file_put_u32(item + size, pdi_zlib_crc32(0, item, size));
        item += size + 4;
    }
}

PDI_FN pd_status pdi_archive_file_write_memory(pd_ctx *ctx, pd_archive_file *s, const char *path)
{
    pdi_archive_file_compute_checksums(s);
    PD_TRY(pdi_file_create(ctx, path, &s->file));
    pd_status status = pdi_file_write(ctx, &s->file, s->memory, s->length);
    if (status == PD_OK) status = pdi_file_commit(ctx, &s->file);
    pdi_file_abandon(&s->file);
    return status;
}

PDI_FN void pdi_archive_file_free_memory(pd_ctx *ctx, pd_archive_file *s)
{
    PD_DELETE(ctx, s->capacity, s->memory);
    memset(s, 0, sizeof *s);
}

/* ---- create, open, close ---- */

pd_status pd_archive_file_create(pd_ctx *ctx, const char *path, pd_archive_file *s)
{
    uint8_t head[PDI_ARCHIVE_FILE_HEADER_SIZE];
    memset(s, 0, sizeof *s);
    pdi_archive_file_set_callbacks(s, 0);
    PD_TRY(pdi_file_create(ctx, path, &s->file));
    pdi_archive_file_init_header(head);
    pd_status status = pdi_archive_file_write_bytes(ctx, s, head, sizeof head);
    if (status < 0) pdi_archive_file_abandon(s);
    return status;
}

pd_status pd_archive_file_open(pd_ctx *ctx, const char *path, pd_archive_file *s)
{
    memset(s, 0, sizeof *s);
    pdi_archive_file_set_callbacks(s, 1);
    PD_TRY(pdi_file_open_read(ctx, path, &s->file));
    pd_status status = pdi_archive_file_check_file(ctx, s);
    pdi_archive_file_abandon(s);
    if (status == PD_OK) status = pdi_file_open_read(ctx, path, &s->file);
    if (status == PD_OK) status = pdi_archive_file_read_header(ctx, s);
    if (status < 0) pdi_archive_file_abandon(s);
    return status;
}

PDI_FN void pdi_archive_file_abandon(pd_archive_file *s) { pdi_file_abandon(&s->file); }

/* Reading: check that the end item comes next. PD_ERR_ARGUMENT: another item comes; PD_ERR_FILE: cut off or damaged.
 * Writing: write the end item with the number of items and, except in memory, commit the file. */
static pd_status pdi_archive_file_end(pd_ctx *ctx, pd_archive_file *s)
{
    pdi_archive_file_item item;
    uint8_t head[PDI_ARCHIVE_FILE_ITEM_HEADER_SIZE];
    if (s->archive.is_reading) {
        PD_TRY(pdi_archive_file_read_item_header(ctx, s, "last", &item));
        if (strcmp(item.name, PDI_ARCHIVE_FILE_END_NAME) != 0)
            return pd_fail(ctx, PD_ERR_ARGUMENT, "store", "'%s' holds '%s', expected its end: it is of another run",
                           s->file.path, item.name);
        return PD_OK;
    }
    memset(head, 0, sizeof head);
    memcpy(head, PDI_ARCHIVE_FILE_END_NAME, sizeof PDI_ARCHIVE_FILE_END_NAME);
    memcpy(head + PDI_ARCHIVE_FILE_OFFSET_COUNT, &s->item_count, sizeof s->item_count);
    pdi_archive_file_set_checksum(head, sizeof head);
    PD_TRY(pdi_archive_file_write_bytes(ctx, s, head, sizeof head));
    return s->in_memory ? PD_OK : pdi_file_commit(ctx, &s->file);
}

pd_status pd_archive_file_close(pd_ctx *ctx, pd_archive_file *s)
{
    pd_status status = pdi_archive_file_end(ctx, s);
    pdi_archive_file_abandon(s);
    return status;
}

#undef PDI_ARCHIVE_FILE_MAGIC
#undef PDI_ARCHIVE_FILE_BYTE_ORDER_MARK
#undef PDI_ARCHIVE_FILE_SWAPPED_MARK
#undef PDI_ARCHIVE_FILE_HEADER_SIZE
#undef PDI_ARCHIVE_FILE_ITEM_HEADER_SIZE
#undef PDI_ARCHIVE_FILE_END_NAME
