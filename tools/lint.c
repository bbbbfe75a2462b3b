/* lint: house rules that no compiler checks. Run at the root of the repository.
 *
 *   lint [FILE ...]    without files: everything under the folders of `folders` and the texts of the root
 *
 * Every text: no path of a developer's machine. Code (.c .h .sh) in addition: lines of at most 120 columns, files of
 * at most 830 lines, no tab, no trailing blank, no leftover marker. src/ in addition, because all modules end up in
 * one translation unit: names carry the prefix of their module, a public function has its PD_NAME line, every double
 * of a public struct has its unit. The order of modules is the affair of amalgamate.
 */
#define _POSIX_C_SOURCE 200809L
#include <ctype.h>
#include <dirent.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_COLUMNS 120
#define MAX_LINES 830
#define WORD 96
#define PATH_SIZE 1024

typedef struct source {
    const char *path;
    char module[WORD]; /* empty outside of src/ */
    int is_header, is_code;
    char *text;
    char **line; /* without newline */
    int lines;
} source;

static const char *const folders[] = {"src", "drivers", "cases", "examples", "tests", "tools", "docs"};
static const char *const root_texts[] = {"README.md", "CHANGELOG.md", "LICENSE", "Makefile"};
/* Written in two halves so that this file passes its own rules. */
static const char *const machine_paths[] = {"/wo" "rk/", "/tm" "p/", "/ho" "me/", "/ro" "ot/"};
static const char *const markers[] = {"TO" "DO", "FIX" "ME", "XX" "X"};

static int complaints, files;

static void complain(const source *s, int line, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    printf("%s:%d: ", s->path, line + 1);
    vprintf(format, args);
    printf("\n");
    va_end(args);
    complaints++;
}

static void out_of_memory(void)
{
    fprintf(stderr, "lint: out of memory\n");
    exit(2);
}

static int starts(const char *text, const char *with) { return strncmp(text, with, strlen(with)) == 0; }

static int is_name(char c) { return isalnum((unsigned char)c) || c == '_'; }

static int ends(const char *text, const char *with)
{
    size_t a = strlen(text), b = strlen(with);
    return a >= b && strcmp(text + a - b, with) == 0;
}

/* The identifier that ends before `end`. */
static void name_before(const char *begin, const char *end, char name[WORD])
{
    while (end > begin && !is_name(end[-1])) end--;
    const char *from = end;
    while (from > begin && is_name(from[-1])) from--;
    snprintf(name, WORD, "%.*s", (int)(end - from), from);
}

/* The identifier at `at`, blanks skipped. */
static void name_at(const char *at, char name[WORD])
{
    size_t size = 0;
    while (*at == ' ' || *at == '*') at++;
    while (is_name(at[size])) size++;
    snprintf(name, WORD, "%.*s", (int)size, at);
}

/* ---- every text and every code file ---- */

static int has_word(const char *line, const char *word)
{
    for (const char *at = strstr(line, word); at; at = strstr(at + 1, word))
        if ((at == line || !is_name(at[-1])) && !is_name(at[strlen(word)])) return 1;
    return 0;
}

static int columns(const char *line)
{
    int count = 0;
    for (; *line; line++) count += ((unsigned char)*line & 0xC0) != 0x80; /* UTF-8 tails take no column */
    return count;
}

static void check_text(const source *s)
{
    for (int k = 0; k < s->lines; k++)
        for (size_t w = 0; w < sizeof machine_paths / sizeof machine_paths[0]; w++)
            if (strstr(s->line[k], machine_paths[w])) complain(s, k, "a path of one machine: %s", machine_paths[w]);
}

static void check_code(const source *s)
{
    if (s->lines > MAX_LINES) complain(s, MAX_LINES, "%d lines, at most %d", s->lines, MAX_LINES);
    for (int k = 0; k < s->lines; k++) {
        const char *line = s->line[k];
        size_t size = strlen(line);
        if (columns(line) > MAX_COLUMNS) complain(s, k, "%d columns, at most %d", columns(line), MAX_COLUMNS);
        if (strchr(line, '\t')) complain(s, k, "a tab");
        if (size && (line[size - 1] == ' ' || line[size - 1] == '\r')) complain(s, k, "a trailing blank");
        for (size_t w = 0; w < sizeof markers / sizeof markers[0]; w++)
            if (has_word(line, markers[w])) complain(s, k, "leftover marker %s", markers[w]);
    }
}

/* ---- prefixes in src/ ---- */

/* pd_T or pdi_T is a struct or enum of this header: pdi_T_verb is then a good name. */
static int header_has_type(const source *s, const char *type, size_t size)
{
    for (int k = 0; k < s->lines; k++) {
        const char *at = s->line[k];
        char name[WORD];
        if (starts(at, "typedef struct ")) name_at(at + 15, name);
        else if (starts(at, "typedef enum ")) name_at(at + 13, name);
        else continue;
        const char *bare = starts(name, "pdi_") ? name + 4 : starts(name, "pd_") ? name + 3 : name;
        if (strlen(bare) == size && memcmp(bare, type, size) == 0) return 1;
    }
    return 0;
}

/* An internal name of a header: pdi_<module>_..., or pdi_<type>_... with a type of the header; of an inline function
 * also with pd_. The module base is the vocabulary of all others and leaves its own name out. */
static int internal_name_fits(const source *s, const char *name, int is_inline)
{
    size_t size = strlen(s->module);
    const char *word = name + (starts(name, "pdi_") ? 4 : 3);
    if (!starts(name, "pdi_") && !(is_inline && starts(name, "pd_"))) return 0;
    if (strcmp(s->module, "base") == 0 || strcmp(s->module, "config") == 0) return 1;
    if (strncmp(word, s->module, size) == 0 && (word[size] == '_' || !word[size])) return 1;
    for (const char *end = strchr(word, '_'); end; end = strchr(end + 1, '_'))
        if (header_has_type(s, word, (size_t)(end - word))) return 1;
    return 0;
}

static int has_line(const source *s, const char *wanted)
{
    for (int k = 0; k < s->lines; k++)
        if (strcmp(s->line[k], wanted) == 0) return 1;
    return 0;
}

static void check_public_function(const source *s, int k, const char *name)
{
    char wanted[3 * WORD];
    if (!starts(name, "pd_")) complain(s, k, "public function %s: expected a name pd_...", name);
    snprintf(wanted, sizeof wanted, "#define %s PD_NAME(%s)", name, name);
    if (!has_line(s, wanted)) complain(s, k, "public function %s: the line `%s` is missing", name, wanted);
}

/* Top-level declarations of a header. */
static void check_header_names(const source *s)
{
    for (int k = 0; k < s->lines; k++) {
        const char *line = s->line[k], *open = strchr(line, '(');
        char name[WORD];
        if (!open || !isalpha((unsigned char)line[0]) || starts(line, "typedef ")) continue;
        if (k && ends(s->line[k - 1], "\\")) continue; /* body of a macro */
        name_before(line, open, name);
        if (starts(line, "PD_API ")) check_public_function(s, k, name);
        else if (!starts(line, "PDI_FN ") && !starts(line, "PDI_INLINE ") &&
                 !starts(line, "static inline "))
            complain(s, k, "%s: a header declares PD_API, PDI_FN or inline functions", name);
        else if (!internal_name_fits(s, name, !starts(line, "PDI_FN ")))
            complain(s, k, "internal function %s: expected pdi_%s_... or pdi_<type>_... of it; inline also pd_",
                     name, s->module);
    }
}

/* Every PD_NAME line has its function. */
static void check_mapped_names(const source *s)
{
    for (int k = 0; k < s->lines; k++) {
        char name[WORD], call[WORD + 1];
        int found = 0;
        if (!starts(s->line[k], "#define pd_")) continue;
        name_at(s->line[k] + 8, name);
        snprintf(call, sizeof call, "%s(", name);
        for (int j = 0; j < s->lines && !found; j++) {
            const char *at = strstr(s->line[j], call);
            found = at && starts(s->line[j], "PD_API ") && !is_name(at[-1]);
        }
        if (!found) complain(s, k, "%s is mapped, but no PD_API function has this name", name);
    }
}

static int undefined_again(const source *s, const char *name)
{
    char line[WORD + 8];
    snprintf(line, sizeof line, "#undef %s", name);
    return has_line(s, line);
}

static void check_macro(const source *s, int k)
{
    char name[WORD], upper[WORD + 8];
    name_at(s->line[k] + 8, name);
    snprintf(upper, sizeof upper, "PDI_%s_", s->module);
    for (char *c = upper; *c; c++) *c = (char)toupper((unsigned char)*c);
    if (s->is_header) {
        if (!starts(name, "PD_") && !starts(name, "PDI_") && !starts(name, "pd_"))
            complain(s, k, "macro %s of a header: expected PD_... or PDI_...", name);
    } else if (!starts(name, upper) && !undefined_again(s, name)) {
        complain(s, k, "macro %s: expected %s... or an #undef at the end of its use", name, upper);
    }
}

/* Names private to a .c file. */
static void check_source_names(const source *s)
{
    char prefix[WORD + 8], name[WORD];
    snprintf(prefix, sizeof prefix, "pdi_%s_", s->module);
    for (int k = 0; k < s->lines; k++) {
        const char *line = s->line[k], *end = line + strcspn(line, "([=;{");
        if (starts(line, "static ") && *end && *end != '{') {
            name_before(line, end, name);
            if (!starts(name, prefix)) complain(s, k, "static %s: expected a name %s...", name, prefix);
        }
        if (!starts(line, "typedef struct ") && !starts(line, "typedef enum ")) continue;
        name_at(strchr(line + 8, ' '), name);
        if (!starts(name, "pdi_")) complain(s, k, "type %s: expected a name pdi_...", name);
    }
}

/* ---- units of public structs ---- */

static int is_unit_symbol(const char *at, size_t size)
{
    static const char *const symbols[] = {"m", "d", "s", "kg", "mol", "K", "A", "V", "N", "Pa", "J", "W", "C", "S",
                                          "F", "rad", "byte", "h", "min", "um", "mm", "year"};
    for (size_t k = 0; k < sizeof symbols / sizeof symbols[0]; k++)
        if (strlen(symbols[k]) == size && memcmp(symbols[k], at, size) == 0) return 1;
    return 0;
}

/* "-", "1", "m2/s", "m^(d-2)", "kg/(m3 s)", or words that begin with "unit", such as "unit of b". */
static int is_unit(const char *at, size_t size)
{
    const char *end = at + size;
    if (size == 0) return 0;
    if (starts(at, "unit")) return 1;
    while (at < end) {
        size_t run = 0;
        while (at + run < end && isalpha((unsigned char)at[run])) run++;
        if (run && !is_unit_symbol(at, run)) return 0;
        if (!run && !strchr("0123456789^/()-+. *", *at)) return 0;
        at += run ? run : 1;
    }
    return 1;
}

static int has_unit(const char *comment)
{
    for (const char *open = strchr(comment, '['); open; open = strchr(open + 1, '['))
        if (strchr(open, ']') && is_unit(open + 1, strcspn(open + 1, "]"))) return 1;
    return 0;
}

/* Does the comment that begins in line k, possibly over several lines, name a unit? */
static int comment_has_unit(const source *s, int k)
{
    const char *at = strstr(s->line[k], "/*");
    while (at) {
        if (has_unit(at)) return 1;
        if (strstr(at, "*/") || ++k == s->lines) return 0;
        at = s->line[k];
    }
    return 0;
}

/* A unit stands beside the field, or in a comment line above its group of doubles. */
static void check_units(const source *s)
{
    int inside = 0, group = 0;
    for (int k = 0; k < s->lines; k++) {
        const char *line = s->line[k], *at = line + strspn(line, " ");
        if (starts(line, "typedef struct pd_") && strchr(line, '{')) inside = 1, group = 0;
        else if (starts(line, "}")) inside = 0;
        if (!inside) continue;
        if (starts(at, "/*")) group = comment_has_unit(s, k);
        if (starts(at, "const ")) at += 6;
        if (starts(at, "double ") && !strstr(at, "(*")) {
            if (!group && !comment_has_unit(s, k)) complain(s, k, "a double without a unit such as [m2/s] or [-]");
        } else if (!starts(at, "/*") && !starts(at, "*") && strchr(at, ';')) {
            group = 0;
        }
    }
}

static void check_module(const source *s)
{
    for (int k = 0; k < s->lines; k++)
        if (starts(s->line[k], "#define ")) check_macro(s, k);
    if (s->is_header) {
        check_header_names(s);
        check_mapped_names(s);
        check_units(s);
    } else {
        check_source_names(s);
    }
}

/* ---- files ---- */

static char *read_text(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    size_t room = 1 << 16, got;
    char *text = (char *)malloc(room);
    *size = 0;
    while (text && (got = fread(text + *size, 1, room - *size - 1, file)) > 0) {
        *size += got;
        if (room - *size < 2) text = (char *)realloc(text, room *= 2);
    }
    if (!text) out_of_memory();
    text[*size] = 0;
    fclose(file);
    return text;
}

static void split_lines(source *s)
{
    for (const char *c = s->text; *c; c++) s->lines += *c == '\n';
    s->line = (char **)malloc(sizeof(char *) * (size_t)(s->lines + 1));
    if (!s->line) out_of_memory();
    char *at = s->text;
    for (int k = 0; k < s->lines; k++) {
        char *end = strchr(at, '\n');
        *end = 0;
        s->line[k] = at;
        at = end + 1;
    }
    if (*at) complain(s, s->lines, "the file does not end with a newline");
}

/* The name of a file without its folders. */
static const char *name_of(const char *path)
{
    const char *last = strrchr(path, '/');
    return last ? last + 1 : path;
}

static void check_file(const char *path)
{
    source s;
    size_t size;
    memset(&s, 0, sizeof s);
    s.path = path;
    s.text = read_text(path, &size);
    if (!s.text) {
        complain(&s, 0, "cannot be read");
        return;
    }
    if (strlen(s.text) == size) { /* else binary: a picture */
        files++;
        s.is_header = ends(path, ".h");
        s.is_code = s.is_header || ends(path, ".c") || ends(path, ".sh");
        if (starts(path, "src/") && (s.is_header || ends(path, ".c")))
            snprintf(s.module, sizeof s.module, "%.*s", (int)strlen(name_of(path)) - 2, name_of(path));
        split_lines(&s);
        check_text(&s);
        if (s.is_code) check_code(&s);
        if (s.module[0]) check_module(&s);
        free(s.line);
    }
    free(s.text);
}

static void check_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    if (!dir) return;
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        char path[PATH_SIZE];
        if (entry->d_name[0] == '.') continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        DIR *below = opendir(path);
        if (below) {
            closedir(below);
            check_folder(path);
        } else {
            check_file(path);
        }
    }
    closedir(dir);
}

int main(int argc, char **argv)
{
    for (int k = 1; k < argc; k++) check_file(argv[k]);
    if (argc < 2) {
        for (size_t k = 0; k < sizeof folders / sizeof folders[0]; k++) check_folder(folders[k]);
        for (size_t k = 0; k < sizeof root_texts / sizeof root_texts[0]; k++) {
            FILE *file = fopen(root_texts[k], "rb");
            if (!file) continue;
            fclose(file);
            check_file(root_texts[k]);
        }
    }
    printf("lint: %d files, %d complaints\n", files, complaints);
    return complaints > 0 || fflush(stdout) != 0;
}
