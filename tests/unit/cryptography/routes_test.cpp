#include "plugins/cryptography/routes.hpp"

#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypted = ProtectionKind::encrypt;
constexpr auto kOriginAuthenticated = ProtectionKind::encrypt_with_origin_authentication;

EndpointSecurityAttributes submessages_by(ProtectionKind kind) {
  return endpoint_attributes(kind, ProtectionKind::none);
}

Bytes message_of(TwoSides& two, const WriterToReader& ends) {
  return encode_submessage(two, ends, data_submessage(40)).value();
}

// Returns the endpoint of `b` that the message is for.
Result<spi::SecureSubmessage> routed(TwoSides& two, const Bytes& message) {
  return two.b.transform().preprocess_secure_submessage(two.b.participant, two.b.remote, message);
}

// Endpoints come and leave in any order, in runs of every length.
TEST(Routes, EachPresentEndpoint_IsFoundAndNoOther) {
  TwoSides two;
  std::mt19937 random(1);
  struct One {
    WriterToReader ends;
    Bytes message;
    bool is_there = true;
  };
  std::vector<One> all;
  const auto check = [&] {
    for (const auto& [ends, message, is_there] : all) {
      const auto to = routed(two, message);
      ASSERT_EQ(code_of(to), is_there ? Code{} : Code::unknown_key_id);
      ASSERT_TRUE(!to || to->datawriter == ends.remote_writer);
    }
  };
  for (int round = 0; round < 40; ++round) {
    for (unsigned i = random() % 30; i > 0; --i) {
      const auto ends = two.endpoints(submessages_by(kEncrypted));
      all.push_back({ends, message_of(two, ends)});
    }
    const auto share = random() % 3;
    for (auto& [ends, message, is_there] : all) {
      if (!is_there || random() % 3 >= share) continue;
      ASSERT_TRUE(two.b.factory().unregister_datawriter(ends.remote_writer));
      is_there = false;
    }
    check();
  }
}

// The key id stays the same in a key revision. The readers get the new key one after the other, or
// some of them do not get it.
TEST(Routes, RevisedKey_LeadsToAReaderThatHasIt) {
  for (const std::size_t first : {0U, 1U, 2U}) {
    TwoSides two(participant_attributes(ProtectionKind::none, true));
    std::vector all = {two.endpoints(submessages_by(kEncrypted))};
    const auto add_reader = [&] {
      auto next = all.front();
      next.reader =
          two.b.factory()
              .register_local_datareader(two.b.participant, {}, submessages_by(kEncrypted))
              .value();
      two.match_endpoints(next);
      all.push_back(next);
    };
    auto late = all.front();
    late.reader = two.b.factory()
                      .register_local_datareader(two.b.participant, {}, submessages_by(kEncrypted))
                      .value();
    late.remote_writer =
        two.b.factory()
            .register_matched_remote_datawriter(late.reader, two.b.remote, shared_secret())
            .value();
    add_reader();
    add_reader();
    const auto before = two.writer_tokens(all.front()).value();
    const auto revision = two.a.factory().revise_local_entity_keys(two.a.participant).value();
    const auto tell = [&](const WriterToReader& ends, KeyStage stage) {
      ASSERT_TRUE(two.take_writer(ends, two.writer_tokens(ends, stage).value()));
    };
    tell(all[first], KeyStage::revised);
    EXPECT_EQ(routed(two, message_of(two, all[first]))->datareader, all[first].reader)
        << "it opens messages under the former key, too";
    ASSERT_TRUE(two.a.factory().activate_key_revision(two.a.participant, revision));
    const auto message = message_of(two, all[first]);
    EXPECT_EQ(routed(two, message)->datareader, all[first].reader);
    EXPECT_TRUE(decode_submessage(two, all[first], message));
    // A reader that gets its first tokens from before the revision takes no route away.
    ASSERT_TRUE(two.take_writer(late, before));
    EXPECT_EQ(routed(two, message)->datareader, all[first].reader);
    // The others get the new key when the first one has left.
    ASSERT_TRUE(two.b.factory().unregister_datawriter(all[first].remote_writer));
    const auto& last = all[first == 2 ? 1 : 2];
    tell(last, KeyStage::in_use);
    EXPECT_EQ(routed(two, message)->datareader, last.reader);
  }
}

// One remote writer is matched with many readers here, and has one key for each of them.
TEST(Routes, OneKeyOfManyReaders_LeadsToTheReaderWithAMac) {
  TwoSides two;
  std::vector all = {two.endpoints(submessages_by(kOriginAuthenticated))};
  for (int i = 0; i < 200; ++i) {
    auto next = all.front();
    next.reader =
        two.b.factory()
            .register_local_datareader(two.b.participant, {}, submessages_by(kOriginAuthenticated))
            .value();
    two.match_endpoints(next);
    all.push_back(next);
  }
  for (const auto& one : all) EXPECT_EQ(routed(two, message_of(two, one))->datareader, one.reader);
  for (std::size_t i = 0; i < all.size(); i += 2)
    ASSERT_TRUE(two.b.factory().unregister_datawriter(all[i].remote_writer));
  for (std::size_t i = 1; i < all.size(); i += 2)
    EXPECT_EQ(routed(two, message_of(two, all[i]))->datareader, all[i].reader);
  const auto of_another = routed(two, message_of(two, all[0]));
  ASSERT_TRUE(of_another);
  EXPECT_FALSE(into_bytes(200, [&](MutableBytes out) {
    return two.b.transform().decode_datawriter_submessage(
        of_another->datareader, of_another->datawriter, message_of(two, all[0]), out);
  })) << "it has no MAC for those that are left";
}

TEST(Routes, EndpointThatStays_IsFoundWhileOthersComeAndGo) {
  TwoSides two;
  const auto steady = two.endpoints(submessages_by(kEncrypted));
  const auto message = message_of(two, steady);
  std::atomic<bool> done = false;
  std::thread changes([&] {
    for (int round = 0; round < 10; ++round) {
      std::vector<WriterToReader> others;
      for (int i = 0; i < 100; ++i) others.push_back(two.endpoints(submessages_by(kEncrypted)));
      for (const auto& one : others)
        two.b.factory().unregister_datawriter(one.remote_writer).value();
    }
    done = true;
  });
  std::size_t lost = 0;
  while (!done) {
    const auto to = routed(two, message);
    if (!to || to->datawriter != steady.remote_writer) ++lost;
  }
  changes.join();
  EXPECT_EQ(lost, 0u);
}

// A host takes other keys for an endpoint. The former key then belongs to no endpoint.
TEST(Routes, EndpointWithANewKey_IsFoundByItOnly) {
  TwoSides two;
  const auto first = two.endpoints(submessages_by(kEncrypted)),
             second = two.endpoints(submessages_by(kEncrypted));
  const auto of_first = message_of(two, first), of_second = message_of(two, second);
  ASSERT_TRUE(two.take_writer(first, two.writer_tokens(second).value()));
  EXPECT_EQ(code_of(routed(two, of_first)), Code::unknown_key_id);
  ASSERT_TRUE(two.b.factory().unregister_datawriter(second.remote_writer));
  EXPECT_EQ(routed(two, of_second)->datawriter, first.remote_writer);
  ASSERT_TRUE(two.take_writer(first, two.writer_tokens(first).value()));
  EXPECT_EQ(routed(two, of_first)->datawriter, first.remote_writer);
  EXPECT_EQ(code_of(routed(two, of_second)), Code::unknown_key_id);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
