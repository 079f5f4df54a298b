#include "plugins/cryptography/fragment_walks.hpp"

#include <algorithm>

namespace ddssec::cryptography {
namespace {

std::unexpected<Error> early_fragment_error() { return fail(Code::builtin_fragment_early); }

std::size_t fragments_of(const DataPiece& piece) {
  return (std::size_t{piece.sample_size} + piece.fragment_size - 1) / piece.fragment_size;
}

// Converts a position in the sample to one in the payload of this piece.
TypeInformationAt within(const DataPiece& piece, TypeInformationAt at) {
  const auto begin = std::size_t{piece.first_fragment - 1} * piece.fragment_size;
  if (!at || at->at < begin || at->at >= begin + piece.payload.size()) return {};
  at->at -= static_cast<std::uint32_t>(begin);
  return at;
}

}  // namespace

void FragmentWalks::Writer::erase(Samples::iterator sample) {
  fragments -= sample->second.count;
  samples.erase(sample);
}

bool FragmentWalks::Writer::is_full(std::uint64_t number, std::size_t fragments_more) const {
  const bool is_highest = samples.empty() || number > samples.rbegin()->first;
  return samples.size() >= kMaxSamples + (is_highest ? 0 : kSpareSamples) ||
         fragments + fragments_more > kMaxFragments + (is_highest ? 0 : kSpareFragments);
}

Result<TypeInformationAt> FragmentWalks::check(const DiscoveryTopic& topic, const Owner& owner,
                                               const DataPiece& piece,
                                               AnnouncedEndpoints& announced, MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  auto& writer = writers_[topic.writer];
  DDSSEC_ASSIGN_OR_RETURN(const auto sample, sample_of(topic, writer, piece, announced, now));
  auto status = read(topic, owner, piece, sample->second, announced, now);
  const auto type_information = sample->second.type_information;
  if (sample->second.passed.empty()) {  // no fragment of it reached the host
    writer.erase(sample);
    announced.retract(topic, piece.number);
  }
  if (!status) return std::unexpected(std::move(status).error());
  return within(piece, type_information);
}

Result<FragmentWalks::Samples::iterator> FragmentWalks::sample_of(const DiscoveryTopic& topic,
                                                                  Writer& writer,
                                                                  const DataPiece& piece,
                                                                  AnnouncedEndpoints& announced,
                                                                  MonotonicTime now) {
  if (const auto found = writer.samples.find(piece.number); found != writer.samples.end()) {
    const auto& known = found->second;
    if (known.size != piece.sample_size || known.fragment_size != piece.fragment_size)
      return unreadable_name_error(topic, "its fragments are of different sizes");
    return found;
  }
  const auto count = fragments_of(piece);
  if (count > kMaxOfSample || piece.sample_size > kMaxOctets)
    return unreadable_name_error(topic, "it is too large");
  if (piece.number <= writer.forgotten_until || !piece.begins_sample) return early_fragment_error();
  DDSSEC_RETURN_IF_ERROR(make_room(topic, writer, piece.number, count, announced, now));
  DDSSEC_RETURN_IF_ERROR(announced.note(
      topic,
      {.number = piece.number, .kind = Announcement::Kind::unread, .octets = piece.sample_size}));
  writer.fragments += count;
  return writer.samples
      .emplace(piece.number, Sample{.size = piece.sample_size,
                                    .fragment_size = piece.fragment_size,
                                    .count = count,
                                    .last_progress = now})
      .first;
}

// The host may still hold fragments of a forgotten sample. Because only the lowest is forgotten,
// one number is enough to remember all forgotten samples. A sample that the host has not
// acknowledged stays, because the host may still wait for one below it.
Status FragmentWalks::make_room(const DiscoveryTopic& topic, Writer& writer, std::uint64_t number,
                                std::size_t fragments, const AnnouncedEndpoints& announced,
                                MonotonicTime now) {
  while (writer.is_full(number, fragments)) {
    const auto lowest = writer.samples.begin();
    if (number < lowest->first || now - lowest->second.last_progress < kKept ||
        !announced.is_acknowledged(topic, lowest->first))
      return early_fragment_error();
    writer.forgotten_until = lowest->first;
    writer.erase(lowest);
  }
  return {};
}

Status FragmentWalks::read(const DiscoveryTopic& topic, const Owner& owner, const DataPiece& piece,
                           Sample& sample, AnnouncedEndpoints& announced, MonotonicTime now) const {
  const auto first = std::size_t{piece.first_fragment - 1};
  if (first > sample.passed.size()) return early_fragment_error();
  std::vector<Sha256Digest> added;
  auto unread = piece.payload;
  auto index = first;
  for (auto rest = piece.payload; !rest.empty(); ++index) {
    const auto fragment = rest.first(std::min<std::size_t>(piece.fragment_size, rest.size()));
    rest = rest.subspan(fragment.size());
    const auto digest = sha256(fragment);
    if (index >= sample.passed.size()) {
      added.push_back(digest);
    } else if (digest == sample.passed[index]) {
      unread = rest;
    } else {
      return unreadable_name_error(topic, "one of its fragments came with other content before");
    }
  }
  if (added.empty()) return {};
  DDSSEC_RETURN_IF_ERROR(continue_sample(topic, owner, piece, unread, added, sample, announced));
  sample.last_progress = now;
  return {};
}

// Reads the octets after the passed fragments. Changes nothing if they must not pass.
Status FragmentWalks::continue_sample(const DiscoveryTopic& topic, const Owner& owner,
                                      const DataPiece& piece, BytesView octets,
                                      const std::vector<Sha256Digest>& added, Sample& sample,
                                      AnnouncedEndpoints& announced) const {
  auto walk = *sample.walk;
  while (!octets.empty()) {
    const auto fragment = octets.first(std::min<std::size_t>(sample.fragment_size, octets.size()));
    octets = octets.subspan(fragment.size());
    DDSSEC_RETURN_IF_ERROR(walk.read(topic, owner, fragment));
  }
  const bool is_whole = sample.passed.size() + added.size() == sample.count;
  if (is_whole) {
    DDSSEC_RETURN_IF_ERROR(walk.check_end(topic));
    DDSSEC_RETURN_IF_ERROR(announced.complete(topic, {.number = piece.number,
                                                      .kind = Announcement::Kind::announces,
                                                      .entity = walk.entity(),
                                                      .octets = walk.cost(sample.size),
                                                      .hides = !walk.says_protection()}));
  }
  sample.type_information = walk.type_information();
  sample.passed.insert(sample.passed.end(), added.begin(), added.end());
  if (is_whole)
    sample.walk.reset();
  else
    *sample.walk = walk;
  return {};
}

}  // namespace ddssec::cryptography
