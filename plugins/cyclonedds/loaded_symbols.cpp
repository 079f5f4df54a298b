#include "plugins/cyclonedds/loaded_symbols.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <link.h>

namespace ddssec::cyclonedds {
namespace {

using Symbol = ElfW(Sym);

// The parts of a library's dynamic section that are needed to find its symbols.
struct DynamicSection {
  const Symbol* symbols = nullptr;
  const char* strings = nullptr;
  std::size_t string_octets = 0;
  const std::uint32_t* gnu_hash = nullptr;
  const std::uint32_t* hash = nullptr;
};

const ElfW(Dyn) * dynamic_entries(const dl_phdr_info& library) {
  for (int i = 0; i < library.dlpi_phnum; ++i)
    if (library.dlpi_phdr[i].p_type == PT_DYNAMIC)
      return reinterpret_cast<const ElfW(Dyn)*>(library.dlpi_addr + library.dlpi_phdr[i].p_vaddr);
  return nullptr;
}

DynamicSection dynamic_section(const dl_phdr_info& library) {
  DynamicSection out;
  const auto* entry = dynamic_entries(library);
  if (entry == nullptr) return out;
  // The loader relocates the addresses in the section, but not in a section that is read-only (the
  // vdso).
  const auto address = [&](const ElfW(Dyn) & of) {
    const auto value = of.d_un.d_ptr;
    return value < library.dlpi_addr ? library.dlpi_addr + value : value;
  };
  for (; entry->d_tag != DT_NULL; ++entry) {
    if (entry->d_tag == DT_SYMTAB) out.symbols = reinterpret_cast<const Symbol*>(address(*entry));
    if (entry->d_tag == DT_STRTAB) out.strings = reinterpret_cast<const char*>(address(*entry));
    if (entry->d_tag == DT_STRSZ) out.string_octets = entry->d_un.d_val;
    if (entry->d_tag == DT_GNU_HASH)
      out.gnu_hash = reinterpret_cast<const std::uint32_t*>(address(*entry));
    if (entry->d_tag == DT_HASH) out.hash = reinterpret_cast<const std::uint32_t*>(address(*entry));
  }
  return out;
}

// Returns the number of symbols. The table does not contain its length; it follows from the hash
// tables. A GNU hash table holds four numbers (buckets, first hashed symbol, bloom words, shift),
// the bloom filter, the buckets, and for each hashed symbol one word whose lowest bit ends a
// bucket's chain.
std::size_t symbol_count(const DynamicSection& section) {
  if (section.gnu_hash == nullptr) return section.hash != nullptr ? section.hash[1] : 0;
  const auto bucket_count = section.gnu_hash[0];
  const auto first_hashed = section.gnu_hash[1];
  const auto* const bloom = section.gnu_hash + 4;
  const auto* const buckets = bloom + section.gnu_hash[2] * (sizeof(ElfW(Addr)) / 4);
  std::size_t last = bucket_count == 0 ? 0 : *std::max_element(buckets, buckets + bucket_count);
  if (last < first_hashed) return first_hashed;
  const auto* const chain = buckets + bucket_count;
  while ((chain[last - first_hashed] & 1u) == 0) ++last;
  return last + 1;
}

// The state of a search. It must not allocate or throw, because it is used in the loader's C code,
// which holds a lock.
struct Search {
  std::string_view suffix;
  std::array<char, 512> library{};
  std::array<char, 128> name{};
  bool found = false;
};

void keep(std::string_view text, auto& place) {
  std::copy_n(text.begin(), std::min(text.size(), place.size() - 1), place.begin());
}

bool search_library(const dl_phdr_info& library, Search& search) {
  const auto section = dynamic_section(library);
  if (section.symbols == nullptr || section.strings == nullptr) return false;
  const auto count = symbol_count(section);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& symbol = section.symbols[i];
    if (symbol.st_shndx == SHN_UNDEF || symbol.st_name >= section.string_octets) continue;
    const char* const text = section.strings + symbol.st_name;
    const std::string_view name(text, strnlen(text, section.string_octets - symbol.st_name));
    if (name.size() <= search.suffix.size() || !name.ends_with(search.suffix)) continue;
    keep(library.dlpi_name != nullptr ? library.dlpi_name : "", search.library);
    keep(name, search.name);
    return true;
  }
  return false;
}

extern "C" int search_each(dl_phdr_info* library, std::size_t, void* data) {
  auto& search = *static_cast<Search*>(data);
  search.found = search_library(*library, search);
  return search.found ? 1 : 0;
}

}  // namespace

std::optional<LoadedSymbol> find_loaded_symbol(std::string_view suffix) {
  Search search{.suffix = suffix};
  dl_iterate_phdr(search_each, &search);
  if (!search.found) return std::nullopt;
  return LoadedSymbol{search.library.data(), search.name.data()};
}

}  // namespace ddssec::cyclonedds
