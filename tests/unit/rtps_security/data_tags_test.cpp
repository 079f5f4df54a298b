// The data tags of an endpoint count for the rights of its participant, on both sides (DDS-Security
// 1.2, clause 10.4.1.5.3.4).
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

Qos tagged(Qos qos, const std::string& level) {
  qos.data_tags = {{"level", level, false}};
  return qos;
}

// Alice may write and read what is tagged as open, and nothing else.
struct DataTags : ::testing::Test {
  const Rules rules{.discovery = ProtectionKind::encrypt};
  Node a{1, properties_of("CN=alice,O=Example", rules, {"*"}, 24h,
                          std::vector<governance::DataTag>{{"level", "open"}})};
  Node b{2, properties_of("CN=bob,O=Example", rules)};
  World world{.nodes = {&a, &b}};

  bool match() {
    return world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; }, 500);
  }
};

TEST_F(DataTags, TagsOfOurOwnEndpoints_MustBeAllowed) {
  for (const auto& level : {"open", "secret"}) {
    const bool allowed = level == std::string("open");
    const auto writer =
        a->create_writer(square(tagged(default_writer_qos(), level)), a.listener, world.now);
    const auto reader =
        a->create_reader(square(tagged(default_reader_qos(), level)), a.listener, world.now);
    EXPECT_EQ(code_of(writer), allowed ? Code{} : Code::publish_not_allowed);
    EXPECT_EQ(code_of(reader), allowed ? Code{} : Code::subscribe_not_allowed);
  }
}

TEST_F(DataTags, TagsOfARemoteWriter_MustBeAllowed) {
  const auto writer =
      a->create_writer(square(tagged(default_writer_qos(), "open")), a.listener, world.now);
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  ASSERT_TRUE(match()) << b.events.text();
  // Nothing on Alice's side keeps it from lying.
  ASSERT_TRUE(a->change_qos(*writer, tagged(default_writer_qos(), "secret"), world.now));
  EXPECT_TRUE(world.run_until([&] { return b.listener.matched == 0; }, 300));
  EXPECT_TRUE(b.events.has(Code::announced_writer_not_allowed)) << b.events.text();
}

// Access control comes before QoS: a reader must not be notified of a mismatch with a writer that
// may not use its topic at all.
TEST_F(DataTags, AWriterThatIsNotAllowed_ChangesNoStatusOfTheReader) {
  const auto writer =
      a->create_writer(square(tagged(default_writer_qos(), "open")), a.listener, world.now);
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  ASSERT_TRUE(match()) << b.events.text();
  auto unfit = tagged(default_writer_qos(), "secret");
  unfit.ownership = OwnershipKind::exclusive;
  ASSERT_TRUE(a->change_qos(*writer, unfit, world.now));
  ASSERT_TRUE(
      world.run_until([&] { return b.events.has(Code::announced_writer_not_allowed); }, 300));
  EXPECT_EQ(b.listener.incompatible, 0);
  EXPECT_FALSE(b.events.has(Code::rtps_qos_incompatible)) << b.events.text();
  // For a writer that is allowed, the mismatch is reported.
  unfit.data_tags = {{"level", "open", false}};
  ASSERT_TRUE(a->change_qos(*writer, unfit, world.now));
  EXPECT_TRUE(world.run_until([&] { return b.listener.incompatible == 1; }, 300));
  EXPECT_TRUE(b.events.has(Code::rtps_qos_incompatible)) << b.events.text();
}

TEST_F(DataTags, TagsOfARemoteReader_MustBeAllowed) {
  const auto reader =
      a->create_reader(square(tagged(default_reader_qos(), "open")), a.listener, world.now);
  ASSERT_TRUE(b->create_writer(square(default_writer_qos()), b.listener, world.now));
  ASSERT_TRUE(match()) << b.events.text();
  ASSERT_TRUE(a->change_qos(*reader, tagged(default_reader_qos(), "secret"), world.now));
  EXPECT_TRUE(world.run_until([&] { return b.listener.matched == 0; }, 300));
  EXPECT_TRUE(b.events.has(Code::announced_reader_not_allowed)) << b.events.text();
}

// Tags say something about the data of their endpoint.
TEST_F(DataTags, ProtectedDiscovery_HidesThem) {
  // Permissions also name the tags, and are sent in the clear.
  ASSERT_TRUE(world.run_until([&] { return a.knows(b) && b.knows(a); }));
  bool seen = false;
  world.filter = [&](const Node&, Bytes datagram) {
    seen = seen || as_text(datagram).find("level") != std::string_view::npos;
    return one(std::move(datagram));
  };
  ASSERT_TRUE(
      a->create_writer(square(tagged(default_writer_qos(), "open")), a.listener, world.now));
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  ASSERT_TRUE(match());
  world.run(50);
  EXPECT_FALSE(seen);
}

TEST(DataTagsInTheClear, ClearDiscovery_DoesNotAnnounceThem) {
  Pair pair({});
  bool seen = false;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    seen = seen || as_text(datagram).find("level") != std::string_view::npos;
    return one(std::move(datagram));
  };
  EXPECT_EQ(code_of(pair.a->create_writer(square(tagged(default_writer_qos(), "open")),
                                          pair.a.listener, pair.world.now)),
            Code::publish_not_allowed)
      << "rules without data tags are for endpoints without";
  ASSERT_TRUE(pair.match());
  const auto qos = tagged(default_writer_qos(), "open");
  ASSERT_TRUE(pair.a->change_qos(pair.writer, qos, pair.world.now));
  pair.world.run(50);
  EXPECT_FALSE(seen);
  EXPECT_EQ(pair.b.listener.matched, 1);
}

}  // namespace
}  // namespace ddssec::rtps
