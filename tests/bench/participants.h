// What the measuring peers on other DDS products share: the command line and output of ddssec-peer
// for its roles ping, pong, tput-pub and tput-sub, one more role that only waits for matches, and
// their loops. A stack supplies a few calls and nothing else, so all peers behave alike.
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

/// Returns how many unacknowledged samples the peers keep at most: as many as ddssec-peer, and at
/// most 64 MiB.
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
  /// The number of remote readers and remote writers that are matched at this moment.
  uint32_t (*readers)(void* self);
  uint32_t (*writers)(void* self);
  /// Returns false if the stack refuses the sample for now.
  bool (*write)(void* self, const struct bench_blob* blob);
  /// Takes one sample, which is valid until the next call. Returns false if there is none.
  bool (*take)(void* self, struct bench_blob* blob);
  /// Waits until there is something to take, for at most 20 ms.
  void (*wait)(void* self);
  /// Returns true if every sample is acknowledged; waits 10 ms at most.
  bool (*acknowledged)(void* self);
};

/// Parses argv. Prints usage and ends the process if it must.
void bench_parse(int argc, char** argv, struct bench_options* options);
bool bench_is_local(const struct bench_options* options);
/// Return the topic that the role writes or reads, or NULL if it does not.
const char* bench_written(enum bench_role role);
const char* bench_read(enum bench_role role);

/// Returns "DIRECTORY/NAME" after `prefix`. The result is allocated and belongs to the caller.
char* bench_document(const char* prefix, const char* directory, const char* name);

/// Reports that something could not be created, and returns BENCH_NOT_CREATED.
int bench_refused(const char* what, const char* reason);
/// Returns true if the role receives in the listener of its reader, which calls bench_on_data.
bool bench_listens(const struct bench_options* options);
/// Must be called from the listener. Answers the samples that arrived, or measures them.
void bench_on_data(const struct bench_stack* stack);
/// Runs the role to its end and prints `done` and `exit`. Returns the exit code.
int bench_run(const struct bench_options* options, const struct bench_stack* stack);

#ifdef __cplusplus
}
#endif
#endif
