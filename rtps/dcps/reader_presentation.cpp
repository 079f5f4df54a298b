#include "rtps/dcps/reader_presentation.hpp"

namespace ddssec::rtps {

void ReaderPresentation::start(const Presentation& policy, Presenter* of_group, bool paused,
                               MonotonicTime now) {
  if (policy.scope == PresentationScope::group) {
    presenter_ = of_group;
  } else if (policy.coherent_access) {
    own_ = std::make_unique<Presenter>(
        Presenter::PresentedAccess{.is_coherent = true, .is_ordered = policy.ordered_access});
    presenter_ = own_.get();
    if (paused) own_->pause(true, now);
  }
}

void ReaderPresentation::stop(MonotonicTime now) {
  if (holds_back()) presenter_->remove_reader(reader_, now);
}

void ReaderPresentation::add_writer(const Guid& writer, const std::optional<Guid>& group,
                                    const GuidPrefix& identity) {
  if (holds_back()) presenter_->add_writer(reader_, writer, group, identity);
}

bool ReaderPresentation::remove_writer(const Guid& writer, MonotonicTime now) {
  return holds_back() && presenter_->remove_writer(reader_, writer, now);
}

void ReaderPresentation::on_group(const Guid& writer, SequenceNumber group, MonotonicTime now) {
  if (holds_back()) presenter_->on_progress(reader_, writer, group, now);
}

void ReaderPresentation::release(MonotonicTime now, Presenter::ReaderRoom room) {
  if (holds_back()) presenter_->present_ready(now, room);
}

void ReaderPresentation::pause(bool paused, MonotonicTime now) {
  if (own_) own_->pause(paused, now);
}

MonotonicTime ReaderPresentation::next_tick() const {
  return holds_back() ? presenter_->next_tick() : kNever;
}

}  // namespace ddssec::rtps
