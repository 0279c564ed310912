// SPDX-License-Identifier: MIT
// What a run leaves and reads again. The first byte chooses: the text of a result, which is written
// as it was read; the JSON half of a checkpoint beside a good PLY half; or the PLY half.
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/result_folder.h>

#include <cstdlib>

#include "fuzz.h"

namespace {

using namespace selvedge;

void write(const std::filesystem::path& file, const std::uint8_t* bytes, std::size_t n) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(n));
}

/// A folder with the checkpoint of a triangle.
class Folder {
 public:
  Folder() : path_("/dev/shm/selvedge_fuzz_" + std::to_string(getpid())) {
    std::filesystem::create_directories(path_);
    detail::StateCopy copy;
    copy.state.x = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
    copy.state.v.assign(3, Vec3::Zero());
    static const std::vector<Triangle> triangles{{0, 1, 2}};
    copy.triangles = triangles;
    detail::write_checkpoint(path_, 1, copy, RunResult{});
    std::filesystem::copy_file(path_ / "checkpoint.ply", path_ / "good.ply");
    std::filesystem::copy_file(path_ / "checkpoint.json", path_ / "good.json");
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  void restore(const std::string& half) const {
    std::filesystem::copy_file(path_ / ("good" + half), path_ / ("checkpoint" + half),
                               std::filesystem::copy_options::overwrite_existing);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  static const Folder folder;
  if (n == 0) return 0;
  try {
    if (bytes[0] % 3 == 0) {
      const RunResult result =
          result_from_text(std::string(reinterpret_cast<const char*>(bytes + 1), n - 1));
      const std::string text = result_text(result);
      if (result_text(result_from_text(text)) != text) std::abort();
    } else {
      const std::string half = bytes[0] % 3 == 1 ? ".json" : ".ply";
      folder.restore(half == ".json" ? ".ply" : ".json");
      write(folder.path() / ("checkpoint" + half), bytes + 1, n - 1);
      const detail::Checkpoint checkpoint = detail::read_checkpoint(folder.path());
      if (checkpoint.state.x.size() != checkpoint.state.v.size()) std::abort();
    }
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
