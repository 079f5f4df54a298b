#include "base/renewal_refusals.hpp"

namespace ddssec {

Error renewal_refused(Code code, const Error& why, const std::string& path,
                      std::string_view stays) {
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
