// Preloaded by signals_test.py. A process that opens ./endless makes the file ./computing, and from
// then on computes without an end and without a system call. A command on that file therefore
// computes for as long as the test needs, even on the fastest machine.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static volatile int is_computing = 0;

static int is_endless(const char* path) {
  const char* name = strrchr(path, '/');
  return strcmp(name == NULL ? path : name + 1, "endless") == 0;
}

__attribute__((visibility("default"))) int open(const char* path, int flags, ...) {
  int (*const next)(const char*, int, ...) =
      (int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open");
  if (is_endless(path)) {
    close(next("computing", O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    is_computing = 1;
    while (is_computing) {
    }
  }
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return next(path, flags, mode);
}
