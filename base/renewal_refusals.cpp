#include "base/renewal_refusals.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <unistd.h>

namespace ddssec {

std::string_view to_string(FileState state) {
  switch (state) {
    case FileState::current:
      return "current";
    case FileState::candidate:
      return "candidate";
    case FileState::refused:
      return "refused";
  }
  return "";
}

std::optional<Error> folder_refused(const Error& why, const std::string& path) {
  const auto slash = path.rfind('/');
  if (why.code() != Code::file_unreadable || slash == path.npos) return std::nullopt;
  const auto folder = path.substr(0, std::max<std::size_t>(slash, 1));
  if (::faccessat(AT_FDCWD, folder.c_str(), X_OK, AT_EACCESS) == 0 || errno != EACCES)
    return std::nullopt;
  return Error(Code::folder_unreadable,
               {.document = folder,
                .expected = "a folder that the user of the process can enter",
                .note = "what was read of its documents before stays in force"});
}

Error renewal_refused_error(Code code, const Error& why, const std::string& path,
                            std::string_view stays) {
  if (auto folder = folder_refused(why, path)) return *std::move(folder);
  auto details = why.details();
  details.document = path;
  if (why.code() != code) details.hint.clear();
  std::string note;
  const auto add = [&](std::string_view part) {
    if (!part.empty()) note += (note.empty() ? "" : "; ") + std::string(part);
  };
  if (why.code() != code) add(std::string(info(why.code()).summary));
  add(details.note);
  add(stays);
  details.note = std::move(note);
  return {code, std::move(details)};
}

}  // namespace ddssec
