#include "governance/doctor/library_search.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <elf.h>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "governance/doctor/installed_version.hpp"
#include "governance/doctor/loader_subfolders.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxOctets = 64 * 1024 * 1024;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

class OpenFile {
 public:
  // Opening a FIFO must not block.
  explicit OpenFile(const fs::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)), error_(errno) {}
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }
  int error() const { return error_; }
  std::uint64_t size() const {
    struct stat status {};
    return ::fstat(descriptor_, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
  }
  template <typename T>
  std::optional<T> read_at(std::uint64_t at) const {
    T out{};
    if (::pread(descriptor_, &out, sizeof out, static_cast<off_t>(at)) != sizeof out)
      return std::nullopt;
    return out;
  }

 private:
  int descriptor_;
  int error_;
};

std::optional<Elf64_Ehdr> own_header() {
  static const auto header = OpenFile("/proc/self/exe").read_at<Elf64_Ehdr>(0);
  return header;
}

bool is_padding_clear(const Elf64_Ehdr& header) {
  const auto* const begin = header.e_ident + EI_ABIVERSION;
  return std::all_of(begin, header.e_ident + EI_NIDENT, [](unsigned char c) { return c == 0; });
}

// The checks have the order of those in ld.so (open_verify in elf/dl-load.c).
LibraryState state_of_header(const Elf64_Ehdr& header, const Elf64_Ehdr& own) {
  if (!std::equal(header.e_ident, header.e_ident + SELFMAG, ELFMAG)) return LibraryState::refused;
  if (header.e_ident[EI_CLASS] != own.e_ident[EI_CLASS]) return LibraryState::absent;
  const bool is_system =
      header.e_ident[EI_OSABI] == ELFOSABI_SYSV || header.e_ident[EI_OSABI] == ELFOSABI_LINUX;
  if (header.e_ident[EI_DATA] != own.e_ident[EI_DATA] || header.e_ident[EI_VERSION] != EV_CURRENT ||
      !is_system || !is_padding_clear(header) || header.e_version != EV_CURRENT)
    return LibraryState::refused;
  if (header.e_machine != own.e_machine) return LibraryState::absent;
  return header.e_type == ET_DYN && header.e_phentsize == sizeof(Elf64_Phdr)
             ? LibraryState::loadable
             : LibraryState::refused;
}

// Pages after the end of a file cannot be read.
LibraryState state_of_segments(const OpenFile& file, const Elf64_Ehdr& header) {
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const auto readable = (file.size() + page - 1) / page * page;
  for (std::uint64_t i = 0; i < header.e_phnum; ++i) {
    const auto segment = file.read_at<Elf64_Phdr>(header.e_phoff + i * sizeof(Elf64_Phdr));
    if (!segment) return LibraryState::refused;
    if (segment->p_type == PT_LOAD &&
        (segment->p_filesz > readable || segment->p_offset > readable - segment->p_filesz))
      return LibraryState::cut_off;
  }
  return LibraryState::loadable;
}

std::uint32_t number_at(std::string_view octets, std::size_t at) {
  std::uint32_t out = 0;
  if (at + sizeof out <= octets.size()) std::memcpy(&out, octets.data() + at, sizeof out);
  return out;
}

// Reads glibc's "new" format (sysdeps/generic/dl-cache.h): a header of 48 octets, and entries of
// 24.
std::vector<fs::path> listed_in_cache(const fs::path& cache, std::string_view name) {
  constexpr std::string_view kMagic = "glibc-ld.so.cache1.1";
  constexpr std::size_t kHeader = 48, kEntry = 24;
  std::vector<fs::path> out;
  const auto octets = is_file(cache) ? library_octets(cache) : std::string();
  if (!octets.starts_with(kMagic)) return out;
  const auto text_at = [&](std::uint32_t at) {
    return at < octets.size() ? std::string_view(octets.c_str() + at) : std::string_view();
  };
  const std::size_t count = number_at(octets, kMagic.size());
  for (std::size_t i = 0; i < count && kHeader + (i + 1) * kEntry <= octets.size(); ++i) {
    const auto entry = kHeader + i * kEntry;
    if (text_at(number_at(octets, entry + 4)) == name)
      out.emplace_back(text_at(number_at(octets, entry + 8)));
  }
  return out;
}

// The place of a cached file's subfolder in the loader's order. Empty for a subfolder that the
// loader of this machine does not search.
std::optional<std::size_t> rank_of(const fs::path& file,
                                   const std::vector<std::string>& subfolders) {
  const auto folder = file.parent_path().string();
  const auto found = std::ranges::find_if(
      subfolders, [&](const std::string& name) { return folder.ends_with("/" + name); });
  if (found != subfolders.end()) return static_cast<std::size_t>(found - subfolders.begin());
  return folder.contains("/glibc-hwcaps/") ? std::nullopt : std::optional(subfolders.size());
}

FoundLibrary found_in_cache(const LoaderPlaces& places, std::string_view name) {
  FoundLibrary out;
  std::optional<std::size_t> best;
  for (const auto& file : listed_in_cache(places.cache, name)) {
    const auto rank = rank_of(file, places.subfolders);
    if (!rank || (best && *best <= *rank)) continue;
    const auto state = library_state(file);
    if (state == LibraryState::absent) continue;
    out = {file, state};
    best = rank;
  }
  return out;
}

}  // namespace

fs::path own_dropin() {
  std::error_code error;
  const auto program = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  const auto prefix = program.parent_path().parent_path();
  for (const auto* name : {"lib/ddssec/dropin", "dropin"})
    if (is_file(prefix / name / "libdds_security_auth.so")) return prefix / name;
  return {};
}

std::string library_path_line(const fs::path& dropin) {
  return fmt::format("export LD_LIBRARY_PATH={}${{LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}}",
                     shell_word(dropin.string()));
}

LoaderPlaces LoaderPlaces::here() {
  const char* const path = std::getenv("LD_LIBRARY_PATH");
  LoaderPlaces out{.library_path = path != nullptr ? path : "",
                   .system = library_folders(""),
                   .dropin = own_dropin(),
                   .subfolders = loader_subfolders()};
  for (const auto& folder : out.system) out.after_loader.push_back(folder / "libddsc0debian");
  return out;
}

LibraryState library_state(const fs::path& path) {
  const OpenFile file(path);
  if (!file.is_open())
    return file.error() == ENOENT || file.error() == EACCES || file.error() == ENOTDIR
               ? LibraryState::absent
               : LibraryState::refused;
  const auto own = own_header();
  const auto header = file.read_at<Elf64_Ehdr>(0);
  if (!own || !header) return LibraryState::refused;
  const auto state = state_of_header(*header, *own);
  return state == LibraryState::loadable ? state_of_segments(file, *header) : state;
}

FoundLibrary found_in(const std::vector<fs::path>& folders,
                      const std::vector<std::string>& subfolders, const std::string& name) {
  const auto look = [&](const fs::path& file) { return FoundLibrary{file, library_state(file)}; };
  for (const auto& folder : folders) {
    for (const auto& subfolder : subfolders)
      if (auto found = look(folder / subfolder / name); found.state != LibraryState::absent)
        return found;
    if (auto found = look(folder / name); found.state != LibraryState::absent) return found;
  }
  return {};
}

// Searches as dlopen does for a name without a slash.
FoundLibrary found_by_loader(const std::string& name, const LoaderPlaces& places) {
  auto out = found_in(folders_of(places.library_path), places.subfolders, name);
  if (out.state == LibraryState::absent) out = found_in_cache(places, name);
  if (out.state == LibraryState::absent) out = found_in(places.system, places.subfolders, name);
  return out;
}

std::vector<fs::path> folders_of(std::string_view library_path) {
  std::vector<fs::path> out;
  while (!library_path.empty()) {
    const auto end = std::min(library_path.find_first_of(":;"), library_path.size());
    out.emplace_back(end == 0 ? "." : library_path.substr(0, end));
    library_path.remove_prefix(std::min(end + 1, library_path.size()));
  }
  return out;
}

std::string library_octets(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  std::string out(error ? 0 : std::min<std::uintmax_t>(size, kMaxOctets), '\0');
  file.read(out.data(), static_cast<std::streamsize>(out.size()));
  out.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return out;
}

}  // namespace ddssec::governance::doctor
