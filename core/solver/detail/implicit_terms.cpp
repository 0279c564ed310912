// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/detail/implicit_terms.h>

#include <stdexcept>
#include <string>

namespace selvedge::detail {
namespace {

constexpr std::size_t kTermGrain = 1024;

}  // namespace

void TermOperator::reset(std::span<const ImplicitTerm> terms, std::size_t particles,
                         const Followers* followers) {
  terms_ = terms;
  moment_.resize(terms.size());
  count_.assign(particles, 0);
  corners_.clear();
  corner_begin_.assign(1, 0);
  const std::size_t named = followers == nullptr ? particles : followers->particles();
  for (std::size_t t = 0; t < terms.size(); ++t) {
    for (const std::int32_t p : terms[t].particle)
      if (p >= static_cast<std::int32_t>(named))
        throw std::invalid_argument("implicit term " + std::to_string(t) + " names particle " +
                                    std::to_string(p) + ", but there are " + std::to_string(named));
    for (int k = 0; k < 4; ++k)
      for_each_row(terms[t], k, followers, [&](std::int32_t i, double weight) {
        corners_.push_back({i, weight});
        ++count_[i];
      });
    corner_begin_.push_back(corners_.size());
  }
  touched_.clear();
  row_begin_.assign(1, 0);
  for (std::size_t p = 0; p < particles; ++p) {
    if (count_[p] == 0) continue;
    touched_.push_back(static_cast<std::int32_t>(p));
    row_begin_.push_back(row_begin_.back() + count_[p]);
    count_[p] = row_begin_[row_begin_.size() - 2];  // from here on: where the next entry goes
  }
  incidence_.resize(row_begin_.back());
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (const Corner& c : corners_of(t))
      incidence_[count_[c.particle]++] = {static_cast<std::int32_t>(t), c.weight};
}

/// Calls body(t, Σ_l w_l x_l) for each term t.
template <class Body>
void TermOperator::for_each_sum(std::span<const Vec3> x, const Body& body) const {
  parallel_for(terms_.size(), kTermGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Vec3 sum = Vec3::Zero();
      for (const Corner& c : corners_of(t)) sum += c.weight * x[c.particle];
      body(t, sum);
    }
  });
}

void TermOperator::add_multiply(std::span<const Vec3> x, std::span<Vec3> y) {
  for_each_sum(x, [&](std::size_t t, const Vec3& sum) { moment_[t] = terms_[t].matrix * sum; });
  add_moments(y);
}

void TermOperator::add_residual(std::span<const Vec3> x, std::span<Vec3> y) {
  for_each_sum(x, [&](std::size_t t, const Vec3& sum) {
    moment_[t] = terms_[t].rhs - terms_[t].matrix * sum;
  });
  add_moments(y);
}

/// y += Σ_t w_t moment_t.
void TermOperator::add_moments(std::span<Vec3> y) const {
  parallel_for(touched_.size(), kTermGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      Vec3 sum = Vec3::Zero();
      for (std::int32_t i = row_begin_[r]; i < row_begin_[r + 1]; ++i)
        sum += incidence_[i].weight * moment_[incidence_[i].term];
      y[touched_[r]] += sum;
    }
  });
}

void TermOperator::add_diagonal(std::span<Mat3> diagonal) const {
  for (std::size_t t = 0; t < terms_.size(); ++t)
    for (const Corner& c : corners_of(t))
      // A particle that occurs twice in a term is coupled with itself.
      for (const Corner& other : corners_of(t))
        if (other.particle == c.particle)
          diagonal[c.particle] += (c.weight * other.weight) * terms_[t].matrix;
}

}  // namespace selvedge::detail
