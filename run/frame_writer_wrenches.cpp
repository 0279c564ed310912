// SPDX-License-Identifier: MIT
//
// A table of what bodies, handles and held vertices feel. Its rows stay when a run is resumed.
#include <fmt/format.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/named_wrenches.h>
#include <selvedge/run/frame_writer.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader =
    "frame,time_s,on,about_x_m,about_y_m,about_z_m,force_x_N,force_y_N,force_z_N,torque_x_Nm,"
    "torque_y_Nm,torque_z_Nm\n";

std::string csv_quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

class WrenchTable final : public FrameWriter {
 public:
  explicit WrenchTable(fs::path file) : file_(std::move(file)) {}

  void write(const Frame& frame) override {
    if (frame.wrenches.empty()) return;
    std::string rows;
    for (const NamedWrench& w : frame.wrenches)
      rows += fmt::format(
          "{},{:.17g},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},"
          "{:.17g},{:.17g}\n",
          frame.number, frame.time, csv_quoted(w.on), w.about.x(), w.about.y(), w.about.z(),
          w.force.x(), w.force.y(), w.force.z(), w.torque.x(), w.torque.y(), w.torque.z());
    if (!std::exchange(started_, true)) {
      AtomicFile file(file_);
      file.write(rows_before(frame.number) + rows);
      file.commit();
    } else if (!(std::ofstream(file_, std::ios::app) << rows << std::flush)) {
      throw std::runtime_error("cannot write " + file_.string());
    }
  }

 private:
  /// The rows of the file, as a former part of the run left it, of frames below `number`.
  std::string rows_before(int number) const {
    std::string rows = kHeader, line;
    std::ifstream in(file_);
    std::getline(in, line);
    while (std::getline(in, line))
      if (std::atoi(line.c_str()) < number) rows += line + "\n";
    return rows;
  }

  fs::path file_;
  bool started_ = false;
};

}  // namespace

std::unique_ptr<FrameWriter> detail::make_wrench_table(const fs::path& file) {
  return std::make_unique<WrenchTable>(file);
}

void register_wrenches(FrameFormatRegistry& registry) {
  registry.add(
      "wrenches", {},
      [](const MethodOptions&, const fs::path& out) {
        return detail::make_wrench_table(out / "wrenches.csv");
      },
      {.promise = "forces and torques on bodies, handles and held vertices, means over each frame",
       .source = "comma-separated values, RFC 4180",
       .files = {"wrenches.csv", "steps/wrenches.csv"}});
}

}  // namespace selvedge
