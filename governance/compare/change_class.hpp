// The terms in which comparisons of documents are reported.
#pragma once

#include <cstdint>
#include <string_view>

namespace ddssec::governance {

/// The meaning of one difference between documents.
enum class ChangeClass : std::uint8_t {
  neutral,
  interop,   ///< the same for ddssec, perhaps not for other products
  stronger,  ///< governance: better protected
  narrower,  ///< less is allowed
  wider,     ///< more is allowed
  weaker,    ///< governance: less protected
  mixed,     ///< some of both
  unknown,   ///< it could not be determined
};
std::string_view to_string(ChangeClass change);

/// Combines classes; wider counts as down, narrower as up.
class CombinedChange {
 public:
  void add(ChangeClass change);
  void add(const CombinedChange& other) {
    down_ |= other.down_, up_ |= other.up_, unknown_ |= other.unknown_;
  }
  bool down() const { return down_; }
  bool up() const { return up_; }
  bool unknown() const { return unknown_; }
  /// neutral, `if_up`, `if_down`, mixed (also if more is unknown), or unknown.
  ChangeClass change_class(ChangeClass if_up, ChangeClass if_down) const;

 private:
  bool down_ = false, up_ = false, unknown_ = false;
};

}  // namespace ddssec::governance
