// Prints what results_test.py compares with the schema and the README: the field list of each
// command that has one.
#include <cstdio>

#include "cli/frame/command.hpp"

int main() {
  using namespace ddssec::cli;
  Json out = Json::object();
  for (const auto& command : commands()) {
    auto& entry = out[command.full_name()];
    if (command.run.shape() == nullptr) continue;
    const auto shape = command.run.shape()();
    entry = {
        {"schema", shape.schema}, {"definitions", shape.definitions}, {"members", shape.members}};
  }
  std::puts(out.dump(1).c_str());
}
