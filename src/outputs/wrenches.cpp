// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/wrenches.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <tuple>
#include <variant>

#include "element/registry.h"
#include "joint/kinds.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"
#include "outputs/port_readings.h"
#include "scene/formulas.h"
#include "scene/scene.h"
#include "scene/signals.h"
#include "scene/touching_laws.h"

namespace gelenk {

void BodyWrenches::add(int island, const Reading& reading, const Loads& loads, const double* u) {
  const Mechanism& mechanism = reduced_.islands[static_cast<std::size_t>(island)];
  add_forces(island, &reading.dynamics, &loads, u);
  add_along_joints(reading, mechanism, loads, u);
  add_reactions(island, reading.dynamics);
  if (mechanism.touches() && reading.contacts != nullptr) add_contacts(reading, mechanism);
}

int BodyWrenches::body_of(const BodyFrame& frame) const {
  const auto found = std::ranges::find(scene_.bodies, frame.body, &Body::name);
  return found == scene_.bodies.end() ? -1 : static_cast<int>(found - scene_.bodies.begin());
}

Pose3 BodyWrenches::X_WB(int body, const Readings<double>& dynamics) const {
  return body < 0 ? Pose3() : pose_in_world(reduced_, reduced_.bodies[static_cast<std::size_t>(body)], dynamics);
}

// Binds the names of inputs and the time; returns false if it names others.
bool BodyWrenches::bind_to_inputs(Formula& formula, int first_input) const {
  for (std::size_t k = 0; k < formula.signal_names().size(); ++k) {
    const std::string& name = formula.signal_names()[k];
    const auto input = std::ranges::find(scene_.inputs, name, &SceneInput::name);
    const bool is_input = input != scene_.inputs.end();
    if (!is_input && name != time_signal) return false;
    const int index = first_input + static_cast<int>(input - scene_.inputs.begin());
    formula.bind_signal(k, index, is_input ? scene_.units.size_of(input->unit) : 1);
  }
  return true;
}

// Returns false if it cannot be evaluated. loads: of its island, or null. force: index in the scene.
template <class F>
bool BodyWrenches::act(const F& element, RecordingPort<double>* at, const Loads* loads, const double* u,
                       int force) const {
  const std::vector<std::vector<int>> inputs = first_inputs(scene_);
  if constexpr (HasFormulas<F>) {
    std::vector<Formula> known;
    if (loads != nullptr) {
      each_formula(std::as_const(*loads->forces), [&](const Formula& formula, int of) {
        if (of == force) known.push_back(formula);
      });
    }
    F bound = element;
    bool is_bound = true;
    std::size_t next = 0;
    F::each_formula(bound, [&](Formula& formula) {
      if (next < known.size()) {
        formula = known[next++];
      } else {
        is_bound = bind_to_inputs(formula, inputs.back().front()) && is_bound;
      }
    });
    if (is_bound) bound.act(at, u);
    return is_bound;
  } else {
    element.act(at, u + inputs[sections::forces][static_cast<std::size_t>(force)]);
    return true;
  }
}

void BodyWrenches::add_forces(int island, const Readings<double>* dynamics, const Loads* loads, const double* u) {
  for (std::size_t i = 0; i < scene_.forces.size(); ++i) {
    const Force& force = scene_.forces[i];
    const PortPlaces places(scene_, reduced_, force, false);
    if (places.island != island) continue;
    const SeenPorts<double> seen(places, reduced_, dynamics);
    std::array<RecordingPort<double>, max_force_ports> at;
    for (std::size_t k = 0; k < force.frames.size(); ++k) at[k] = seen.port(static_cast<int>(k));
    const bool acts = std::visit(
        [&](const auto& element) { return act(element, at.data(), loads, u, static_cast<int>(i)); }, *force.is);
    if (!acts) continue;
    const Eigen::Matrix3d R_W0 = seen.X_W0().R;
    for (std::size_t k = 0; k < force.frames.size(); ++k) {
      const BodyFrame& on = force.frames[k];
      if (const int body = body_of(on); body >= 0) {
        all.push_back(
            {BodyWrench::Kind::load, force.name, body, static_cast<int>(k), on.X_BF.p, R_W0 * at[k].f, R_W0 * at[k].n});
      }
    }
  }
}

namespace {

// The effort in the user's sign; recorded: the next of the forces with branches, which is taken if it may hold a
// coordinate at rest: what holds something is not the element's to compute.
template <class F>
double effort_of(const F& force, const double* q, const double* v, const double* u, const double*& recorded) {
  using E = std::decay_t<decltype(force.element)>;
  if constexpr (Switches<E>) {
    [[maybe_unused]] const double of_run = *recorded++;
    if constexpr (Sticks<E> || Blocks<E>) return of_run;
    return force.sign * force.held(force.side(q, v), q, v, u);
  } else {
    return force.sign * force.effort(q, v, u);
  }
}

}  // namespace

void BodyWrenches::add_along_joints(const Reading& reading, const Mechanism& mechanism, const Loads& loads,
                                    const double* u) {
  const double* recorded = reading.forces;
  const auto add = [&](const JointLoads& along, const double* q, const double* v) {
    each_list(along.lists, [&](const auto& list) {
      using E = std::decay_t<decltype(list.front().element)>;
      constexpr bool is_along = requires { E::group; };
      std::string_view group;
      if constexpr (is_along) group = E::group;
      for (const auto& force : list) {
        std::string_view owner;
        if (force.owner >= 0) {
          const auto of = static_cast<std::size_t>(force.owner);
          owner = is_along ? scene_.components[of].name : scene_.motors[of].name;
        }
        add_along(force.joint, force.component, owner, group, effort_of(force, q, v, u, recorded), reading);
      }
    });
  };
  add(loads.tree, reading.q, reading.v);
  for (std::size_t c = 0; c < loads.cuts.size(); ++c) {
    std::array<double, max_cut_nv> v{};
    reading.dynamics.cut_speeds(static_cast<int>(c), v.data());
    add(loads.cuts[c], reading.cut_q + mechanism.cuts[c].iq, v.data());
  }
}

void BodyWrenches::add_along(int j, int component, std::string_view owner, std::string_view group, double effort,
                             const Reading& reading) {
  const Joint& joint = scene_.joints[static_cast<std::size_t>(j)];
  const JointPlace& place = reduced_.joints[static_cast<std::size_t>(j)];
  const bool is_driven = !owner.empty();
  std::string name(is_driven ? owner : joint.name);
  if (!is_driven && !group.empty()) name.append(".").append(group);
  std::array<double, max_cut_nq> own{};
  std::array<double, 6> tau{};
  const double* const q = place.role == JointPlace::Role::cut ? reading.cut_q : reading.q;
  for (std::size_t k = 0; k < place.q_sign.size(); ++k)
    own[k] = place.q_sign[k] * q[static_cast<std::size_t>(place.iq) + k];
  tau[static_cast<std::size_t>(component)] = effort;
  const Spatial::Force F_M = force_along(*joint.is, own.data(), tau.data());
  const int body = body_of(joint.child);
  const Eigen::Matrix3d R_WM =
      X_WB(body, reading.dynamics).R * joint.child.X_BF.R * canonical_rotation(*joint.is, joint.axes);
  all.push_back(
      {BodyWrench::Kind::load, name, body, is_driven ? 1 : 0, joint.child.X_BF.p, R_WM * F_M.f, R_WM * F_M.n});
}

void BodyWrenches::add_reactions(int island, const Readings<double>& dynamics) {
  for (const Sensor& sensor : scene_.sensors) {
    if (!kind_of(*sensor.is).reads_reaction) continue;
    const auto is_known = [&](const BodyWrench& of) {
      return of.kind == BodyWrench::Kind::reaction && of.name == sensor.joints.front();
    };
    if (std::ranges::any_of(all, is_known)) continue;
    const PortPlaces places(scene_, reduced_, sensor, true);
    if (places.island != island) continue;
    const auto joint = std::ranges::find(scene_.joints, sensor.joints.front(), &Joint::name);
    const SeenPorts<double> seen(places, reduced_, &dynamics);
    const SeenWrench<double> on = seen.reaction();
    const Eigen::Matrix3d R_W0 = seen.X_W0().R;
    all.push_back({BodyWrench::Kind::reaction, joint->name, body_of(joint->child), 0, joint->child.X_BF.p, R_W0 * on.f,
                   R_W0 * on.n});
  }
}

// The torque of the limit of a ball joint, or the friction of a joint, at the joint.
void BodyWrenches::add_law_of_joint(const ContactForce& at, const Reading& reading, const Mechanism& mechanism) {
  const std::optional<TouchingLawOfJoint> law = touching_law_of_joint(scene_, at.contact);
  const Joint& joint = scene_.joints[static_cast<std::size_t>(law->joint)];
  const std::string name = name_of_touching_law(scene_, at.contact);
  const Eigen::Vector3d n = mechanism.X_W0.R * at.moment;
  const Eigen::Vector3d f = mechanism.X_W0.R * at.force;
  for (const auto& [on, number, side] : {std::tuple(&joint.parent, 0, -1.0), std::tuple(&joint.child, 1, 1.0)}) {
    const int body = body_of(*on);
    if (body < 0) continue;
    Eigen::Vector3d p = on->X_BF.p;
    if (!law->turns()) {
      const Pose3 X = X_WB(body, reading.dynamics);
      p = X.R.transpose() * (mechanism.X_W0.point(at.p) - X.p);
    }
    all.push_back({BodyWrench::Kind::load, name, body, number, p, side * f, side * n});
  }
}

// All points between two bodies together: their force acts at the mean of the points, weighted by the normal forces.
void BodyWrenches::add_contacts(const Reading& reading, const Mechanism& mechanism) {
  struct Sum {
    Eigen::Vector3d f = Eigen::Vector3d::Zero(), n = Eigen::Vector3d::Zero();  // on the second body, n about the origin
    Eigen::Vector3d weighted = Eigen::Vector3d::Zero();
    double weight = 0;
  };
  std::map<std::tuple<int, int, int>, Sum> sums;  // by contact and bodies
  for (const ContactForce& at : reading.contacts->forces()) {
    if (static_cast<std::size_t>(at.contact) >= scene_.contacts.size()) {
      add_law_of_joint(at, reading, mechanism);
      continue;
    }
    const auto body = [&](int shape) { return mechanism.shapes[static_cast<std::size_t>(shape)].scene_body; };
    const double side = body(at.a) < body(at.b) ? 1 : -1;
    Sum& sum = sums[{at.contact, std::min(body(at.a), body(at.b)), std::max(body(at.a), body(at.b))}];
    sum.f += side * at.force;
    sum.n += side * (at.moment + at.p.cross(at.force));
    sum.weighted += at.normal * at.p;
    sum.weight += at.normal;
  }
  for (const auto& [between, sum] : sums) {
    const auto [contact, first, second] = between;
    if (!(sum.weight > 0)) continue;
    const Eigen::Vector3d p = sum.weighted / sum.weight;
    const Eigen::Vector3d f = mechanism.X_W0.R * sum.f;
    const Eigen::Vector3d n = mechanism.X_W0.R * (sum.n - p.cross(sum.f));
    for (const auto& [body, other, side] : {std::tuple(first, second, -1.0), std::tuple(second, first, 1.0)}) {
      if (body < 0) continue;
      const Pose3 X = X_WB(body, reading.dynamics);
      all.push_back({BodyWrench::Kind::contact, scene_.contacts[static_cast<std::size_t>(contact)].name, body, other,
                     X.R.transpose() * (mechanism.X_W0.point(p) - X.p), side * f, side * n});
    }
  }
}

}  // namespace gelenk
