#include "base/document_watch.hpp"

#include <utility>

#include "base/rollback.hpp"
#include "base/uri_source.hpp"

namespace ddssec {

DocumentWatch::DocumentWatch(WatchedDocument what, std::chrono::seconds interval)
    : what_(std::move(what)), watch_(what_.uri, interval) {
  if (auto path = file_named_by(watch_.uri())) what_.name = *std::move(path);
}

Result<Bytes> DocumentWatch::read() const {
  return load_uri(watch_.uri(), what_.name, what_.max_octets);
}

Result<bool> DocumentWatch::poll(std::chrono::nanoseconds now, const Adopt& adopt) {
  if (!watch_.may_have_changed(now)) return false;
  Rollback again([&] { watch_.force_change(); });
  const auto file = read();
  const auto content = file ? sha256(*file) : Sha256Digest{};
  is_as_at_last_poll_ = file && last_read_ == content;
  last_read_ = file ? std::optional(content) : std::nullopt;
  Status status;
  if (!file) status = std::unexpected(file.error());
  const bool is_other = file && content != content_;
  if (is_other) status = adopt(*file);
  if (std::exchange(is_undecided_, false)) {
    refusals_.note_doubt();
    return false;
  }
  if (status) {
    if (is_other) content_ = content;
    refusals_.clear();
    again.release();
    return is_other;
  }
  if (!refusals_.note_refusal(status.error().code(), content)) return false;
  const auto& why = status.error();
  auto report = renewal_refused_error(what_.refused, why, what_.name, what_.stays);
  const bool is_about_folder = report.code() == Code::folder_unreadable;
  if (what_.gives_remedy_of_reason && why.code() != what_.refused && !is_about_folder) {
    auto details = report.details();
    details.hint = why.hint();
    report = Error(what_.refused, std::move(details));
  }
  return std::unexpected(refusals_.note(std::move(report)));
}

}  // namespace ddssec
