// Preloaded by interrupted_test.py. Kills the process, as SIGKILL does, just before its n-th call
// that changes files (KILL_AT=n; 0: never), so that a test can stop a command between any two
// writes. From the n-th write on, each write finds the disk full (FULL_AT=n). At the first rename,
// a participant's owner removes the drafts in its folder (REMOVE_DRAFTS=pattern) or runs a command
// (AT_RENAME=command). A command runs just before the n-th call (AT_CALL=command, CALL=n), or after
// the n-th lock (AT_LOCK=command, LOCK=n), or after the links of a path were resolved
// (AT_RESOLVED).
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

// The agent's workers do not inherit these variables, so those of the parent count, too. They are
// read at the start, because a worker that has become another user may not read them.
static char parents[1 << 16];

__attribute__((constructor)) static void read_parents_variables(void) {
  char name[64];
  snprintf(name, sizeof name, "/proc/%d/environ", (int)getppid());
  FILE* file = fopen(name, "r");
  if (file == NULL) return;
  const size_t size = fread(parents, 1, sizeof parents - 2, file);
  memset(parents + size, 0, 2);
  fclose(file);
}

static char* parents_value_of(const char* variable) {
  const size_t length = strlen(variable);
  if (getenv("HOME") == NULL || strcmp(getenv("HOME"), "/nonexistent") != 0) return NULL;
  for (char* one = parents; *one != 0; one += strlen(one) + 1)
    if (strncmp(one, variable, length) == 0 && one[length] == '=') return one + length + 1;
  return NULL;
}

static const char* value_of(const char* variable) {
  const char* own = getenv(variable);
  return own != NULL ? own : parents_value_of(variable);
}

static long number_of(const char* variable) {
  const char* wanted = value_of(variable);
  return wanted == NULL ? 0 : atol(wanted);
}

// Another command may run between two writes. It runs once in each process.
static void run(const char* variable) {
  const char* command = value_of(variable);
  if (command == NULL) return;
  char* copy = strdup(command);
  char* of_parent = parents_value_of(variable);
  if (of_parent != NULL) of_parent[-1] = ' ';  // it is no variable any more
  unsetenv(variable);
  unsetenv("LD_PRELOAD");
  if (copy != NULL && system(copy) != 0) abort();
  free(copy);
}

static void count(void) {
  static long left = -1, other = -1;
  if (left == -1) left = number_of("KILL_AT");
  if (other == -1) other = number_of("CALL");
  if (left > 0 && --left == 0) kill(getpid(), SIGKILL);
  if (other > 0 && --other == 0) run("AT_CALL");
}

static int is_full(void) {
  static long left = -1;
  if (left == -1) left = number_of("FULL_AT");
  if (left > 1) return --left, 0;
  return left == 1;
}

static void remove_drafts(void) {
  const char* pattern = value_of("REMOVE_DRAFTS");
  glob_t found;
  if (pattern == NULL || glob(pattern, 0, NULL, &found) != 0) return;
  for (size_t i = 0; i < found.gl_pathc; ++i) remove(found.gl_pathv[i]);
  globfree(&found);
}

#define SEEN __attribute__((visibility("default")))

SEEN int flock(int file, int operation) {
  static int (*real)(int, int);
  static long left = -1;
  if (real == NULL) real = (int (*)(int, int))dlsym(RTLD_NEXT, "flock");
  if (left == -1) left = number_of("LOCK");
  const int done = real(file, operation);
  if (done == 0 && left > 0 && --left == 0) run("AT_LOCK");
  return done;
}

SEEN char* realpath(const char* path, char* out) {
  static char* (*real)(const char*, char*);
  if (real == NULL) real = (char* (*)(const char*, char*))dlsym(RTLD_NEXT, "realpath");
  char* done = real(path, out);
  run("AT_RESOLVED");
  return done;
}

#define CHANGE(type, name, parameters, arguments)                         \
  SEEN type name parameters {                                             \
    static type(*real) parameters;                                        \
    if (real == NULL) real = (type(*) parameters)dlsym(RTLD_NEXT, #name); \
    count();                                                              \
    return real arguments;                                                \
  }

// This counts as two calls, because something may also happen between this one and the next.
#define CHANGE_AND_AFTER(type, name, parameters, arguments)               \
  SEEN type name parameters {                                             \
    static type(*real) parameters;                                        \
    if (real == NULL) real = (type(*) parameters)dlsym(RTLD_NEXT, #name); \
    count();                                                              \
    const type done = real arguments;                                     \
    count();                                                              \
    return done;                                                          \
  }

CHANGE(int, rename, (const char* from, const char* to), (from, to))
CHANGE(int, renameat2, (int d, const char* from, int e, const char* to, unsigned flags),
       (d, from, e, to, flags))

SEEN int renameat(int d, const char* from, int e, const char* to) {
  static int (*real)(int, const char*, int, const char*);
  if (real == NULL)
    real = (int (*)(int, const char*, int, const char*))dlsym(RTLD_NEXT, "renameat");
  remove_drafts();
  run("AT_RENAME");
  count();
  return real(d, from, e, to);
}

CHANGE(int, unlinkat, (int d, const char* path, int flags), (d, path, flags))
CHANGE(int, mkdir, (const char* path, mode_t mode), (path, mode))
CHANGE_AND_AFTER(int, mkdirat, (int d, const char* path, mode_t mode), (d, path, mode))
CHANGE(int, unlink, (const char* path), (path))
CHANGE(int, symlinkat, (const char* to, int d, const char* path), (to, d, path))
CHANGE(int, ftruncate, (int file, off_t size), (file, size))
CHANGE(int, chmod, (const char* path, mode_t mode), (path, mode))
CHANGE(int, fchmod, (int file, mode_t mode), (file, mode))

// A killed process loses nothing that it wrote, on the disk or not, so waiting for the disk would
// show nothing.
static int no_wait(void) {
  count();
  return 0;
}
SEEN int fsync(int file) { return (void)file, no_wait(); }
SEEN int syncfs(int file) { return (void)file, no_wait(); }

// Half of the octets are written, and then the process ends, so the file is cut off.
SEEN ssize_t write(int file, const void* octets, size_t size) {
  static ssize_t (*real)(int, const void*, size_t);
  if (real == NULL) real = (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
  struct stat status;
  if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return real(file, octets, size);
  if (is_full()) {
    errno = ENOSPC;
    return -1;
  }
  count();
  const ssize_t done = size > 1 ? real(file, octets, size / 2) : 0;
  if (done < 0) return done;
  count();
  const ssize_t rest = real(file, (const char*)octets + done, size - (size_t)done);
  return rest < 0 ? done : done + rest;
}
