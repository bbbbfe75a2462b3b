/* amalgamate: joins the modules of src/ into a header, or into two.
 *
 *   amalgamate [--check | --rules] [--skip-missing] SRC LICENSE OUT [APP]
 *
 * A line of SRC/MODULES names a room, which is a folder of SRC, and its modules in order. The output is: banner with
 * contents, the public part of every header in order, and under PDCORR_IMPLEMENTATION what headers have under
 * PDI_INTERNAL, and every .c, in order. Lines are copied as they are; only those that include another module are left
 * out. Rooms of a line `app` go to APP, which includes OUT; there the macros are PDCORR_APP_IMPLEMENTATION or the one
 * of OUT, and PDI_APP_INTERNAL. Refused: include cycles, a module that includes a later one, files of SRC that no
 * module owns, a module without header. --check compares with OUT and APP instead of writing them, --rules stops after
 * the refusals, --skip-missing passes over modules that have no header yet.
 *
 * Other lines of MODULES, behind those of the rooms:
 *   app: ROOM...                what reads scenes, writes files and draws
 *   cut MACRO: ROOM...          the macro leaves these rooms, or modules as ROOM/NAME, out; refused when one that
 *                               stays uses one of them
 *   cold N: ROOM or MODULE...   no loop of theirs gains from more than -O<N>, which gcc then compiles their .c with;
 *                               N: g, 1 or 2; 3: all but the passes that loops of vectors do not gain from; of two
 *                               lines that name a module the later one counts
 *   small: ROOM or MODULE...    compiled to be small where programs are sent over a network, as those of -Og to -O2 are
 */
#define _POSIX_C_SOURCE 200809L
#include <ctype.h>
#include <dirent.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_MODULES 320
#define MAX_CUTS 8
#define NAME_SIZE 48
#define PATH_SIZE 1024

typedef struct module {
    char name[NAME_SIZE];
    char room[NAME_SIZE];
    char path[2 * NAME_SIZE]; /* room/name */
    char *header, *source; /* texts; NULL: no such file */
    char uses[MAX_MODULES]; /* 1: a file of this module includes that module */
    unsigned cuts; /* bit k: cut k leaves it out */
    char level; /* of optimisation that its .c gains from; 0: whatever the compiler has */
    int small;  /* named by a line `small` */
    int app;    /* it goes to the second header */
    char *visible, *hidden; /* parts of the header: public, and of PDI_INTERNAL; NULL: nothing stands there */
    int seen; /* of the cycle search: 1 on the path, 2 finished */
} module;

typedef struct text {
    char *data;
    size_t size, room;
} text;

static module modules[MAX_MODULES];
static int module_count;
static char cuts[MAX_CUTS][NAME_SIZE]; /* macros */
static int cut_count;

static void die(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fprintf(stderr, "amalgamate: ");
    vfprintf(stderr, format, args);
    fprintf(stderr, "\n");
    va_end(args);
    exit(1);
}

static void append(text *t, const char *data, size_t size)
{
    if (t->size + size + 1 > t->room) {
        t->room = 2 * (t->size + size + 1);
        t->data = (char *)realloc(t->data, t->room);
        if (!t->data) die("out of memory");
    }
    memcpy(t->data + t->size, data, size);
    t->size += size;
    t->data[t->size] = 0;
}

static void append_line(text *t, const char *format, ...)
{
    char line[512];
    va_list args;
    va_start(args, format);
    int size = vsnprintf(line, sizeof line, format, args);
    va_end(args);
    if (size < 0 || (size_t)size >= sizeof line) die("a generated line is too long: %s", line);
    append(t, line, (size_t)size);
    append(t, "\n", 1);
}

/* The text of a file, NULL when it does not exist. */
static char *read_text(const char *path)
{
    text t = {NULL, 0, 0};
    char block[65536];
    size_t size;
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    append(&t, "", 0);
    while ((size = fread(block, 1, sizeof block, file)) > 0) append(&t, block, size);
    if (ferror(file)) die("%s: cannot be read", path);
    fclose(file);
    if (strlen(t.data) != t.size) die("%s: holds a zero byte", path);
    if (t.size == 0 || t.data[t.size - 1] != '\n') die("%s: does not end with a newline", path);
    return t.data;
}

static const char *next_line(const char *line)
{
    const char *end = strchr(line, '\n');
    return end ? end + 1 : line + strlen(line);
}

static int find_module(const char *name, size_t size)
{
    for (int k = 0; k < module_count; k++)
        if (strlen(modules[k].name) == size && memcmp(modules[k].name, name, size) == 0) return k;
    return -1;
}

static int find_path(const char *path, size_t size)
{
    for (int k = 0; k < module_count; k++)
        if (strlen(modules[k].path) == size && memcmp(modules[k].path, path, size) == 0) return k;
    return -1;
}

/* What follows the name of a directive that begins with `name`; NULL: the line is none. */
static const char *behind_directive(const char *line, const char *name)
{
    while (*line == ' ') line++;
    if (*line++ != '#') return NULL;
    while (*line == ' ') line++;
    return strncmp(line, name, strlen(name)) == 0 ? line + strlen(name) : NULL;
}

/* 1 when the line is `#include "file"`. */
static int local_include(const char *line, const char **file, size_t *size)
{
    line = behind_directive(line, "include");
    if (!line) return 0;
    while (*line == ' ') line++;
    if (*line != '"') return 0;
    *file = line + 1;
    *size = strcspn(*file, "\"\n");
    return 1;
}

static void add_module(const char *src, const char *room, const char *name, int skip_missing)
{
    char path[PATH_SIZE];
    if (find_module(name, strlen(name)) >= 0) die("%s/MODULES: %s is listed twice", src, name);
    if (module_count == MAX_MODULES) die("%s/MODULES: more than %d modules", src, MAX_MODULES);
    module *m = &modules[module_count];
    snprintf(path, sizeof path, "%s/%s/%s.h", src, room, name);
    m->header = read_text(path);
    if (!m->header && skip_missing) return;
    if (!m->header) die("%s: not found, but MODULES lists %s", path, name);
    snprintf(path, sizeof path, "%s/%s/%s.c", src, room, name);
    m->source = read_text(path);
    strcpy(m->name, name);
    strcpy(m->room, room);
    snprintf(m->path, sizeof m->path, "%s/%s", room, name);
    module_count++;
}

/* The words from `at` to the end of the line: rooms and paths of modules of a cut, or, cut < 0, of a level (0: small),
 * or the app ('a'), which take names of modules, too. */
static void mark_modules(const char *src, const char *at, const char *end, int cut, char level)
{
    char name[NAME_SIZE];
    int size;
    for (; at < end && sscanf(at, " %47s%n", name, &size) == 1 && at + size <= end; at += size) {
        int found = 0;
        for (int k = 0; k < module_count; k++) {
            module *m = &modules[k];
            if (strcmp(m->room, name) != 0 && strcmp(m->path, name) != 0 && (cut >= 0 || strcmp(m->name, name) != 0))
                continue;
            if (cut >= 0) m->cuts |= 1u << cut;
            else if (level == 'a') m->app = 1;
            else if (level) m->level = level;
            else m->small = 1;
            found = 1;
        }
        if (!found) die("%s/MODULES: %s is no room or module that stands before", src, name);
    }
}

static int read_mark(const char *src, const char *line, const char *end)
{
    char name[NAME_SIZE];
    int size = 0;
    if (strncmp(line, "cold ", 5) == 0 && line[5] && strchr("g123", line[5]) && line[6] == ':') {
        mark_modules(src, line + 7, end, -1, line[5]);
        return 1;
    }
    if (strncmp(line, "app:", 4) == 0) {
        mark_modules(src, line + 4, end, -1, 'a');
        return 1;
    }
    if (strncmp(line, "small:", 6) == 0) {
        mark_modules(src, line + 6, end, -1, 0);
        return 1;
    }
    if (sscanf(line, "cut %47[A-Z_]:%n", name, &size) != 1 || !size) return 0;
    if (cut_count == MAX_CUTS) die("%s/MODULES: more than %d cuts", src, MAX_CUTS);
    strcpy(cuts[cut_count], name);
    mark_modules(src, line + size, end, cut_count++, 0);
    return 1;
}

static void read_modules(const char *src, int skip_missing)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, "%s/MODULES", src);
    const char *line = read_text(path);
    if (!line) die("%s: not found", path);
    for (; *line; line = next_line(line)) {
        char room[NAME_SIZE], name[NAME_SIZE];
        int size;
        if (*line == '#' || *line == '\n') continue;
        const char *at = line, *end = line + strcspn(line, "\n");
        if (read_mark(src, line, end)) continue;
        for (int k = 0; at < end && sscanf(at, " %47s%n", k ? name : room, &size) == 1; k++) {
            at += size;
            if (at > end) break;
            if (k) add_module(src, room, name, skip_missing);
        }
    }
    if (!module_count) die("%s: lists no module", path);
}

/* Files of a room, or of SRC itself, which holds rooms and MODULES. */
static void refuse_unowned_files(const char *src, const char *room)
{
    char path[PATH_SIZE];
    snprintf(path, sizeof path, *room ? "%s/%s" : "%s", src, room);
    DIR *dir = opendir(path);
    if (!dir) die("%s/%s: no module of MODULES owns this file", src, room);
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir)) {
        const char *name = entry->d_name, *dot = strrchr(name, '.');
        if (name[0] == '.' || (!*room && strcmp(name, "MODULES") == 0)) continue;
        if (!*room) {
            refuse_unowned_files(src, name);
            continue;
        }
        int is_code = dot && (strcmp(dot, ".h") == 0 || strcmp(dot, ".c") == 0);
        int owner = is_code ? find_module(name, (size_t)(dot - name)) : -1;
        if (owner < 0 || strcmp(modules[owner].room, room) != 0)
            die("%s/%s: no module of MODULES owns this file", path, name);
    }
    closedir(dir);
}

static void note_uses(module *m, const char *data, const char *ending)
{
    for (const char *line = data; line && *line; line = next_line(line)) {
        const char *file;
        size_t size;
        if (!local_include(line, &file, &size)) continue;
        int used = size > 2 && memcmp(file + size - 2, ".h", 2) == 0 ? find_path(file, size - 2) : -1;
        if (used < 0) die("%s%s includes \"%.*s\", which no module owns", m->name, ending, (int)size, file);
        if (&modules[used] != m) m->uses[used] = 1;
        else if (ending[1] == 'h') die("%s.h includes itself", m->name);
    }
}

static void refuse_cycles(int k, int depth, int *path)
{
    path[depth] = k;
    modules[k].seen = 1;
    for (int used = 0; used < module_count; used++) {
        if (!modules[k].uses[used] || modules[used].seen == 2) continue;
        if (modules[used].seen == 0) {
            refuse_cycles(used, depth + 1, path);
            continue;
        }
        char text_of_cycle[PATH_SIZE] = "";
        int first = depth;
        while (path[first] != used) first--;
        for (; first <= depth; first++) {
            size_t length = strlen(text_of_cycle);
            snprintf(text_of_cycle + length, sizeof text_of_cycle - length, "%s -> ", modules[path[first]].name);
        }
        die("include cycle: %s%s", text_of_cycle, modules[used].name);
    }
    modules[k].seen = 2;
}

static void refuse_reaching_up(void)
{
    for (int k = 0; k < module_count; k++)
        for (int used = k + 1; used < module_count; used++)
            if (modules[k].uses[used])
                die("%s reaches up: it includes %s, which stands later in MODULES", modules[k].path,
                    modules[used].path);
}

/* 1: a line of a header that declares nothing: blank, an include, a guard. */
static int declares_nothing(const module *m, const char *line)
{
    const char *file;
    size_t size;
    char guard[NAME_SIZE + 16];
    if (*line == '\n' || local_include(line, &file, &size)) return 1;
    if (strncmp(line, "#endif", 6) == 0) return 1;
    snprintf(guard, sizeof guard, "PD_%.40s_H\n", m->name);
    for (char *c = guard; *c; c++) *c = (char)toupper((unsigned char)*c);
    return (strncmp(line, "#ifndef ", 8) == 0 && strncmp(line + 8, guard, strlen(guard)) == 0) ||
           (strncmp(line, "#define ", 8) == 0 && strncmp(line + 8, guard, strlen(guard)) == 0);
}

/* Parts the header into what all see and what stands under PDI_INTERNAL. */
static void part_header(module *m)
{
    text visible = {NULL, 0, 0}, hidden = {NULL, 0, 0};
    const char *macro = m->app ? "#ifdef PDI_APP_INTERNAL\n" : "#ifdef PDI_INTERNAL\n";
    int depth = 0, within = 0, lines = 0, comment = 0;
    append(&visible, "", 0);
    append(&hidden, "", 0);
    for (const char *line = m->header; *line; line = next_line(line)) {
        size_t size = (size_t)(next_line(line) - line);
        if (behind_directive(line, "if")) depth++;
        if (!within && strncmp(line, macro, strlen(macro)) == 0) {
            if (depth > 2) die("%s.h: what is internal stands under another condition", m->path);
            within = depth;
            continue;
        }
        if (within && depth == within && (behind_directive(line, "el") || behind_directive(line, "endif"))) {
            if (!behind_directive(line, "endif")) die("%s.h: what is internal has another branch", m->path);
            within = 0;
            depth--;
            continue;
        }
        if (behind_directive(line, "endif")) depth--;
        /* what stood apart from a part that is cut out needs one blank line, not two, and the end of the guard none */
        const char *end = visible.size > 1 ? visible.data + visible.size - 2 : "";
        if (!depth && behind_directive(line, "endif") && strcmp(end, "\n\n") == 0) visible.data[--visible.size] = '\0';
        int again = !within && *line == '\n' && strcmp(end, "\n\n") == 0;
        if (!again) append(within ? &hidden : &visible, line, size);
        if (within) continue;
        if (strncmp(line, "/*", 2) == 0) comment = 1;
        lines += !comment && !declares_nothing(m, line);
        const char *close = strstr(line, "*/");
        if (close && close < line + size) comment = 0;
    }
    m->visible = lines ? visible.data : NULL;
    m->hidden = lines && !hidden.size ? NULL : lines ? hidden.data : m->header;
}

/* What a macro leaves out, nothing that stays may use. */
static void refuse_torn_cuts(void)
{
    for (int k = 0; k < module_count; k++)
        for (int used = 0; used < module_count; used++)
            for (int cut = 0; cut < cut_count; cut++)
                if (modules[k].uses[used] && (modules[used].cuts & ~modules[k].cuts) >> cut & 1u)
                    die("%s leaves out %s, which %s uses", cuts[cut], modules[used].path, modules[k].path);
}

/* The version, from the lines #define PD_VERSION_MAJOR 0, _MINOR and _PATCH of config.h. */
static void find_version(char *version, size_t room)
{
    static const char *const parts[] = {"MAJOR", "MINOR", "PATCH"};
    int config = find_module("config", 6), number[3];
    for (int k = 0; k < 3; k++) {
        char line[NAME_SIZE];
        snprintf(line, sizeof line, "#define PD_VERSION_%s ", parts[k]);
        const char *at = config < 0 ? NULL : strstr(modules[config].header, line);
        if (!at || sscanf(at + strlen(line), "%d", &number[k]) != 1)
            die("config.h: no line #define PD_VERSION_%s with a number", parts[k]);
    }
    snprintf(version, room, "%d.%d.%d", number[0], number[1], number[2]);
}

/* What follows "name: " in the first line of the header. */
static void describe(const module *m, char *out, size_t room)
{
    char start[NAME_SIZE + 8];
    snprintf(start, sizeof start, "/* %.*s: ", NAME_SIZE - 1, m->name);
    if (strncmp(m->header, start, strlen(start)) != 0)
        die("%s.h: the first line has to begin with '%s'", m->name, start);
    const char *at = m->header + strlen(start);
    snprintf(out, room, "%.*s", (int)strcspn(at, "\n"), at);
    char *end = strstr(out, " */");
    if (end) *end = 0;
}

static void append_contents(text *out, int app)
{
    const module *last = NULL;
    char about[128];
    for (int k = 0; k < module_count; k++) {
        const module *m = &modules[k];
        if (m->app != app) continue;
        if (!last || strcmp(m->room, last->room) != 0) append_line(out, " *   %s/", m->room);
        describe(m, about, sizeof about);
        append_line(out, " *     %-10s %s", m->name, about);
        last = m;
    }
    append_line(out, " */");
}

/* Name of a file without its folders. */
static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Programs that compile the second header here. */
static const char *const app_implementation =
    "defined(PDCORR_IMPLEMENTATION) || defined(PDCORR_STATIC) || defined(PDCORR_APP_IMPLEMENTATION)";

static void append_app_banner(text *out, const char *kernel)
{
    static const char *const lines[] = {
        " *",
        " * Generated by `make amalgam` from the modules in src/; changes belong there.",
        " *",
        " * HOW TO USE",
        " *   Copy this file and pdcorr.h into your project, and include this one in place of that one. In exactly one",
        " *   file for each space dimension write",
        " *       #define PD_DIM 2                 (1, 2 or 3)",
        " *       #define PDCORR_IMPLEMENTATION",
        " *       #include \"pdcorr_app.h\"",
        " *   With PDCORR_APP_IMPLEMENTATION in its place this file alone is compiled, and another one has",
        " *   pdcorr.h: it uses nothing of pdcorr.h but what all programs see.",
        " *       #define PDCORR_NO_SCENE          leaves out scene and run",
        " *",
        " * CONTENTS (search for >> and the file name, for example >>io/png.h)",
    };
    char version[32];
    find_version(version, sizeof version);
    append_line(out, "/* pdcorr_app %s: scenes, files and pictures for pdcorr.", version);
    append_line(out, " * MIT licence, see the end of this file.");
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) append_line(out, "%s", lines[k]);
    append_contents(out, 1);
    append_line(out, "#include \"%s\"", base_name(kernel));
    append_line(out, "#if %s", app_implementation);
    append_line(out, "#define PDI_APP_INTERNAL 1");
    append_line(out, "#endif");
}

static void append_banner(text *out)
{
    static const char *const lines[] = {
        " *",
        " * Generated by `make amalgam` from the modules in src/; changes belong there.",
        " *",
        " * HOW TO USE",
        " *   Copy this file into your project. In exactly one C or C++ file for each space dimension write",
        " *       #define PD_DIM 2                 (1, 2 or 3)",
        " *       #define PDCORR_IMPLEMENTATION",
        " *       #include \"pdcorr.h\"",
        " *   and leave PDCORR_IMPLEMENTATION out everywhere else. With PDCORR_STATIC in its place all is private to",
        " *   the file, and what it does not call costs neither time nor room. Any C99 or C++11 compiler will do:",
        " *       cc -std=c99 -O3 -march=native -ffp-contract=off -fopenmp prog.c -lm",
        " *   Rooms that a program does not use can be left out; put these lines above the inclusion, too:",
        " *       #define PDCORR_NO_MODEL          leaves out setup and physics, of which scenes are made",
        " *       #define PDCORR_NO_SOLID          leaves out mechanics: solid, couple/solid_coupling, and those",
        " *       #define PDCORR_NO_PHYSICS        leaves out flow, transport, metal, couple and those: kernels stay",
        " *   A file may leave out more than the one with PDCORR_IMPLEMENTATION. gcc compiles what runs spend no time",
        " *   in with -Og to -O2 where the file has -O3. Scenes, files and pictures stand in pdcorr_app.h.",
        " *   OpenMP is optional and does not change a bit of the results. Linked names carry the dimension, so that",
        " *   several dimensions live in one program. Start with pd_ctx_init; every call that can fail returns a",
        " *   pd_status, and pd_ctx.message then says what, where and how to mend.",
        " *",
        " * IT DOES NOT",
        " *   exit, print, keep globals, or assert on input;",
        " *   read or write a file unless you call a function that says so;",
        " *   need memory within a step (a linear solver that stalls takes some, gives it back, and does without where",
        " *   there is none), or allocate outside the allocator of the context;",
        " *   need another library, a mesh, a graphics card or MPI;",
        " *   share a context between threads of the caller: one context a thread.",
        " *",
        " * CONTENTS (search for >> and the file name, for example >>core/config.h)",
    };
    char version[32];
    find_version(version, sizeof version);
    append_line(out, "/* pdcorr %s: peridynamic corrosion simulation in one C99 header.", version);
    append_line(out, " * MIT licence, see the end of this file.");
    for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) append_line(out, "%s", lines[k]);
    append_contents(out, 0);
}

static void append_file(text *out, const module *m, const char *data, const char *ending)
{
    char tag[2 * NAME_SIZE + 8];
    snprintf(tag, sizeof tag, ">>%s%s", m->path, ending);
    append_line(out, "\n/* ======== %s ======== */", tag);
    for (const char *line = data; *line; line = next_line(line)) {
        const char *file;
        size_t size;
        if (!local_include(line, &file, &size)) append(out, line, (size_t)(next_line(line) - line));
    }
}

/* Is it compiled to be small, where that is asked for? */
static int small(const module *m)
{
    return m->small || m->level == 'g' || m->level == '1' || m->level == '2';
}

/* Guards of neighbours that the same macros leave out; their level of optimisation. */
static void close_guards(text *out, const module *last, int sources)
{
    if (sources && last->level) append_line(out, "#ifdef PDI_COLD\n#pragma GCC pop_options");
    if (sources && small(last))
        append_line(out, "%s\n#pragma clang attribute pop",
                    last->level ? "#elif defined(PDI_OPTIMISE_SIZE)" : "#ifdef PDI_OPTIMISE_SIZE");
    if (sources && (last->level || small(last))) append_line(out, "#endif");
    if (last->cuts) append_line(out, "#endif /* cut */");
}

static void open_guards(text *out, const module *m, int sources)
{
    char line[MAX_CUTS * (NAME_SIZE + 16)] = "\n#if";
    for (int cut = 0; cut < cut_count; cut++)
        if (m->cuts >> cut & 1u)
            snprintf(line + strlen(line), sizeof line - strlen(line), "%s !defined(%s)", line[4] ? " &&" : "",
                     cuts[cut]);
    if (m->cuts) append_line(out, "%s", line);
    if (!sources || !(m->level || small(m))) return;
    if (m->level) append_line(out, "\n#ifdef PDI_COLD\n#pragma GCC push_options");
    if (m->level == '3')
        append_line(out, "#pragma GCC optimize (\"no-gcse-after-reload\", \"no-schedule-insns2\", \"no-split-paths\")");
    else if (m->level) append_line(out, "#pragma GCC optimize (\"O%c\")", m->level);
    if (small(m))
        append_line(out, "%s\n#pragma clang attribute push (__attribute__((minsize)), apply_to = function)",
                    m->level ? "#elif defined(PDI_OPTIMISE_SIZE)" : "\n#ifdef PDI_OPTIMISE_SIZE");
    append_line(out, "#endif");
}

/* What headers show, what they hide, or the sources, of one of the two outputs. */
typedef enum part { VISIBLE, HIDDEN, SOURCES } part;

static void append_modules(text *out, part what, int app)
{
    const module *last = NULL;
    int sources = what == SOURCES;
    for (int k = 0; k < module_count; k++) {
        const module *m = &modules[k];
        const char *lines = what == VISIBLE ? m->visible : what == HIDDEN ? m->hidden : m->source;
        if (m->app != app || !lines) continue;
        if (!last || last->cuts != m->cuts || (sources && (last->level != m->level || small(last) != small(m)))) {
            if (last) close_guards(out, last, sources);
            open_guards(out, m, sources);
        }
        append_file(out, m, lines, sources ? ".c" : what == HIDDEN && m->visible ? ".h, internal" : ".h");
        last = m;
    }
    if (last) close_guards(out, last, sources);
}

static void append_licence(text *out, const char *path)
{
    const char *licence = read_text(path);
    if (!licence) die("%s: not found", path);
    if (strstr(licence, "*/")) die("%s: would end its comment", path);
    append_line(out, "\n/* ======== >>licence ========");
    for (const char *line = licence; *line; line = next_line(line)) {
        size_t size = strcspn(line, "\n");
        append_line(out, size ? " * %.*s" : " *%.*s", (int)size, line);
    }
    append_line(out, " */");
}

/* What the sources know of each other. */
static void append_hidden(text *out, int app, const char *macro)
{
    append_line(out, "\n/* ======== >>internal ======== */");
    append_line(out, "#if defined(%s) && !defined(%s_DECLARED)", macro, macro);
    append_line(out, "#define %s_DECLARED", macro);
    append_modules(out, HIDDEN, app);
    append_line(out, "#endif /* %s */", macro);
}

static void append_all(text *out, const char *licence)
{
    append_banner(out);
    append_modules(out, VISIBLE, 0);
    append_hidden(out, 0, "PDI_INTERNAL");
    append_line(out, "\n/* ======== >>implementation ======== */");
    append_line(out, "#if (defined(PDCORR_IMPLEMENTATION) || defined(PDCORR_STATIC)) && !defined(PDI_IMPLEMENTED)");
    append_line(out, "#define PDI_IMPLEMENTED");
    append_line(out, "#ifndef PDI_INTERNAL");
    append_line(out, "#error \"pdcorr: define PDCORR_IMPLEMENTATION before the first inclusion in this file\"");
    append_line(out, "#else");
    append_modules(out, SOURCES, 0);
    append_line(out, "\n#endif");
    append_line(out, "#endif /* PDCORR_IMPLEMENTATION */");
    append_licence(out, licence);
}

static void append_app(text *out, const char *kernel, const char *licence)
{
    append_app_banner(out, kernel);
    append_modules(out, VISIBLE, 1);
    append_hidden(out, 1, "PDI_APP_INTERNAL");
    append_line(out, "\n/* ======== >>implementation ======== */");
    append_line(out, "#if (%s) && \\\n    !defined(PDI_APP_IMPLEMENTED)", app_implementation);
    append_line(out, "#define PDI_APP_IMPLEMENTED");
    append_modules(out, SOURCES, 1);
    append_line(out, "#endif /* PDCORR_APP_IMPLEMENTATION */");
    append_licence(out, licence);
}

/* Written aside and renamed: a reader sees the old file or the new one. */
static void write_text(const char *path, const text *out)
{
    char aside[PATH_SIZE];
    snprintf(aside, sizeof aside, "%s.new", path);
    FILE *file = fopen(aside, "wb");
    if (!file) die("%s: cannot be written", aside);
    int bad = fwrite(out->data, 1, out->size, file) != out->size;
    bad = fclose(file) != 0 || bad;
    if (bad || rename(aside, path) != 0) {
        remove(aside);
        die("%s: cannot be written", path);
    }
}

static void check_text(const char *path, const text *out)
{
    const char *old = read_text(path), *fresh = out->data;
    if (!old) die("%s: not found; run `make amalgam`", path);
    if (strcmp(old, fresh) == 0) return;
    int line = 1;
    for (; *old && *old == *fresh; old++, fresh++) line += *old == '\n';
    die("%s is stale (first difference in line %d); run `make amalgam`", path, line);
}

static void deliver(const char *path, const text *out, int check)
{
    if (check) check_text(path, out);
    else write_text(path, out);
}

int main(int argc, char **argv)
{
    const char *name[4] = {NULL, NULL, NULL, NULL};
    int names = 0, check = 0, rules = 0, skip_missing = 0, path[MAX_MODULES];
    text out = {NULL, 0, 0}, app = {NULL, 0, 0};
    for (int k = 1; k < argc; k++) {
        if (strcmp(argv[k], "--check") == 0) check = 1;
        else if (strcmp(argv[k], "--rules") == 0) rules = 1;
        else if (strcmp(argv[k], "--skip-missing") == 0) skip_missing = 1;
        else if (argv[k][0] != '-' && names < 4) name[names++] = argv[k];
        else names = 5;
    }
    if (names != 3 && names != 4) die("usage: amalgamate [--check | --rules] [--skip-missing] SRC LICENSE OUT [APP]");
    read_modules(name[0], skip_missing);
    refuse_unowned_files(name[0], "");
    for (int k = 0; k < module_count; k++) {
        note_uses(&modules[k], modules[k].header, ".h");
        note_uses(&modules[k], modules[k].source, ".c");
    }
    for (int k = 0; k < module_count; k++)
        if (modules[k].seen == 0) refuse_cycles(k, 0, path);
    refuse_reaching_up();
    refuse_torn_cuts();
    if (rules) return 0;
    for (int k = 0; k < module_count; k++) {
        if (modules[k].app && names < 4) die("%s/MODULES has an app, but no second output is named", name[0]);
        part_header(&modules[k]);
    }
    append_all(&out, name[1]);
    deliver(name[2], &out, check);
    if (names < 4) return 0;
    append_app(&app, name[2], name[1]);
    deliver(name[3], &app, check);
    return 0;
}
