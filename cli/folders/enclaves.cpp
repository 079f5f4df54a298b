#include "cli/folders/enclaves.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/frame/suggestions.hpp"
#include "cli/inputs/files.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

bool is_token(std::string_view token) {
  const auto is_letter = [](char c) {
    return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_';
  };
  return !token.empty() && is_letter(token[0]) &&
         std::ranges::all_of(token, [&](char c) { return is_letter(c) || ('0' <= c && c <= '9'); });
}

// Searches for enclaves folder by folder, so that an unreadable folder hides no other one.
class EnclaveSearch {
 public:
  explicit EnclaveSearch(fs::path root) : root_(std::move(root)) {}

  Enclaves run() {
    search_folder(root_, 0);
    std::ranges::sort(out_.names);
    std::ranges::sort(out_.without_key);
    std::ranges::sort(out_.empty);
    return std::move(out_);
  }

 private:
  // The contents of one folder.
  struct Content {
    bool has_key = false, has_other_file = false, is_empty = true;
    std::vector<fs::path> folders = {}, links = {};
  };

  void search_folder(const fs::path& folder, int depth) {
    if (out_.names.size() >= kMaxEnclaves) return;
    std::error_code error;
    auto content = content_of(folder, error);
    // It is no error if the folder is gone, because another user may remove it at any time.
    if (error && error != std::errc::no_such_file_or_directory) leave_out(folder, error.message());
    if (content.has_key || content.has_other_file) add(folder, content.has_key);
    if (content.is_empty && !error && depth > 0) out_.empty.push_back(name_of(folder));
    for (const auto& link : content.links) leave_out(link, "a link to a folder is not followed");
    if (depth == kMaxEnclaveDepth && !content.folders.empty())
      return leave_out(folder, fmt::format("there are folders deeper than {}", kMaxEnclaveDepth));
    std::ranges::sort(content.folders);
    for (const auto& inner : content.folders) search_folder(inner, depth + 1);
  }

  // The entries that were read before an error are kept.
  static Content content_of(const fs::path& folder, std::error_code& error) {
    Content out;
    fs::directory_iterator at(folder, error);
    for (; !error && at != fs::directory_iterator(); at.increment(error)) {
      const auto name = at->path().filename().string();
      std::error_code ignored;
      out.is_empty = false;
      // The name of an enclave never begins with a dot; unfinished folders of killed commands do.
      if (name.starts_with('.')) continue;
      if (name == "key.pem" || name == "key.p11") out.has_key = true;
      if (name == "cert.pem" || name == "permissions.p7s") out.has_other_file = true;
      if (at->is_symlink(ignored) && at->is_directory(ignored)) out.links.push_back(at->path());
      if (!at->is_symlink(ignored) && at->is_directory(ignored)) out.folders.push_back(at->path());
    }
    return out;
  }

  std::string name_of(const fs::path& folder) const {
    const auto below = folder.lexically_relative(root_).generic_string();
    return below == "." ? "/" : "/" + below;
  }

  void add(const fs::path& folder, bool has_key) {
    const auto name = name_of(folder);
    out_.names.push_back(name);
    if (!has_key) out_.without_key.push_back(name);
    if (out_.names.size() == kMaxEnclaves)
      leave_out(root_, fmt::format("there are {} enclaves or more", kMaxEnclaves));
  }

  void leave_out(const fs::path& folder, std::string why) {
    out_.unseen.emplace_back(tool_code::keystore_unseen,
                             ErrorDetails{.document = folder.string(), .note = std::move(why)});
  }

  fs::path root_;
  Enclaves out_;
};

}  // namespace

Status check_enclave(std::string_view name) {
  constexpr std::size_t kMaxOctets = 255;
  const auto wrong = [&] {
    return fail(Code::enclave_name_unusable,
                {.found = '"' + std::string(name.substr(0, kMaxOctets)) + '"'});
  };
  if (name == "/") return {};
  if (name.size() > kMaxOctets || !name.starts_with('/')) return wrong();
  int depth = 0;
  for (auto rest = name.substr(1);;) {
    const auto slash = std::min(rest.find('/'), rest.size());
    if (!is_token(rest.substr(0, slash)) || ++depth > kMaxEnclaveDepth) return wrong();
    if (slash == rest.size()) return {};
    rest.remove_prefix(slash + 1);
  }
}

fs::path enclave_folder(std::string_view name) {
  const auto below = fs::path(name).relative_path();
  return below.empty() ? fs::path("enclaves") : "enclaves" / below;
}

Enclaves enclaves_of(const fs::path& keystore) {
  return EnclaveSearch(keystore / "enclaves").run();
}

Status check_enclave_in(const fs::path& keystore, std::string_view name) {
  const auto folder = keystore / enclave_folder(name);
  if (path_exists(folder)) return {};
  const auto meant = nearest(name, enclaves_of(keystore).names);
  return fail(
      Code::file_not_found,
      {.document = folder,
       .note = "the keystore has no such enclave",
       .hint = meant.empty() ? fmt::format("ddssec keystore list {} lists them", keystore.string())
                             : fmt::format("is {} meant?", meant)});
}

void add_unseen(const Enclaves& enclaves, Report& report) {
  for (const auto& error : enclaves.unseen) {
    report.errors.push_back(error);
    report.exit = std::max(report.exit, exit_of(error.code()));
  }
  for (const auto& name : enclaves.without_key)
    report.errors.emplace_back(tool_code::enclave_without_key, ErrorDetails{.found = name});
}

}  // namespace ddssec::cli
