#include "plugins/cryptography/fragment_walks.hpp"

#include <algorithm>
#include <iterator>

namespace ddssec::cryptography {
namespace {

std::unexpected<Error> early() { return fail(Code::builtin_fragment_early); }

std::size_t fragments_of(const DataPiece& piece) {
  return (std::size_t{piece.sample_size} + piece.fragment_size - 1) / piece.fragment_size;
}

}  // namespace

Status FragmentWalks::take(const BuiltinTopic& topic, const Owner& owner, const DataPiece& piece) {
  const std::lock_guard lock(mutex_);
  ++pieces_;
  auto& writer = writers_[topic.writer];
  const auto sample = DDSSEC_TRY(sample_of(topic, writer, piece));
  auto status = read(topic, owner, piece, sample->second);
  if (sample->second.passed.empty()) {  // the host got nothing of it
    writer.fragments -= sample->second.count;
    writer.samples.erase(sample);
  }
  return status;
}

Result<FragmentWalks::Samples::iterator> FragmentWalks::sample_of(const BuiltinTopic& topic,
                                                                  Writer& writer,
                                                                  const DataPiece& piece) {
  if (const auto found = writer.samples.find(piece.number); found != writer.samples.end()) {
    const auto& known = found->second;
    if (known.size != piece.sample_size || known.fragment_size != piece.fragment_size)
      return unreadable_name(topic, "its fragments are of different sizes");
    return found;
  }
  const auto count = fragments_of(piece);
  if (count > kMostOfSample) return unreadable_name(topic, "it is too large");
  if (piece.number <= writer.given_up_until || writer.given_up.contains(piece.number))
    return unreadable_name(topic, "it was given up, being unfinished for long");
  if (!piece.begins_sample) return early();
  DDSSEC_TRY(make_room(writer, piece.number, count));
  writer.fragments += count;
  return writer.samples
      .emplace(piece.number, Sample{.size = piece.sample_size,
                                    .fragment_size = piece.fragment_size,
                                    .count = count,
                                    .last_progress = pieces_})
      .first;
}

Status FragmentWalks::make_room(Writer& writer, std::uint64_t number, std::size_t fragments) {
  while (writer.samples.size() >= kMostSamples || writer.fragments + fragments > kMostFragments) {
    const auto victim = dispensable(writer, number);
    if (victim == writer.samples.end()) return early();
    if (!victim->second.is_whole()) writer.given_up.insert(victim->first);
    writer.fragments -= victim->second.count;
    writer.samples.erase(victim);
  }
  while (writer.given_up.size() > kMostGivenUp) {
    writer.given_up_until = *writer.given_up.begin();
    writer.given_up.erase(writer.given_up.begin());
  }
  return {};
}

/// A whole sample has left the place where the host keeps fragments; its digests only stay lest
/// another thread should be late. What has made no progress for long is void at its writer, or was
/// sent again for another reader. Of the rest the host needs the lowest numbers first.
FragmentWalks::Samples::iterator FragmentWalks::dispensable(Writer& writer,
                                                            std::uint64_t number) const {
  auto& samples = writer.samples;
  auto oldest = samples.end();
  for (auto one = samples.begin(); one != samples.end(); ++one)
    if (one->second.is_whole() &&
        (oldest == samples.end() || one->second.last_progress < oldest->second.last_progress))
      oldest = one;
  if (oldest != samples.end()) return oldest;
  const auto stale = std::ranges::find_if(samples, [&](const auto& one) {
    return pieces_ - one.second.last_progress > kPiecesUntilStale;
  });
  if (stale != samples.end()) return stale;
  const auto highest = std::prev(samples.end());
  return number < highest->first ? highest : samples.end();
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
