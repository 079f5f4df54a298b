#include "governance/doctor/lenient_text.hpp"

#include <algorithm>
#include <set>

#include "base/text.hpp"
#include "governance/xml_check.hpp"

namespace ddssec::governance::doctor {
namespace {

// Goes through the text once and replaces invalid parts by blanks. Takes linear time and memory,
// because the text may come from anyone: a name ends at the next '<', and no attribute and no run
// of blanks is read twice.
class Cleaner {
 public:
  explicit Cleaner(std::string text) : text_(std::move(text)) {}

  LenientText run() {
    declaration();
    for (std::size_t at = text_.find('<'); at < text_.size(); at = text_.find('<', at + 1)) {
      const auto rest = std::string_view(text_).substr(at);
      if (rest.starts_with("<![CDATA["))
        at = cdata(at);
      else if (rest.starts_with("<!--"))
        at = comment(at);
      else if (rest.starts_with("<!DOCTYPE"))
        blank(at, end_of_doctype(at), Variant::governance_doctype);
      else if (rest.starts_with("<?"))
        instruction(at);
      else
        at = start_of_tag(at);
    }
    octets();
    return {to_bytes(as_bytes(text_)), std::move(left_out_), has_pieces_, is_refused_by_fastdds_};
  }

 private:
  // The largest number of joins, because each of them moves the rest of the text.
  static constexpr std::size_t kMaxJoined = 1000;
  static constexpr std::string_view kBlanks = " \t\r\n";
  // More than any document has: ddssec refuses elements deeper than kMaxXmlDepth.
  static constexpr std::size_t kMaxOpen = 10'000;

  std::size_t behind(std::size_t from, std::string_view end) const {
    const auto found = text_.find(end, from);
    return found == text_.npos ? text_.size() : found + end.size();
  }

  // An internal subset is in brackets.
  std::size_t end_of_doctype(std::size_t from) const {
    const auto at = text_.find_first_of("[>", from);
    const bool has_subset = at != text_.npos && text_[at] == '[';
    return behind(has_subset ? behind(at, "]") : from, ">");
  }

  void blank(std::size_t from, std::size_t to, Variant what) {
    for (std::size_t i = from; i < to; ++i)
      if (text_[i] != '\n' && text_[i] != '\r') text_[i] = ' ';
    note(what);
  }
  // Measured: Fast DDS reads a processing instruction before the root element only.
  void instruction(std::size_t at) {
    if (has_root_) is_refused_by_fastdds_ = true;
    blank(at, behind(at, "?>"), Variant::governance_processing_instruction);
  }
  // Handles a tag, and returns the last place that was handled.
  std::size_t start_of_tag(std::size_t at) {
    small_name(at + 1);
    return text_.compare(at + 1, 1, "/") == 0 ? at : attributes(at + 1) - 1;
  }
  // Blanks the attributes that ddssec refuses and does not need, so that the rest can be judged for
  // a product that ignores them (Fast DDS, measured). Returns the place after the last one.
  std::size_t attributes(std::size_t at) {
    const auto name = text_.substr(at, text_.find_first_of(" \t\r\n/<>", at) - at);
    std::set<std::string> seen;
    for (at += name.size(); at < text_.size();) {
      const auto begin = text_.find_first_not_of(" \t\r\n", at);
      const auto equals = text_.find_first_of("=<>", begin);
      if (begin == text_.npos || equals == text_.npos || text_[equals] != '=') return at;
      const auto quote = text_.find_first_not_of(" \t\r\n", equals + 1);
      if (quote == text_.npos || (text_[quote] != '"' && text_[quote] != '\'')) return at;
      const auto end = text_.find(text_[quote], quote + 1);
      if (end == text_.npos) return at;
      const std::string word(trimmed(text_.substr(begin, equals - begin), " \t\r\n"));
      if (!seen.insert(word).second) return at;  // no product accepts an attribute twice
      if (!is_known(word, name)) blank(begin, end + 1, Variant::governance_unknown_attribute);
      at = end + 1;
    }
    return at;
  }
  static bool is_known(std::string_view attribute, std::string_view element) {
    return attribute == "must_interpret" || attribute.starts_with("xmlns") ||
           attribute.starts_with("xsi:") || attribute.starts_with("xml:") ||
           (element == "grant" && attribute == "name");
  }
  // Converts the name of a start tag or an end tag to lower case.
  void small_name(std::size_t at) {
    has_root_ = true;
    const auto end = std::min(text_.find_first_of(" \t\r\n<>", at), text_.size());
    const auto name = text_.substr(at, end - at);
    if (!is_in_pair(name, end)) return;
    for (; at < end; ++at)
      if (text_[at] >= 'A' && text_[at] <= 'Z') {
        text_[at] = static_cast<char>(text_[at] - 'A' + 'a');
        is_refused_by_fastdds_ = true;
      }
  }
  // False for an end tag that is not spelt like its start tag.
  bool is_in_pair(std::string_view name, std::size_t end) {
    if (name.starts_with('/')) {
      const bool is_same = !open_.empty() && open_.back() == name.substr(1);
      if (!open_.empty()) open_.pop_back();
      return is_same;
    }
    if (open_.size() == kMaxOpen) return false;
    const auto close = text_.find_first_of("<>", end);
    const bool is_closed =
        close != text_.npos && close > 0 && text_[close] == '>' && text_[close - 1] == '/';
    if (!is_closed) open_.emplace_back(name);
    return true;
  }
  void note(Variant what) {
    if (std::ranges::find(left_out_, what) == left_out_.end()) left_out_.push_back(what);
  }

  // A declaration that ddssec can parse stays; it may be the only part that names the encoding.
  void declaration() {
    const auto at = text_.find("<?xml ");
    constexpr std::string_view kAlone = "<a/>";
    if (at == text_.npos || at > 3) return;  // a byte order mark may be before it
    const auto end = behind(at, "?>");
    const auto words = text_.substr(at, end - at);
    if (check_xml(words + std::string(kAlone))) return;
    blank(at, end,
          words.find("\\\"") != words.npos ? Variant::governance_escaped_quotes
                                           : Variant::governance_latin_1);
  }

  // Handles a comment, and returns the last place that was handled.
  std::size_t comment(std::size_t at) {
    constexpr std::size_t kStart = 4;
    const auto end = behind(at + kStart, "-->");
    const auto dashes = text_.find("--", at + kStart);
    if (dashes < end && dashes + 3 < end) blank(at, end, Variant::governance_comment_dashes);
    const bool is_ended = text_.find("-->", at + kStart) != text_.npos;
    if (!is_ended || !is_in_value(at, end) || ++joined_ > kMaxJoined) return at;
    join(at, end, {});
    return at == 0 ? 0 : at - 1;
  }

  std::size_t cdata(std::size_t at) {
    constexpr std::size_t kStart = 9, kEnd = 3;
    const auto end = behind(at + kStart, "]]>");
    if (end == text_.size() || !is_in_value(at, end) || ++joined_ > kMaxJoined) return end - 1;
    const auto inside = text_.substr(at + kStart, end - kEnd - at - kStart);
    if (inside.find_first_of("<&") != inside.npos) return end - 1;
    join(at, end, inside);
    return at == 0 ? 0 : at - 1;
  }

  // Returns the place of the last octet before `at` that is not blank. Comments that were blanked
  // one after the other are passed only once.
  std::size_t last_before(std::size_t at) {
    if (at < seen_) {
      seen_ = 0;
      last_seen_ = text_.npos;
    }
    const auto found = std::string_view(text_).substr(seen_, at - seen_).find_last_not_of(kBlanks);
    if (found != text_.npos) last_seen_ = seen_ + found;
    seen_ = at;
    return last_seen_;
  }

  // True if the comment or CDATA has text other than blanks beside it, between two tags.
  bool is_in_value(std::size_t at, std::size_t end) {
    const auto before = last_before(at);
    const auto after = text_.find_first_not_of(kBlanks, end);
    const auto is_text = [&](std::size_t i, char tag) {
      return i < text_.size() && text_[i] != tag;
    };
    const bool has_piece_after = text_.compare(std::min(end, text_.size()), 9, "<![CDATA[") == 0;
    return is_text(before, '>') || is_text(after, '<') || has_piece_after;
  }

  // Joins the pieces as Cyclone DDS does. To keep the number of lines, the line breaks of the piece
  // are put after the element.
  void join(std::size_t at, std::size_t end, const std::string& instead) {
    const auto lines = std::count(text_.begin() + static_cast<std::ptrdiff_t>(at),
                                  text_.begin() + static_cast<std::ptrdiff_t>(end), '\n') -
                       std::ranges::count(instead, '\n');
    text_.replace(at, end - at, instead);
    text_.insert(behind(at, ">"), static_cast<std::size_t>(lines), '\n');
    has_pieces_ = true;
  }

  void octets() {
    const auto status = check_xml(text_);
    if (status || status.error().code() != Code::xml_encoding) return;
    for (char& c : text_)
      if (static_cast<unsigned char>(c) >= 0x80) c = '?';
    note(Variant::governance_latin_1);
  }

  std::string text_;
  std::vector<Variant> left_out_;
  std::vector<std::string> open_;  // names of the elements around this place
  bool has_root_ = false;
  bool is_refused_by_fastdds_ = false;
  bool has_pieces_ = false;
  std::size_t joined_ = 0;
  std::size_t seen_ = 0;                       // until where last_before() has looked
  std::size_t last_seen_ = std::string::npos;  // the last octet there that is not blank
};

}  // namespace

LenientText lenient_text(BytesView xml) { return Cleaner(std::string(as_text(xml))).run(); }

}  // namespace ddssec::governance::doctor
