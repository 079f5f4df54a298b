// What the Cyclone and the Fast DDS test peer share: command line, exit codes, milestones and the
// loop that publishes or receives. A stack supplies four calls (struct peer_stack) and nothing
// else, so that both peers behave alike.
#ifndef DDSSEC_INTEROP_PEER_H
#define DDSSEC_INTEROP_PEER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Exit codes of a peer.
enum peer_exit {
  PEER_OK = 0,         ///< publisher: every sample acknowledged; subscriber: every sample seen
  PEER_USAGE = 2,      ///< the command line is wrong
  PEER_REFUSED = 3,    ///< participant, topic or endpoint could not be created
  PEER_NO_MATCH = 4,   ///< no remote endpoint matched before the timeout
  PEER_NO_SAMPLES = 5  ///< matched, but samples or acknowledgements are missing
};

/// The security documents and values a peer is given, in the order of peer_security_names.
enum peer_security {
  PEER_IDENTITY_CA,
  PEER_IDENTITY_CERTIFICATE,
  PEER_PRIVATE_KEY,
  PEER_PASSWORD,
  PEER_CRL,
  PEER_PERMISSIONS_CA,
  PEER_GOVERNANCE,
  PEER_PERMISSIONS,
  PEER_KEYSIZE,
  PEER_CIPHER,  ///< of the endpoint (Cyclone DDS) or of the participant (embedded)
  PEER_SECURITY_COUNT
};

enum { PEER_MAX_PROPERTIES = 16, PEER_MAX_PASSING = 100, PEER_PASSING_SECONDS = 5 };

/// The command line, parsed. Strings belong to argv or live as long as the process.
struct peer_options {
  bool publish;      ///< publisher if true, else subscriber
  bool plain;        ///< no security properties at all
  bool hold;         ///< keep running (and publishing) until the timeout or a signal
  bool is_volatile;  ///< what all readers have acknowledged is not kept
  uint32_t domain;
  uint32_t samples;     ///< how many samples are sent or awaited
  uint32_t payload;     ///< octets in each sample's payload
  uint32_t keep_last;   ///< history depth (publishers, and subscribers of Cyclone DDS); 0: keep all
  uint32_t lease;       ///< lease of the participant in seconds; 0: the stack's own
  uint32_t interval;    ///< milliseconds between two samples; 0: 5, with hold 100
  uint32_t passing;     ///< further readers, deleted after some seconds (Cyclone DDS only)
  uint32_t exit_after;  ///< milliseconds until exit() is called with all entities alive; 0: never
  uint32_t late;        ///< seconds until a subscriber makes further entities (Cyclone DDS only)
  uint32_t user_data;   ///< octets, of the participant and its endpoints (Cyclone DDS only)
  double timeout;       ///< seconds after which the peer ends whatever happened
  const char* address;  ///< of the interface to use
  const char* peer;     ///< address that is announced to by unicast
  const char* topic;
  const char* partition;  ///< NULL: the default partition
  const char* decoy;      ///< of an endpoint that is not used; NULL: none (Cyclone DDS only)
  /// CERTIFICATE,KEY,PERMISSIONS,SAMPLES: a second participant of the process, which subscribes as
  /// well, knows no CRL and is deleted after so many samples (Cyclone DDS only); NULL: none
  char* companion;
  const char* plugin_auth;
  const char* plugin_ac;
  const char* plugin_crypto;
  const char* security[PEER_SECURITY_COUNT];  ///< NULL: not given
  size_t properties;                          ///< additional raw properties, name and value
  const char* property_name[PEER_MAX_PROPERTIES];
  const char* property_value[PEER_MAX_PROPERTIES];
};

/// One received sample, valid until the next call into the stack.
struct peer_sample {
  const char* color;
  int32_t x;
  const uint8_t* payload;
  uint32_t payload_length;
};

/// What a DDS stack does for the loop. `self` is the stack's own state.
struct peer_stack {
  void* self;
  /// Number of remote endpoints matched at this moment.
  uint32_t (*matched)(void* self);
  /// Publishes sample `index`; false if the stack refuses it now.
  bool (*write)(void* self, int32_t index, const uint8_t* payload, uint32_t length);
  /// True once every matched reader acknowledged everything; waits a few milliseconds at most.
  bool (*acknowledged)(void* self);
  /// Takes one sample; false if there is none.
  bool (*take)(void* self, struct peer_sample* sample);
};

/// Parses argv; prints usage and ends the process with PEER_USAGE or 0 (--help) if it must.
void peer_parse(int argc, char** argv, struct peer_options* options);

/// The document value as a URI: `value` itself if it has a known scheme, else `prefix` + value.
/// The result is allocated and belongs to the caller.
char* peer_uri(const char* prefix, const char* value);

/// Prints one milestone line to standard output at once.
void peer_say(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// Prints "refused WHAT: REASON" and returns PEER_REFUSED.
int peer_refused(const char* what, const char* reason);

/// Publishes or subscribes until done, the timeout, SIGTERM or SIGINT. Returns the exit code.
int peer_run(const struct peer_options* options, const struct peer_stack* stack);

#ifdef __cplusplus
}
#endif
#endif
