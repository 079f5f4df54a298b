// The calls that read and take samples (DDS 1.4, 2.2.2.5.3), for any type of collection.
#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rtps/dcps/condition.hpp"
#include "rtps/dcps/reader_cache.hpp"
#include "rtps/dcps/type_support.hpp"

namespace ddssec::rtps {

/// A sample that was read or taken. The application owns it.
template <DdsType T>
struct Sample {
  T data{};  ///< only its key is meaningful if !info.valid_data
  SampleInfo info;
};

/// The result of a read or take. If it is passed again, its objects keep their memory.
template <DdsType T>
class Samples {
 public:
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  Sample<T>& operator[](std::size_t i) { return held_[i]; }
  const Sample<T>& operator[](std::size_t i) const { return held_[i]; }
  /// For `for (auto& sample : samples)`.
  auto begin() { return held_.begin(); }
  auto end() { return held_.begin() + static_cast<std::ptrdiff_t>(size_); }
  auto begin() const { return held_.begin(); }
  auto end() const { return held_.begin() + static_cast<std::ptrdiff_t>(size_); }

 private:
  template <DdsType>
  friend class DataReader;

  // Returns false if the payload cannot be deserialized as T.
  bool append(const OctetSample& raw) {
    if (size_ == held_.size()) held_.emplace_back();
    auto& sample = held_[size_];
    const auto read = raw.is_key_only ? deserialize_key_into(raw.payload.view(), sample.data)
                                      : deserialize_into(raw.payload.view(), sample.data);
    if (!read) return false;
    sample.info = raw.info;
    ++size_;
    return true;
  }

  /// Appends what was selected. Returns what cannot be deserialized.
  std::vector<OctetSample> append_raw() {
    std::vector<OctetSample> malformed;
    for (const auto& raw : raw_)
      if (!append(raw)) malformed.push_back(raw);
    raw_.clear();
    return malformed;
  }
  /// Corrects the infos after samples were left out, or were found by several selections.
  void join_selections() {
    std::vector<SampleInfo*> infos;
    for (auto& sample : *this) infos.push_back(&sample.info);
    rtps::join_selections(infos);
  }

  std::vector<Sample<T>> held_;
  std::size_t size_ = 0;
  std::vector<OctetSample> raw_;
};

/// True for one of these types.
template <class C, class... Types>
concept AnyOf = (std::same_as<C, Types> || ...);

/// The base class of readers that has these calls, for each of these types of collections. `Reader`
/// provides fill(query, samples), which replaces the contents of the collection.
///
/// All calls replace the contents of `out` and return the number of samples found: 0 if there are
/// none (NO_DATA), at most `max_samples`. Only those with a timeout wait. A read marks samples as
/// read, a take removes them from the reader. Errors: rtps_not_enabled, rtps_bad_parameter (no such
/// instance), rtps_precondition_not_met (the condition belongs to another reader, or GROUP access
/// without begin_access).
template <class Reader, class... Collections>
class SampleAccess {
 public:
  using Count = Result<std::size_t>;

  /// Selects the samples in these states, of all instances.
  template <AnyOf<Collections...> C>
  Count read(C& out, std::int32_t max_samples = kLengthUnlimited, const States& states = {}) {
    return find(out, max_samples, {.states = states});
  }
  /// As read, and removes the samples.
  template <AnyOf<Collections...> C>
  Count take(C& out, std::int32_t max_samples = kLengthUnlimited, const States& states = {}) {
    return find(out, max_samples, {.states = states, .take = true});
  }
  /// As read and take, but first wait until the reader holds samples in these states, as
  /// wait_for_samples does. The number is 0 after the timeout, and if another thread took the
  /// samples meanwhile.
  template <AnyOf<Collections...> C>
  Count read(C& out, std::chrono::nanoseconds timeout, std::int32_t max_samples = kLengthUnlimited,
             const States& states = {}) {
    wait_for_samples(static_cast<Reader&>(*this), states, timeout);
    return read(out, max_samples, states);
  }
  template <AnyOf<Collections...> C>
  Count take(C& out, std::chrono::nanoseconds timeout, std::int32_t max_samples = kLengthUnlimited,
             const States& states = {}) {
    wait_for_samples(static_cast<Reader&>(*this), states, timeout);
    return take(out, max_samples, states);
  }
  /// Selects the samples for which the condition is triggered.
  template <AnyOf<Collections...> C>
  Count read_w_condition(C& out, const ReadCondition& condition,
                         std::int32_t max_samples = kLengthUnlimited) {
    return find(out, max_samples, {}, &condition);
  }
  /// As read_w_condition, and removes the samples.
  template <AnyOf<Collections...> C>
  Count take_w_condition(C& out, const ReadCondition& condition,
                         std::int32_t max_samples = kLengthUnlimited) {
    return find(out, max_samples, {.take = true}, &condition);
  }
  /// Selects the samples of one instance.
  template <AnyOf<Collections...> C>
  Count read_instance(C& out, InstanceHandle instance, std::int32_t max_samples = kLengthUnlimited,
                      const States& states = {}) {
    return find(out, max_samples,
                {.states = states, .scope = Scope::instance, .instance = instance});
  }
  /// As read_instance, and removes the samples.
  template <AnyOf<Collections...> C>
  Count take_instance(C& out, InstanceHandle instance, std::int32_t max_samples = kLengthUnlimited,
                      const States& states = {}) {
    return find(out, max_samples,
                {.states = states, .take = true, .scope = Scope::instance, .instance = instance});
  }
  /// Selects the next instance after `previous` that has such samples; HANDLE_NIL selects the first
  /// one.
  template <AnyOf<Collections...> C>
  Count read_next_instance(C& out, InstanceHandle previous,
                           std::int32_t max_samples = kLengthUnlimited, const States& states = {}) {
    return find(out, max_samples,
                {.states = states, .scope = Scope::next_instance, .instance = previous});
  }
  /// As read_next_instance, and removes the samples.
  template <AnyOf<Collections...> C>
  Count take_next_instance(C& out, InstanceHandle previous,
                           std::int32_t max_samples = kLengthUnlimited, const States& states = {}) {
    return find(
        out, max_samples,
        {.states = states, .take = true, .scope = Scope::next_instance, .instance = previous});
  }
  /// Selects the next instance after `previous` for whose samples the condition is triggered.
  template <AnyOf<Collections...> C>
  Count read_next_instance_w_condition(C& out, InstanceHandle previous,
                                       const ReadCondition& condition,
                                       std::int32_t max_samples = kLengthUnlimited) {
    return find(out, max_samples, {.scope = Scope::next_instance, .instance = previous},
                &condition);
  }
  /// As read_next_instance_w_condition, and removes the samples.
  template <AnyOf<Collections...> C>
  Count take_next_instance_w_condition(C& out, InstanceHandle previous,
                                       const ReadCondition& condition,
                                       std::int32_t max_samples = kLengthUnlimited) {
    return find(out, max_samples,
                {.take = true, .scope = Scope::next_instance, .instance = previous}, &condition);
  }

 private:
  using Scope = SampleQuery::Scope;
  template <class C>
  Count find(C& out, std::int32_t max_samples, SampleQuery query,
             const ReadCondition* condition = nullptr) {
    auto& reader = static_cast<Reader&>(*this);
    if (max_samples != kLengthUnlimited)
      query.max_samples = static_cast<std::size_t>(std::max(max_samples, 0));
    if (condition != nullptr) {
      if (auto own = condition->check_reader(reader); !own) return std::unexpected(own.error());
      query.states = condition->states();
      query.matching = condition->query();
    }
    return reader.fill(query, out);
  }
};

}  // namespace ddssec::rtps
