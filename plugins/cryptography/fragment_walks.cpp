#include "plugins/cryptography/fragment_walks.hpp"

#include <algorithm>
#include <iterator>

namespace ddssec::cryptography {
namespace {

std::unexpected<Error> early() { return fail(Code::builtin_fragment_early); }

std::size_t fragments_of(const DataPiece& piece) {
  return (std::size_t{piece.sample_size} + piece.fragment_size - 1) / piece.fragment_size;
}

/// Of a sample's place, that in the piece's payload.
TypeInformationAt within(const DataPiece& piece, TypeInformationAt at) {
  const auto begin = std::size_t{piece.first_fragment - 1} * piece.fragment_size;
  if (!at || *at < begin || *at >= begin + piece.payload.size()) return {};
  return static_cast<std::uint32_t>(*at - begin);
}

}  // namespace

void FragmentWalks::Table::erase(Samples::iterator sample) {
  fragments -= sample->second.count;
  samples.erase(sample);
}

void FragmentWalks::Numbers::insert(std::uint64_t number) {
  numbers_.insert(number);
  while (numbers_.size() > most_) {
    all_until_ = *numbers_.begin();
    numbers_.erase(numbers_.begin());
  }
}

Result<TypeInformationAt> FragmentWalks::take(const BuiltinTopic& topic, const Owner& owner,
                                              const DataPiece& piece) {
  const std::lock_guard lock(mutex_);
  ++pieces_;
  auto& writer = writers_[topic.writer];
  auto [table, place] = DDSSEC_TRY(place_of(topic, writer, piece));
  auto status = read(topic, owner, piece, place->second);
  const auto type_information = place->second.walk.type_information();
  if (place->second.passed.empty())
    table.erase(place);  // the host got nothing of it
  else if (place->second.is_whole())
    writer.once_whole.insert(piece.number);
  if (!status) return std::unexpected(std::move(status).error());
  return within(piece, type_information);
}

Result<FragmentWalks::Place> FragmentWalks::place_of(const BuiltinTopic& topic, Writer& writer,
                                                     const DataPiece& piece) {
  for (auto* const table : {&writer.fresh, &writer.again}) {
    const auto found = table->samples.find(piece.number);
    if (found == table->samples.end()) continue;
    const auto& known = found->second;
    if (known.size != piece.sample_size || known.fragment_size != piece.fragment_size)
      return unreadable_name(topic, "its fragments are of different sizes");
    return Place{*table, found};
  }
  const auto count = fragments_of(piece);
  if (count > kMostOfSample) return unreadable_name(topic, "it is too large");
  if (writer.given_up.contains(piece.number))
    return unreadable_name(topic, "it was given up, being unfinished for long");
  if (!piece.begins_sample) return early();
  const bool is_again = writer.once_whole.contains(piece.number);
  DDSSEC_TRY(is_again ? make_room_again(writer, piece.number, count)
                      : make_room(writer, piece.number, count));
  auto& table = is_again ? writer.again : writer.fresh;
  table.fragments += count;
  const Sample sample{.size = piece.sample_size,
                      .fragment_size = piece.fragment_size,
                      .count = count,
                      .last_progress = pieces_};
  return Place{table, table.samples.emplace(piece.number, sample).first};
}

/// A whole sample has left the place where the host keeps fragments; its digests only stay lest
/// another thread should be late. What has made no progress for long is void at its writer, or was
/// sent again for another reader. Of the rest the host needs the lowest numbers first.
Status FragmentWalks::make_room(Writer& writer, std::uint64_t number, std::size_t fragments) {
  auto& [samples, taken] = writer.fresh;
  while (samples.size() >= kMostSamples || taken + fragments > kMostFragments) {
    auto victim = oldest_whole(samples);
    if (victim == samples.end()) victim = stale(samples);
    if (victim == samples.end() && number < std::prev(samples.end())->first)
      victim = std::prev(samples.end());
    if (victim == samples.end()) return early();
    if (!victim->second.is_whole()) writer.given_up.insert(victim->first);
    writer.fresh.erase(victim);
  }
  return {};
}

/// The host has got them once, and needs one again only if it had no room for it, or for another
/// reader. Of an unfinished one it may hold fragments: it must not begin anew with other content.
Status FragmentWalks::make_room_again(Writer& writer, std::uint64_t number,
                                      std::size_t fragments) const {
  if (writer.closed.contains(number)) return early();
  auto& [samples, taken] = writer.again;
  while (samples.size() >= kMostSamples || taken + fragments > kMostFragments) {
    auto victim = oldest_whole(samples);
    if (victim == samples.end()) victim = stale(samples);
    if (victim == samples.end()) return early();
    if (!victim->second.is_whole()) writer.closed.insert(victim->first);
    writer.again.erase(victim);
  }
  return {};
}

FragmentWalks::Samples::iterator FragmentWalks::oldest_whole(Samples& samples) const {
  auto oldest = samples.end();
  for (auto one = samples.begin(); one != samples.end(); ++one)
    if (one->second.is_whole() &&
        (oldest == samples.end() || one->second.last_progress < oldest->second.last_progress))
      oldest = one;
  return oldest;
}

FragmentWalks::Samples::iterator FragmentWalks::stale(Samples& samples) const {
  return std::ranges::find_if(samples, [&](const auto& one) {
    return pieces_ - one.second.last_progress > kPiecesUntilStale;
  });
}

Status FragmentWalks::read(const BuiltinTopic& topic, const Owner& owner, const DataPiece& piece,
                           Sample& sample) const {
  auto index = std::size_t{piece.first_fragment - 1};
  if (index > sample.passed.size()) return early();
  auto walk = sample.walk;
  std::vector<Sha256Digest> added;
  for (auto rest = piece.payload; !rest.empty(); ++index) {
    const auto fragment = rest.first(std::min<std::size_t>(piece.fragment_size, rest.size()));
    rest = rest.subspan(fragment.size());
    const auto digest = sha256(fragment);
    if (index >= sample.passed.size()) {
      DDSSEC_TRY(walk.read(topic, owner, fragment));
      added.push_back(digest);
    } else if (digest != sample.passed[index]) {
      return unreadable_name(topic, "one of its fragments came with other content before");
    }
  }
  if (added.empty()) return {};
  if (sample.passed.size() + added.size() == sample.count) DDSSEC_TRY(walk.check_end(topic));
  sample.walk = walk;
  sample.last_progress = pieces_;
  sample.passed.insert(sample.passed.end(), added.begin(), added.end());
  return {};
}

}  // namespace ddssec::cryptography
