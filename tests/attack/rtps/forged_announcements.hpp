// Announcements of endpoints that an attacker sends in the name of an authenticated participant.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "rtps/discovery/serialized.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps::testing {

/// Two participants that have matched: a writes, b reads. An attacker forges what one of them
/// announces without protection.
struct ForgedAnnouncements {
  enum class Kind { writers_of_a, readers_of_b };

  ForgedAnnouncements(Kind kind, const Rules& rules) : pair(rules), kind_(kind) {
    EXPECT_TRUE(pair.match());
    pair.world.run(100);
    true_endpoint = kind == Kind::writers_of_a
                        ? *pair.b.participant->remote_participants().endpoint(pair.writer)
                        : *pair.a.participant->remote_participants().endpoint(pair.reader);
  }

  /// The announced endpoint with the entity id of one that does not exist.
  EndpointData forged_endpoint(std::uint32_t number) const {
    auto out = true_endpoint;
    out.guid.entity.octets = {0x40, static_cast<std::uint8_t>(number >> 8),
                              static_cast<std::uint8_t>(number), out.guid.entity.octets[3]};
    return out;
  }
  void announce(const EndpointData& endpoint) {
    Bytes buffer(4096);
    SpanWriter out(buffer);
    write_payload(out, endpoint);
    send(PayloadKind::data, out.view());
  }
  void dispose(const Guid& guid) {
    Bytes buffer(64);
    SpanWriter out(buffer);
    write_endpoint_key(out, guid);
    InlineQos qos;
    qos.status = {true, true};
    send(PayloadKind::key, out.view(), std::move(qos));
  }
  /// True if a's writer matches the reader.
  bool matches(const Guid& reader) const {
    const auto matched = pair.a.participant->local_endpoints().matched(pair.writer);
    return std::ranges::find(matched, reader) != matched.end();
  }

  Pair pair;
  EndpointData true_endpoint;  ///< the true writer of a, or the true reader of b
  std::int64_t next = 2;       ///< the number of the next one: each has announced one endpoint
  const Locator attacker = *Locator::parse("127.0.0.1", 7000);

 private:
  void send(PayloadKind kind, BytesView payload, InlineQos qos = {}) {
    const bool writers = kind_ == Kind::writers_of_a;
    auto& owner = writers ? pair.a : pair.b;
    auto& receiver = writers ? pair.b : pair.a;
    receiver->receive(
        forged(owner->prefix(), Data{writers ? kPublicationsReader : kSubscriptionsReader,
                                     writers ? kPublicationsWriter : kSubscriptionsWriter,
                                     {next++},
                                     std::move(qos),
                                     kind,
                                     payload}),
        pair.world.now, attacker);
  }

  Kind kind_;
};

}  // namespace ddssec::rtps::testing
