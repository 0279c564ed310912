// SPDX-License-Identifier: MIT
#include <selvedge/core/detail/preconditioner.h>
#include <selvedge/core/parallel.h>

#include <Eigen/LU>
#include <vector>

namespace selvedge::detail {
namespace {

constexpr std::size_t kBlockGrain = 2048;

class BlockJacobi final : public Preconditioner {
 public:
  void set_matrix(const BlockMatrix& a, std::span<const char> free) override {
    a_ = &a;
    free_ = free;
  }

  void set_terms(TermOperator& terms) override {
    const std::size_t n = a_->size();
    inverse_.resize(n);
    for (std::size_t i = 0; i < n; ++i) inverse_[i] = a_->diagonal(i);
    terms.add_diagonal(inverse_);
    for (std::size_t i = 0; i < n; ++i)
      inverse_[i] = free_[i] ? Mat3(inverse_[i].inverse()) : Mat3::Zero();
  }

  void apply(std::span<const Vec3> r, std::span<Vec3> z) override {
    parallel_for(r.size(), kBlockGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) z[i].noalias() = inverse_[i] * r[i];
    });
  }

 private:
  const BlockMatrix* a_ = nullptr;
  std::span<const char> free_;
  std::vector<Mat3> inverse_;
};

}  // namespace

std::unique_ptr<Preconditioner> make_block_jacobi() { return std::make_unique<BlockJacobi>(); }

}  // namespace selvedge::detail
