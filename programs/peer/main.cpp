// ddssec-peer: one end of a connection, for tests and measurements.
#include <array>

#include "programs/peer/session.hpp"

namespace {

using namespace ddssec::peer;

struct Role {
  const char* name;
  int (*run)(Session&);
};
constexpr std::array kRoles = {Role{"pub", run_pub},           Role{"sub", run_sub},
                               Role{"ping", run_ping},         Role{"pong", run_pong},
                               Role{"tput-pub", run_tput_pub}, Role{"tput-sub", run_tput_sub}};

}  // namespace

int main(int argc, char** argv) {
  const auto parsed = parse(argc, argv);
  if (!parsed.options) return parsed.exit_code;
  watch_signals();
  Session session(*parsed.options);
  if (const auto opened = session.open(); !opened) return print_refusal(opened.error());
  for (const auto& role : kRoles)
    if (parsed.options->role == role.name) return role.run(session);
  return kUsage;
}
