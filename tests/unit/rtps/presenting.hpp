// Writers and readers with a presentation.
#pragma once

#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::presenting {

using namespace std::chrono_literals;
using testing::reliable;

struct Presenting : testing::Polled {
  DataWriter<Reading>& writer_on(Topic& topic, Publisher& publisher) {
    return **publisher.create_datawriter<Reading>(topic, reliable());
  }
  DataReader<Reading>& reader_on(Topic& topic, Subscriber& subscriber) {
    return **subscriber.create_datareader<Reading>(topic, reliable());
  }
  Publisher& publisher(const Presentation& presentation) {
    return a.participant->create_publisher({.presentation = presentation});
  }
  Subscriber& subscriber(const Presentation& presentation) {
    return b.participant->create_subscriber({.presentation = presentation});
  }
};

}  // namespace ddssec::rtps::presenting
