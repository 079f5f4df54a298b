// What the insider changes in its messages before they are encrypted. The names of the tamperings
// are explained in insider.cpp.
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"

namespace insider {

using Bytes = std::vector<DDS_Security_octet>;

/// Does INSIDER_TAMPER name `what`?
bool tampers(std::string_view what);
/// Says so on stderr, once.
void say_tampered();

std::string hex_of(const DDS_Security_octet* prefix);
void say_prefix(const char* whose, const DDS_Security_octet* prefix);

/// The victim's GUID prefix, once it was met.
class Victim {
 public:
  void meet(const DDS_Security_octet* prefix);
  /// Empty before.
  Bytes prefix();

 private:
  std::mutex mutex_;
  Bytes prefix_;
};
extern Victim victim;
extern DDS_Security_octet own_prefix[12];

/// Is it a DATA of that writer of the insider's?
bool is_of_writer(const Bytes& octets, std::uint32_t writer);

/// One submessage of a writer of the insider's.
void tamper_with_submessage(Bytes& octets);
/// What goes out instead of an announcement where fragments are spliced.
std::vector<Bytes> spliced(const Bytes& announcement);
/// A whole RTPS message, once the victim was met, whose prefix is `prefix`.
void tamper_with_message(Bytes& octets, const Bytes& prefix);

}  // namespace insider
