// SPDX-License-Identifier: MIT
#include <selvedge/render/render.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

extern char** environ;

namespace selvedge {
namespace {

constexpr const char* pad_to_even = "pad=ceil(iw/2)*2:ceil(ih/2)*2";

/// Output options of ffmpeg for a file extension; empty if the extension is unknown.
std::vector<std::string> encoding(const std::string& extension) {
  if (extension == ".mp4")
    return {"-vf",      pad_to_even, "-c:v",      "libx264",    "-crf", "18",
            "-pix_fmt", "yuv420p",   "-movflags", "+faststart", "-f",   "mp4"};
  if (extension == ".webm")
    return {"-vf",  pad_to_even, "-c:v",     "libvpx-vp9", "-crf", "28",
            "-b:v", "0",         "-pix_fmt", "yuv420p",    "-f",   "webm"};
  if (extension == ".gif")
    return {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=sierra2_4a", "-f", "gif"};
  return {};
}

std::string text(double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << value;
  return out.str();
}

/// A pair of connected sockets. If the reader has died, a write to a socket can return an error,
/// whereas a write to a pipe raises a signal that kills this process.
std::pair<int, int> connected_sockets() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::runtime_error(std::string("cannot talk to ffmpeg: ") + std::strerror(errno));
  return {ends[0], ends[1]};
}

/// Starts a program with `input` as its standard input; returns its process id or -errno.
int spawn(const std::vector<std::string>& words, int input) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  if (const int error = posix_spawn_file_actions_init(&actions); error != 0) return -error;
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = -1;
  const int error =
      posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return error != 0 ? -error : process;
}

}  // namespace

bool ffmpeg_is_there() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const auto program = std::filesystem::path(folder.empty() ? "." : folder) / "ffmpeg";
    std::error_code ignored;  // a file that cannot be inspected cannot be executed
    if (std::filesystem::is_regular_file(program, ignored) && ::access(program.c_str(), X_OK) == 0)
      return true;
  }
  return false;
}

AnimationWriter::AnimationWriter(std::filesystem::path file, double fps)
    : file_(std::move(file)), partial_(file_), fps_(fps) {
  partial_ += ".partial";
  if (encoding(file_.extension().string()).empty())
    throw std::invalid_argument(file_.string() + ": an animation ends in .mp4, .webm or .gif");
  if (!(fps_ > 0.0 && fps_ <= 1000.0))
    throw std::invalid_argument(file_.string() + ": " + text(fps_) +
                                " frames per second are not within 0 and 1000");
  if (!ffmpeg_is_there())
    throw std::invalid_argument(file_.string() +
                                ": ffmpeg is not on PATH; install it (apt install ffmpeg) or make "
                                "the animation from the pictures elsewhere");
}

AnimationWriter::~AnimationWriter() {
  if (process_ < 0) return;
  wait();
  std::error_code ignored;  // a destructor cannot report that the file remains
  std::filesystem::remove(partial_, ignored);
}

void AnimationWriter::start(int width, int height) {
  width_ = width;
  height_ = height;
  // With the prefix `file:`, ffmpeg treats the name as a file even if it looks like an option or a
  // protocol.
  std::vector<std::string> words = {
      "ffmpeg",    "-y",
      "-loglevel", "error",
      "-f",        "rawvideo",
      "-pix_fmt",  "rgb24",
      "-s",        std::to_string(width) + "x" + std::to_string(height),
      "-r",        text(fps_),
      "-i",        "pipe:0"};
  for (const std::string& word : encoding(file_.extension().string())) words.push_back(word);
  words.push_back("file:" + partial_.string());
  const auto [mine, theirs] = connected_sockets();
  process_ = spawn(words, theirs);
  ::close(theirs);
  socket_ = mine;
  if (process_ >= 0) return;
  ::close(std::exchange(socket_, -1));
  throw std::runtime_error(std::string("cannot start ffmpeg: ") +
                           std::strerror(-std::exchange(process_, -1)));
}

void AnimationWriter::add(const Image& image) {
  if (process_ < 0) start(image.width, image.height);
  if (image.width != width_ || image.height != height_)
    throw std::invalid_argument(file_.string() + ": pictures of different sizes");
  const std::uint8_t* begin = image.rgb.data();
  for (std::size_t left = image.rgb.size(); left > 0;) {
    const ssize_t sent = ::send(socket_, begin, left, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) throw std::runtime_error(file_.string() + ": ffmpeg stopped before the end");
    begin += sent;
    left -= static_cast<std::size_t>(sent);
  }
}

/// Closes the input and waits for ffmpeg. Returns its wait status, or -1.
int AnimationWriter::wait() {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
  int status = 0;
  const pid_t process = std::exchange(process_, -1);
  pid_t ended = -1;
  do ended = ::waitpid(process, &status, 0);
  while (ended < 0 && errno == EINTR);
  return ended == process ? status : -1;
}

void AnimationWriter::finish() {
  if (process_ < 0) throw std::runtime_error(file_.string() + ": an animation without a picture");
  const int status = wait();
  std::error_code error;
  if (status == 0) std::filesystem::rename(partial_, file_, error);
  if (status == 0 && !error) return;
  const std::string cause = error ? error.message() : "ffmpeg failed; its message stands above";
  std::filesystem::remove(partial_, error);
  throw std::runtime_error("cannot write " + file_.string() + ": " + cause);
}

}  // namespace selvedge
