// The interop type for Fast DDS, and the setting that keeps its participants on loopback, for every
// Fast DDS peer.
#ifndef DDSSEC_INTEROP_FASTDDS_SHAPE_HPP
#define DDSSEC_INTEROP_FASTDDS_SHAPE_HPP

#include <string>
#include <vector>

#include "interop/peers/fastdds_api.hpp"

namespace interop_fast {

struct Shape {
  std::string color = "BLUE";
  int32_t x = 0;
  int32_t y = 0;
  int32_t shapesize = 30;
  std::vector<uint8_t> payload = {};
};

/// The type of shape.idl.
class ShapeType : public TypeOf<Shape> {
 public:
  explicit ShapeType(const char* name = "interop::Shape")
      : TypeOf(name, 4 + 4 + 64 + 3 * 4 + 4 + 1024, true) {}

 protected:
  void write(Cdr& cdr, const void* sample) const override {
    const auto& shape = *static_cast<const Shape*>(sample);
    cdr << shape.color << shape.x << shape.y << shape.shapesize << shape.payload;
  }
  void read(Cdr& cdr, void* sample) const override {
    auto& shape = *static_cast<Shape*>(sample);
    cdr >> shape.color >> shape.x >> shape.y >> shape.shapesize >> shape.payload;
  }
  std::uint32_t most_octets(const void* sample) const override {
    const auto& shape = *static_cast<const Shape*>(sample);
    const std::size_t text = 4 + 4 + shape.color.size() + 1 + 3;
    return static_cast<std::uint32_t>(text + 3 * 4 + 4 + shape.payload.size() + 4);
  }
  bool write_key(Cdr& cdr, const void* sample) const override {
    cdr << static_cast<const Shape*>(sample)->color;
    return true;
  }
};

inline void set_interface(fdds::DomainParticipantQos& qos, const char* address, const char* peer) {
  use_udp_alone(qos, address);
  use_unicast_alone(qos, address, peer);
}

inline void set_loopback(fdds::DomainParticipantQos& qos) {
  set_interface(qos, "127.0.0.1", "127.0.0.1");
}

}  // namespace interop_fast

#endif
