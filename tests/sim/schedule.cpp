#include "tests/sim/schedule.hpp"

namespace ddssec::rtps::sim {
namespace {

// The number of steps of a long siege, which is longer than a dead participant is remembered.
constexpr int kLongSiege = static_cast<int>((Invariants::kMaxMemory + seconds(5)) / World::kStep);

// The number of steps that the crowd needs to fill all tables.
constexpr int kCrowdGathers = 500;

std::vector<std::string> all_topics() { return {kTopics.begin(), kTopics.end()}; }

std::vector<Subject> cast_of(Dice& dice) {
  std::vector<Subject> out;
  const std::array<const char*, 3> honest = {"alice", "bob", "carol"};
  const auto count = 2 + dice.below(2);
  for (std::size_t i = 0; i < count; ++i)
    out.push_back({honest[i], Role::honest, all_topics(), all_topics()});
  const std::array<Subject, 7> others = {
      Subject{"mallory", Role::insider, {std::string(kTopics[2])}, {std::string(kTopics[1])}},
      Subject{"trudy", Role::insider},
      Subject{"frank", Role::forger, all_topics(), all_topics()},
      Subject{"ivan", Role::impostor, {std::string(kTopics[2])}, {std::string(kTopics[1])}},
      Subject{"alice", Role::foreign, all_topics(), all_topics()},
      Subject{"walter", Role::elsewhere, all_topics(), all_topics()},
      Subject{"oscar", Role::borrower}};
  for (const auto& subject : others)
    if (dice.chance(250)) out.push_back(subject);
  return out;
}

// Draws how often an attack is made. Most runs have few kinds of attacks, and these often.
unsigned some(Dice& dice, unsigned most) {
  return dice.chance(500) ? 0 : static_cast<unsigned>(1 + dice.below(most));
}

// Makes a plan with more participants of one certificate than it may have places, and with no other
// attack.
void add_siblings(Plan& plan) {
  constexpr std::size_t kSiblings = Handshakes::kMaxAuthenticated / 2 + 20;
  for (std::size_t i = 0; i < kSiblings; ++i)
    plan.cast.push_back({"sybil", Role::sibling, {}, {std::string(kTopics[0])}});
  plan.temper = plan.siege = {};
  plan.tampers = plan.false_keys = 0;
  plan.restarts = plan.sleeps = plan.calendars = plan.endpoints = 0;
  plan.hostile_steps = 1500;
  plan.siege_steps = 100;
  plan.siege_restart = true;
}

// Makes strangers fill the tables of participants before one of them restarts.
void add_crowd(Plan& plan) {
  plan.siege = {.crowd = 200};
  plan.siege_steps = 100;
  plan.siege_restart = true;
}

// Adds the attacks that were written later. They are drawn apart, so that the other draws of a seed
// stay.
void add_further_attacks(Plan& plan) {
  auto dice = Dice(plan.seed).fork("further");
  plan.false_keys = dice.chance(300) ? static_cast<unsigned>(20 + dice.below(100)) : 0;
  if (dice.chance(250)) {
    plan.temper.announce = static_cast<unsigned>(1 + dice.below(50));
    plan.siege.announce = static_cast<unsigned>(1 + dice.below(50));
  }
  // Where submessages are not protected, a writer matches present readers at once, and these would
  // get each of the samples.
  plan.sparse =
      dice.chance(100) && plan.protection->covers_headers && plan.protection->separates_topics;
  if (dice.chance(10))
    add_siblings(plan);
  else if (dice.chance(20))
    add_crowd(plan);
}

// An insider without any permission is not authenticated, so that it announces no endpoints.
bool is_member(const Subject& one) { return one.role == Role::insider && !one.publishes.empty(); }

// Adds the attacks that were written last, which are drawn apart, too.
void add_latest_attacks(Plan& plan) {
  auto dice = Dice(plan.seed).fork("latest");
  const bool ambushes = dice.chance(100), claims = dice.chance(300);
  const auto often = static_cast<unsigned>(300 + dice.below(700));
  if (plan.siege.crowd > 0 || plan.cast.back().role == Role::sibling) return;
  if (ambushes) {
    plan.temper.ambush = plan.siege.ambush = often;
    plan.siege_restart = true;
  }
  if (claims && std::ranges::any_of(plan.cast, is_member)) plan.claims = often;
}

class Run {
 public:
  explicit Run(const Plan& plan)
      : plan_(plan),
        dice_(Dice(plan.seed).fork("run")),
        world_(*plan.protection, plan.cast, Dice(plan.seed).fork("world"),
               plan.temper.announce > 0) {}

  Outcome operator()() {
    for (const auto& node : world_.nodes()) world_.start(*node);
    if (plan_.meets_first) repeat(300, [] { return false; });
    incite();
    world_.outsider().behave(plan_.temper);
    world_.set_hostile(true);
    for (int i = 0; i < plan_.hostile_steps && !is_over(); ++i) hostile_step();
    world_.set_hostile(false);
    revive();
    if (plan_.sparse && !is_over()) add_sparse_writer();
    if (!is_over()) reunite(invariant::kReunion);
    if (!is_over()) exchange();
    if (!is_over()) withstand();
    return outcome();
  }

 private:
  bool is_over() const { return world_.violation().has_value(); }
  void step() {
    ++steps_;
    world_.step();
  }
  // Runs up to that many steps. Returns true once `done` does.
  bool repeat(int steps, const std::function<bool()>& done) {
    for (int i = 0; i < steps && !is_over(); ++i) {
      if (done()) return true;
      step();
    }
    return done();
  }
  Node& any_node() { return *dice_.of(world_.nodes()); }
  // Returns the insider that exists if any claims are made.
  Node& insider() {
    return **std::ranges::find_if(world_.nodes(),
                                  [](const auto& node) { return is_member(node->subject()); });
  }
  void incite() {
    world_.malice().tampers = plan_.tampers;
    world_.malice().false_keys = plan_.false_keys;
    world_.malice().claims = plan_.claims;
  }
  void hostile_step() {
    step();
    if (dice_.chance(plan_.writes)) write();
    if (dice_.chance(plan_.restarts)) restart();
    if (dice_.chance(plan_.sleeps))
      any_node().sleep_until(world_.now() + milliseconds(dice_.below(40'000)));
    if (dice_.chance(plan_.calendars))
      any_node().set_calendar(seconds(dice_.below(7200)) - seconds(3600));
    if (dice_.chance(plan_.endpoints)) change_endpoints(any_node());
  }
  void write() {
    auto& node = any_node();
    if (node.is_running() && !node.endpoints().empty()) node.write(*dice_.of(node.endpoints()));
  }
  void restart() {
    auto& node = any_node();
    if (!node.is_running()) return world_.start(node);
    node.stop(dice_.chance(300));
    if (dice_.chance(700)) world_.start(node);
  }
  // Adds or removes an endpoint. Honest nodes keep one of each kind, which the reunion looks for.
  void change_endpoints(Node& node) {
    if (!node.is_running()) return;
    constexpr std::size_t kKept = 2 * kTopics.size(), kMax = 40;
    if (node.endpoints().size() < kMax && dice_.chance(600))
      node.add_endpoint(dice_.of(kTopics), dice_.chance(500));
    else if (node.endpoints().size() > kKept)
      node.remove_endpoint(kKept + dice_.below(node.endpoints().size() - kKept));
  }

  void revive() {
    for (const auto& node : world_.nodes()) {
      node->sleep_until({});
      if (!node->is_running()) world_.start(*node);
    }
  }
  // Adds a sparse writer, and readers that come after all that it wrote. The first nodes are
  // honest.
  void add_sparse_writer() {
    constexpr std::int64_t kNumbers = 1'000'000;
    world_.nodes()[1]->add_sparse_writer(kTopics[1], kNumbers);
    for (const bool reliable : {true, false})
      world_.nodes()[0]->add_durable_reader(kTopics[1], reliable);
  }
  // Calls `f(writer, reader)` for each honest pair, each writer with the node that owns it.
  void each_pair(const std::function<void(Node&, Endpoint&, Endpoint&)>& f) {
    for (const auto& a : world_.nodes())
      for (const auto& b : world_.nodes()) {
        if (a == b || !a->is_honest() || !b->is_honest()) continue;
        for (const auto& writer : a->endpoints())
          for (const auto& reader : b->endpoints())
            if (writer->end().writes && !reader->end().writes &&
                writer->end().topic == reader->end().topic &&
                (writer->end().durable || !reader->end().durable))
              f(*a, *writer, *reader);
      }
  }
  std::string unmatched() {
    std::string out;
    each_pair([&](Node&, Endpoint& writer, Endpoint& reader) {
      const bool there = writer.matched_since(reader.end().guid) != kNever;
      const bool back = reader.matched_since(writer.end().guid) != kNever;
      if (there && back) return;
      out = describe(writer.end()) + (there ? " (matched)" : "") + " and " +
            describe(reader.end()) + (back ? " (matched)" : "");
    });
    return out;
  }
  // Returns, for each honest node, the participants that it knows and the events that it raised.
  std::string relations() {
    std::string out;
    for (const auto& a : world_.nodes()) {
      if (!a->is_honest()) continue;
      out += "\n  " + a->subject().name + " " + a->prefix().to_string() + " knows";
      for (const auto& b : world_.nodes())
        if (a->participant().is_authenticated(b->prefix())) out += " " + b->subject().name;
      for (const auto& [code, count] : a->events())
        out += "; " + std::string(info(code).name) + " " + std::to_string(count);
    }
    return out;
  }
  void reunite(std::string_view invariant, MonotonicTime most = Invariants::kMaxReunion) {
    const auto begin = world_.now();
    if (!repeat(static_cast<int>(most / World::kStep), [&] { return unmatched().empty(); }) &&
        !is_over())
      world_.invariants().fail(invariant, unmatched() + relations());
    reunion_ = std::max(reunion_, world_.now() - begin);
  }
  // True if the reader has all that the writer holds, or is not one that gets what was written
  // before it.
  bool has_all_held(const Endpoint& reader, const Guid& writer) {
    const bool gets_all = reader.end().durable && reader.end().is_reliable;
    return !gets_all || std::ranges::all_of(world_.ledger().held(writer), [&](const auto& one) {
      return reader.has(writer, one.first);
    });
  }
  std::string missing() {
    std::string out;
    if (!plan_.protection->covers_headers) return out;
    each_pair([&](Node&, Endpoint& writer, Endpoint& reader) {
      const auto since = std::max(writer.matched_since(reader.end().guid),
                                  reader.matched_since(writer.end().guid));
      if (since == kNever) return;
      const auto& guid = writer.end().guid;
      if (writer.end().durable) {
        if (!has_all_held(reader, guid)) out = "what is held for " + describe(reader.end());
        return;
      }
      for (std::int64_t i = world_.ledger().count(guid); i > 0; --i) {
        const auto* sample = world_.ledger().written(guid, {i});
        if (sample->when <= since) break;
        if (!reader.has(guid, {i}))
          out = "number " + std::to_string(i) + " of " + describe(writer.end()) + " to " +
                describe(reader.end());
      }
    });
    return out;
  }
  void exchange() {
    step();
    for (const auto& node : world_.nodes())
      if (node->is_honest())
        for (const auto& endpoint : node->endpoints()) node->write(*endpoint);
    if (!repeat(static_cast<int>(Invariants::kMaxExchange / World::kStep),
                [&] { return missing().empty(); }) &&
        !is_over())
      world_.invariants().fail(invariant::kLoss, missing());
  }
  // Besieges the honest participants. What began in the hostile phase, such as another handshake,
  // ends before.
  void withstand() {
    repeat(static_cast<int>(seconds(15) / World::kStep), [] { return false; });
    world_.set_hostile(true);
    world_.outsider().behave(plan_.siege);
    incite();
    world_.invariants().set_besieged(true);
    const bool crowded = plan_.siege.crowd > 0;
    if (crowded) repeat(kCrowdGathers, [] { return false; });
    if (plan_.siege_restart) {
      auto& victim = *world_.nodes().front();
      victim.stop(false);
      world_.start(victim);
    }
    repeat(plan_.siege_steps, [&] {
      if (plan_.claims > 0 && dice_.chance(plan_.claims / 10)) change_endpoints(insider());
      return false;
    });
    if (!is_over())
      reunite(invariant::kNewcomer, crowded ? Invariants::kMaxInCrowd : Invariants::kMaxReunion);
    if (!is_over()) exchange();
    world_.invariants().set_besieged(false);
    if (!is_over()) world_.check_dead();
  }
  Outcome outcome() {
    Outcome out{.violation = world_.violation(),
                .step = steps_,
                .fingerprint = world_.fingerprint(),
                .datagrams = world_.delivered(),
                .most = {},
                .most_branches = world_.invariants().most_branches(),
                .most_handshakes = world_.invariants().most_handshakes(),
                .reunion = reunion_};
    for (const auto& node : world_.nodes())
      if (node->is_honest() && node->cost().most_octets > out.most.most_octets)
        out.most = node->cost();
    return out;
  }

  const Plan& plan_;
  Dice dice_;
  World world_;
  long steps_ = 0;
  MonotonicTime reunion_{};
};

}  // namespace

Plan plan_of(std::uint64_t seed, int steps) {
  auto dice = Dice(seed).fork("plan");
  Plan plan{.seed = seed, .protection = &dice.of(protections()), .cast = cast_of(dice)};
  plan.temper = {.drop = some(dice, 300),
                 .duplicate = some(dice, 300),
                 .delay = some(dice, 500),
                 .mangle = some(dice, 200),
                 .cut_short = some(dice, 50),
                 .splice = some(dice, 200),
                 .bridge = some(dice, 1000),
                 .muffle = dice.chance(100) ? 1000u : 0u,
                 .silence = some(dice, 5),
                 .replay = some(dice, 300),
                 .forge = some(dice, 200)};
  plan.siege = {.duplicate = some(dice, 300),
                .splice = some(dice, 200),
                .replay = some(dice, 300),
                .forge = some(dice, 200)};
  plan.siege_steps = static_cast<int>(100 + dice.below(300));
  if (dice.chance(100)) {
    plan.siege_steps += kLongSiege;
    plan.siege.replay = std::max(plan.siege.replay, 100u);
    plan.siege_restart = true;
  }
  if (dice.chance(250)) plan.siege_restart = true;
  plan.tampers = some(dice, 200);
  plan.hostile_steps = static_cast<int>(500 + dice.below(2500));
  // This is longer than handshakes and leases last.
  if (dice.chance(plan.temper.muffle > 0 ? 500 : 40)) plan.hostile_steps += 11'000;
  if (steps > 0) plan.hostile_steps = steps;
  plan.meets_first = dice.chance(500);
  plan.writes = 100;
  plan.restarts = some(dice, 4);
  plan.sleeps = some(dice, 4);
  plan.calendars = some(dice, 4);
  plan.endpoints = some(dice, 30);
  add_further_attacks(plan);
  add_latest_attacks(plan);
  return plan;
}

std::string describe(const Plan& plan) {
  std::string out = "seed " + std::to_string(plan.seed) + ", " +
                    std::string(plan.protection->name) + ", " + std::to_string(plan.hostile_steps) +
                    " hostile steps:";
  for (const auto& subject : plan.cast)
    if (subject.role != Role::sibling) out += " " + subject.name;
  if (plan.cast.back().role == Role::sibling) out += " siblings";
  const auto add = [&](const char* name, unsigned value) {
    if (value > 0) out += std::string("; ") + name + " " + std::to_string(value);
  };
  const auto& t = plan.temper;
  add("drop", t.drop), add("duplicate", t.duplicate), add("delay", t.delay);
  add("mangle", t.mangle), add("cut short", t.cut_short), add("splice", t.splice);
  add("bridge", t.bridge), add("muffle", t.muffle), add("silence", t.silence),
      add("replay", t.replay), add("forge", t.forge), add("announce", t.announce),
      add("ambush", t.ambush);
  const auto& s = plan.siege;
  add(plan.siege_steps >= kLongSiege ? "long siege" : "siege",
      static_cast<unsigned>(plan.siege_steps));
  add("duplicate", s.duplicate), add("splice", s.splice), add("replay", s.replay),
      add("forge", s.forge), add("announce", s.announce), add("crowd", s.crowd),
      add("ambush", s.ambush);
  add("tamper", plan.tampers), add("restart", plan.restarts), add("sleep", plan.sleeps);
  add("calendar", plan.calendars), add("endpoints", plan.endpoints);
  add("false keys", plan.false_keys), add("claims", plan.claims);
  if (plan.sparse) out += "; sparse history";
  if (plan.siege_restart) out += "; restart in the siege";
  out += plan.meets_first ? "; meets first" : "; meets late";
  return out;
}

Outcome run(const Plan& plan) { return Run(plan)(); }

}  // namespace ddssec::rtps::sim
