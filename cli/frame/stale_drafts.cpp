#include "cli/frame/stale_drafts.hpp"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <ctime>
#include <dirent.h>
#include <fcntl.h>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "cli/frame/held_folder.hpp"
#include "cli/frame/new_file.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxEntries = 10'000;
constexpr std::time_t kDay = 24 * 60 * 60;

// Returns 0 if the namespace is not known.
std::uint64_t pid_namespace() {
  struct stat status {};
  return ::stat("/proc/self/ns/pid", &status) == 0 ? status.st_ino : 0;
}

// Takes a number and the following dot from the front of `text`.
std::optional<std::uint64_t> take_number(std::string_view& text) {
  std::uint64_t out = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (error != std::errc() || end == text.data() + text.size() || *end != '.') return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
  return out;
}

// The process that made a file, by the file's name.
struct DraftProcess {
  std::uint64_t pid = 0, name_space = 0;
};

// Reads "PID.NAMESPACE." from the front of `text` and leaves the rest.
std::optional<DraftProcess> take_process(std::string_view& text) {
  const auto pid = take_number(text);
  const auto name_space = pid ? take_number(text) : std::nullopt;
  if (!name_space || *pid == 0 || *pid > std::uint64_t{std::numeric_limits<pid_t>::max()})
    return std::nullopt;
  return DraftProcess{*pid, *name_space};
}

bool is_gone(const DraftProcess& process, std::time_t modified) {
  const auto own = pid_namespace();
  if (own != 0 && process.name_space == own)
    return ::kill(static_cast<pid_t>(process.pid), 0) != 0 && errno == ESRCH;
  return modified + kDay < std::time(nullptr);
}

// The process of a draft, from the text after the target's name and a dot.
std::optional<DraftProcess> process_of_draft(std::string_view rest) {
  const auto process = take_process(rest);
  if (!process) return std::nullopt;
  if (rest != "new" && (!take_number(rest) || rest != "new")) return std::nullopt;
  return process;
}

std::optional<DraftProcess> process_of_folder(std::string_view rest) {
  const auto process = take_process(rest);
  constexpr std::size_t kRandomLetters = 6;  // as NewFolder makes them
  const bool is_ours = process && rest.size() == kRandomLetters && rest.find('.') == rest.npos;
  return is_ours ? process : std::nullopt;
}

// True if a leftover belongs to this user, and its process has ended.
bool may_go(const struct stat& status, const DraftProcess& process) {
  return status.st_uid == ::geteuid() && is_gone(process, status.st_mtime);
}

bool may_go(const fs::path& file, const DraftProcess& process) {
  struct stat status {};
  return ::lstat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && may_go(status, process);
}

// The folder that is checked is the one that is emptied, even if its name leads elsewhere
// meanwhile.
void remove_leftover(int parent, const char* name, const DraftProcess& process) {
  const auto folder = open_folder_in(parent, name);
  struct stat status {};
  if (!folder || ::fstat(folder.number(), &status) != 0 || !may_go(status, process)) return;
  remove_contents(folder.number());
  ::unlinkat(parent, name, AT_REMOVEDIR);
}

template <class Each>
void for_each_entry(const fs::path& folder, Each each) {
  std::error_code error;
  std::size_t count = 0;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    if (++count <= kMaxEntries) each(at->path());
}

}  // namespace

std::string process_mark() { return fmt::format("{}.{}", ::getpid(), pid_namespace()); }

void remove_drafts_of(std::span<const fs::path> targets) {
  std::map<fs::path, std::set<std::string>> names;
  for (const auto& target : targets)
    names[folder_of(target)].insert(target.filename().string() + '.');
  for (const auto& [folder, wanted] : names)
    for_each_entry(folder, [&](const fs::path& path) {
      const auto name = path.filename().string();
      if (!name.ends_with(".new")) return;
      for (auto end = name.rfind('.'); end != name.npos && end > 0;
           end = name.rfind('.', end - 1)) {
        if (!wanted.contains(name.substr(0, end + 1))) continue;
        const auto process = process_of_draft(std::string_view(name).substr(end + 1));
        if (process && may_go(path, *process)) ::unlink(path.c_str());
      }
    });
}

void remove_contents(int folder) {
  auto listed = open_folder_in(folder, ".");
  DIR* listing = listed ? ::fdopendir(listed.number()) : nullptr;
  if (listing == nullptr) return;
  listed.release();  // closedir() closes the descriptor
  while (const auto* entry = ::readdir(listing)) {
    const std::string_view name = entry->d_name;
    if (name == "." || name == ".." || ::unlinkat(folder, entry->d_name, 0) == 0) continue;
    if (const auto inner = open_folder_in(folder, entry->d_name)) remove_contents(inner.number());
    ::unlinkat(folder, entry->d_name, AT_REMOVEDIR);
  }
  ::closedir(listing);
}

void remove_unfinished_folders(const fs::path& target) {
  const int parent = folder_descriptor(folder_of(target));
  const auto beginning = fmt::format(".{}.", target.filename().string());
  for_each_entry(folder_of(target), [&](const fs::path& path) {
    const auto name = path.filename().string();
    if (!name.starts_with(beginning)) return;
    const auto process = process_of_folder(std::string_view(name).substr(beginning.size()));
    if (process) remove_leftover(parent, name.c_str(), *process);
  });
}

}  // namespace ddssec::cli
