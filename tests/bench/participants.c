#define _POSIX_C_SOURCE 200809L
#include "bench/participants.h"

#include <getopt.h>
#include <inttypes.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
  PATIENCE_NS = 20000000,
  SETTLE_MS = 100,
  WARM_UP = 200,
  MAX_SIZE = 64 << 20,
  MAX_COUNT = 10000000
};
static const uint32_t end_marker = 0xffffffffu;

static volatile sig_atomic_t stopped;

static void on_signal(int number) {
  (void)number;
  stopped = 1;
}

// ---- command line

static const struct {
  const char *name, *written, *read;
} roles[] = {{"ping", "PerfPing", "PerfPong"},
             {"pong", "PerfPong", "PerfPing"},
             {"tput-pub", "PerfTput", NULL},
             {"tput-sub", NULL, "PerfTput"},
             {"matched", "PerfMatched", "PerfMatched"}};

const char* bench_written(enum bench_role role) { return roles[role].written; }
const char* bench_read(enum bench_role role) { return roles[role].read; }

bool bench_is_local(const struct bench_options* options) {
  return options->role != BENCH_MATCHED && strcmp(options->address, "127.0.0.1") == 0;
}

static void usage(const char* program) {
  fprintf(stderr,
          "usage: %s --role ping|pong|tput-pub|tput-sub|matched --domain N [--count N]\n"
          "       [--size OCTETS] [--duration S] [--timeout S] [--security DIR|off]\n"
          "       [--address IP] [--best-effort] [--listener] [--waiting] [--interval US]\n"
          "       [--busy-wait US]\n",
          program);
  exit(BENCH_USAGE);
}

static double number(const char* program, const char* text, double limit) {
  char* end = NULL;
  const double value = strtod(text, &end);
  if (end == text || *end != '\0' || !(value >= 0 && value <= limit)) usage(program);
  return value;
}

static enum bench_role role_of(const char* program, const char* name) {
  for (size_t i = 0; i < sizeof roles / sizeof *roles; ++i)
    if (strcmp(roles[i].name, name) == 0) return (enum bench_role)i;
  usage(program);
  return BENCH_PING;
}

static void apply(const char* program, int option, struct bench_options* options) {
  switch (option) {
    case 'r':
      options->role = role_of(program, optarg);
      break;
    case 'd':
      options->domain = (uint32_t)number(program, optarg, 232);
      break;
    case 'c':
      options->count = (uint32_t)number(program, optarg, MAX_COUNT);
      break;
    case 's':
      options->size = (uint32_t)number(program, optarg, MAX_SIZE);
      break;
    case 't':
      options->timeout = number(program, optarg, 86400);
      break;
    case 'u':
      options->duration = number(program, optarg, 86400);
      break;
    case 'k':
      options->security = strcmp(optarg, "off") == 0 ? NULL : optarg;
      break;
    case 'a':
      options->address = optarg;
      break;
    case 'b':
      options->best_effort = true;
      break;
    case 'l':
      options->listener = true;
      break;
    case 'w':
      options->waiting = true;
      break;
    case 'y':
      options->busy_wait_us = (uint32_t)number(program, optarg, 1000);
      break;
    case 'i':
      options->interval_us = (uint32_t)number(program, optarg, 1e6);
      break;
    default:
      usage(program);
  }
}

void bench_parse(int argc, char** argv, struct bench_options* options) {
  static const struct option table[] = {
      {"role", 1, NULL, 'r'},      {"domain", 1, NULL, 'd'},  {"count", 1, NULL, 'c'},
      {"size", 1, NULL, 's'},      {"timeout", 1, NULL, 't'}, {"duration", 1, NULL, 'u'},
      {"security", 1, NULL, 'k'},  {"address", 1, NULL, 'a'}, {"best-effort", 0, NULL, 'b'},
      {"listener", 0, NULL, 'l'},  {"waiting", 0, NULL, 'w'}, {"interval", 1, NULL, 'i'},
      {"busy-wait", 1, NULL, 'y'}, {NULL, 0, NULL, 0}};
  *options = (struct bench_options){
      .count = 10, .size = 64, .timeout = 30, .duration = 2, .address = "127.0.0.1"};
  bool role = false;
  for (int option; (option = getopt_long(argc, argv, "", table, NULL)) != -1;) {
    role = role || option == 'r';
    apply(argv[0], option, options);
  }
  if (!role || optind != argc) usage(argv[0]);
}

uint32_t bench_most_samples(const struct bench_options* options) {
  const uint32_t fit = MAX_SIZE / (options->size + 1);
  return fit < 16 ? 16 : fit > 2048 ? 2048 : fit;
}

char* bench_document(const char* prefix, const char* directory, const char* name) {
  const size_t size = strlen(prefix) + strlen(directory) + strlen(name) + 2;
  char* out = malloc(size);
  if (out != NULL) snprintf(out, size, "%s%s/%s", prefix, directory, name);
  return out;
}

// ---- the roles

struct run {
  const struct bench_options* options;
  const struct bench_stack* stack;
  uint8_t* payload;
  int64_t end;
  bool ever_matched;
  uint64_t written, received, corrupt;
};

static atomic_ullong echoed;

static int64_t now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

static bool over(const struct run* run) { return stopped || now() >= run->end; }

static void nap(long milliseconds) {
  nanosleep(&(struct timespec){.tv_nsec = milliseconds * 1000000}, NULL);
}

int bench_refused(const char* what, const char* reason) {
  printf("{\"event\":\"error\",\"what\":\"%s: %s\"}\n", what, reason);
  printf("{\"event\":\"exit\",\"code\":%d}\n", BENCH_NOT_CREATED);
  fflush(stdout);
  return BENCH_NOT_CREATED;
}

static bool is_matched(struct run* run) {
  const struct bench_stack* stack = run->stack;
  const enum bench_role role = run->options->role;
  const bool good = (bench_written(role) == NULL || stack->readers(stack->self) > 0) &&
                    (bench_read(role) == NULL || stack->writers(stack->self) > 0);
  run->ever_matched = run->ever_matched || good;
  return good;
}

static bool wait_for_match(struct run* run) {
  while (!is_matched(run)) {
    if (over(run)) return false;
    nap(1);
  }
  return true;
}

static int ascending(const void* left, const void* right) {
  const double a = *(const double*)left, b = *(const double*)right;
  return (a > b) - (a < b);
}

static double cpu_seconds(void) {
  struct timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/// The round trips of role ping. The listener and the main thread never use it at the same time,
/// except for `done`.
static struct {
  double* microseconds;
  uint32_t measured, lost, next;
  int64_t begin, until;
  double cpu_before;
  atomic_bool done;
} trips;
static struct run* pinging;

// Returns by how much one round trip differs from the one before, on average.
static double jitter(const double* microseconds, size_t count) {
  double sum = 0;
  for (size_t i = 1; i < count; ++i) {
    const double step = microseconds[i] - microseconds[i - 1];
    sum += step < 0 ? -step : step;
  }
  return count > 1 ? sum / (double)(count - 1) : 0;
}

static void say_round_trips(const struct run* run, double cpu) {
  double* microseconds = trips.microseconds;
  const size_t count = trips.measured;
  const double jitter_us = jitter(microseconds, count);
  qsort(microseconds, count, sizeof *microseconds, ascending);
  const double last = (double)(count - 1);
  printf("{\"event\":\"rtt\",\"size\":%" PRIu32 ",\"n\":%zu,\"lost\":%" PRIu32
         ",\"min_us\":%.3f,\"median_us\":%.3f,\"p90_us\":%.3f,\"p99_us\":%.3f,"
         "\"p999_us\":%.3f,\"p9999_us\":%.3f,\"max_us\":%.3f,\"jitter_us\":%.3f,"
         "\"cpu_us\":%.3f}\n",
         run->options->size, count, trips.lost, microseconds[0], microseconds[(size_t)(last * 0.5)],
         microseconds[(size_t)(last * 0.9)], microseconds[(size_t)(last * 0.99)],
         microseconds[(size_t)(last * 0.999)], microseconds[(size_t)(last * 0.9999)],
         microseconds[count - 1], jitter_us, cpu * 1e6 / (double)count);
}

static bool send_ping(struct run* run) {
  const struct bench_stack* stack = run->stack;
  trips.begin = now();
  trips.until = trips.begin + PATIENCE_NS;
  const struct bench_blob ping = {trips.next, 0, (uint64_t)trips.begin, run->payload,
                                  run->options->size};
  if (trips.next == WARM_UP) trips.cpu_before = cpu_seconds();
  if (!stack->write(stack->self, &ping)) return false;
  ++run->written;
  return true;
}

// Returns true and notes the time if the pong is the awaited one.
static bool note_pong(struct run* run, const struct bench_blob* pong) {
  if (pong->seq != trips.next) return false;
  ++run->received;
  run->corrupt +=
      pong->length != run->options->size || memcmp(pong->data, run->payload, pong->length) != 0;
  if (trips.next >= WARM_UP)
    trips.microseconds[trips.measured++] = (double)(now() - trips.begin) * 1e-3;
  return true;
}

static bool is_last(const struct run* run) {
  return trips.next + 1 >= WARM_UP + run->options->count;
}

// Returns false if the pong did not arrive. A best-effort sample may be lost.
static bool await_pong(struct run* run) {
  const struct bench_stack* stack = run->stack;
  struct bench_blob pong;
  while (!over(run)) {
    while (stack->take(stack->self, &pong))
      if (note_pong(run, &pong)) return true;
    if (run->options->best_effort && now() >= trips.until) break;
    stack->wait(stack->self);
  }
  return false;
}

static void pace(const struct run* run) {
  const int64_t left = trips.begin + (int64_t)run->options->interval_us * 1000 - now();
  if (run->options->interval_us > 0 && left > 0)
    nanosleep(&(struct timespec){.tv_sec = left / 1000000000, .tv_nsec = left % 1000000000}, NULL);
}

static void ping_and_wait(struct run* run) {
  for (; trips.next < WARM_UP + run->options->count; ++trips.next) {
    if (!send_ping(run)) return;
    if (await_pong(run))
      pace(run);
    else if (over(run) || !run->options->best_effort)
      return;
    else
      ++trips.lost;
  }
}

// The listener sends the next ping. A lost best-effort sample ends the run.
static void ping_and_listen(struct run* run) {
  pinging = run;
  if (!send_ping(run)) return;
  while (!trips.done && !over(run)) nap(20);
}

static void bench_next(struct run* run) {
  struct bench_blob pong;
  while (run->stack->take(run->stack->self, &pong)) {
    if (trips.done || !note_pong(run, &pong)) continue;
    if (is_last(run)) {
      trips.done = true;
      return;
    }
    ++trips.next;
    pace(run);
    if (!send_ping(run)) trips.done = true;
  }
}

static int run_ping(struct run* run) {
  if (!wait_for_match(run)) return BENCH_NEVER_MATCHED;
  const uint32_t count = run->options->count;
  trips.microseconds = calloc(count + 1u, sizeof *trips.microseconds);
  if (trips.microseconds == NULL) return BENCH_NOT_CREATED;
  // The other side may match a little later, and samples that are sent before are lost.
  nap(SETTLE_MS);
  if (run->options->listener)
    ping_and_listen(run);
  else
    ping_and_wait(run);
  const double cpu = cpu_seconds() - trips.cpu_before;
  const bool whole = trips.measured + trips.lost >= count;
  if (trips.measured > 0 && (whole || !run->options->listener)) say_round_trips(run, cpu);
  return run->corrupt > 0 ? BENCH_WRONG : whole ? BENCH_DONE : BENCH_MISSING;
}

bool bench_listens(const struct bench_options* options) {
  return options->role == BENCH_PING ? options->listener
                                     : options->role == BENCH_PONG && !options->waiting;
}

static bool echo(const struct bench_stack* stack) {
  struct bench_blob ping;
  bool any = false;
  for (; stack->take(stack->self, &ping); any = true)
    if (stack->write(stack->self, &ping)) ++echoed;
  return any;
}

void bench_on_data(const struct bench_stack* stack) {
  if (pinging != NULL)
    bench_next(pinging);
  else
    echo(stack);
}

static int run_pong(struct run* run) {
  while (!over(run)) {
    if (!is_matched(run) && run->ever_matched) break;
    if (!run->options->waiting) {
      nap(20);
      continue;
    }
    do run->stack->wait(run->stack->self);
    while (echo(run->stack) && !over(run));
  }
  run->received = run->written = echoed;
  return run->ever_matched ? BENCH_DONE : BENCH_NEVER_MATCHED;
}

static int run_tput_pub(struct run* run) {
  const struct bench_stack* stack = run->stack;
  if (!wait_for_match(run)) return BENCH_NEVER_MATCHED;
  struct bench_blob sample = {.data = run->payload, .length = run->options->size};
  const int64_t end = now() + (int64_t)(run->options->duration * 1e9);
  while (now() < end && !over(run)) {
    sample.t_ns = (uint64_t)now();
    if (!stack->write(stack->self, &sample)) continue;
    ++sample.seq;
    ++run->written;
  }
  const struct bench_blob marker = {.seq = end_marker, .pad = sample.seq, .data = run->payload};
  while (!over(run) && !stack->write(stack->self, &marker)) {
  }
  while (!stack->acknowledged(stack->self))
    if (over(run)) return BENCH_MISSING;
  return BENCH_DONE;
}

static void say_throughput(const struct run* run, uint32_t sent, uint64_t octets, int64_t taken) {
  const double seconds = taken > 0 ? (double)taken * 1e-9 : 1e-9;
  printf("{\"event\":\"tput\",\"size\":%" PRIu32 ",\"samples\":%" PRIu64 ",\"sent\":%" PRIu32
         ",\"seconds\":%.6f,\"samples_per_s\":%.1f,\"mbit_per_s\":%.3f}\n",
         run->options->size, run->received, sent, seconds, (double)run->received / seconds,
         (double)octets * 8e-6 / seconds);
}

static int run_tput_sub(struct run* run) {
  const struct bench_stack* stack = run->stack;
  struct bench_blob sample = {0};
  int64_t first = 0, last = 0;
  uint64_t octets = 0;
  bool ended = false;
  while (!over(run) && !ended) {
    stack->wait(stack->self);
    is_matched(run);
    while (!ended && stack->take(stack->self, &sample)) {
      ended = sample.seq == end_marker;
      if (ended) break;
      run->corrupt += sample.seq != run->received;
      if (run->received++ == 0) first = now();
      octets += sample.length;
    }
    last = now();
  }
  if (!run->ever_matched) return BENCH_NEVER_MATCHED;
  const uint32_t sent = ended ? sample.pad : 0;
  say_throughput(run, sent, octets, last - first);
  if (run->corrupt > 0) return BENCH_WRONG;
  return ended && sent == run->received ? BENCH_DONE : BENCH_MISSING;
}

// Waits until --count writers and readers are matched, its own among them. Then it stays without
// writing until it is killed, because only the time of the other processes is measured.
static int run_matched(struct run* run) {
  const struct bench_stack* stack = run->stack;
  const double created = cpu_seconds();
  uint32_t readers, writers;
  for (;;) {
    readers = stack->readers(stack->self);
    writers = stack->writers(stack->self);
    run->ever_matched = readers >= run->options->count && writers >= run->options->count;
    if (run->ever_matched || over(run)) break;
    nap(10);
  }
  printf("{\"event\":\"%s\",\"readers\":%" PRIu32 ",\"writers\":%" PRIu32
         ",\"at_s\":%.4f,\"created_cpu_s\":%.4f}\n",
         run->ever_matched ? "matched" : "incomplete", readers, writers, (double)now() * 1e-9,
         created);
  fflush(stdout);
  while (run->ever_matched && !over(run)) nap(50);
  return run->ever_matched ? BENCH_DONE : BENCH_NEVER_MATCHED;
}

int bench_run(const struct bench_options* options, const struct bench_stack* stack) {
  static int (*const run_role[])(struct run*) = {run_ping, run_pong, run_tput_pub, run_tput_sub,
                                                 run_matched};
  struct sigaction action = {.sa_handler = on_signal};
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGINT, &action, NULL);
  struct run run = {.options = options, .stack = stack};
  run.end = now() + (int64_t)(options->timeout * 1e9);
  run.payload = malloc(options->size + 1u);
  if (run.payload == NULL) return bench_refused("memory", "out of memory");
  memset(run.payload, 0x5a, options->size + 1u);
  puts("{\"event\":\"participant_created\"}");
  const int code = run_role[options->role](&run);
  free(run.payload);
  printf("{\"event\":\"done\",\"matched\":%s,\"written\":%" PRIu64 ",\"received\":%" PRIu64
         ",\"corrupt\":%" PRIu64 "}\n",
         run.ever_matched ? "true" : "false", run.written, run.received, run.corrupt);
  printf("{\"event\":\"exit\",\"code\":%d}\n", code);
  fflush(stdout);
  return code;
}
