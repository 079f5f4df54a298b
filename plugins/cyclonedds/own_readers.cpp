#include "plugins/cyclonedds/own_readers.hpp"

#include "plugins/cyclonedds/disposal.hpp"
#include "wire/data.hpp"
#include "wire/data_frag.hpp"
#include "wire/entity_ids.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr std::size_t kEncapsulationSize = 4;

// DATA and DATA_FRAG have the writer id at the same position.
bool is_of_subscriptions(BytesView submessage) {
  constexpr std::size_t kWriterAt = 12;
  return submessage.size() > kWriterAt + EntityId::size &&
         (submessage[0] == static_cast<std::uint8_t>(rtps::SubmessageId::data) ||
          submessage[0] == static_cast<std::uint8_t>(rtps::SubmessageId::data_frag)) &&
         EntityId::from(submessage.subspan(kWriterAt, EntityId::size)) ==
             rtps::kSubscriptionsSecureWriter;
}

std::optional<Guid> whole_guid(BytesView octets) {
  return octets.size() == Guid::size ? std::optional(Guid::from(octets)) : std::nullopt;
}

std::size_t key_of(const EntityId& entity) {
  return std::size_t{entity.octets[0]} << 16 | std::size_t{entity.octets[1]} << 8 |
         entity.octets[2];
}

// Returns the content of a string or a sequence of octets, after its length.
BytesView counted(const rtps::Parameter& parameter) {
  auto in = parameter.reader();
  const auto length = in.read<std::uint32_t>();
  if (!length) return {};
  return in.read_bytes(*length).value_or(BytesView());
}

}  // namespace

void EntityKeys::insert(const EntityId& entity) {
  const auto key = key_of(entity);
  if (key >= has_.size()) has_.resize(key + 1);
  has_[key] = true;
}

bool EntityKeys::contains(const EntityId& entity) const {
  const auto key = key_of(entity);
  return key < has_.size() && has_[key];
}

struct OwnReaders::Announcement {
  EntityId to = {};  // the peers' reader, or zero for all
  rtps::SequenceNumber number{1};
  bool is_end = false;
  Guid reader = {};
  bool is_carrier = false;
  std::optional<Guid> ended = {};  // the reader whose end a carrier carries

  void read(const rtps::Parameter& parameter);
  // Reads the list up to its end, or up to the first fault.
  void read(BytesView payload);
};

void OwnReaders::Announcement::read(const rtps::Parameter& parameter) {
  if (parameter.id == pid::kEndpointGuid) {
    reader = whole_guid(parameter.value).value_or(Guid{});
  } else if (parameter.id == pid::kTopicName) {
    auto name = as_text(counted(parameter));
    if (name.ends_with('\0')) name.remove_suffix(1);
    is_carrier = name == kCarrierTopic;
  } else if (parameter.id == pid::kUserData) {
    ended = whole_guid(counted(parameter));
  }
}

void OwnReaders::Announcement::read(BytesView payload) {
  if (payload.size() < kEncapsulationSize) return;
  const auto endian = (payload[1] & 1) != 0 ? Endian::little : Endian::big;
  rtps::ParameterReader list(payload.subspan(kEncapsulationSize), endian);
  for (auto next = list.next(); next && *next; next = list.next()) read(**next);
}

// The host puts the GUID after user data, partitions and the type, so it may be in any fragment.
std::optional<OwnReaders::Announcement> OwnReaders::read(std::int64_t sender,
                                                         const rtps::DataFrag& piece) {
  const std::lock_guard lock(mutex_);
  if (piece.first.value == 1) {
    if (begun_.size() >= kMaxBegun && !begun_.contains(sender)) begun_.erase(begun_.begin());
    begun_[sender] = {.number = piece.sequence_number};
  }
  const auto at = begun_.find(sender);
  if (at == begun_.end()) return std::nullopt;
  auto& begun = at->second;
  if (begun.number != piece.sequence_number || begun.next != piece.first.value) return std::nullopt;
  begun.next += piece.count;
  begun.octets.insert(begun.octets.end(), piece.payload.begin(), piece.payload.end());
  Announcement out;
  out.read(begun.octets);
  out.is_carrier = false;  // carriers of this process are small
  const bool is_done = out.reader != Guid{} || begun.next > piece.total();
  if (is_done || begun.octets.size() > kMaxBegunOctets) begun_.erase(at);
  return out;
}

std::optional<OwnReaders::Announcement> OwnReaders::read(std::int64_t sender,
                                                         BytesView submessage) {
  if (!is_of_subscriptions(submessage)) return std::nullopt;
  const rtps::SubmessageView view{static_cast<rtps::SubmessageId>(submessage[0]), submessage[1],
                                  submessage.subspan(rtps::kSubmessageHeaderSize), submessage};
  Announcement out;
  if (view.id == rtps::SubmessageId::data_frag) {
    const auto piece = rtps::read_data_frag(view);
    return piece ? read(sender, *piece) : std::nullopt;
  }
  const auto data = rtps::read_data(view);
  if (!data) return std::nullopt;
  out.to = data->reader;
  out.number = data->sequence_number;
  out.is_end = data->kind == rtps::PayloadKind::key || data->inline_qos.status.disposed;
  out.read(data->payload);
  return out;
}

BytesView OwnReaders::said(std::int64_t sender, BytesView submessage, Room& room) {
  const auto announcement = read(sender, submessage);
  if (!announcement) return submessage;
  const auto& ended = announcement->ended;
  if (!announcement->is_carrier || !ended || ended->prefix != announcement->reader.prefix) {
    note(*announcement);
    return submessage;
  }
  rtps::SpanWriter out(room);
  write(out, Disposal{.reader = announcement->to,
                      .writer = rtps::kSubscriptionsSecureWriter,
                      .number = announcement->number,
                      .key = pid::kEndpointGuid,
                      .gone = *ended});
  return out.view();
}

void OwnReaders::note(const Announcement& announcement) {
  const auto& reader = announcement.reader;
  if (reader == Guid{}) return;
  const std::lock_guard lock(mutex_);
  if (announcement.is_end) {
    note_end(reader);
  } else if (!has_ended(reader) && announced_.insert(reader).second) {
    ++count_;
  }
}

std::vector<Guid> OwnReaders::announced() const {
  const std::lock_guard lock(mutex_);
  return {announced_.begin(), announced_.end()};
}

std::uint64_t OwnReaders::count() const {
  const std::lock_guard lock(mutex_);
  return count_;
}

void OwnReaders::note_ended(const Guid& reader) {
  const std::lock_guard lock(mutex_);
  note_end(reader);
}

void OwnReaders::note_end(const Guid& reader) {
  ended_[reader.prefix].insert(reader.entity);
  announced_.erase(reader);
}

bool OwnReaders::has_ended(const Guid& reader) const {
  const auto owner = ended_.find(reader.prefix);
  return owner != ended_.end() && owner->second.contains(reader.entity);
}

void OwnReaders::forget(const GuidPrefix& participant) {
  const std::lock_guard lock(mutex_);
  std::erase_if(announced_, [&](const Guid& reader) { return reader.prefix == participant; });
  ended_.erase(participant);
}

}  // namespace ddssec::cyclonedds
