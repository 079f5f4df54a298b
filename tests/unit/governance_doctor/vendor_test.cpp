#include "governance/doctor/vendor.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <gtest/gtest.h>

#include "governance/doctor/installed.hpp"
#include "governance/doctor/lenient_text.hpp"
#include "governance/doctor/measured.hpp"

namespace ddssec::governance::doctor {
namespace {

TEST(Vendor, IsFoundByItsIdWithOrWithoutVersion) {
  for (const auto vendor : kVendors) EXPECT_EQ(vendor_from(id(vendor)), vendor);
  EXPECT_EQ(vendor_from("ddssec"), Vendor::ours);
  EXPECT_EQ(product_from("cyclonedds"), NamedProduct{Vendor::cyclonedds});
  EXPECT_EQ(product_from("fastdds@3.1"), (NamedProduct{Vendor::fastdds, Version{3, 1, 0}}));
  EXPECT_EQ(id(Vendor::fastdds, {.fastdds = {3, 1, 2}}), "fastdds@3.1.2");
  for (const auto* other : {"", "cyclone", "fastdds@", "OURS", "ours@1.0.0", "fastdds@-1",
                            "fastdds@1..2", "fastdds@1.2.3.4", "fastdds@1.2x", "fastdds@99999"})
    EXPECT_EQ(product_from(other), std::nullopt) << other;
}

TEST(Measured, TheNearestOlderVersionStandsForOneThatWasNotMeasured) {
  const auto cyclone = [](Version version) {
    return stand_in(Vendor::cyclonedds, version).version;
  };
  EXPECT_EQ(cyclone({0, 10, 2}), (Version{0, 10, 2}));
  EXPECT_EQ(cyclone({0, 10, 4}), (Version{0, 10, 2}));
  EXPECT_EQ(cyclone({0, 11, 0}), (Version{0, 10, 5}));
  EXPECT_EQ(cyclone({12, 0, 0}), (Version{11, 0, 0}));
  EXPECT_EQ(cyclone({0, 9, 0}), (Version{0, 10, 2}));  // the oldest
  EXPECT_EQ(stand_in(Vendor::cyclonedds, {11, 0, 1}).source, Source::reported);
  EXPECT_EQ(stand_in(Vendor::fastdds, {4, 0, 0}), (KnownVersion{{3, 1, 2}, Source::measured}));
}

TEST(Measured, VersionsOfAVendorRise) {
  EXPECT_TRUE(known_versions(Vendor::ours).empty());
  for (const auto vendor : {Vendor::cyclonedds, Vendor::fastdds}) {
    const auto known = known_versions(vendor);
    ASSERT_FALSE(known.empty());
    EXPECT_TRUE(std::ranges::is_sorted(known, {}, &KnownVersion::version));
    EXPECT_EQ(known.front().version, Lineup().of(vendor));
  }
}

TEST(Measured, AnOutcomeIsThatOfTheVersion) {
  const auto itself = [](Lineup lineup) {
    return measured(Variant::permissions_by_itself, lineup);
  };
  EXPECT_EQ(itself({}), (Outcomes{Outcome::unsafe, Outcome::unsafe, Outcome::ok}));
  EXPECT_EQ(itself({.cyclonedds = {11, 0, 1}, .fastdds = {3, 1, 2}}),
            (Outcomes{Outcome::fail, Outcome::fail, Outcome::ok}));
}

class Installed : public testing::Test {
 protected:
  Installed()
      : root_(std::filesystem::path(testing::TempDir()) /
              ("ddssec-installed-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(root_ / "a");
    std::filesystem::create_directories(root_ / "b");
  }
  ~Installed() override { std::filesystem::remove_all(root_); }
  void touch(const char* name) const { std::ofstream(root_ / name) << ""; }
  std::optional<Version> found(Vendor vendor) const {
    return installed_version(vendor, {root_ / "missing", root_ / "a", root_ / "b"});
  }

  std::filesystem::path root_;
};

TEST_F(Installed, TheLibrarysNameSaysIt) {
  EXPECT_EQ(found(Vendor::cyclonedds), std::nullopt);
  for (const auto* name : {"a/libddsc.so", "a/libddsc.so.0debian", "a/libfastrtps.so.2.9",
                           "a/libddscxx.so.0.10.9", "a/libddsc.so.0.10.x"})
    touch(name);
  EXPECT_EQ(found(Vendor::cyclonedds), std::nullopt);
  EXPECT_EQ(found(Vendor::fastdds), std::nullopt);
  touch("b/libddsc.so.0.10.5");
  touch("b/libfastrtps.so.2.9.1");
  EXPECT_EQ(found(Vendor::cyclonedds), (Version{0, 10, 5}));
  EXPECT_EQ(found(Vendor::fastdds), (Version{2, 9, 1}));
  touch("a/libddsc.so.0.10.2");  // the loader would take this one
  touch("b/libfastdds.so.3.1.2");
  EXPECT_EQ(found(Vendor::cyclonedds), (Version{0, 10, 2}));
  EXPECT_EQ(found(Vendor::fastdds), (Version{3, 1, 2}));
  EXPECT_EQ(found(Vendor::ours), std::nullopt);
}

TEST_F(Installed, FoldersAreThoseOfTheVariableAndThenTheSystems) {
  const auto a = (root_ / "a").string();
  const auto folders = library_folders(":/nowhere:" + a + "::");
  ASSERT_FALSE(folders.empty());
  EXPECT_EQ(folders.front(), a);
  EXPECT_NE(std::ranges::find(folders, "/usr/lib"), folders.end());
}

struct Text {
  std::string given;
  std::string left;
  std::vector<Variant> left_out;
};

std::string blanks(std::string_view text) { return std::string(text.size(), ' '); }

TEST(LenientText, WhatStockProductsSkipIsBlankedOutAndNamed) {
  using enum Variant;
  const std::string doctype = R"(<!DOCTYPE d [<!ENTITY a "">]>)";
  const std::string dashes = "<!-- a--b -->";
  const std::string declaration = R"(<?xml version=\"1.0\" encoding=\"utf-8\"?>)";
  for (const auto& [given, left, left_out] : {
           Text{"<dds/>", "<dds/>", {}},
           Text{"<dds><!-- a --></dds>", "<dds><!-- a --></dds>", {}},
           Text{doctype + "<d/>", blanks(doctype) + "<d/>", {governance_doctype}},
           Text{"<?a\n b?><d/>", "   \n    <d/>", {governance_processing_instruction}},
           Text{"<d>" + dashes + "</d>",
                "<d>" + blanks(dashes) + "</d>",
                {governance_comment_dashes}},
           Text{declaration + "<d/>", blanks(declaration) + "<d/>", {governance_escaped_quotes}},
           Text{"<d>\xE4</d>", "<d>?</d>", {governance_latin_1}},
           Text{"<!DOCTYPE", "         ", {governance_doctype}},
           Text{"<!--", "<!--", {}},
           Text{"", "", {}},
       }) {
    const auto out = lenient_text(as_bytes(std::string_view(given)));
    EXPECT_EQ(as_text(out.text), left) << given;
    EXPECT_EQ(out.left_out, left_out) << given;
  }
}

TEST(Outcomes, TheWorseCountsForEachProductAlone) {
  constexpr Outcomes a{.cyclonedds = Outcome::late, .ours = Outcome::unsafe};
  constexpr Outcomes b{.cyclonedds = Outcome::ok, .fastdds = Outcome::fail, .ours = Outcome::late};
  EXPECT_EQ(a.worse(b), (Outcomes{Outcome::late, Outcome::fail, Outcome::late}));
  EXPECT_EQ(b.worse(a), a.worse(b));
  EXPECT_FALSE(a.all_ok());
  EXPECT_TRUE(Outcomes{}.all_ok());
  EXPECT_EQ(Outcomes::all(Outcome::fail).of(Vendor::fastdds), Outcome::fail);
  EXPECT_EQ(b.of(Vendor::cyclonedds), Outcome::ok);
}

TEST(Outcome, HasAWord) {
  EXPECT_EQ(to_string(Outcome::ok), "ok");
  EXPECT_EQ(to_string(Outcome::unsafe), "unsafe");
  EXPECT_EQ(to_string(Outcome::late), "late");
  EXPECT_EQ(to_string(Outcome::fail), "fail");
  EXPECT_EQ(name(Vendor::fastdds), "Fast DDS 2.9.1");
}

}  // namespace
}  // namespace ddssec::governance::doctor
