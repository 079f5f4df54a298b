// PRESENTATION of one DataReader (DDS 1.4, 2.2.3.6): what stands between the protocol and its
// samples. No I/O, clock or lock.
#pragma once

#include "rtps/dcps/presenter.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// Nothing stands between them unless access is coherent or has GROUP scope: then a Presenter, of
/// the reader alone or of its subscriber.
class ReaderPresentation {
 public:
  /// `reader` gets what is presented, and outlives this.
  explicit ReaderPresentation(PresentedReader& reader) : reader_(reader) {}

  /// The reader is enabled. `of_group`: the subscriber's, for GROUP scope; nullptr: not needed.
  /// `paused`: the subscriber is between begin_access and end_access.
  void start(const Presentation& policy, Presenter* of_group, bool paused, MonotonicTime now);
  /// Nothing that is held of this reader is presented any more.
  void stop(MonotonicTime now);
  /// False: changes go to the reader's samples at once.
  bool holds_back() const { return presenter_ != nullptr; }

  // Nothing unless it holds back:
  void add_writer(const Guid& writer, const std::optional<Guid>& group, const GuidPrefix& identity);
  void remove_writer(const Guid& writer, MonotonicTime now);
  void on_group(const Guid& writer, SequenceNumber group, MonotonicTime now);
  void release(MonotonicTime now);
  /// Of the reader's own Presenter; the subscriber's is paused by the subscriber.
  void pause(bool paused, MonotonicTime now);
  /// kNever unless it holds back.
  MonotonicTime next_tick() const;

  /// Only if it holds back. False: refused for now.
  bool on_change(Change& change, MonotonicTime now) {
    return presenter_->on_change(reader_, change, now);
  }

 private:
  PresentedReader& reader_;
  Presenter* presenter_ = nullptr;
  std::unique_ptr<Presenter> own_;
};

}  // namespace ddssec::rtps
