// The program in the background, controlled by its standard input and output.
#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/may_allocate.h"

namespace godobject::test {

class BackgroundProgram {
 public:
  /// Runs `godobject <arguments>` from the source directory. closed: descriptors closed at its start.
  explicit BackgroundProgram(const std::vector<std::string>& arguments, const std::vector<int>& closed = {}) {
    int to_child[2], from_child[2];
    if (pipe(to_child) != 0 || pipe(from_child) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      dup2(to_child[0], STDIN_FILENO);
      dup2(from_child[1], STDOUT_FILENO);
      for (const int fd : {to_child[0], to_child[1], from_child[0], from_child[1]}) close(fd);
      if (chdir(GODOBJECT_SOURCE_DIR) != 0) _exit(126);
      for (const int fd : closed) close(fd);
      std::vector<char*> argv{const_cast<char*>(GODOBJECT_PROGRAM)};
      for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
      argv.push_back(nullptr);
      execv(GODOBJECT_PROGRAM, argv.data());
      _exit(127);
    }
    close(to_child[0]);
    close(from_child[1]);
    in_ = fdopen(to_child[1], "w");
    out_ = fdopen(from_child[0], "r");
  }
  ~BackgroundProgram() {
    if (pid_ > 0) kill(pid_, SIGTERM);
    if (pid_ > 0) kill(pid_, SIGCONT);  // a stopped program does not end before
    if (pid_ > 0) waitpid(pid_, nullptr, 0);
    if (in_) std::fclose(in_);
    if (out_) std::fclose(out_);
  }
  BackgroundProgram(const BackgroundProgram&) = delete;
  BackgroundProgram& operator=(const BackgroundProgram&) = delete;

  /// Sends a signal and waits for the end.
  void end_by(int signal) {
    if (pid_ > 0) kill(pid_, signal);
    if (pid_ > 0) waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

  pid_t pid() const { return pid_; }
  /// Waits for the end and returns the status of waitpid().
  int wait_status() {
    int status = 0;
    if (pid_ > 0) waitpid(pid_, &status, 0);
    pid_ = -1;
    return status;
  }

  /// Returns the next line, without its end; empty at the end of the output.
  std::string line() {
    std::string text;
    if (!out_) return text;
    for (int c = std::fgetc(out_); c != EOF && c != '\n'; c = std::fgetc(out_)) text += static_cast<char>(c);
    return text;
  }
  /// Sends a command and leaves its answer unread.
  void tell(const std::string& command) {
    std::fprintf(in_, "%s\n", command.c_str());
    std::fflush(in_);
  }
  /// Sends a command and returns the line of its answer.
  std::string say(const std::string& command) {
    [[maybe_unused]] const MayAllocate scope;  // within a cycle, too
    tell(command);
    return line();
  }

 private:
  pid_t pid_ = -1;
  std::FILE *in_ = nullptr, *out_ = nullptr;
};

}  // namespace godobject::test
