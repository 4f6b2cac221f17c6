// SPDX-License-Identifier: BSD-3-Clause
// The contacts of shapes of a formulation: in steps with impulses, or with modes that change at events.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "event_driven/run_counts.h"
#include "formulation/equations.h"
#include "formulation/impulse_steps.h"
#include "nonsmooth/law_audit.h"
#include "util/archive.h"

namespace gelenk {

struct Scene;

class ContactModes;
class EventModes;

class ContactMotion final : public ImpulseEquations {
 public:
  // modes: must outlive it. located: contacts change at events, too.
  ContactMotion(const ImpulseSteps::Context& context, EventModes& modes, bool located);

  bool are_required() const override { return steps_.are_required(); }
  bool may_be_located() const override { return located_ != nullptr; }
  bool must_be_located() const override;
  void use(ImpulseAccuracy accuracy) override;
  bool are_used() const override { return steps_used_; }
  void change_to(bool impulses, double t, const double* y) override;
  Activity activity() const override;
  bool can_be_located_at(const double* y) override;
  bool take_over(const Activity& before) override;
  void start(double t, double h, const double* y) override { steps_.start(t, h, y); }
  bool step(double t, double h, double* y) override { return steps_.step(t, h, y); }

  ImpulseSteps& steps() { return steps_; }
  ContactModes* located() const { return located_; }  // null: contacts are not located

  // Whether a located contact is closed.
  bool touches() const;
  // Adds the effect of closed contacts to vdot, the last solution; solve: finds it again, with other loads.
  void add_to(double* vdot, const std::function<void(double* vdot)>& solve);
  // Makes the forces of closed contacts loads of the next solutions, until they are withdrawn.
  void apply_forces();
  void withdraw_forces();
  // By indicator of contacts, which follow all others.
  std::vector<std::array<std::string, 2>> event_texts(const std::vector<std::string>& bodies,
                                                      const std::vector<std::string>& contacts) const;
  // What outputs of contacts show.
  ContactReadings& readings() { return readings_; }
  void count(RunCounts& counts) const;
  // Of the time steps since the last begin_part(), while steps are used; v: the velocities after the last one, at t.
  // Records loads that contacts share with joints.
  LawAudit law_audit(double t, std::span<const double> v);

  // At the start of a run.
  void start();
  // At the start of each part of a communication step; continues: of a later one.
  void begin_part(bool continues) { steps_.begin_part(continues); }
  void serialize(Archive& archive);

 private:
  void forget_events(const Activity& before) override { steps_.events().forget_beyond(before.events); }
  void report(const SchemeChange& change) override { steps_.events().add(change); }
  const double* smooth_accelerations() const override { return steps_.smooth_accelerations(); }
  void report_shared_load(double t);
  void keep() override { steps_.stepper().copy_to(TimeStepper::Memory::kept); }
  void return_to_kept() override { steps_.stepper().exchange_with(TimeStepper::Memory::kept); }
  void copy_to_second() override { steps_.stepper().copy_to(TimeStepper::Memory::second); }
  void exchange_with_second() override { steps_.stepper().exchange_with(TimeStepper::Memory::second); }
  double highest_frequency(double t, const double* y) override { return steps_.highest_frequency(t, y); }

  // Of the present way.
  class PresentReadings final : public ContactReadings {
   public:
    explicit PresentReadings(ContactMotion& of) : of_(of) {}
    Eigen::Vector3d force(int contact) const override { return present().force(contact); }
    int mode(int contact) const override { return present().mode(contact); }
    double gap(int contact) override { return present().gap(contact); }
    std::vector<ContactForce> forces() override { return present().forces(); }

   private:
    ContactReadings& present() const;
    ContactMotion& of_;
  };

  ImpulseSteps steps_;
  Dynamics& dynamics_;
  std::size_t links_;
  EventModes& modes_;
  ContactModes* located_;
  PresentReadings readings_{*this};
  std::vector<Spatial::Force> wrenches_;  // by link: workspace
  bool steps_used_ = false;
};

}  // namespace gelenk
