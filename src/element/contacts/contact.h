// SPDX-License-Identifier: BSD-3-Clause
// The interface of contacts, laws of the forces between touching shapes with two surfaces. A contact has
//
//   law()                    the numbers of its law
//   output(seen, group, i)   component i of an output group, where seen offers force(), gap() and mode()
#pragma once

#include <Eigen/Core>
#include <vector>

#include "element/element.h"

namespace gelenk {

// Coulomb's law with rolling and spinning friction, and Newton's law of impact.
struct ContactLaw {
  double sliding_friction = 0, static_friction = 0;  // coefficients
  double rolling = 0, spinning = 0;                  // m: largest moments per normal force
  double restitution = 0;
  Eigen::Vector3d belt_velocity = Eigen::Vector3d::Zero();  // m/s: of the second surface, in the axes of its shape
  double given_normal = 0;  // N, N m: of friction of joints, the force of which the coefficients are parts
};

// The force at a point at which two shapes of a mechanism (Mechanism::shapes) touch, in the root frame.
struct ContactForce {
  int contact = 0;                                                                    // of the scene
  int a = 0, b = 0;                                                                   // the shapes
  Eigen::Vector3d p = Eigen::Vector3d::Zero();                                        // m
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();  // N, N m: on b
  double normal = 0;  // N: the part of the force along the normal
};

// What the outputs of contacts show, by contact of the scene.
class ContactReadings {
 public:
  virtual Eigen::Vector3d force(int contact) const = 0;  // N, on the bodies with the first surface, in the world's axes
  virtual int mode(int contact) const = 0;               // 0: open; 1: all contact points stick; 2: some of them slide
  virtual double gap(int contact) = 0;                   // m; found when it is asked for
  virtual std::vector<ContactForce> forces() = 0;        // at all points of contact; found when they are asked for

 protected:
  ~ContactReadings() = default;
};

// The outputs of one contact.
struct SeenContact {
  ContactReadings& all;
  int contact;

  Eigen::Vector3d force() const { return all.force(contact); }
  int mode() const { return all.mode(contact); }
  double gap() const { return all.gap(contact); }
};

}  // namespace gelenk
