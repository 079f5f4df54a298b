#define _POSIX_C_SOURCE 200809L
#include "interop/peers/peer.h"

#include <getopt.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char color[] = "BLUE";
enum {
  MAX_SAMPLES = 100000,
  MAX_PAYLOAD = 64 << 20,
  MAX_USER_DATA = 60000,
  MAX_INTERVAL = 60000,
  MAX_EXIT_AFTER = 60000
};

static volatile sig_atomic_t stopped;

static void on_signal(int number) {
  (void)number;
  stopped = 1;
}

void peer_say(const char* format, ...) {
  va_list args;
  va_start(args, format);
  vprintf(format, args);
  va_end(args);
  putchar('\n');
  fflush(stdout);
}

int peer_refused(const char* what, const char* reason) {
  peer_say("refused %s: %s", what, reason);
  return PEER_REFUSED;
}

char* peer_uri(const char* prefix, const char* value) {
  static const char* const schemes[] = {"file:", "data:", "pkcs11:"};
  for (size_t i = 0; i < sizeof schemes / sizeof *schemes; ++i)
    if (strncmp(value, schemes[i], strlen(schemes[i])) == 0) return strdup(value);
  const size_t size = strlen(prefix) + strlen(value) + 1;
  char* uri = malloc(size);
  if (uri != NULL) snprintf(uri, size, "%s%s", prefix, value);
  return uri;
}

// ---- command line

static void usage(const char* program, int status) {
  fprintf(
      status == 0 ? stdout : stderr,
      "usage: %s --publish|--subscribe [--topic T] [--domain D] [--partition P]\n"
      "       [--samples N] [--payload OCTETS] [--timeout SECONDS] [--hold]\n"
      "       [--keep-last DEPTH] [--interval MS] [--lease SECONDS]\n"
      "       [--volatile]\n"
      "       [--address OF_INTERFACE] [--peer ADDRESS]\n"
      "       --plain | --identity_ca F --identity_certificate F --private_key F\n"
      "                 --permissions_ca F --governance F --permissions F\n"
      "                 [--password P] [--crl F] [--keysize 128|256] [--cipher NAME]\n"
      "       [--plugins auth=NAME,ac=NAME,crypto=NAME]   (Cyclone DDS only)\n"
      "       [--companion CERTIFICATE,KEY,PERMISSIONS,SAMPLES]   (Cyclone DDS only)\n"
      "       [--user-data OCTETS]   (Cyclone DDS only)\n"
      "       [--decoy PARTITION]   of an endpoint that is not used (Cyclone DDS only)\n"
      "       [--late SECONDS]   until a subscriber makes further entities (Cyclone DDS only)\n"
      "       [--passing READERS]   further ones, deleted after some seconds (Cyclone DDS only)\n"
      "       [--exit-after MS]   calls exit() and deletes nothing\n"
      "       [--property NAME=VALUE]...\n"
      "exit: 0 all samples seen or acknowledged, 2 usage, 3 refused, 4 no match, 5 no samples\n",
      program);
  exit(status);
}

static uint32_t number(const char* program, const char* text, unsigned long limit) {
  char* end = NULL;
  const unsigned long value = strtoul(text, &end, 10);
  if (end == text || *end != '\0' || value > limit) {
    fprintf(stderr, "%s: %s is not a number from 0 to %lu\n", program, text, limit);
    exit(PEER_USAGE);
  }
  return (uint32_t)value;
}

static void plugin_names(const char* program, char* list, struct peer_options* options) {
  for (char* item = strtok(list, ","); item != NULL; item = strtok(NULL, ",")) {
    if (strncmp(item, "auth=", 5) == 0)
      options->plugin_auth = item + 5;
    else if (strncmp(item, "ac=", 3) == 0)
      options->plugin_ac = item + 3;
    else if (strncmp(item, "crypto=", 7) == 0)
      options->plugin_crypto = item + 7;
    else
      usage(program, PEER_USAGE);
  }
}

static void raw_property(const char* program, char* text, struct peer_options* options) {
  char* equals = strchr(text, '=');
  if (equals == NULL || options->properties == PEER_MAX_PROPERTIES) usage(program, PEER_USAGE);
  *equals = '\0';
  options->property_name[options->properties] = text;
  options->property_value[options->properties++] = equals + 1;
}

enum {
  OPT_SECURITY = 256,
  OPT_PUBLISH = 512,
  OPT_SUBSCRIBE,
  OPT_PLAIN,
  OPT_HOLD,
  OPT_VOLATILE,
  OPT_TOPIC,
  OPT_DOMAIN,
  OPT_PARTITION,
  OPT_DECOY,
  OPT_SAMPLES,
  OPT_PAYLOAD,
  OPT_TIMEOUT,
  OPT_KEEP_LAST,
  OPT_LEASE,
  OPT_INTERVAL,
  OPT_ADDRESS,
  OPT_PEER,
  OPT_PLUGINS,
  OPT_COMPANION,
  OPT_USER_DATA,
  OPT_LATE,
  OPT_PASSING,
  OPT_EXIT_AFTER,
  OPT_PROPERTY,
  OPT_HELP
};

static const struct option table[] = {
    {"identity_ca", 1, NULL, OPT_SECURITY + PEER_IDENTITY_CA},
    {"identity_certificate", 1, NULL, OPT_SECURITY + PEER_IDENTITY_CERTIFICATE},
    {"private_key", 1, NULL, OPT_SECURITY + PEER_PRIVATE_KEY},
    {"password", 1, NULL, OPT_SECURITY + PEER_PASSWORD},
    {"crl", 1, NULL, OPT_SECURITY + PEER_CRL},
    {"permissions_ca", 1, NULL, OPT_SECURITY + PEER_PERMISSIONS_CA},
    {"governance", 1, NULL, OPT_SECURITY + PEER_GOVERNANCE},
    {"permissions", 1, NULL, OPT_SECURITY + PEER_PERMISSIONS},
    {"keysize", 1, NULL, OPT_SECURITY + PEER_KEYSIZE},
    {"cipher", 1, NULL, OPT_SECURITY + PEER_CIPHER},
    {"publish", 0, NULL, OPT_PUBLISH},
    {"subscribe", 0, NULL, OPT_SUBSCRIBE},
    {"plain", 0, NULL, OPT_PLAIN},
    {"hold", 0, NULL, OPT_HOLD},
    {"volatile", 0, NULL, OPT_VOLATILE},
    {"topic", 1, NULL, OPT_TOPIC},
    {"domain", 1, NULL, OPT_DOMAIN},
    {"partition", 1, NULL, OPT_PARTITION},
    {"decoy", 1, NULL, OPT_DECOY},
    {"samples", 1, NULL, OPT_SAMPLES},
    {"payload", 1, NULL, OPT_PAYLOAD},
    {"timeout", 1, NULL, OPT_TIMEOUT},
    {"keep-last", 1, NULL, OPT_KEEP_LAST},
    {"lease", 1, NULL, OPT_LEASE},
    {"interval", 1, NULL, OPT_INTERVAL},
    {"address", 1, NULL, OPT_ADDRESS},
    {"peer", 1, NULL, OPT_PEER},
    {"plugins", 1, NULL, OPT_PLUGINS},
    {"companion", 1, NULL, OPT_COMPANION},
    {"user-data", 1, NULL, OPT_USER_DATA},
    {"late", 1, NULL, OPT_LATE},
    {"passing", 1, NULL, OPT_PASSING},
    {"exit-after", 1, NULL, OPT_EXIT_AFTER},
    {"property", 1, NULL, OPT_PROPERTY},
    {"help", 0, NULL, OPT_HELP},
    {NULL, 0, NULL, 0}};

static void apply(const char* program, int option, struct peer_options* options, int* roles) {
  if (option >= OPT_SECURITY && option < OPT_SECURITY + PEER_SECURITY_COUNT) {
    options->security[option - OPT_SECURITY] = optarg;
    return;
  }
  switch (option) {
    case OPT_PUBLISH:
      options->publish = true;
      ++*roles;
      break;
    case OPT_SUBSCRIBE:
      options->publish = false;
      ++*roles;
      break;
    case OPT_PLAIN:
      options->plain = true;
      break;
    case OPT_VOLATILE:
      options->is_volatile = true;
      break;
    case OPT_HOLD:
      options->hold = true;
      break;
    case OPT_TOPIC:
      options->topic = optarg;
      break;
    case OPT_DOMAIN:
      options->domain = number(program, optarg, 230);
      break;
    case OPT_PARTITION:
      options->partition = optarg;
      break;
    case OPT_DECOY:
      options->decoy = optarg;
      break;
    case OPT_SAMPLES:
      options->samples = number(program, optarg, MAX_SAMPLES);
      break;
    case OPT_PAYLOAD:
      options->payload = number(program, optarg, MAX_PAYLOAD);
      break;
    case OPT_TIMEOUT:
      options->timeout = number(program, optarg, 86400);
      break;
    case OPT_KEEP_LAST:
      options->keep_last = number(program, optarg, MAX_SAMPLES);
      break;
    case OPT_LEASE:
      options->lease = number(program, optarg, 3600);
      break;
    case OPT_INTERVAL:
      options->interval = number(program, optarg, MAX_INTERVAL);
      break;
    case OPT_USER_DATA:
      options->user_data = number(program, optarg, MAX_USER_DATA);
      break;
    case OPT_LATE:
      options->late = number(program, optarg, 3600);
      break;
    case OPT_PASSING:
      options->passing = number(program, optarg, PEER_MAX_PASSING);
      break;
    case OPT_EXIT_AFTER:
      options->exit_after = number(program, optarg, MAX_EXIT_AFTER);
      break;
    case OPT_ADDRESS:
      options->address = optarg;
      break;
    case OPT_PEER:
      options->peer = optarg;
      break;
    case OPT_PLUGINS:
      plugin_names(program, optarg, options);
      break;
    case OPT_COMPANION:
      options->companion = optarg;
      break;
    case OPT_PROPERTY:
      raw_property(program, optarg, options);
      break;
    case OPT_HELP:
      usage(program, 0);
      break;
    default:
      usage(program, PEER_USAGE);
  }
}

void peer_parse(int argc, char** argv, struct peer_options* options) {
  *options = (struct peer_options){.samples = 10,
                                   .payload = 32,
                                   .timeout = 10,
                                   .topic = "Square",
                                   .address = "127.0.0.1",
                                   .peer = "127.0.0.1",
                                   .plugin_auth = "dds_security_auth",
                                   .plugin_ac = "dds_security_ac",
                                   .plugin_crypto = "dds_security_crypto"};
  int roles = 0;
  for (int option; (option = getopt_long(argc, argv, "", table, NULL)) != -1;)
    apply(argv[0], option, options, &roles);
  if (roles != 1 || optind != argc) usage(argv[0], PEER_USAGE);
}

// ---- the loop

static double now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + (double)time.tv_nsec * 1e-9;
}

static void nap(void) { nanosleep(&(struct timespec){.tv_nsec = 3000000}, NULL); }

struct run {
  const struct peer_options* options;
  const struct peer_stack* stack;
  uint8_t* payload;
  bool* seen;        // subscriber: which sample numbers came
  uint32_t count;    // samples sent, or different samples seen
  uint32_t matched;  // remote endpoints matched at the last look
  bool ever_matched;
  bool corrupt;
  double next_write;
};

static void watch_matches(struct run* run) {
  const uint32_t matched = run->stack->matched(run->stack->self);
  if (matched > run->matched) peer_say("matched %u", matched);
  if (matched < run->matched) peer_say("unmatched %u", matched);
  if (matched > 0) run->ever_matched = true;
  run->matched = matched;
}

static uint8_t pattern(int32_t index, uint32_t at) { return (uint8_t)((uint32_t)index * 7 + at); }

// Runs one round of the publisher. Returns true once everything was sent and acknowledged.
static bool publish_some(struct run* run) {
  const struct peer_options* options = run->options;
  if (run->matched == 0) return false;
  if (run->count >= options->samples && !options->hold)
    return run->stack->acknowledged(run->stack->self);
  if (now() < run->next_write) return false;
  const int32_t index = (int32_t)run->count;
  for (uint32_t i = 0; i < options->payload; ++i) run->payload[i] = pattern(index, i);
  if (run->stack->write(run->stack->self, index, run->payload, options->payload)) ++run->count;
  if (run->count == options->samples) peer_say("written %u", run->count);
  const double standard = options->hold ? 0.1 : 0.005;
  run->next_write = now() + (options->interval ? options->interval * 1e-3 : standard);
  return false;
}

static bool intact(const struct peer_sample* sample) {
  if (strcmp(sample->color, color) != 0 || sample->x < 0) return false;
  for (uint32_t i = 0; i < sample->payload_length; ++i)
    if (sample->payload[i] != pattern(sample->x, i)) return false;
  return true;
}

// Runs one round of the subscriber. Returns true once every sample was seen.
static bool receive_some(struct run* run) {
  struct peer_sample sample;
  while (run->stack->take(run->stack->self, &sample)) {
    const bool good = intact(&sample);
    peer_say("sample %d %u%s", sample.x, sample.payload_length, good ? "" : " corrupt");
    if (!good) run->corrupt = true;
    if (!good || (uint32_t)sample.x >= run->options->samples || run->seen[sample.x]) continue;
    run->seen[sample.x] = true;
    ++run->count;
  }
  return run->count >= run->options->samples && !run->options->hold;
}

// The publisher still needs the last acknowledgment, so this stays until the publisher is gone, or
// for one second.
static void linger(struct run* run) {
  for (const double end = now() + 1; !stopped && run->matched > 0 && now() < end; nap())
    watch_matches(run);
}

static int verdict(const struct run* run, bool done) {
  const bool held = run->options->hold && run->count >= run->options->samples;
  if (run->corrupt) return PEER_NO_SAMPLES;
  if (done || held) return PEER_OK;
  return run->ever_matched ? PEER_NO_SAMPLES : PEER_NO_MATCH;
}

static int run_until_done(struct run* run) {
  const bool publish = run->options->publish;
  const double begin = now(), end = begin + run->options->timeout;
  const double exit_after = run->options->exit_after * 1e-3;
  bool done = false;
  while (!done && !stopped && now() < end) {
    if (exit_after > 0 && now() - begin >= exit_after) exit(PEER_OK);
    watch_matches(run);
    done = publish ? publish_some(run) : receive_some(run);
    if (!done) nap();
  }
  if (done)
    peer_say(publish ? "acknowledged %u" : "received %u", run->count);
  else
    peer_say(stopped ? "stopped" : "timeout");
  if (done && !publish) linger(run);
  return verdict(run, done);
}

int peer_run(const struct peer_options* options, const struct peer_stack* stack) {
  struct sigaction action = {.sa_handler = on_signal};
  sigaction(SIGTERM, &action, NULL);
  sigaction(SIGINT, &action, NULL);
  struct run run = {.options = options, .stack = stack};
  run.payload = malloc(options->payload + 1u);
  run.seen = calloc(options->samples + 1u, sizeof *run.seen);
  if (run.payload == NULL || run.seen == NULL) return peer_refused("memory", "out of memory");
  peer_say("created");
  const int status = run_until_done(&run);
  free(run.payload);
  free(run.seen);
  return status;
}
