/* file: see file.h */
#include "io/file.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <fcntl.h>
#if defined(_WIN32)
#include <direct.h>
#include <io.h>
#include <wchar.h>
/* As in windows.h, which defines thousands of other names; rename() does not replace there. */
#ifdef __cplusplus
extern "C" {
#endif
__declspec(dllimport) int __stdcall MoveFileExW(const wchar_t *from, const wchar_t *to, unsigned long flags);
__declspec(dllimport) int __stdcall MultiByteToWideChar(unsigned page, unsigned long flags, const char *text, int size,
                                                        wchar_t *wide, int room);
#ifdef __cplusplus
}
#endif
#define PDI_FILE_SEPARATORS "/\\"
#else
#include <unistd.h>
/* Headers of strict C99 leave these out. */
#if defined(__STRICT_ANSI__) && !defined(__cplusplus) && (!defined(_POSIX_C_SOURCE) || _POSIX_C_SOURCE < 200112L)
extern FILE *fdopen(int descriptor, const char *mode);
extern ssize_t readlink(const char *path, char *text, size_t size);
#endif
#define PDI_FILE_SEPARATORS "/"
#endif
/* Error numbers of this module, beside the positive ones of errno. */
#define PDI_FILE_ERROR_BUSY (-1)
#define PDI_FILE_ERROR_PIPE (-2)
#define PDI_FILE_ERROR_DEVICE (-3)
#define PDI_FILE_ERROR_LINK (-4)
#define PDI_FILE_CREATE_ATTEMPTS 8 /* attempts to create a file that another program recreates */

/* Text of an error number: errno, or one of the negative numbers above. */
static const char *pdi_file_error_text(int error)
{
    switch (error) {
    case PDI_FILE_ERROR_BUSY: return "another program has it open, or it is read-only";
    case PDI_FILE_ERROR_PIPE: return "it is a pipe or a socket, expected a file";
    case PDI_FILE_ERROR_DEVICE: return "it is a device, expected a file";
    case PDI_FILE_ERROR_LINK: return "it is a link, expected a file of its own";
    case 0: return "unknown reason";
    default: return strerror(error);
    }
}

/* Report "cannot <what> '<path>': <reason>" as PD_ERR_FILE. */
static pd_status pdi_file_fail(pd_ctx *ctx, const char *what, const char *path, int error)
{
    return pd_fail(ctx, PD_ERR_FILE, "file", "cannot %s '%s': %s", what, path, pdi_file_error_text(error));
}

/* Check a path. PD_ERR_ARGUMENT: it is NULL or empty; PD_ERR_SIZE: it does not fit PD_PATH_SIZE. */
static pd_status pdi_file_check_path(pd_ctx *ctx, const char *path)
{
    if (!path || !path[0]) return pd_fail(ctx, PD_ERR_ARGUMENT, "file", "the path is empty");
    if (strlen(path) >= PD_PATH_SIZE)
        return pd_fail(ctx, PD_ERR_SIZE, "file", "a path of %lu characters, at most %d are possible: %.80s...",
                       (unsigned long)strlen(path), PD_PATH_SIZE - 1, path);
    return PD_OK;
}

/* Paths are UTF-8. Windows has functions of its own for them: those of the C library take a code page there. */

#if defined(_WIN32)
PDI_FN const wchar_t *pdi_file_to_utf16(const char *path, wchar_t *wide)
{
    const unsigned utf8 = 65001; /* CP_UTF8 */
    if (!MultiByteToWideChar(utf8, 0, path, -1, wide, PDI_FILE_UTF16_SIZE)) wide[0] = 0;
    return wide;
}
#endif

#if defined(_WIN32)
/* Attributes of a path. Returns 0 or an error number. */
static int pdi_file_stat(const char *path, struct __stat64 *info)
{
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    errno = 0;
    return _wstat64(pdi_file_to_utf16(path, wide), info) == 0 ? 0 : errno ? errno : EACCES;
}

/* Returns 0 for a regular file, else an error number that says what it is. */
static int pdi_file_check_regular(const struct __stat64 *info)
{
    if (info->st_mode & _S_IFREG) return 0;
    return info->st_mode & _S_IFDIR ? EISDIR : PDI_FILE_ERROR_DEVICE;
}

PDI_FN int pdi_file_is_link(const char *path)
{
    (void)path; /* files are made there as such, and replaced */
    return 0;
}

PDI_FN int pdi_file_exists(const char *path)
{
    struct __stat64 info;
    return pdi_file_stat(path, &info) == 0;
}

/* Open a regular file to read. *size: its length [byte]. NULL with *error set: it is none, or cannot be opened. */
static FILE *pdi_file_open_read_stream(const char *path, double *size, int *error)
{
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    struct __stat64 info;
    *error = pdi_file_stat(path, &info);
    if (!*error) *error = pdi_file_check_regular(&info);
    if (*error) return NULL;
    *size = (double)info.st_size;
    FILE *stream = _wfopen(pdi_file_to_utf16(path, wide), L"rb");
    if (!stream) *error = errno ? errno : EACCES;
    return stream;
}

/* Create a file that must not exist, and open it to write; exclusive creation follows no link. NULL with *error set on
 * failure. */
static FILE *pdi_file_create_stream(const char *path, int *error)
{
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    const int anew = _O_CREAT | _O_EXCL | _O_WRONLY | _O_BINARY;
    errno = 0;
    int descriptor = _wopen(pdi_file_to_utf16(path, wide), anew, _S_IREAD | _S_IWRITE);
    FILE *stream = descriptor < 0 ? NULL : _fdopen(descriptor, "wb");
    *error = stream ? 0 : errno ? errno : EACCES;
    if (!stream && descriptor >= 0) _close(descriptor);
    return stream;
}

/* Open a file to append; a missing one is created, and links are not checked. NULL with *error set on failure. */
static FILE *pdi_file_open_append_stream(const char *path, int *error)
{
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    errno = 0;
    FILE *stream = _wfopen(pdi_file_to_utf16(path, wide), L"ab");
    *error = stream ? 0 : errno ? errno : EACCES;
    return stream;
}
#else
/* Returns 0 for a regular file, else an error number that says what it is. */
static int pdi_file_check_regular(const struct stat *info)
{
    if (S_ISREG(info->st_mode)) return 0;
    if (S_ISDIR(info->st_mode)) return EISDIR;
    return S_ISCHR(info->st_mode) || S_ISBLK(info->st_mode) ? PDI_FILE_ERROR_DEVICE : PDI_FILE_ERROR_PIPE;
}

PDI_FN int pdi_file_is_link(const char *path)
{
    char first;
    return readlink(path, &first, 1) >= 0;
}

PDI_FN int pdi_file_exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0;
}

/* Open an existing regular file with these flags, without blocking on a pipe. Returns a descriptor, or -1 with *error
 * set; *size: its length [byte]. */
static int pdi_file_open_descriptor(const char *path, int flags, double *size, int *error)
{
    struct stat info;
    int descriptor = -1;
    errno = 0;
    *error = stat(path, &info) == 0 ? pdi_file_check_regular(&info) : errno ? errno : EACCES;
    if (!*error) {
        descriptor = open(path, flags | O_NONBLOCK);
        if (descriptor < 0 || fstat(descriptor, &info) != 0) *error = errno ? errno : EACCES;
        else *error = pdi_file_check_regular(&info); /* another one has come in between */
    }
    *size = (double)info.st_size;
    if (*error && descriptor >= 0) close(descriptor);
    return *error ? -1 : descriptor;
}

/* Wrap a descriptor in a stream of the C library, which closes it. NULL with *error set on failure, when the descriptor
 * is closed; a descriptor of -1 gives NULL, and *error stays. */
static FILE *pdi_file_wrap_descriptor(int descriptor, const char *mode, int *error)
{
    FILE *stream = descriptor < 0 ? NULL : fdopen(descriptor, mode);
    if (stream || descriptor < 0) return stream;
    *error = errno ? errno : EACCES;
    close(descriptor);
    return NULL;
}

/* Open a regular file to read. *size: its length [byte]. NULL with *error set: it is none, or cannot be opened. */
static FILE *pdi_file_open_read_stream(const char *path, double *size, int *error)
{
    int descriptor = pdi_file_open_descriptor(path, O_RDONLY, size, error);
    return pdi_file_wrap_descriptor(descriptor, "rb", error);
}

/* Create a file that must not exist, and open it to write; exclusive creation follows no link. NULL with *error set on
 * failure. */
static FILE *pdi_file_create_stream(const char *path, int *error)
{
    errno = 0;
    int descriptor = open(path, O_CREAT | O_EXCL | O_WRONLY, 0666);
    *error = descriptor >= 0 ? 0 : errno ? errno : EACCES;
    return pdi_file_wrap_descriptor(descriptor, "wb", error);
}

/* Open a regular file to append, but none that is reached through a symbolic or a hard link. NULL with *error set on
 * failure. */
static FILE *pdi_file_open_append_stream(const char *path, int *error)
{
    struct stat ours, there;
    double size;
    int descriptor = pdi_file_open_descriptor(path, O_WRONLY | O_APPEND, &size, error);
    if (descriptor < 0) return NULL;
    if (pdi_file_is_link(path) || fstat(descriptor, &ours) != 0 || stat(path, &there) != 0 ||
        ours.st_ino != there.st_ino || ours.st_dev != there.st_dev || ours.st_nlink > 1) {
        close(descriptor);
        *error = PDI_FILE_ERROR_LINK;
        return NULL;
    }
    return pdi_file_wrap_descriptor(descriptor, "ab", error);
}
#endif

/* Delete one file, outside of Windows also an empty directory; failures are ignored. */
static void pdi_file_remove_path(const char *path)
{
#if defined(_WIN32)
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    _wremove(pdi_file_to_utf16(path, wide));
#else
    remove(path);
#endif
}

/* Directories. */

PDI_FN int pdi_file_is_separator(char c) { return c && strchr(PDI_FILE_SEPARATORS, c) != NULL; }

PDI_FN int pdi_file_is_absolute(const char *path)
{
#if defined(_WIN32)
    if (path[0] && path[1] == ':') return 1;
#endif
    return pdi_file_is_separator(path[0]);
}

/* Returns 1 for an existing directory, also through a link; else 0. */
static int pdi_file_is_directory(const char *path)
{
#if defined(_WIN32)
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    struct _stat info;
    return _wstat(pdi_file_to_utf16(path, wide), &info) == 0 && (info.st_mode & _S_IFDIR) != 0;
#else
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
#endif
}

/* Create one directory. Returns 0 or an error number; an existing directory is no error. */
static int pdi_file_make_one_directory(const char *path)
{
    int error = 0;
    errno = 0;
#if defined(_WIN32)
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    if (_wmkdir(pdi_file_to_utf16(path, wide)) != 0) error = errno ? errno : EACCES;
#else
    if (mkdir(path, 0777) != 0) error = errno ? errno : EACCES;
#endif
    return error && pdi_file_is_directory(path) ? 0 : error;
}

pd_status pd_file_make_directory(pd_ctx *ctx, const char *path)
{
    char partial[PD_PATH_SIZE];
    PD_TRY(pdi_file_check_path(ctx, path));
    strcpy(partial, path);
    /* Failures at parents are ignored: a parent may exist without write permission. The last call reports. */
    for (size_t i = 1; partial[i]; i++) {
        char separator = partial[i];
        if (!pdi_file_is_separator(separator)) continue;
        partial[i] = 0;
        (void)pdi_file_make_one_directory(partial);
        partial[i] = separator;
    }
    int error = pdi_file_make_one_directory(path);
    if (error) return pdi_file_fail(ctx, "make the directory", path, error);
    return PD_OK;
}

/* Returns 1 when files cannot be created in a directory, with the reason in errno; else 0. */
static int pdi_file_is_unwritable(const char *path)
{
    errno = 0;
#if defined(_WIN32)
    wchar_t wide[PDI_FILE_UTF16_SIZE];
    return _waccess(pdi_file_to_utf16(path, wide), 2) != 0;
#else
    return access(path, W_OK | X_OK) != 0;
#endif
}

PDI_FN pd_status pdi_file_check_writable(pd_ctx *ctx, const char *path)
{
    char above[PD_PATH_SIZE];
    PD_TRY(pdi_file_check_path(ctx, path));
    strcpy(above, path);
    /* the deepest directory that is there */
    for (size_t end = strlen(above); !pdi_file_is_directory(above); above[end] = 0) {
        if (pdi_file_exists(above)) return pdi_file_fail(ctx, "make the directory", path, ENOTDIR);
        while (end > 0 && !pdi_file_is_separator(above[end - 1])) end--;
        while (end > 1 && pdi_file_is_separator(above[end - 1])) end--;
        if (end == 0) strcpy(above, ".");
        if (end == 0) break;
    }
    if (pdi_file_is_unwritable(above)) return pdi_file_fail(ctx, "write into the directory", above, errno);
    return PD_OK;
}

PDI_FN int pdi_file_is_subpath(const char *path)
{
    if (path[0] == '/' || path[0] == '\\' || strchr(path, ':')) return 0;
    for (const char *part = path; *part; part += strspn(part, "/\\")) {
        size_t size = strcspn(part, "/\\");
        if (size == 2 && part[0] == '.' && part[1] == '.') return 0;
        part += size;
    }
    return 1;
}

pd_status pd_file_join(pd_ctx *ctx, const char *directory, const char *name, char *path)
{
    size_t length = strlen(directory), size = strlen(name) + 1;
    path[0] = 0;
    if (length + size + 1 > PD_PATH_SIZE)
        return pd_fail(ctx, PD_ERR_SIZE, "file", "the path '%.60s.../%.60s' is longer than %d characters", directory,
                       name, PD_PATH_SIZE - 1);
    memcpy(path, directory, length);
    if (length > 0 && !pdi_file_is_separator(directory[length - 1])) path[length++] = '/';
    memcpy(path + length, name, size);
    return PD_OK;
}

PDI_FN pd_status pdi_file_format_frame_name(pd_ctx *ctx, const char *prefix, int frame, double time,
                                            const char *extension, char *name)
{
    char stamp[PDI_FILE_NUMBER_SIZE];
    name[0] = 0;
    if (frame < 0 || frame > 999999)
        return pd_fail(ctx, PD_ERR_ARGUMENT, "file", "frame %d, expected 0 to 999999", frame);
    if (!(time >= 0 && time < 1e18))
        return pd_fail(ctx, PD_ERR_ARGUMENT, "file", "frame time %g s, expected 0 or more", time);
    if (strlen(prefix) + strlen(extension) + sizeof stamp + 16 > PD_PATH_SIZE)
        return pd_fail(ctx, PD_ERR_SIZE, "file", "the name '%.60s...' is too long", prefix);
    /* as many decimals as the time needs, one to six */
    int decimals = 1;
    double scale = 10.0;
    for (; decimals < 6 && fabs(floor(time * scale + 0.5) / scale - time) > 1e-9 * time; decimals++) scale *= 10.0;
    int used = snprintf(stamp, sizeof stamp, "%.*f", decimals, time);
    /* Not every locale writes a point; some take more than one byte for it. */
    for (int i = 0; i < used; i++)
        if (stamp[i] < '0' || stamp[i] > '9') {
            stamp[i] = '.';
            memmove(stamp + i + 1, stamp + used - decimals, (size_t)decimals + 1);
            break;
        }
    snprintf(name, PD_PATH_SIZE, "%s_%06d_t%ss.%s", prefix, frame, stamp, extension);
    return PD_OK;
}

/* Reading. The number of bytes read counts, not the length found before: files may grow. */

/* Report that a file exceeds its size limit, as PD_ERR_FILE. */
static pd_status pdi_file_fail_too_large(pd_ctx *ctx, const char *path, size_t limit)
{
    return pd_fail(ctx, PD_ERR_FILE, "file", "'%s' is larger than %.0f bytes, the limit for this kind of file", path,
                   (double)limit);
}

/* Read a stream to its end into (*data)[*capacity], which is doubled when it is full; *size: bytes used. PD_ERR_FILE:
 * more than `limit` bytes, or a read error. */
static pd_status pdi_file_read_stream(pd_ctx *ctx, const char *path, FILE *stream, size_t limit, char **data,
                                      size_t *size, size_t *capacity)
{
    for (;;) {
        size_t room = *capacity - *size;
        size_t got = fread(*data + *size, 1, room, stream);
        *size += got;
        if (*size > limit) return pdi_file_fail_too_large(ctx, path, limit);
        if (got < room) {
            if (ferror(stream)) return pdi_file_fail(ctx, "read", path, errno);
            return PD_OK;
        }
        size_t larger = *capacity * 2;
        PD_TRY(PD_GROW(ctx, "file", *capacity, larger, *data));
        *capacity = larger;
    }
}

PDI_FN pd_status pdi_file_read_all(pd_ctx *ctx, const char *path, size_t limit, char **data, size_t *size)
{
    size_t capacity = 16384;
    *data = NULL;
    *size = 0;
    PD_TRY(pdi_file_check_path(ctx, path));
    double found = 0.0;
    int error;
    FILE *stream = pdi_file_open_read_stream(path, &found, &error);
    if (!stream) return pdi_file_fail(ctx, "open", path, error);
    pd_status status = found > (double)limit ? pdi_file_fail_too_large(ctx, path, limit) : PD_OK;
    if (found >= (double)capacity && found <= (double)limit) capacity = (size_t)found + 1;
    if (status == PD_OK) status = PD_NEW(ctx, "file", capacity, *data);
    if (status == PD_OK) status = pdi_file_read_stream(ctx, path, stream, limit, data, size, &capacity);
    fclose(stream);
    if (status == PD_OK) {
        status = PD_GROW(ctx, "file", capacity, *size + 1, *data);
        if (status == PD_OK) (*data)[*size] = 0;
    }
    if (status != PD_OK) {
        PD_DELETE(ctx, capacity, *data);
        *size = 0;
    }
    return status;
}

/* Writing. */

PDI_FN pd_status pdi_file_create(pd_ctx *ctx, const char *path, pd_file *file)
{
    memset(file, 0, sizeof *file);
    PD_TRY(pdi_file_check_path(ctx, path));
    strcpy(file->path, path);
    snprintf(file->temporary_path, sizeof file->temporary_path, "%s.part", path);
    int error = EEXIST;
    for (int k = 0; k < PDI_FILE_CREATE_ATTEMPTS && error == EEXIST; k++) {
        if (pdi_file_is_link(file->temporary_path) || !pdi_file_is_directory(file->temporary_path))
            pdi_file_remove_path(file->temporary_path);
        file->stream = pdi_file_create_stream(file->temporary_path, &error);
    }
    if (file->stream) return PD_OK;
    pd_status status = pdi_file_fail(ctx, "create", file->temporary_path, error);
    file->temporary_path[0] = 0; /* it belongs to another program */
    return status;
}

/* Zero `file` and open the file `path` itself, without a temporary one, to append (append 1) or to read (0). verb: for
 * the message. PD_ERR_FILE; PD_ERR_ARGUMENT: no path; PD_ERR_SIZE: a path too long. */
static pd_status pdi_file_open_in_place(pd_ctx *ctx, const char *path, int append, const char *verb, pd_file *file)
{
    double size;
    int error;
    memset(file, 0, sizeof *file);
    PD_TRY(pdi_file_check_path(ctx, path));
    strcpy(file->path, path);
    file->stream = append ? pdi_file_open_append_stream(path, &error) : pdi_file_open_read_stream(path, &size, &error);
    return file->stream ? PD_OK : pdi_file_fail(ctx, verb, path, error);
}

PDI_FN pd_status pdi_file_open_append(pd_ctx *ctx, const char *path, pd_file *file)
{
    return pdi_file_open_in_place(ctx, path, 1, "append to", file);
}

/* Name under which the file is open now: the temporary or the final one. */
static const char *pdi_file_current_name(const pd_file *file)
{
    return file->temporary_path[0] ? file->temporary_path : file->path;
}

PDI_FN pd_status pdi_file_write(pd_ctx *ctx, pd_file *file, const void *data, size_t size)
{
    if (!file->stream) return pd_fail(ctx, PD_ERR_ARGUMENT, "file", "write to a file that is not open");
    errno = 0;
    if (fwrite(data, 1, size, (FILE *)file->stream) != size)
        return pdi_file_fail(ctx, "write", pdi_file_current_name(file), errno);
    return PD_OK;
}

PDI_FN pd_status pdi_file_write_text(pd_ctx *ctx, pd_file *file, const char *text)
{
    return pdi_file_write(ctx, file, text, strlen(text));
}

PDI_FN pd_status pdi_file_flush(pd_ctx *ctx, pd_file *file)
{
    if (!file->stream) return pd_fail(ctx, PD_ERR_ARGUMENT, "file", "flush of a file that is not open");
    errno = 0;
    if (fflush((FILE *)file->stream) != 0) return pdi_file_fail(ctx, "write", pdi_file_current_name(file), errno);
    return PD_OK;
}

/* Rename a file and replace an existing one atomically. Returns 0 or an error number. */
static int pdi_file_rename(const char *from, const char *to)
{
#if defined(_WIN32)
    const unsigned long replace = 1; /* MOVEFILE_REPLACE_EXISTING */
    wchar_t wide[PDI_FILE_UTF16_SIZE], target[PDI_FILE_UTF16_SIZE];
    return MoveFileExW(pdi_file_to_utf16(from, wide), pdi_file_to_utf16(to, target), replace) ? 0 : PDI_FILE_ERROR_BUSY;
#else
    errno = 0;
    if (rename(from, to) == 0) return 0;
    return errno ? errno : EACCES;
#endif
}

PDI_FN pd_status pdi_file_commit(pd_ctx *ctx, pd_file *file)
{
    if (!file->stream) return pd_fail(ctx, PD_ERR_ARGUMENT, "file", "commit of a file that is not open");
    pd_status status = PD_OK;
    errno = 0;
    /* A caller may have ignored the error of an earlier write: the file must not get its final name then. */
    int broken = ferror((FILE *)file->stream);
    int closed = fclose((FILE *)file->stream);
    file->stream = NULL;
    if (broken || closed != 0) status = pdi_file_fail(ctx, "write", pdi_file_current_name(file), errno);
    if (status == PD_OK && file->temporary_path[0]) {
        int error = pdi_file_rename(file->temporary_path, file->path);
        if (error) status = pdi_file_fail(ctx, "put the finished file in place as", file->path, error);
    }
    if (status != PD_OK) pdi_file_abandon(file);
    file->temporary_path[0] = 0;
    return status;
}

PDI_FN void pdi_file_abandon(pd_file *file)
{
    if (file->stream) fclose((FILE *)file->stream);
    file->stream = NULL;
    if (file->temporary_path[0]) pdi_file_remove_path(file->temporary_path);
    file->temporary_path[0] = 0;
}

PDI_FN void pdi_file_remove(const char *path)
{
    char part[PD_PATH_SIZE + 8];
    snprintf(part, sizeof part, "%s.part", path);
    pdi_file_remove_path(part);
    pdi_file_remove_path(path);
}

/* Truncating, and reading in parts. */

PDI_FN pd_status pdi_file_open_read(pd_ctx *ctx, const char *path, pd_file *file)
{
    return pdi_file_open_in_place(ctx, path, 0, "open", file);
}

PDI_FN pd_status pdi_file_read_bytes(pd_ctx *ctx, pd_file *file, void *data, size_t size, size_t *got)
{
    errno = 0;
    *got = fread(data, 1, size, (FILE *)file->stream);
    if (*got < size && ferror((FILE *)file->stream)) return pdi_file_fail(ctx, "read", file->path, errno);
    return PD_OK;
}

PDI_FN pd_status pdi_file_get_length(pd_ctx *ctx, pd_file *file, int64_t *length)
{
    PD_TRY(pdi_file_flush(ctx, file));
    errno = 0;
    long end = fseek((FILE *)file->stream, 0, SEEK_END) == 0 ? ftell((FILE *)file->stream) : -1;
    if (end < 0) return pdi_file_fail(ctx, "measure", file->path, errno);
    *length = end;
    return PD_OK;
}

/* Copy the next `length` bytes of a file, which must end a line. PD_ERR_FILE: it is shorter, or no line ends there. */
static pd_status pdi_file_copy_bytes(pd_ctx *ctx, pd_file *from, int64_t length, pd_file *to)
{
    char bytes[4096], last = '\n';
    size_t got;
    for (int64_t left = length; left > 0; left -= (int64_t)got) {
        size_t wanted = left < (int64_t)sizeof bytes ? (size_t)left : sizeof bytes;
        PD_TRY(pdi_file_read_bytes(ctx, from, bytes, wanted, &got));
        if (got < wanted)
            return pd_fail(ctx, PD_ERR_FILE, "file", "'%s' holds %.0f bytes, expected at least the %.0f to go on from",
                           from->path, (double)(length - left) + (double)got, (double)length);
        PD_TRY(pdi_file_write(ctx, to, bytes, got));
        last = bytes[got - 1];
    }
    if (last != '\n')
        return pd_fail(ctx, PD_ERR_FILE, "file", "no line of '%s' ends at byte %.0f: it is not the file to go on from",
                       from->path, (double)length);
    return PD_OK;
}

PDI_FN pd_status pdi_file_begin_resume(pd_ctx *ctx, const char *path, int64_t length, pd_file *file)
{
    pd_file from;
    memset(file, 0, sizeof *file);
    PD_TRY(pdi_file_open_read(ctx, path, &from));
    pd_status status = pdi_file_create(ctx, path, file);
    if (status == PD_OK) status = pdi_file_copy_bytes(ctx, &from, length, file);
    if (status == PD_OK) status = pdi_file_flush(ctx, file);
    pdi_file_abandon(&from); /* Windows replaces no file that is open */
    if (status < 0) pdi_file_abandon(file);
    return status;
}

PDI_FN pd_status pdi_file_finish_resume(pd_ctx *ctx, pd_file *file)
{
    char path[PD_PATH_SIZE];
    memcpy(path, file->path, sizeof path);
    PD_TRY(pdi_file_commit(ctx, file));
    return pdi_file_open_append(ctx, path, file);
}

PDI_FN pd_status pdi_file_resume(pd_ctx *ctx, const char *path, int64_t length, pd_file *file)
{
    PD_TRY(pdi_file_begin_resume(ctx, path, length, file));
    return pdi_file_finish_resume(ctx, file);
}

/* Numbers: the C library follows the locale of the host program, files must not. */

PDI_FN void pdi_file_format_number(double value, char *text)
{
    if (isnan(value) || isinf(value)) {
        strcpy(text, isnan(value) ? "nan" : value > 0 ? "inf" : "-inf");
        return;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, PDI_FILE_NUMBER_SIZE, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    size_t used = 0;
    for (size_t i = 0; text[i]; i++) {
        if (strchr("0123456789+-e", text[i])) text[used++] = text[i];
        else if (used && text[used - 1] != '.') text[used++] = '.';
    }
    text[used] = 0;
}

/* Number of decimal digits at the start of text[0..length). */
static size_t pdi_file_count_digits(const char *text, size_t length)
{
    size_t at = 0;
    while (at < length && text[at] >= '0' && text[at] <= '9') at++;
    return at;
}

PDI_FN size_t pdi_file_find_number_length(const char *text, size_t length)
{
    size_t at = length > 0 && (*text == '-' || *text == '+'), digits = pdi_file_count_digits(text + at, length - at),
           more;
    at += digits;
    if (at < length && text[at] == '.') {
        more = pdi_file_count_digits(text + at + 1, length - at - 1);
        digits += more;
        at += 1 + more;
    }
    if (digits == 0) return 0;
    if (at + 1 >= length || (text[at] != 'e' && text[at] != 'E')) return at;
    size_t sign = text[at + 1] == '-' || text[at + 1] == '+';
    more = pdi_file_count_digits(text + at + 1 + sign, length - at - 1 - sign);
    return more > 0 ? at + 1 + sign + more : at;
}

PDI_FN int pdi_file_parse_number(const char *text, size_t length, double *value)
{
    char copy[80], sample[16], *end;
    size_t used = 0, point;
    if (length == 0 || length >= sizeof copy - sizeof sample || strchr(" \t\r\n\v\f", text[0])) return 0;
    snprintf(sample, sizeof sample, "%.1f", 0.5); /* "0", the point of the locale, "5" */
    point = strlen(sample) - 2;
    for (size_t i = 0, points = 0; i < length; i++) {
        if (!text[i] || text[i] == 'x' || text[i] == 'X' || text[i] == '(' || text[i] == ',') return 0;
        if (text[i] != '.') {
            copy[used++] = text[i];
            continue;
        }
        if (points++) return 0;
        memcpy(copy + used, sample + 1, point);
        used += point;
    }
    copy[used] = 0;
    *value = strtod(copy, &end);
    return end == copy + used;
}

#undef PDI_FILE_SEPARATORS
#undef PDI_FILE_ERROR_BUSY
#undef PDI_FILE_ERROR_PIPE
#undef PDI_FILE_ERROR_DEVICE
#undef PDI_FILE_ERROR_LINK
#undef PDI_FILE_CREATE_ATTEMPTS
