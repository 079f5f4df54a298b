// The factory and its participants.
#include "rtps/dcps/domain_participant_factory.hpp"

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using testing::code_of;

using Entities = testing::Polled;

TEST_P(Entities, TheFactory_KeepsParticipantsUntilTheyAreEmpty) {
  DomainParticipantFactory factory(services);
  auto* participant = *factory.create_participant(options());
  EXPECT_EQ(factory.lookup_participant(options().domain_id), participant);
  EXPECT_EQ(factory.lookup_participant(options().domain_id + 1), nullptr);
  EXPECT_EQ(code_of(factory.delete_participant(*a.participant)), Code::rtps_precondition_not_met);
  participant->create_publisher();
  EXPECT_EQ(code_of(factory.delete_participant(*participant)), Code::rtps_precondition_not_met);
  EXPECT_TRUE(participant->delete_contained_entities());
  EXPECT_TRUE(factory.delete_participant(*participant));
  factory.set_autoenable_created_entities(false);
  EXPECT_FALSE((*factory.create_participant(options()))->is_enabled());
  EXPECT_EQ(code_of(factory.create_participant({.domain_id = 999})), Code::invalid_property);
}

}  // namespace
}  // namespace ddssec::rtps
