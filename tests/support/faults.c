/* Loaded before the C library: makes the n-th call of a kind fail, or writes down what is done below the folder "out".
 *
 * FAULT=KIND:N[:always]  the N-th call fails (EIO; ENOSPC where it writes), and with "always" all after it. KIND is write,
 *                        half (half of the bytes are written, then none), fsync, rename, create, unlink, truncate, mkdir or memory
 *                        (blocks of 16 KiB and more).
 * FAULT_MET=FILE         is made when a call has failed.
 * RECORD=FILE            gets one entry a call: a line of its name, numbers and paths, followed by the bytes it speaks of.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#define REAL(result, name, ...) static result (*real_##name)(__VA_ARGS__)

REAL(ssize_t, write, int, const void *, size_t);
REAL(ssize_t, pwrite64, int, const void *, size_t, off64_t);
REAL(int, fsync, int);
REAL(int, rename, const char *, const char *);
REAL(int, open64, const char *, int, ...);
REAL(int, unlink, const char *);
REAL(int, rmdir, const char *);
REAL(int, mkdir, const char *, mode_t);
REAL(int, ftruncate64, int, off64_t);

static char kind[16];
static long at, calls;
static int always, record = -1;

__attribute__((constructor)) static void begin(void) {
    real_write = dlsym(RTLD_NEXT, "write");
    real_pwrite64 = dlsym(RTLD_NEXT, "pwrite64");
    real_fsync = dlsym(RTLD_NEXT, "fsync");
    real_rename = dlsym(RTLD_NEXT, "rename");
    real_open64 = dlsym(RTLD_NEXT, "open64");
    real_unlink = dlsym(RTLD_NEXT, "unlink");
    real_rmdir = dlsym(RTLD_NEXT, "rmdir");
    real_mkdir = dlsym(RTLD_NEXT, "mkdir");
    real_ftruncate64 = dlsym(RTLD_NEXT, "ftruncate64");
    const char *fault = getenv("FAULT"), *file = getenv("RECORD");
    if (fault) {
        sscanf(fault, "%15[a-z]:%ld", kind, &at);
        always = strstr(fault, ":always") != NULL;
    }
    if (file)
        record = syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

/* Whether this call of a kind is to fail. */
static int fails(const char *which) {
    if (!at || strcmp(kind, which))
        return 0;
    long call = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
    if (call != at && !(always && call > at))
        return 0;
    const char *met = getenv("FAULT_MET");
    if (met)
        syscall(SYS_close, syscall(SYS_openat, AT_FDCWD, met, O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    return 1;
}

static int regular(int file) {
    struct stat64 state;
    return !fstat64(file, &state) && S_ISREG(state.st_mode);
}

static int ours(const char *path) { return record >= 0 && !strncmp(path, "out", 3); }

static void note(const char *line, const void *bytes, size_t length) {
    if (record < 0)
        return;
    syscall(SYS_write, record, line, strlen(line));
    if (length)
        syscall(SYS_write, record, bytes, length);
}

static void note_write(int file, long offset, const void *bytes, size_t length) {
    char line[80];
    snprintf(line, sizeof line, "write %d %ld %zu\n", file, offset, length);
    note(line, bytes, length);
}

/* What of a write is done before it fails; -1: all of it, without failing. A full disk has room where a file lies already. */
static ssize_t part(int file, off64_t end, size_t length) {
    struct stat64 state;
    if (fails("write"))
        return 0;
    if (at && !strcmp(kind, "half") && !(!fstat64(file, &state) && end <= state.st_size)) {
        always = 1;
        long before = __atomic_load_n(&calls, __ATOMIC_SEQ_CST);
        if (fails("half"))
            return before + 1 == at ? (ssize_t)(length / 2) : 0;
    }
    return -1;
}

ssize_t write(int file, const void *bytes, size_t length) {
    if (regular(file)) {
        ssize_t some = part(file, lseek64(file, 0, SEEK_CUR) + (off64_t)length, length);
        if (some > 0)
            return real_write(file, bytes, some);
        if (!some) {
            errno = ENOSPC;
            return -1;
        }
        if (record >= 0)
            note_write(file, lseek64(file, 0, SEEK_CUR), bytes, length);
    }
    return real_write(file, bytes, length);
}

ssize_t pwrite64(int file, const void *bytes, size_t length, off64_t offset) {
    ssize_t some = part(file, offset + (off64_t)length, length);
    if (some > 0)
        return real_pwrite64(file, bytes, some, offset);
    if (!some) {
        errno = ENOSPC;
        return -1;
    }
    note_write(file, offset, bytes, length);
    return real_pwrite64(file, bytes, length, offset);
}

int fsync(int file) {
    char line[40];
    if (fails("fsync")) {
        errno = EIO;
        return -1;
    }
    snprintf(line, sizeof line, "fsync %d\n", file);
    note(line, NULL, 0);
    return record >= 0 ? 0 : real_fsync(file);
}

int rename(const char *from, const char *to) {
    char line[1000];
    if (fails("rename")) {
        errno = EIO;
        return -1;
    }
    if (ours(from)) {
        snprintf(line, sizeof line, "rename %s %s\n", from, to);
        note(line, NULL, 0);
    }
    return real_rename(from, to);
}

int open64(const char *path, int flags, ...) {
    char line[600];
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if (flags & O_CREAT && fails("create")) {
        errno = EIO;
        return -1;
    }
    int file = real_open64(path, flags, mode);
    if (file >= 0 && ours(path)) {
        snprintf(line, sizeof line, "open %d %s\n", file, path);
        note(line, NULL, 0);
    }
    return file;
}

int unlink(const char *path) {
    char line[600];
    if (fails("unlink")) {
        errno = EIO;
        return -1;
    }
    int done = real_unlink(path);
    if (!done && ours(path)) {
        snprintf(line, sizeof line, "unlink %s\n", path);
        note(line, NULL, 0);
    }
    return done;
}

int rmdir(const char *path) {
    char line[600];
    int done = real_rmdir(path);
    if (!done && ours(path)) {
        snprintf(line, sizeof line, "rmdir %s\n", path);
        note(line, NULL, 0);
    }
    return done;
}

int mkdir(const char *path, mode_t mode) {
    char line[600];
    if (fails("mkdir")) {
        errno = EIO;
        return -1;
    }
    int done = real_mkdir(path, mode);
    if (!done && ours(path)) {
        snprintf(line, sizeof line, "mkdir %s\n", path);
        note(line, NULL, 0);
    }
    return done;
}

int ftruncate64(int file, off64_t length) {
    char line[60];
    if (fails("truncate")) {
        errno = EIO;
        return -1;
    }
    snprintf(line, sizeof line, "truncate %d %ld\n", file, (long)length);
    note(line, NULL, 0);
    return real_ftruncate64(file, length);
}

extern void *__libc_malloc(size_t), *__libc_realloc(void *, size_t), *__libc_calloc(size_t, size_t);
extern void *__libc_memalign(size_t, size_t);

static int no_memory(size_t size) { return size >= 16384 && fails("memory"); }

void *malloc(size_t size) { return no_memory(size) ? NULL : __libc_malloc(size); }

void *realloc(void *old, size_t size) { return no_memory(size) ? NULL : __libc_realloc(old, size); }

void *calloc(size_t count, size_t size) { return no_memory(count * size) ? NULL : __libc_calloc(count, size); }

int posix_memalign(void **place, size_t boundary, size_t size) {
    *place = no_memory(size) ? NULL : __libc_memalign(boundary, size);
    return *place ? 0 : ENOMEM;
}
