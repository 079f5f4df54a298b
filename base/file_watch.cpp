#include "base/file_watch.hpp"

#include <algorithm>
#include <sys/stat.h>

#include "base/uri_source.hpp"

namespace ddssec {

FileWatch::FileWatch(std::string_view uri, std::chrono::nanoseconds interval)
    : uri_(absolute_uri(uri)),
      path_(interval.count() > 0 ? file_named_by(uri_).value_or("") : ""),
      interval_(interval),
      last_(stamp()) {}

bool FileWatch::may_have_changed(std::chrono::nanoseconds now) {
  const auto shortest = interval_ - std::min(interval_ / 8, kMaxSlack);
  if (path_.empty() || (last_query_ && now - *last_query_ < shortest)) return false;
  last_query_ = now;
  const auto current = stamp();
  const bool same = current == last_;
  if (same && is_settled_) return false;
  is_settled_ = same;
  last_ = current;
  return true;
}

std::optional<FileWatch::Stamp> FileWatch::stamp() const {
  struct stat status {};
  if (path_.empty() || ::stat(path_.c_str(), &status) != 0) return std::nullopt;
  const auto number = [](auto value) { return static_cast<std::uint64_t>(value); };
  return Stamp{number(status.st_dev),          number(status.st_ino),
               number(status.st_size),         number(status.st_mtim.tv_sec),
               number(status.st_mtim.tv_nsec), number(status.st_ctim.tv_sec),
               number(status.st_ctim.tv_nsec)};
}

}  // namespace ddssec
