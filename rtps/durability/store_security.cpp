#include "rtps/durability/store_security.hpp"

#include <string>

#include "base/bytes.hpp"

namespace ddssec::rtps {
namespace {

std::string_view security_word(bool is_secured) {
  return is_secured ? "with security" : "without security";
}

}  // namespace

Status check_store_security(DurableStore& store, bool is_secured, Time now) {
  const Moment moment{.wall = now};
  DDSSEC_ASSIGN_OR_RETURN(const bool is_empty, store.is_empty());
  DDSSEC_ASSIGN_OR_RETURN(const auto opened,
                          store.open_stream({.topic = "", .type = "security"}, {}, moment));
  std::string_view found = security_word(is_empty ? is_secured : true);
  if (!opened.history.empty()) found = as_text(opened.history.back().payload.view());
  const auto wanted = security_word(is_secured);
  if (found != wanted)
    return fail(Code::rtps_store_unusable,
                {.document = store.path(),
                 .expected = "samples that were kept " + std::string(wanted),
                 .found = "samples that were kept " + std::string(found),
                 .hint = "start as before (--security FOLDER, or not), or name another store"});
  if (!opened.history.empty()) return {};
  Change mark;
  mark.payload = Payload::copy_of(as_bytes(wanted));
  store.append(opened.id, mark, moment);
  return {};
}

}  // namespace ddssec::rtps
