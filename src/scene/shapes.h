// SPDX-License-Identifier: BSD-3-Clause
// Shapes of a scene as a whole: surfaces, masses, units.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// Multiplies all lengths of a shape by a factor.
void scale(Stored<AnyShape>& shape, double factor);

// Names of all surfaces, in the order of the file, each once.
std::vector<std::string> surfaces_of(const Scene& scene);

// Mass properties of all bounded shapes together for unit density, in the body's frame; shapes that overlap count twice
// where they do.
MassProperties mass_properties(const std::vector<BodyShape>& shapes);

// Index of the contact between two surfaces, -1: none; either order.
int contact_between(const Scene& scene, const std::string& a, const std::string& b);

// The number of features at which shapes can touch for located events (shape/features.h): tips on cores, corners on
// faces, edges on edges, rims on planes; 0: contacts of such shapes are not located.
int located_features(const AnyShape& a, const AnyShape& b);
// Why the integrator auto makes time steps from the start: pairs of shapes whose contacts are not located, or very
// many; empty: it locates events.
std::string reason_for_time_steps(const Scene& scene);
// Whether contacts may change at events that are located; otherwise steps are made with impulses. The integrator auto
// does so if it can for all pairs of shapes, unless there are very many.
bool locates_contacts(const Scene& scene);

// Calls visit(a, b) for pairs of shapes of different bodies between which the contact may act.
void each_pair_of_shapes(const Scene& scene, const Contact& contact,
                         const std::function<void(const BodyShape&, const BodyShape&)>& visit);

// By body of the scene: whether one of its shapes can touch something.
std::vector<bool> bodies_that_touch(const Scene& scene);

}  // namespace gelenk
