// TypeInformation (DDS-XTypes 7.6.3.2.2) of types that do not exist: types by number, and those
// that they need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

inline void append_word(std::vector<std::uint8_t>& out, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8)
    out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Appends a TypeIdentifierWithSize: a hash of that kind, made from `number`.
inline void append_identifier(std::vector<std::uint8_t>& out, std::uint8_t kind,
                              std::size_t number) {
  append_word(out, 20);
  out.push_back(kind);
  out.resize(out.size() + 13, 0x5a);
  out.push_back(static_cast<std::uint8_t>(number));
  out.push_back(static_cast<std::uint8_t>(number >> 8));
  append_word(out, 77);
}

/// Appends one half of TypeInformation (XCDR2, mutable): a type, and the types on which it depends.
inline void append_half(std::vector<std::uint8_t>& out, bool is_complete, std::size_t type,
                        const std::vector<std::size_t>& needs) {
  const std::uint8_t kind = is_complete ? 0xf2 : 0xf1;
  const auto list = 4 + needs.size() * 24, body = 24 + 4 + 4 + list;
  append_word(out, is_complete ? 0x40001002 : 0x40001001);
  append_word(out, body + 4);
  append_word(out, body);
  append_identifier(out, kind, type);
  append_word(out, needs.size());
  append_word(out, list);
  append_word(out, needs.size());
  for (const auto one : needs) append_identifier(out, kind, one);
}

inline std::vector<std::uint8_t> type_that_needs(std::size_t type,
                                                 const std::vector<std::size_t>& needs) {
  std::vector<std::uint8_t> out;
  append_word(out, 2 * (4 + 4 + 4 + 24 + 4 + 4 + 4 + needs.size() * 24));
  for (const bool is_complete : {false, true}) append_half(out, is_complete, type, needs);
  return out;
}
