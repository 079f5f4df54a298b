// The terms in which comparisons of documents are reported.
#pragma once

#include <cstdint>
#include <string_view>

namespace ddssec::governance {

/// The meaning of one difference between documents.
enum class ChangeClass : std::uint8_t {
  neutral,
  interop,   ///< no difference for ddssec, perhaps one for other products
  stronger,  ///< governance: better protected
  narrower,  ///< less is allowed
  wider,     ///< more is allowed
  weaker,    ///< governance: less protected
  mixed,     ///< some of both
  unknown,   ///< the meaning could not be determined
};
std::string_view to_string(ChangeClass change);

/// Combines classes; wider counts as down, narrower as up.
class CombinedChange {
 public:
  void add(ChangeClass change);
  void add(const CombinedChange& other) {
    loses_ |= other.loses_, gains_ |= other.gains_, is_unknown_ |= other.is_unknown_;
  }
  bool down() const { return loses_; }
  bool up() const { return gains_; }
  bool unknown() const { return is_unknown_; }
  /// neutral, `if_up`, `if_down`, mixed (also if more is unknown), or unknown.
  ChangeClass change_class(ChangeClass if_up, ChangeClass if_down) const;

 private:
  bool loses_ = false, gains_ = false, is_unknown_ = false;
};

}  // namespace ddssec::governance
