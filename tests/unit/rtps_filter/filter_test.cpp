#include "rtps/filter/filter.hpp"

#include "rtps/filter/lexer.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/rtps_filter/vehicle.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

class FilterTest : public ::testing::Test {
 protected:
  Result<Filter> compile(std::string expression, std::vector<std::string> parameters = {}) {
    return Filter::compile({std::move(expression), std::move(parameters)}, view.leaves());
  }
  bool passes(const std::string& expression, std::vector<std::string> parameters = {}) {
    const auto filter = compile(expression, std::move(parameters));
    if (!filter) ADD_FAILURE() << expression << ": " << filter.error().to_sentence();
    if (!filter) return false;
    for (const auto version : {XcdrVersion::xcdr1, XcdrVersion::xcdr2}) {
      Bytes payload;
      serialize(vehicle, payload, version);
      EXPECT_TRUE(view.decode(payload, filter->members()));
    }
    return filter->passes(view);
  }
  // Expects a refusal with this place, this expected value and this found value.
  void expect_refused(const std::string& expression, const std::string& field,
                      const std::string& expected, const std::string& found,
                      std::vector<std::string> parameters = {}) {
    const auto filter = compile(expression, std::move(parameters));
    ASSERT_FALSE(filter) << expression;
    EXPECT_EQ(filter.error().code(), Code::rtps_filter_invalid);
    const auto& details = filter.error().details();
    EXPECT_EQ(details.document, "filter expression");
    EXPECT_EQ(details.field, field) << expression;
    EXPECT_EQ(details.expected, expected) << expression;
    EXPECT_EQ(details.found, found) << expression;
  }

  SampleViewOf<Vehicle> view;
  Vehicle vehicle{.name = "BLUE",
                  .wheels = {1, 2, 3},
                  .moving = true,
                  .mark = 'q',
                  .tiny = -3,
                  .speed = 30,
                  .gear = Gear::reverse,
                  .place = {.north = 2.5, .east = 0.1f, .stamp = ~std::uint64_t{0}},
                  .odometer = -1,
                  .image = Bytes(100, 7)};
};

TEST_F(FilterTest, EveryKindOfMember_IsCompared) {
  for (const auto* expression : {"name = 'BLUE'",
                                 "name <> 'RED'",
                                 "name < 'BLUF'",
                                 "'A' < name",
                                 "speed = 30",
                                 "speed > 29",
                                 "speed >= 30",
                                 "speed <= 30",
                                 "30 = speed",
                                 "speed <> 31",
                                 "speed == 30",
                                 "speed != -30",
                                 "speed = 0x1e",
                                 "speed = +30",
                                 "speed = 30.0",
                                 "speed < 30.5",
                                 "speed < 3.1e1",
                                 "tiny = -3",
                                 "tiny < 0",
                                 "moving = TRUE",
                                 "moving = true",
                                 "moving <> FALSE",
                                 "moving = 1",
                                 "mark = 'q'",
                                 "mark > 'p'",
                                 "gear = 'REVERSE'",
                                 "gear <> 'DRIVE'",
                                 "gear = 7",
                                 "gear > 6",
                                 "place.north = 2.5",
                                 "place.north > 2",
                                 "place.east = 0.1",
                                 "place.east < 1",
                                 "odometer = -1",
                                 "odometer < place.stamp",
                                 "place.stamp = 18446744073709551615",
                                 "place.stamp > 9223372036854775807",
                                 "place.stamp > -1",
                                 "place.north < speed",
                                 "gear < speed",
                                 "name = name"}) {
    EXPECT_TRUE(passes(expression)) << expression;
    EXPECT_FALSE(passes("NOT (" + std::string(expression) + ")")) << expression;
  }
}

TEST_F(FilterTest, Operators_BindInTheOrderNotAndOr) {
  EXPECT_TRUE(passes("speed = 30 OR speed = 1 AND speed = 2"));
  EXPECT_FALSE(passes("(speed = 30 OR speed = 1) AND speed = 2"));
  EXPECT_TRUE(passes("NOT speed = 1 OR speed = 2"));
  EXPECT_FALSE(passes("NOT speed = 30 AND speed = 30"));
  EXPECT_TRUE(passes("NOT NOT speed = 30 and Not speed = 2 oR speed = 3"));
  EXPECT_TRUE(passes("speed = 1 OR speed = 2 OR speed = 30 OR speed = 4"));
  EXPECT_FALSE(passes("speed = 30 AND speed = 30 AND speed = 2 AND speed = 30"));
}

TEST_F(FilterTest, Between_IncludesBothEnds) {
  EXPECT_TRUE(passes("speed BETWEEN 30 AND 40"));
  EXPECT_TRUE(passes("speed between 20 and 30 AND speed = 30"));
  EXPECT_FALSE(passes("speed BETWEEN 31 AND 40"));
  EXPECT_FALSE(passes("speed BETWEEN 40 AND 20"));
  EXPECT_TRUE(passes("speed NOT BETWEEN 31 AND 40 AND speed = 30"));
  EXPECT_FALSE(passes("speed NOT BETWEEN 30 AND 30"));
  EXPECT_TRUE(passes("name BETWEEN 'A' AND %0", {"'C'"}));
}

TEST_F(FilterTest, Like_KnowsTwoWildcards) {
  EXPECT_TRUE(passes("name LIKE 'B%'"));
  EXPECT_TRUE(passes("name like '%U_'"));
  EXPECT_FALSE(passes("name LIKE 'B'"));
  EXPECT_FALSE(passes("name LIKE '_____'"));
  EXPECT_TRUE(passes("name LIKE %0", {"'%L%'"}));
  EXPECT_TRUE(matches_pattern("", ""));
  EXPECT_TRUE(matches_pattern("", "%%"));
  EXPECT_FALSE(matches_pattern("", "_"));
  EXPECT_TRUE(matches_pattern("aab", "%ab"));
  EXPECT_TRUE(matches_pattern("abcabd", "%ab_"));
  EXPECT_TRUE(matches_pattern("mississippi", "m%iss%ip%i"));
  EXPECT_FALSE(matches_pattern("mississippi", "m%iss%ipp%z"));
  // This must not take exponential time.
  EXPECT_FALSE(matches_pattern(std::string(5000, 'a'), "%a%a%a%a%a%a%a%a%a%a%a%a%a%a%a%b"));
}

// 240 tests of a text of 100 characters would take 0.7 ms of the writer's time for each sample.
TEST_F(FilterTest, PassesWithin_AnExpressionThatTakesMoreSteps_SaysNothing) {
  vehicle.name = std::string(100, 'a');
  std::string expression = "name LIKE '%ab'";
  while (expression.size() + 20 < Filter::kMaxExpression) expression += " OR name LIKE '%ab'";
  const auto expensive = compile(expression), cheap = compile("name LIKE 'a%' AND speed = 30");
  ASSERT_TRUE(expensive && cheap);
  Bytes payload;
  serialize(vehicle, payload, XcdrVersion::xcdr1);
  ASSERT_TRUE(view.decode(payload, expensive->members()));
  EXPECT_EQ(expensive->passes_within(2048, view), std::nullopt);
  EXPECT_EQ(expensive->passes_within(1'000'000, view), false);
  ASSERT_TRUE(view.decode(payload, cheap->members()));
  EXPECT_EQ(cheap->passes_within(2048, view), true);
}

TEST_F(FilterTest, MatchesPattern_CountsEachCharacterItLooksAt) {
  const std::string text(1000, 'a');
  std::size_t steps = 5000;
  EXPECT_TRUE(matches_pattern(text, "a%", steps));
  EXPECT_LT(steps, 5000u);
  EXPECT_FALSE(matches_pattern(text, "%" + std::string(200, 'a') + "b%", steps));
  EXPECT_EQ(steps, 0u);
  EXPECT_FALSE(matches_pattern("a", "a", steps));
}

TEST_F(FilterTest, Parameters_AreLiterals) {
  EXPECT_TRUE(passes("name = %0 AND speed > %1", {"'BLUE'", "29"}));
  EXPECT_TRUE(passes("speed BETWEEN %1 AND %0", {"40", "20"}));
  EXPECT_TRUE(passes("moving = %0 AND place.north >= %1", {"TRUE", " 2.5 "}));
  EXPECT_TRUE(passes("%99 = gear", [] {
    std::vector<std::string> all(100, "0");
    all[99] = "'REVERSE'";
    return all;
  }()));
}

TEST_F(FilterTest, NotANumber_ComparesAsIeee754Says) {
  vehicle.place.north = std::nan("");
  EXPECT_FALSE(passes("place.north = place.north"));
  EXPECT_TRUE(passes("place.north <> 0"));
  EXPECT_FALSE(passes("place.north BETWEEN -1e300 AND 1e300"));
  EXPECT_TRUE(passes("place.north NOT BETWEEN -1e300 AND 1e300"));
}

// Members after the last one that is compared are not read.
TEST_F(FilterTest, UnneededMembers_AreNotLookedAt) {
  EXPECT_EQ(compile("name = 'x'")->members(), 1u);
  EXPECT_EQ(compile("gear = 0 OR name = 'x'")->members(), 7u);
  EXPECT_EQ(compile("place.stamp = 0")->members(), 8u);
  const auto filter = compile("speed = 30");
  Bytes payload;
  serialize(vehicle, payload, XcdrVersion::xcdr1);
  std::size_t least = payload.size();
  for (auto size = payload.size(); size-- > 0;)
    if (view.decode(BytesView(payload).first(size), filter->members())) least = size;
  EXPECT_LT(least, payload.size() - 100);
}

// XTypes 7.6.3.4: a sample of an older writer has fewer members, and comes after one that had all
// of them.
TEST_F(FilterTest, MembersThatAreAbsent_HaveTheirDefaults) {
  EXPECT_TRUE(passes("odometer = -1"));
  Bytes payload;
  serialize(vehicle, payload, XcdrVersion::xcdr1);
  const auto filter = compile("odometer = 0");
  bool any = false;
  for (auto size = payload.size(); size-- > 8;) {
    auto shorter = BytesView(payload).first(size);
    if (view.decode(shorter, filter->members()) && filter->passes(view)) any = true;
  }
  EXPECT_TRUE(any);
}

TEST_F(FilterTest, EachError_NamesItsPlaceAndBothValues) {
  expect_refused("", "character 1", "a field, a value, NOT or (", "the end");
  expect_refused("  ", "character 3", "a field, a value, NOT or (", "the end");
  expect_refused("speed", "character 6", "=, <>, <, <=, >, >=, LIKE or BETWEEN", "the end");
  expect_refused("speed >", "character 8", "a field, a value or a parameter", "the end");
  expect_refused("speed = 30 speed", "character 12", "AND, OR or the end", "speed");
  expect_refused("speed = 30 ORDER BY speed", "character 12", "AND, OR or the end", "ORDER");
  expect_refused("(speed = 30", "character 12", "AND, OR or )", "the end");
  expect_refused("speed = 30)", "character 11", "AND, OR or the end", ")");
  expect_refused("speeds = 30", "character 1", "a member of the type that can be compared",
                 "speeds");
  expect_refused("speed = 'x'", "character 9", "an integer for speed", "x");
  expect_refused("name = 5", "character 8", "a text for name", "5");
  expect_refused("moving = 'TRUE'", "character 10", "TRUE or FALSE for moving", "TRUE");
  expect_refused("speed = TRUE", "character 9", "an integer for speed", "TRUE");
  expect_refused("gear = 'FIFTH'", "character 8", "a label of gear", "FIFTH");
  expect_refused("gear = 1.5", "character 8", "a label for gear", "1.5");
  expect_refused("mark = 'qq'", "character 8", "a character for mark", "qq");
  expect_refused("mark = 5", "character 8", "a character for mark", "5");
  expect_refused("place.north = 'x'", "character 15", "a number for place.north", "x");
  expect_refused("name = speed", "character 8", "a text, as name is", "speed");
  expect_refused("5 = 5", "character 1", "a field on one side", "5");
  expect_refused("5 BETWEEN 1 AND 2", "character 1", "a field before BETWEEN", "5");
  expect_refused("speed NOT 5", "character 11", "BETWEEN", "5");
  expect_refused("speed BETWEEN 1 OR 2", "character 17", "AND", "OR");
  expect_refused("speed BETWEEN tiny AND 2", "character 15", "a value or a parameter", "tiny");
  expect_refused("speed LIKE '3%'", "character 1", "texts on both sides of LIKE", "speed");
  expect_refused("name LIKE name", "character 11", "a pattern in quotes", "name");
  expect_refused("speed # 3", "character 7", "a field, a value, a parameter or an operator", "# 3");
  expect_refused("name = 'x", "character 8",
                 "a text that ends with a single quote on the same line", "'x");
  expect_refused("name = 'x\n'", "character 8",
                 "a text that ends with a single quote on the same line", "'x?'");
  expect_refused("place. = 1", "character 7", "the name of a member behind the point", " = 1");
  expect_refused("speed = 5x", "character 9", "a number", "5x");
  expect_refused("speed = 0x", "character 9", "a number", "0x");
  expect_refused("speed = 1e", "character 9", "a number", "1e");
  expect_refused("speed = -", "character 9", "a number", "-");
  expect_refused("speed = .", "character 9", "a number", ".");
  expect_refused("speed = 99999999999999999999", "character 9", "an integer of 64 bits",
                 "99999999999999999999");
  expect_refused("speed = -9223372036854775809", "character 9", "an integer of 64 bits",
                 "-9223372036854775809");
  expect_refused("speed = 1e999", "character 9", "a number that a double can hold", "1e999");
  expect_refused("AND speed = 1", "character 1", "a field, a value, NOT or (", "AND");
}

TEST_F(FilterTest, CollectionsAndMembersWithoutAName_CannotBeCompared) {
  for (const auto* field : {"wheels", "image", "secret", "place"})
    expect_refused(std::string(field) + " = 1", "character 1",
                   "a member of the type that can be compared", field);
}

TEST_F(FilterTest, MissingParametersAndNonLiterals_AreRefused) {
  expect_refused("speed = %0", "character 9", "one of 0 parameters", "%0");
  expect_refused("speed = %2", "character 9", "one of 2 parameters", "%2", {"1", "2"});
  expect_refused("speed = %100", "character 9", "a parameter, %0 to %99", "%100");
  expect_refused("speed = %", "character 9", "a parameter, %0 to %99", "%");
  for (const auto* parameter : {"BLUE", "", "1 2", "%1", "=", "'x", "speed"})
    expect_refused("name = %0", "character 8", "a literal (5, 2.5, 'text', TRUE) as parameter %0",
                   *parameter == 0 ? "nothing" : parameter, {parameter, "'y'"});
  expect_refused("speed = %0", "character 9", "an integer for speed", "fast", {"'fast'"});
}

TEST_F(FilterTest, LengthDepthAndParameters_AreBounded) {
  expect_refused(std::string(5000, ' '), "length", "at most 4096", "5000");
  expect_refused("speed = 1", "number of parameters", "at most 100", "101",
                 std::vector<std::string>(101, "1"));
  expect_refused("speed = 1", "length of a parameter", "at most 256", "257",
                 {std::string(257, '1')});
  const std::string deep = std::string(31, '(') + "speed = 30" + std::string(31, ')');
  EXPECT_TRUE(passes(deep));
  expect_refused("(" + deep + ")", "character 33", "at most 32 levels of nesting", "speed");
  expect_refused(std::string(4000, '('), "character 33", "at most 32 levels of nesting", "(");
  std::string nots;
  for (int i = 0; i < 40; ++i) nots += "NOT ";
  expect_refused(nots + "speed = 1", "character 129", "at most 32 levels of nesting", "NOT");
  std::string wide = "speed = 1";
  while (wide.size() < 4000) wide += " OR speed=1";
  EXPECT_FALSE(passes(wide));
  expect_refused("name LIKE '" + std::string(257, '%') + "'", "character 11",
                 "a pattern of at most 256", std::string(40, '%') + "...");
}

// The text of a remote reader goes into logs.
TEST_F(FilterTest, TextThatATerminalWouldObey_IsNotShown) {
  const auto filter = compile("speed = \x1b[2J\x07");
  ASSERT_FALSE(filter);
  EXPECT_EQ(filter.error().details().found, "?[2J?");
}

TEST_F(FilterTest, EveryPrefix_IsParsedOrRefused) {
  const std::string whole =
      "NOT (name LIKE 'B%' AND speed BETWEEN %0 AND 0x20) OR place.east >= -1.5e3 AND gear <> "
      "'PARK'";
  for (std::size_t size = 0; size <= whole.size(); ++size)
    static_cast<void>(compile(whole.substr(0, size), {"1"}));
  EXPECT_TRUE(compile(whole, {"1"}));
}

}  // namespace
}  // namespace ddssec::rtps
