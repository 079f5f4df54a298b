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

/// Combines the classes of several changes into one. down() says that something is less protected,
/// or allowed to more participants (weaker, wider), and up() the reverse.
class CombinedChange {
 public:
  void add(ChangeClass change);
  void add(const CombinedChange& other) {
    loses_ |= other.loses_, gains_ |= other.gains_, is_unknown_ |= other.is_unknown_;
  }
  bool down() const { return loses_; }
  bool up() const { return gains_; }
  bool unknown() const { return is_unknown_; }
  /// Returns `if_up` or `if_down` if all changes go one way, mixed if they go both ways, neutral if
  /// there are none, and unknown if a class is unknown and the others are not mixed.
  ChangeClass change_class(ChangeClass if_up, ChangeClass if_down) const;

 private:
  bool loses_ = false, gains_ = false, is_unknown_ = false;
};

}  // namespace ddssec::governance
