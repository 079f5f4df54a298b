#include "plugins/cyclonedds/c_boundary.hpp"

#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace ddssec::cyclonedds {
namespace {

char* malloc_text(std::string_view text) noexcept {
  auto* copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (copy == nullptr) return nullptr;
  std::memcpy(copy, text.data(), text.size());
  copy[text.size()] = '\0';
  return copy;
}

}  // namespace

void fill_exception(Exception* ex, const Error& error, DDS_Security_long code) noexcept {
  if (ex == nullptr) return;
  try {
    ex->message = malloc_text(error.to_sentence());
  } catch (...) {
    ex->message = malloc_text(info(error.code()).summary);
  }
  ex->code = code;
  ex->minor_code = 0;
}

void fill_exception_of_logged(Exception* ex, const Error& error, DDS_Security_long code) noexcept {
  if (ex == nullptr) return;
  const auto& row = info(error.code());
  try {
    ex->message = malloc_text(std::string(row.summary) + " [" + std::string(row.name) +
                              "]; ddssec's own line says more ");
  } catch (...) {
    ex->message = malloc_text(row.summary);
  }
  ex->code = code;
  ex->minor_code = 0;
}

Error caught_error(const std::exception* thrown) noexcept {
  try {
    return Error(Code::internal,
                 {.note = thrown != nullptr ? thrown->what() : "something unknown was thrown"});
  } catch (...) {
    return Error(Code::internal);
  }
}

}  // namespace ddssec::cyclonedds
