// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/island.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "event_driven/mode_changes.h"
#include "preparation/law_report.h"
#include "scene/element_numbers.h"
#include "scene/touching_laws.h"
#include "simulation/solver_options.h"

namespace gelenk {
namespace {

// Change of a prescribed motion or its rate that is a jump, of its magnitude or 1: more than the rounding of a master.
constexpr double jump_tolerance = 1e-10;

}  // namespace

bool is_kinematic(const Scene& scene, const PreparedIsland& prepared, Formulation& equations) {
  return scene.solver.reduces(Reduction::kinematic) && scene.solver.integrator == "auto" &&
         scene.solver.formulation == "projection" && prepared.is_positioned() && equations.modes().indicators() == 0;
}

Island::Island(const Scene& scene, PreparedIsland prepared, Loads loads, Inputs& u, double time)
    : scene_(scene),
      prepared_(std::move(prepared)),
      loads_(std::move(loads)),
      best_pivot_ratio_(prepared_.mobility.known_pivot_ratio()),
      dynamics_(make_dynamics(prepared_.mechanism, loads_, !scene.solver.reduces(Reduction::outputs))),
      program_(prepared_.mechanism, loads_, *dynamics_),
      equations_(make_formulation(scene.solver.formulation, {prepared_.mechanism, *dynamics_, u, events_, loads_,
                                                             options_of(scene, &best_pivot_ratio_),
                                                             traces_equations(scene.solver) ? &program_ : nullptr})),
      time_(time),
      y_(prepared_.start.q),
      vdot_(prepared_.mechanism.nv, 0.0),
      rates_(prepared_.states.size()),
      values_(prepared_.mechanism.expressions.size()),
      inputs_of_scene_(u.signals()) {
  y_.insert(y_.end(), prepared_.start.v.begin(), prepared_.start.v.end());
  y_.insert(y_.end(), prepared_.states.begin(), prepared_.states.end());
  events_.describe(event_texts(), scene.solver.max_events, equations_->modes().own_indicators());
  dynamics_->set_max_rank(prepared_.mobility.rank);
  equations_->start(prepared_.cut_start, time, y_.data());
  follows_ = std::ranges::any_of(mechanism().coordinate_rows, [](const CoordinateRow& row) { return row.input >= 0; });
  if (follows_) equations_->drives().targets_at(time, followed_);
  drives_ = followed_;  // so that steps do not allocate
  make_reading();
}

void Island::start_integrator(double tolerance) {
  if (y_.empty()) return;
  IntegratorOptions options;
  options.tolerance = tolerance;
  options.step = step_of(scene_);
  options.cone_tolerance = scene_.solver.cone_tolerance;
  options.rho_inf = scene_.solver.rho_inf;
  equations_->modes().locks().set_tolerance(tolerance);
  integrator_ = make_integrator(scene_.solver.integrator, *equations_, options);
  record_equations();
  if (is_kinematic(scene_, prepared_, *equations_))
    integrator_ = make_kinematic_steps(*equations_, std::move(integrator_));
  make_reading();
  integrator_->restart(time_, y_.data());
  evaluations_before_ = dynamics_->evaluations();
  warm_up(options.step);
}

void Island::record_equations() {
  if (!traces_equations(scene_.solver) || is_kinematic(scene_, prepared_, *equations_)) return;
  equations_->drives().go_to(time_, y_.data());
  program_.record(equations_->revolutions().coordinates(), y_.data(), equations_->drives());
}

std::vector<std::array<std::string, 2>> Island::event_texts() const {
  std::vector<std::array<std::string, 2>> out;
  for (const SwitchingForce& of : switching_forces_of(loads_)) {
    const Joint& joint = scene_.joints[static_cast<std::size_t>(of.joint)];
    const Coordinate coordinate = coordinate_of(kind_of(*joint.is), of.component);
    const ElementPlace place{.name = {}, .frames = {}, .joints = {joint.name}, .coordinate = {}};
    for (const auto& texts : of.events)
      out.push_back({filled_in(texts[0], place, coordinate), filled_in(texts[1], place, coordinate)});
  }
  for (const BranchPlace& place : branch_places(loads_)) {
    // Where the value does not jump, there is nothing to report.
    const std::string text = place.is_knot ? "" : owner_of_branch(scene_, mechanism(), place) + " changes its branch";
    out.push_back({text, text});
  }
  std::vector<std::string> bodies;
  for (const Body& body : scene_.bodies) bodies.push_back(body.name);
  for (auto& of : equations_->contacts().event_texts(bodies, names_of_touching_laws(scene_))) out.push_back(of);
  return out;
}

// Performs a trial step and undoes it, so that later steps find all memory allocated.
void Island::warm_up(double step) {
  Archive start;
  serialize(start);
  reserve(start.words().size());
  const auto undo = [&] {
    start.start_reading();
    serialize(start);
  };
  std::vector<double> y = y_;
  try {
    integrator_->warm_up(time_ + step, y.data());
    undo();
  } catch (const IntegrationError&) {
    undo();  // reported when the actual step fails
  } catch (const SingularMass&) {
    undo();
  }
}

// words: size of an archive at the start; later it also contains stored accelerations and inputs (projection.cpp) and
// samples near a singular configuration (singularity_monitor.h), and points of contact.
void Island::reserve(std::size_t words) {
  const std::size_t contacts = !mechanism().touches() ? 0 : ContactState::reserved_words;
  replay_.beginning.reserve(words + 16 * (20 + y_.size() + inputs_of_scene_) + contacts);
  if (may_have_history()) replay_.legs.reserve(ReplayHistory::max_legs);
}

// Keeps what roll_back() needs, and where a history will begin. A method with a history has kept it there.
void Island::keep_start() {
  start_ = {.time = time_, .evaluations = evaluations(), .jumped = inputs_jumped_, .shown = shown_};
  if (has_history() && !replay_.legs.empty()) {
    start_.legs = replay_.legs.size();
    start_.last_evaluations = replay_.legs.back().evaluations;
  }
  if (!integrator_ || has_history()) return;
  replay_.clear();
  replay_.beginning.start_writing();
  serialize(replay_.beginning);
  if (!will_have_history()) return;
  // A history begins as it does where it is restored.
  replay_.beginning.start_reading();
  serialize(replay_.beginning);
}

double Island::advance(double end, long max_evaluations, bool continues) {
  keep_start();
  forget_outputs();
  shown_ = false;
  if (!continues) events_.begin(time_);
  equations_->contacts().begin_part(continues);
  events_.begin_part();
  if (integrator_) {
    // A method that restarts because a motion has jumped does so again when its legs are repeated.
    const bool continues_history = has_history();
    if (follows_) enforce_given_motions();
    inputs_jumped_ = loads_changed_ || (inputs_jumped_ && equations_->drives().inputs().jumped());
    if (inputs_jumped_) {
      equations_->inputs_changed(time_, y_.data());
      integrator_->inputs_changed();
    } else if (inputs_touched_ || follows_) {
      integrator_->inputs_touched();
    }
    inputs_touched_ = false;
    if (!continues) integrator_->begin();
    if (will_have_history() && !continues_history) replay_.begin(integrator_->steps());
    ReplayStep leg{end, dynamics_->evaluations(), inputs_jumped_};
    equations_->set_evaluation_budget(max_evaluations);
    time_ = integrator_->advance(end, y_.data());
    inputs_jumped_ = loads_changed_ = false;
    if (follows_) equations_->drives().targets_at(time_, followed_);
    leg.evaluations = dynamics_->evaluations() - leg.evaluations;
    audit();
    remember(leg, continues, time_ == end);
  } else {
    time_ = end;
  }
  return time_;
}

// The legs remain, to which roll_back() may return.
void Island::discard_history() {
  integrator_->discard_history(time_, y_.data());
  replay_.begun = false;
}

// whole: the advance has reached its end. Otherwise the method is not restarted, so that an advance in parts gives the
// same results as one without interruption.
void Island::remember(const ReplayStep& leg, bool continues, bool whole) {
  if (!has_history()) {
    replay_.begun = false;
  } else if (!replay_.begun || !replay_.add(leg, continues) ||
             (whole && integrator_->steps() - replay_.steps > ReplayHistory::max_steps)) {
    discard_history();
  }
}

void Island::replay(const ReplayStep& leg) {
  inputs_jumped_ = leg.jumped;
  if (!(leg.end > time_)) throw std::invalid_argument("it is not of this plant, or damaged");
  try {
    advance(leg.end, leg.evaluations);
  } catch (const IntegrationError&) {
    throw std::invalid_argument("it is not of this plant, or damaged");
  } catch (const SingularMass&) {
    throw std::invalid_argument("it is not of this plant, or damaged");
  }
}

void Island::finish_replay(const ReplayPath& replay_path, double time) {
  if (time_ != time) throw std::invalid_argument("it is not of this plant, or damaged");
  inputs_jumped_ = replay_path.jumped;
  shown_ = replay_path.shown;
  events_.begin_part();  // those of the last leg have been reported
  evaluations_before_ = dynamics_->evaluations() - replay_path.evaluations;
}

// Projects the state onto a motion by inputs that has jumped, by the least change in the mass metric: an impact.
void Island::enforce_given_motions() {
  equations_->drives().targets_at(time_, drives_);
  const auto same = [](double a, double b) { return std::abs(a - b) <= jump_tolerance * (1 + std::abs(a)); };
  if (std::ranges::equal(drives_, followed_, same)) return;
  const std::vector<double> before(y_.begin(), y_.begin() + mechanism().nq);
  const std::vector<int> latched = equations_->modes().changes().latched();
  carry_along();
  followed_ = drives_;
  if (!equations_->project_onto_constraints(time_, y_.data(), true)) {
    throw IntegrationError(
        "the motion prescribed by an input cannot be followed from the present state: projection did not converge");
  }
  equations_->modes().changes().refuse_moved_latches(latched, before.data(), y_.data());
  integrator_->restart(time_, y_.data());
}

// Modes decide on the forces of what is held alone. Outputs of this state use the same evaluation.
LawAudit Island::law_audit() {
  if (equations_->holds_by_modes()) evaluate_outputs();
  return equations_->law_audit(time_, y_.data());
}

void Island::audit() {
  const Drives::AtEndOfStep reading(equations_->drives());
  if (const std::optional<BrokenLaw> broken = law_audit().broken())
    throw IntegrationError(at_time(time_) + describe_broken_law(scene_, loads_, *broken));
}

// A motion of unknown start velocity changes its coordinate alone, and its velocity by that at the start: joints that
// move with it keep theirs, as if the mechanism had been started with that velocity. By the least change they would
// stay behind.
void Island::carry_along() {
  const std::vector<CoordinateRow>& rows = mechanism().coordinate_rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].input < 0 || !rows[i].holds_position || rows[i].terms.size() != 1) continue;
    const MotionSamples* samples = equations_->drives().inputs().samples(rows[i].input);
    const double since_start = samples == nullptr ? 0 : samples->time_since_start();
    if (since_start == 0) continue;
    const MotionLaw::Derivatives s = equations_->drives().target(static_cast<int>(i), time_);
    const CoordinateRow::Term& term = rows[i].terms.front();
    y_[term.q] = s[0] / term.factor;
    y_[mechanism().nq + term.v] = (s[1] - s[2] * since_start) / term.factor;
  }
}

ReplayPath Island::roll_back() {
  ReplayPath path{{}, start_.evaluations, start_.jumped, start_.shown};
  path.legs.assign(replay_.legs.begin(), replay_.legs.begin() + static_cast<std::ptrdiff_t>(start_.legs));
  if (!path.legs.empty()) path.legs.back().evaluations = start_.last_evaluations;
  if (integrator_) {
    replay_.beginning.start_reading();
    serialize(replay_.beginning);
  } else {
    time_ = start_.time;
    forget_outputs();
    events_.begin_part();
  }
  return path;
}

// Writing has no effect on the run.
void Island::serialize(Archive& archive) {
  if (!archive.reading() && has_history()) return archive.append(replay_.beginning);
  long made = evaluations();
  int flags = (inputs_jumped_ ? 1 : 0) + (loads_changed_ ? 2 : 0) + (shown_ ? 4 : 0);
  archive.serialize(time_, y_, made);
  archive.serialize_in_range(flags, 0, 7);
  inputs_jumped_ = (flags & 1) != 0;
  loads_changed_ = (flags & 2) != 0;
  shown_ = (flags & 4) != 0;
  if (follows_) archive.serialize(followed_);
  equations_->serialize(archive);
  if (integrator_) {
    if (archive.reading()) integrator_->restart(time_, y_.data());
    integrator_->serialize(archive);
  }
  if (!archive.reading()) return;
  evaluations_before_ = dynamics_->evaluations() - made;
  forget_outputs();
  replay_.clear();
}

// Accelerations, and the forces that outputs show.
void Island::evaluate_outputs() {
  if (evaluated_) return;
  const long before = dynamics_->evaluations();
  equations_->output_accelerations(time_, y_.data(), vdot_.data());
  // The run that was saved has counted them.
  if (shown_) evaluations_before_ += dynamics_->evaluations() - before;
  shown_ = evaluated_ = true;
}

void Island::realize(Stage stage) {
  if (stage <= realized_) return;
  if (stage == Stage::acceleration) {
    evaluate_outputs();
  } else {
    equations_->drives().go_to_outputs(time_, y_.data());
    dynamics_->set_position(y_.data());
    dynamics_->set_velocity(y_.data() + mechanism().nq);
  }
  dynamics_->readings().set_root_poses();
  if (stage == Stage::acceleration) dynamics_->set_acceleration(vdot_.data());
  realize_named(stage);
}

// Under the inputs, with all quantities up to this stage, that have been set last.
void Island::realize_named(Stage stage) {
  realized_ = stage;
  const double* const u = equations_->drives().u().data();
  if (!rates_.empty()) dynamics_->readings().state_rates(u, rates_.data());
  if (!values_.empty()) dynamics_->readings().expression_values(u, values_.data());
  if (values_.empty() && !force_reader_) return;
  reading_->signals = dynamics_->readings().all_signals(u);
  if (force_reader_ && stage == Stage::acceleration) force_reader_->read(*reading_, rates_.data());
}

// Again when the integrator has decided whether steps are made with impulses.
void Island::make_reading() {
  const RevolutionCounter& turns = equations_->revolutions();
  EventModes& modes = equations_->modes();
  reading_.emplace(Reading{dynamics_->readings(), y_.data(), y_.data() + mechanism().nq, vdot_.data(),
                           turns.coordinates().data(), turns.speeds().data(),
                           y_.data() + mechanism().nq + mechanism().nv, rates_.data(), values_.data(), nullptr,
                           loads_.values.data(), modes.outputs().forces().data(), modes.outputs().sides().data(),
                           &equations_->contacts().readings()});
}

std::vector<MotionLaw::Derivatives> Island::targets() const {
  std::vector<MotionLaw::Derivatives> out;
  for (std::size_t row = 0; row < mechanism().coordinate_rows.size(); ++row)
    out.push_back(equations_->drives().target(static_cast<int>(row), time_));
  return out;
}

Island::Position Island::position() const {
  return {.y = Eigen::Map<const Eigen::VectorXd>(y_.data(), static_cast<Eigen::Index>(y_.size())),
          .cut_q = equations_->revolutions().coordinates()};
}

void Island::place(const Position& at, double time) {
  y_.assign(at.y.begin(), at.y.end());
  time_ = time;
  forget_outputs();
  equations_->start(at.cut_q, time_, y_.data());
}

bool Island::place(const Eigen::VectorXd& change, double time) {
  Eigen::Map<Eigen::VectorXd>(y_.data(), change.size()) += change;
  time_ = time;
  forget_outputs();
  if (mechanism().rows == 0) {
    dynamics_->normalize(y_.data());
  } else if (!equations_->project_onto_constraints(time_, y_.data(), false)) {
    return false;
  }
  equations_->start(equations_->revolutions().coordinates(), time_, y_.data());
  return true;
}

void Island::take_modes(const Island& other) {
  LockModes& locks = equations_->modes().locks();
  if (!locks.empty()) locks.set_state(other.equations_->modes().locks().state());
  forget_outputs();
}

void Island::start_again(const Island& other) {
  inputs_jumped_ = other.inputs_jumped_;
  if (follows_) equations_->drives().targets_at(time_, followed_);
  replay_.clear();
  if (integrator_) integrator_->restart(time_, y_.data());
}

RunCounts Island::counts() const {
  RunCounts out = equations_->mode_counts();
  out.steps = integrator_ ? integrator_->steps() : 0;
  out.rejected_steps = integrator_ ? integrator_->rejected_steps() : 0;
  out.evaluations = evaluations();
  out.events = events_.count();
  out.step_error = integrator_ ? integrator_->stepped_time().error : 0;
  return out;
}

}  // namespace gelenk
