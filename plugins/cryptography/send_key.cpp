#include "plugins/cryptography/send_key.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "plugins/cryptography/crypto_framing.hpp"

namespace ddssec::cryptography {
namespace {

SessionId id_from(std::uint32_t value) {
  SessionId id;
  for (std::size_t i = 0; i < 4; ++i)
    id.octets[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
  return id;
}

std::uint32_t number_of(SessionId id) {
  std::uint32_t number = 0;
  for (const auto octet : id.octets) number = number << 8 | octet;
  return number;
}

Iv iv_from(SessionId session, std::uint64_t suffix) {
  Iv iv;
  UncheckedWriter octets(iv);
  octets.put(session.octets);
  octets.u32(static_cast<std::uint32_t>(suffix >> 32));
  octets.u32(static_cast<std::uint32_t>(suffix));
  return iv;
}

// Returns the AES blocks of a message: those of its content, and one for the tag.
std::uint64_t blocks(std::size_t size) { return size / 16 + 2; }

}  // namespace

Result<std::unique_ptr<SendKey>> SendKey::create(KeyMaterial material, SendStart start,
                                                 const KeyServices& services) {
  const auto traits = traits_of(material.kind);
  if (!traits) return fail(Code::internal);
  return std::unique_ptr<SendKey>(new SendKey(std::move(material), *traits, start, services));
}

Result<SendStart> SendStart::draw(Random& random) {
  std::array<std::uint8_t, sizeof(session) + sizeof(suffix)> octets;
  DDSSEC_RETURN_IF_ERROR(random.fill(octets));
  SendStart start;
  std::memcpy(&start.session, octets.data(), sizeof start.session);
  std::memcpy(&start.suffix, octets.data() + sizeof start.session, sizeof start.suffix);
  return start;
}

Status SendKey::expand(SendSession& session) const {
  session.id = id_from(session.begun.first + session.begun.further);
  const auto key = derive_session_key(material_.sender_key, material_.salt, session.id);
  return key.expose(
      [&](BytesView octets) { return session.key.expand(services_.aead, traits_.cipher, octets); });
}

// A child of fork() draws a new start, because the one in its memory belongs to its parent.
Result<std::unique_ptr<SendSession>> SendKey::first_session() const {
  auto first = std::make_unique<SendSession>();
  first->generation = services_.generation.current();
  auto start = start_;
  if (first->generation != generation_) {
    first->begun_by_parents.push_back({start.session, 0});
    DDSSEC_ASSIGN_OR_RETURN(start, SendStart::draw(services_.random));
  }
  first->suffix = start.suffix;
  first->begun.first = start.session;
  DDSSEC_RETURN_IF_ERROR(expand(*first));
  return first;
}

// In a child of fork() the session begins at random; the sessions of its parents count as used.
Result<std::unique_ptr<SendSession>> SendKey::session_after(const SendSession& former) const {
  auto next = std::make_unique<SendSession>();
  next->number = former.number + 1;
  next->generation = services_.generation.current();
  next->begun_by_parents = former.begun_by_parents;
  if (former.generation == next->generation) {
    next->suffix = former.suffix;
    next->begun = {former.begun.first, former.begun.further + 1};
  } else {
    DDSSEC_ASSIGN_OR_RETURN(const auto start, SendStart::draw(services_.random));
    next->suffix = start.suffix;
    next->begun.first = start.session;
    next->begun_by_parents.push_back(former.begun);
  }
  DDSSEC_RETURN_IF_ERROR(expand(*next));
  return next;
}

Result<SendKey::Reservation> SendKey::reserve(std::size_t size) {
  const auto wanted = blocks(size);
  for (;;) {
    auto* const session = current_.read();
    if (session != nullptr && session->generation == services_.generation.peek()) [[likely]] {
      const auto first = session->used.fetch_add(wanted, std::memory_order_relaxed);
      // A message larger than a whole session may be the only one of it.
      if (first == 0 || first + wanted <= services_.max_blocks_per_session) [[likely]]
        return Reservation{session, iv_from(session->id, session->suffix + first)};
    }
    DDSSEC_RETURN_IF_ERROR(roll_over(session));
  }
}

bool SendKey::has_begun(SessionId session) const {
  const auto* const current = current_.read();
  if (current == nullptr) return false;
  const auto id = number_of(session);
  const auto has_it = [&](const SessionRange& range) { return range.contains(id); };
  return has_it(current->begun) || std::ranges::any_of(current->begun_by_parents, has_it);
}

SendPosition SendKey::position() const {
  const auto* const current = current_.read();
  if (current == nullptr) return {start_.session, start_.suffix, {{start_.session, 0}}};
  const auto used = current->used.load(std::memory_order_relaxed);
  SendPosition out{number_of(current->id), current->suffix + used, {current->begun}};
  out.begun.insert(out.begun.end(), current->begun_by_parents.begin(),
                   current->begun_by_parents.end());
  return out;
}

std::uint64_t SendKey::blocks_used() const {
  const auto* const session = current_.read();
  if (session == nullptr) return 0;
  const auto most = services_.max_blocks_per_session;
  const auto of_session = std::min(session->used.load(std::memory_order_relaxed), most);
  const auto before = session->number * most;  // below 2^64
  return before + std::min(of_session, std::numeric_limits<std::uint64_t>::max() - before);
}

Status SendKey::roll_over(const SendSession* former) {
  const std::lock_guard lock(mutex_);
  if (current_.read() != former) return {};
  if (former != nullptr && former->number + 1 >= services_.max_sessions_per_key)
    return fail(Code::session_ids_exhausted);
  auto next = former != nullptr ? session_after(*former) : first_session();
  DDSSEC_RETURN_IF_ERROR(next);
  current_.replace(*std::move(next), services_.retired_objects);
  return {};
}

Status ReceiverKey::mac(const SendKey& sender, const SendKey::Reservation& reservation,
                        TagView common_mac, TagOut out) {
  const Session* session = current_.read();
  if (session == nullptr || !session->is_of(sender, reservation.session->id)) [[unlikely]] {
    DDSSEC_ASSIGN_OR_RETURN(session, expand(sender, reservation.session->id));
  }
  if (!session->key.mac(reservation.iv, common_mac, out)) return fail(Code::internal);
  return {};
}

Result<const ReceiverKey::Session*> ReceiverKey::expand(const SendKey& sender, SessionId id) {
  const std::lock_guard lock(mutex_);
  if (const auto* const current = current_.read(); current != nullptr && current->is_of(sender, id))
    return current;
  auto next = std::make_unique<Session>();
  next->id = id;
  next->kind = sender.material().kind;
  const auto key = derive_session_receiver_key(key_, sender.material().salt, id);
  DDSSEC_RETURN_IF_ERROR(key.expose([&](BytesView octets) {
    return next->key.expand(services_.aead, sender.traits().cipher, octets);
  }));
  const auto* const made = next.get();
  current_.replace(std::move(next), services_.retired_objects);
  return made;
}

}  // namespace ddssec::cryptography
