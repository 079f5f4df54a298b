#include "rtps/security/fragment_store.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

namespace ddssec::rtps {
namespace {

/// All ways to choose a number below each limit so that they add up to `sum`, until `use` says that
/// it has seen enough. False: it has.
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

void FragmentStore::Sender::drop_first() {
  price -= fragments.front().price();
  fragments.pop_front();
}

void FragmentStore::Sender::keep(Fragment fragment) {
  const auto same = std::ranges::find_if(fragments, [&](const auto& f) {
    return f.index == fragment.index && f.number == fragment.number &&
           f.fragment_size == fragment.fragment_size && f.sample_size == fragment.sample_size &&
           f.octets == fragment.octets;
  });
  if (same != fragments.end()) {
    price -= same->price();
    fragments.erase(same);
  }
  price += fragment.price();
  fragments.push_back(std::move(fragment));
  while (price > kMostOctetsPerSender) drop_first();
}

FragmentStore::Sender& FragmentStore::place_for(const GuidPrefix& prefix, MonotonicTime now) {
  const auto at = std::ranges::find(senders_, prefix, &Sender::prefix);
  auto sender = at != senders_.end() ? std::move(*at) : Sender{prefix};
  if (at != senders_.end()) senders_.erase(at);
  while (!sender.fragments.empty() && now - sender.fragments.front().since >= kLife)
    sender.drop_first();
  if (senders_.size() >= kMostSenders) senders_.pop_front();
  return senders_.emplace_back(std::move(sender));
}

std::vector<Bytes> FragmentStore::add(const GuidPrefix& prefix, const DataFrag& frag,
                                      MonotonicTime now) {
  if (frag.sample_size > kLargestMessage) return {};
  auto& sender = place_for(prefix, now);
  for (std::uint32_t i = 0; i < frag.count; ++i) {
    const auto begin = std::size_t{i} * frag.fragment_size;
    const auto size = std::min<std::size_t>(frag.fragment_size, frag.payload.size() - begin);
    sender.keep({frag.sequence_number, frag.fragment_size, frag.sample_size,
                 frag.first.value - 1 + i, to_bytes(frag.payload.subspan(begin, size)), now});
  }
  const auto forms = forms_of(sender, frag);
  if (!forms || (frag.sample_size > kLarge && !more_.take(now))) return {};
  return messages_of(*forms, now);
}

std::optional<FragmentStore::Forms> FragmentStore::forms_of(const Sender& sender,
                                                            const DataFrag& frag) {
  // Who claims very many small ones costs nothing until they are there.
  if (sender.fragments.size() < frag.total()) return std::nullopt;
  Forms forms(frag.total());
  std::size_t missing = forms.size();
  for (auto at = sender.fragments.rbegin(); at != sender.fragments.rend(); ++at) {
    if (!at->belongs_to(frag)) continue;
    auto& of_one = forms[at->index];
    missing -= of_one.empty() ? 1 : 0;
    // Messages without what has just come were made before.
    const bool is_new =
        at->index + 1 >= frag.first.value && at->index + 1 < frag.first.value + frag.count;
    if (of_one.size() < (is_new ? 1 : kMostForms)) of_one.push_back(&*at);
  }
  return missing == 0 ? std::optional(std::move(forms)) : std::nullopt;
}

// Those of one message come one right after the other. So the latest of each are tried first, then
// those with one that was forged in between, and so on.
std::vector<Bytes> FragmentStore::messages_of(const Forms& forms, MonotonicTime now) {
  std::vector<Bytes> out;
  std::vector<std::size_t> limits;
  for (const auto& of_one : forms) limits.push_back(of_one.size());
  const auto most = std::accumulate(limits.begin(), limits.end(), std::size_t{0}) - limits.size();
  Choices choices(std::move(limits), [&](const std::vector<std::size_t>& chosen) {
    if (!out.empty() && (out.size() == kMostMessages || !more_.take(now))) return false;
    auto& message = out.emplace_back();
    for (std::size_t i = 0; i < forms.size(); ++i) {
      const auto& octets = forms[i][chosen[i]]->octets;
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
      [](std::size_t sum, const Sender& sender) { return sum + sender.fragments.size(); });
}

}  // namespace ddssec::rtps
