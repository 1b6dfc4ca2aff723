#include "platform/cli/run/view.h"

#include <unistd.h>

#include "platform/cli/fault_texts.h"
#include "platform/view/server/server.h"

namespace godobject {
namespace {

constexpr std::size_t view_console_bytes = 1 << 16;

template <class Text>
BitText words_of(const Text& text) {
  return {.name = std::string(text.name),
          .text = std::string(text.meaning) + ": " + std::string(text.remedy)};
}

}  // namespace

void add_words(ViewAbout& about) {
  for (const CoreFaultText& fault : core_fault_texts) about.faults.push_back(words_of(fault.text));
  for (const RigFaultText& fault : rig_fault_texts()) about.rig_faults.push_back(words_of(fault));
  for (const RunLimit& limit : run_limits)
    about.limits.push_back({.name = std::string(limit.name), .text = std::string(limit.remedy)});
}

std::string view_warning(const std::string& address) {
  if (is_loopback(address)) return "";
  return "served on " + address +
         ", unencrypted: everybody who reaches this address and sees the token can watch";
}

std::string RunView::start(const RunOptions& options, PreparedRun& prepared) {
  ViewAbout about{.title = options.scene,
                  .takes_pointer = options.view_input,
                  .warning = view_warning(options.view_address)};
  add_words(about);
  for (const BusLoad& load : prepared.bus_loads)
    about.buses.push_back({.name = load.bus, .percent = load.worst_percent});
  address_ = options.view_address;
  console_ = std::make_unique<BackgroundFile>(STDERR_FILENO, view_console_bytes);
  live_ = std::make_unique<LiveView>(*prepared.session, about, prepared.pointer.get(),
                                     prepared.joint_pointer.get());
  const ServerSettings settings{.address = address_, .port = *options.view, .token = view_token()};
  const auto log = [this](const std::string& line) {
    static_cast<void>(console_->write("view: " + line + "\n"));
  };
  std::string why_not;
  server_ = ViewServer::start(settings, *live_, log, why_not);
  if (server_) prepared.plan.tap = &live_->tap();
  return why_not;
}

std::vector<std::string> view_lines(const std::string& url, const std::string& address) {
  std::vector<std::string> lines{"view: " + url};
  if (const std::string warning = view_warning(address); !warning.empty())
    lines.push_back("view: WARNING: " + warning);
  if (!has_page())
    lines.push_back(
        "view: this program was built without its page, which requires npm and esbuild: run ./dev setup "
        "view, then build again");
  return lines;
}

}  // namespace godobject
