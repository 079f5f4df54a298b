// The measuring peer on memory that two processes share and the futex call, which is the lower
// bound for the roles ping and pong through memory. Each process writes one place and reads the
// other one. The reader does not copy the payload.
#define _GNU_SOURCE
#include <fcntl.h>
#include <limits.h>
#include <linux/futex.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "bench/participants.h"

enum { MOST = 4 << 20, HEADER = 16 };

struct place {
  _Atomic uint32_t count;  // of samples; readers wait for it
  uint32_t length;
  uint8_t octets[HEADER + MOST];
};

struct memory {
  struct place* own;
  struct place* other;
  uint32_t seen;
  bool is_ping, has_received;
};

static uint32_t matched(void* self) {
  const struct memory* memory = self;
  return memory->is_ping || memory->has_received;
}

static void futex(struct place* place, int operation, uint32_t value,
                  const struct timespec* timeout) {
  syscall(SYS_futex, (uint32_t*)&place->count, operation, value, timeout, NULL, 0);
}

static bool write_blob(void* self, const struct bench_blob* blob) {
  struct place* place = ((struct memory*)self)->own;
  memcpy(place->octets, blob, HEADER);  // seq, pad and t_ns
  memcpy(place->octets + HEADER, blob->data, blob->length);
  place->length = blob->length;
  atomic_fetch_add(&place->count, 1);
  futex(place, FUTEX_WAKE, INT_MAX, NULL);
  return true;
}

// Blocks for up to 20 ms.
static void wait_for_data(void* self) {
  struct memory* memory = self;
  const struct timespec timeout = {.tv_nsec = 20000000};
  futex(memory->other, FUTEX_WAIT, memory->seen, &timeout);
}

static bool take_blob(void* self, struct bench_blob* blob) {
  struct memory* memory = self;
  const uint32_t count = atomic_load(&memory->other->count);
  if (count == memory->seen) return false;
  memory->seen = count;
  memory->has_received = true;
  memcpy(blob, memory->other->octets, HEADER);
  blob->data = memory->other->octets + HEADER;
  blob->length = memory->other->length;
  return true;
}

static bool acknowledged(void* self) {
  (void)self;
  return true;
}

static struct place* map_places(const char* name) {
  const size_t size = 2 * sizeof(struct place);
  const int descriptor = shm_open(name, O_RDWR | O_CREAT, 0600);
  if (descriptor < 0 || ftruncate(descriptor, (off_t)size) != 0) return NULL;
  void* at = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, descriptor, 0);
  close(descriptor);
  return at == MAP_FAILED ? NULL : at;
}

int main(int argc, char** argv) {
  struct bench_options options;
  bench_parse(argc, argv, &options);
  const bool is_ping = options.role == BENCH_PING;
  if ((!is_ping && options.role != BENCH_PONG) || options.listener || options.size > MOST) {
    fputs("bench_futex_peer: has the roles ping and pong alone, and no listener\n", stderr);
    return BENCH_USAGE;
  }
  options.waiting = true;
  char name[64];
  snprintf(name, sizeof name, "/ddssec-bench-%u-%u", (unsigned)getuid(), options.domain);
  struct place* places = map_places(name);
  if (places == NULL) return bench_refused("memory", "shm_open or mmap failed");
  struct memory memory = {&places[!is_ping], &places[is_ping], 0, is_ping, false};
  memory.seen = atomic_load(&memory.other->count);
  const struct bench_stack stack = {&memory,   matched,       matched,     write_blob,
                                    take_blob, wait_for_data, acknowledged};
  const int code = bench_run(&options, &stack);
  if (is_ping) shm_unlink(name);
  return code;
}
