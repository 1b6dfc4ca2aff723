// Checks of interrupt threads (Linux's Documentation/core-api/irq): those of the buses are above the loop,
// and none runs on an isolated core.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <system_error>
#include <vector>

#include "platform/rt/machine_files.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

struct Interrupt {
  unsigned number = 0;
  std::vector<std::string> devices;  // names of its handlers
  Cores cores;                       // that may run it
  int thread = 0;                    // process id of its thread; 0: none
  int priority = 0;                  // of the thread; 0: not real-time
};

/// Returns the real-time priority of a process, the 40th column of its file `stat` (proc(5)).
int priority_of(const fs::path& process) {
  std::string text = line_of(process / "stat").value_or("");
  text.erase(0, text.rfind(')') + 1);  // the name before it may contain spaces
  std::istringstream columns(text);
  std::string column;
  for (int i = 3; i <= 39; ++i) columns >> column;
  int priority = 0;
  columns >> priority;
  return priority;
}

void find_threads(const fs::path& proc, std::vector<Interrupt>& interrupts) {
  std::error_code ignored;
  for (const fs::directory_entry& process : fs::directory_iterator(proc, ignored)) {
    const std::string id = process.path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string name = line_of(process.path() / "comm").value_or("");
    unsigned number = 0;
    if (std::sscanf(name.c_str(), "irq/%u-", &number) != 1) continue;
    const auto found = std::ranges::find(interrupts, number, &Interrupt::number);
    if (found == interrupts.end()) continue;
    found->thread = std::stoi(id);
    found->priority = priority_of(process.path());
  }
}

/// Returns the interrupts that have a handler, by number.
std::vector<Interrupt> interrupts_of(const fs::path& root) {
  std::vector<Interrupt> interrupts;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "proc/irq", ignored)) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    Interrupt irq{.number = static_cast<unsigned>(std::stoul(name)), .devices = {}, .cores = {}};
    for (const fs::directory_entry& handler : fs::directory_iterator(entry.path(), ignored))
      if (handler.is_directory(ignored)) irq.devices.push_back(handler.path().filename());
    std::string cores = line_of(entry.path() / "effective_affinity_list").value_or("");
    if (cores.empty()) cores = line_of(entry.path() / "smp_affinity_list").value_or("");
    irq.cores = cores_in(cores);
    if (!irq.devices.empty()) interrupts.push_back(std::move(irq));
  }
  std::ranges::sort(interrupts, {}, &Interrupt::number);
  find_threads(root / "proc", interrupts);
  return interrupts;
}

std::string name_of(const Interrupt& irq) { return std::to_string(irq.number) + "-" + irq.devices.front(); }

/// Interrupts of a network interface or serial line.
struct Owned {
  std::string name;            // of the device, as some handlers have it
  std::set<unsigned> numbers;  // of the nearest device above that has interrupts
};

/// Finds the interrupts of an interface by its device. Those of a USB adapter are its controller's, whose
/// handler has another name.
/// interface: name of a network interface, or path of a serial line.
Owned owned_by(const std::string& interface, const fs::path& root) {
  std::error_code error;
  fs::path of_class = root / "sys/class/net" / interface;
  if (interface.starts_with('/'))
    of_class = root / "sys/class/tty" / fs::weakly_canonical(root / interface.substr(1), error).filename();
  fs::path device = fs::canonical(of_class / "device", error);
  Owned owned{.name = interface, .numbers = {}};
  if (error) return owned;
  owned.name = device.filename();
  for (; device.has_relative_path() && device.filename() != "devices"; device = device.parent_path()) {
    for (const fs::directory_entry& message : fs::directory_iterator(device / "msi_irqs", error))
      owned.numbers.insert(static_cast<unsigned>(std::stoul(message.path().filename())));
    unsigned line = 0;
    if (std::ifstream(device / "irq") >> line && line > 0) owned.numbers.insert(line);
    if (!owned.numbers.empty()) break;
  }
  return owned;
}

bool belongs_to(const Interrupt& irq, const std::string& interface, const Owned& owned) {
  return std::ranges::count(irq.devices, interface) > 0 || std::ranges::count(irq.devices, owned.name) > 0 ||
         owned.numbers.contains(irq.number);
}

/// Lists the first threads with their priorities and cores.
std::string threads_text(const std::vector<Interrupt>& interrupts) {
  constexpr std::size_t max_listed = 6;
  std::string text;
  std::size_t count = 0;
  for (const Interrupt& irq : interrupts) {
    if (irq.thread == 0 || ++count > max_listed) continue;
    text += (text.empty() ? "irq/" : ", irq/") + name_of(irq) + " (priority " + std::to_string(irq.priority) +
            ", core " + list_of(irq.cores) + ")";
  }
  if (count > max_listed) text += " and " + std::to_string(count - max_listed) + " more";
  return text.empty() ? "no interrupt has a thread" : text;
}

}  // namespace

RtStep check_interrupts(const fs::path& root, std::span<const std::string> interfaces) {
  RtStep step{.name = "interrupts", .result = RtResult::degraded, .detail = "", .remedy = ""};
  std::error_code error;
  if (!fs::is_directory(root / "proc/irq", error)) return unreadable(step.name, "/proc/irq");
  const std::vector<Interrupt> interrupts = interrupts_of(root);
  const Cores isolated = isolated_cores(root);
  std::vector<Owned> owned;
  for (const std::string& interface : interfaces) owned.push_back(owned_by(interface, root));
  const auto is_above_loop = [](const Interrupt& irq) { return irq.priority > rt_priority; };
  for (const Interrupt& irq : interrupts) {
    std::size_t bus = 0;
    while (bus < owned.size() && !belongs_to(irq, interfaces[bus], owned[bus])) ++bus;
    if (bus == owned.size() || irq.thread == 0 || is_above_loop(irq)) continue;
    step.detail = "irq/" + name_of(irq) + " of " + interfaces[bus] + " has priority " +
                  std::to_string(irq.priority) + ", below the loop's " + std::to_string(rt_priority) +
                  ": frames wait for the loop";
    step.remedy = "chrt -f -p " + std::to_string(rt_priority + 5) + " " + std::to_string(irq.thread);
    return step;
  }
  for (const Interrupt& irq : interrupts) {
    if (common(irq.cores, isolated).empty() || is_above_loop(irq)) continue;
    step.detail =
        "interrupt " + name_of(irq) + " may run on the isolated core " + list_of(common(irq.cores, isolated));
    step.remedy = "echo " + list_of(without(online_cores(root), isolated)) + " > /proc/irq/" +
                  std::to_string(irq.number) + "/smp_affinity_list";
    return step;
  }
  step.detail = threads_text(interrupts);
  const bool have_threads =
      has_preempt_rt(root) ||
      line_of(root / "proc/cmdline").value_or("").find("threadirqs") != std::string::npos;
  step.result = have_threads ? RtResult::ok : RtResult::degraded;
  if (!have_threads) {
    step.detail = "most handlers are not threads, and delay the loop: " + step.detail;
    step.remedy = boot_with("threadirqs");
  }
  return step;
}

}  // namespace godobject
