// Files of passphrases are read or refused. No two have the same id, and no error contains a part
// of one.
#include <algorithm>
#include <cstdlib>
#include <set>

#include "plugins/cryptography/passphrase.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::cryptography;

// This is too long to appear in a sentence by chance.
constexpr std::string_view kSecret = "xyzzy-plugh";

void check(const Result<std::vector<Passphrase>>& all) {
  if (!all) {
    if (all.error().to_sentence().find(kSecret) != std::string::npos) std::abort();
    return;
  }
  std::set<std::uint32_t> ids;
  for (const auto& passphrase : *all)
    if (!ids.insert(passphrase.id).second || (passphrase.id & 0xff) == 0xff) std::abort();
  if (all->empty() || all->size() > kMaxExtraPassphrases + 1) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace property = spi::property;
  const std::string text = "data:," + std::string(as_text(BytesView(data, size)));
  test::RecordedEvents events;
  const auto load = [&](std::string own, std::string extra) {
    return PassphraseFiles({{std::string(property::kPskPassphrase), std::move(own)},
                            {std::string(property::kPskExtraPassphrases), std::move(extra)}},
                           {})
        .load(events);
  };
  check(load(text, ""));
  check(load("data:,1:" + std::string(kSecret), text));
  return 0;
}
