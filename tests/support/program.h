// The program as run by a user.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

namespace godobject::test {

struct ProgramResult {
  int exit_code = -1;
  std::string output;  // standard output and standard error
};

/// Runs `godobject <arguments>` in a shell, from the source directory. prefix: command that runs it, e.g.
/// "timeout 1 ".
inline ProgramResult run_program(const std::string& arguments, const std::string& prefix = "") {
  ProgramResult result;
  const std::string command =
      "cd '" GODOBJECT_SOURCE_DIR "' && " + prefix + "'" GODOBJECT_PROGRAM "' " + arguments + " 2>&1";
  std::FILE* const pipe = popen(command.c_str(), "r");
  if (!pipe) return result;
  std::array<char, 4096> buffer{};
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    result.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A test with its own directory, empty at the start, removed at the end.
class ProgramTest : public testing::Test {
 protected:
  ProgramTest() {
    std::string name = (std::filesystem::path(testing::TempDir()) / "godobject-XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~ProgramTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace godobject::test
