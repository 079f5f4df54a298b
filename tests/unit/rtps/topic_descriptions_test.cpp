// Topics of a participant, by name.
#include "rtps/dcps/topic_descriptions.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;

using Entities = testing::Polled;

TEST_P(Entities, Topics_HaveOneNameAndOneType) {
  EXPECT_EQ(code_of(a.participant->create_topic<Reading>("Readings")),
            Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(a.participant->create_topic<Reading>("")), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(a.participant->create_topic<Reading>(std::string(257, 'x'))),
            Code::rtps_bad_parameter);
  auto* other = *a.participant->create_topic("Other", {.name = "Other"});
  EXPECT_EQ(code_of(a.publisher->create_datawriter<Reading>(*other)), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(a.subscriber->create_datareader<Reading>(*other)), Code::rtps_bad_parameter);
}

}  // namespace
}  // namespace ddssec::rtps
