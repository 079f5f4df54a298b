#include "governance/name_automaton.hpp"

#include <algorithm>
#include <iterator>

namespace ddssec::governance {
namespace {

constexpr std::uint32_t kNoLabel = std::numeric_limits<std::uint32_t>::max();

void append(std::vector<std::uint32_t>& to, std::span<const std::uint32_t> what) {
  to.insert(to.end(), what.begin(), what.end());
}

void sort_unique(std::vector<std::uint32_t>& list) {
  if (!std::ranges::is_sorted(list)) std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

NameAutomaton::NameAutomaton(std::span<const RankedExpression> expressions, const SetLimits& limits,
                             Goal goal)
    : limits_(limits),
      table_(expressions),
      by_class_(table_.classes().size()),
      is_star_now_(table_.size()),
      is_star_next_(table_.size()),
      settled_from_(table_.lists(), kNoLabel) {
  for (const auto list : goal.with) goal_with_ |= 1u << list;
  for (const auto list : goal.without) goal_without_ |= 1u << list;
}

NameAutomaton::End NameAutomaton::run() {
  if (limits_.shared != nullptr) limits_.steps = std::min(limits_.steps, limits_.shared->steps);
  const auto end = search();
  if (limits_.shared != nullptr)
    limits_.shared->steps -= std::min(limits_.shared->steps, steps_taken_);
  return end;
}

NameAutomaton::End NameAutomaton::search() {
  settled_labels_.add({});
  stars_.add({});
  arrivals_ = table_.beginnings();
  arrive({});
  for (State state = 0; state < states_.size(); ++state) {
    if (goal_ && goal_->from != kNowhere) return End::goal_reached;
    expand(state);
    if (limit_reached()) break;
  }
  if (goal_) return End::goal_reached;
  return limit_reached() ? End::limit_reached : End::complete;
}

bool NameAutomaton::limit_reached() const {
  const auto held = states_.weight() + stars_.weight() + settled_labels_.weight() +
                    acceptances_.weight() + moves_held_;
  return states_.size() > limits_.states || acceptances_.size() > limits_.atoms ||
         steps_taken_ > limits_.steps || held > limits_.memory;
}

void NameAutomaton::expand(State state) {
  const auto key = states_[state];
  settled_labels_now_ = key[0];
  stars_now_ = key[1];
  here_.assign(key.begin() + 2, key.end());
  collect_moves();
  const StarMoves& moves = moves_of(stars_now_);
  bool others_done = false;
  for (std::size_t i = 0; i < by_class_.size() && !limit_reached(); ++i) {
    const auto c = static_cast<Class>(i);
    const bool own = !by_class_[c].empty() || !moves.of(c).empty();
    // All classes that no expression names lead to the same state; the first of them is the most
    // readable.
    if (!own && std::exchange(others_done, true)) continue;
    gather_arrivals(moves, own ? std::optional(c) : std::nullopt);
    arrive({state, c});
  }
}

void NameAutomaton::collect_moves() {
  for (auto& list : by_class_) list.clear();
  any_.clear();
  ++expand_count_;
  for (const Position star : stars_[stars_now_]) is_star_now_[star] = expand_count_;
  steps_taken_ += here_.size() + stars_[stars_now_].size() + by_class_.size();
  for (const Position p : here_) {
    switch (table_.kind(p)) {
      case Kind::octet:
        if (table_.octet(p) != ByteClasses::kNone) {
          by_class_[table_.octet(p)].push_back(table_.next(p));
        }
        break;
      case Kind::any:
        any_.push_back(table_.next(p));
        break;
      case Kind::set:
        for (const auto c : table_.set(p)) by_class_[c].push_back(table_.next(p));
        steps_taken_ += table_.set(p).size();
        break;
      case Kind::star:  // is among stars_
      case Kind::end:
        break;
    }
  }
}

const NameAutomaton::StarMoves& NameAutomaton::moves_of(ListId stars) {
  const auto [entry, is_new] = star_moves_.try_emplace(stars);
  if (is_new) {
    entry->second = make_moves(stars_[stars]);
    const auto held = entry->second.by_class.size() + entry->second.any.size();
    moves_held_ += held + entry->second.begin.size();
    steps_taken_ += 2 * held;
  }
  return entry->second;
}

NameAutomaton::StarMoves NameAutomaton::make_moves(std::span<const Position> stars) const {
  std::vector<std::pair<std::uint32_t, Position>> pairs;
  StarMoves moves;
  for (const Position star : stars) {
    // A star may match nothing, so the position after it is tried at once.
    const Position p = table_.next(star);
    if (table_.kind(p) == Kind::any) moves.any.push_back(table_.next(p));
    if (table_.kind(p) == Kind::octet && table_.octet(p) != ByteClasses::kNone) {
      pairs.emplace_back(table_.octet(p), table_.next(p));
    }
    if (table_.kind(p) != Kind::set) continue;
    for (const auto c : table_.set(p)) pairs.emplace_back(c, table_.next(p));
  }
  std::ranges::sort(moves.any);
  std::ranges::sort(pairs);
  moves.begin.assign(by_class_.size() + 1, 0);
  for (const auto& [c, p] : pairs) {
    ++moves.begin[c + 1u];
    moves.by_class.push_back(p);
  }
  for (std::size_t c = 1; c < moves.begin.size(); ++c) moves.begin[c] += moves.begin[c - 1];
  return moves;
}

void NameAutomaton::gather_arrivals(const StarMoves& moves, std::optional<Class> by) {
  arrivals_.assign(any_.begin(), any_.end());
  if (by) append(arrivals_, by_class_[*by]);
  sort_unique(arrivals_);
  // The positions after a star are sorted already and may be many, so they are merged and not
  // sorted again.
  const auto merge = [this](std::span<const Position> list) {
    if (list.empty()) return;
    scratch_.clear();
    std::ranges::merge(arrivals_, list, std::back_inserter(scratch_));
    arrivals_.swap(scratch_);
  };
  if (by) merge(moves.of(*by));
  merge(moves.any);
  arrivals_.erase(std::unique(arrivals_.begin(), arrivals_.end()), arrivals_.end());
}

void NameAutomaton::arrive(Origin origin) {
  steps_taken_ += arrivals_.size() + 1;
  next_.clear();
  new_stars_.clear();
  labels_.clear();
  for (const Position p : arrivals_) {
    const Position before = table_.star_before(p);
    if (before != ExpressionTable::kNone && is_star_now_[before] == expand_count_) continue;
    if (table_.is_final_star(p)) {
      append(labels_, table_.labels(p));
    } else {
      (table_.kind(p) == Kind::star ? new_stars_ : next_).push_back(p);
    }
  }
  settled_labels_next_ = settled_labels_now_;
  stars_next_ = stars_now_;
  if (!new_stars_.empty()) move_stars();
  if (!labels_.empty()) settle();
  enter(origin);
}

void NameAutomaton::move_stars() {
  append(new_stars_, stars_[stars_now_]);
  sort_unique(new_stars_);
  ++move_count_;
  for (const Position star : new_stars_) is_star_next_[star] = move_count_;
  steps_taken_ += 2 * new_stars_.size() + next_.size();
  const auto covered = [this](Position p) { return is_covered(p); };
  std::erase_if(new_stars_, covered);
  std::erase_if(next_, covered);
  stars_next_ = stars_.add(new_stars_).first;
}

// Returns false without searching further once the steps are used up: a covered position that stays
// costs memory, but changes no answer.
bool NameAutomaton::is_covered(Position p) {
  const Position before = table_.star_before(p);
  if (before != ExpressionTable::kNone && is_star_next_[before] == move_count_) return true;
  for (p = table_.star_ahead(p); p != ExpressionTable::kNone && steps_taken_ <= limits_.steps;
       p = table_.star_ahead(p)) {
    ++steps_taken_;
    if (is_star_next_[p] == move_count_) return true;
  }
  return false;
}

void NameAutomaton::settle() {
  append(labels_, settled_labels_[settled_labels_now_]);
  steps_taken_ += labels_.size();
  table_.keep_first_of_each_list(labels_);
  settled_labels_next_ = settled_labels_.add(labels_).first;
  if (settled_labels_next_ == settled_labels_now_) return;
  for (const Label label : labels_) settled_from_[table_.list_number(label)] = label;
  const auto settled = [this](Position p) { return is_settled(p); };
  std::erase_if(next_, settled);
  scratch_.assign(stars_[stars_next_].begin(), stars_[stars_next_].end());
  steps_taken_ += next_.size() + scratch_.size();
  std::erase_if(scratch_, settled);
  stars_next_ = stars_.add(scratch_).first;
  for (const Label label : labels_) settled_from_[table_.list_number(label)] = kNoLabel;
}

bool NameAutomaton::is_settled(Position p) const {
  // Labels ascend by list and then rank.
  return std::ranges::all_of(table_.labels(p), [this](Label label) {
    return label >= settled_from_[table_.list_number(label)];
  });
}

void NameAutomaton::enter(Origin origin) {
  if (goal_with_ != 0 && is_hopeless()) return;
  scratch_.assign({settled_labels_next_, stars_next_});
  append(scratch_, next_);
  const auto [state, is_new] = states_.add(scratch_);
  if (is_new) {
    origins_.push_back(origin);
    acceptance_of_.push_back(acceptance());
  }
  note_acceptance(state, origin);
}

NameAutomaton::ListId NameAutomaton::acceptance() {
  labels_.assign(settled_labels_[settled_labels_next_].begin(),
                 settled_labels_[settled_labels_next_].end());
  for (const Position p : next_) {
    if (table_.kind(p) == Kind::end) append(labels_, table_.labels(p));
  }
  steps_taken_ += labels_.size();
  table_.keep_first_of_each_list(labels_);
  return acceptances_.add(labels_).first;
}

void NameAutomaton::note_acceptance(State state, Origin origin) {
  const ListId accepted = acceptance_of_[state];
  const bool is_new = accepted == witnesses_.size();
  if (is_new) witnesses_.push_back(origin);
  // The empty name is the example only if there is no other name.
  const bool is_better = !is_new && witnesses_[accepted].from == kNowhere;
  if (is_better) witnesses_[accepted] = origin;
  if ((is_new || is_better) && goal_with_ != 0 && reaches_goal(acceptances_[accepted]))
    goal_ = origin;
}

bool NameAutomaton::reaches_goal(std::span<const Label> labels) const {
  std::uint32_t lists = 0;
  for (const Label label : labels) lists |= 1u << table_.match(label).list;
  return (lists & goal_with_) == goal_with_ && (lists & goal_without_) == 0;
}

bool NameAutomaton::is_hopeless() const {
  std::uint32_t lists = 0;
  for (const Label label : settled_labels_[settled_labels_next_])
    lists |= 1u << table_.match(label).list;
  if ((lists & goal_without_) != 0) return true;
  const auto add_lists = [&](std::span<const Position> positions) {
    for (std::size_t i = 0; i < positions.size() && (lists & goal_with_) != goal_with_; ++i) {
      for (const Label label : table_.labels(positions[i])) {
        lists |= 1u << table_.match(label).list;
      }
    }
  };
  add_lists(next_);
  add_lists(stars_[stars_next_]);
  return (lists & goal_with_) != goal_with_;
}

std::string NameAutomaton::name_of(Origin origin) const {
  std::string name;
  for (; origin.from != kNowhere; origin = origins_[origin.from]) {
    name += table_.classes().shown(origin.by);
  }
  std::ranges::reverse(name);
  return name;
}

std::vector<NameAtom> NameAutomaton::atoms() const {
  std::vector<NameAtom> atoms(witnesses_.size());
  for (ListId id = 0; id < witnesses_.size(); ++id) {
    for (const Label label : acceptances_[id]) atoms[id].matches.push_back(table_.match(label));
    atoms[id].witness = name_of(witnesses_[id]);
  }
  std::ranges::sort(atoms, {}, [](const NameAtom& atom) {
    return std::pair(atom.witness.size(), std::string_view(atom.witness));
  });
  return atoms;
}

}  // namespace ddssec::governance
