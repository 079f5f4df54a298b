// Twenty lines that use the installed package. They ask the authentication plugin for an identity
// that is not configured, and print why it refuses.
#include <cstdio>

#include "base/clock.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"

struct Quiet : ddssec::EventSink {
  void raise(const ddssec::Event&) override {}
};

int main() {
  ddssec::SystemClock clock;
  ddssec::SystemRandom random;
  Quiet quiet;
  const ddssec::PluginServices services{clock, random, quiet};
  const auto authentication = ddssec::authentication::make_authentication(services);
  const auto access_control = ddssec::access_control::make_access_control(services);
  const auto cryptography = ddssec::cryptography::make_cryptography(services);
  const auto identity = authentication->validate_local_identity(0, {}, {});
  if (identity) return 1;
  std::puts(identity.error().to_sentence().c_str());
  return identity.error().code() == ddssec::Code::missing_property ? 0 : 2;
}
