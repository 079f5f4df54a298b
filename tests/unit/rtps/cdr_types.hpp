// Types that are written and read: final, appendable and nested ones, with every kind of member.
#pragma once

#include "rtps/cdr/type.hpp"

namespace ddssec::rtps {

enum class Colour : std::int32_t { red, green };

struct Shape {
  std::string color;
  std::int32_t x = 0, y = 0, shapesize = 0;
  bool operator==(const Shape&) const = default;
};
template <>
struct TypeTraits<Shape> {
  static constexpr std::string_view type_name = "ShapeType";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.color, 128), s.x, s.y, s.shapesize);
  }
};

struct Inner {
  std::uint8_t octet = 0;
  std::uint64_t wide = 0;
  bool operator==(const Inner&) const = default;
};
template <>
struct TypeTraits<Inner> {
  static constexpr std::string_view type_name = "Inner";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.octet, s.wide);
  }
};

struct Everything {
  bool flag = false;
  std::int16_t small = 0;
  double real = 0;
  float single = 0;
  Colour colour = Colour::red;
  std::array<std::uint16_t, 3> fixed{};
  std::vector<std::uint8_t> octets;
  std::vector<std::int64_t> wide;
  std::vector<std::string> texts;
  std::vector<Inner> inners;
  Inner last;
  bool operator==(const Everything&) const = default;
};
template <>
struct TypeTraits<Everything> {
  static constexpr std::string_view type_name = "Everything";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.flag, s.small, s.real, s.single, s.colour, s.fixed, bounded(s.octets, 100), s.wide,
          s.texts, s.inners, s.last);
  }
};

// The first version of Everything.
struct Less {
  bool flag = false;
  std::int16_t small = 0;
  bool operator==(const Less&) const = default;
};
template <>
struct TypeTraits<Less> {
  static constexpr std::string_view type_name = "Everything";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.flag, s.small);
  }
};

struct Point {
  std::int32_t id = 0;
  std::int64_t line = 0;
};
template <>
struct TypeTraits<Point> {
  static constexpr std::string_view type_name = "Point";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.id), s.line);
  }
};

struct Tree {
  std::vector<Tree> children;
};
template <>
struct TypeTraits<Tree> {
  static constexpr std::string_view type_name = "Tree";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.children);
  }
};

}  // namespace ddssec::rtps
