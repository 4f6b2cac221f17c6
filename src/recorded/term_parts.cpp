// SPDX-License-Identifier: BSD-3-Clause
#include "recorded/term_parts.h"

#include <set>

namespace gelenk {

std::vector<expression::Term> independent_parts(const expression::Graph& graph, const std::vector<expression::Term>& of,
                                                const std::function<bool(int)>& depends) {
  std::vector<bool> varies(static_cast<std::size_t>(graph.size()), false);
  for (expression::Term term = 0; term < graph.size(); ++term) {
    const expression::Node& node = graph[term];
    const auto at = static_cast<std::size_t>(term);
    varies[at] = node.operation == expression::Operation::variable && depends(node.index);
    for (const expression::Term operand : node.of)
      varies[at] = varies[at] || (operand >= 0 && varies[static_cast<std::size_t>(operand)]);
  }
  std::set<expression::Term> out;
  std::vector<bool> is_seen(varies.size(), false);
  std::vector<expression::Term> waiting = of;
  while (!waiting.empty()) {
    const expression::Term term = waiting.back();
    waiting.pop_back();
    if (is_seen[static_cast<std::size_t>(term)]) continue;
    is_seen[static_cast<std::size_t>(term)] = true;
    if (!varies[static_cast<std::size_t>(term)]) {
      if (!graph.is_constant(term)) out.insert(term);
      continue;
    }
    for (const expression::Term operand : graph[term].of) {
      if (operand >= 0) waiting.push_back(operand);
    }
  }
  return {out.begin(), out.end()};
}

}  // namespace gelenk
