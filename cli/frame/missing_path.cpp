#include "cli/frame/missing_path.hpp"

#include <vector>

#include <fmt/format.h>

#include "cli/frame/suggestions.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

}  // namespace

fs::path without_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

std::string missing_path_hint(const fs::path& missing) {
  constexpr std::size_t kMaxNames = 1'000;  // the number of names that are compared
  const auto plain = without_slash(missing);
  const auto folder = plain.has_parent_path() ? plain.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::exists(folder, error))
    return fmt::format("the folder {} does not exist", folder.string());
  if (fs::is_symlink(plain, error))
    return fmt::format("it is a link to {}, which does not exist",
                       fs::read_symlink(plain, error).string());
  const auto own = plain.filename().string();
  std::vector<std::string> names;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (names.size() == kMaxNames) break;
    if (auto name = at->path().filename().string(); name != own) names.push_back(std::move(name));
  }
  const auto name = nearest(own, names);
  if (name.empty()) return {};
  return fmt::format("is {} meant?", (plain.parent_path() / name).string());
}

}  // namespace ddssec::cli
