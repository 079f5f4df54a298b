// Key material: wiped at destruction, compared in constant time, never printed.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "base/bytes.hpp"
#include "base/hash.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Up to N secret octets (for example 16 for AES-128 in a type for 32). `Tag` makes each kind a
/// distinct type. Move-only; moving wipes the source. `expose` is the only access to the octets, so
/// a search for it finds every use.
template <class Tag, std::size_t N>
class Secret {
 public:
  static constexpr std::size_t capacity = N;

  Secret() = default;
  ~Secret() { wipe(octets_); }
  Secret(Secret&& other) noexcept : octets_(other.octets_), size_(other.size_) { other.clear(); }
  Secret& operator=(Secret&& other) noexcept {
    if (this != &other) {
      octets_ = other.octets_;
      size_ = other.size_;
      other.clear();
    }
    return *this;
  }
  Secret(const Secret&) = delete;
  Secret& operator=(const Secret&) = delete;

  /// Makes a secret of `size` octets that `fill_octets(MutableBytes) -> Status` writes in place.
  /// Errors: length_out_of_range (more than N), those of `fill_octets`.
  template <class Fill>
  static Result<Secret> fill(std::size_t size, Fill&& fill_octets) {
    if (size > N) return fail(Code::length_out_of_range);
    Secret secret;
    secret.size_ = size;
    Status status = std::forward<Fill>(fill_octets)(MutableBytes(secret.octets_).first(size));
    if (!status) return std::unexpected(std::move(status).error());
    return secret;
  }

  /// Copies octets, which the caller must wipe. Error: length_out_of_range.
  static Result<Secret> copy_of(BytesView octets) {
    return fill(octets.size(), [&](MutableBytes out) -> Status {
      std::copy(octets.begin(), octets.end(), out.begin());
      return {};
    });
  }

  /// Returns SHA-256 of secret octets, written in place so that no other copy exists.
  static Secret digest_of(BytesView octets) requires(N >= 32) {
    Secret secret;
    secret.size_ = 32;
    sha256({octets}, MutableBytes(secret.octets_).template first<32>());
    return secret;
  }

  /// Returns a copy, which is wiped independently of this secret.
  Secret clone() const {
    Secret copy;
    copy.octets_ = octets_;
    copy.size_ = size_;
    return copy;
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  /// Calls `f(BytesView)` and returns its result. The view must not outlive the call.
  template <class F>
  decltype(auto) expose(F&& f) const {
    return std::forward<F>(f)(BytesView(octets_).first(size_));
  }

  bool operator==(const Secret& other) const noexcept {
    return size_ == other.size_ && constant_time_equal(octets_, other.octets_);
  }

 private:
  void clear() noexcept {
    wipe(octets_);
    size_ = 0;
  }

  std::array<std::uint8_t, N> octets_{};
  std::size_t size_ = 0;
};

}  // namespace ddssec
