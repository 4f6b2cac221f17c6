// SPDX-License-Identifier: BSD-3-Clause
// What the model descriptions of all versions of FMI have in common.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "modelDescription/catalog.h"
#include "modelDescription/dependencies.h"
#include "modelDescription/xml_writer.h"

namespace gelenk {

const char* name_of(Causality causality);
const char* name_of(Variability variability);

// The kinds of unknowns that ModelStructure lists, as indices of variables, with their dependencies.
class Structure {
 public:
  // dependencies: those of dependencies_of().
  Structure(const Catalog& catalog, const std::vector<Knowns>& dependencies);

  struct Unknown {
    int variable;
    const std::vector<int>* dependencies;  // null: too many to list; no list means all
  };
  const std::vector<Unknown>& outputs() const { return outputs_; }
  const std::vector<Unknown>& derivatives() const { return derivatives_; }
  const std::vector<Unknown>& initial_unknowns() const { return initial_; }

 private:
  std::vector<Knowns> dependencies_, initial_dependencies_;
  std::vector<Unknown> outputs_, derivatives_, initial_;
};

// `is_shown`: by variable.
void write_units(XmlWriter& w, const Catalog& catalog, const std::vector<bool>& is_shown);
void write_log_categories(XmlWriter& w);
// As attributes of the root.
void write_metadata(XmlWriter& w, const Scene& scene);
void write_default_experiment(XmlWriter& w, const Scene& scene);
// The number of states, and the natural units of the mechanism.
void write_order(XmlWriter& w, int depth, const Scene& scene, const FmuFacts& facts);

}  // namespace gelenk
