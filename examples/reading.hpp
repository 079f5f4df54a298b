// What the two examples talk about. The list of members says what a reading looks like on the wire.
#pragma once

#include <rtps/cdr/type.hpp>

struct Reading {
  std::string sensor;
  double celsius = 0;
};

template <>
struct ddssec::rtps::TypeTraits<Reading> {
  static constexpr std::string_view type_name = "Reading";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& self, Visit&& visit) {
    visit(key(self.sensor), self.celsius);
  }
};
