// Parameter lists, made of octets.
#pragma once

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps::parameters {

using namespace std::chrono_literals;

inline Bytes list(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const auto& part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

}  // namespace ddssec::rtps::parameters
