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
  PointFiles(fs::path folder, int digits) : folder_(std::move(folder)), digits_(digits) {}

  void write(const Frame& frame) override {
    std::ostringstream name;
    name << "cloth_" << std::setfill('0') << std::setw(5) << frame.number << ".xyz";
    std::ofstream out(folder_ / name.str());
    out << std::setprecision(digits_);
    for (const Vec3& x : frame.x) out << x.x() << ' ' << x.y() << ' ' << x.z() << '\n';
    if (!out.flush()) throw std::runtime_error((folder_ / name.str()).string() + ": not written");
  }

 private:
  fs::path folder_;
  int digits_;
};

}  // namespace

void register_points(FrameFormatRegistry& registry) {
  registry.add("points",
               {{.name = "digits",
                 .initial = std::numeric_limits<double>::max_digits10,
                 .unit = "1",
                 .least = 1.0,
                 .most = std::numeric_limits<double>::max_digits10,
                 .kind = OptionKind::whole,
                 .meaning = "digits of a coordinate; the default reads back exactly"}},
               [](const MethodOptions& o, const fs::path& out) {
                 return std::make_unique<PointFiles>(out / "frames", o.whole("digits"));
               },
               {.promise = "one line \"x y z\" per cloth vertex",
                .source = "docs/adding.md",
                .extension = ".xyz"});
}

}  // namespace adding
