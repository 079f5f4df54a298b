// A writer with its parts, and what it sends.
#pragma once

#include <gmock/gmock.h>

#include "rtps/reliability/filtered_writing.hpp"
#include "rtps/reliability/retransmissions.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps::writer_parts {

using std::chrono::milliseconds;

inline const GuidPrefix kA = GuidPrefix::from(Bytes(12, 0xaa));

/// Describes in words what was sent: "data 3 unicast", "gap 1-4", ...
struct Words final : Transport {
  std::vector<std::string> said;
  void send(BytesView message, std::span<const Locator> to) override {
    auto walker = *MessageReader::open(message);
    for (auto next = walker.next(); next && *next; next = walker.next()) {
      const auto words = words_of(**next);
      if (!words.empty()) said.push_back(words + (to.size() > 1 ? " to all" : ""));
    }
  }
  static std::string words_of(const SubmessageView& view) {
    const auto text = [](auto number) { return std::to_string(number.value); };
    switch (view.id) {
      case SubmessageId::data:
        return "data " + text(read_data(view)->sequence_number);
      case SubmessageId::data_frag:
        return "fragment " + text(read_data_frag(view)->first);
      case SubmessageId::gap:
        return "gap " + text(read_gap(view)->start) + "-" + text(read_gap(view)->list.base());
      case SubmessageId::heartbeat:
        return "heartbeat";
      default:
        return {};
    }
  }
};

/// Passes changes of more than one octet.
struct Filter final : ChangeFilter {
  std::optional<bool> passes(const Change& change) override { return change.payload.size() > 1; }
};

struct WriterParts : ::testing::Test {
  Words words;
  MessageSender sender{words, kA};
  WriterHistory history{keep_all()};
  WriterMessages messages{testing::kWriter, DurabilityKind::volatile_, sender, history};
  MatchedReaders readers{testing::kWriter, true};
  EvaluationAllowance evaluations;
  Retransmissions retransmissions{history, messages, evaluations};
  FilteredWriting filtered{readers, messages};
  MonotonicTime now = milliseconds(1000);

  static Qos keep_all() {
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    return qos;
  }
  const Change& add(std::size_t octets = 8) {
    Change change;
    change.payload = Payload::copy_of(Bytes(octets));
    return *history.find(history.add(std::move(change)));
  }
  std::vector<std::string> said() {
    sender.flush();
    return std::exchange(words.said, {});
  }
  bool request(ReaderProxy& proxy, std::initializer_list<std::int64_t> numbers) {
    SequenceNumberSet missing({*numbers.begin()});
    for (const auto number : numbers) missing.insert({number});
    return retransmissions.answer(proxy, readers.one(proxy), missing, now);
  }
  static NackFrag nack(std::int64_t sample, std::uint32_t fragments) {
    FragmentNumberSet missing({1});
    for (std::uint32_t i = 1; i <= fragments; ++i) missing.insert({i});
    return {testing::kReader, testing::kWriter, {sample}, missing, 1};
  }
};

}  // namespace ddssec::rtps::writer_parts
