#include "cli/frame/fields.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

// A type without fields() of its own. It has no place in an unnamed namespace, since files of tests
// are joined.
struct Range {
  int first, last;
};

template <>
struct FieldsOf<Range> {
  static constexpr std::string_view kDef = "range";
  static constexpr auto fields() {
    return std::tuple(field<&Range::first>(), field<&Range::last>());
  }
};

namespace {

struct Key {
  bool encrypted = false;
  std::string mode;
  std::optional<std::string> token = {};

  static constexpr auto fields() {
    return std::tuple(field("encrypted", &Key::encrypted),
                      field("mode", &Key::mode, {.pattern = "^[0-7]{4}$"}),
                      field("token", &Key::token, {.note = "its URI", .omits_empty = true}));
  }
};

struct Authority {
  static constexpr std::string_view kDef = "authority";
  std::string subject;
  WallTime until = {};

  static constexpr auto fields() {
    return std::tuple(field("subject", &Authority::subject, {.def = "subject"}),
                      field("until", &Authority::until));
  }
};

struct Folder {
  Authority authority;
  std::filesystem::path dir;
  std::string role;
  std::vector<Authority> others = {};
  std::optional<Key> key = {};
  int line = 0;
  std::string not_a_field = {};

  static constexpr auto fields() {
    return std::tuple_cat(
        fields_within(&Folder::authority),
        std::tuple(field("dir", &Folder::dir),
                   field("role", &Folder::role, {.words = "identity|not due"}),
                   field("others", &Folder::others, {.min = 1, .max = 2}),
                   field("key", &Folder::key, {"null: not here"}), field("line", &Folder::line)));
  }
  std::string text() const { return dir.string() + " of " + authority.subject + "\n"; }
};

struct Fleet {
  static constexpr std::string_view kWhen = "with --from";
  std::vector<std::string> names = {};

  static constexpr auto fields() { return std::tuple(field("names", &Fleet::names)); }
  std::string text() const { return std::to_string(names.size()) + " names\n"; }
};

struct Scope {
  std::vector<Range> ranges;
  double seconds = 0;

  static constexpr auto fields() {
    return std::tuple(computed<Scope>("count", [](const Scope& one) { return one.ranges.size(); }),
                      field("ranges", &Scope::ranges), field("seconds", &Scope::seconds));
  }
};

Json json(const char* text) { return Json::parse(text); }

TEST(Fields, ToJson_OrderOfTheFieldList) {
  const Folder folder{{"CN=CA"}, "ca", "identity", {{"CN=B"}}, Key{true, "0600"}, 3};
  EXPECT_EQ(to_json(folder).dump(),
            R"({"subject":"CN=CA","until":"1970-01-01T00:00:00Z","dir":"ca","role":"identity",)"
            R"("others":[{"subject":"CN=B","until":"1970-01-01T00:00:00Z"}],)"
            R"("key":{"encrypted":true,"mode":"0600"},"line":3})");
}

TEST(Fields, ToJson_EmptyOptionalIsNullOrAbsent) {
  EXPECT_EQ(to_json(Folder{})["key"], Json());
  EXPECT_FALSE(to_json(Key{}).contains("token"));
  EXPECT_EQ(to_json(Key{false, "0600", "pkcs11:"})["token"], "pkcs11:");
}

TEST(Fields, Schema_OfEachKindOfField) {
  EXPECT_EQ(object_schema<Folder>(), json(R"({
    "type": "object", "additionalProperties": false,
    "required": ["subject", "until", "dir", "role", "others", "key", "line"],
    "properties": {
      "subject": {"$ref": "#/$defs/subject"}, "until": {"$ref": "#/$defs/time"},
      "dir": {"$ref": "#/$defs/path"}, "role": {"enum": ["identity", "not due"]},
      "others": {"type": "array", "items": {"$ref": "#/$defs/authority"}, "minItems": 1, "maxItems": 2},
      "key": {"anyOf": [{"type": "null"}, {
        "type": "object", "additionalProperties": false, "required": ["encrypted", "mode"],
        "properties": {
          "encrypted": {"type": "boolean"},
          "mode": {"type": "string", "pattern": "^[0-7]{4}$"},
          "token": {"type": "string"}}}]},
      "line": {"type": "integer", "minimum": 0}}})"));
}

TEST(Fields, Definitions_OfStructsWithAName) {
  const auto shape = shape_of<Folder>();
  EXPECT_EQ(shape.definitions.size(), 1U);
  EXPECT_EQ(shape.definitions["authority"], object_schema<Authority>());
  EXPECT_EQ(schema_of<Authority>(), json(R"({"$ref": "#/$defs/authority"})"));
}

TEST(Fields, Members_WithNotesAndInnerMembers) {
  EXPECT_EQ(members_of<Folder>(),
            "`subject`, `until`, `dir`, `role`, `others` (each: `subject`, `until`), `key` (null: "
            "not here; `encrypted`, `mode`, `token` (its URI)), `line`");
}

TEST(Fields, MadeFieldsAndListedStructs_AsOthers) {
  const Scope scope{{{0, 4}, {7, 7}}, 1.5};
  EXPECT_EQ(to_json(scope).dump(),
            R"({"count":2,"ranges":[{"first":0,"last":4},{"first":7,"last":7}],"seconds":1.5})");
  const auto shape = shape_of<Scope>();
  EXPECT_EQ(shape.schema["properties"]["ranges"]["items"]["$ref"], "#/$defs/range");
  EXPECT_EQ(shape.definitions["range"], object_schema<Range>());
  EXPECT_EQ(shape.schema["properties"]["seconds"], json(R"({"type": "number"})"));
  EXPECT_EQ(shape.members, "`count`, `ranges` (each: `first`, `last`), `seconds`");
}

TEST(Fields, Variant_OneOfItsAlternatives) {
  using Either = std::variant<Authority, Fleet>;
  EXPECT_EQ(members_of<Either>(), "`subject`, `until`; with --from: `names`");
  EXPECT_EQ(schema_of<Either>()["oneOf"][0], schema_of<Authority>());
  EXPECT_EQ(schema_of<Either>()["oneOf"][1], object_schema<Fleet>());
  EXPECT_EQ(to_json(Either(Fleet{{"a"}})).dump(), R"({"names":["a"]})");
}

Result<Answer<Folder>> typed(const Arguments& arguments, const Context&) {
  if (arguments.has("--fail")) return fail(Code::usage, {});
  Answer<Folder> out{{{"CN=CA"}, "ca", "identity"}};
  out.report.text = "next\n";
  out.report.exit = Exit::no;
  out.has_result = !arguments.has("--nothing");
  return out;
}

class RunnerTest : public testing::Test {
 protected:
  Result<Report> run(const Runner& runner, Arguments::Values values = {}) {
    return runner(Arguments(std::move(values)), {clock_, random_});
  }
  ManualClock clock_{WallTime{}};
  SystemRandom random_;
};

TEST_F(RunnerTest, TypedCommand_TextAndJsonOfOneResult) {
  const auto report = run(typed);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->text, "ca of CN=CA\nnext\n");
  EXPECT_EQ(report->result["dir"], "ca");
  EXPECT_EQ(report->exit, Exit::no);
}

TEST_F(RunnerTest, TypedCommandWithoutResult_OnlySaysWhy) {
  const auto report = run(typed, {{"--nothing", {""}}});
  ASSERT_TRUE(report);
  EXPECT_EQ(report->text, "next\n");
  EXPECT_EQ(report->result, Json::object());
}

TEST_F(RunnerTest, TypedCommandThatFails_PassesTheErrorOn) {
  const auto report = run(typed, {{"--fail", {""}}});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code(), Code::usage);
}

TEST_F(RunnerTest, Shape_OfTheFieldList) {
  EXPECT_EQ(Runner(typed).shape().members, members_of<Folder>());
}

}  // namespace
}  // namespace ddssec::cli
