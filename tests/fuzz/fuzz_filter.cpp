// Filter expressions are compiled or refused. What was compiled is evaluated, and has the opposite
// result after NOT. The first line is the expression, and each further line a parameter.
#include <cstdlib>

#include "tests/unit/rtps_filter/vehicle.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::rtps;

FilterText text_of(std::string_view input) {
  FilterText out;
  auto end = std::min(input.find('\n'), input.size());
  out.expression = input.substr(0, end);
  while (end < input.size()) {
    input.remove_prefix(end + 1);
    end = std::min(input.find('\n'), input.size());
    out.parameters.emplace_back(input.substr(0, end));
  }
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static SampleViewOf<Vehicle> view;
  static const Bytes payload = [] {
    Bytes out;
    serialize(Vehicle{.name = "BLUE", .speed = 30, .gear = Gear::drive}, out);
    return out;
  }();
  auto text = text_of(as_text(BytesView(data, size)));
  const auto filter = Filter::compile(text, view.leaves());
  if (!filter) return 0;
  if (!view.decode(payload, filter->members())) std::abort();
  const bool passes = filter->passes(view);
  text.expression = "NOT (" + text.expression + ")";
  const auto opposite = Filter::compile(text, view.leaves());
  if (opposite && opposite->passes(view) == passes) std::abort();
  return 0;
}
