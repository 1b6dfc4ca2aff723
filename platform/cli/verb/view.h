// View of a run: its server, its console lines, and the frames from the loop.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "platform/cli/run/options.h"
#include "platform/rt/background_file.h"
#include "platform/view/live.h"

namespace godobject {

/// Adds the texts for the bits of a frame.
void add_words(ViewAbout& about);
/// Returns lines with the page's address and its warning.
std::vector<std::string> view_lines(const std::string& url, const std::string& address);
/// Returns the warning of a page served on this address; empty: none.
std::string view_warning(const std::string& address);

class RunView {
 public:
  /// Starts the server and sets the plan's tap. Returns why this failed; empty on success.
  std::string start(const RunOptions& options, PreparedRun& prepared);
  std::vector<std::string> announcement() const { return view_lines(server_->url(), address_); }

 private:
  std::string address_;
  std::unique_ptr<BackgroundFile> console_;
  std::unique_ptr<LiveView> live_;
  std::unique_ptr<ViewServer> server_;
};

}  // namespace godobject
