#include "cli/ca/ca_rotation.hpp"

#include <algorithm>

#include "cli/ca/participant_drafts.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {

pki::Validity validity_like(const pki::Certificate& old, WallTime now) {
  return {now - kBackdated, now + (old.not_after() - old.not_before())};
}

Result<pki::Authority> new_root(const pki::Certificate& old, const std::string& subject,
                                const Context& context) {
  const auto key = old.key_algorithm();
  return pki::Authority::create_root(subject, {key.kind, key.bits},
                                     validity_like(old, context.clock.calendar_seconds()),
                                     context.random);
}

Result<std::vector<WrittenFile>> put_in_place(FileTransaction& out, RotationResult& rotation) {
  DDSSEC_ASSIGN_OR_RETURN(auto files, out.commit());
  for (const auto& [name, error] : out.failures()) {
    std::erase(rotation.updated, name);
    rotation.unwritten.push_back(with_unwritten_hint(error, rotation.unwritten_hint));
  }
  return files;
}

void add_unreached(const RotationResult& rotation, Report& report) {
  for (const auto& error : rotation.doubtful) report.errors.push_back(error);
  if (!rotation.doubtful.empty()) report.exit = Exit::no;
  for (const auto& error : rotation.unwritten) {
    report.errors.push_back(error);
    report.exit = std::max(report.exit, exit_of(error.code()));
  }
}

}  // namespace ddssec::cli
