// Preloaded by agent_worker_test.py. Just before a process of the agent becomes another user, it
// writes into ./loot what code of that user could find in the process: variables, open files, the
// terminal, the limit of a core file, and whether its memory has the text of ./needle. (That file
// has the text in reverse, so that this code does not have it itself.)
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/types.h>
#include <unistd.h>

extern char** environ;

static size_t needle_of(char* out, size_t most) {
  FILE* file = fopen("needle", "r");
  if (file == NULL) return 0;
  const size_t size = fread(out, 1, most, file);
  fclose(file);
  return size;
}

static int is_at(const char* place, const char* reversed, size_t size) {
  for (size_t i = 0; i < size; ++i)
    if (place[i] != reversed[size - 1 - i]) return 0;
  return 1;
}

static int is_in(const char* from, size_t length, const char* reversed, size_t size) {
  for (size_t i = 0; size > 0 && i + size <= length; ++i)
    if (is_at(from + i, reversed, size)) return 1;
  return 0;
}

static int memory_has_needle(void) {
  char reversed[64], line[512];
  const size_t size = needle_of(reversed, sizeof reversed);
  FILE* maps = fopen("/proc/self/maps", "r");
  const int memory = open("/proc/self/mem", O_RDONLY);
  int found = 0;
  while (maps != NULL && fgets(line, sizeof line, maps) != NULL) {
    unsigned long begin = 0, end = 0;
    char mode[8] = "";
    if (sscanf(line, "%lx-%lx %7s", &begin, &end, mode) != 3 || strncmp(mode, "rw", 2) != 0)
      continue;
    if (end - begin > (64UL << 20)) continue;
    char* copy = malloc(end - begin);
    const ssize_t got = copy == NULL ? -1 : pread(memory, copy, end - begin, (off_t)begin);
    if (got > 0) found |= is_in(copy, (size_t)got, reversed, size);
    free(copy);
  }
  if (maps != NULL) fclose(maps);
  close(memory);
  return found;
}

static void write_loot(void) {
  FILE* loot = fopen("loot", "w");
  if (loot == NULL) return;
  for (char** one = environ; *one != NULL; ++one) fprintf(loot, "variable %s\n", *one);
  for (int file = 0; file < 64; ++file) {
    char path[64], target[512];
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    const ssize_t size = readlink(path, target, sizeof target - 1);
    if (size > 0 && file != fileno(loot)) fprintf(loot, "file %d %.*s\n", file, (int)size, target);
  }
  const int terminal = open("/dev/tty", O_RDWR | O_NOCTTY);
  fprintf(loot, "terminal %s\n", terminal >= 0 ? "yes" : "no");
  if (terminal >= 0) close(terminal);
  fprintf(loot, "leader %s\n", getsid(0) == getpid() ? "yes" : "no");
  struct rlimit core = {1, 1};
  getrlimit(RLIMIT_CORE, &core);
  fprintf(loot, "core %lu\n", (unsigned long)core.rlim_max);
  fprintf(loot, "memory %s\n", memory_has_needle() ? "yes" : "no");
  fclose(loot);
}

__attribute__((visibility("default"))) int setresuid(uid_t real, uid_t effective, uid_t saved) {
  write_loot();
  int (*const next)(uid_t, uid_t, uid_t) =
      (int (*)(uid_t, uid_t, uid_t))dlsym(RTLD_NEXT, "setresuid");
  return next(real, effective, saved);
}
