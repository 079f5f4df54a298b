// A durability service in a domain with access control: a participant that may not write a topic
// does not decide how it is kept.
#include <filesystem>

#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/secured_keeper.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST_F(SecuredKeeper, AWriterThatIsNotAllowed_SaysNothingOfHowATopicIsKept) {
  mallory->writer(durable(DurabilityKind::transient, OwnershipKind::exclusive));
  ASSERT_TRUE(heard_mallory()) << process.events.text();
  run(50);
  EXPECT_EQ(keeper->topics(), 0u);
  auto* publisher = &alice.participant->create_publisher();
  auto& writer =
      **publisher->create_datawriter<Sensor>(*alice.topic, durable(DurabilityKind::transient));
  ASSERT_TRUE(eventually([&] { return keeper->topics() == 1; })) << process.events.text();
  ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
  run(50);
  for (std::int32_t value = 1; value <= 3; ++value) ASSERT_TRUE(writer.write({value, value}));
  run(50);
  ASSERT_TRUE(publisher->delete_contained_entities());
  EXPECT_EQ(late_joiner(3), (std::vector<std::int32_t>{1, 2, 3})) << process.events.text();
}

// One writer of the keeper must not serve the samples of both, with the tags of the first one.
TEST_F(SecuredKeeper, DataTags_OfTwoWriters_KeepTheirSamplesApart) {
  using Tags = std::vector<governance::DataTag>;
  const auto allow = [&](DomainParticipantOptions options, const std::string& subject, Tags tags) {
    options.security->properties = properties_of(subject, rules, {"*"}, 24h, std::move(tags));
    return options;
  };
  mallory.reset();
  keeper.reset();
  const Tags both{{"level", "open"}, {"level", "secret"}};
  const auto in_keeper = process.options("CN=keeper,O=Example", rules);
  const auto store = std::filesystem::path(folder.path()) / "tagged";
  const auto start = [&](const Tags& tags) {
    return Keeper::create(allow(in_keeper, "CN=keeper,O=Example", tags), {.store = store},
                          process.services)
        .value();
  };
  keeper = start(both);
  alice.participant = DomainParticipant::create(allow(alice.options("CN=alice,O=Example", rules),
                                                      "CN=alice,O=Example", both),
                                                alice.services)
                          .value();
  alice.topic = alice.participant->create_topic<Sensor>("Sensors").value();
  const auto tagged = [&](const std::string& level) -> DataWriter<Sensor>& {
    auto qos = durable(DurabilityKind::transient);
    qos.data_tags = {{"level", level}};
    return alice.writer(qos);
  };
  auto& open = tagged("open");
  ASSERT_TRUE(eventually([&] { return keeper->topics() == 1; })) << process.events.text();
  auto& secret = tagged("secret");
  ASSERT_TRUE(eventually([&] { return keeper->topics() == 2; })) << process.events.text();
  run(50);
  ASSERT_TRUE(secret.write({1, 7}));  // stored first, although its topic came second
  run(50);
  ASSERT_TRUE(open.write({1, 3}));
  run(50);
  ASSERT_TRUE(keeper->flush(5s));
  ASSERT_TRUE(alice.participant->delete_contained_entities());
  alice.topic = alice.participant->create_topic<Sensor>("Sensors").value();
  run(50);
  keeper.reset();
  keeper = start(both);
  EXPECT_EQ(keeper->topics(), 2u);
  EXPECT_THAT(late_joiner(2), ::testing::UnorderedElementsAre(3, 7));
  ASSERT_TRUE(alice.participant->delete_contained_entities());
  alice.topic = alice.participant->create_topic<Sensor>("Sensors").value();
  keeper.reset();
  keeper = start({{"level", "open"}});
  EXPECT_EQ(late_joiner(1), (std::vector<std::int32_t>{3}));
  run(50);
  std::filesystem::remove(store);
}

// A keeper that is started without --security must not serve what it decrypted to all readers of
// the domain.
TEST_F(SecuredKeeper, AStore_KeptWithSecurity_IsRefusedWithout) {
  mallory.reset();
  keeper.reset();
  const auto store = std::filesystem::path(folder.path()) / "security";
  const auto secured = process.options("CN=keeper,O=Example", rules);
  auto open = secured;
  open.security.reset();
  const auto start = [&](const DomainParticipantOptions& options) {
    return Keeper::create(options, {.store = store}, process.services);
  };
  for (const bool is_secured : {true, false}) {
    ASSERT_TRUE(start(is_secured ? secured : open));
    const auto refused = start(is_secured ? open : secured);
    ASSERT_EQ(code_of(refused), Code::rtps_store_unusable);
    EXPECT_THAT(refused.error().to_sentence(),
                ::testing::AllOf(::testing::HasSubstr("samples that were kept with security"),
                                 ::testing::HasSubstr("samples that were kept without security")));
    ASSERT_TRUE(start(is_secured ? secured : open));
    std::filesystem::remove(store);
  }
}

// All stores say how they were kept, not only the keeper's own, and whatever other streams they
// have.
TEST_F(SecuredKeeper, AStore_OfASecuredParticipantOrOfUnknownOrigin_IsRefusedWithout) {
  mallory.reset();
  keeper.reset();
  const auto store = std::filesystem::path(folder.path()) / "origin";
  auto secured = process.options("CN=keeper,O=Example", rules);
  secured.durability_store = store;
  auto open = secured;
  open.security.reset();
  const auto participant = [&](const DomainParticipantOptions& options) {
    return code_of(DomainParticipant::create(options, process.services));
  };
  const auto keeps = [&](DomainParticipantOptions options) {
    options.durability_store.clear();
    return code_of(Keeper::create(std::move(options), {.store = store}, process.services));
  };
  const auto is_for_secured_only = [&] {
    EXPECT_EQ(participant(open), Code::rtps_store_unusable);
    EXPECT_EQ(keeps(open), Code::rtps_store_unusable);
    EXPECT_EQ(participant(secured), Code{});
    EXPECT_EQ(keeps(secured), Code{});
    std::filesystem::remove(store);
  };
  EXPECT_EQ(participant(secured), Code{});
  is_for_secured_only();
  {
    const auto unknown = DurableStore::open(store, process.events).value();
    const auto stream =
        unknown->open_stream({.topic = "Sensors", .type = "Sensor"}, {}, Moment{}).value();
    Change change;
    change.payload = Payload::copy_of(as_bytes(std::string_view("sample")));
    unknown->append(stream.id, change, {});
    ASSERT_TRUE(unknown->flush(5s));
  }
  is_for_secured_only();
}

// The keeper must start nevertheless, and serve the other topics.
TEST_F(SecuredKeeper, AStoredTopic_ThatIsNoLongerAllowed_IsNamedAndTheOthersAreServed) {
  mallory.reset();
  keeper.reset();
  const auto store = std::filesystem::path(folder.path()) / "allowed";
  const auto start = [&](std::vector<std::string> topics) {
    return Keeper::create(process.options("CN=keeper,O=Example", rules, "", std::move(topics)),
                          {.store = store}, process.services);
  };
  keeper = start({"*"}).value();
  auto* other = *alice.participant->create_topic<Sensor>("Other");
  for (auto* topic : {other, alice.topic}) store_one(*topic);
  keeper.reset();
  auto started = start({"Sensors"});
  ASSERT_TRUE(started) << started.error().to_sentence();
  keeper = *std::move(started);
  EXPECT_EQ(keeper->topics(), 1u);
  EXPECT_THAT(process.events.text(), ::testing::HasSubstr("topic Other is not kept now"));
  EXPECT_EQ(late_joiner(1), (std::vector<std::int32_t>{7}));
  keeper.reset();
  keeper = start({"*"}).value();
  EXPECT_EQ(keeper->topics(), 2u) << "it is still in the store";
  keeper.reset();
  std::filesystem::remove(store);
}

// The keeper must keep the topic without a new announcement of a writer.
TEST_F(SecuredKeeper, ATopic_ThatRenewedPermissionsAllow_IsKept) {
  mallory.reset();
  keeper.reset();
  auto options = process.options("CN=keeper,O=Example", rules, "", {"Other"});
  DocumentFiles files(options.security->properties);
  options.security->properties = files.in(std::move(options.security->properties));
  keeper = Keeper::create(std::move(options), {}, process.services).value();
  alice.writer(durable(DurabilityKind::transient));
  ASSERT_TRUE(eventually([&] {
    return process.events.text().find("topic Sensors is not kept now") != std::string::npos;
  }));
  files.put(properties_of("CN=keeper,O=Example", rules, {"*"}));
  EXPECT_TRUE(keeps_one_soon()) << process.events.text();
}

// The keeper must serve the topic without an announcement of a writer.
TEST_F(SecuredKeeper, AStoredTopic_ThatRenewedPermissionsAllowAgain_IsServed) {
  mallory.reset();
  keeper.reset();
  const auto store = std::filesystem::path(folder.path()) / "again";
  const auto start = [&](DomainParticipantOptions options) {
    return Keeper::create(std::move(options), {.store = store}, process.services).value();
  };
  keeper = start(process.options("CN=keeper,O=Example", rules));
  store_one(*alice.topic);
  keeper.reset();

  auto options = process.options("CN=keeper,O=Example", rules, "", {"Other"});
  DocumentFiles files(options.security->properties);
  options.security->properties = files.in(std::move(options.security->properties));
  keeper = start(std::move(options));
  EXPECT_EQ(keeper->topics(), 0u);
  files.put(properties_of("CN=keeper,O=Example", rules, {"*"}));
  EXPECT_TRUE(keeps_one_soon()) << process.events.text();
  EXPECT_EQ(late_joiner(1), (std::vector<std::int32_t>{7}));
  keeper.reset();
  std::filesystem::remove(store);
}

// Otherwise any participant could fill a keeper with announcements, and leave.
TEST_F(SecuredKeeper, TopicsOfWritersThatAreNotAllowed_TakeNoPlace) {
  auto* publisher = &mallory->participant->create_publisher();
  for (int i = 0; i < 40; ++i) {
    auto* topic = *mallory->participant->create_topic<Sensor>("Junk" + std::to_string(i));
    ASSERT_TRUE(publisher->create_datawriter<Sensor>(*topic, durable(DurabilityKind::transient)));
  }
  ASSERT_TRUE(heard_mallory());
  run(100);
  EXPECT_EQ(keeper->topics(), 0u);
  mallory.reset();
  run(50);
  EXPECT_EQ(keeper->topics(), 0u);
}

// One identity must not fill the store, or the keeper would keep no further sample of any topic.
// And samples beyond the share must not be acknowledged and then dropped.
TEST_F(SmallSecuredKeeper, BeyondAnIdentitysShare_Samples_AreNotAcknowledged) {
  write(*of_mallory, 0, 3000);
  ASSERT_TRUE(eventually([&] { return process.events.has(Code::rtps_store_failed); }));
  EXPECT_FALSE(stored_all_of(*of_mallory));
  EXPECT_GT(keeper->unstored(), 0u);
  EXPECT_EQ(keeper->left_out(), 0u);
  write(*of_alice, 1'000'000, 20);
  EXPECT_TRUE(stored_all_of(*of_alice)) << process.events.text();
  EXPECT_LT(keeper->served(), 3020u) << "what is not stored was held in memory";
  EXPECT_EQ(keeper->abandoned(), 0u);
  const auto waiting = keeper->unstored();
  mallory.reset();
  ASSERT_TRUE(eventually([&] { return keeper->abandoned() > 0; }));
  EXPECT_EQ(keeper->abandoned() + keeper->unstored(), waiting);
}

TEST_F(SmallSecuredKeeper, BeyondAnIdentitysShare_OnceThereIsRoom_AllIsStoredInOrder) {
  write(*of_alice, 1'000'000, 700);
  ASSERT_TRUE(stored_all_of(*of_alice));
  write(*of_mallory, 0, 700);
  for (std::int32_t value = 1; value <= 3; ++value) ASSERT_TRUE(of_mallory->write({699, value}));
  ASSERT_FALSE(stored_all_of(*of_mallory)) << "the test needs a smaller store";
  for (std::int32_t i = 0; i < 700; ++i) ASSERT_TRUE(of_alice->dispose({1'000'000 + i, 0}));
  EXPECT_TRUE(stored_all_of(*of_alice));
  EXPECT_TRUE(stored_all_of(*of_mallory)) << keeper->unstored();
  EXPECT_EQ(keeper->unstored(), 0u);
  mallory.reset();  // so that only the keeper has its samples
  run(50);
  auto got = late_joiner(1400 + 703);
  std::erase_if(got, [](std::int32_t value) { return value == 0 || value >= 1'000'000; });
  ASSERT_EQ(got.size(), 702u);
  EXPECT_EQ(std::vector(got.end() - 4, got.end()), (std::vector<std::int32_t>{699, 1, 2, 3}));
}

// An identity's own ends must not wait, because they make room.
TEST_F(SmallSecuredKeeper, BeyondAnIdentitysShare_ItsOwnEnds_MakeRoom) {
  auto& other = mallory->writer(qos);
  write(other, 0, 400);
  write(*of_mallory, 10'000, 1500);
  ASSERT_TRUE(stored_all_of(other));
  ASSERT_FALSE(stored_all_of(*of_mallory)) << "the test needs a smaller store";
  const auto waiting = keeper->unstored();
  for (std::int32_t i = 0; i < 400; ++i) ASSERT_TRUE(other.dispose({i, 0}));
  EXPECT_TRUE(stored_all_of(other));
  run(100);
  EXPECT_LE(keeper->unstored(), waiting - 300);
}

struct SmallKeepLastKeeper : SmallSecuredKeeper {
  SmallKeepLastKeeper() { qos.history.depth = qos.durability_service.history.depth = 1; }
};

// A sample that waited must not replace a later one, and must not bring the ended instance back.
TEST_F(SmallKeepLastKeeper, ASample_ThatWaited_ReplacesNoLaterOneOfAnother) {
  write(*of_alice, 1'000'000, 700);
  ASSERT_TRUE(stored_all_of(*of_alice));
  write(*of_mallory, 0, 700);
  ASSERT_TRUE(of_mallory->write({1'000'000, -5}));
  ASSERT_TRUE(of_mallory->write({1'000'001, -6}));
  ASSERT_TRUE(of_mallory->write({1'000'002, -7}));
  ASSERT_FALSE(stored_all_of(*of_mallory)) << "the test needs a smaller store";
  ASSERT_TRUE(of_alice->write({1'000'000, -9}));
  for (std::int32_t i = 1; i < 700; ++i) ASSERT_TRUE(of_alice->dispose({1'000'000 + i, 0}));
  EXPECT_TRUE(stored_all_of(*of_alice));
  EXPECT_TRUE(stored_all_of(*of_mallory)) << keeper->unstored();
  ASSERT_TRUE(mallory->participant->delete_contained_entities());
  mallory.reset();  // so that only the keeper has its samples
  ASSERT_TRUE(alice.participant->delete_contained_entities());
  alice.topic = alice.participant->create_topic<Sensor>("Sensors").value();
  run(50);
  EXPECT_EQ(keeper->served(), 701u);
  auto got = late_joiner(701);
  std::erase_if(got, [](std::int32_t value) { return value >= 0; });
  EXPECT_EQ(got, std::vector{-9});
}

// A sample that waits must not block its writer after the writer has replaced it.
TEST_F(SmallKeepLastKeeper, ASample_ThatItsWriterReplaced_IsNotWaitedFor) {
  write(*of_alice, 1'000'000, 700);
  ASSERT_TRUE(stored_all_of(*of_alice));
  write(*of_mallory, 0, 700);
  ASSERT_FALSE(stored_all_of(*of_mallory)) << "the test needs a smaller store";
  // For instance 0 the writer still holds a sample before those that wait.
  for (std::int32_t i = 1; i < 700; ++i) ASSERT_TRUE(of_mallory->dispose({i, 0}));
  EXPECT_TRUE(stored_all_of(*of_mallory)) << keeper->unstored();
  EXPECT_EQ(keeper->unstored(), 0u);
  EXPECT_EQ(keeper->served(), 701u);
}

}  // namespace
}  // namespace ddssec::rtps
