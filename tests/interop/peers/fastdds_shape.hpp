// The interop type for Fast DDS, and how its participants keep to loopback; for every Fast DDS
// peer.
#ifndef DDSSEC_INTEROP_FASTDDS_SHAPE_HPP
#define DDSSEC_INTEROP_FASTDDS_SHAPE_HPP

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/utils/md5.h>
#include <memory>
#include <string>
#include <vector>

#include "interop/peers/fastdds_cdr.hpp"

namespace interop_fast {

namespace fdds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::Duration_t;

struct Shape {
  std::string color = "BLUE";
  int32_t x = 0;
  int32_t y = 0;
  int32_t shapesize = 30;
  std::vector<uint8_t> payload = {};
};

// shape.idl in XCDR1.
class ShapeType : public fdds::TopicDataType {
 public:
  ShapeType() {
    setName("interop::Shape");
    m_typeSize = 4 + 4 + 64 + 3 * 4 + 4 + 1024;  // a first guess; histories grow as needed
    m_isGetKeyDefined = true;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Shape& shape = *static_cast<Shape*>(data);
    return write_cdr(*payload, [&](Cdr& cdr) {
      cdr << shape.color << shape.x << shape.y << shape.shapesize << shape.payload;
    });
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    Shape& shape = *static_cast<Shape*>(data);
    return read_cdr(*payload, [&](Cdr& cdr) {
      cdr >> shape.color >> shape.x >> shape.y >> shape.shapesize >> shape.payload;
    });
  }

  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [shape = static_cast<Shape*>(data)] {
      const std::size_t text = 4 + 4 + shape->color.size() + 1 + 3;
      return static_cast<uint32_t>(text + 3 * 4 + 4 + shape->payload.size() + 4);
    };
  }

  // The key is an unbounded string, so the key hash is the MD5 of its big-endian form.
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool) override {
    const Shape& shape = *static_cast<Shape*>(data);
    std::vector<char> octets(4 + shape.color.size() + 1);
    FastBuffer buffer(octets.data(), octets.size());
    Cdr cdr(buffer, Cdr::BIG_ENDIANNESS);
    cdr << shape.color;
    MD5 md5;
    md5.init();
    md5.update(octets.data(), static_cast<unsigned>(cdr.getSerializedDataLength()));
    md5.finalize();
    for (unsigned i = 0; i < 16; ++i) handle->value[i] = md5.digest[i];
    return true;
  }

  void* createData() override { return new Shape; }
  void deleteData(void* data) override { delete static_cast<Shape*>(data); }
};

// UDP at one interface, unicast: a metatraffic locator with port 0 keeps Fast DDS off multicast.
inline void set_interface(fdds::DomainParticipantQos& qos, const char* address, const char* peer) {
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back(address);
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  rtps::Locator_t own, other;
  rtps::IPLocator::setIPv4(own, address);
  rtps::IPLocator::setIPv4(other, peer);
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(own);
  builtin.initialPeersList.push_back(other);
  auto& discovery = builtin.discovery_config;
  discovery.leaseDuration_announcementperiod = Duration_t(0, 500'000'000);
  discovery.initial_announcements.period = Duration_t(0, 100'000'000);
}

inline void set_loopback(fdds::DomainParticipantQos& qos) {
  set_interface(qos, "127.0.0.1", "127.0.0.1");
}

// Standard output is for the peer's own lines.
inline void log_to_stderr() {
  auto consumer = std::make_unique<fdds::StdoutErrConsumer>();
  consumer->stderr_threshold(fdds::Log::Kind::Info);
  fdds::Log::ClearConsumers();
  fdds::Log::RegisterConsumer(std::move(consumer));
  fdds::Log::SetVerbosity(fdds::Log::Kind::Warning);
}

}  // namespace interop_fast

#endif
