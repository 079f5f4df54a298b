// Positions (send_position.hpp) of a remote participant's writers that protect payloads only:
// several local readers may have the key of one of them.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "plugins/cryptography/receive_key.hpp"

namespace ddssec::cryptography {

/// The positions, by key id and revision. Not thread-safe.
class PayloadPositions {
 public:
  /// Shares the position: from now on, all keys of one id and revision use the newest position of
  /// any of them.
  void share(ReceiveKey& key) {
    const auto& material = key.material();
    auto& known = positions_[{material.sender_key_id, material.kind}];
    if (const auto position = known.lock()) key.count_with(position);
    known = key.position();
    if (positions_.size() < look_at_) return;
    std::erase_if(positions_, [](const auto& one) { return one.second.expired(); });
    look_at_ = std::max(kFirstLook, 2 * positions_.size());
  }

 private:
  static constexpr std::size_t kFirstLook = 64;
  std::map<std::pair<KeyId, TransformKind>, std::weak_ptr<NewestPosition>> positions_;
  std::size_t look_at_ = kFirstLook;
};

}  // namespace ddssec::cryptography
