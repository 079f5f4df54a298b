// A host forks with the plugins loaded. Messages of parent and child must not share an IV.
// Otherwise an attacker that receives both has the xor of their plaintexts, and GHASH's key.
#include <array>
#include <set>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

const std::string kPlugins = DDSSEC_PLUGIN_DIR "/libddssec_";
const Paths kPaths = {kPlugins + "authentication.so", kPlugins + "access_control.so",
                      kPlugins + "cryptography.so"};

constexpr std::size_t kRounds = 8;
// The place of the CryptoHeader in a payload, a submessage and a message.
constexpr std::array<std::size_t, 3> kHeaderAt = {0, 4, 24};
constexpr std::size_t kHeaderSize = 20;

Octets submessage() {
  Octets out(64, 0x5a);
  out[0] = 0x15, out[1] = 0x05, out[2] = 60, out[3] = 0;
  return out;
}
Octets message() {
  Octets out = {'R', 'T', 'P', 'S', 2, 1, 1, 0x10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const auto body = submessage();
  out.insert(out.end(), body.begin(), body.end());
  return out;
}

Block encode(const Sender& sender, std::size_t level) {
  if (level == 0) return sender.encode_payload(submessage());
  return level == 1 ? sender.encode_submessage(submessage()) : sender.encode_message(message());
}

// Returns messages that `sender` protects in its process, each with its length before it.
Octets speech(const Sender& sender) {
  Octets out;
  for (std::size_t i = 0; i < kRounds * kHeaderAt.size(); ++i) {
    const auto said = encode(sender, i % kHeaderAt.size()).octets();
    out.push_back(static_cast<std::uint8_t>(said.size()));
    out.insert(out.end(), said.begin(), said.end());
  }
  return out;
}

Octets speech_of_child(const Sender& sender) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const auto child = fork();
  if (child == 0) {
    const auto said = speech(sender);
    const auto written = write(ends[1], said.data(), said.size());  // less than a pipe holds
    _exit(written == static_cast<ssize_t>(said.size()) ? 0 : 1);
  }
  close(ends[1]);
  Octets said(65536);
  std::size_t size = 0;
  for (ssize_t got; (got = read(ends[0], said.data() + size, said.size() - size)) > 0;)
    size += static_cast<std::size_t>(got);
  close(ends[0]);
  said.resize(size);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  return said;
}

void decode(const Receiver& receiver, std::size_t level, Octets said) {
  auto octets = view(said);
  if (level == 0) receiver.decode_payload(octets);
  if (level == 1) receiver.decode_submessage(octets);
  if (level != 2) return;
  to_machine_order(octets);
  receiver.decode_message(octets);
}

TEST(HostFork, ParentAndChild_NeverUseOneIvTwice) {
  Domain sending(kPaths), receiving(kPaths);
  const CryptoLink link(sending.cryptography(), receiving.cryptography(), keys_of(2, 2, 2), 1);
  std::set<Octets> headers;
  const auto before = speech(link.sender);
  const auto of_child = speech_of_child(link.sender);
  for (const auto& words : {before, of_child, speech(link.sender)}) {
    std::size_t count = 0;
    for (std::size_t at = 0; at < words.size(); at += 1 + words[at], ++count) {
      const auto level = count % kHeaderAt.size();
      const auto begin = words.begin() + static_cast<std::ptrdiff_t>(at) + 1;
      const auto header = begin + static_cast<std::ptrdiff_t>(kHeaderAt[level]);
      EXPECT_TRUE(headers.insert({header, header + kHeaderSize}).second) << level;
      EXPECT_NO_THROW(decode(link.receivers[0], level, {begin, begin + words[at]})) << level;
    }
    EXPECT_EQ(count, kRounds * kHeaderAt.size());
  }
}

}  // namespace
}  // namespace ddssec::driver
