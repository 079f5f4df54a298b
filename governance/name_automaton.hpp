// The automaton used by topic_sets.hpp: it follows all expressions at once, state by state.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "governance/expression_table.hpp"
#include "governance/number_lists.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance {

/// Explores the states of all expressions together, breadth first, and records every acceptance.
///
/// A position is a place in one of the expressions, before one of its octets or stars, or at its
/// end. A state is what a name can lead to, and has three parts:
/// - the settled labels: what matches whatever follows. An expression whose last step is a star
///   settles its label when the star is reached. Entries with an equal or higher rank in the same
///   list no longer matter then, so their positions are left out.
/// - the positions of stars: once reached, a star stays in every later state.
/// - all other positions. Those before a star that was reached already are covered by it, since it
///   matches whatever they could, and are left out.
///
/// With the expressions `a*b` and `*` of two lists, the empty name settles the label of `*`, and
/// leads to the position before `a`. After "a" the state has the star of `a*b`; the position before
/// `b` is not stored, because moves_of() tries it for each star. After "ab" it has the end of `a*b`
/// as well: this state accepts both labels, and "ab" is its witness. After "abc" the end is gone,
/// and the state is that of "a" again.
class NameAutomaton {
 public:
  /// The goal of a search. Without `with`, every atom is wanted.
  struct Goal {
    std::vector<std::uint32_t> with = {};     ///< lists that must match, below 32
    std::vector<std::uint32_t> without = {};  ///< lists that must not match, below 32
  };
  enum class End : std::uint8_t { complete, goal_reached, limit_reached };

  NameAutomaton(std::span<const RankedExpression> expressions, const SetLimits& limits, Goal goal);

  /// Runs the search; may be called once. With a goal it stops at the first name, except the empty
  /// one, that reaches it.
  End run();
  /// Returns the atoms found, shortest name first. Valid after run().
  std::vector<NameAtom> atoms() const;
  /// Returns the name that reaches the goal. Valid after goal_reached.
  std::string goal_name() const { return name_of(*goal_); }

 private:
  using Position = ExpressionTable::Position;
  using Label = ExpressionTable::Label;
  using Class = ByteClasses::Class;
  using Kind = ExpressionTable::Kind;
  using State = std::uint32_t;
  using ListId = NumberLists::Id;

  /// The last octet of a name and the state before it.
  struct Origin {
    State from = kNowhere;
    Class by = 0;
  };
  static constexpr State kNowhere = std::numeric_limits<State>::max();

  /// The moves of a set of stars.
  struct StarMoves {
    std::vector<std::uint32_t> begin;  ///< beginning of each class in `by_class`, and the end
    std::vector<Position> by_class;
    std::vector<Position> any;
    std::span<const Position> of(Class c) const {
      return std::span(by_class).subspan(begin[c], begin[c + 1] - begin[c]);
    }
  };

  End search();
  void expand(State state);
  void collect_moves();
  const StarMoves& moves_of(ListId stars);
  StarMoves make_moves(std::span<const Position> stars) const;
  void gather_arrivals(const StarMoves& moves, std::optional<Class> by);
  void arrive(Origin origin);
  void move_stars();
  bool is_covered(Position p);
  void settle();
  bool is_settled(Position p) const;
  void enter(Origin origin);
  ListId acceptance();
  void note_acceptance(State state, Origin origin);
  bool reaches_goal(std::span<const Label> labels) const;
  bool is_hopeless() const;
  bool limit_reached() const;
  std::string name_of(Origin origin) const;

  SetLimits limits_;
  ExpressionTable table_;
  std::uint32_t goal_with_ = 0, goal_without_ = 0;  ///< one bit for each list
  std::optional<Origin> goal_;

  NumberLists settled_labels_;  ///< labels that match whatever follows
  NumberLists stars_;           ///< positions of stars
  NumberLists states_;          ///< an id in settled_labels_, an id in stars_, and positions
  NumberLists acceptances_;     ///< labels
  std::unordered_map<ListId, StarMoves> star_moves_;
  std::vector<Origin> origins_;        ///< one for each state
  std::vector<ListId> acceptance_of_;  ///< one for each state
  std::vector<Origin> witnesses_;      ///< one for each acceptance
  std::size_t steps_taken_ = 0, moves_held_ = 0;

  // The registers of one step: expand() fills the first group from a state, gather_arrivals() and
  // arrive() the second one for each class of octets.
  ListId settled_labels_now_ = 0, stars_now_ = 0;
  std::vector<Position> here_;
  std::vector<std::vector<Position>> by_class_;
  std::vector<Position> any_;
  /// Holds for each position: expand_count_ if it is a star before the step.
  std::vector<std::uint32_t> is_star_now_;
  /// Holds for each position: move_count_ if it is a star after the step.
  std::vector<std::uint32_t> is_star_next_;
  std::uint32_t expand_count_ = 1, move_count_ = 0;
  // The second group: the state after the step.
  ListId settled_labels_next_ = 0, stars_next_ = 0;
  std::vector<Position> arrivals_, next_, new_stars_;
  std::vector<Label> labels_;
  std::vector<Label> settled_from_;  ///< for each list, while settle() is at work
  std::vector<std::uint32_t> scratch_;
};

}  // namespace ddssec::governance
