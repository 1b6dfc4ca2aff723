// The view of a run: its server, what it says on the console, and what the loop fills for it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "platform/cli/run/options.h"
#include "platform/rt/background_file.h"
#include "platform/view/live.h"

namespace godobject {

/// The words that a view shows for the bits of a frame.
void add_words(ViewAbout& about);
/// Where a page is, and what of it to be careful with.
std::vector<std::string> view_lines(const std::string& url, const std::string& address);
/// What a page warns of that is served on this address; empty: nothing.
std::string view_warning(const std::string& address);

class RunView {
 public:
  /// Serves from here on, and sets the plan's tap. Empty, or why not.
  std::string start(const RunOptions& options, PreparedRun& prepared);
  std::vector<std::string> announcement() const { return view_lines(server_->url(), address_); }

 private:
  std::string address_;
  std::unique_ptr<BackgroundFile> console_;
  std::unique_ptr<LiveView> live_;
  std::unique_ptr<ViewServer> server_;
};

}  // namespace godobject
