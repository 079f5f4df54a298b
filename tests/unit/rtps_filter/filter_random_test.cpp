// Random expressions, evaluated by the compiled program and by a simple walk through the tree.
#include <functional>
#include <random>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/rtps_filter/vehicle.hpp"

namespace ddssec::rtps {
namespace {

using Truth = std::function<bool(const Vehicle&)>;
struct Expression {
  std::string text;
  Truth holds;
};

// LIKE by its definition.
bool like(std::string_view text, std::string_view pattern) {
  if (pattern.empty()) return text.empty();
  if (pattern.front() == '%')
    return like(text, pattern.substr(1)) || (!text.empty() && like(text.substr(1), pattern));
  return !text.empty() && (pattern.front() == '_' || pattern.front() == text.front()) &&
         like(text.substr(1), pattern.substr(1));
}

template <class T>
std::function<bool(const T&, const T&)> relation(int which) {
  static const std::function<bool(const T&, const T&)> all[] = {
      std::equal_to<T>{},   std::not_equal_to<T>{}, std::less<T>{},
      std::less_equal<T>{}, std::greater<T>{},      std::greater_equal<T>{}};
  return all[which];
}
constexpr const char* kRelations[] = {" = ", " <> ", " < ", " <= ", " > ", " >= "};

class Maker {
 public:
  explicit Maker(unsigned seed) : random_(seed) {}

  std::vector<std::string> parameters;

  Expression expression(int depth) {
    const int kind = depth == 0 ? 0 : pick(5);
    if (kind <= 1) return predicate();
    if (kind == 2) {
      auto inner = expression(depth - 1);
      return {"NOT (" + inner.text + ")", [=](const Vehicle& v) { return !inner.holds(v); }};
    }
    auto a = expression(depth - 1), b = expression(depth - 1);
    const std::string left = "(" + a.text + ")", right = "(" + b.text + ")";
    if (kind == 3)
      return {left + " AND " + right, [=](const Vehicle& v) { return a.holds(v) && b.holds(v); }};
    return {left + " or " + right, [=](const Vehicle& v) { return a.holds(v) || b.holds(v); }};
  }

  Vehicle vehicle() {
    return {.name = word(),
            .wheels = std::vector<std::uint16_t>(static_cast<std::size_t>(pick(4)), 1),
            .moving = pick(2) == 1,
            .mark = static_cast<char>('a' + pick(3)),
            .tiny = static_cast<std::int8_t>(pick(5) - 2),
            .speed = pick(5) - 2,
            .gear = pick(2) == 1 ? Gear::drive : Gear::reverse,
            .place = {.north = (pick(9) - 4) / 2.0, .east = 0.5f, .stamp = 3},
            .odometer = pick(5) - 2};
  }

 private:
  int pick(int below) { return static_cast<int>(random_() % static_cast<unsigned>(below)); }
  std::string word() {
    std::string out;
    for (int i = pick(4); i > 0; --i) out += static_cast<char>('a' + pick(2));
    return out;
  }
  // Returns the literal itself, or a parameter with this value.
  std::string shown(std::string literal) {
    if (pick(3) != 0 || parameters.size() == Filter::kMaxParameters) return literal;
    parameters.push_back(std::move(literal));
    return "%" + std::to_string(parameters.size() - 1);
  }

  Expression predicate() {
    const int which = pick(6);
    const auto* sign = kRelations[which];
    switch (pick(8)) {
      case 0: {
        const int number = pick(5) - 2;
        const auto compare = relation<std::int64_t>(which);
        return {"speed" + std::string(sign) + shown(std::to_string(number)),
                [=](const Vehicle& v) { return compare(v.speed, number); }};
      }
      case 1: {
        const auto text = word();
        const auto compare = relation<std::string>(which);
        return {shown("'" + text + "'") + sign + "name",
                [=](const Vehicle& v) { return compare(text, v.name); }};
      }
      case 2: {
        const double number = (pick(9) - 4) / 2.0;
        const auto compare = relation<double>(which);
        return {"place.north" + std::string(sign) + shown(std::to_string(number)),
                [=](const Vehicle& v) { return compare(v.place.north, number); }};
      }
      case 3: {
        std::string pattern;
        for (int i = pick(5); i > 0; --i) pattern += "ab%_"[pick(4)];
        return {"name LIKE " + shown("'" + pattern + "'"),
                [=](const Vehicle& v) { return like(v.name, pattern); }};
      }
      case 4: {
        const int low = pick(5) - 2, high = pick(5) - 2;
        const bool inside = pick(2) == 1;
        return {
            std::string("odometer ") + (inside ? "" : "not ") + "between " +
                shown(std::to_string(low)) + " and " + shown(std::to_string(high)),
            [=](const Vehicle& v) { return (v.odometer >= low && v.odometer <= high) == inside; }};
      }
      case 5: {
        const auto compare = relation<int>(which);
        return {"gear" + std::string(sign) + shown("'DRIVE'"),
                [=](const Vehicle& v) { return compare(static_cast<int>(v.gear), 1); }};
      }
      case 6: {
        const auto compare = relation<std::int64_t>(which);
        return {"tiny" + std::string(sign) + "odometer",
                [=](const Vehicle& v) { return compare(v.tiny, v.odometer); }};
      }
      default: {
        const auto compare = relation<double>(which);
        return {"place.north" + std::string(sign) + "speed",
                [=](const Vehicle& v) { return compare(v.place.north, v.speed); }};
      }
    }
  }

  std::mt19937 random_;
};

TEST(FilterRandomTest, RandomFilters_AgreeWithANaiveEvaluator) {
  SampleViewOf<Vehicle> view;
  Bytes payload;
  std::size_t passed = 0, all = 0;
  for (unsigned seed = 0; seed < 4000; ++seed) {
    Maker maker(seed);
    const auto expression = maker.expression(static_cast<int>(seed % 5));
    if (expression.text.size() > Filter::kMaxExpression) continue;
    const auto filter = Filter::compile({expression.text, maker.parameters}, view.leaves());
    ASSERT_TRUE(filter) << expression.text << ": " << filter.error().to_sentence();
    for (int i = 0; i < 10; ++i) {
      const auto vehicle = maker.vehicle();
      serialize(vehicle, payload, i % 2 == 0 ? XcdrVersion::xcdr1 : XcdrVersion::xcdr2,
                i % 3 == 0 ? Endian::big : Endian::little);
      ASSERT_TRUE(view.decode(payload, filter->members()));
      const bool expected = expression.holds(vehicle);
      ASSERT_EQ(filter->passes(view), expected) << "seed " << seed << ": " << expression.text;
      ++all;
      passed += expected ? 1 : 0;
    }
  }
  EXPECT_GT(passed, all / 4);
  EXPECT_LT(passed, all * 3 / 4);
}

}  // namespace
}  // namespace ddssec::rtps
