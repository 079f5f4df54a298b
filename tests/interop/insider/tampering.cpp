#include "tests/interop/insider/tampering.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <numeric>
#include <utility>

#include "tests/interop/insider/splice.hpp"
#include "tests/interop/insider/type_claims.hpp"

namespace insider {

bool tampers(std::string_view what) {
  const char* const mode = std::getenv("INSIDER_TAMPER");
  return mode != nullptr && mode == what;
}

void say_tampered() {
  static std::atomic<int> count = 0;
  if (++count == 1) std::fprintf(stderr, "insider: tampered\n");
}

std::string hex_of(const DDS_Security_octet* prefix) {
  std::string hex;
  for (int i = 0; i < 12; ++i) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", prefix[i]);
    hex += two;
  }
  return hex;
}

void say_prefix(const char* whose, const DDS_Security_octet* prefix) {
  std::fprintf(stderr, "insider: %s prefix %s\n", whose, hex_of(prefix).c_str());
}

Victim victim;
DDS_Security_octet own_prefix[12];

void Victim::meet(const DDS_Security_octet* prefix) {
  const std::lock_guard lock(mutex_);
  if (prefix_.empty()) say_prefix("victim", prefix);
  prefix_.assign(prefix, prefix + 12);
}

Bytes Victim::prefix() {
  const std::lock_guard lock(mutex_);
  return prefix_;
}

bool is_of_writer(const Bytes& octets, std::uint32_t writer) {
  constexpr DDS_Security_octet kData = 0x15;
  if (octets.size() < 24 || octets[0] != kData) return false;
  std::uint32_t id = 0;
  for (int i = 12; i < 16; ++i) id = id << 8 | octets[i];
  return id == writer;
}

namespace {

bool holds(const Bytes& octets, std::string_view text) {
  return std::string_view(reinterpret_cast<const char*>(octets.data()), octets.size()).find(text) !=
         std::string_view::npos;
}

// Finds endpoint_security_info in a parameter list, in either byte order.
void hide_access_control(Bytes& octets) {
  constexpr DDS_Security_octet kLittle[] = {0x04, 0x10, 8, 0}, kBig[] = {0x10, 0x04, 0, 8};
  for (std::size_t at = 0; at + 12 <= octets.size(); at += 4) {
    if (std::memcmp(&octets[at], kLittle, 4) != 0 && std::memcmp(&octets[at], kBig, 4) != 0)
      continue;
    std::memset(&octets[at + 4], 0, 8);
    say_tampered();
  }
}

// The place of the last octet of source_endpoint_guid in a DATA without inline QoS, whose payload
// begins at 24.
constexpr std::size_t kEntityKindAt = 24 + 84 + 15;

void name_victim(Bytes& octets, std::string_view token_class, std::size_t at) {
  const auto prefix = victim.prefix();
  if (prefix.empty() || !holds(octets, token_class) || octets.size() < at + 12) return;
  std::memcpy(&octets[at], prefix.data(), prefix.size());
  say_tampered();
}

void set_length(Bytes& submessage) {
  const auto length = submessage.size() - 4;
  submessage[2] = static_cast<DDS_Security_octet>(length);
  submessage[3] = static_cast<DDS_Security_octet>(length >> 8);
}

constexpr DDS_Security_octet kInlineQosFlag = 2, kDataFlag = 4, kKeyFlag = 8;

// Leaves the data out of what the volatile writer sends. A stock host writes little endian and no
// inline QoS.
void leave_key(Bytes& octets, bool only_hash) {
  if (!is_of_writer(octets, 0xff0202c3) || (octets[1] & kInlineQosFlag) != 0) return;
  octets[1] &= static_cast<DDS_Security_octet>(~kDataFlag);
  if (!only_hash) {
    octets[1] |= kKeyFlag;
  } else {
    octets[1] |= kInlineQosFlag;
    Bytes qos;
    splice::append_parameter(qos, 0x70, Bytes(16, 0x11));
    splice::append_parameter(qos, 1, {});
    octets.insert(octets.begin() + 24, qos.begin(), qos.end());
    set_length(octets);
  }
  say_tampered();
}

// Turns what the volatile writer sends into a fragment of a sample of two gigabytes.
void leave_fragment(Bytes& octets) {
  if (!is_of_writer(octets, 0xff0202c3) || (octets[1] & kInlineQosFlag) != 0) return;
  constexpr DDS_Security_octet kDataFrag = 0x16, kToInlineQos = 28;
  octets[0] = kDataFrag;
  octets[1] &= static_cast<DDS_Security_octet>(~kDataFlag);
  octets[6] = kToInlineQos;
  const auto size = octets.size() - 24;
  const Bytes place = {2,
                       0,
                       0,
                       0,
                       1,
                       0,
                       static_cast<DDS_Security_octet>(size),
                       static_cast<DDS_Security_octet>(size >> 8),
                       0,
                       0,
                       0,
                       0x77};
  octets.insert(octets.begin() + 24, place.begin(), place.end());
  set_length(octets);
  say_tampered();
}

// The key tokens of builtin writers to one participant all name one reader that never matches. As
// their writer they name one of two in turn. A retransmission stays unchanged.
void repeat_tokens(Bytes& octets) {
  constexpr std::size_t kLocalAt = 24 + 68, kRemoteAt = 24 + 84, kGuid = 16, kPrefix = 12;
  constexpr DDS_Security_octet kReader[] = {0xff, 0, 4, 0xc7};
  constexpr DDS_Security_octet kWriters[2][4] = {{0xff, 0, 3, 0xc2}, {0xff, 1, 1, 0xc2}};
  if (octets.size() < kRemoteAt + kGuid || octets[kEntityKindAt] != 0xc2 ||
      !holds(octets, "dds.sec.datawriter_crypto_tokens"))
    return;
  static std::mutex mutex;
  static std::map<std::string, std::map<std::string, std::size_t>>
      turns;  // by participant, and then by the GUIDs
  const auto at = [&](std::size_t begin, std::size_t size) {
    return std::string(octets.begin() + static_cast<std::ptrdiff_t>(begin),
                       octets.begin() + static_cast<std::ptrdiff_t>(begin + size));
  };
  const std::lock_guard lock(mutex);
  auto& known = turns[at(kLocalAt, kPrefix)];
  const auto turn = known.try_emplace(at(kLocalAt, 2 * kGuid), known.size()).first->second;
  std::memcpy(&octets[kLocalAt + kPrefix], kReader, sizeof kReader);
  std::memcpy(&octets[kRemoteAt + kPrefix], kWriters[turn % 2], 4);
  if (turn >= 2) say_tampered();
}

bool is_of_writer_tokens(const Bytes& octets) {
  return octets.size() > kEntityKindAt && holds(octets, "dds.sec.datawriter_crypto_tokens") &&
         (octets[kEntityKindAt] == 0x02 || octets[kEntityKindAt] == 0x03);
}

// The writer is invented in its announcements and in its key tokens.
void invent_writer(Bytes& octets) {
  constexpr DDS_Security_octet kInvented[] = {0xfe, 0, 1, 0xc2};
  if (is_of_writer_tokens(octets)) {
    std::memcpy(&octets[kEntityKindAt - 3], kInvented, sizeof kInvented);
    say_tampered();
  }
  if (!is_of_writer(octets, 0xff0003c2)) return;
  for (std::size_t at = 24; at + 16 <= octets.size(); at += 4)
    if (std::memcmp(&octets[at], own_prefix, 12) == 0 && octets[at + 15] <= 0x03)
      std::memcpy(&octets[at + 12], kInvented, sizeof kInvented);
}

void send_nobodys_tokens(Bytes& octets) {
  if (!is_of_writer_tokens(octets)) return;
  std::memset(&octets[kEntityKindAt - 15], 0, 12);
  say_tampered();
}

// Replaces every GUID in the payload.
void speak_as_victim(Bytes& octets) {
  const auto prefix = victim.prefix();
  if (prefix.empty()) return;
  for (std::size_t at = 24; at + 12 <= octets.size(); at += 4) {
    if (std::memcmp(&octets[at], own_prefix, 12) != 0) continue;
    std::memcpy(&octets[at], prefix.data(), 12);
    say_tampered();
  }
}

void dispose(Bytes& octets) {
  if ((octets[1] & kInlineQosFlag) != 0) return;
  const DDS_Security_octet qos[] = {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0};
  octets.insert(octets.begin() + 24, std::begin(qos), std::end(qos));
  octets[1] |= kInlineQosFlag;
  set_length(octets);
}

// The discriminator of the first type identifier in PID_TYPE_INFORMATION (little endian, as a stock
// host writes it) becomes one that Cyclone DDS does not expect.
void spoil_type_information(Bytes& octets) {
  constexpr DDS_Security_octet kUnexpected = 0x82;
  constexpr std::size_t kPayloadAt = 24 + 4, kKindAt = 4 + 20;
  const auto word = [&](std::size_t at) -> std::size_t { return octets[at] | octets[at + 1] << 8; };
  for (auto at = kPayloadAt; at + kKindAt < octets.size() && word(at) != 1;
       at += 4 + word(at + 2)) {
    if (word(at) != 0x75) continue;
    octets[at + kKindAt] = kUnexpected;
    say_tampered();
  }
}

// Puts another PID_TYPE_INFORMATION in the place of the host's.
void replace_type_information(Bytes& octets, const Bytes& value) {
  const auto word = [&](std::size_t at) -> std::size_t { return octets[at] | octets[at + 1] << 8; };
  for (std::size_t at = 28; at + 4 < octets.size() && word(at) != 1; at += 4 + word(at + 2)) {
    if (word(at) != 0x75) continue;
    const auto begin = octets.begin() + static_cast<std::ptrdiff_t>(at + 4);
    const auto end = begin + static_cast<std::ptrdiff_t>(word(at + 2));
    Bytes changed(octets.begin(), begin);
    changed.insert(changed.end(), value.begin(), value.end());
    changed.insert(changed.end(), end, octets.end());
    changed[at + 2] = static_cast<DDS_Security_octet>(value.size());
    changed[at + 3] = static_cast<DDS_Security_octet>(value.size() >> 8);
    set_length(changed);
    octets = std::move(changed);
    say_tampered();
    return;
  }
}

void announce_types(Bytes& octets, bool is_writer) {
  if (tampers("type")) spoil_type_information(octets);
  if (tampers("circle"))
    replace_type_information(octets, type_that_needs(is_writer ? 1 : 2, {is_writer ? 2u : 1u}));
  if (!tampers("many")) return;
  std::vector<std::size_t> needs(600);
  std::iota(needs.begin(), needs.end(), 2);
  replace_type_information(octets, type_that_needs(1, needs));
}

// Inserts the parameters before the sentinel with which a stock host ends its announcements.
void append_to_announcement(Bytes& octets, const Bytes& parameters) {
  octets.insert(octets.end() - 4, parameters.begin(), parameters.end());
  set_length(octets);
  say_tampered();
}

// Each expression almost matches, again and again, a name of many zeros.
Bytes costly_partitions() {
  constexpr std::string_view kExpression("*0*0*0*0*0*0*0*0*0*0*0*0*0*0*0*0*x", 35);
  constexpr std::size_t kMany = 300;
  Bytes value;
  append_word(value, kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    append_word(value, kExpression.size());
    value.insert(value.end(), kExpression.begin(), kExpression.end());
    value.push_back(0);  // pads to whole words
  }
  Bytes out;
  splice::append_parameter(out, 0x29, value);
  return out;
}

Bytes many_locators() {
  Bytes out;
  for (std::size_t i = 0; i < 300; ++i) {
    Bytes value;
    append_word(value, 1);  // the kind UDPv4
    append_word(value, 20'000 + i);
    value.resize(20);
    value.insert(value.end(), {127, 0, 0, 1});
    splice::append_parameter(out, 0x2f, value);
  }
  return out;
}

// Returns PID_DEFAULT_UNICAST_IPADDRESS and PID_DEFAULT_UNICAST_PORT of RTPS 1.
Bytes deprecated_address() {
  Bytes out;
  splice::append_parameter(out, 0x0c, {127, 0, 0, 1});
  splice::append_parameter(out, 0x0e, {0x20, 0x4e, 0, 0});
  return out;
}

void add_address_to_sample(Bytes& octets) {
  constexpr std::size_t kKindAt = 15, kInlineQosAt = 24;
  const bool is_sample = octets[0] == 0x15 && (octets[kKindAt] == 0x02 || octets[kKindAt] == 0x03);
  if (!is_sample) return;
  auto qos = deprecated_address();
  const bool has_qos = (octets[1] & kInlineQosFlag) != 0;
  if (!has_qos) qos.insert(qos.end(), {1, 0, 0, 0});
  octets.insert(octets.begin() + kInlineQosAt, qos.begin(), qos.end());
  octets[1] |= kInlineQosFlag;
  set_length(octets);
  say_tampered();
}

void announce_too_much(Bytes& octets) {
  if (tampers("partitions")) {
    hide_access_control(octets);
    append_to_announcement(octets, costly_partitions());
  }
  if (tampers("locators")) append_to_announcement(octets, many_locators());
  if (tampers("address")) append_to_announcement(octets, deprecated_address());
}

void speak_of_endpoints(Bytes& octets) {
  constexpr std::uint32_t kPublications = 0xff0003c2, kSubscriptions = 0xff0004c2;
  const bool is_publication = is_of_writer(octets, kPublications);
  if (is_publication || is_of_writer(octets, kSubscriptions)) {
    announce_types(octets, is_publication);
    announce_too_much(octets);
  }
  if (tampers("dispose") && is_of_writer(octets, kPublications)) {
    speak_as_victim(octets);
    dispose(octets);
  }
  if (!tampers("speak-as") || !is_of_writer(octets, kSubscriptions)) return;
  hide_access_control(octets);
  speak_as_victim(octets);
}

// True if the message has a sample of an application's writer.
bool is_of_application(const Bytes& message) {
  for (std::size_t at = 20; at + 16 <= message.size();) {
    const auto kind = message[at + 15];
    if (message[at] == 0x15 && (kind == 0x02 || kind == 0x03)) return true;
    const std::size_t length = message[at + 2] | message[at + 3] << 8;
    if (length == 0) return false;
    at += 4 + length;
  }
  return false;
}

// Returns a message to all readers, from its own plain writer of liveliness, which says that the
// victim is gone.
Bytes end_of_victim(const Bytes& prefix, DDS_Security_octet number) {
  Bytes out = {0x0e, 1, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};  // INFO_DST
  Bytes data = {0x15, 7, 0, 0, 0, 0, 16, 0, 0, 0, 0, 0, 0, 2, 0, 0xc2, 0, 0, 0, 0, number, 0, 0, 0};
  data.insert(data.end(), {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0});  // disposed and unregistered
  data.insert(data.end(), {0, 1, 0, 0});
  data.insert(data.end(), prefix.begin(), prefix.end());
  data.insert(data.end(), {0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0});
  set_length(data);
  out.insert(out.end(), data.begin(), data.end());
  const Bytes heartbeat = {7, 1, 28, 0, 0, 0, 0, 0, 0,      2, 0, 0xc2, 0,      0, 0, 0,
                           1, 0, 0,  0, 0, 0, 0, 0, number, 0, 0, 0,    number, 0, 0, 0};
  out.insert(out.end(), heartbeat.begin(), heartbeat.end());
  return out;
}

void append_end_of_victim(Bytes& message, const Bytes& prefix) {
  constexpr int kTimes = 40;
  static std::atomic<int> times = 0;
  const int number = ++times;
  if (number > kTimes) return;
  const auto end = end_of_victim(prefix, static_cast<DDS_Security_octet>(number));
  message.insert(message.end(), end.begin(), end.end());
  say_tampered();
}

// Sends this instead of an announcement, after an empty submessage.
void smuggle_end_of_victim(Bytes& octets) {
  if (!is_of_writer(octets, 0xff0003c2)) return;
  octets = {0x09, 1, 0, 0};  // INFO_TS
  append_end_of_victim(octets, victim.prefix());
}

}  // namespace

void tamper_with_submessage(Bytes& octets) {
  if (tampers("announce") || (tampers("decoy") && holds(octets, "Hidden")))
    hide_access_control(octets);
  if (tampers("participant")) name_victim(octets, "dds.sec.participant_crypto_tokens", 24 + 4);
  // Only for the application's writers, because it needs those of discovery itself.
  if (tampers("endpoint") && is_of_writer_tokens(octets))
    name_victim(octets, "dds.sec.datawriter_crypto_tokens", 24 + 84);
  if (tampers("key-only")) leave_key(octets, false);
  if (tampers("key-hash")) leave_key(octets, true);
  if (tampers("fragment")) leave_fragment(octets);
  if (tampers("repeat")) repeat_tokens(octets);
  if (tampers("invent")) invent_writer(octets);
  if (tampers("nobody")) send_nobodys_tokens(octets);
  if (tampers("address-qos")) add_address_to_sample(octets);
  if (tampers("smuggle")) smuggle_end_of_victim(octets);
  speak_of_endpoints(octets);
}

std::vector<Bytes> spliced(const Bytes& announcement) {
  constexpr DDS_Security_octet kFirstWriter = 2, kWriterWithKey = 2;
  const bool is_type = tampers("splice-type");
  Bytes inner;
  if (is_type) {
    auto octets = announcement;
    spoil_type_information(octets);
    inner.assign(octets.begin() + 28, octets.end());
  } else {
    splice::append_endpoint(inner, victim.prefix(), kFirstWriter, kWriterWithKey);
    splice::append_parameter(inner, 1, {});
  }
  const std::size_t number = announcement[20] | announcement[21] << 8;
  return splice::plan(number, Bytes(own_prefix, own_prefix + sizeof own_prefix), inner, !is_type);
}

void tamper_with_message(Bytes& octets, const Bytes& prefix) {
  if (tampers("clear")) append_end_of_victim(octets, prefix);
  if (tampers("source") && is_of_application(octets)) {
    Bytes source = {0x0c, 0x01, 20, 0, 0, 0, 0, 0, 2, 1, 1, 16};
    source.insert(source.end(), prefix.begin(), prefix.end());
    octets.insert(octets.begin() + 20, source.begin(), source.end());
    say_tampered();
  }
}

}  // namespace insider
