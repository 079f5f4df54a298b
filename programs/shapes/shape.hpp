// The type that every vendor's shapes program has.
#pragma once

#include "rtps/cdr/type.hpp"

namespace ddssec::shapes {

struct ShapeType {
  std::string color;
  std::int32_t x = 0, y = 0, shapesize = 0;
  std::vector<std::uint8_t> additional_payload_size;
};

/// Without the sequence and final, as older peers have it.
struct FinalShapeType {
  std::string color;
  std::int32_t x = 0, y = 0, shapesize = 0;
};

}  // namespace ddssec::shapes

template <>
struct ddssec::rtps::TypeTraits<ddssec::shapes::ShapeType> {
  static constexpr std::string_view type_name = "ShapeType";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("color", key(s.color, 128)), named("x", s.x), named("y", s.y),
          named("shapesize", s.shapesize),
          named("additional_payload_size", s.additional_payload_size));
  }
};

template <>
struct ddssec::rtps::TypeTraits<ddssec::shapes::FinalShapeType> {
  static constexpr std::string_view type_name = "ShapeType";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("color", key(s.color, 128)), named("x", s.x), named("y", s.y),
          named("shapesize", s.shapesize));
  }
};
