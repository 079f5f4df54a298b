#include "plugins/cryptography/partition_walk.hpp"

#include <string>

#include "plugins/cryptography/builtin_names.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::size_t kWordSize = 4;

std::unexpected<Error> wrong_length_error(const DiscoveryTopic& topic) {
  return unreadable_name_error(topic, "its partitions have lengths that lie");
}

}  // namespace

Status PartitionWalk::read(const DiscoveryTopic& topic, BytesView octets) {
  for (const auto octet : octets) {
    --rest_;
    DDSSEC_RETURN_IF_ERROR(read_octet(topic, octet));
  }
  const bool is_done = has_count_ && names_left_ == 0 && name_left_ == 0;
  return rest_ == 0 && !is_done ? Status(wrong_length_error(topic)) : Status();
}

Status PartitionWalk::read_octet(const DiscoveryTopic& topic, std::uint8_t octet) {
  if (name_left_ > 0) {
    --name_left_;
    return read_character(topic, static_cast<char>(octet));
  }
  if (to_pad_ > 0) {
    --to_pad_;
    return {};
  }
  if (has_count_ && names_left_ == 0) return {};  // padding of the parameter
  const auto shift = 8 * (is_little_ ? filled_ : kWordSize - 1 - filled_);
  word_ |= std::uint32_t{octet} << shift;
  if (++filled_ < kWordSize) return {};
  const auto word = word_;
  filled_ = 0;
  word_ = 0;
  return read_word(topic, word);
}

Status PartitionWalk::read_word(const DiscoveryTopic& topic, std::uint32_t word) {
  if (has_count_) return begin_name(topic, word);
  if (word > kMaxNames)
    return unreadable_name_error(topic,
                                 "it has more than " + std::to_string(kMaxNames) + " partitions");
  has_count_ = true;
  names_ = static_cast<std::uint16_t>(word);
  names_left_ = word;
  return {};
}

Status PartitionWalk::begin_name(const DiscoveryTopic& topic, std::uint32_t size) {
  if (size == 0 || size > rest_) return wrong_length_error(topic);
  if (size > kMaxNameOctets + 1)
    return unreadable_name_error(
        topic, "one of its partitions has more than " + std::to_string(kMaxNameOctets) + " octets");
  --names_left_;
  name_left_ = size;
  to_pad_ = static_cast<std::uint8_t>((kWordSize - size % kWordSize) % kWordSize);
  stars_ = 0;
  is_in_stars_ = false;
  text_size_ = 0;
  return {};
}

Status PartitionWalk::read_character(const DiscoveryTopic& topic, char character) {
  if (character == '\0') return {};
  if (text_size_ < text_.size()) text_[text_size_++] = character;
  if (character == '*') is_in_stars_ = true;
  if (character == '*' || character == '?' || !is_in_stars_) return {};
  is_in_stars_ = false;
  return count_star(topic);
}

Status PartitionWalk::count_star(const DiscoveryTopic& topic) {
  const auto expression = '"' + std::string(text_.data(), text_size_) + "...\"";
  if (++stars_ > kMaxStarsOfName)
    return unreadable_name_error(topic, "its partition expression " + expression +
                                            " has more than " + std::to_string(kMaxStarsOfName) +
                                            " '*' before its end");
  if (++stars_of_all_ > kMaxStarsOfSample)
    return unreadable_name_error(
        topic, "its partition expressions, of which " + expression + " is one, have more than " +
                   std::to_string(kMaxStarsOfSample) + " '*' before their ends");
  return {};
}

}  // namespace ddssec::cryptography
