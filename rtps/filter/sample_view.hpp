// A decoded sample whose members a filter accesses by their names in the IDL.
#pragma once

#include <span>
#include <variant>

#include "rtps/cdr/cdr_reader.hpp"

namespace ddssec::rtps {

/// A member that is an enumeration, of any type.
struct EnumLeaf {
  const void* at = nullptr;
  std::int32_t (*read)(const void*) = nullptr;
  std::span<const EnumLabel> labels = {};
};

/// A member that can be compared. Points into the view that lists it.
struct Leaf {
  std::string path;     ///< for example "position.x"
  std::size_t top = 0;  ///< index of the member of the whole type that it is, or is part of
  std::variant<const bool*, const char*, const std::int8_t*, const std::uint8_t*,
               const std::int16_t*, const std::uint16_t*, const std::int32_t*, const std::uint32_t*,
               const std::int64_t*, const std::uint64_t*, const float*, const double*,
               const std::string*, EnumLeaf>
      at;
};

/// Holds one sample at a time and reuses its memory. Collections have no leaves.
class SampleView {
 public:
  virtual ~SampleView() = default;
  SampleView(const SampleView&) = delete;
  SampleView& operator=(const SampleView&) = delete;

  std::span<const Leaf> leaves() const { return leaves_; }
  /// Decodes the first `members` members of the type. The octets after them are not read. Errors:
  /// those of deserialize.
  virtual Status decode(BytesView payload, std::size_t members) = 0;

 protected:
  SampleView() = default;
  std::vector<Leaf> leaves_;
};

/// The values of a sample of type T, as a content filter compares them.
template <DdsType T>
class SampleViewOf final : public SampleView {
 public:
  SampleViewOf() { list(value_, "", 0); }
  Status decode(BytesView payload, std::size_t members) override {
    return deserialize_first(payload, members, value_);
  }

 private:
  template <DdsType S>
  void list(const S& value, const std::string& prefix, std::size_t depth) {
    std::size_t index = 0;
    detail::for_each_member(value, [&](const auto& member) {
      if (depth == 0) top_ = index++;
      if (!member.name.empty()) list_member(member.value, prefix + std::string(member.name), depth);
    });
  }
  template <class M>
  void list_member(const M& value, std::string path, std::size_t depth) {
    if constexpr (DdsType<M>) {
      list(value, path + ".", depth + 1);
    } else if constexpr (std::is_enum_v<M>) {
      const EnumLeaf leaf{
          &value,
          [](const void* at) { return static_cast<std::int32_t>(*static_cast<const M*>(at)); },
          EnumTraits<M>::labels};
      leaves_.push_back({std::move(path), top_, leaf});
    } else if constexpr (detail::Primitive<M> || std::is_same_v<M, std::string>) {
      leaves_.push_back({std::move(path), top_, &value});
    }
  }

  T value_{};
  std::size_t top_ = 0;
};

}  // namespace ddssec::rtps
