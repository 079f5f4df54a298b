// Folders with libraries, and participants that load them.
#pragma once

#include <elf.h>
#include <fstream>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "governance/doctor/host_plugins.hpp"

namespace ddssec::governance::doctor::libraries {

using testing::ElementsAre;

inline constexpr const char* kConfiguration =
    "<CycloneDDS><Domain><!-- <Authentication> --><Security>\n"
    "<authentication><Library path=\"dds_security_auth\"/></authentication>\n"
    "<AccessControl><Library initFunction='x' path='dds_security_ac'/></AccessControl>\n"
    "<Cryptographic><Library/></Cryptographic></Security></Domain></CycloneDDS>";

inline constexpr const char* kNames[] = {"auth", "ac", "crypto"};

/// Returns the header of a library of this machine: that of this test program, without segments and
/// sections.
inline Elf64_Ehdr library_header() {
  Elf64_Ehdr header{};
  std::ifstream("/proc/self/exe", std::ios::binary)
      .read(reinterpret_cast<char*>(&header), sizeof header);
  header.e_type = ET_DYN;
  header.e_phnum = header.e_shnum = 0;
  return header;
}

inline std::string octets_of(const Elf64_Ehdr& header) {
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
  std::vector<std::string> products() const {
    std::vector<std::string> out;
    for (const auto& plugin : found()) out.push_back(product_of(plugin));
    return out;
  }
  Diagnosis said() const {
    Diagnosis out;
    diagnose_host_plugins(found(), places_, were_ours_meant_, out);
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

/// Returns an ELF file that has only a dynamic section, and needs one library.
inline std::string elf_that_needs(const std::string& library) {
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

}  // namespace ddssec::governance::doctor::libraries
