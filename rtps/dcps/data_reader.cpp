#include "rtps/dcps/data_reader.hpp"

#include <algorithm>

#include "rtps/dcps/subscriber.hpp"

namespace ddssec::rtps {
namespace {

std::unexpected<Error> no_such_instance() {
  return fail(Code::rtps_bad_parameter, {.document = "reader",
                                         .field = "handle",
                                         .expected = "an instance the reader knows",
                                         .found = "none"});
}

}  // namespace

AnyDataReader::AnyDataReader(Group& subscriber, ParticipantContext& context, Topic& topic, Qos qos)
    : Endpoint(subscriber, context, topic, std::move(qos),
               {"reader", "subscriber", StatusKind::subscription_matched,
                StatusKind::requested_incompatible_qos, StatusKind::requested_deadline_missed}) {
  make_cache();
}

AnyDataReader::~AnyDataReader() {
  retire();
  const auto held = lock();
  if (presenter_ != nullptr) presenter_->remove(*this, context_.now());
  if (filtered_topic_ != nullptr) std::erase(filtered_topic_->readers_, this);
}

Subscriber& AnyDataReader::subscriber() const { return static_cast<Subscriber&>(group_); }

void AnyDataReader::make_cache() {
  const auto& key = topic_.type().serialized_key;
  const bool with_key = topic_.type().with_key;
  cache_.emplace(qos_, with_key && key ? ReaderCache::KeyOf(key) : nullptr);
}

Result<Guid> AnyDataReader::create(EndpointRequest request) {
  choose_presenter(request.qos.presentation);
  if (qos_.durability != DurabilityKind::volatile_) seen_.emplace();
  if (filtered_topic_ != nullptr) request.content_filter = filtered_topic_->property();
  return context_.protocol().create_reader(std::move(request), *this, context_.now());
}

// Without coherent or ordered access nothing stands between protocol and cache.
void AnyDataReader::choose_presenter(const Presentation& presentation) {
  const bool by_group = presentation.scope == PresentationScope::group;
  if (presentation.ordered_access && presentation.scope != PresentationScope::instance)
    cache_->order_by_arrival(by_group ? subscriber().arrivals_ : arrivals_);
  if (by_group) {
    presenter_ = subscriber().presenter(presentation);
  } else if (presentation.coherent_access) {
    own_presenter_ = std::make_unique<Presenter>(false, true, presentation.ordered_access);
    presenter_ = own_presenter_.get();
    if (subscriber().is_accessing()) pause(true, context_.now());
  }
}

void AnyDataReader::pause(bool paused, MonotonicTime now) {
  if (own_presenter_ == nullptr) return;
  own_presenter_->pause(paused, now);
  if (!paused) call_at(own_presenter_->next_tick());
}

void AnyDataReader::on_own_qos(const Qos& before) {
  if (!enabled()) return make_cache();
  if (qos_.deadline != before.deadline) cache_->set_deadline(qos_.deadline, context_.now());
  cache_->set_lifecycle(qos_.reader_data_lifecycle);
  if (qos_.time_based_filter != before.time_based_filter)
    cache_->set_minimum_separation(qos_.time_based_filter);
  call_at(cache_->next_tick());
}

Status AnyDataReader::filter_by(ContentFilteredTopic& topic) {
  const auto held = lock();
  filter_.emplace(DDSSEC_TRY(topic.compile(topic.text_)));
  filtered_topic_ = &topic;
  topic.readers_.push_back(this);
  return {};
}

Status AnyDataReader::on_filter_changed() {
  filter_.emplace(DDSSEC_TRY(filtered_topic_->compile(filtered_topic_->text_)));
  if (enabled())
    context_.protocol().change_filter(guid_, filtered_topic_->property(), context_.now());
  return {};
}

Status AnyDataReader::check_unused() const {
  if (conditions_.empty()) return {};
  return precondition_not_met("reader", "no read conditions any more",
                              std::to_string(conditions_.size()));
}

// Reading is what resets DATA_AVAILABLE and DATA_ON_READERS (DDS 1.4, 2.2.4.2.2).
Result<std::size_t> AnyDataReader::access(const Query& query, std::vector<OctetSample>& out) {
  const auto held = lock();
  DDSSEC_TRY(check_enabled(topic_.name()));
  DDSSEC_TRY(subscriber().check_access());
  if (query.scope == Query::Scope::instance && cache_->key_value(query.instance) == nullptr)
    return no_such_instance();
  const auto before = out.size();
  cache_->select(query, context_.moment(), out);
  changes_.clear(StatusKind::data_available);
  subscriber().changes_.clear(StatusKind::data_on_readers);
  if (query.take && std::exchange(refused_, false)) {
    if (auto* reader = context_.protocol().local_endpoints().reader(guid_)) reader->offer_again();
    context_.reschedule();
  }
  if (query.take && presenter_ != nullptr) presenter_->release(context_.now());
  update_conditions();
  return out.size() - before;
}

InstanceHandle AnyDataReader::lookup_key(const KeyHash& key) const {
  const auto held = lock();
  return cache_->lookup(key);
}

Result<Payload> AnyDataReader::octets_of_key(InstanceHandle instance) const {
  const auto held = lock();
  if (const auto* key = cache_->key_value(instance)) return *key;
  return no_such_instance();
}

ReadCondition& AnyDataReader::create_readcondition(const States& states) {
  std::unique_ptr<ReadCondition> condition(new ReadCondition(*this, states));
  const auto held = lock();
  conditions_.push_back(std::move(condition));
  update_conditions();
  return *conditions_.back();
}

Result<std::unique_ptr<BoundFilter>> AnyDataReader::compile_query(const FilterText& text) const {
  if (text.expression.find_first_not_of(" \t\r\n") == std::string::npos) return nullptr;
  const auto& view = topic_.type().view;
  return std::make_unique<BoundFilter>(
      DDSSEC_TRY(BoundFilter::compile(text, view ? view() : nullptr)));
}

Result<QueryCondition*> AnyDataReader::create_querycondition(const States& states,
                                                             FilterText query) {
  auto compiled = DDSSEC_TRY(compile_query(query));
  std::unique_ptr<QueryCondition> condition(
      new QueryCondition(*this, states, std::move(query), std::move(compiled)));
  auto* out = condition.get();
  const auto held = lock();
  conditions_.push_back(std::move(condition));
  update_conditions();
  return out;
}

std::vector<std::string> QueryCondition::query_parameters() const {
  const auto held = reader_.lock();
  return text_.parameters;
}

Status QueryCondition::set_query_parameters(std::vector<std::string> parameters) {
  const auto held = reader_.lock();
  FilterText text{text_.expression, std::move(parameters)};
  auto compiled = DDSSEC_TRY(reader_.compile_query(text));
  if (compiled) *query_ = std::move(*compiled);  // its place is known to whoever reads now
  text_.parameters = std::move(text.parameters);
  reader_.update_conditions();
  return {};
}

Status AnyDataReader::delete_readcondition(ReadCondition& condition) {
  const auto held = lock();
  if (std::erase_if(conditions_, [&](const auto& c) { return c.get() == &condition; }) > 0)
    return {};
  return precondition_not_met("read condition", "one of this reader", "another's");
}

void AnyDataReader::delete_contained_entities() {
  const auto held = lock();
  conditions_.clear();
}

Status AnyDataReader::check_own(const ReadCondition& condition) const {
  if (&condition.datareader() == this) return {};
  return precondition_not_met("read condition", "one of this reader", "another's");
}

void AnyDataReader::update_conditions() {
  for (auto& condition : conditions_)
    condition->trigger(cache_->any(condition->states(), condition->query()));
}

Status AnyDataReader::wait_for_historical_data(std::chrono::nanoseconds most) {
  auto held = lock();
  DDSSEC_TRY(check_enabled(topic_.name()));
  if (qos_.durability == DurabilityKind::volatile_) return {};
  // A heartbeat alone can complete it, and tells nobody.
  constexpr std::chrono::nanoseconds kStep = std::chrono::milliseconds(10);
  const auto complete = [&] {
    const auto* reader = context_.protocol().local_endpoints().reader(guid_);
    return reader == nullptr || reader->has_history();
  };
  for (auto left = most;; left -= kStep) {
    if (context_.wait(held, std::min(left, kStep), complete)) return {};
    if (left <= kStep || context_.in_callback()) break;
  }
  return fail(Code::rtps_timeout, {.document = "reader " + guid_.to_string()});
}

bool AnyDataReader::wait_for_unread(std::chrono::nanoseconds most) {
  auto held = lock();
  return context_.wait(held, most, [&] { return cache_->any({.sample = SampleState::not_read}); });
}

}  // namespace ddssec::rtps
