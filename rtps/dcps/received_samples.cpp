#include "rtps/dcps/received_samples.hpp"

namespace ddssec::rtps {

ReceivedSamples::ReceivedSamples(const Qos& qos, const TypeSupport& type, const Queries& queries)
    : type_(type), queries_(queries) {
  reset(qos);
}

void ReceivedSamples::reset(const Qos& qos) {
  const auto& key = type_.serialized_key;
  cache_.emplace(qos, type_.with_key && key ? ReaderCache::KeyOf(key) : nullptr, queries_);
}

bool ReceivedSamples::passes(const Change& change, BoundFilter& filter) {
  const auto passes = filter.passes(change.payload.view());
  if (!passes) count_malformed();
  return passes.value_or(false);
}

// The key of a protected payload comes from its writer. The key hash next to it is not protected,
// so the key is computed from the payload.
std::optional<KeyHash> ReceivedSamples::key_of(const Change& change,
                                               const KeyProtection& keys) const {
  const bool from_payload = keys.proven && change.payload.size() > 0;
  if (type_.key_hash && (!change.key_hash || from_payload))
    return type_.key_hash(change, keys.hidden);
  return change.key_hash;
}

bool ReceivedSamples::name_instance(Change& change, const KeyProtection& keys) const {
  if (!type_.with_key) return true;
  change.key_hash = key_of(change, keys);
  return change.key_hash.has_value();
}

KeyHash ReceivedSamples::instance_of(const Change& change, const KeyProtection& keys) const {
  if (change.is_examined) return change.key_hash.value_or(KeyHash{});
  return type_.with_key ? key_of(change, keys).value_or(KeyHash{}) : KeyHash{};
}

ReceivedSamples::ReceptionReport ReceivedSamples::receive(Change& change, BoundFilter* filter,
                                                          const KeyProtection& keys,
                                                          const Moment& at) {
  if (change.is_examined && seen_)  // checked before the digests of large payloads are computed
    if (const auto refusal = cache_->rejects_again(change, at))
      return {Reception::rejected, *refusal};
  const bool is_new = !std::exchange(change.is_examined, false);
  if (is_new && filter != nullptr && change.is_alive() && !passes(change, *filter)) return {};
  if (is_new && !name_instance(change, keys)) {
    count_malformed();
    return {change.is_alive() ? Reception::unseen : Reception::unreadable_key};
  }
  const auto expires = cache_->expiry_of(change, at);
  if (seen_ && seen_->contains(change, expires) && !cache_->is_wanted_again(change)) return {};
  // The end of an instance is not reported if none of its samples passed the filter.
  const auto key = change.key_hash.value_or(KeyHash{});
  if (filter != nullptr && !change.is_alive() && cache_->lookup(key).is_nil()) return {};
  const auto sighting = seen_ ? SeenOriginals::of(change, expires) : SeenOriginals::Sighting{};
  const auto stored = cache_->store(change, at);
  if (stored.outcome == ReaderCache::StoreResult::rejected) {
    change.is_examined = true;
    return {Reception::rejected, stored};
  }
  // Samples that the reader does not see do not take a place in `seen_`.
  const bool is_seen = stored.outcome == ReaderCache::StoreResult::stored;
  if (seen_ && (is_seen || !sighting.claim)) seen_->add(sighting);
  return {is_seen ? Reception::stored : Reception::unseen, stored};
}

}  // namespace ddssec::rtps
