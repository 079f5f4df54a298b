// A type with a member of every kind that a filter can compare, and some that it cannot.
#pragma once

#include "rtps/cdr/cdr_writer.hpp"
#include "rtps/filter/filter.hpp"

namespace ddssec::rtps {

enum class Gear : std::int32_t { park, drive, reverse = 7 };
template <>
struct EnumTraits<Gear> {
  static constexpr EnumLabel labels[] = {{"PARK", 0}, {"DRIVE", 1}, {"REVERSE", 7}};
};

struct Place {
  double north = 0;
  float east = 0;
  std::uint64_t stamp = 0;
};
template <>
struct TypeTraits<Place> {
  static constexpr std::string_view type_name = "Place";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("north", s.north), named("east", s.east), named("stamp", s.stamp));
  }
};

struct Vehicle {
  std::string name;
  std::vector<std::uint16_t> wheels = {};
  bool moving = false;
  char mark = 'a';
  std::int8_t tiny = 0;
  std::int32_t speed = 0;
  Gear gear = Gear::park;
  Place place = {};
  std::uint32_t secret = 0;  // has no name in the type
  std::int64_t odometer = 0;
  std::vector<std::uint8_t> image = {};
};
template <>
struct TypeTraits<Vehicle> {
  static constexpr std::string_view type_name = "Vehicle";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("name", key(s.name)), named("wheels", s.wheels), named("moving", s.moving),
          named("mark", s.mark), named("tiny", s.tiny), named("speed", s.speed),
          named("gear", s.gear), named("place", s.place), s.secret, named("odometer", s.odometer),
          named("image", s.image));
  }
};

}  // namespace ddssec::rtps
