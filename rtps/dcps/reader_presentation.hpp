// PRESENTATION of one DataReader (DDS 1.4, 2.2.3.6), between the protocol and the reader's samples.
// No I/O, clock or lock.
#pragma once

#include "rtps/dcps/presenter.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// Passes changes through directly, unless access is coherent or has GROUP scope. Then a Presenter
/// holds them back: the reader's own, or that of its subscriber.
class ReaderPresentation {
 public:
  /// `reader` receives the changes that are presented, and must outlive this object.
  explicit ReaderPresentation(PresentedReader& reader) : reader_(reader) {}

  /// Called when the reader is enabled. `of_group` is the subscriber's Presenter for GROUP scope,
  /// or nullptr if none is needed. `paused` is true between begin_access and end_access of the
  /// subscriber.
  void start(const Presentation& policy, Presenter* of_group, bool paused, MonotonicTime now);
  /// Called when the reader ends. Its samples that are still held are not presented any more.
  void stop(MonotonicTime now);
  /// False if changes go to the reader's samples at once.
  bool holds_back() const { return presenter_ != nullptr; }

  // These do nothing, and return false, unless holds_back():
  void add_writer(const Guid& writer, const std::optional<Guid>& group, const GuidPrefix& identity);
  /// Returns true if samples of the writer still wait (Presenter::remove).
  bool remove_writer(const Guid& writer, MonotonicTime now);
  void on_group(const Guid& writer, SequenceNumber group, MonotonicTime now);
  void release(MonotonicTime now, Presenter::ReaderRoom room = Presenter::ReaderRoom::may_be_freed);
  /// Pauses the reader's own Presenter. The subscriber pauses its own.
  void pause(bool paused, MonotonicTime now);
  /// Returns kNever unless holds_back().
  MonotonicTime next_tick() const;

  /// Passes a change to the Presenter. Call it only if holds_back(). Returns false if the
  /// change is refused for now.
  bool on_change(Change& change, MonotonicTime now) {
    return presenter_->on_change(reader_, change, now);
  }

 private:
  PresentedReader& reader_;
  Presenter* presenter_ = nullptr;
  std::unique_ptr<Presenter> own_;
};

}  // namespace ddssec::rtps
