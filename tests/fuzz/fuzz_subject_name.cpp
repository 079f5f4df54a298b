// The text of a subject name is read or refused. Every name that is read equals itself, and its key
// gives the same answer as matches().
#include <cstdlib>
#include <numeric>

#include "pki/subject_name.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  const auto name = pki::SubjectName::parse(as_text({data, size}));
  if (!name) return 0;
  if (!name->matches(*name)) std::abort();
  const auto rdns = name->rdns();
  const auto in_rdns =
      std::accumulate(rdns.begin(), rdns.end(), std::size_t{0},
                      [](std::size_t sum, const pki::Rdn& rdn) { return sum + rdn.size(); });
  if (in_rdns != name->attributes().size() || rdns.empty()) std::abort();
  // The text before the first line feed is another name.
  const auto text = as_text({data, size});
  const auto other = pki::SubjectName::parse(text.substr(0, text.find('\n')));
  if (other && other->matches(*name) != (other->key() == name->key())) std::abort();
  return 0;
}
