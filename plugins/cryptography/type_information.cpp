#include "plugins/cryptography/type_information.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::uint32_t kWord = 4;
constexpr std::uint8_t kNoType = 0x00;                      ///< TK_NONE
constexpr std::uint8_t kKinds[] = {0xf1, 0xf2};             ///< EK_MINIMAL, EK_COMPLETE
constexpr std::uint32_t kMemberIds[] = {0x1001, 0x1002};    ///< of TypeInformation
constexpr std::uint32_t kHashIdSize = 20, kNoIdSize = 8;    ///< of TypeIdentifierWithSize
constexpr std::uint32_t kListedSize = kWord + kHashIdSize;  ///< with its own header

}  // namespace

void TypeInformationWalk::begin(std::uint32_t length) {
  *this = {};
  left_ = length;
}

bool TypeInformationWalk::step(bool is_right, Next next) {
  next_ = next;
  return is_right;
}

bool TypeInformationWalk::take(std::uint32_t word, std::uint8_t first) {
  left_ -= kWord;
  switch (next_) {
    case Next::size:
      return begin_all(word);
    case Next::member:
      return begin_member(word);
    case Next::member_size:
      member_size_ = word;
      return step(true, Next::body_size);
    case Next::body_size:
      return begin_body(word);
    default:
      break;
  }
  if (next_ == Next::anything) return true;
  if (body_left_ < kWord) return false;
  body_left_ -= kWord;
  switch (next_) {
    case Next::id_size:
      return begin_id(word);
    case Next::kind:
      return begin_kind(first);
    case Next::hash:
      return step(true, --hash_words_ == 0 ? Next::object_size : Next::hash);
    case Next::object_size:
      return end_id();
    case Next::count:
      return step(true, Next::list_size);
    case Next::list_size:
      return step(word == body_left_, Next::list_length);
    default:
      return begin_list(word);
  }
}

bool TypeInformationWalk::begin_all(std::uint32_t size) {
  if (size > left_) return step(true, Next::anything);
  return step(size == left_, Next::member);
}

bool TypeInformationWalk::begin_member(std::uint32_t header) {
  constexpr std::uint32_t kMustUnderstand = 0x80000000;
  constexpr std::uint32_t kSized = 0x40000000;      // length code 4: a size, then the member
  constexpr std::uint32_t kDelimited = 0x50000000;  // 5: the member, which begins with its size
  if (half_ == kHalves) return false;
  header &= ~kMustUnderstand;
  is_sized_ = header == (kSized | kMemberIds[half_]);
  const bool is_delimited = header == (kDelimited | kMemberIds[half_]);
  return step(is_sized_ || is_delimited, is_sized_ ? Next::member_size : Next::body_size);
}

bool TypeInformationWalk::begin_body(std::uint32_t size) {
  body_left_ = size;
  in_list_ = false;
  const bool agrees = !is_sized_ || (member_size_ >= kWord && member_size_ - kWord == size);
  return step(agrees && size <= left_, Next::id_size);
}

bool TypeInformationWalk::begin_id(std::uint32_t size) {
  is_none_ = size == kNoIdSize && !in_list_;
  return step(size == kHashIdSize || is_none_, Next::kind);
}

bool TypeInformationWalk::begin_kind(std::uint8_t kind) {
  constexpr std::uint8_t kHashWords = 3;  // after the first, which begins with the kind
  hash_words_ = kHashWords;
  if (is_none_) return step(kind == kNoType, Next::object_size);
  return step(kind == kKinds[half_], Next::hash);
}

bool TypeInformationWalk::end_id() {
  if (!in_list_) return step(true, Next::count);
  if (--dependents_ > 0) return step(true, Next::id_size);
  end_half();
  return true;
}

bool TypeInformationWalk::begin_list(std::uint32_t length) {
  in_list_ = true;
  dependents_ = length;
  if (std::uint64_t{length} * kListedSize != body_left_) return false;
  if (length > 0) return step(true, Next::id_size);
  end_half();
  return true;
}

void TypeInformationWalk::end_half() {
  ++half_;
  next_ = Next::member;
}

}  // namespace ddssec::cryptography
