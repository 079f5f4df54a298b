// The commands that get certificates or documents from a CA elsewhere. --hook reads a request
// (PKCS#10, PEM) from standard input and writes the certificate (PEM) to standard output.
// --documents-hook reads the certificate and writes a document.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/agent/agent_process.hpp"
#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// The longest answer of a hook, in octets: a certificate and its chain.
inline constexpr std::size_t kMaxHookAnswer = 64 * 1024;
/// The longest document of a hook, in octets.
inline constexpr std::size_t kMaxHookDocument = 1024 * 1024;

/// A hook from the command line.
struct Hook {
  std::vector<std::string> words;      ///< the program by its absolute path, and its arguments
  std::vector<std::string> variables;  ///< NAME=VALUE, added to those that every hook gets
  std::chrono::seconds timeout;
};

/// Reads the hook of an option, --hook or --documents-hook, with --hook-env and --hook-timeout.
/// Words are separated by blanks. Characters that mean something to a shell are refused, because no
/// shell reads the words. Error: usage.
Result<Hook> hook_of(const Arguments& arguments, const std::string& option);

/// Success if no user but this one and root can change the file of --trust. Errors: trust_unsafe,
/// file_unreadable.
Status check_trust_file(const std::filesystem::path& file);

/// The request that a hook is run for.
struct HookRequest {
  std::filesystem::path folder;  ///< of the participant, DDSSEC_FOLDER
  std::string subject;           ///< RFC 2253, DDSSEC_SUBJECT
  std::string input;             ///< what the hook reads from its standard input
  std::string wanted = {};       ///< DDSSEC_WANTED: the kind of document; empty: a certificate
  std::size_t max_answer = kMaxHookAnswer;
};

/// Runs the hook and returns what it wrote, not yet checked. The hook runs with the rights of this
/// process, in the folder "/", and with its standard error. Its only variables are PATH, LC_ALL,
/// those that HookRequest names, and those of --hook-env. Errors: hook_unsafe, hook_failed,
/// hook_too_slow, hook_too_long; interrupted.
Result<std::string> run_hook(const Hook& hook, const HookRequest& request, HeldSignals& signals);

}  // namespace ddssec::cli
