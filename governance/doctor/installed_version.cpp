#include "governance/doctor/installed_version.hpp"

#include <algorithm>
#include <array>
#include <system_error>

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// The library of Fast DDS 3 has another name than that of Fast DDS 2.
constexpr std::array<std::string_view, 1> kCycloneDds{"libddsc.so."};
constexpr std::array<std::string_view, 2> kFastDds{"libfastrtps.so.", "libfastdds.so."};

// The version in the file's name. Links have fewer numbers (libfastrtps.so.2.9) or others
// (libddsc.so.0debian).
std::optional<Version> version_of(const std::string& file, std::string_view library) {
  if (!file.starts_with(library)) return std::nullopt;
  const auto text = std::string_view(file).substr(library.size());
  return std::ranges::count(text, '.') == 2 ? version_from(text) : std::nullopt;
}

void add_if_folder(const fs::path& path, std::vector<fs::path>& out) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) out.push_back(path);
}

}  // namespace

std::vector<fs::path> library_folders(std::string_view library_path) {
  std::vector<fs::path> out;
  while (!library_path.empty()) {
    const auto part = library_path.substr(0, library_path.find(':'));
    if (!part.empty()) add_if_folder(part, out);
    library_path.remove_prefix(std::min(part.size() + 1, library_path.size()));
  }
  for (const auto* system : {"/usr/local/lib", "/usr/lib", "/usr/lib64"}) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(system, error))
      if (entry.path().filename().string().ends_with("-linux-gnu"))
        add_if_folder(entry.path(), out);
    add_if_folder(system, out);
  }
  return out;
}

std::optional<Version> installed_version(Product product, const std::vector<fs::path>& folders) {
  if (product == Product::ddssec) return std::nullopt;
  std::optional<Version> out;
  for (const auto& folder : folders) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const auto file = entry.path().filename().string();
      const auto look = [&](std::string_view library) {
        out = std::max(out, version_of(file, library));
      };
      if (product == Product::cyclonedds) std::ranges::for_each(kCycloneDds, look);
      if (product == Product::fastdds) std::ranges::for_each(kFastDds, look);
    }
    if (out) return out;
  }
  return out;
}

}  // namespace ddssec::governance::doctor
