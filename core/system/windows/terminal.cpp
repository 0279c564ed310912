// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/windows.h>
#include <selvedge/core/system/internal/terminal.h>

#include <fcntl.h>
#include <io.h>
#include <shellapi.h>

#include <cstdio>
#include <filesystem>

namespace selvedge {

bool error_stream_is_terminal() { return _isatty(_fileno(stderr)) != 0; }

std::vector<std::string> program_arguments(int, char**) {
  int count = 0;
  wchar_t** const words = CommandLineToArgvW(GetCommandLineW(), &count);
  std::vector<std::string> arguments;
  for (int i = 0; i < count; ++i) arguments.push_back(std::filesystem::path(words[i]).string());
  LocalFree(words);
  return arguments;
}

void write_bytes_to_output() { _setmode(_fileno(stdout), _O_BINARY); }

void prepare_console() {
  SetConsoleOutputCP(CP_UTF8);
  const HANDLE error = GetStdHandle(STD_ERROR_HANDLE);
  DWORD mode = 0;
  if (GetConsoleMode(error, &mode) != 0)
    SetConsoleMode(error, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

}  // namespace selvedge
