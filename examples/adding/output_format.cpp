// SPDX-License-Identifier: MIT
// One text file per frame, with one line "x y z" per cloth vertex.
#include "additions.h"

#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace adding {
namespace {

using namespace selvedge;
namespace fs = std::filesystem;

class PointFiles final : public FrameWriter {
 public:
  explicit PointFiles(fs::path folder) : folder_(std::move(folder)) {}

  void write(const Frame& frame) override {
    std::ostringstream name;
    name << "cloth_" << std::setfill('0') << std::setw(5) << frame.number << ".xyz";
    std::ofstream out(folder_ / name.str());
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
    for (const Vec3& x : frame.x) out << x.x() << ' ' << x.y() << ' ' << x.z() << '\n';
    if (!out.flush()) throw std::runtime_error((folder_ / name.str()).string() + ": not written");
  }

 private:
  fs::path folder_;
};

}  // namespace

FrameFormat points_format() {
  return {.promise = "one line \"x y z\" per cloth vertex, digits that read back exactly",
          .source = "docs/adding.md",
          .extension = ".xyz",
          .make = [](const fs::path& out) { return std::make_unique<PointFiles>(out / "frames"); }};
}

}  // namespace adding
