// Calls through the C ABI that are repeated until no allocation is left to fail.
#pragma once

#include <cstdlib>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "base/code.hpp"
#include "plugins/cyclonedds/abi.hpp"
#include "tests/support/failing_memory.hpp"

namespace ddssec::driver {

namespace memory = failing_memory;
using cyclonedds::Exception;
using memory::Extent;
using memory::Source;

/// The allocations that fail. Without a plan none fails.
struct Plan {
  Source source;
  Extent extent;
};

/// Repeats each call, with its first allocation failing, then with its second, and so on, until no
/// allocation is left to fail.
class Caller {
 public:
  /// A call of the C ABI. It returns true for success.
  using Call = std::function<bool(Exception*)>;
  using Undo = std::function<void()>;

  explicit Caller(std::optional<Plan> plan) : plan_(plan) {}

  /// An allocation that belongs to a notice (an informational event) may fail although the call
  /// succeeds.
  static constexpr long kMaxAllocationsOfNotices = 32;

  /// OpenSSL can do without some of its allocations. `undo` takes such a success back.
  void operator()(const std::string& name, const Call& call, const Undo& undo) {
    SCOPED_TRACE(name);
    long done_without = 0;
    for (long number = 1;; number += stride(number)) {
      Exception ex{};
      if (plan_) memory::fail_at(plan_->source, plan_->extent, number);
      const bool succeeded = call(&ex);
      const bool wanted_more = memory::stop_failing();
      const std::string message = ex.message != nullptr ? ex.message : "";
      std::free(ex.message);
      if (!wanted_more) {
        if (!succeeded) throw std::runtime_error(name + " is refused for good: " + message);
        return;
      }
      ++failed_;
      if (!succeeded) {
        EXPECT_TRUE(is_a_reason(static_cast<Code>(ex.code)))
            << "allocation " << number << ": " << ex.code << " " << message;
        continue;
      }
      if (plan_->source != Source::c) {
        EXPECT_LE(++done_without, kMaxAllocationsOfNotices)
            << "can do without allocation " << number;
      }
      undo();
    }
  }

  /// Returns how many calls failed for lack of memory.
  long failed() const { return failed_; }

 private:
  bool is_a_reason(Code code) const {
    return code == Code::out_of_memory || (plan_->source == Source::c && code != Code{});
  }
  /// The numbers grow faster and faster, because reading documents takes thousands of similar
  /// allocations.
  static long stride(long number) { return 1 + number / 64; }

  std::optional<Plan> plan_;
  long failed_ = 0;
};

}  // namespace ddssec::driver
