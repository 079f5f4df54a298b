// An adapter around a mock plugin, and the small values of the C ABI that tests pass in.
#pragma once

#include <cstdlib>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "base/plugin_services.hpp"
#include "plugins/cyclonedds/adapter_calls.hpp"
#include "plugins/cyclonedds/token_translation.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "tests/unit/cyclonedds/mocks.hpp"

namespace ddssec::cyclonedds {

/// A SecurityException that is freed at its end.
struct Refusal : Exception {
  Refusal() : Exception{} {}
  ~Refusal() { std::free(message); }
  Refusal(const Refusal&) = delete;
  Refusal& operator=(const Refusal&) = delete;
  /// Frees the message. Call this before a second use, which would leak the message.
  void clear() {
    std::free(message);
    static_cast<Exception&>(*this) = {};
  }
  std::string text() const { return message != nullptr ? message : ""; }
  Code reason() const { return static_cast<Code>(code); }
};

/// Keeps the events except plugins_in_use and openssl_known_unsafe, which the first participant of
/// a process raises, in whichever test that is.
class Recorder final : public EventSink {
 public:
  explicit Recorder(std::vector<Event>& events) : events_(events) {}
  void raise(const Event& event) override {
    const auto code = event.error.code();
    if (code != Code::plugins_in_use && code != Code::openssl_known_unsafe)
      events_.push_back(event);
  }

 private:
  std::vector<Event>& events_;
};

/// An adapter with a mock plugin, and the events that the adapter raised.
template <class Adapter, class Plugin, class Spi>
struct Harness {
  /// `more`: what the adapter's constructor takes besides.
  template <class... More>
  explicit Harness(More... more)
      : adapter(
            std::make_unique<Host>(std::make_unique<Recorder>(events)),
            [this](const PluginServices& given) {
              services.emplace(given);
              auto made = std::make_unique<testing::NiceMock<Plugin>>();
              plugin = made.get();
              return std::unique_ptr<Spi>(std::move(made));
            },
            domain(), more...) {}

  /// Returns any address that is not null.
  ddsi_domaingv* domain() { return reinterpret_cast<ddsi_domaingv*>(&events); }

  std::vector<Event> events;
  std::optional<PluginServices> services;
  testing::NiceMock<Plugin>* plugin = nullptr;
  Adapter adapter;
};

/// A sequence of octets with their memory, in the form in which the host passes it.
struct HostOctets {
  explicit HostOctets(Bytes from) : octets(std::move(from)) {
    const auto length = static_cast<DDS_Security_unsigned_long>(octets.size());
    sequence = {length, length, octets.empty() ? nullptr : octets.data()};
  }
  Bytes octets;
  DDS_Security_OctetSeq sequence{};
};

/// The result of a transform call.
struct HostBlock : DDS_Security_OctetSeq {
  HostBlock() : DDS_Security_OctetSeq{} {}
  ~HostBlock() { std::free(_buffer); }
  HostBlock(const HostBlock&) = delete;
  HostBlock& operator=(const HostBlock&) = delete;
  Bytes octets() const { return {_buffer, _buffer + _length}; }
};

inline spi::Token sample_token() {
  return {.class_id = "DDS:Auth:PKI-DH:1.0",
          .properties = {{"c.name", "value", true}, {"hidden", "", false}},
          .binary_properties = {{"c.octets", {0, 1, 2, 255}, true}, {"c.empty", {}, true}}};
}

}  // namespace ddssec::cyclonedds
