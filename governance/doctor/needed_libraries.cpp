#include "governance/doctor/needed_libraries.hpp"

#include <cstring>
#include <elf.h>
#include <optional>

namespace ddssec::governance::doctor {
namespace {

template <typename T>
std::optional<T> structure_at(std::string_view octets, std::uint64_t at) {
  if (at > octets.size() || octets.size() - at < sizeof(T)) return std::nullopt;
  T out;
  std::memcpy(&out, octets.data() + at, sizeof out);
  return out;
}

std::string_view part(std::string_view octets, std::uint64_t at, std::uint64_t size) {
  return at < octets.size() ? octets.substr(at, size) : std::string_view();
}

std::string text_at(std::string_view texts, std::uint64_t at) {
  const auto rest = part(texts, at, texts.size());
  return std::string(rest.substr(0, rest.find('\0')));
}

std::optional<Elf64_Shdr> section_at(std::string_view octets, const Elf64_Ehdr& header,
                                     std::uint64_t index) {
  if (index >= header.e_shnum || header.e_shoff > octets.size()) return std::nullopt;
  return structure_at<Elf64_Shdr>(octets, header.e_shoff + index * sizeof(Elf64_Shdr));
}

void add_entries(std::string_view entries, std::string_view texts, NeededLibraries& out) {
  for (std::uint64_t at = 0;; at += sizeof(Elf64_Dyn)) {
    const auto entry = structure_at<Elf64_Dyn>(entries, at);
    if (!entry || entry->d_tag == DT_NULL) return;
    const auto text = text_at(texts, entry->d_un.d_val);
    if (entry->d_tag == DT_NEEDED) out.names.push_back(text);
    if (entry->d_tag == DT_RUNPATH || entry->d_tag == DT_RPATH) out.search_path = text;
  }
}

}  // namespace

NeededLibraries needed_libraries(std::string_view octets) {
  NeededLibraries out;
  const auto header = structure_at<Elf64_Ehdr>(octets, 0);
  if (!header || !octets.starts_with(ELFMAG) || header->e_ident[EI_CLASS] != ELFCLASS64 ||
      header->e_shentsize != sizeof(Elf64_Shdr))
    return out;
  for (std::uint64_t i = 0; i < header->e_shnum; ++i) {
    const auto section = section_at(octets, *header, i);
    if (!section || section->sh_type != SHT_DYNAMIC) continue;
    const auto texts = section_at(octets, *header, section->sh_link);
    if (!texts) break;
    add_entries(part(octets, section->sh_offset, section->sh_size),
                part(octets, texts->sh_offset, texts->sh_size), out);
  }
  return out;
}

}  // namespace ddssec::governance::doctor
