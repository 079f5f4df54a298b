// A peer that follows commands: one on each line of standard input, with one line on standard
// output as the answer. There is one program for each stack, so that a driver can try every policy
// between any two of them within one discovery.
//   writer ID TOPIC [policy=value ...]     reader ID TOPIC [policy=value ...]     delete ID
//   write ID COLOR X [SOURCE_TIME_MS]      dispose ID COLOR     unregister ID COLOR
//   assert ID     take ID     status ID     enable ID     quit
//   begin ID, end ID: begin and end a coherent set of the group of the writer
//   told ID: USER_DATA, TOPIC_DATA and GROUP_DATA that a matched endpoint announced
// Policies: reliability=reliable|best_effort durability=volatile|transient_local|transient
// history=all|DEPTH deadline=MS lifespan=MS liveliness=automatic|participant|topic lease=MS
// ownership=shared|exclusive strength=N order=reception|source partition=NAME representation=1|2
// service=DEPTH (DURABILITY_SERVICE) scope=instance|topic|group coherent=on budget=MS priority=N
// user=TEXT topic=TEXT group=TEXT (data) factory=off (a writer's: it is created disabled)
// samples=N autodispose=on purge=MS (of disposed samples) separation=MS
// types=same|known (a reader's TYPE_CONSISTENCY_ENFORCEMENT: no coercion, only known types)
// describe=no (ours only: announces no TypeInformation)
// filter=EXPRESSION (a reader's, without spaces)
#pragma once

#include <cstdint>
#include <cstdio>
#include <iostream>
#include <map>
#include <sstream>
#include <string>

namespace policy_peer {

struct Policies {
  std::map<std::string, std::string> given;

  bool is(const std::string& name, const std::string& value) const {
    const auto at = given.find(name);
    return at != given.end() && at->second == value;
  }
  bool has(const std::string& name) const { return given.contains(name); }
  std::string text(const std::string& name) const { return has(name) ? given.at(name) : ""; }
  std::int64_t number(const std::string& name) const { return std::stoll(given.at(name)); }
};

enum class End { dispose, unregister };

class Stack {
 public:
  virtual ~Stack() = default;
  // All of these return false if the stack refuses.
  virtual bool writer(const std::string& id, const std::string& topic, const Policies&) = 0;
  virtual bool reader(const std::string& id, const std::string& topic, const Policies&) = 0;
  virtual bool remove(const std::string& id) = 0;
  /// Writes a sample. A negative `source_ms` means the present time.
  virtual bool write(const std::string& id, const std::string& color, int x,
                     std::int64_t source_ms) = 0;
  virtual bool end(const std::string& id, const std::string& color, End how) = 0;
  virtual bool assert_liveliness(const std::string& id) = 0;
  virtual bool enable(const std::string& id) = 0;
  virtual bool begin_set(const std::string&) { return false; }
  virtual bool end_set(const std::string&) { return false; }
  /// Returns "user=TEXT topic=TEXT group=TEXT".
  virtual std::string told(const std::string& id) = 0;
  /// Returns "COLOR:X:STATE ...", where X is - without data, and the state is A, D or N.
  virtual std::string take(const std::string& id) = 0;
  /// Returns "name=value ...".
  virtual std::string status(const std::string& id) = 0;
};

inline std::string answer(Stack& stack, std::istringstream& line) {
  std::string command, id, word;
  line >> command >> id;
  const auto said = [](bool done) { return done ? "ok" : "refused"; };
  if (command == "writer" || command == "reader") {
    std::string topic;
    Policies policies;
    line >> topic;
    while (line >> word) {
      const auto at = word.find('=');
      policies.given[word.substr(0, at)] = word.substr(at + 1);
    }
    return said(command == "writer" ? stack.writer(id, topic, policies)
                                    : stack.reader(id, topic, policies));
  }
  if (command == "write") {
    int x = 0;
    std::int64_t source_ms = -1;
    line >> word >> x;
    if (!(line >> source_ms)) source_ms = -1;
    return said(stack.write(id, word, x, source_ms));
  }
  if (command == "dispose" || command == "unregister") {
    line >> word;
    return said(stack.end(id, word, command == "dispose" ? End::dispose : End::unregister));
  }
  if (command == "delete") return said(stack.remove(id));
  if (command == "assert") return said(stack.assert_liveliness(id));
  if (command == "enable") return said(stack.enable(id));
  if (command == "begin") return said(stack.begin_set(id));
  if (command == "end") return said(stack.end_set(id));
  if (command == "told") return "told " + stack.told(id);
  if (command == "take") return "samples" + stack.take(id);
  if (command == "status") return "status " + stack.status(id);
  return "unknown command";
}

inline int serve(Stack& stack) {
  std::printf("ready\n"), std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line) && line != "quit";) {
    std::istringstream words(line);
    std::printf("%s\n", answer(stack, words).c_str()), std::fflush(stdout);
  }
  return 0;
}

}  // namespace policy_peer
