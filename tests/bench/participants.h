// What the measuring peers of other makes share: ddssec-peer's command line and output for its
// roles ping, pong, tput-pub and tput-sub, one more that only waits for matches, and their loops. A
// stack supplies a few calls and nothing else, so that all makes do the same.
#ifndef DDSSEC_BENCH_PARTICIPANTS_H
#define DDSSEC_BENCH_PARTICIPANTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Exit codes, as ddssec-peer's.
enum bench_exit {
  BENCH_DONE = 0,
  BENCH_NEVER_MATCHED = 1,
  BENCH_USAGE = 2,
  BENCH_NOT_CREATED = 3,
  BENCH_MISSING = 4,
  BENCH_WRONG = 5
};

enum bench_role { BENCH_PING, BENCH_PONG, BENCH_TPUT_PUB, BENCH_TPUT_SUB, BENCH_MATCHED };

/// The command line, parsed. Strings belong to argv.
struct bench_options {
  enum bench_role role;
  uint32_t domain;
  uint32_t count;
  uint32_t size;
  double timeout;
  double duration;
  const char* security;   ///< a folder, or NULL
  const char* address;    ///< of the interface; bench_is_local: the loopback, without multicast
  bool best_effort;       ///< endpoints are BEST_EFFORT and KEEP_LAST 1
  bool listener;          ///< role ping receives in its listener
  bool waiting;           ///< role pong waits, and answers without a listener
  uint32_t busy_wait_us;  ///< of the embedded participant alone
  uint32_t interval_us;   ///< from one ping to the next; 0: the next follows the pong
};

/// What both makes keep at most of unacknowledged samples: as ddssec-peer, and 64 MiB.
uint32_t bench_most_samples(const struct bench_options* options);

struct bench_blob {
  uint32_t seq;
  uint32_t pad;
  uint64_t t_ns;
  const uint8_t* data;
  uint32_t length;
};

/// What a DDS stack does for the loops. `self` is the stack's own state.
struct bench_stack {
  void* self;
  /// Remote readers and remote writers matched at this moment.
  uint32_t (*readers)(void* self);
  uint32_t (*writers)(void* self);
  /// False: refused for now.
  bool (*write)(void* self, const struct bench_blob* blob);
  /// Takes one sample, valid until the next call; false: there is none.
  bool (*take)(void* self, struct bench_blob* blob);
  /// Until there is something to take, or 20 ms.
  void (*wait)(void* self);
  /// Every sample is acknowledged; waits 10 ms at most.
  bool (*acknowledged)(void* self);
};

/// Parses argv; prints usage and ends the process if it must.
void bench_parse(int argc, char** argv, struct bench_options* options);
bool bench_is_local(const struct bench_options* options);
/// The topic the role writes or reads; NULL: it does not.
const char* bench_written(enum bench_role role);
const char* bench_read(enum bench_role role);

/// "DIRECTORY/NAME" behind `prefix`; the result is allocated and belongs to the caller.
char* bench_document(const char* prefix, const char* directory, const char* name);

/// Says that something could not be created; BENCH_NOT_CREATED.
int bench_refused(const char* what, const char* reason);
/// The role receives in the listener of its reader, which calls bench_on_data.
bool bench_listens(const struct bench_options* options);
/// From the listener: answers what has come, or measures it.
void bench_on_data(const struct bench_stack* stack);
/// Runs the role to its end and says `done` and `exit`. Returns the exit code.
int bench_run(const struct bench_options* options, const struct bench_stack* stack);

#ifdef __cplusplus
}
#endif
#endif
