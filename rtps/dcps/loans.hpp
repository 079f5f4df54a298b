// Samples that an application fills or reads in place (loans). An application moves a loan, and
// gives it back by destroying it.
#pragma once

#include <atomic>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/cdr_writer.hpp"
#include "rtps/dcps/sample_selection.hpp"

namespace ddssec::rtps {

/// Counts the loans of one writer or reader, up to a limit. Thread-safe.
class LoanCount {
 public:
  /// `lender` is "writer" or "reader", for errors.
  LoanCount(std::size_t max, const char* lender) : max_(max), lender_(lender), left_(max) {}
  /// Counts up to `wanted` loans more, and returns how many. Errors: rtps_precondition_not_met
  /// (none is left).
  Result<std::size_t> add(std::size_t wanted, const std::string& topic);
  void remove(std::size_t count) { left_ += count; }

 private:
  const std::size_t max_;
  const char* const lender_;
  std::atomic<std::size_t> left_;
};

/// One loan that was counted; the destructor ends it. The count lives as long as its tickets.
class LoanTicket {
 public:
  LoanTicket() = default;
  explicit LoanTicket(std::shared_ptr<LoanCount> count) : count_(std::move(count)) {}
  ~LoanTicket() {
    if (count_) count_->remove(1);
  }
  LoanTicket(LoanTicket&& other) noexcept = default;
  LoanTicket& operator=(LoanTicket&& other) noexcept {
    LoanTicket ended(std::move(other));
    std::swap(count_, ended.count_);
    return *this;
  }
  bool is_of(const std::shared_ptr<LoanCount>& count) const { return count_ == count; }

 private:
  std::shared_ptr<LoanCount> count_;
};

/// Ends a count of loans, except those that a collection holds.
template <class C>
class UnusedLoans {
 public:
  UnusedLoans(LoanCount& count, std::size_t counted, const C& used)
      : count_(count), counted_(counted), used_(used) {}
  ~UnusedLoans() { count_.remove(counted_ - used_.size()); }
  UnusedLoans(const UnusedLoans&) = delete;
  UnusedLoans& operator=(const UnusedLoans&) = delete;

 private:
  LoanCount& count_;
  const std::size_t counted_;
  const C& used_;
};

/// The memory of one sample, lent by AnyDataWriter::loan_octets. If it is not written, destroying
/// it gives it back. It may outlive its writer.
class OctetLoan {
 public:
  OctetLoan() = default;
  /// False after it was written, and if it was moved from.
  explicit operator bool() const { return payload_.size() > 0; }
  /// Returns the sample, with its encapsulation. Do not use the octets after they were written.
  MutableBytes octets() { return payload_.fill(); }
  /// Reduces the sample to its first `size` octets.
  void shrink(std::size_t size) { payload_.shrink(size); }
  /// Errors: rtps_precondition_not_met (it was written, or another writer than the one with `count`
  /// lent it).
  Status check(const std::shared_ptr<LoanCount>& count, const std::string& topic) const;

 private:
  friend class AnyDataWriter;
  OctetLoan(Payload payload, LoanTicket ticket)
      : payload_(std::move(payload)), ticket_(std::move(ticket)) {}

  Payload payload_;
  LoanTicket ticket_;
};

/// A sample to be filled in place and then written, lent by DataWriter::loan. If it is not written,
/// destroying it gives it back. It may outlive its writer.
template <DdsType T>
class WriterLoan {
 public:
  WriterLoan() = default;
  WriterLoan(WriterLoan&& other) noexcept
      : octets_(std::move(other.octets_)), sample_(std::exchange(other.sample_, nullptr)) {}
  WriterLoan& operator=(WriterLoan&& other) noexcept {
    octets_ = std::move(other.octets_);
    sample_ = std::exchange(other.sample_, nullptr);
    return *this;
  }
  /// False after it was written, and if it was moved from. Then there is no sample.
  explicit operator bool() const { return sample_ != nullptr; }
  /// Returns the sample. Do not use it after it was written: readers see it.
  T& operator*() const { return *sample_; }
  T* operator->() const { return sample_; }

 private:
  template <DdsType>
  friend class DataWriter;
  WriterLoan(OctetLoan octets, T* sample) : octets_(std::move(octets)), sample_(sample) {}

  OctetLoan octets_;
  T* sample_ = nullptr;
};

namespace detail {

/// The size of the payload of a flat sample.
template <FlatType T>
inline constexpr std::size_t kFlatPayload = kEncapsulationSize + (sizeof(T) + 3) / 4 * 4;

/// Writes what precedes and follows a flat sample in its payload.
template <FlatType T>
void frame_flat(MutableBytes payload) {
  std::ranges::copy(encapsulation_octets(Encapsulation::cdr, Endian::little), payload.begin());
  payload[3] = static_cast<std::uint8_t>(-sizeof(T) & 3u);
  std::ranges::fill(payload.subspan(kEncapsulationSize + sizeof(T)), std::uint8_t{0});
}

/// Returns the sample in a payload, or nullptr if it is not there as it would be in memory.
template <FlatType T>
const T* flat_view(BytesView payload) {
  const auto opened = open_payload(payload);
  if (!opened || opened->encapsulation != Encapsulation::cdr || opened->endian != Endian::little ||
      opened->body.size() < sizeof(T))
    return nullptr;
  const void* at = opened->body.data();
  if (std::bit_cast<std::uintptr_t>(at) % alignof(T) != 0) return nullptr;
  return std::launder(static_cast<const T*>(at));
}

}  // namespace detail

/// A sample of a reader, where it arrived. Destroying it gives it back. It may outlive its reader.
template <DdsType T>
class LoanedSample {
 public:
  LoanedSample(LoanedSample&& other) noexcept
      : payload_(std::move(other.payload_)),
        data_(std::exchange(other.data_, nullptr)),
        info_(other.info_),
        ticket_(std::move(other.ticket_)) {}
  LoanedSample& operator=(LoanedSample&& other) noexcept {
    payload_ = std::move(other.payload_);
    data_ = std::exchange(other.data_, nullptr);
    info_ = other.info_;
    ticket_ = std::move(other.ticket_);
    return *this;
  }
  /// False after it was moved from. Then there is no sample.
  explicit operator bool() const { return data_ != nullptr; }
  /// Only the key is meaningful if !info().valid_data.
  const T& data() const { return *data_; }
  const T& operator*() const { return *data_; }
  const T* operator->() const { return data_; }
  const SampleInfo& info() const { return info_; }

 private:
  template <DdsType>
  friend class LoanedSamples;
  LoanedSample(Payload payload, const T* data, const SampleInfo& info, LoanTicket ticket)
      : payload_(std::move(payload)), data_(data), info_(info), ticket_(std::move(ticket)) {}

  Payload payload_;
  const T* data_;
  SampleInfo info_;
  LoanTicket ticket_;
};

/// The result of a read or take without copies, for a FlatType. A sample that arrived in another
/// encoding is converted. If the collection is passed again, its samples are given back first.
template <DdsType T>
class LoanedSamples {
  static_assert(FlatType<T>,
                "loans are for FlatType only: @final, with numbers, enumerations, arrays and "
                "structs of these, without bool and without padding");

 public:
  std::size_t size() const { return held_.size(); }
  bool empty() const { return held_.empty(); }
  /// Returns a sample. If it is moved to another place, its element stays here, without a sample.
  LoanedSample<T>& operator[](std::size_t i) { return held_[i]; }
  const LoanedSample<T>& operator[](std::size_t i) const { return held_[i]; }
  /// For `for (auto& sample : samples)`.
  auto begin() { return held_.begin(); }
  auto end() { return held_.end(); }
  auto begin() const { return held_.begin(); }
  auto end() const { return held_.end(); }
  /// Gives all samples back.
  void clear() {
    held_.clear();
    raw_.clear();
  }

 private:
  template <DdsType>
  friend class DataReader;

  // Returns false if the payload cannot be deserialized as T.
  bool append(const OctetSample& raw) {
    const auto octets = raw.payload.view();
    // No encoding of T is shorter. Such samples cost no memory for a T.
    if (!raw.is_key_only && octets.size() < kEncapsulationSize + sizeof(T)) return false;
    // A longer sample, which is legal, would keep all its memory as long as the loan lives.
    const bool is_long =
        Payload::memory_for(octets.size()) > Payload::memory_for(detail::kFlatPayload<T>);
    const auto* data = raw.is_key_only || is_long ? nullptr : detail::flat_view<T>(octets);
    if (data != nullptr) return add(raw.payload, data, raw.info);
    auto converted = Payload::uninitialized(detail::kFlatPayload<T>);
    auto* const value = new (converted.fill().data() + kEncapsulationSize) T{};
    if (!(raw.is_key_only ? deserialize_key_into(octets, *value)
                          : deserialize_into(octets, *value)))
      return false;
    return add(std::move(converted), value, raw.info);
  }
  bool add(Payload payload, const T* data, const SampleInfo& info) {
    held_.push_back(LoanedSample<T>(std::move(payload), data, info, LoanTicket(loans_)));
    return true;
  }

  /// Appends what was selected. Returns what cannot be deserialized.
  std::vector<OctetSample> append_raw() {
    std::vector<OctetSample> malformed;
    held_.reserve(held_.size() + raw_.size());  // so that no ticket is lost for lack of memory
    for (const auto& raw : raw_)
      if (!append(raw)) malformed.push_back(raw);
    raw_.clear();
    return malformed;
  }
  /// Corrects the infos after samples were left out, or were found by several selections.
  void join_selections() {
    std::vector<SampleInfo*> infos;
    for (auto& sample : held_) infos.push_back(&sample.info_);
    rtps::join_selections(infos);
  }

  std::vector<LoanedSample<T>> held_;
  std::vector<OctetSample> raw_;
  std::shared_ptr<LoanCount> loans_;  ///< of the reader that fills it
};

}  // namespace ddssec::rtps
