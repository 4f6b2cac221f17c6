// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/velocity_hessian.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gelenk {
namespace {

constexpr int max_gmres_steps = 50;

// The pattern of the factor of groups of rows.
class GroupFactor final : public Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> {
 public:
  int place(int group) const { return m_P.size() > 0 ? m_P.indices()[group] : group; }
  // Multiplications of a factorization, about; size: rows of each group, by place.
  double cost(std::span<const int> size) const {
    const int* first = m_matrix.outerIndexPtr();
    const auto groups = static_cast<double>(size.size());
    const double mean = std::accumulate(size.begin(), size.end(), 0.0) / groups;
    double sum = 0;
    for (std::size_t i = 0; i < size.size(); ++i) {
      const double own = size[i], below = mean * (first[i + 1] - first[i]);
      sum += own * (below * below + below * own + own * own / 3);
    }
    return sum;
  }
};

}  // namespace

void VelocityHessian::start(ConeIteration& at) {
  if (!take_root(at)) return;
  find_blocks(at.cones());
  order();
  find_blocks(at.cones());
  analyzed_ = false;
}

// Returns whether the pattern has changed.
bool VelocityHessian::take_root(ConeIteration& at) {
  const ConeRoot root = at.G().root();
  const bool same = rows_ == root.rows && std::ranges::equal(first_, root.first) &&
                    std::ranges::equal(given_row_, root.row) && block_of_.size() == at.cones().size();
  rows_ = root.rows;
  first_.assign(root.first.begin(), root.first.end());
  if (!same) {
    given_row_.assign(root.row.begin(), root.row.end());
    row_ = given_row_;
  }
  value_.assign(root.value.begin(), root.value.end());
  for (int j = 0; j + 1 < static_cast<int>(first_.size()); ++j) {
    for (int k = first_[at_index(j)]; k < first_[at_index(j + 1)]; ++k) value_[at_index(k)] *= at.scale(j);
  }
  return !same;
}

// Contacts of one pair of bodies share a block.
void VelocityHessian::find_blocks(std::span<const Cone> cones) {
  std::size_t count = 0;
  block_of_.clear();
  local_.resize(row_.size());
  std::vector<int> rows;
  for (const Cone& cone : cones) {
    const auto begin = row_.begin() + first_[at_index(cone.first)];
    const auto end = row_.begin() + first_[at_index(cone.first + cone.size())];
    rows.assign(begin, end);
    std::ranges::sort(rows);
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (count == 0 || blocks_[count - 1].rows != rows) {
      if (blocks_.size() == count) blocks_.emplace_back();
      blocks_[count++].rows = rows;
    }
    block_of_.push_back(static_cast<int>(count) - 1);
    for (auto k = begin; k != end; ++k) {
      local_[static_cast<std::size_t>(k - row_.begin())] =
          static_cast<int>(std::ranges::lower_bound(rows, *k) - rows.begin());
    }
  }
  blocks_.resize(count);
}

// Rows that belong to the same blocks, as those of a free body, are ordered as one by approximate minimum degree.
void VelocityHessian::order() {
  std::vector<int> group;
  const int groups = group_rows(group);
  using Pattern = Eigen::SparseMatrix<double>;
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<int> members;
  for (int g = 0; g < groups; ++g) entries.emplace_back(g, g, 1.0);
  for (const Block& block : blocks_) {
    members.clear();
    for (const int row : block.rows) members.push_back(group[at_index(row)]);
    std::ranges::sort(members);
    members.erase(std::unique(members.begin(), members.end()), members.end());
    for (const int a : members) {
      for (const int b : members) entries.emplace_back(a, b, 1.0);
    }
  }
  Pattern pattern(groups, groups);
  pattern.setFromTriplets(entries.begin(), entries.end());
  GroupFactor factor;
  factor.analyzePattern(pattern);
  std::vector<int> size(at_index(groups), 0), first(at_index(groups), 0);
  for (const int g : group) ++size[at_index(factor.place(g))];
  factor_cost_ = factor.cost(size);
  for (std::size_t g = 1; g < first.size(); ++g) first[g] = first[g - 1] + size[g - 1];
  std::vector<int> place;
  for (const int g : group) place.push_back(first[at_index(factor.place(g))]++);
  for (int& row : row_) row = place[at_index(row)];
}

// group <- by row, the number of its group. Returns how many there are.
int VelocityHessian::group_rows(std::vector<int>& group) {
  moved_rows_ = 0;
  group.assign(at_index(rows_), 0);
  std::vector<int> split{0}, split_by{-1};  // by group: what its rows in a block become, and the last block
  int block_number = 0;
  for (const Block& block : blocks_) {
    for (const int row : block.rows) {
      int& g = group[at_index(row)];
      const std::size_t old = at_index(g);
      if (split_by[old] != block_number) {
        split_by[old] = block_number;
        split[old] = static_cast<int>(split.size());
        split.push_back(0);
        split_by.push_back(-1);
      }
      g = split[old];
    }
    ++block_number;
  }
  std::vector<int> number(split.size(), -1);
  int count = 0;
  for (int& g : group) {
    const bool alone = g == 0;  // in no block
    if (!alone) ++moved_rows_;
    if (alone || number[at_index(g)] < 0) number[at_index(g)] = count++;
    g = number[at_index(g)];
  }
  return count;
}

void VelocityHessian::analyze() {
  analyzed_ = true;
  std::vector<std::vector<int>> columns(at_index(rows_));
  for (int i = 0; i < rows_; ++i) columns[at_index(i)].push_back(i);
  for (const Block& block : blocks_) {
    for (std::size_t c = 0; c < block.rows.size(); ++c) {
      auto& column = columns[at_index(block.rows[c])];
      column.insert(column.end(), block.rows.begin() + static_cast<std::ptrdiff_t>(c), block.rows.end());
    }
  }
  std::vector<int> starts{0};
  for (auto& column : columns) {
    std::ranges::sort(column);
    column.erase(std::unique(column.begin(), column.end()), column.end());
    starts.push_back(starts.back() + static_cast<int>(column.size()));
  }
  H_.resize(rows_, rows_);
  H_.resizeNonZeros(starts.back());
  std::ranges::copy(starts, H_.outerIndexPtr());
  for (int i = 0; i < rows_; ++i) std::ranges::copy(columns[at_index(i)], H_.innerIndexPtr() + starts[at_index(i)]);
  std::fill_n(H_.valuePtr(), starts.back(), 1.0);
  for (Block& block : blocks_) {
    block.places.clear();
    for (std::size_t c = 0; c < block.rows.size(); ++c) {
      const auto& column = columns[at_index(block.rows[c])];
      for (std::size_t r = c; r < block.rows.size(); ++r) {
        const auto found = std::ranges::lower_bound(column, block.rows[r]) - column.begin();
        block.places.push_back(starts[at_index(block.rows[c])] + static_cast<int>(found));
      }
    }
  }
  factor_.analyzePattern(H_);
}

void VelocityHessian::multiply(const double* x, Eigen::VectorXd& w) const {
  w.setZero(rows_);
  for (std::size_t j = 0; j + 1 < first_.size(); ++j) {
    if (x[j] == 0) continue;
    for (int k = first_[j]; k < first_[j + 1]; ++k) w[row_[at_index(k)]] += value_[at_index(k)] * x[j];
  }
}

void VelocityHessian::multiply_transposed(const Eigen::VectorXd& w, double* out) const {
  for (std::size_t j = 0; j + 1 < first_.size(); ++j) {
    out[j] = 0;
    for (int k = first_[j]; k < first_[j + 1]; ++k) out[j] += value_[at_index(k)] * w[row_[at_index(k)]];
  }
}

bool VelocityHessian::factorize(std::span<const Cone> cones, std::span<const ProjectionModes> modes,
                                std::span<const ModeWeights> weights) {
  if (!analyzed_) analyze();
  std::fill_n(H_.valuePtr(), H_.nonZeros(), 0.0);
  for (int i = 0; i < rows_; ++i) H_.valuePtr()[H_.outerIndexPtr()[i]] = 1;
  int present = -1;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    if (block_of_[i] != present) {
      if (present >= 0) scatter(blocks_[at_index(present)]);
      present = block_of_[i];
      sum_.assign(blocks_[at_index(present)].places.size(), 0.0);
    }
    add(cones[i], blocks_[at_index(present)], modes[i], weights[i]);
  }
  if (present >= 0) scatter(blocks_[at_index(present)]);
  factor_.factorize(H_);
  return factor_.info() == Eigen::Success;
}

// Adds what a cone contributes to its block.
void VelocityHessian::add(const Cone& cone, const Block& block, const ProjectionModes& modes,
                          const ModeWeights& weights) {
  const std::size_t n = block.rows.size();
  for (int m = 0; m < modes.count; ++m) {
    y_.assign(n, 0.0);
    for (int c = 0; c < cone.size(); ++c) {
      const double q = modes.q[at_index(m)][at_index(c)];
      if (q == 0) continue;
      const auto column = at_index(cone.first + c);
      for (int k = first_[column]; k < first_[column + 1]; ++k)
        y_[at_index(local_[at_index(k)])] += q * value_[at_index(k)];
    }
    const double factor = weights[at_index(m)];
    std::size_t place = 0;
    for (std::size_t c = 0; c < n; ++c) {
      const double scaled = factor * y_[c];
      for (std::size_t r = c; r < n; ++r) sum_[place++] += scaled * y_[r];
    }
  }
}

void VelocityHessian::scatter(const Block& block) {
  for (std::size_t k = 0; k < block.places.size(); ++k) H_.valuePtr()[block.places[k]] += sum_[k];
}

void VelocityHessian::solve(const Eigen::VectorXd& g, Eigen::VectorXd& out) const { out = factor_.solve(g); }

void VelocityHessian::solve_lifted(std::span<const Cone> cones, const double* sigma, const double* lifted,
                                   double tolerance, const Eigen::VectorXd& g, Eigen::VectorXd& out) {
  solve(g, right_);
  if (std::all_of(lifted, lifted + first_.size() - 1, [](double x) { return x == 0; })) {
    out = right_;
    return;
  }
  change_.resize(first_.size());
  const auto apply = [&](const Eigen::VectorXd& in, Eigen::VectorXd& image) {
    multiply_transposed(in, change_.data());
    for (const Cone& cone : cones) {
      double lift = 0;
      for (int c = cone.first; c < cone.first + cone.size(); ++c) lift += sigma[c] * change_[at_index(c)];
      for (int c = cone.first; c < cone.first + cone.size(); ++c) change_[at_index(c)] = lift * lifted[c];
    }
    multiply(change_.data(), moved_);
    solve(moved_, image);
    image += in;
  };
  gmres_.solve(apply, right_, tolerance, max_gmres_steps, out);
}

}  // namespace gelenk
