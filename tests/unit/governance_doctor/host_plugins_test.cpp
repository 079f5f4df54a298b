#include "governance/doctor/host_plugins.hpp"

#include <cstring>
#include <elf.h>
#include <fstream>

#include <gmock/gmock.h>

#include "fixture.hpp"
#include "governance/doctor/loader_subfolders.hpp"
#include "governance/doctor/needed_libraries.hpp"

namespace ddssec::governance::doctor {
namespace {

using Maker = HostPlugin::Maker;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kConfiguration =
    "<CycloneDDS><Domain><!-- <Authentication> --><Security>\n"
    "<authentication><Library path=\"dds_security_auth\"/></authentication>\n"
    "<AccessControl><Library initFunction='x' path='dds_security_ac'/></AccessControl>\n"
    "<Cryptographic><Library/></Cryptographic></Security></Domain></CycloneDDS>";
constexpr const char* kNames[] = {"auth", "ac", "crypto"};

/// The header of a library of this machine: this test program's, without segments and sections.
Elf64_Ehdr library_header() {
  Elf64_Ehdr header{};
  std::ifstream("/proc/self/exe", std::ios::binary)
      .read(reinterpret_cast<char*>(&header), sizeof header);
  header.e_type = ET_DYN;
  header.e_phnum = header.e_shnum = 0;
  return header;
}
std::string octets_of(const Elf64_Ehdr& header) {
  return {reinterpret_cast<const char*>(&header), sizeof header};
}

class HostPlugins : public Folders {
 protected:
  void SetUp() override {
    Folders::SetUp();
    places_.cache = root_ / "no-cache";
    places_.system = {root_ / "system"};
    places_.after_loader = {root_ / "system/private"};
    for (const auto* folder : {"ours", "old", "system/private"})
      fs::create_directories(root_ / folder);
    for (const auto* name : kNames) {
      put("ours", name, std::string("ELF\0ddssec_x_version\0ddssec plugin version 1.2.3\0", 49));
      put("old", name, "ddssec_x_version");
      put("system/private", name, "init_authentication");
    }
  }
  void put(const fs::path& folder, const std::string& name, const std::string& octets) const {
    std::ofstream(root_ / folder / ("libdds_security_" + name + ".so"))
        << octets_of(library_header()) << octets;
  }
  void put_file(const fs::path& folder, const std::string& name, const std::string& octets) const {
    std::ofstream(root_ / folder / ("libdds_security_" + name + ".so")) << octets;
  }
  void put_as(const fs::path& folder, const std::string& octets) const {
    fs::create_directories(root_ / folder);
    for (const auto* name : kNames) put_file(folder, name, octets);
  }
  void path(std::initializer_list<const char*> folders) {
    places_.library_path.clear();
    for (const auto* folder : folders) places_.library_path += (root_ / folder).string() + ":";
  }
  std::vector<HostPlugin> found() const { return host_plugins(kConfiguration, places_); }
  std::vector<std::string> makers() const {
    std::vector<std::string> out;
    for (const auto& plugin : found()) out.push_back(maker_of(plugin));
    return out;
  }
  Diagnosis said() const {
    Diagnosis out;
    check_host_plugins(found(), places_, were_ours_meant_, out);
    return out;
  }
  std::string message() const {
    const auto all = said();
    EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC068));
    return rules_of(all).empty() ? "" : finding_of(all, Rule::DOC068).message;
  }
  LoaderPlaces places_;
  bool were_ours_meant_ = false;
};

TEST_F(HostPlugins, AreThoseThatTheLoaderFindsFirst) {
  path({"nowhere", "ours", "old"});
  EXPECT_THAT(makers(), ElementsAre("ddssec 1.2.3", "ddssec 1.2.3", "ddssec 1.2.3"));
  EXPECT_EQ(found()[0].file, root_ / "ours/libdds_security_auth.so");
  EXPECT_EQ(found()[1].role, "access control");
  EXPECT_THAT(rules_of(said()), IsEmpty());
  path({"old", "ours"});
  EXPECT_THAT(makers(), ElementsAre("ddssec", "ddssec", "ddssec"));
}

TEST_F(HostPlugins, OfAnotherProductAreNoFaultWhereNothingNamesOurs) {
  path({});
  EXPECT_EQ(found()[2].maker, Maker::other);
  EXPECT_EQ(found()[2].file, root_ / "system/private/libdds_security_crypto.so");
  EXPECT_THAT(rules_of(said()), IsEmpty());
  EXPECT_THAT(said().checks(), IsEmpty());
}

TEST_F(HostPlugins, OfAnotherProductAreTold_InAFolderThatWasMadeForOurs) {
  path({});
  were_ours_meant_ = true;
  EXPECT_THAT(message(), HasSubstr("runs the stock plugins, not ddssec's: authentication: stock"));
  EXPECT_EQ(said().outcomes(),
            (Outcomes{}));  // it starts, and who runs no Cyclone DDS may not care
  EXPECT_THAT(finding_of(said(), Rule::DOC068).hint,
              HasSubstr("lib/ddssec/dropin of an installation"));
  places_.dropin = "/opt/ddssec/lib/ddssec/dropin";
  EXPECT_THAT(finding_of(said(), Rule::DOC068).hint,
              HasSubstr("export LD_LIBRARY_PATH=/opt/ddssec/lib/ddssec/dropin${LD_LIBRARY_PATH"));
  path({"ours"});
  EXPECT_THAT(rules_of(said()), IsEmpty());
  fs::remove_all(root_ / "system");
  path({});
  EXPECT_THAT(rules_of(said()), IsEmpty());  // a machine without Cyclone DDS
}

/// An ELF file with nothing but a dynamic section, which needs one library.
std::string elf_that_needs(const std::string& library) {
  auto header = library_header();
  header.e_shentsize = sizeof(Elf64_Shdr);
  header.e_shnum = 2;
  header.e_shoff = sizeof header;
  const std::string texts = std::string(1, '\0') + library + '\0' + "$ORIGIN/beside" + '\0';
  const Elf64_Dyn entries[] = {
      {DT_NEEDED, {1}}, {DT_RUNPATH, {library.size() + 2}}, {DT_NULL, {0}}};
  Elf64_Shdr dynamic{}, strings{};
  dynamic.sh_type = SHT_DYNAMIC;
  dynamic.sh_link = 1;
  dynamic.sh_offset = sizeof header + 2 * sizeof dynamic;
  dynamic.sh_size = sizeof entries;
  strings.sh_type = SHT_STRTAB;
  strings.sh_offset = dynamic.sh_offset + dynamic.sh_size;
  strings.sh_size = texts.size();
  std::string out;
  const auto put = [&](const auto& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(header);
  put(dynamic);
  put(strings);
  put(entries);
  return out + texts + "ddssec plugin version 1.2.3 of ddssec_x";
}

TEST_F(HostPlugins, OfOursThatCannotBeLoadedAreTold) {
  const auto octets = elf_that_needs("libnowhere.so.23");
  put_file("ours", "ac", octets);
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("libnowhere.so.23 is not on this machine"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.ours = Outcome::fail}));
  fs::create_directories(root_ / "ours/beside");
  std::ofstream(root_ / "ours/beside/libnowhere.so.23") << octets_of(library_header());
  EXPECT_THAT(rules_of(said()), IsEmpty());
  fs::rename(root_ / "ours/beside/libnowhere.so.23", root_ / "system/libnowhere.so.23");
  EXPECT_THAT(rules_of(said()), IsEmpty());
  for (std::size_t size = 0; size < octets.size(); ++size)  // and nothing is read that is not there
    EXPECT_LE(needed_libraries(octets.substr(0, size)).names.size(), 1u);
}

TEST_F(HostPlugins, OfTwoProductsAreTold) {
  fs::remove(root_ / "ours/libdds_security_ac.so");
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("authentication: ddssec 1.2.3"));
  EXPECT_THAT(message(), HasSubstr("access control: stock, not ddssec's (" +
                                   (root_ / "system/private").string()));
  EXPECT_EQ(said().outcomes(), (Outcomes{.ours = Outcome::unsafe}));
}

TEST_F(HostPlugins, OfTwoVersionsAreTold) {
  put("ours", "crypto", "ddssec_x ddssec plugin version 1.2.4");
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("of two versions: authentication: ddssec 1.2.3"));
}

TEST_F(HostPlugins, ThatAreMissingAreTold) {
  fs::remove(root_ / "ours/libdds_security_ac.so");
  fs::remove(root_ / "system/private/libdds_security_ac.so");
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("access control: not found"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ours = Outcome::fail}));
}

TEST_F(HostPlugins, OfAnotherProductAreTold_WhereOursWereMeant) {
  fs::create_directories(root_ / "links");
  for (const auto* name : kNames)
    fs::create_symlink("../lib/gone.so",
                       root_ / ("links/libdds_security_" + std::string(name) + ".so"));
  path({"links"});
  EXPECT_THAT(message(), HasSubstr("libdds_security_auth.so is a link that leads nowhere"));
  path({"my-dropin"});
  EXPECT_THAT(message(), HasSubstr("my-dropin is no folder"));
  path({"system/private", "ours"});
  EXPECT_THAT(message(), HasSubstr("ours/libdds_security_auth.so is ddssec's, and"));
  fs::create_directories(root_ / "lib");
  std::ofstream(root_ / "lib/libddssec_authentication.so") << "ddssec_";
  path({"lib"});
  EXPECT_THAT(message(), HasSubstr("under names that the configuration does not name"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.ours = Outcome::fail}));
}

TEST_F(HostPlugins, CountWithAPathAsItIs) {
  auto text = std::string(kConfiguration);
  const std::string name = "dds_security_ac";
  text.replace(text.find(name), name.size(), (root_ / "old/libdds_security_ac.so").string());
  EXPECT_EQ(host_plugins(text, places_)[1].maker, Maker::ours);
  Diagnosis judged;
  check_host_plugins(host_plugins(text, places_), places_, true, judged);
  EXPECT_THAT(rules_of(judged), ElementsAre(Rule::DOC068));  // two products
  put_file("old", "ac", elf_that_needs("libnowhere.so.23"));
  const auto unloadable = host_plugins(text, places_);
  Diagnosis told;
  check_loadable(unloadable, told);
  EXPECT_EQ(told.outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ours = Outcome::fail}));
  EXPECT_THAT(finding_of(told, Rule::DOC068).message, HasSubstr("Cyclone DDS does not start"));
  fs::remove(root_ / "old/libdds_security_ac.so");  // DOC102 reports it: no question of the loader
  Diagnosis missing;
  check_host_plugins(host_plugins(text, places_), places_, true, missing);
  EXPECT_THAT(rules_of(missing), IsEmpty());
  text.replace(text.find((root_ / "old").string()), (root_ / "old").string().size(), "${HOME}/x");
  EXPECT_THAT(host_plugins(text, places_), IsEmpty());
}

TEST_F(HostPlugins, OfAConfigurationWithoutSecurityAreNone) {
  EXPECT_THAT(host_plugins("<CycloneDDS/>", places_), IsEmpty());
  EXPECT_THAT(host_plugins("", places_), IsEmpty());
  EXPECT_EQ(plugins_of_node(places_).size(), 3u);
}

/// A cache as ldconfig writes it, with one entry.
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

TEST_F(HostPlugins, AreFoundInTheCacheOfLdconfigToo) {
  const auto octets =
      cache_with("libdds_security_ac.so", (root_ / "old/libdds_security_ac.so").string());
  places_.cache = root_ / "cache";
  std::ofstream(places_.cache) << octets;
  path({});
  EXPECT_EQ(found()[1].file, root_ / "old/libdds_security_ac.so");
  EXPECT_EQ(found()[0].maker, Maker::other);
  for (std::size_t size = 0; size < octets.size(); ++size) {
    std::ofstream(places_.cache) << octets.substr(0, size);
    EXPECT_EQ(found()[0].maker, Maker::other);  // and nothing is read that is not there
  }
}

TEST_F(HostPlugins, InASubfolderOfTheLoaderComeFirst) {
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
  places_.subfolders = {};  // of another processor
  path({"ours"});
  EXPECT_EQ(found()[0].maker, Maker::ours);
}

TEST_F(HostPlugins, OfOtherMachinesArePassedOver) {
  auto other_class = library_header(), other_machine = library_header();
  other_class.e_ident[EI_CLASS] = ELFCLASS32;
  other_machine.e_machine = EM_SPARC;
  put_as("32", octets_of(other_class));
  put_as("sparc", octets_of(other_machine));
  path({"32", "sparc", "ours"});
  EXPECT_EQ(found()[0].file, root_ / "ours/libdds_security_auth.so");
  EXPECT_THAT(rules_of(said()), IsEmpty());
}

TEST_F(HostPlugins, AreNotFoundBehindAFileThatIsNoLibrary) {
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

TEST_F(HostPlugins, ThatAreCutOffEndTheProcess) {
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
  EXPECT_EQ(said().outcomes(), (Outcomes{.cyclonedds = Outcome::fail, .ours = Outcome::fail}));
  put_as("cut", octets + std::string(1'000'000, ' '));
  EXPECT_THAT(rules_of(said()), IsEmpty());
}

TEST_F(HostPlugins, OfTheCacheAreThoseForThisProcessor) {
  const auto folder = root_ / "cached/glibc-hwcaps/x86-64-v4";
  put_as("cached/glibc-hwcaps/x86-64-v4", octets_of(library_header()) + "ddssec_");
  places_.cache = root_ / "cache";
  std::ofstream(places_.cache) << cache_with("libdds_security_ac.so",
                                             (folder / "libdds_security_ac.so").string());
  path({});
  EXPECT_EQ(found()[1].maker, Maker::other);
  places_.subfolders = {"glibc-hwcaps/x86-64-v4"};
  EXPECT_EQ(found()[1].file, folder / "libdds_security_ac.so");
}

TEST(LoaderSubfolders, AreReadFromWhatTheLoaderSays) {
  EXPECT_THAT(
      subfolders_in(
          "  12:\t search path=/p/glibc-hwcaps/x86-64-v2:/p/tls:/p\t\t(LD_LIBRARY_PATH)\n", "/p"),
      ElementsAre("glibc-hwcaps/x86-64-v2", "tls"));
  EXPECT_THAT(subfolders_in("  12:\t search path=/p\t\t(LD_LIBRARY_PATH)\n", "/p"), IsEmpty());
  EXPECT_THAT(subfolders_in("  12:\t search path=/usr/lib/tls:/usr/lib\t\t(x)\n", "/p"), IsEmpty());
  EXPECT_THAT(subfolders_in("find library=libm.so.6 [0]; searching\n", "/p"), IsEmpty());
}

TEST_F(HostPlugins, OfThisMachineAreLookedForInItsFolders) {
  const auto here = LoaderPlaces::here();
  EXPECT_FALSE(here.system.empty());
  EXPECT_EQ(here.after_loader.size(), here.system.size());
}

}  // namespace
}  // namespace ddssec::governance::doctor
