// The two types of ddssec-peer; peers of other makes have the same in IDL, final, in XCDR1.
#pragma once

#include "rtps/cdr/type.hpp"

namespace ddssec::peer {

struct ShapeType {
  std::string color;
  std::int32_t x = 0, y = 0, shapesize = 0;
};

struct Blob {
  std::uint32_t seq = 0;
  std::uint32_t pad = 0;
  std::uint64_t t_ns = 0;
  std::vector<std::uint8_t> data;
};

}  // namespace ddssec::peer

template <>
struct ddssec::rtps::TypeTraits<ddssec::peer::ShapeType> {
  static constexpr std::string_view type_name = "ShapeType";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("color", key(s.color, 128)), named("x", s.x), named("y", s.y),
          named("shapesize", s.shapesize));
  }
};

template <>
struct ddssec::rtps::TypeTraits<ddssec::peer::Blob> {
  static constexpr std::string_view type_name = "Blob";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.seq, s.pad, s.t_ns, s.data);
  }
};
