/* text: the text of a scene, sections of `key = value` pairs, and the typed look-up of its values.
 *
 *   # comment
 *   [shape pin]  box = 0 .. 400 um, -40 um .. 40 um   kind = solid
 *   [side x-]    flow = inlet, profile = parabola, mean = 0.236 m/s
 *
 * `[name]` or `[name label]` opens a section at the start of a line. A pair begins at every `identifier =` outside
 * parentheses (not ==, <=, >=) and ends before the next one or at the end of the line; commas and blanks around the
 * value do not count. In a section whose first key is a text (keys.h) that text stands without its key, and what is no
 * key of the section belongs to it. A file without any section line is flat: its numbers are SI and need no unit.
 *
 * Whoever reads a value says its dimension and its default, as text; what nobody read is an error (pdi_text_unused).
 * Every message starts with file:line.
 */
#ifndef PD_TEXT_H
#define PD_TEXT_H
#include "io/file.h"
#include "scene/expr.h"
#include "scene/keys.h"

#define PD_TEXT_SIZE (1 << 20) /* [byte] of a file */
#define PD_TEXT_ENTRIES 4096   /* pairs, and sections */
#define PD_TEXT_WORDS 32       /* words of one list */
#define PD_TEXT_WORD 32        /* [byte] of a word with its end */

typedef struct pd_section {
    const char *name, *label; /* "" when absent */
    const char *file;         /* where it stands, for messages */
    int line;                 /* 0: not in the file */
    int group;                /* first section of the same name */
    int present;              /* stands in the file or has a pair */
    int asked;                /* of the group's first section: a call has looked up that name */
} pd_section;

typedef struct pd_text_entry {
    const char *key, *value;
    int section;
    const char *file;
    int line, column; /* of the value; line 0: command line */
    int depth;        /* files that include one another down to this one */
    int used;
} pd_text_entry;

typedef struct pd_text_key {
    const char *key;
    int group;
} pd_text_key;

typedef struct pd_text_block {
    char *bytes;
    size_t size;
} pd_text_block;

typedef struct pd_text {
    const char *name;             /* of the file, for messages */
    int flat;                     /* no section line */
    int bare;                     /* numbers may lack their unit; set for flat files, the caller may change it */
    const pd_expr_symbol *consts; /* the caller's named constants in numbers and expressions; borrowed */
    int const_count;
    const pd_expr_table *tables;  /* the caller's functions there; borrowed as long as expressions live */
    int table_count;
    int scene;                    /* set by the caller: look-ups are held against pd_keys where PD_DEBUG is defined */
    pd_section *section; /* 0: what stands before the first section line */
    int section_count, section_room;
    pd_text_entry *entry;
    int entry_count, entry_room;
    pd_text_key *asked; /* keys that were asked for, by group */
    int asked_count, asked_room;
    pd_text_block *block; /* own the strings; they stay where they are until pdi_text_free */
    int block_count, block_room;
    pd_status failed; /* of a call that could not say so: not enough memory */
} pd_text;

typedef struct pd_word_list {
    int count;
    char word[PD_TEXT_WORDS][PD_TEXT_WORD];
} pd_word_list;

#ifdef PDI_INTERNAL
#define PDI_TEXT_LIST 240 /* [byte] of a list of names in a message */

/* What a word may be made of: of an identifier; in a label also of signs; in one of a formula of ( ) ^ : too. */
typedef enum pdi_text_word { PDI_TEXT_KEY = 0, PDI_TEXT_LABEL, PDI_TEXT_FORMULA } pdi_text_word;

/* Take a copy of bytes[size]; name stands in messages. PD_ERR_PARSE: not text, not the format, a key twice, too many
 * pairs. PD_ERR_SIZE: larger than PD_TEXT_SIZE. */
PDI_FN pd_status pdi_text_build(pd_ctx *ctx, const char *name, const char *bytes, size_t size, pd_text *text);
/* The same from a file. PD_ERR_FILE: it cannot be read or is too large. */
PDI_FN pd_status pdi_text_read(pd_ctx *ctx, const char *path, pd_text *text);
PDI_FN void pdi_text_free(pd_ctx *ctx, pd_text *text);
PDI_FN int pdi_text_flat(const pd_text *text);

/* Index of the section for the calls below; label NULL is "". A section that is absent has no keys. Section 0 has
 * the name "". -1: out of memory, which the next call that has a status returns. */
PDI_FN int pdi_text_section(pd_ctx *ctx, pd_text *text, const char *name, const char *label);
/* The next section of that name behind index `after` in file order; start with -1. -1: no more. */
PDI_FN int pdi_text_next(pd_ctx *ctx, pd_text *text, const char *name, int after);
/* 1 when the section has the key; key NULL: when the section is present. Out of memory: 0, returned as above. */
PDI_FN int pdi_text_has(pd_ctx *ctx, pd_text *text, int section, const char *key);

/* Look-ups. fallback is the default as text, read like a value from the file; NULL: the key is required. unit gives
 * the dimension ("um" asks for a length); values come in SI. PD_ERR_PARSE with file:line, what was found, what was
 * expected; PD_ERR_ARGUMENT: section -1. */
/* The value as it stands. It lives as long as the text (or is fallback itself). */
PDI_FN pd_status pdi_text_string(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                 const char **value);
/* A constant finite expression. */
PDI_FN pd_status pdi_text_number(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                 const char *fallback, double *value);
/* A list `a, b, c` of 1 to max numbers. */
PDI_FN pd_status pdi_text_numbers(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                  const char *fallback, int max, double *values, int *count);
/* A whole number in [low, high]. */
PDI_FN pd_status pdi_text_integer(pd_ctx *ctx, pd_text *text, int section, const char *key, int low, int high,
                                  const char *fallback, int *value);
/* yes, true, on: 1; no, false, off: 0. */
PDI_FN pd_status pdi_text_bool(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                               int *value);
/* Index of the value in names, which ends with NULL. */
PDI_FN pd_status pdi_text_choice(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *const *names,
                                 const char *fallback, int *index);
/* A list `C, v, p` of words of letters, digits and _ + - . */
PDI_FN pd_status pdi_text_words(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                pd_word_list *list);
/* A list `a .. b, c .. d` of 1 to max ranges with a < b. */
PDI_FN pd_status pdi_text_ranges(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                 const char *fallback, int max, double *low, double *high, int *count);
/* An expression in vars; unit NULL: of any dimension. The caller frees it with pdi_expr_free. */
PDI_FN pd_status pdi_text_expr(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                               const pd_expr_symbol *vars, int var_count, const char *fallback, pd_expr *expr);
/* A list of 1 to max expressions; on failure none is left to free. */
PDI_FN pd_status pdi_text_exprs(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                const pd_expr_symbol *vars, int var_count, const char *fallback, int max,
                                pd_expr *exprs, int *count);
/* Report that the value of a key is not admissible: sets "file:line: key: message", returns PD_ERR_ARGUMENT. */
PDI_FN pd_status pdi_text_refuse(pd_ctx *ctx, const pd_text *text, int section, const char *key, const char *format,
                                 ...) PD_PRINTF_LIKE(5, 6);
/* PD_ERR_PARSE when no call has read a section or key; the message suggests the nearest name that was looked up. */
PDI_FN pd_status pdi_text_unused(pd_ctx *ctx, const pd_text *text);

/* For modules that change a text. */
/* A copy of bytes[size] with an end, owned by text. */
PDI_FN pd_status pdi_text_keep(pd_ctx *ctx, pd_text *text, const char *bytes, size_t size, char **copy);
/* PD_ERR_PARSE with "file:12: " or, for line 0, "command line: " before the message. */
PDI_FN pd_status pdi_text_error(pd_ctx *ctx, const char *file, int line, const char *format, ...) PD_PRINTF_LIKE(4, 5);
/* The same for what stands at t[at]. */
PDI_FN pd_status pdi_text_expected(pd_ctx *ctx, const pd_text *text, int line, const char *t, size_t at,
                                   const char *expected);
/* Add a name to list[PDI_TEXT_LIST]. */
PDI_FN void pdi_text_list_add(char *list, const char *separator, const char *name);
/* Index of the section; creates it when absent. */
PDI_FN pd_status pdi_text_section_at(pd_ctx *ctx, pd_text *text, const char *name, const char *label, int *index);
/* NULL: there is none. */
PDI_FN pd_text_entry *pdi_text_entry_at(const pd_text *text, int section, const char *key);
/* A pair, whose strings live as long as text. PD_ERR_PARSE: the section has the key. */
PDI_FN pd_status pdi_text_add(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *value, int line,
                              int column);
/* Where t[at..] has its next byte that is no blank. */
PDI_FN size_t pdi_text_skip(const char *t, size_t at);
/* Which words are labels of a section of this name. */
PDI_FN pdi_text_word pdi_text_label(const char *section);
/* Length of the word at t. */
PDI_FN size_t pdi_text_name(const char *t, pdi_text_word kind);
/* Only printable bytes, tabs and line ends: a binary file is recognised before anything is read from it. */
PDI_FN pd_status pdi_text_check_bytes(pd_ctx *ctx, const pd_text *text, const char *t, size_t size);
#endif

#endif
