// The listener of a reader that is called.
#include "rtps/dcps/data_reader_listeners.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/dcps_parts.hpp"

namespace ddssec::rtps::dcps_parts {
namespace {

using namespace testing;

TEST(DataReaderListenersTest, DataOnReaders_ComesInsteadOfDataAvailable) {
  struct OfSubscriber final : SubscriberListener {
  } of_subscriber;
  struct OfParticipant final : DomainParticipantListener {
  } of_participant;
  ListenerAndMask<SubscriberListener> subscriber;
  ListenerAndMask<DomainParticipantListener> participant;
  const DataReaderListeners listeners(subscriber, participant);
  EXPECT_FALSE(listeners.has(StatusKind::data_available));
  participant = {&of_participant, StatusKind::data_on_readers};
  EXPECT_TRUE(listeners.has(StatusKind::data_available));
  EXPECT_EQ(listeners.for_status(StatusKind::data_available), nullptr);
  EXPECT_EQ(listeners.for_data_on_readers(), &of_participant);
  subscriber = {&of_subscriber, kAnyStatus};
  EXPECT_EQ(listeners.for_data_on_readers(), &of_subscriber);
  EXPECT_EQ(listeners.for_status(StatusKind::data_available), &of_subscriber);
}

}  // namespace
}  // namespace ddssec::rtps::dcps_parts
