/* text: parser of scene files, sections of `key = value` pairs, and typed look-up of their values (number with unit,
 * list, range, choice, expression).
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
 * Whoever reads a value says its dimension and its default, as text; what nobody read is an error
 * (pdi_text_check_unused). Every message starts with file:line.
 */
#ifndef PD_TEXT_H
#define PD_TEXT_H
#include "io/file.h"
#include "setup/expr.h"
#include "scene/keys.h"
#include "scene/renamed_keys.h"

#define PD_TEXT_SIZE (1 << 20) /* [byte] of a file */
#define PD_TEXT_ENTRIES 4096   /* pairs, and sections */
#define PD_TEXT_WORDS 32       /* words of one list */
#define PD_TEXT_WORD 32        /* [byte] of a word with its end */

/* A section of the text: [name label]. */
typedef struct pd_section {
    const char *name, *label; /* "" when absent */
    const char *file;         /* file that contains it, for messages */
    int line;                 /* of that file, 0: not in a file */
    int group_first;          /* index of the first section of the same name */
    int is_present;           /* 1: it is in the file, or has a pair */
    int is_looked_up;         /* of the first section of a group: 1: a reader has looked up that name */
} pd_section;

/* A `key = value` pair. */
typedef struct pd_text_entry {
    const char *key, *value;
    int section;
    const char *file;
    int line, column; /* of the value; line 0: command line */
    int depth;        /* nesting depth of included files, 0: the scene file */
    int is_read;      /* 1: a reader has read the value */
} pd_text_entry;

/* A key that a reader has looked up in a group of sections, for suggestions in messages. */
typedef struct pd_text_asked_key {
    const char *key;
    int group;
} pd_text_asked_key;

/* Memory of strings. */
typedef struct pd_text_memory {
    char *bytes;
    size_t size;
} pd_text_memory;

/* A parsed file: its sections and pairs, the names that its expressions know, and which keys the readers looked up. */
typedef struct pd_text {
    const char *name;             /* of the file, for messages */
    int is_flat;                  /* 1: a file without sections */
    /* 1: numbers may lack their unit; set for flat files, the caller may change it */
    int allow_bare_numbers;
    const pd_expr_symbol *consts; /* the caller's named constants in numbers and expressions; borrowed */
    int const_count;
    const pd_expr_table *tables;  /* the caller's functions there; borrowed as long as expressions live */
    int table_count;
    /* set by the caller: with PD_DEBUG each look-up is compared with the table pd_key_sections */
    int check_keys;
    uint8_t has_renamed[PD_RENAMED_KEYS]; /* 1: the text has this former name (renamed_keys.h) */
    pd_section *section; /* section 0 holds the pairs before the first section line */
    int section_count, section_capacity;
    pd_text_entry *entry;
    int entry_count, entry_capacity;
    pd_text_asked_key *asked_key; /* keys that readers have looked up, by group */
    int asked_count, asked_capacity;
    pd_text_memory *block; /* memory of all strings, at fixed addresses until pdi_text_free */
    int block_count, block_capacity;
    pd_status pending_status; /* pending error (out of memory) of a call that returns no status */
} pd_text;

/* A comma-separated list of words, copied. */
typedef struct pd_word_list {
    int count;
    char word[PD_TEXT_WORDS][PD_TEXT_WORD];
} pd_word_list;

#ifdef PDI_APP_INTERNAL
#define PDI_TEXT_LIST_SIZE 240 /* [byte] of a list of names in a message */

/* Character set of a word: identifier; label, also with digits first, + and -; chemical formula, also with ( ) ^ : */
typedef enum pdi_text_charset {
    PDI_TEXT_CHARSET_KEY = 0,
    PDI_TEXT_CHARSET_LABEL,
    PDI_TEXT_CHARSET_FORMULA
} pdi_text_charset;

/* Parse a copy of bytes[size] into text, for pdi_text_free; on failure text is zero. name: file name in messages. A
 * file without section lines is flat, and its numbers may lack units; an empty one is admitted. PD_ERR_PARSE: control
 * bytes, wrong format, a duplicate key, too many pairs or sections. PD_ERR_SIZE: larger than PD_TEXT_SIZE. */
PDI_FN pd_status pdi_text_build(pd_ctx *ctx, const char *name, const char *bytes, size_t size, pd_text *text);
/* Read a file and parse it as pdi_text_build does; the path is its name. PD_ERR_FILE: it cannot be read or is larger
 * than PD_TEXT_SIZE. On failure text is zero. */
PDI_FN pd_status pdi_text_read(pd_ctx *ctx, const char *path, pd_text *text);
/* Free all memory of the text, which includes the strings that look-ups returned, and zero it. */
PDI_FN void pdi_text_free(pd_ctx *ctx, pd_text *text);
/* 1: a file without sections (SI numbers, no units). */
PDI_FN int pdi_text_is_flat(const pd_text *text);

/* Index of the section [name label] for the look-ups below; label NULL is "". A missing section is created empty. All
 * sections of that name then count as looked up. -1: out of memory; the next call that returns a status reports it. */
PDI_FN int pdi_text_get_section(pd_ctx *ctx, pd_text *text, const char *name, const char *label);
/* Iterate over the sections of that name, the present one, that are in the file or have a pair, in the order of the
 * text: index of the next one after `after` (-1: first). -1: no more, or out of memory. The first call creates the
 * section without label, empty, and the name counts as looked up. */
PDI_FN int pdi_text_next_section(pd_ctx *ctx, pd_text *text, const char *name, int after);
/* 1: the section has the key; key NULL: the section is in the file or has a pair. The key is recorded as asked for, and
 * its value stays unread. Section -1: 0. Out of memory: 0, reported by the next call with a status. */
PDI_FN int pdi_text_has_key(pd_ctx *ctx, pd_text *text, int section, const char *key);

/* Typed look-ups of the value under `key` of a section, which then counts as read. fallback: default as text, parsed
 * like a value of the file; NULL: the key is required. unit: expected dimension ("um" asks for a length), "" for a
 * plain number; results are in SI. PD_ERR_PARSE with file:line, what was found, what was expected; PD_ERR_ARGUMENT:
 * section -1. */
/* The value as a string, unparsed. It lives as long as the text (or is fallback itself). */
PDI_FN pd_status pdi_text_get_string(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                     const char **value);
/* A number: a constant expression of that dimension, which must be finite. */
PDI_FN pd_status pdi_text_get_number(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                     const char *fallback, double *value);
/* A list `a, b, c` of 1 to max numbers into values[max]; *count: how many. A comma inside parentheses separates
 * nothing. PD_ERR_PARSE: more than max, or an empty item; values before it are then stored and counted. */
PDI_FN pd_status pdi_text_get_numbers(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                      const char *fallback, int max, double *values, int *count);
/* A whole number in low .. high, both included. PD_ERR_PARSE: another number. */
PDI_FN pd_status pdi_text_get_integer(pd_ctx *ctx, pd_text *text, int section, const char *key, int low, int high,
                                      const char *fallback, int *value);
/* Read yes, true, on as *value 1 and no, false, off as 0. PD_ERR_PARSE: another word, also in capitals. */
PDI_FN pd_status pdi_text_get_bool(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                   int *value);
/* One of the words in names, which ends with NULL; *index: its position, from 0 on. PD_ERR_PARSE: another word; the
 * message lists the names. */
PDI_FN pd_status pdi_text_get_choice(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *const *names,
                                     const char *fallback, int *index);
/* A list `C, v, Mg(OH)2(s)` of 1 to PD_TEXT_WORDS words of letters, digits and _ + - . and, behind the first character,
 * parentheses and colons. PD_ERR_PARSE: more words, an empty one, one of PD_TEXT_WORD bytes or more, or another
 * character. */
PDI_FN pd_status pdi_text_get_words(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *fallback,
                                    pd_word_list *list);
/* A list `a .. b, c .. d` of 1 to max ranges with a < b into low[max] and high[max]; *count: how many. PD_ERR_PARSE:
 * also a range with a >= b, or three dots. */
PDI_FN pd_status pdi_text_get_ranges(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                     const char *fallback, int max, double *low, double *high, int *count);
/* An expression in the variables vars[var_count]; unit NULL: any dimension. The caller frees it with pd_expr_free; on
 * failure there is nothing to free. */
PDI_FN pd_status pdi_text_get_expr(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                   const pd_expr_symbol *vars, int var_count, const char *fallback, pd_expr *expr);
/* A list of 1 to max expressions into exprs[max], whose rest is zeroed; *count: how many. On failure none is left to
 * free. */
PDI_FN pd_status pdi_text_get_exprs(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *unit,
                                    const pd_expr_symbol *vars, int var_count, const char *fallback, int max,
                                    pd_expr *exprs, int *count);
/* Report an inadmissible value of a key: sets the message "file:line: key: ...", printf style, with the line of the
 * pair, else of its section, else 1. Returns PD_ERR_ARGUMENT, or the status of a pending error (out of memory), which
 * goes first. */
PDI_FN pd_status pdi_text_fail_key(pd_ctx *ctx, const pd_text *text, int section, const char *key, const char *format,
                                   ...) PD_PRINTF_LIKE(5, 6);
/* Check after all readers that each pair was read and each section that is present was looked up. PD_ERR_PARSE: one was
 * not; the message suggests the nearest name that was looked up, or says that the key has no effect in this scene. A
 * pending error (out of memory) goes first. */
PDI_FN pd_status pdi_text_check_unused(pd_ctx *ctx, const pd_text *text);

/* For modules that change a text: command-line overrides, included files. */
/* Copy bytes[size] into a null-terminated string that text owns. */
PDI_FN pd_status pdi_text_copy_string(pd_ctx *ctx, pd_text *text, const char *bytes, size_t size, char **copy);
/* Set the message "file:12: ...", for line 0 "command line: ...", printf style. Returns PD_ERR_PARSE. */
PDI_FN pd_status pdi_text_fail_line(pd_ctx *ctx, const char *file, int line, const char *format, ...)
    PD_PRINTF_LIKE(4, 5);
/* Set a message with line and column: what stands at t[at], and what was expected. Returns PD_ERR_PARSE. */
PDI_FN pd_status pdi_text_fail_expected(pd_ctx *ctx, const pd_text *text, int line, const char *t, size_t at,
                                        const char *expected);
/* Append a name to the list of names in a message, list[PDI_TEXT_LIST_SIZE], with the separator before it if the list
 * is not empty. A name that does not fit is left out; then the list ends with "...", once. */
PDI_FN void pdi_text_add_to_list(char *list, const char *separator, const char *name);
/* Find the section [name label], or create it empty and not present, with copies of both; *index: its position. label
 * is not NULL. A former name stands for the present one and is recorded for the notes. */
PDI_FN pd_status pdi_text_find_or_add_section(pd_ctx *ctx, pd_text *text, const char *name, const char *label,
                                              int *index);
/* Present names of a section, and of a key of a section; a former one is recorded for the notes. A name that is none of
 * the former ones is returned as it is. */
PDI_FN const char *pdi_text_get_present_section(pd_text *text, const char *name);
PDI_FN const char *pdi_text_get_present_key(pd_text *text, int section, const char *key);
/* Set the value of a pair; whether it was read and its location stay. A former word is replaced by its present one and
 * recorded for the notes. value must live as long as text. */
PDI_FN void pdi_text_set_value(pd_text *text, pd_text_entry *entry, const char *value);
/* Find the pair of a key, given by its present or a former name, in a section. NULL: there is none. */
PDI_FN pd_text_entry *pdi_text_find_entry(const pd_text *text, int section, const char *key);
/* Append a pair to a section, which then is present; former names are replaced. key and value must live as long as
 * text. line 0: command line. PD_ERR_PARSE: the section has the key already, or there are PD_TEXT_ENTRIES pairs. */
PDI_FN pd_status pdi_text_add_entry(pd_ctx *ctx, pd_text *text, int section, const char *key, const char *value,
                                    int line, int column);
/* Index of the first non-blank byte in t from t[at] on. */
PDI_FN size_t pdi_text_skip_blanks(const char *t, size_t at);
/* Character set of the labels of sections of this name. */
PDI_FN pdi_text_charset pdi_text_get_label_charset(const char *section);
/* Length [byte] of the longest word of that character set at the start of t; 0: none. An identifier does not begin with
 * a digit, a formula not with ( ) ^ or : */
PDI_FN size_t pdi_text_scan_word(const char *t, pdi_text_charset kind);
/* Check that t[size] holds no bytes below 0x20 or 0x7f but tabs, newlines and a carriage return before a newline or the
 * end, to reject binary files. PD_ERR_PARSE with the line. */
PDI_FN pd_status pdi_text_check_bytes(pd_ctx *ctx, const pd_text *text, const char *t, size_t size);
#endif

#endif
