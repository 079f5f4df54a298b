#include "plugins/authentication/transcript.hpp"

#include <array>

#include "plugins/authentication/token_fields.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

Bytes Transcript::reply_input() const {
  const std::array<spi::NamedOctets, 6> fields = {{{kHashC2, hash_c2},
                                                   {kChallenge2, challenge2},
                                                   {kDh2.name, dh2},
                                                   {kChallenge1, challenge1},
                                                   {kDh1.name, dh1},
                                                   {kHashC1, hash_c1}}};
  return spi::serialize_binary_properties(fields);
}

Bytes Transcript::final_input() const {
  const std::array<spi::NamedOctets, 6> fields = {{{kHashC1, hash_c1},
                                                   {kChallenge1, challenge1},
                                                   {kDh1.name, dh1},
                                                   {kChallenge2, challenge2},
                                                   {kDh2.name, dh2},
                                                   {kHashC2, hash_c2}}};
  return spi::serialize_binary_properties(fields);
}

}  // namespace ddssec::authentication
