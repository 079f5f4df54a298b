// Filtered readers of coherent sets.
#include "rtps/dcps/reader_filter.hpp"

#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/presenting.hpp"

namespace ddssec::rtps::presenting {
namespace {

using namespace std::chrono_literals;
using test::succeeds;
using ::testing::ElementsAre;
using testing::reliable;
using testing::taken;

// If the writer filtered for the reader, its GAPs would be holes in the sets.
TEST_P(Presenting, AFilteredReader_GetsWhatPassesOfAWholeSetOrGroup) {
  auto* large = *b.participant->create_contentfilteredtopic("large", *b.topic, {"value >= 2", {}});
  for (const auto& access : {Presentation{PresentationScope::topic, true, false},
                             Presentation{PresentationScope::group, false, true}}) {
    auto& pub = publisher(access);
    auto& writer = writer_on(*a.topic, pub);
    auto& sub = subscriber(access);
    auto& reader = **sub.create_datareader<Reading>(*large, reliable());
    ASSERT_TRUE(match(writer, reader));
    ASSERT_TRUE(succeeds(pub.begin_coherent_changes()));
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(succeeds(writer.write({"a", i % 4})));
    ASSERT_TRUE(succeeds(pub.end_coherent_changes()));
    run(20ms);
    ASSERT_TRUE(succeeds(sub.begin_access()));
    EXPECT_THAT(taken(reader), ElementsAre(2, 3));
    ASSERT_TRUE(succeeds(sub.end_access()));
    ASSERT_TRUE(succeeds(pub.delete_contained_entities()));
    ASSERT_TRUE(succeeds(sub.delete_contained_entities()));
    run(50ms);
  }
}

}  // namespace
}  // namespace ddssec::rtps::presenting
