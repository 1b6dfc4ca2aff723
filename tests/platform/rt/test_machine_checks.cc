// Each check of the machine on invented machines, on which it is ok, degraded and failed.
#include <gmock/gmock.h>

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

#include "platform/linux/bus/socket_can.h"
#include "platform/linux/serial_port.h"
#include "platform/rt/disk.h"
#include "platform/rt/setup.h"
#include "tests/support/program.h"

namespace godobject::test::test_machine_checks {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr RtResult ok = RtResult::ok, degraded = RtResult::degraded, failed = RtResult::failed;

const std::string cpus = "sys/devices/system/cpu/";

/// A folder with /proc, /sys and /dev of a machine that meets every requirement.
class MachineChecks : public ProgramTest {
 protected:
  MachineChecks() {
    put("proc/version", "Linux version 6.1.0-rt SMP PREEMPT_RT Debian");
    put("proc/cmdline", "quiet");
    put("proc/self/status", "Name:\tx\nCapEff:\t0000000000000000\n");
    limits("unlimited", "98");
    put("proc/sys/kernel/sched_rt_runtime_us", "-1");
    put("proc/sys/kernel/sched_rt_period_us", "1000000");
    put("dev/cpu_dma_latency", "");
    put(cpus + "online", "0-3");
    put(cpus + "isolated", "3");
    put(cpus + "cpufreq/policy0/scaling_governor", "performance");
    put(cpus + "cpufreq/policy0/scaling_driver", "acpi-cpufreq");
    interrupt(30, "eth0", "0-2", 50);
    interrupt(31, "can0", "3", 85);
    access_.root = path("");
    access_.lock_memory = [this](int flags) { return lock_flags_ = flags, 0; };
    access_.take_priority = [this](int priority) { return priority <= highest_priority_ ? 0 : EPERM; };
  }

  void put(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(path(file)).parent_path());
    write(file, text + "\n");
  }
  void remove(const std::string& file) const { std::filesystem::remove_all(path(file)); }
  void limits(const std::string& memory, const std::string& priority) const {
    put("proc/self/limits",
        "Limit                     Soft Limit           Hard Limit           Units\n"
        "Max locked memory         " +
            memory +
            "   unlimited   bytes\n"
            "Max realtime priority     " +
            priority + "   99   ");
  }
  /// An interrupt with a thread. priority: of the thread; 0: no thread.
  void interrupt(int number, const std::string& device, const std::string& cores, int priority) const {
    const std::string n = std::to_string(number), process = "proc/4" + n;
    std::filesystem::create_directories(path("proc/irq/" + n + "/" + device));
    put("proc/irq/" + n + "/smp_affinity_list", cores);
    remove(process);
    if (priority == 0) return;
    put(process + "/comm", "irq/" + n + "-" + device);
    std::string columns = "4" + n + " (irq/" + n + "-a b) S";  // columns 1 to 3
    for (int i = 4; i <= 39; ++i) columns += " -7";
    put(process + "/stat", columns + " " + std::to_string(priority) + " 1 0");
  }
  RtStep real_time(const std::string& name) const { return find(real_time_checks(access_), name); }
  RtStep cores(const std::string& name) const {
    return find(core_checks(std::vector<std::string>{"can0"}, access_), name);
  }
  static RtStep find(const std::vector<RtStep>& steps, const std::string& name) {
    const auto step = std::ranges::find(steps, name, &RtStep::name);
    if (step == steps.end()) throw std::runtime_error("no check " + name);
    return *step;
  }
  /// Expects the result, and a remedy that contains this text; none for ok.
  static void expect(const RtStep& step, RtResult result, const std::string& remedy = "") {
    EXPECT_EQ(step.result, result) << step.name << ": " << step.detail;
    EXPECT_FALSE(step.detail.empty()) << step.name;
    EXPECT_EQ(step.remedy.empty(), result == ok) << step.name;
    EXPECT_THAT(step.remedy, HasSubstr(remedy));
  }

  MachineAccess access_;
  int lock_flags_ = 0, highest_priority_ = 99;
};

TEST_F(MachineChecks, AMachineWithAllRequirementsIsOkInEveryCheck) {
  for (const RtStep& step : real_time_checks(access_)) expect(step, ok);
  for (const RtStep& step : core_checks(std::vector<std::string>{"can0"}, access_)) expect(step, ok);
  EXPECT_EQ(lock_flags_, MCL_CURRENT | MCL_FUTURE);
}

TEST_F(MachineChecks, TheKernelIsFoundByItsFileOrByItsVersion) {
  put("proc/version", "Linux version 6.1.0 SMP PREEMPT_DYNAMIC");
  expect(real_time("kernel"), degraded, "apt install linux-image-rt-amd64");
  put("sys/kernel/realtime", "0");
  expect(real_time("kernel"), degraded, "apt install linux-image-rt-amd64");
  put("sys/kernel/realtime", "1");
  expect(real_time("kernel"), ok);
  remove("sys/kernel");
  remove("proc/version");
  expect(real_time("kernel"), failed, "mount -t proc");
}

TEST_F(MachineChecks, LockedMemoryIsLimitedOrRefused) {
  limits("8388608", "98");
  expect(real_time("lock memory"), degraded, "memlock unlimited");
  EXPECT_THAT(real_time("lock memory").detail, HasSubstr("8192 KiB"));
  EXPECT_EQ(lock_flags_, MCL_CURRENT);
  remove("proc/self/limits");  // an unknown limit may be any
  expect(real_time("lock memory"), degraded, "memlock unlimited");
  access_.lock_memory = [](int) { return ENOMEM; };
  expect(real_time("lock memory"), failed, "memlock unlimited");
}

TEST_F(MachineChecks, ACapabilityReplacesALimit) {
  limits("8388608", "0");
  put("proc/self/status", "CapEff:\t0000000000004000");  // bit 14, CAP_IPC_LOCK
  expect(real_time("lock memory"), ok);
  put("proc/self/status", "CapEff:\t0000000000800000");  // bit 23, CAP_SYS_NICE
  highest_priority_ = 0;
  expect(real_time("lock memory"), degraded);
  expect(real_time("priority"), failed, "cpu.rt_runtime_us");  // no limit, so a control group refuses
}

TEST_F(MachineChecks, PriorityFallsToTheLimitOrIsRefused) {
  highest_priority_ = 49;
  limits("unlimited", "49");
  expect(real_time("priority"), degraded, "rtprio 98");
  EXPECT_THAT(real_time("priority").detail, HasSubstr("SCHED_FIFO 49"));
  highest_priority_ = 0;
  limits("unlimited", "0");
  expect(real_time("priority"), failed, "rtprio 98");
}

TEST_F(MachineChecks, DeepSleepCountsWhereItCannotBeForbidden) {
  remove("dev");
  expect(real_time("processor sleep"), degraded, "processor.max_cstate=1");
  put(cpus + "cpu0/cpuidle/state0/latency", "2");
  put(cpus + "cpu1/cpuidle/state0/latency", "10");
  expect(real_time("processor sleep"), ok);
  put(cpus + "cpu1/cpuidle/state1/latency", "170");
  expect(real_time("processor sleep"), degraded, "udev/rules.d");
  EXPECT_THAT(real_time("processor sleep").detail, HasSubstr("170 us"));
  put(cpus + "cpu1/cpuidle/state2/latency", "1034");
  expect(real_time("processor sleep"), failed, "udev/rules.d");
  put(cpus + "cpu1/cpuidle/state2/disable", "1");
  expect(real_time("processor sleep"), degraded, "udev/rules.d");
}

TEST_F(MachineChecks, TheWorstGovernorCounts) {
  put(cpus + "cpufreq/policy1/scaling_governor", "schedutil");
  expect(real_time("governor"), degraded, "cpupower frequency-set -g performance");
  put(cpus + "cpufreq/policy2/scaling_governor", "powersave");
  put(cpus + "cpufreq/policy2/scaling_driver", "intel_pstate");
  expect(real_time("governor"), degraded, "cpupower");
  put(cpus + "cpufreq/policy2/scaling_driver", "acpi-cpufreq");
  expect(real_time("governor"), failed, "cpupower");
  remove(cpus + "cpufreq");
  expect(real_time("governor"), ok);
  remove("sys");
  expect(real_time("governor"), failed, "mount -t sysfs");
}

TEST_F(MachineChecks, ThrottlingBelowTheKernelsDefaultIsDegraded) {
  const auto with_runtime = [&](const std::string& us) {
    put("proc/sys/kernel/sched_rt_runtime_us", us);
    return real_time("throttling");
  };
  expect(with_runtime("950000"), ok);
  expect(with_runtime("949999"), degraded, "sysctl -w kernel.sched_rt_runtime_us=950000");
  expect(with_runtime("0"), failed, "sysctl -w kernel.sched_rt_runtime_us=950000");
  remove("proc/sys");
  expect(real_time("throttling"), failed, "mount -t proc");
}

TEST_F(MachineChecks, TheCoreOfTheLoopIsIsolated) {
  int refused = 0;
  access_.take_core = [&](unsigned) { return refused; };
  const auto core = [&](unsigned n) { return find(set_up_rt_thread(access_, {.core = n}), "core"); };
  expect(core(3), ok);
  expect(core(2), degraded, "isolcpus=2 nohz_full=2 rcu_nocbs=2 irqaffinity=0,1,3");
  refused = EINVAL;
  expect(core(3), failed, "AllowedCPUs=0,1,2,3");
  EXPECT_THAT(why_no_core(4, access_), HasSubstr("no core 4: it has 0,1,2,3"));
  EXPECT_EQ(why_no_core(3, access_), "");
}

TEST_F(MachineChecks, EachRefusalOfADeadlineHasItsRemedy) {
  int refused = 0;
  access_.take_deadline = [&](Nanoseconds, Nanoseconds) { return refused; };
  const auto deadline = [&] {
    return find(set_up_rt_thread(access_, {.runtime_ns = 300'000, .period_ns = 1'000'000}), "deadline");
  };
  expect(deadline(), ok);
  EXPECT_THAT(deadline().detail, HasSubstr("SCHED_DEADLINE 300 us of each 1000 us"));
  for (const auto& [error, remedy] : {std::pair{EPERM, "setcap cap_sys_nice+ep"},
                                      {EBUSY, "sysctl -w kernel.sched_rt_runtime_us=950000"},
                                      {EINVAL, "kernel.sched_deadline_period_min_us=100"},
                                      {ENOSYS, "without --deadline"}}) {
    refused = error;
    expect(deadline(), failed, remedy);
  }
  put("proc/self/status", "CapEff:\t0000000000800000");  // bit 23, CAP_SYS_NICE: its cores are the reason
  refused = EPERM;
  expect(deadline(), failed, "taskset -c 0,1,2,3");
}

TEST_F(MachineChecks, IsolatedCoresAreListed) {
  EXPECT_THAT(cores("isolated cores").detail, testing::StartsWith("3;"));
  EXPECT_THAT(cores("isolated cores").detail, HasSubstr("--core 3"));
  put(cpus + "isolated", "");
  expect(cores("isolated cores"), degraded, "isolcpus=3 nohz_full=3 rcu_nocbs=3 irqaffinity=0,1,2");
  put(cpus + "online", "0");
  expect(cores("isolated cores"), degraded, "two or more cores");
  remove(cpus + "isolated");
  expect(cores("isolated cores"), failed, "mount -t sysfs");
}

TEST_F(MachineChecks, InterruptThreadsOfTheBusAreAboveTheLoop) {
  EXPECT_THAT(cores("interrupts").detail, HasSubstr("irq/31-can0 (priority 85, core 3)"));
  interrupt(31, "can0", "3", 50);
  expect(cores("interrupts"), degraded, "chrt -f -p 85 431");
  EXPECT_THAT(cores("interrupts").detail, HasSubstr("below the loop's 80"));
  interrupt(31, "can0", "3", 80);
  expect(cores("interrupts"), degraded, "chrt -f -p 85 431");
}

TEST_F(MachineChecks, InterruptsOfAUsbAdapterAreThoseOfItsController) {
  remove("proc/irq/31");
  const std::string controller = "sys/devices/pci0000:00/0000:00:14.0/";
  put(controller + "usb1/1-2/1-2:1.0/net/can0/mtu", "16");
  put(controller + "msi_irqs/131", "msi");
  put(controller + "irq", "16");
  std::filesystem::create_directories(path("sys/class/net/can0"));
  std::filesystem::create_directory_symlink("../../../devices/pci0000:00/0000:00:14.0/usb1/1-2/1-2:1.0",
                                            path("sys/class/net/can0/device"));
  interrupt(130, "nvme0q1", "0", 50);
  interrupt(131, "xhci_hcd", "0-2", 50);
  expect(cores("interrupts"), degraded, "chrt -f -p 85 4131");
  EXPECT_THAT(cores("interrupts").detail, HasSubstr("irq/131-xhci_hcd of can0 has priority 50"));
  interrupt(131, "xhci_hcd", "0-2", 85);
  expect(cores("interrupts"), ok);
  remove(controller + "msi_irqs");
  interrupt(16, "xhci_hcd", "0-2", 50);
  expect(cores("interrupts"), degraded, "chrt -f -p 85 416");
}

TEST_F(MachineChecks, InterruptsOfASerialAdapterAreFoundByItsLine) {
  put("dev/ttyACM0", "");
  put("sys/devices/pci0/usb1/1-1:1.0/tty/ttyACM0/dev", "166:0");
  put("sys/devices/pci0/irq", "40");
  std::filesystem::create_directories(path("sys/class/tty/ttyACM0"));
  std::filesystem::create_directory_symlink("../../../devices/pci0/usb1/1-1:1.0",
                                            path("sys/class/tty/ttyACM0/device"));
  interrupt(40, "ehci_hcd", "0-2", 50);
  const RtStep step = find(core_checks(std::vector<std::string>{"/dev/ttyACM0"}, access_), "interrupts");
  expect(step, degraded, "chrt -f -p 85 440");
}

TEST_F(MachineChecks, InterruptsOfAnSpiControllerHaveItsName) {
  put("sys/devices/soc/spi0/spi0.0/net/can0/mtu", "16");
  std::filesystem::create_directories(path("sys/class/net/can0"));
  std::filesystem::create_directory_symlink("../../../devices/soc/spi0/spi0.0",
                                            path("sys/class/net/can0/device"));
  remove("proc/irq/31");
  interrupt(50, "spi0.0", "0-2", 50);
  expect(cores("interrupts"), degraded, "chrt -f -p 85 450");
}

TEST_F(MachineChecks, InterruptsKeepAwayFromTheIsolatedCores) {
  interrupt(30, "eth0", "2-3", 50);
  expect(cores("interrupts"), degraded, "echo 0,1,2 > /proc/irq/30/smp_affinity_list");
  put("proc/irq/30/effective_affinity_list", "1");
  expect(cores("interrupts"), ok);
}

TEST_F(MachineChecks, InterruptsAreThreadsWithPreemptRtOrByTheCommandLine) {
  put("proc/version", "Linux version 6.1.0 SMP PREEMPT_DYNAMIC");
  expect(cores("interrupts"), degraded, "&threadirqs /' /etc/default/grub && update-grub");
  put("proc/cmdline", "quiet threadirqs");
  expect(cores("interrupts"), ok);
  remove("proc/irq");
  expect(cores("interrupts"), failed, "mount -t proc");
}

TEST_F(MachineChecks, ManyInterruptThreadsAreCounted) {
  for (int i = 40; i < 50; ++i) interrupt(i, "nvme0q" + std::to_string(i), "0", 50);
  EXPECT_THAT(cores("interrupts").detail, HasSubstr(" and 6 more"));
}

TEST_F(MachineChecks, TheDiskHoldsAnHourAMinuteOrLess) {
  const double rate = 1e6;
  const std::string folder = path("");
  expect(disk_check(folder, 3'600'000'000, rate), ok);
  expect(disk_check(folder, 3'599'000'000, rate), degraded, "--trace-every");
  expect(disk_check(folder, 59'000'000, rate), failed, "--trace-every");
  expect(disk_check(path("none"), free_bytes(path("none")), rate), failed, "mkdir -p");
  EXPECT_GT(free_bytes(folder).value_or(0), 0u);
}

TEST_F(MachineChecks, AFolderOfAnotherUserIsNoPlaceForRecords) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give up its rights";
  std::filesystem::permissions(path(""), std::filesystem::perms::owner_all);
  constexpr uid_t nobody = 65534;
  ASSERT_EQ(seteuid(nobody), 0);
  const RtStep step = disk_check(path(""), 3'600'000'000, 1);
  ASSERT_EQ(seteuid(0), 0);
  expect(step, failed, "chown");
}

TEST_F(MachineChecks, ASerialPortIsThereWithAShortLatencyTimer) {
  const auto check = [&] { return check_serial_port("polaris", "/dev/ttyUSB0", access_.root); };
  expect(check(), failed, "/dev/serial/by-id");
  put("dev/ttyUSB0", "");
  expect(check(), ok);
  const std::string timer = "sys/class/tty/ttyUSB0/device/latency_timer";
  put(timer, "1");
  expect(check(), ok);
  put(timer, "16");
  expect(check(), degraded, "ATTR{latency_timer}=\"1\"");
  EXPECT_THAT(check().detail, HasSubstr("16 ms"));
}

TEST_F(MachineChecks, ASerialPortOfAnotherGroupIsRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give up its rights";
  put("dev/ttyUSB0", "");
  std::filesystem::permissions(path(""), std::filesystem::perms::all);
  std::filesystem::permissions(path("dev/ttyUSB0"), std::filesystem::perms::owner_read);
  constexpr uid_t nobody = 65534;
  ASSERT_EQ(seteuid(nobody), 0);
  const RtStep step = check_serial_port("polaris", "/dev/ttyUSB0", access_.root);
  ASSERT_EQ(seteuid(0), 0);
  expect(step, failed, "adduser $USER dialout");
}

class CanLinkCheck : public MachineChecks {
 protected:
  std::vector<RtStep> check(int error = 0) const {
    return check_can_link({.name = "arm", .where = "can0", .settings = {.bit_rate = 1e6}, .frames = 8}, error,
                          link_);
  }
  void expect_one(RtResult result, const std::string& remedy = "") const {
    const std::vector<RtStep> steps = check();
    ASSERT_EQ(steps.size(), 1u);
    EXPECT_EQ(steps.front().name, "arm");
    expect(steps.front(), result, remedy);
  }

  CanLink link_{
      .up = true,
      .mtu = 16,
      .transmit_queue_length = 10,
      .controller = CanController{.bit_rate = 1'000'000, .restart_ms = 100, .state = BusState::error_active}};
};

TEST_F(CanLinkCheck, AnInterfaceThatFitsIsOk) { expect_one(ok); }

TEST_F(CanLinkCheck, AMissingInterfaceIsFailed) {
  for (const auto& [error, remedy] : {std::pair{ENODEV, "plug the adapter in"},
                                      {EMEDIUMTYPE, "ip link show type can"},
                                      {EAFNOSUPPORT, "modprobe can_raw"},
                                      {EPROTO, "ip link show can0"}}) {
    const std::vector<RtStep> steps = check(error);
    ASSERT_EQ(steps.size(), 1u);
    expect(steps.front(), failed, remedy);
  }
}

TEST_F(CanLinkCheck, AnInterfaceThatIsDownOrAtAnotherRateIsFailed) {
  link_.up = false;
  expect_one(failed, "ip link set can0 up type can bitrate 1000000");
  link_.up = true;
  link_.controller->bit_rate = 500'000;
  expect_one(failed, "ip link set can0 down && ip link set can0 up type can bitrate 1000000");
}

TEST_F(CanLinkCheck, TheStateOfTheBusCounts) {
  link_.controller->state = BusState::error_warning;
  expect_one(degraded, "termination");
  link_.controller->state = BusState::error_passive;
  expect_one(degraded, "termination");
  link_.controller->state = BusState::bus_off;
  expect_one(failed, "it restarts by itself 100 ms");
}

TEST_F(CanLinkCheck, EachTroubleOfAnInterfaceHasItsRemedy) {
  link_.controller->restart_ms = 0;
  std::ranges::copy(std::string("fq_codel"), link_.qdisc.begin());
  link_.transmit_queue_length = 7;
  const std::vector<RtStep> steps = check();
  ASSERT_EQ(steps.size(), 3u);
  expect(steps[0], degraded, "restart-ms 100");
  expect(steps[1], degraded, "root pfifo_fast");
  expect(steps[2], degraded, "ip link set can0 txqueuelen 100");
}

TEST_F(CanLinkCheck, AVirtualInterfaceHasNoController) {
  link_.controller.reset();
  expect_one(ok);
}

}  // namespace
}  // namespace godobject::test::test_machine_checks
