#include "plugins/access_control/permissions_watch.hpp"

#include "base/rollback.hpp"
#include "pki/source.hpp"

namespace ddssec::access_control {

PermissionsWatch::PermissionsWatch(std::string uri, std::string name, std::chrono::seconds interval)
    : uri_(std::move(uri)), name_(std::move(name)), watch_(uri_, interval) {}

Result<bool> PermissionsWatch::look(std::chrono::nanoseconds now, const Take& take) {
  if (!watch_.may_have_changed(now)) return false;
  Rollback again([&] { watch_.look_again(); });
  const auto file = pki::load(uri_, name_, pki::kMostSentPermissionsOctets);
  const auto content = file ? sha256(*file) : Sha256Digest{};
  Status status;
  if (!file) status = std::unexpected(file.error());
  const bool is_other = file && content != content_;
  if (is_other) status = take(*file);
  if (status) {
    if (is_other) content_ = content;
    refusals_.clear();
    again.release();
    return is_other;
  }
  if (!refusals_.is_due(status.error().code(), content)) return false;
  return std::unexpected(spi::renewal_refused(Code::permissions_renewal_refused, status.error(),
                                              name_, "the permissions read before stay in force"));
}

}  // namespace ddssec::access_control
