// The file that the dynamic loader opens.
#include "governance/doctor/library_search.hpp"

#include <elf.h>
#include <fstream>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/host_plugins.hpp"
#include "tests/unit/governance_doctor/libraries.hpp"

namespace ddssec::governance::doctor::libraries {
namespace {

using PluginProduct = HostPlugin::PluginProduct;

using testing::HasSubstr;
using testing::IsEmpty;

// Returns a cache in the form of ldconfig, with one entry.
std::string cache_with(const std::string& name, const std::string& file) {
  constexpr std::size_t kHeader = 48, kEntry = 24;
  std::string out = "glibc-ld.so.cache1.1";
  const auto put = [&](std::uint32_t number) {
    out.append(reinterpret_cast<const char*>(&number), 4);
  };
  put(1);
  out.resize(kHeader);
  put(0x303);
  put(kHeader + kEntry);
  put(static_cast<std::uint32_t>(kHeader + kEntry + name.size() + 1));
  out.resize(kHeader + kEntry);
  return out + name + '\0' + file + '\0';
}

TEST_F(HostPlugins, CacheOfLdconfig_IsSearchedToo) {
  const auto octets =
      cache_with("libdds_security_ac.so", (root_ / "old/libdds_security_ac.so").string());
  places_.cache = root_ / "cache";
  std::ofstream(places_.cache) << octets;
  path({});
  EXPECT_EQ(found()[1].file, root_ / "old/libdds_security_ac.so");
  EXPECT_EQ(found()[0].product, PluginProduct::other);
  for (std::size_t size = 0; size < octets.size(); ++size) {
    std::ofstream(places_.cache) << octets.substr(0, size);
    EXPECT_EQ(found()[0].product,
              PluginProduct::other);  // and nothing beyond the end of the file is read
  }
}

TEST_F(HostPlugins, SubfolderOfTheLoader_ComesFirst) {
  places_.subfolders = {"glibc-hwcaps/x86-64-v3", "tls"};
  const auto stock = octets_of(library_header()) + "init_authentication";
  put_as("ours/tls", stock);
  path({"ours"});
  EXPECT_EQ(found()[0].file, root_ / "ours/tls/libdds_security_auth.so");
  EXPECT_THAT(message(), HasSubstr("ours/libdds_security_auth.so is ddssec's, and"));
  put_as("ours/glibc-hwcaps/x86-64-v3", stock);
  EXPECT_EQ(found()[0].file, root_ / "ours/glibc-hwcaps/x86-64-v3/libdds_security_auth.so");
  put_as("system/glibc-hwcaps/x86-64-v3", stock);
  path({});
  EXPECT_EQ(found()[2].file, root_ / "system/glibc-hwcaps/x86-64-v3/libdds_security_crypto.so");
  places_.subfolders = {};  // those of another processor
  path({"ours"});
  EXPECT_EQ(found()[0].product, PluginProduct::ddssec);
}

TEST_F(HostPlugins, PluginsOfOtherMachines_ArePassedOver) {
  auto other_class = library_header(), other_machine = library_header();
  other_class.e_ident[EI_CLASS] = ELFCLASS32;
  other_machine.e_machine = EM_SPARC;
  put_as("32", octets_of(other_class));
  put_as("sparc", octets_of(other_machine));
  path({"32", "sparc", "ours"});
  EXPECT_EQ(found()[0].file, root_ / "ours/libdds_security_auth.so");
  EXPECT_THAT(rules_of(said()), IsEmpty());
}

TEST_F(HostPlugins, FileThatIsNoLibrary_EndsTheSearch) {
  auto executable = library_header();
  executable.e_type = ET_EXEC;
  put_as("text", "hello");
  put_as("executable", octets_of(executable));
  fs::create_directories(root_ / "folders/libdds_security_auth.so");
  fs::create_directories(root_ / "loops");
  fs::create_symlink("libdds_security_auth.so", root_ / "loops/libdds_security_auth.so");
  for (const auto* folder : {"text", "executable", "folders", "loops"}) {
    path({folder, "ours"});
    EXPECT_EQ(found()[0].file, root_ / "system/private/libdds_security_auth.so") << folder;
    EXPECT_EQ(found()[0].obstacle, root_ / folder / "libdds_security_auth.so");
    EXPECT_FALSE(said().outcomes() == Outcomes{}) << folder;
  }
  path({"text", "ours"});
  EXPECT_THAT(message(),
              HasSubstr("text/libdds_security_auth.so is no library of this machine, and "
                        "the loader looks no further"));
}

TEST_F(HostPlugins, LibraryCutOff_EndsTheProcess) {
  auto header = library_header();
  header.e_phnum = 1;
  header.e_phoff = sizeof header;
  Elf64_Phdr segment{};
  segment.p_type = PT_LOAD;
  segment.p_filesz = 1'000'000;
  const auto octets = octets_of(header) +
                      std::string(reinterpret_cast<const char*>(&segment), sizeof segment) +
                      "ddssec_";
  put_as("cut", octets);
  path({"cut", "ours"});
  EXPECT_THAT(message(), HasSubstr("is cut off"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail}));
  put_as("cut", octets + std::string(1'000'000, ' '));
  EXPECT_THAT(rules_of(said()), IsEmpty());
}

TEST_F(HostPlugins, EntriesOfTheCacheForOtherProcessors_ArePassedOver) {
  const auto folder = root_ / "cached/glibc-hwcaps/x86-64-v4";
  put_as("cached/glibc-hwcaps/x86-64-v4", octets_of(library_header()) + "ddssec_");
  places_.cache = root_ / "cache";
  std::ofstream(places_.cache) << cache_with("libdds_security_ac.so",
                                             (folder / "libdds_security_ac.so").string());
  path({});
  EXPECT_EQ(found()[1].product, PluginProduct::other);
  places_.subfolders = {"glibc-hwcaps/x86-64-v4"};
  EXPECT_EQ(found()[1].file, folder / "libdds_security_ac.so");
}

TEST_F(HostPlugins, ThisMachinesFolders_AreKnown) {
  const auto here = LoaderPlaces::here();
  EXPECT_FALSE(here.system.empty());
  EXPECT_EQ(here.after_loader.size(), here.system.size());
}

}  // namespace
}  // namespace ddssec::governance::doctor::libraries
