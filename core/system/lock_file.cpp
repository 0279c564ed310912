// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/descriptor.h>
#include <selvedge/core/system/detail/lock_file.h>

#include <fstream>
#include <stdexcept>

namespace selvedge::detail {

void note_owner(int descriptor) {
  const std::string text = std::to_string(process_number()) + "\n";
  if (resize_file(descriptor, 0) != 0) return;
  if (write_at(descriptor, text.data(), text.size(), 0) < 0) return;
}

void refuse_second(const std::filesystem::path& file, const std::string& user) {
  std::ifstream in(file);
  long process = 0;
  const std::string owner = in >> process ? " (process " + std::to_string(process) + ")" : "";
  throw std::invalid_argument(file.parent_path().string() + ": another " + user + owner +
                              " is at work in this folder; wait for it, or name another folder "
                              "with --out");
}

void refuse_folder(const std::filesystem::path& file, const std::string& cause) {
  throw std::invalid_argument(file.string() + ": cannot be made: " + cause +
                              "; name a folder that can be written with --out");
}

}  // namespace selvedge::detail
