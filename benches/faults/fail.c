/* Loaded before the C library (LD_PRELOAD): lets calls under one folder fail, and moves the clock.
 *
 *   FAULT_UNDER   folder; calls on anything else go through
 *   FAULT_CALL    one of: write fsync rename mkdir open read unlink
 *   FAULT_ERRNO   number of the error
 *   FAULT_AT      which of these calls fails, from 1; 0 lets all through
 *   FAULT_ALWAYS  1: that one and all after it
 *   FAULT_COUNT   file that holds, at the end, how many there were and how many failed
 *   FAULT_CLOCK   seconds added to the time of day ...
 *   FAULT_CLOCK_AFTER   ... from so many questions for the time on
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

static const char *under, *call, *count_file;
static long number, at, always, clock_shift, clock_after;
static atomic_long calls, failed, asked;

static long get(const char *name) {
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

__attribute__((constructor)) static void begin(void) {
    under = getenv("FAULT_UNDER");
    call = getenv("FAULT_CALL");
    count_file = getenv("FAULT_COUNT");
    number = get("FAULT_ERRNO");
    at = get("FAULT_AT");
    always = get("FAULT_ALWAYS");
    clock_shift = get("FAULT_CLOCK");
    clock_after = get("FAULT_CLOCK_AFTER");
}

__attribute__((destructor)) static void end(void) {
    char text[64];
    if (!count_file) return;
    int length = snprintf(text, sizeof text, "%ld %ld\n", (long)calls, (long)failed);
    int file = syscall(SYS_openat, AT_FDCWD, count_file, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (file >= 0) {
        syscall(SYS_write, file, text, length);
        syscall(SYS_close, file);
    }
}

static int is_inside(const char *path) {
    size_t length = strlen(under);
    return strncmp(path, under, length) == 0 && (path[length] == '/' || path[length] == 0);
}

/* Whether the open file lies under the folder. */
static int file_is_inside(int file) {
    char name[40], path[PATH_MAX];
    snprintf(name, sizeof name, "/proc/self/fd/%d", file);
    ssize_t length = syscall(SYS_readlinkat, AT_FDCWD, name, path, sizeof path - 1);
    if (length <= 0) return 0;
    path[length] = 0;
    return is_inside(path);
}

/* Whether a path, seen from an open folder, lies under the folder; the program runs inside of it. */
static int path_is_inside(int folder, const char *path) {
    char here[PATH_MAX];
    if (!path) return 0;
    if (path[0] == '/') return is_inside(path);
    if (folder != AT_FDCWD) return file_is_inside(folder);
    return syscall(SYS_getcwd, here, sizeof here) > 0 && is_inside(here);
}

static int is_meant(const char *name) { return under && call && strcmp(call, name) == 0; }

/* Counts a call that is meant; 1 if it fails. */
static int fails(void) {
    long n = atomic_fetch_add(&calls, 1) + 1;
    if (at == 0 || (always ? n < at : n != at)) return 0;
    atomic_fetch_add(&failed, 1);
    errno = number;
    return 1;
}

#define FILE_FAILS(name, file) (is_meant(name) && file_is_inside(file) && fails())
#define PATH_FAILS(name, folder, path) (is_meant(name) && path_is_inside(folder, path) && fails())
#define NEXT(type, name) \
    static type (*next)(); \
    if (!next) next = (type(*)())dlsym(RTLD_NEXT, #name)

ssize_t write(int f, const void *b, size_t n) { NEXT(ssize_t, write); return FILE_FAILS("write", f) ? -1 : next(f, b, n); }
ssize_t writev(int f, const struct iovec *v, int n) { NEXT(ssize_t, writev); return FILE_FAILS("write", f) ? -1 : next(f, v, n); }
ssize_t pwrite(int f, const void *b, size_t n, off_t o) { NEXT(ssize_t, pwrite); return FILE_FAILS("write", f) ? -1 : next(f, b, n, o); }
ssize_t pwrite64(int f, const void *b, size_t n, off64_t o) { NEXT(ssize_t, pwrite64); return FILE_FAILS("write", f) ? -1 : next(f, b, n, o); }
ssize_t pwritev64(int f, const struct iovec *v, int n, off64_t o) { NEXT(ssize_t, pwritev64); return FILE_FAILS("write", f) ? -1 : next(f, v, n, o); }
ssize_t copy_file_range(int a, off64_t *p, int f, off64_t *q, size_t n, unsigned flags) {
    NEXT(ssize_t, copy_file_range);
    return FILE_FAILS("write", f) ? -1 : next(a, p, f, q, n, flags);
}
ssize_t sendfile(int f, int a, off_t *p, size_t n) { NEXT(ssize_t, sendfile); return FILE_FAILS("write", f) ? -1 : next(f, a, p, n); }
ssize_t sendfile64(int f, int a, off64_t *p, size_t n) { NEXT(ssize_t, sendfile64); return FILE_FAILS("write", f) ? -1 : next(f, a, p, n); }
int ftruncate(int f, off_t n) { NEXT(int, ftruncate); return FILE_FAILS("write", f) ? -1 : next(f, n); }
int ftruncate64(int f, off64_t n) { NEXT(int, ftruncate64); return FILE_FAILS("write", f) ? -1 : next(f, n); }

int fsync(int f) { NEXT(int, fsync); return FILE_FAILS("fsync", f) ? -1 : next(f); }
int fdatasync(int f) { NEXT(int, fdatasync); return FILE_FAILS("fsync", f) ? -1 : next(f); }

ssize_t read(int f, void *b, size_t n) { NEXT(ssize_t, read); return FILE_FAILS("read", f) ? -1 : next(f, b, n); }
ssize_t pread(int f, void *b, size_t n, off_t o) { NEXT(ssize_t, pread); return FILE_FAILS("read", f) ? -1 : next(f, b, n, o); }
ssize_t pread64(int f, void *b, size_t n, off64_t o) { NEXT(ssize_t, pread64); return FILE_FAILS("read", f) ? -1 : next(f, b, n, o); }

int rename(const char *a, const char *b) { NEXT(int, rename); return PATH_FAILS("rename", AT_FDCWD, b) ? -1 : next(a, b); }
int renameat(int d, const char *a, int e, const char *b) { NEXT(int, renameat); return PATH_FAILS("rename", e, b) ? -1 : next(d, a, e, b); }
int renameat2(int d, const char *a, int e, const char *b, unsigned flags) {
    NEXT(int, renameat2);
    return PATH_FAILS("rename", e, b) ? -1 : next(d, a, e, b, flags);
}
int link(const char *a, const char *b) { NEXT(int, link); return PATH_FAILS("rename", AT_FDCWD, b) ? -1 : next(a, b); }
int linkat(int d, const char *a, int e, const char *b, int flags) { NEXT(int, linkat); return PATH_FAILS("rename", e, b) ? -1 : next(d, a, e, b, flags); }

int mkdir(const char *p, mode_t m) { NEXT(int, mkdir); return PATH_FAILS("mkdir", AT_FDCWD, p) ? -1 : next(p, m); }
int mkdirat(int d, const char *p, mode_t m) { NEXT(int, mkdirat); return PATH_FAILS("mkdir", d, p) ? -1 : next(d, p, m); }

int unlink(const char *p) { NEXT(int, unlink); return PATH_FAILS("unlink", AT_FDCWD, p) ? -1 : next(p); }
int unlinkat(int d, const char *p, int flags) { NEXT(int, unlinkat); return PATH_FAILS("unlink", d, p) ? -1 : next(d, p, flags); }
int rmdir(const char *p) { NEXT(int, rmdir); return PATH_FAILS("unlink", AT_FDCWD, p) ? -1 : next(p); }

#define MODE(flags, last) \
    mode_t mode = 0; \
    if ((flags) & (O_CREAT | O_TMPFILE)) { \
        va_list rest; \
        va_start(rest, last); \
        mode = va_arg(rest, mode_t); \
        va_end(rest); \
    }
int open(const char *p, int flags, ...) { MODE(flags, flags) NEXT(int, open); return PATH_FAILS("open", AT_FDCWD, p) ? -1 : next(p, flags, mode); }
int open64(const char *p, int flags, ...) { MODE(flags, flags) NEXT(int, open64); return PATH_FAILS("open", AT_FDCWD, p) ? -1 : next(p, flags, mode); }
int openat(int d, const char *p, int flags, ...) { MODE(flags, flags) NEXT(int, openat); return PATH_FAILS("open", d, p) ? -1 : next(d, p, flags, mode); }
int openat64(int d, const char *p, int flags, ...) { MODE(flags, flags) NEXT(int, openat64); return PATH_FAILS("open", d, p) ? -1 : next(d, p, flags, mode); }
DIR *opendir(const char *p) { NEXT(DIR *, opendir); return PATH_FAILS("open", AT_FDCWD, p) ? NULL : next(p); }

static long shift(void) { return clock_shift && atomic_fetch_add(&asked, 1) >= clock_after ? clock_shift : 0; }
int clock_gettime(clockid_t which, struct timespec *t) {
    int done = syscall(SYS_clock_gettime, which, t);
    if (done == 0 && (which == CLOCK_REALTIME || which == CLOCK_REALTIME_COARSE)) t->tv_sec += shift();
    return done;
}
int gettimeofday(struct timeval *restrict t, void *restrict zone) {
    int done = syscall(SYS_gettimeofday, t, zone);
    if (done == 0 && t) t->tv_sec += shift();
    return done;
}
time_t time(time_t *t) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (t) *t = now.tv_sec;
    return now.tv_sec;
}
