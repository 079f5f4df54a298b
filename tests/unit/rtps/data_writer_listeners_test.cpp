// The listener of a writer that is called.
#include "rtps/dcps/data_writer_listeners.hpp"

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

TEST(DataWriterListenersTest, NearestListenerForTheStatus_IsChosen) {
  struct OfPublisher final : PublisherListener {
  } of_publisher;
  struct OfParticipant final : DomainParticipantListener {
  } of_participant;
  struct Own final : DataWriterListener {
  } own;
  ListenerAndMask<PublisherListener> publisher;
  ListenerAndMask<DomainParticipantListener> participant;
  DataWriterListeners listeners(publisher, participant);
  const auto matched = StatusKind::publication_matched;
  EXPECT_EQ(listeners.for_status(matched), nullptr);
  participant = {&of_participant, kAnyStatus};
  EXPECT_EQ(listeners.for_status(matched), &of_participant);
  publisher = {&of_publisher, matched};
  EXPECT_EQ(listeners.for_status(matched), &of_publisher);
  EXPECT_EQ(listeners.for_status(StatusKind::liveliness_lost), &of_participant);
  listeners.set(&own, matched);
  EXPECT_EQ(listeners.for_status(matched), &own);
  listeners.set(nullptr, kAnyStatus);
  EXPECT_EQ(listeners.for_status(matched), &of_publisher);
}

}  // namespace
}  // namespace ddssec::rtps
