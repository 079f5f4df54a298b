#include "plugins/cyclonedds/plugins_in_use.hpp"

#include "base/openssl_version.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kFlawed = "OpenSSL 3.0.19 27 Jan 2026";

std::string said_of(const PluginVersions& found) {
  return plugins_in_use(found, "OpenSSL 3.0.17 1 Jul 2025").to_line();
}

TEST(PluginsInUse, AllThree_AreNamedWithBothVersions) {
  const auto line = said_of({version(), version(), version()});
  EXPECT_THAT(line,
              HasSubstr(std::string("authentication, access control and cryptography of ddssec ") +
                        version() + "; running on OpenSSL 3.0.17 1 Jul 2025"));
  EXPECT_THAT(line, HasSubstr("[plugins_in_use 1620]"));
  EXPECT_THAT(line, Not(HasSubstr("another product")));
}

TEST(PluginsInUse, BesideStockOnes_SaysWhichAreWhose) {
  EXPECT_THAT(said_of({version(), nullptr, nullptr}),
              HasSubstr(std::string("authentication of ddssec ") + version() +
                        ", access control and cryptography of another product"));
  EXPECT_THAT(said_of({nullptr, version(), version()}),
              HasSubstr("access control and cryptography of ddssec"));
}

TEST(PluginsInUse, AnotherVersion_IsSaid) {
  EXPECT_THAT(said_of({version(), version(), "0.0.1"}), HasSubstr(", but cryptography of 0.0.1;"));
}

TEST(MixtureWarning, PluginsOfAnotherProduct_AreNamed) {
  EXPECT_FALSE(mixture_warning({version(), version(), version()}));
  const auto warning = mixture_warning({version(), nullptr, version()});
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->severity, Severity::warning);
  EXPECT_THAT(warning->to_line(), HasSubstr("found access control of another product"));
}

TEST(TransportWarning, ProcessThatSurelyHasNoUdp_IsWarned) {
  EXPECT_FALSE(transport_warning(true));
  EXPECT_FALSE(transport_warning(std::nullopt));
  EXPECT_EQ(transport_warning(false)->error.code(), Code::transport_without_resets);
}

TEST(OpensslWarning, KnownFlaw_NamesTheVersionAndTheRemedyInOneShortLine) {
  const auto warning = openssl_warning(kFlawed);
  ASSERT_TRUE(warning);
  EXPECT_EQ(warning->severity, Severity::warning);
  EXPECT_THAT(warning->to_line(), HasSubstr("found OpenSSL 3.0.19)"));
  EXPECT_THAT(warning->to_line(), HasSubstr("update its package; ddssec explain 1624 says more"));
  EXPECT_THAT(warning->to_line(), HasSubstr("[openssl_known_unsafe 1624]"));
}

TEST(OpensslWarning, VersionWithoutACertainFlaw_RaisesNoWarning) {
  EXPECT_FALSE(openssl_warning("OpenSSL 3.0.22 25 Aug 2026"));
  EXPECT_FALSE(openssl_warning("OpenSSL 3.0.23 29 Sep 2026"));
}

// `ddssec doctor` reads the version from the file, which it does not load.
TEST(PluginsInUse, TheLibrary_SaysItsVersionUnderAName) {
  constexpr std::string_view kName = "ddssec plugin version ";
  EXPECT_EQ(std::string_view(version() - kName.size(), kName.size()), kName);
}

// True if the event is raised for the first of several participants only, whatever their domains
// are.
bool is_said_once() {
  struct All final : EventSink {
    explicit All(std::vector<Event>& to) : events(to) {}
    void raise(const Event& event) override { events.push_back(event); }
    std::vector<Event>& events;
  };
  std::vector<Event> events;
  Host first{std::make_unique<All>(events)}, second{std::make_unique<All>(events)};
  const auto flawed = [] { return std::string(kFlawed); };
  report_plugins_in_use(first, PluginKind::authentication, flawed);
  report_plugins_in_use(first, PluginKind::access_control, flawed);
  report_plugins_in_use(second, PluginKind::authentication, flawed);
  return events.size() == 3 && events[0].error.code() == Code::plugins_in_use &&
         events[0].severity == Severity::informational &&
         events[0].error.to_sentence().contains(kFlawed) &&
         events[1].error.code() == Code::plugins_mixed &&
         events[2].error.code() == Code::openssl_known_unsafe;
}

// This needs a process of its own, because other tests may have raised the event in this one.
TEST(PluginsInUse, OneProcess_SaysItOnce) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::_Exit(is_said_once() ? 0 : 1), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace ddssec::cyclonedds
