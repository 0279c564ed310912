// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/implicit_terms.h>
#include <selvedge/core/parallel.h>

#include <stdexcept>
#include <string>

namespace selvedge::detail {
namespace {

constexpr std::size_t kTermGrain = 1024;

}  // namespace

void TermOperator::reset(std::span<const ImplicitTerm> terms, std::size_t particles) {
  terms_ = terms;
  moment_.resize(terms.size());
  count_.assign(particles, 0);
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (const std::int32_t p : terms[t].particle) {
      if (p >= static_cast<std::int32_t>(particles))
        throw std::invalid_argument("implicit term " + std::to_string(t) + " names particle " +
                                    std::to_string(p) + ", but there are " +
                                    std::to_string(particles));
      if (p >= 0) ++count_[p];
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
    for (std::int32_t k = 0; k < 4; ++k)
      if (terms[t].particle[k] >= 0)
        incidence_[count_[terms[t].particle[k]]++] = {static_cast<std::int32_t>(t), k};
}

/// Calls body(t, Σ_l w_l x_l) for each term t.
template <class Body>
void TermOperator::for_each_sum(std::span<const Vec3> x, const Body& body) const {
  parallel_for(terms_.size(), kTermGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < 4; ++k)
        if (terms_[t].particle[k] >= 0) sum += terms_[t].weight[k] * x[terms_[t].particle[k]];
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
        sum +=
            terms_[incidence_[i].term].weight[incidence_[i].corner] * moment_[incidence_[i].term];
      y[touched_[r]] += sum;
    }
  });
}

void TermOperator::add_diagonal(std::span<Mat3> diagonal) const {
  for (const ImplicitTerm& t : terms_)
    for (int k = 0; k < 4; ++k)
      if (t.particle[k] >= 0)
        // A particle that occurs twice in a term is coupled with itself.
        for (int l = 0; l < 4; ++l)
          if (t.particle[l] == t.particle[k])
            diagonal[t.particle[k]] += (t.weight[k] * t.weight[l]) * t.matrix;
}

}  // namespace selvedge::detail
