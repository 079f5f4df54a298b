#include "governance/doctor/loader_subfolders.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <link.h>
#include <memory>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

// This folder need not exist: the loader lists its subfolders before it looks for them.
constexpr std::string_view kProbe = "/ddssec-asks-which-folders-are-searched";
constexpr std::string_view kSearch = "search path=";
constexpr std::size_t kMaxLine = 64 * 1024;

// Notes PT_INTERP of this program, which is the first object; nothing if it has none.
int note_interpreter(dl_phdr_info* info, std::size_t, void* out) {
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& segment = info->dlpi_phdr[i];
    if (segment.p_type == PT_INTERP)
      *static_cast<std::string*>(out) =
          std::bit_cast<const char*>(std::uintptr_t{info->dlpi_addr} + segment.p_vaddr);
  }
  return 1;
}

std::string interpreter() {
  std::string out;
  ::dl_iterate_phdr(&note_interpreter, &out);
  return out;
}

// The environment of this process, without other variables that the loader obeys.
std::vector<std::string> environment_of_question() {
  std::vector<std::string> out{"LD_DEBUG=libs", "LD_LIBRARY_PATH=" + std::string(kProbe)};
  for (char** one = environ; one != nullptr && *one != nullptr; ++one)
    if (!std::string_view(*one).starts_with("LD_")) out.emplace_back(*one);
  return out;
}

// Starts the loader with its standard error at `to`. Returns 0 if it does not start.
pid_t start_loader(const std::string& loader, const std::string& program, int to) {
  std::vector<std::string> words{loader, "--list", program};
  auto environment = environment_of_question();
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, to, STDERR_FILENO);
  pid_t child = 0;
  const auto error =
      ::posix_spawn(&child, loader.c_str(), &actions, nullptr, argument_pointers(words).data(),
                    argument_pointers(environment).data());
  ::posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? child : 0;
}

std::vector<std::string> answer_from(int descriptor) {
  const std::unique_ptr<FILE, int (*)(FILE*)> stream(::fdopen(descriptor, "r"), &std::fclose);
  if (!stream) return {};
  std::string line(kMaxLine, '\0');
  while (std::fgets(line.data(), static_cast<int>(line.size()), stream.get()) != nullptr)
    if (auto found = subfolders_in(line.c_str(), kProbe); !found.empty()) return found;
  return {};
}

std::vector<std::string> ask_loader() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto loader = interpreter();
  std::array<int, 2> ends{};
  if (error || loader.empty() || ::pipe2(ends.data(), O_CLOEXEC) != 0) return {};
  const auto child = start_loader(loader, program.string(), ends[1]);
  ::close(ends[1]);
  auto out = answer_from(ends[0]);  // also closes the pipe, so that the loader ends
  if (child != 0) ::waitpid(child, nullptr, 0);
  return out;
}

}  // namespace

const std::vector<std::string>& loader_subfolders() {
  static const auto subfolders = ask_loader();
  return subfolders;
}

std::vector<std::string> subfolders_in(std::string_view line, std::string_view folder) {
  const auto at = line.find(kSearch);
  if (at == line.npos) return {};
  auto list = line.substr(at + kSearch.size());
  list = list.substr(0, list.find_first_of("\t\n"));
  std::vector<std::string> out;
  while (!list.empty()) {
    const auto one = list.substr(0, list.find(':'));
    list.remove_prefix(std::min(one.size() + 1, list.size()));
    if (one.starts_with(folder) && one.size() > folder.size() + 1)
      out.emplace_back(one.substr(folder.size() + 1));
  }
  return out;
}

}  // namespace ddssec::governance::doctor
