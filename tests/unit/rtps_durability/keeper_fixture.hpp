// A keeper beside two participants that write and read.
#pragma once

#include "rtps/keeper/keeper.hpp"
#include "tests/unit/rtps_durability/durable_fixture.hpp"

namespace ddssec::rtps::testing {

struct KeeperTest : DurableFixture {
  std::unique_ptr<Keeper> keeper(std::vector<std::string> topics = {"*"}) {
    auto made = Keeper::create(options(), {.store = folder / "kept", .topics = std::move(topics)},
                               services);
    EXPECT_TRUE(made) << made.error().to_sentence();
    return *std::move(made);
  }
  void both(Keeper& keeper, int rounds = 20) {
    for (int i = 0; i < rounds; ++i) keeper.poll(0ms), run(10ms);
  }
  bool keeps(Keeper& keeper, std::size_t topics) {
    for (int i = 0; i < 300 && keeper.topics() < topics; ++i) both(keeper, 1);
    both(keeper);
    return keeper.topics() == topics && keeper.flush(10s);
  }
  /// Returns the streams in the keeper's file, while no keeper has it open.
  std::size_t rows() const {
    auto file = Database::open(folder / "kept");
    EXPECT_TRUE(file);
    const auto count = file->number("SELECT count(*) FROM stream");
    return count ? static_cast<std::size_t>(*count) : 0;
  }
  /// Returns what a late reader of `end` gets, until nothing more arrives.
  std::vector<std::int64_t> late_joiner(Keeper& keeper, End& end, std::size_t count) {
    auto& reader = end.reader(late(DurabilityKind::transient));
    std::vector<std::int64_t> out;
    for (int i = 0, quiet = 0; i < 500 && quiet < 30; ++i) {
      both(keeper, 1);
      for (auto value : taken(reader)) out.push_back(value);
      quiet += out.size() >= count ? 1 : 0;
    }
    EXPECT_TRUE(end.subscriber->delete_datareader(reader));
    return out;
  }
};
using Values = std::vector<std::int64_t>;

}  // namespace ddssec::rtps::testing
