// Secured DDS participants with sockets, for tests of what their entities may do and send.
#pragma once

#include <unistd.h>

#include "base/plugin_services.hpp"
#include "rtps/dcps/domain_participant_factory.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {

struct Sensor {
  std::int32_t id = 0;
  std::int32_t value = 0;
};
template <>
struct TypeTraits<Sensor> {
  static constexpr std::string_view type_name = "Sensor";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("id", key(s.id)), named("value", s.value));
  }
};

namespace testing {

/// The plugins and services that a process has for a secured participant.
struct SecuredProcess {
  using Wrap = std::unique_ptr<spi::AccessControl> (*)(std::unique_ptr<spi::AccessControl>);
  /// `wrap` wraps its access control.
  explicit SecuredProcess(ManualClock& clock, Wrap wrap = nullptr)
      : services{clock, random, events},
        authentication(authentication::make_authentication(services)),
        access_control(access_control::make_access_control(services)),
        cryptography(cryptography::make_cryptography(services)) {
    if (wrap != nullptr) access_control = wrap(std::move(access_control));
  }
  /// `topics` are those that it may publish and subscribe to.
  DomainParticipantOptions options(const std::string& subject, const Rules& rules,
                                   std::string store = {},
                                   std::vector<std::string> topics = {"*"}) {
    return {.domain_id = kDomain,
            .domain_tag = std::to_string(::getpid()),
            .interfaces = {"127.0.0.1"},
            .multicast = false,
            .own_thread = false,
            .durability_store = std::move(store),
            .security = SecurityOptions{{*authentication, *access_control, *cryptography},
                                        properties_of(subject, rules, std::move(topics))}};
  }

  static inline const auto kDomain = static_cast<DomainId>(::getpid() % 200 + 30);
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services;
  std::unique_ptr<spi::Authentication> authentication;
  std::unique_ptr<spi::AccessControl> access_control;
  std::unique_ptr<spi::Cryptography> cryptography;
};

/// A secured participant with its entities, which the test polls.
struct Secured : SecuredProcess {
  Secured(const std::string& subject, const Rules& rules, ManualClock& clock,
          std::string store = {}, std::vector<std::string> topics = {"*"}, Wrap wrap = nullptr)
      : SecuredProcess(clock, wrap) {
    participant = DomainParticipant::create(
                      options(subject, rules, std::move(store), std::move(topics)), services)
                      .value();
    topic = participant->create_topic<Sensor>("Sensors").value();
  }
  DataWriter<Sensor>& writer(const Qos& qos) {
    return **participant->create_publisher().create_datawriter<Sensor>(*topic, qos);
  }
  DataReader<Sensor>& reader(const Qos& qos) {
    return **participant->create_subscriber().create_datareader<Sensor>(*topic, qos);
  }

  std::unique_ptr<DomainParticipant> participant;
  Topic* topic = nullptr;
};

}  // namespace testing
}  // namespace ddssec::rtps
