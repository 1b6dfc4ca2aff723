// A step neither allocates, locks, sleeps, reads, writes nor reads a clock, and touches no new page.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <vector>

#include "tests/core/contact/bodies/bricks.h"
#include "tests/core/contact/contact_scene.h"
#include "tests/core/joint/grasper_tool.h"
#include "tests/core/one_body.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_no_allocation {
namespace {

template <class K>
class NoAllocation : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  }
};

using Scenes = ::testing::Types<OneBody<ImplicitEuler, None, None>, OneBody<TrBdf2, None, None>,
                                OneBody<ImplicitEuler, PoseDevice, DampedSpring, LimitedFeedback>,
                                OneBody<TrBdf2, PoseDevice, DampedSpring, LimitedFeedback>,
                                OneBody<TrBdf2, HoldingDevice, DampedSpring, LimitedFeedback>,
                                OneBody<TrBdf2, RelativeDevice, DampedSpring, LimitedFeedback>,
                                OneBody<TrBdf2, AdmittanceDevice, DampedSpring, LimitedFeedback>>;
TYPED_TEST_SUITE(NoAllocation, Scenes);

void disturb(Empty&, int) {}
void disturb(AdmittanceDevice::Input& in, int n) { in.F_WB.f.x() = n % 17; }
void disturb(RelativeDevice::Input& in, int n) { in.dp_W.x() = n % 1000 == 0 ? std::nan("") : 1e-4; }
void disturb(PoseDevice::Input& in, int n) {
  in.target.X_WD.p.x() = n % 1000 == 0 ? std::nan("") : 1e-3 * (n % 100);
  in.valid = n % 7 != 0;
  in.engaged = n % 500 > 20;
}

/// Good samples, faults, lost samples, engaging and releasing.
TYPED_TEST(NoAllocation, InAnyStep) {
  Running<TypeParam> run;
  AllocationGuard guard;
  for (int n = 0; n < 5000; ++n) {
    disturb(run.device(), n);
    run.step();
  }
  guard.disarm();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_GT(run.x.tick, 4000u);
}

TYPED_TEST(NoAllocation, NorAPageFaultAfterTheFirstSteps) {
  Running<TypeParam> run;
  run.step(100);
  rusage before, after;
  getrusage(RUSAGE_THREAD, &before);
  getrusage(RUSAGE_THREAD, &before);
  run.step(100000);
  getrusage(RUSAGE_THREAD, &after);
  EXPECT_EQ(after.ru_minflt - before.ru_minflt, 0);
  EXPECT_EQ(after.ru_majflt - before.ru_majflt, 0);
}

/// A tool of four bodies with stops, and prescribed jaws.
TEST(NoAllocationOfJoints, InAnyStep) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  GrasperTool<TrBdf2, TreeJoints<JointStops, PrescribedJoints>> tool;
  tool.par.bodies[tube].joint.stop.stops[1] = {.upper = 0.05, .k = 1e4, .g = 10, .width = 1e-3};
  for (const std::size_t i : {left_jaw, right_jaw}) tool.par.bodies[i].joint.motion.prescribed = true;
  AllocationGuard guard;
  for (int n = 0; n < 5000; ++n) {
    for (auto& device : tool.in.devices) disturb(device, n);
    tool.in.joints[left_jaw].q[0] = n % 1000 == 1 ? std::nan("") : tool.motion.left.at(tool.time());
    tool.follow();
  }
  guard.disarm();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_GT(tool.x.tick, 4000u);
}

/// Two bodies with more spheres on obstacles than the list of contacts has room for.
TEST(NoAllocationOfContacts, InAnyStep) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  Running<Touching<TrBdf2, 2, 8, PoseDevice, 2, 6>> run;
  run.par.num_bodies = 2;
  for (int k = 0; k < 8; ++k)
    add_sphere(run.par, k < 4 ? 0 : 1, Vec3(k % 2 == 0 ? 0.02 : -0.02, k % 4 < 2 ? 0.02 : -0.02, 0), 0.01);
  add_plane(run.par);
  add_box(run.par, {.p = Vec3(0.05, 0, 0), .q = Quat::Identity()}, Vec3(0.02, 0.02, 0.02));
  set_law(run.par, {.k = 1e4, .c = 10, .mu = 0.3, .k_t = 1e4, .c_t = 10});
  for (auto& body : run.par.bodies) body.coupling = {.k = 1e4, .g = 100, .k_r = 100, .g_r = 10};
  std::size_t num_contacts = 0, num_full = 0;
  AllocationGuard guard;
  for (int n = 0; n < 5000; ++n) {
    for (auto& device : run.in.devices) disturb(device, n);
    run.step();
    num_contacts += run.out.contacts.num_contacts;
    num_full += has(run.out.fault, Fault::contacts_full) ? 1 : 0;
  }
  guard.disarm();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_GT(run.x.tick, 4000u);
  EXPECT_GT(num_contacts, 4000u);
  EXPECT_GT(num_full, 100u);
}

/// Bricks in a heap that a driven one is shaken in, with more contacts than there is room for.
TEST(NoAllocationOfTouchingBodies, InAnyStep) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  const auto pile = std::make_unique<Pile<TouchingBodies<TrBdf2, 6, PoseDevice, 30>>>();
  pile->add_floor();
  for (int i = 0; i < 6; ++i)
    pile->add_brick({.X_WB = at(Vec3(0.004 * i, 0, 0.005 + 0.0101 * i)), .V_WB = {}});
  pile->hold_at(0, {}, spring(pile->par.bodies[0].body, 300, 0.05));
  std::size_t num_contacts = 0, num_full = 0;
  AllocationGuard guard;
  for (int n = 0; n < 5000; ++n) {
    disturb(pile->in.devices[0], n);
    pile->step();
    num_contacts += pile->out.contacts.num_contacts;
    num_full += has(pile->out.fault, Fault::contacts_full) ? 1 : 0;
  }
  guard.disarm();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_GT(pile->x.tick, 4000u);
  EXPECT_GT(num_contacts, 4000u);
  EXPECT_GT(num_full, 10u);
}

/// A guard that notices nothing would prove nothing.
TEST(AllocationGuardItself, NoticesEachWatchedCall) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  static void* volatile kept;  // keeps the compiler from leaving allocations out
  const auto keep = [](void* p) { kept = p; };
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  timespec t{};
  char byte = 0;
  const std::vector<std::pair<const char*, std::function<void()>>> deeds{
      {"malloc",
       [&] {
         keep(std::malloc(8));
         std::free(kept);
       }},
      {"malloc",
       [&] {
         int* p = new int(1);
         keep(p);
         delete p;
       }},
      {"malloc",
       [&] {
         std::vector<double> v(10);
         keep(v.data());
       }},
      {"calloc",
       [&] {
         keep(std::calloc(2, 8));
         std::free(kept);
       }},
      {"realloc",
       [&] {
         keep(std::malloc(8));
         keep(std::realloc(kept, 16));
         std::free(kept);
       }},
      {"free",
       [&] {
         keep(nullptr);
         std::free(kept);
       }},
      {"aligned_alloc",
       [&] {
         keep(std::aligned_alloc(64, 64));
         std::free(kept);
       }},
      {"posix_memalign",
       [&] {
         void* p = nullptr;
         if (posix_memalign(&p, 64, 64) == 0) std::free(p);
       }},
      {"pthread_mutex_lock",
       [&] {
         pthread_mutex_lock(&mutex);
         pthread_mutex_unlock(&mutex);
       }},
      {"clock_gettime", [&] { clock_gettime(CLOCK_MONOTONIC, &t); }},
      {"nanosleep",
       [] {
         timespec nothing{};
         nanosleep(&nothing, nullptr);
       }},
      {"clock_nanosleep",
       [] {
         timespec nothing{};
         clock_nanosleep(CLOCK_MONOTONIC, 0, &nothing, nullptr);
       }},
      {"read", [&] { byte = static_cast<char>(read(-1, &byte, 1)); }},
      {"write", [&] { byte = static_cast<char>(write(-1, &byte, 1)); }}};
  for (const auto& [name, deed] : deeds) {
    AllocationGuard guard;
    deed();
    guard.disarm();
    EXPECT_GT(guard.calls(), 0) << name;
    EXPECT_NE(guard.report().find(name), std::string::npos) << name;
  }
}

TEST(AllocationGuardItself, CountsNothingWhenDisarmed) {
  AllocationGuard guard;
  guard.disarm();
  const auto p = std::make_unique<int>(1);
  EXPECT_EQ(guard.calls(), 0) << *p;
}

}  // namespace
}  // namespace godobject::test_no_allocation
