#include <algorithm>
#include <optional>
#include <utility>

#include "nlp/feasibility.hpp"
#include "search/earlier_plan.hpp"
#include "search/parameters.hpp"
#include "search/planner.hpp"
#include "search/task.hpp"

namespace tendril {
void Planner::attempt(ModeState& state, const StartShape& shape, const std::vector<int>& regions) {
  const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
  PoseProgramSpec spec = d_.spec(mode, regions, d_.nodes);
  // Check points are rows: they change no variable.
  const PoseProgram bare(spec);
  const Eigen::VectorXd start = bare.start_from(shape);
  std::vector<CheckPoint> checks = d_.first_checks(bare, start, shape);
  const bool required = d_.min_force > 0.0;
  // From a start without a feasible point near, a solver takes far the longest, and mostly in vain: the contact is on
  // a part of the finger that cannot hold the object. It is spent only where nothing else led to a plan.
  if (search_parameters().defer && balanced_by_row() && (deferring_ || have_plan_) && !promising(spec, checks, start)) {
    state.deferred = true;
    if (!state.best.has_point) state.trouble = "nothing feasible is near its starts, and there is a plan without it";
    return;
  }
  // From the same start, with every place checked where the rod went through an obstacle before.
  const auto search = [&](Branch branch) {
    bool touching = false;
    for (int retry = 0; retry <= search_parameters().most_retries && !must_stop(); ++retry) {
      spec.checks = checks;
      PoseProgram program(spec);
      Eigen::VectorXd x = start;
      if ((proving_ || hurried()) && nothing_near(state, program, x)) break;
      // Of many values most follow from the moments: what a solver would do with all of them takes it minutes.
      if (solved_reduced(mode)) {
        if (!come_to_point(state, program, x)) break;
        touching = true;
        if (complete(state, regions, checks, x, branches_of(program))) break;
        continue;
      }
      if (!radius_homotopy(state, spec, shape, branch, program, x) && !find_point(state, program, x, branch)) {
        if (state.last.status == SolveStatus::not_finite) record_unfit_term(program, x);
        break;
      }
      const std::vector<Branch> branches = branches_of(program);
      touching = std::all_of(branches.begin(), branches.end(), [](Branch b) { return b == Branch::touching; });
      if (complete(state, regions, checks, x, branches)) break;
      touching = false;
    }
    return touching;
  };
  const int stationary_before = state.stationary_violations;
  // A contact that does not touch belongs to a smaller mode, and has its proof there.
  const bool direct = required || proving_ || solved_reduced(mode);
  const bool touching = search(direct ? Branch::touching : Branch::open);
  // A contact that the treatment let go, or could not decide: the branch that touches is a program of its own. It is
  // part of the one just searched, so where that has nothing feasible and a plan is at hand, it is not searched again.
  const bool hopeless = have_plan_ && !state.best.has_point && state.stationary_violations > stationary_before;
  const bool out_of_time = hurried() && state.stationary_violations > stationary_before;
  const bool missing =
      !mode.contacts.empty() && !direct && !hopeless && !out_of_time && (!touching || !state.best.certified());
  if (missing && !must_stop()) search(Branch::touching);
}

bool Planner::promising(PoseProgramSpec spec, const std::vector<CheckPoint>& checks, const Eigen::VectorXd& start) {
  spec.checks = checks;
  PoseProgram program(spec);
  close_contacts(program);
  const bool feasible = restore_feasibility(program, start, restored).feasible;
  steps_.tally.add_outside(program, {});
  return feasible;
}

namespace {

using Pieces = std::vector<int>;  ///< of an unsplit rod: the one that holds each contact

bool holds(const std::vector<Pieces>& all, const Pieces& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

bool may_lie_in(const Chain& chain, const ContactSetup& contact, int piece) {
  return piece >= 0 && piece < chain.piece_count() && chain.piece(piece).stretch == contact.region;
}

/// Other pieces for one contact at a time, nearest first.
std::vector<Pieces> pieces_around(const Chain& chain, const Mode& mode, const Pieces& pieces) {
  std::vector<Pieces> all;
  for (int distance = 1; distance <= search_parameters().most_pieces_away; ++distance) {
    for (const int side : {1, -1}) {
      for (std::size_t k = 0; k < pieces.size(); ++k) {
        Pieces candidate = pieces;
        candidate[k] += side * distance;
        if (!mode.contacts[k].at_tip && may_lie_in(chain, mode.contacts[k], candidate[k])) all.push_back(candidate);
      }
    }
  }
  return all;
}

/// The pieces after a contact that leans against the end of its own went over it; nothing if there is none, or they
/// were tried.
std::optional<Pieces> pieces_beyond(const PoseProgram& program, const Eigen::VectorXd& x, const Mode& mode,
                                    const std::vector<Pieces>& tried) {
  Pieces own(mode.contacts.size(), 0);
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (!mode.contacts[k].at_tip) own[k] = program.spec().contacts[k].region;
  }
  for (std::size_t k = 0; k < own.size(); ++k) {
    if (mode.contacts[k].at_tip) continue;
    const int variable = program.layout().first_arc_length + static_cast<int>(k);
    for (const int side : {-1, 1}) {
      const bool leans = side < 0 ? x[variable] <= program.lower()[variable] + at_knot
                                  : x[variable] >= program.upper()[variable] - at_knot;
      if (!leans || !may_lie_in(program.chain(), mode.contacts[k], own[k] + side)) continue;
      Pieces candidate = own;
      candidate[k] += side;
      if (!holds(tried, candidate)) return candidate;
    }
  }
  return std::nullopt;
}

}  // namespace

void Planner::try_start(ModeState& state, const StartShape& shape) {
  const Mode& mode = modes_[static_cast<std::size_t>(state.mode)];
  ++state.starts_used;
  std::vector<int> regions;
  for (const ContactSetup& c : mode.contacts) regions.push_back(c.region);
  if (d_.scene.coordinates.split_at_contact || mode.contacts.empty()) {
    attempt(state, shape, regions);
    return;
  }
  // Not split: the contact lies inside one piece. Begin with the one where the shape comes nearest, then follow the
  // contact into the neighbouring piece as long as it leans against a piece's end and that helps.
  PoseProgramSpec whole = d_.spec(mode, regions, d_.nodes);
  whole.split = true;  // with stretches for regions, only to place the contacts
  const PoseProgram placer(whole);
  const Eigen::VectorXd placed = placer.start_from(shape);
  const Chain chain(d_.rod, *d_.components.coordinates, {}, 1);
  Pieces pieces(regions.size(), 0);
  for (std::size_t k = 0; k < regions.size(); ++k) {
    if (!mode.contacts[k].at_tip)
      pieces[k] = chain.piece_at(placed[placer.layout().first_arc_length + static_cast<int>(k)], {});
  }
  const std::vector<Pieces> around = pieces_around(chain, mode, pieces);
  std::vector<Pieces> tried;
  StartShape next_shape = shape;
  for (int hop = 0; hop < 2 * chain.piece_count() + 2 && !must_stop(); ++hop) {
    if (holds(tried, pieces)) break;
    tried.push_back(pieces);
    attempt(state, next_shape, pieces);
    if (!state.best.has_point) {
      // No point with the contact in this piece: look into the others, nearest first.
      const auto next = std::find_if(around.begin(), around.end(), [&](const Pieces& p) { return !holds(tried, p); });
      if (next == around.end()) break;
      pieces = *next;
      continue;
    }
    const std::optional<Pieces> beyond = pieces_beyond(*state.best.program, state.best.x, mode, tried);
    if (!beyond) break;
    pieces = *beyond;
    next_shape = state.best.program->shape_of(state.best.x);
  }
}

}  // namespace tendril
