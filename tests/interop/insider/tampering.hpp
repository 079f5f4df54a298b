// The changes that the insider makes to its messages before they are encrypted. The names of the
// tamperings are explained in insider.cpp.
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"

namespace insider {

using Bytes = std::vector<DDS_Security_octet>;

/// True if INSIDER_TAMPER names `what`.
bool tampers(std::string_view what);
/// Reports the tampering on stderr, once.
void say_tampered();

std::string hex_of(const DDS_Security_octet* prefix);
void say_prefix(const char* whose, const DDS_Security_octet* prefix);

/// The victim's GUID prefix, once the victim was met.
class Victim {
 public:
  void meet(const DDS_Security_octet* prefix);
  /// Returns the prefix; empty before the victim was met.
  Bytes prefix();

 private:
  std::mutex mutex_;
  Bytes prefix_;
};
extern Victim victim;
extern DDS_Security_octet own_prefix[12];

/// True if it is a DATA of that writer of the insider.
bool is_of_writer(const Bytes& octets, std::uint32_t writer);

/// Changes one submessage of a writer of the insider.
void tamper_with_submessage(Bytes& octets);
/// Returns what is sent instead of an announcement if fragments are spliced.
std::vector<Bytes> spliced(const Bytes& announcement);
/// Changes a whole RTPS message, once the victim was met. The victim's prefix is `prefix`.
void tamper_with_message(Bytes& octets, const Bytes& prefix);

}  // namespace insider
