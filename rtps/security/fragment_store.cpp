#include "rtps/security/fragment_store.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

namespace ddssec::rtps {
namespace {

// Enumerates all ways to choose a number below each limit so that the numbers add up to `sum`,
// until `use` returns false. Returns false if it did.
class Choices {
 public:
  using Use = std::function<bool(const std::vector<std::size_t>&)>;
  Choices(std::vector<std::size_t> limits, Use use)
      : limits_(std::move(limits)), chosen_(limits_.size()), use_(std::move(use)) {}

  bool each(std::size_t sum, std::size_t at = 0) {
    if (at == limits_.size()) return sum > 0 || use_(chosen_);
    for (std::size_t i = 0; i <= std::min(sum, limits_[at] - 1); ++i) {
      chosen_[at] = i;
      if (!each(sum - i, at + 1)) return false;
    }
    return true;
  }

 private:
  const std::vector<std::size_t> limits_;
  std::vector<std::size_t> chosen_;
  const Use use_;
};

}  // namespace

bool FragmentStore::Run::repeats(const DataFrag& frag) const {
  return belongs_to(frag) && first + 1 == frag.first.value && count == frag.count &&
         std::ranges::equal(octets, frag.payload);
}

BytesView FragmentStore::Run::fragment(std::uint32_t index) const {
  const auto rest = BytesView(octets).subspan(std::size_t{index - first} * fragment_size);
  return rest.first(std::min<std::size_t>(fragment_size, rest.size()));
}

void FragmentStore::Sender::drop(std::deque<Run>::iterator at) {
  price -= at->price();
  fragments -= at->count;
  runs.erase(at);
}

void FragmentStore::Sender::keep(const DataFrag& frag, MonotonicTime now) {
  const auto same = std::ranges::find_if(runs, [&](const Run& run) { return run.repeats(frag); });
  if (same != runs.end()) drop(same);
  runs.push_back({frag.sequence_number, frag.fragment_size, frag.sample_size, frag.first.value - 1,
                  frag.count, to_bytes(frag.payload), now});
  price += runs.back().price();
  fragments += frag.count;
  while (price > kMaxOctetsPerSender) drop(runs.begin());
}

void FragmentStore::make_room(const SourceAddress& newcomer) {
  const auto held = [&](const Sender& sender) {
    return std::pair(std::ranges::count(senders_, sender.source, &Sender::source),
                     sender.source == newcomer);
  };
  // Senders are in the order of their latest fragments, so max_element finds the one among equals
  // that has been silent longest.
  senders_.erase(std::ranges::max_element(senders_, {}, held));
}

FragmentStore::Sender& FragmentStore::place_for(const GuidPrefix& prefix,
                                                const SourceAddress& source, MonotonicTime now) {
  const auto at = std::ranges::find_if(senders_, [&](const Sender& sender) {
    return sender.prefix == prefix && sender.source == source;
  });
  auto sender = at != senders_.end() ? std::move(*at) : Sender{prefix, source};
  if (at != senders_.end()) senders_.erase(at);
  while (!sender.runs.empty() && now - sender.runs.front().since >= kLife)
    sender.drop(sender.runs.begin());
  if (senders_.size() >= kMaxSenders) make_room(source);
  return senders_.emplace_back(std::move(sender));
}

// The cost of a datagram is limited by its length: each fragment takes at least 512 octets of it,
// or there are only few.
std::vector<Bytes> FragmentStore::add(const GuidPrefix& prefix, const DataFrag& frag,
                                      MonotonicTime now, const SourceAddress& source) {
  if (frag.sample_size > kMaxMessage) return {};
  if (frag.fragment_size < kMinFragmentSize && frag.total() > kMaxSmallFragments) return {};
  auto& sender = place_for(prefix, source, now);
  sender.keep(frag, now);
  const auto forms = forms_of(sender, frag);
  if (!forms || (frag.sample_size > kLarge && !more_.try_spend(now))) return {};
  return messages_of(*forms, now);
}

std::optional<FragmentStore::Forms> FragmentStore::forms_of(const Sender& sender,
                                                            const DataFrag& frag) {
  if (sender.fragments < frag.total()) return std::nullopt;
  Forms forms(frag.total());
  std::size_t missing = forms.size();
  for (auto run = sender.runs.rbegin(); run != sender.runs.rend(); ++run) {
    if (!run->belongs_to(frag)) continue;
    for (auto index = run->first; index < run->first + run->count; ++index) {
      auto& of_one = forms[index];
      missing -= of_one.empty() ? 1 : 0;
      // Messages without the new fragment were assembled before.
      const bool is_new =
          index + 1 >= frag.first.value && index + 1 < frag.first.value + frag.count;
      if (of_one.size() < (is_new ? 1 : kMaxForms)) of_one.push_back(run->fragment(index));
    }
  }
  return missing == 0 ? std::optional(std::move(forms)) : std::nullopt;
}

// The fragments of one message arrive directly after each other. So the latest version of each
// fragment is tried first, then the versions with one forged fragment in between, and so on.
std::vector<Bytes> FragmentStore::messages_of(const Forms& forms, MonotonicTime now) {
  std::vector<Bytes> out;
  std::vector<std::size_t> limits;
  for (const auto& of_one : forms) limits.push_back(of_one.size());
  const auto most = std::accumulate(limits.begin(), limits.end(), std::size_t{0}) - limits.size();
  Choices choices(std::move(limits), [&](const std::vector<std::size_t>& chosen) {
    if (!out.empty() && (out.size() == kMaxMessages || !more_.try_spend(now))) return false;
    auto& message = out.emplace_back();
    for (std::size_t i = 0; i < forms.size(); ++i) {
      const auto octets = forms[i][chosen[i]];
      message.insert(message.end(), octets.begin(), octets.end());
    }
    return true;
  });
  for (std::size_t later = 0; later <= most && choices.each(later); ++later) {
  }
  return out;
}

void FragmentStore::forget(const GuidPrefix& prefix) {
  std::erase_if(senders_, [&](const auto& sender) { return sender.prefix == prefix; });
}

std::size_t FragmentStore::size() const {
  return std::accumulate(
      senders_.begin(), senders_.end(), std::size_t{0},
      [](std::size_t sum, const Sender& sender) { return sum + sender.fragments; });
}

}  // namespace ddssec::rtps
