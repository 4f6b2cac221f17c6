// SPDX-License-Identifier: BSD-3-Clause
// Limits of friction that depend on forces which depend on the friction: a fixed point y = F(y). Where friction grows
// fast with its load there are several, of which one is the motion: what can remain at rest does, and what moves keeps
// moving as without friction, if that motion can be followed to the whole friction; otherwise it stops within the step,
// as a self-locking gear that seizes.
#pragma once

#include <span>
#include <vector>

#include "linear/anderson.h"

namespace gelenk {

class LoadIteration {
 public:
  class Friction {
   public:
    virtual ~Friction() = default;
    // found <- F(limits); false: it has none.
    virtual bool respond(const std::vector<double>& limits, std::vector<double>& found) = 0;
    // Of the last respond(): adds the indices of limits at which friction was; whether anything that moves has stopped.
    virtual void add_reached(std::vector<int>& out) const = 0;
    virtual bool stops() const = 0;
  };

  // How what rests may be held: as in the guess of the limits; by any force that agrees with its load; not by more than
  // the limits of the guess, as in an impact, in which friction exerts no impulse that could be its load.
  enum class Holding { as_guessed, by_any_force, in_impact };
  enum class Limit : char { of_motion, of_rest, without_load };  // of what friction: the last one is known
  // limits: a guess, then the fixed point, to which the last respond() belongs; kinds: theirs. Returns false where
  // there is none.
  bool settle(Friction& friction, std::span<const Limit> kinds, Holding holding, std::vector<double>& limits);

 private:
  bool iterate();
  bool evaluate(std::vector<double>& found);
  enum class Branch { first, other, unknown };
  Branch differentiate();
  bool is_on_first_branch();
  bool correct();
  bool settle_regularly() { return iterate() && (contracts_ || is_on_first_branch()); }
  void hold_what_rests();
  enum class From { rest, motion };
  bool follow(From what_rests);
  bool stop();

  Friction* friction_ = nullptr;
  std::span<const Limit> kinds_;
  std::vector<double>* limits_ = nullptr;
  double part_ = 1;  // of the friction that is followed
  bool follows_all_ = false;
  std::vector<double> guess_, found_, changed_, correction_, matrix_;
  std::vector<int> reached_, pivots_;
  AndersonAcceleration acceleration_;
  bool contracts_ = false;  // the last iterations came closer to each other without acceleration
};

}  // namespace gelenk
