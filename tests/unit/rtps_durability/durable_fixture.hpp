// Two participants and a folder for stores.
#pragma once

#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps::testing {

struct DurableFixture : Polled {
  DurableFixture() {
    std::filesystem::create_directory(folder);
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all);  // whatever the umask
  }
  ~DurableFixture() override { std::filesystem::remove_all(folder); }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("ddssec-writer-" + std::to_string(::getpid()));

  DomainParticipantOptions with_store() const {
    auto out = options();
    out.durability_store = folder / "samples";
    return out;
  }
  static Qos durable(DurabilityKind kind, std::int32_t depth = 10) {
    auto qos = default_writer_qos();
    qos.durability = kind;
    qos.history.depth = depth;
    qos.durability_service.history.depth = depth;
    return qos;
  }
  static Qos late(DurabilityKind kind) {
    auto qos = reliable();
    qos.durability = kind;
    return qos;
  }
  /// Returns all samples that a reader of b gets from the participant of `writer`, which is served
  /// as well.
  std::vector<std::int64_t> all_of(End& end, DataReader<Reading>& reader, std::size_t count) {
    std::vector<std::int64_t> out;
    for (int i = 0; i < 300 && out.size() < count; ++i) {
      end.participant->poll(0ms);
      run(10ms);
      for (auto value : taken(reader)) out.push_back(value);
    }
    for (int i = 0; i < 10; ++i) end.participant->poll(0ms), run(10ms);
    for (auto value : taken(reader)) out.push_back(value);
    return out;
  }
};

}  // namespace ddssec::rtps::testing
