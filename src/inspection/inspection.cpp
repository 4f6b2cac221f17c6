// SPDX-License-Identifier: BSD-3-Clause
#include "inspection/inspection.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "element/constraints/cut_joint.h"
#include "kinematics/loads.h"
#include "mechanism/wanted_part.h"
#include "outputs/port_readings.h"
#include "preparation/loads.h"
#include "preparation/preparation.h"
#include "preparation/report.h"
#include "scene/formulas.h"
#include "scene/locking_elements.h"
#include "scene/words.h"
#include "simulation/start_report.h"
#include "util/text.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// With more constraint equations the search for redundant ones, by dense matrices, would take too long.
constexpr int max_rows_for_redundancy = 600;

std::string counted(int n, const std::string& one) { return std::to_string(n) + " " + one + (n == 1 ? "" : "s"); }

// "z", or "(0.6, 0.8, 0)".
std::string direction(const Vector3d& d) {
  static constexpr const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (std::abs(d[i]) > 1 - 1e-9) return axes[i];
  }
  return "(" + text::rounded(d.x(), 3) + ", " + text::rounded(d.y(), 3) + ", " + text::rounded(d.z(), 3) + ")";
}

std::string forbidden_motion(const Spatial::Force& w, const Eigen::Matrix3d& R_UC) {
  if (w.f.norm() > 1e-9 * w.n.norm()) return "sliding along " + direction(R_UC * w.f.normalized());
  return "turning about " + direction(R_UC * w.n.normalized());
}

// The scene at the start found, without the reductions that hide constraint equations. Bodies without mass are given
// some: it does not affect the constraint equations, and in space such bodies may rotate freely about their axes.
Scene in_space(Simulation& simulation) {
  Scene scene = StartReport(simulation).adjusted_scene();
  for (Body& body : scene.bodies) {
    if (body.mass > 0) continue;
    body.mass = 1;
    body.inertia.setIdentity();
  }
  for (const Reduction pass : {Reduction::planar, Reduction::fixed, Reduction::redundant_rows}) {
    scene.solver.reductions[static_cast<std::size_t>(pass)] = false;
  }
  erase_locking_elements(scene);
  const std::vector<Signal>& signals = simulation.outputs();
  for (int i = 0; i < static_cast<int>(signals.size()); ++i) {
    const Signal& s = signals[i];
    if (s.joint < 0 || s.level > 1) continue;
    JointStart& start = scene.joints[s.joint].start;
    (s.level == 0 ? start.q : start.v)[s.component] = simulation.output(i);
    (s.level == 0 ? start.q_given : start.v_given)[s.component] = true;
  }
  return scene;
}

class RowInspector {
 public:
  RowInspector(Scene scene, Inspection& out)
      : scene_(std::move(scene)),
        out_(out),
        prepared_(prepare(scene_, reduce(scene_), 0, Inputs(input_signals(scene_).size(), reads_time(scene_)))) {
    const std::vector<Loads> loads = make_loads(scene_, prepared_.reduced);
    for (int i = 0; i < static_cast<int>(prepared_.islands.size()); ++i) inspect_island(i, loads[i]);
    out.undetermined_reactions.assign(undetermined_.begin(), undetermined_.end());
    report_mobility();
  }

 private:
  void inspect_island(int i, const Loads& loads) {
    const Mechanism& mechanism = prepared_.reduced.islands[i];
    const MobilityAnalysis& mobility = prepared_.islands[i].mobility;
    constant_ += mechanism.rows - mobility.needed_rows;
    changing_ += mobility.needed_rows - mobility.rank;
    lost_ += mobility.rank - mobility.rank_start;
    if (mobility.null_multipliers.cols() == 0) return;
    const auto dynamics = make_dynamics(mechanism, loads);
    dynamics->set_position(mobility.generic_q.data());
    dynamics->readings().set_root_poses();
    dynamics->factorize();
    name_rows(mechanism, mobility, *dynamics);
    find_undetermined(mechanism, mobility, *dynamics);
  }

  void name_rows(const Mechanism& mechanism, const MobilityAnalysis& mobility, const Dynamics& dynamics) {
    for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
      const Cut& cut = mechanism.cuts[c];
      if (cut.is_contact()) {  // its constraint equations are all kept
        if (mobility.needed_rows > mobility.rank) overconstrained_.push_back(loop(mechanism, c));
        continue;
      }
      Row<Spatial> rows[6];
      const Pose3 X_FM = dynamics.cut_pose(c);
      std::visit([&](const auto& joint) { joint.template rows<Spatial>(X_FM, rows); }, *cut.joint);
      const int joint = cut.scene_joints.front();
      for (const Spatial::Force& w : redundant_wrenches(mechanism, mobility, dynamics, c, rows)) {
        const Eigen::Matrix3d& R_UC = prepared_.reduced.joints[joint].R_UC;
        out_.redundant_rows.push_back({scene_.joints[joint].name, forbidden_motion(w, R_UC)});
      }
      if (mobility.needed_rows > mobility.rank && cut.rows > 0) overconstrained_.push_back(loop(mechanism, c));
    }
  }

  // The redundant constraint wrenches of a cut, one for each equation that is not needed. An equation whose row of J is
  // zero gives its own wrench; combinations of rows whose sum is zero give the sum of their wrenches.
  static std::vector<Spatial::Force> redundant_wrenches(const Mechanism& mechanism, const MobilityAnalysis& mobility,
                                                        const Dynamics& dynamics, int c, const Row<Spatial>* rows) {
    const Eigen::Map<const RowMatrix> J = dynamics.J();
    const Cut& cut = mechanism.cuts[c];
    std::vector<Spatial::Force> out;
    std::vector<int> dropped;
    std::vector<int> working;
    for (int r = 0; r < cut.joint_rows; ++r) {
      const bool null_multipliers = J.cols() == 0 || J.row(cut.first_row + r).lpNorm<Eigen::Infinity>() < 1e-9;
      if (!null_multipliers) working.push_back(r);
      if (std::ranges::find(mobility.needed[c], r) != mobility.needed[c].end()) continue;
      if (null_multipliers) out.push_back(rows[r].w);
      if (!null_multipliers) dropped.push_back(r);
    }
    if (dropped.empty()) return out;
    Eigen::MatrixXd block(working.size(), J.cols());
    for (std::size_t i = 0; i < working.size(); ++i) block.row(static_cast<int>(i)) = J.row(cut.first_row + working[i]);
    Eigen::FullPivLU<Eigen::MatrixXd> lu(block.transpose());
    lu.setThreshold(1e-8);
    const Eigen::MatrixXd kernel = lu.kernel();
    const bool kernel_is_complete = lu.dimensionOfKernel() == static_cast<Eigen::Index>(dropped.size());
    for (std::size_t k = 0; k < dropped.size(); ++k) {
      Spatial::Force w = rows[dropped[k]].w;
      if (kernel_is_complete) {
        w = {};
        for (std::size_t i = 0; i < working.size(); ++i) {
          w += kernel(static_cast<int>(i), static_cast<int>(k)) * rows[working[i]].w;
        }
      }
      out.push_back(w);
    }
    return out;
  }

  std::string loop(const Mechanism& mechanism, int cut) const {
    if (const Cut& c = mechanism.cuts[cut]; c.is_contact()) return "contact " + scene_.constraints[c.constraint].name;
    std::vector<std::string> names;
    for (const int j : joints_of_loop(mechanism, cut)) names.push_back(scene_.joints[j].name);
    return text::some(names);
  }

  // Finds the components of reactions that the null space of the multipliers changes.
  void find_undetermined(const Mechanism& mechanism, const MobilityAnalysis& mobility, Dynamics& dynamics) {
    for (Eigen::Index k = 0; k < mobility.null_multipliers.cols(); ++k) {
      const Eigen::VectorXd lambda = mobility.null_multipliers.col(k);
      dynamics.readings().set_multipliers(lambda.data());
      find_undetermined_contacts(mechanism, lambda);
      for (const int j : mechanism.joints) {
        const ElementPlace at_joint{.name = {}, .frames = {}, .joints = {scene_.joints[j].name}, .coordinate = {}};
        const PortPlaces ports(scene_, prepared_.reduced, at_joint, true);
        const SeenPorts<double> seen(ports, prepared_.reduced, &dynamics.readings());
        const SeenWrench<double> wrench = seen.reaction();
        const Eigen::Matrix3d R_0F = seen.pose(0).R;
        for (int i = 0; i < 6; ++i) {
          if (std::abs(R_0F.col(i % 3).dot(i < 3 ? wrench.f : wrench.n)) < 1e-6) continue;
          undetermined_.insert(scene_.joints[j].name + (i < 3 ? ".f[" : ".t[") + std::to_string(i % 3 + 1) + "]");
        }
      }
    }
  }

  void find_undetermined_contacts(const Mechanism& mechanism, const Eigen::VectorXd& lambda) {
    for (const Cut& cut : mechanism.cuts) {
      for (int i = 0; cut.is_contact() && i < cut.rows; ++i) {
        if (std::abs(lambda[cut.first_row + i]) < 1e-6) continue;
        const Constraint& c = scene_.constraints[cut.constraint];
        undetermined_.insert(c.name + "." + std::string(kind_of(*c.is).outputs[i].name));
      }
    }
  }

  void report_mobility() {
    if (constant_ > 0) {
      out_.mobility.push_back(counted(constant_, "constraint equation") + (constant_ == 1 ? " is" : " are") +
                              " redundant at every position: the loops are closed without " +
                              (constant_ == 1 ? "it" : "them"));
    }
    if (changing_ > 0) {
      out_.mobility.push_back(counted(changing_, "constraint equation") + (changing_ == 1 ? " is" : " are") +
                              " redundant with coefficients that vary along the motion: the loop through " +
                              text::list(overconstrained_) +
                              " is overconstrained and moves only owing to its special dimensions; all its constraint "
                              "equations are kept");
    }
    if (lost_ > 0) {
      out_.mobility.push_back("the start is a singular configuration, in which " +
                              counted(lost_, "constraint equation") + (lost_ == 1 ? " is" : " are") +
                              " momentarily redundant; they are kept, since elsewhere all of them are independent");
    }
  }

  const Scene scene_;  // in natural units
  Inspection& out_;
  const PreparedScene prepared_;
  std::set<std::string> undetermined_;
  std::vector<std::string> overconstrained_;  // loops
  int constant_ = 0, changing_ = 0, lost_ = 0;
};

// "f[2], t[1] of A, B; f[3] of C" from "A.f[2]", "A.t[1]", ...
std::string by_joint(const std::vector<std::string>& components) {
  std::map<std::string, std::string> of_joint;
  for (const std::string& component : components) {
    const std::size_t dot = component.find('.');
    std::string& list = of_joint[component.substr(0, dot)];
    list += (list.empty() ? "" : ", ") + component.substr(dot + 1);
  }
  std::map<std::string, std::vector<std::string>> joints;
  for (const auto& [joint, list] : of_joint) joints[list].push_back(joint);
  std::string out;
  for (const auto& [list, names] : joints) out += (out.empty() ? "" : "; ") + list + " of " + text::some(names);
  return out;
}

void add_note(Inspection& out, Reduction pass, const std::string& note, bool changed) {
  ReductionReport& report = out.reductions[static_cast<std::size_t>(pass)];
  report.notes.push_back(note);
  report.changed = report.changed || (changed && report.on);
}

void report_spinning_rods(const ReducedScene& reduced, Inspection& out) {
  int spinning = 0;
  for (const Mechanism& mechanism : reduced.islands) {
    for (const Cut& cut : mechanism.cuts) spinning += cut.is_rod() && std::get<Rod>(*cut.joint).has_free_spin() ? 1 : 0;
  }
  if (spinning == 0) return;
  out.mobility.push_back(counted(spinning, "rod") +
                         (spinning == 1 ? " rotates about its axis" : " rotate about their axes") +
                         " between spherical joints, which moves no mass and is not counted as a degree of freedom");
}

// Compares the chosen cuts with those in the order of the file.
void compare_cuts(const Scene& scene, int described_rows, Inspection& out) {
  const bool chosen = scene.solver.reduces(Reduction::cut_choice);
  if (!chosen || described_rows == 0) return;
  Scene by_file = scene;
  by_file.solver.reductions[static_cast<std::size_t>(Reduction::cut_choice)] = false;
  const ModelSize other = size_of(reduce(by_file));
  const ModelSize here = size_of(reduce(scene));
  if (other.rows == here.rows && other.coordinates == here.coordinates) {
    // Nothing is gained over the order of the file.
    out.reductions[static_cast<std::size_t>(Reduction::cut_choice)].changed = false;
    return;
  }
  add_note(out, Reduction::cut_choice,
           "cutting in the order of the file would give " + counted(other.rows, "constraint equation") + " and " +
               counted(other.coordinates, "coordinate") + " instead of " + std::to_string(here.rows) + " and " +
               std::to_string(here.coordinates),
           true);
}

void add_row_notes(const Scene& scene, Inspection& out) {
  std::vector<std::string> rows;
  for (const RedundantRow& row : out.redundant_rows) rows.push_back(row.joint + ": " + row.motion);
  if (rows.empty()) return;
  const bool dropped = scene.solver.reduces(Reduction::redundant_rows) || out.reduced.planar;
  const bool one = rows.size() == 1;
  const std::string fate = dropped ? (one ? " and is omitted: " : " and are omitted: ") : ": ";
  add_note(out, Reduction::redundant_rows,
           counted(static_cast<int>(rows.size()), "constraint equation") + (one ? " is" : " are") +
               " redundant at every position" + fate + text::some(rows),
           true);
  add_note(out, Reduction::redundant_rows,
           "the following reactions are therefore statically indeterminate: " + by_joint(out.undetermined_reactions),
           true);
}

// Models with many islands have many similar notes: only the first few are listed.
void shorten(std::vector<std::string>& notes) {
  constexpr std::size_t max_notes = 8;
  constexpr std::size_t shown = 6;
  if (notes.size() <= max_notes) return;
  const std::size_t more = notes.size() - shown;
  notes.resize(shown);
  notes.push_back("and " + std::to_string(more) + " similar notes");
}

// The scene in the natural units in which it is solved.
Scene natural(Scene scene) {
  convert(scene, natural_units(scene));
  return scene;
}

// Sizes without any reduction.
ModelSize size_literally(Scene scene) {
  scene.solver.reductions.fill(false);
  return size_of(reduce(scene));
}

}  // namespace

Inspection inspect(Simulation& simulation, const Scene& whole) {
  const Scene scene = natural(StartReport(simulation).adjusted_scene());
  const ReducedScene& reduced = StartReport(simulation).prepared().reduced;
  Inspection out;
  const ModelSize described = size_literally(scene);
  out.left_out = wanted_part(whole).report();
  out.described = out.left_out.empty() ? described : size_literally(natural(whole));
  out.reduced = simulation.size();
  out.counted_degrees_of_freedom = described.speeds - described.rows;
  for (int i = 0; i < reduction_count; ++i) {
    out.reductions.push_back(
        {.name = words::reductions[i], .on = scene.solver.reductions[i], .changed = false, .notes = {}});
  }
  for (const Note& note : reduced.notes) add_note(out, note.pass, note.text, note.changed);
  compare_cuts(scene, described.rows, out);
  out.moved_frames = StartReport(simulation).moved_frames();
  report_spinning_rods(reduced, out);
  out.initial_degrees_of_freedom = out.reduced.degrees_of_freedom;
  for (const PreparedIsland& island : StartReport(simulation).prepared().islands) {
    out.initial_degrees_of_freedom += island.mobility.rank - island.mobility.rank_start;
  }
  if (described.rows > 0 && described.rows <= max_rows_for_redundancy) {
    const RowInspector rows(natural(in_space(simulation)), out);
  }
  add_row_notes(scene, out);
  if (!out.left_out.empty()) add_note(out, Reduction::outputs, out.left_out, true);
  if (scene.solver.reduces(Reduction::outputs)) {
    add_note(out, Reduction::outputs,
             "accelerations, reactions, poses and energies are computed when they are read, not in every evaluation",
             true);
  }
  if (const int parts = StartReport(simulation).kinematic_parts(); parts > 0) {
    add_note(
        out, Reduction::kinematic,
        (parts == 1 ? "a part" : std::to_string(parts) + " parts") +
            " without degrees of freedom: prescribed motions give positions and velocities, which are not integrated",
        true);
  }
  for (ReductionReport& report : out.reductions) shorten(report.notes);
  return out;
}

}  // namespace gelenk
