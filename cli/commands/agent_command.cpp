// agent: keeps participants' folders current.
#include "cli/agent/agent.hpp"
#include "cli/commands/groups.hpp"
#include "cli/frame/options.hpp"

namespace ddssec::cli {
namespace {

std::unexpected<Error> usage_error(std::string field, std::string note) {
  return fail(Code::usage, {.field = std::move(field), .note = std::move(note)});
}

Status check_options(const Arguments& arguments) {
  const bool by_ca = arguments.has("--ca");
  if (by_ca == arguments.has("--hook"))
    return usage_error("--ca",
                       "either --ca DIR or --hook COMMAND says where certificates come from");
  for (const auto* option : {"--permissions", "--days"})
    if (!by_ca && arguments.has(option)) return usage_error(option, "only with --ca");
  for (const auto* option : {"--hook-env", "--trust", "--documents-hook"})
    if (by_ca && arguments.has(option)) return usage_error(option, "only with --hook");
  for (const auto* option : {"--crl", "--expired"})
    if (arguments.has(option) && !arguments.has("--trust"))
      return usage_error(option, "only with --trust");
  if (arguments.has("--once")) return {};
  for (const auto* option : {"--now", "--dry-run"})
    if (arguments.has(option)) return usage_error(option, "only with --once");
  if (arguments.text("--format") == "json")
    return usage_error("--format", "only with --once: the agent always reports lines of JSON");
  return {};
}

Result<Answer<AgentRun>> agent(const Arguments& arguments, const Context& context) {
  DDSSEC_RETURN_IF_ERROR(check_options(arguments));
  AgentHooks hooks;
  if (arguments.has("--hook")) {
    DDSSEC_ASSIGN_OR_RETURN(hooks.certificates, hook_of(arguments, "--hook"));
  }
  if (arguments.has("--documents-hook")) {
    DDSSEC_ASSIGN_OR_RETURN(hooks.documents, hook_of(arguments, "--documents-hook"));
  }
  // Uses the real clock, because the command runs for long: the certificates of hooks begin later
  // than the command itself.
  const SystemClock clock;
  const Context present{arguments.has("--now") ? context.clock : clock, context.random};
  Agent self(arguments, std::move(hooks), present);
  return arguments.has("--once") ? self.run_once() : self.run();
}

}  // namespace

std::vector<Command> agent_commands() {
  return {
      {.group = "",
       .name = "agent",
       .summary = "Keeps participants' certificates current: renews each at two thirds of its "
                  "lifetime; reports in lines of JSON.",
       .positionals = {{"FOLDERS", "participants' folders", false, true}},
       .options = {{"--ca", "DIR", "the CA that issued the certificates, in a folder here"},
                   {"--hook", "COMMAND",
                    "a program that reads a request and writes a certificate (PEM), with its "
                    "arguments"},
                   {"--documents-hook", "COMMAND",
                    "with --hook: a program that reads the certificate and writes what "
                    "DDSSEC_WANTED names: signed permissions, crl (PEM) or renewals (PEM)"},
                   repeated("--hook-env", "NAME", "a variable that the programs get, too"),
                   {"--hook-timeout", "SECONDS", "how long a program may take", "60"},
                   {"--trust", "FILE",
                    "with --hook: renew only certificates that a CA in this file issued; required "
                    "for folders of other users"},
                   {"--crl", "FILE",
                    "with --trust: revocation lists; certificates on them are not renewed; without "
                    "it, crl.pem beside FILE of --trust, if there is one"},
                   {"--expired", "",
                    "with --trust: also renew certificates that have expired, which revocation "
                    "lists may not name any more; the hook must then refuse revoked ones"},
                   {"--once", "", "look at each folder once and end, for cron"},
                   {"--rekey", "", "with a new key each time; otherwise the key stays"},
                   {"--permissions", "",
                    "with --ca: permissions that end before the certificate are extended too"},
                   {"--days", "N",
                    "with --ca: how long a certificate is valid; otherwise as long as the last"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec agent talker listener --ca ca --permissions",
                    "ddssec agent talker --hook '/etc/ddssec/ask-the-ca plant' --once"},
       .run = agent}};
}

}  // namespace ddssec::cli
