// Prints what results_test.py compares with the schema and cli/results.md: the field list of each
// command.
#include <cstdio>

#include "cli/frame/command.hpp"

int main() {
  using namespace ddssec::cli;
  Json out = Json::object();
  for (const auto& command : commands()) {
    const auto shape = command.run.shape();
    out[command.full_name()] = {{"schema", shape.schema},
                                {"definitions", shape.definitions},
                                {"members", shape.members},
                                {"rows", shape.rows}};
  }
  std::puts(out.dump(1).c_str());
}
