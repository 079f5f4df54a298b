#include "secured/participant_check.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "pki/participant_folder.hpp"

namespace ddssec::secured {
namespace {

namespace fs = std::filesystem;

// Returns `words` followed by the participants found, for example "it holds participants:
// demo/listener, demo/talker". Empty if there are none.
std::string participants_in(const fs::path& folder, std::string words) {
  constexpr int kMaxLooks = 1'000;
  constexpr std::size_t kMaxShown = 4;
  std::vector<fs::path> found;
  std::error_code error;
  int looks = 0;
  const auto start = folder.empty() ? fs::path(".") : folder;
  for (fs::directory_iterator at(start, error), end; !error && at != end; at.increment(error)) {
    if (++looks > kMaxLooks) break;
    const auto path = folder / at->path().filename();
    if (pki::is_participant_folder(path)) found.push_back(path);
  }
  if (found.empty()) return {};
  std::ranges::sort(found);
  for (std::size_t i = 0; i < std::min(found.size(), kMaxShown); ++i)
    words += (i == 0 ? "" : ", ") + found[i].string();
  return found.size() > kMaxShown ? words + " and more" : words;
}

fs::path without_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

Status explain_unless_participant(const fs::path& given) {
  const auto folder = without_slash(given.lexically_normal());
  std::error_code error;
  if (!fs::is_directory(given, error)) {
    const auto near = participants_in(folder.parent_path(), "participants here: ");
    return fail(
        fs::exists(fs::symlink_status(given, error)) ? Code::file_unreadable : Code::file_not_found,
        {.document = given.string(),
         .expected = "a participant's folder",
         .hint = near.empty() ? "name a folder that ddssec init or identity issue made" : near});
  }
  if (pki::is_participant_folder(given)) return {};
  const auto not_found_error = [&](const char* what, std::string hint) {
    return fail(Code::file_not_found,
                {.document = pki::participant_folder(given).certificate.string(),
                 .note = given.string() + what,
                 .hint = std::move(hint)});
  };
  if (pki::is_ca_folder(given)) {
    auto near = participants_in(folder.parent_path(), "participants of it may be ");
    if (near.empty())
      near = participants_in(folder.parent_path().parent_path(), "participants of it may be ");
    return not_found_error(" is the folder of a CA", std::move(near));
  }
  if (auto inside = participants_in(folder, "it holds participants: "); !inside.empty())
    return not_found_error(" is no participant's folder", std::move(inside));
  return {};
}

}  // namespace ddssec::secured
