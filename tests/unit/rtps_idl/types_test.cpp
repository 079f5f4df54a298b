// Types that agree and types that do not, judged by the descriptions of the generator.
#include <thread>

#include <gtest/gtest.h>

#include "rich.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "tests/unit/rtps_idl/cyclone_serializer.h"
#include "track_newer.hpp"
#include "track_one.hpp"
#include "track_other.hpp"

namespace ddssec::rtps {
namespace {

template <class T>
TypeDescription description() {
  return type_support<T>().description;
}

template <class Writer, class Reader>
TypeVerdict verdict() {
  return judge_types(description<Writer>(), description<Reader>()).verdict;
}

TEST(Types, TheSameFile_IsTheSameType) {
  EXPECT_EQ((verdict<one::Track, one::Track>()), TypeVerdict::same);
  EXPECT_EQ((verdict<one::Where, newer::Where>()), TypeVerdict::same);
  EXPECT_NE(minimal_hash(description<one::Track>().information),
            minimal_hash(description<newer::Track>().information));
}

TEST(Types, AnAppendableType_MayGrowAndBoundsOfStringsDoNotCount) {
  EXPECT_EQ((verdict<one::Track, newer::Track>()), TypeVerdict::assignable);
  EXPECT_EQ((verdict<newer::Track, one::Track>()), TypeVerdict::assignable);
}

TEST(Types, AFinalType_MayNotGrow) {
  EXPECT_EQ((verdict<one::Solid, newer::Solid>()), TypeVerdict::different);
  EXPECT_EQ((verdict<newer::Solid, one::Solid>()), TypeVerdict::different);
}

TEST(Types, OtherMembersAnotherOrderOrAnotherInnerType_IsAnotherType) {
  EXPECT_EQ((verdict<one::Solid, other::Solid>()), TypeVerdict::different);
  EXPECT_EQ((verdict<one::Track, other::Track>()), TypeVerdict::different);
  EXPECT_EQ((verdict<one::Where, other::Where>()), TypeVerdict::different);
}

// Returns the part of the reader's policy that refuses the types, or "".
template <class Writer, class Reader>
std::string refused(const TypeConsistency& policy) {
  const auto judged = judge_types(description<Writer>(), description<Reader>(), policy);
  return judged.fits() ? "" : judged.refused_by.empty() ? "type" : std::string(judged.refused_by);
}

TEST(Types, TypesWithoutCoercion_MustBeTheSame) {
  const TypeConsistency same{.kind = TypeConsistencyKind::disallow_type_coercion};
  EXPECT_EQ((refused<one::Track, one::Track>(same)), "");
  EXPECT_EQ((refused<one::Track, newer::Track>(same)), "kind = DISALLOW_TYPE_COERCION");
  auto without_objects = description<newer::Track>();
  without_objects.objects.clear();
  EXPECT_EQ(judge_types(without_objects, description<one::Track>(), same).verdict,
            TypeVerdict::different);
}

TEST(Types, AWiderType_IsPreventedOneWayOnly) {
  const TypeConsistency narrow{.prevent_type_widening = true};
  EXPECT_EQ((refused<newer::Track, one::Track>(narrow)), "prevent_type_widening = true");
  EXPECT_EQ((refused<one::Track, newer::Track>(narrow)), "");
}

TEST(Types, Bounds_CountWhereTheReaderSaysSo) {
  EXPECT_EQ((refused<newer::Bounds, one::Bounds>({})), "");
  EXPECT_EQ((refused<other::Bounds, one::Bounds>({})), "");
  const TypeConsistency sequences{.ignore_sequence_bounds = false};
  EXPECT_EQ((refused<newer::Bounds, one::Bounds>(sequences)), "ignore_sequence_bounds = false");
  EXPECT_EQ((refused<one::Bounds, newer::Bounds>(sequences)), "");
  EXPECT_EQ((refused<other::Bounds, one::Bounds>(sequences)), "");
  const TypeConsistency strings{.ignore_string_bounds = false};
  EXPECT_EQ((refused<other::Bounds, one::Bounds>(strings)), "ignore_string_bounds = false");
  EXPECT_EQ((refused<newer::Track, one::Track>(strings)), "ignore_string_bounds = false");
  EXPECT_EQ((refused<one::Track, newer::Track>(strings)), "");
  EXPECT_EQ((refused<newer::Bounds, one::Bounds>(strings)), "");
}

TEST(Types, NamesOfMembers_CountUnlessTheReaderSaysOtherwise) {
  const TypeConsistency any_name{.ignore_member_names = true};
  EXPECT_EQ((refused<one::Named, newer::Named>({})), "type");
  EXPECT_EQ((refused<one::Named, newer::Named>(any_name)), "");
  EXPECT_EQ((refused<one::Named, other::Named>(any_name)), "type");
}

TEST(Types, WhatCannotBeJudged_IsRefusedWhereValidationIsForced) {
  const TypeConsistency forced{.force_type_validation = true};
  auto known = description<one::Track>(), silent = description<newer::Track>();
  EXPECT_TRUE(judge_types(known, silent, forced).fits());
  EXPECT_TRUE(judge_types(known, known, forced).fits());
  silent.objects.clear();
  EXPECT_EQ(judge_types(known, silent, forced).refused_by, "force_type_validation = true");
  EXPECT_EQ(judge_types({}, known, forced).refused_by, "force_type_validation = true");
  EXPECT_TRUE(judge_types({}, known).fits());
}

TEST(Types, TypesWithoutInformationOrObjects_AreJudgedByTheirNames) {
  auto known = description<one::Solid>(), silent = description<other::Solid>();
  silent.objects.clear();
  EXPECT_EQ(judge_types(known, silent).verdict, TypeVerdict::unknown);
  EXPECT_EQ(judge_types(known, {}).verdict, TypeVerdict::unknown);
  EXPECT_EQ(judge_types({}, {}).verdict, TypeVerdict::unknown);
}

// If a description is cut off anywhere, or any octet changes, there is no crash, and never "the
// same" with another hash.
TEST(Types, HostileDescriptions_AreJudgedWithoutHarm) {
  const auto good = description<one::Track>();
  for (std::size_t size = 0; size < good.information.size(); ++size) {
    auto cut = good;
    cut.information.resize(size);
    const auto hash = minimal_hash(cut.information);
    EXPECT_TRUE(!hash || hash == minimal_hash(good.information));
  }
  for (std::size_t size = 0; size < good.objects.size(); ++size) {
    auto cut = description<newer::Track>();
    cut.objects.resize(std::min(size, cut.objects.size()));
    EXPECT_NE(judge_types(good, cut).verdict, TypeVerdict::same);
  }
  for (std::size_t at = 0; at < good.objects.size(); ++at)
    for (const std::uint8_t flip : {0x01, 0x80, 0xff}) {
      auto bad = description<newer::Track>();
      if (at < bad.objects.size()) bad.objects[at] ^= flip;
      static_cast<void>(judge_types(good, bad));
      auto lie = good;
      lie.information[at % lie.information.size()] ^= flip;
      static_cast<void>(judge_types(lie, good));
    }
}

TEST(Types, EachType_IsDescribedForAPerson) {
  const auto text = describe_type("Track", description<one::Track>());
  EXPECT_TRUE(text.starts_with("Track (minimal type ")) << text;
  EXPECT_EQ(describe_type("Track", {}), "Track");
}

class Events final : public EventSink {
 public:
  void raise(const Event& event) override {
    const std::lock_guard held(mutex_);
    if (event.error.code() == Code::rtps_type_mismatch) last_ = event.to_line();
  }
  std::string last() {
    const std::lock_guard held(mutex_);
    return last_;
  }

 private:
  std::mutex mutex_;
  std::string last_;
};

class TypesOnTheWire : public testing::Test {
 protected:
  std::unique_ptr<DomainParticipant> participant(DomainId domain) {
    return *DomainParticipant::create(
        {.domain_id = domain, .interfaces = {"127.0.0.1"}, .multicast = false},
        {clock_, random_, events_});
  }
  static bool soon(const auto& ready) {
    for (int i = 0; i < 500 && !ready(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return ready();
  }
  template <class T>
  static DataWriter<T>& writer(DomainParticipant& participant, const char* topic) {
    return **participant.create_publisher().create_datawriter<T>(
        **participant.create_topic<T>(topic));
  }
  template <class T>
  static DataReader<T>& reader(DomainParticipant& participant, const char* topic) {
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    return **participant.create_subscriber().create_datareader<T>(
        **participant.create_topic<T>(topic), qos);
  }

  SystemClock clock_;
  SystemRandom random_;
  Events events_;
};

TEST_F(TypesOnTheWire, EndpointsThatDisagree_DoNotMatchAndBothTypesAreNamed) {
  const auto a = participant(187), b = participant(187);
  auto& fixed = writer<one::Solid>(*a, "Solid");
  auto& disagrees = reader<other::Solid>(*b, "Solid");
  auto& track = writer<one::Track>(*a, "Track");
  auto& agrees = reader<newer::Track>(*b, "Track");
  EXPECT_TRUE(soon([&] { return !agrees.matched_publications().empty(); }));
  EXPECT_TRUE(soon([&] { return fixed.topic().inconsistent_topic_status().total_count > 0; }));
  EXPECT_TRUE(soon([&] { return disagrees.topic().inconsistent_topic_status().total_count > 0; }));
  EXPECT_TRUE(fixed.matched_subscriptions().empty());
  EXPECT_TRUE(disagrees.matched_publications().empty());
  EXPECT_NE(events_.last().find("Solid (minimal type "), std::string::npos) << events_.last();
  ASSERT_TRUE(soon([&] { return !track.matched_subscriptions().empty(); }));
  ASSERT_TRUE(track.write({7, "seven", {1, 2}, {}}));
  ASSERT_TRUE(agrees.wait_for_unread(std::chrono::seconds(5)));
  EXPECT_EQ(agrees.take_next_sample()->data, (newer::Track{7, "seven", {1, 2}, {}, 0}));
}

TEST_F(TypesOnTheWire, ThePolicyThatRefuses_IsNamedWithBothTypes) {
  const auto a = participant(187), b = participant(187);
  auto& writes = writer<newer::Track>(*a, "Narrow");
  auto qos = default_reader_qos();
  qos.type_consistency.prevent_type_widening = true;
  auto& reads = **b->create_subscriber().create_datareader<one::Track>(
      **b->create_topic<one::Track>("Narrow"), qos);
  EXPECT_EQ(reads.set_qos(default_reader_qos()).error().code(), Code::rtps_immutable_policy);
  EXPECT_TRUE(soon([&] { return reads.requested_incompatible_qos_status().total_count > 0; }));
  EXPECT_TRUE(soon([&] { return writes.offered_incompatible_qos_status().total_count > 0; }));
  const auto why = reads.requested_incompatible_qos_status().last;
  EXPECT_EQ(why.id, QosPolicyId::type_consistency_enforcement);
  EXPECT_EQ(why.policy, "TYPE_CONSISTENCY_ENFORCEMENT");
  EXPECT_TRUE(why.offered.starts_with("Track (minimal type ")) << why.offered;
  EXPECT_TRUE(why.requested.starts_with("prevent_type_widening = true for Track (minimal type "))
      << why.requested;
  EXPECT_GT(writes.topic().inconsistent_topic_status().total_count, 0);
  EXPECT_TRUE(reads.matched_publications().empty());
}

TEST_F(TypesOnTheWire, CycloneDds_AnnouncesTheSameOctetsAndMatches) {
  ASSERT_NE(cyclone_type("rich::MixedKey", false), nullptr);
  const auto ours = participant(188);
  auto& reads = reader<test_idl::rich::MixedKey>(*ours, "MixedKey0");
  ASSERT_TRUE(soon([&] { return !reads.matched_publications().empty(); }));
  const auto theirs = reads.matched_publication_data(reads.matched_publications()[0]);
  ASSERT_TRUE(theirs);
  EXPECT_EQ(theirs->type.information, description<test_idl::rich::MixedKey>().information);
}

}  // namespace
}  // namespace ddssec::rtps
