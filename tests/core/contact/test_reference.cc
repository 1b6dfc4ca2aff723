// The reference cases with contact, press and bounce: error and order of both integrators.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/core/contact/usual_scenes.h"
#include "tests/oracle/case/csv_table.h"
#include "tests/oracle/case/reference_case.h"
#include "tests/support/shared_data.h"

namespace godobject::test_contact_reference {
namespace {

/// A reference case: one body on the plane z = 0, its motion, and its device's if it has one.
struct ContactCase {
  nlohmann::json about;
  std::string body;
  std::vector<double> t, vz;
  std::vector<Vec3> p;
  std::vector<Quat> q;
  std::shared_ptr<const oracle::Target> device;
};

Vec3 vec3(const nlohmann::json& a) {
  return Vec3(a.at(0).get<double>(), a.at(1).get<double>(), a.at(2).get<double>());
}

ContactCase load_case(const std::filesystem::path& folder) {
  ContactCase c;
  c.about = nlohmann::json::parse(std::ifstream(folder / "case.json"));
  c.body = c.about.at("bodies").at(0).at("name");
  const oracle::CsvTable table(folder / "reference.csv");
  const auto column = [&](const char* name) { return table.column(c.body + "." + name); };
  c.t = table.column("t");
  c.vz = column("vz");
  const auto x = column("x"), y = column("y"), z = column("z");
  const auto qw = column("qw"), qx = column("qx"), qy = column("qy"), qz = column("qz");
  for (std::size_t i = 0; i < c.t.size(); ++i) {
    c.p.emplace_back(x[i], y[i], z[i]);
    c.q.emplace_back(qw[i], qx[i], qy[i], qz[i]);
  }
  if (!c.about.at("coupling").empty()) c.device = oracle::load_motion(folder / "motion.csv", c.body);
  return c;
}

/// A case run by the core.
template <class I>
class CaseRun {
 public:
  using S = OneTool<I>;

  CaseRun(const ContactCase& c, double h) : case_(c) {
    const nlohmann::json &body = c.about.at("bodies").at(0), &contact = c.about.at("contact");
    Params<S>& par = run_.par;
    par.h = h;
    par.gravity_W = vec3(c.about.at("gravity"));
    par.bodies[0].body = rigid_body(body.at("mass"), vec3(body.at("inertia")).asDiagonal());
    par.bodies[0].device.rise = 0;
    if (contact.contains("spheres_in_body"))
      for (const nlohmann::json& p : contact.at("spheres_in_body"))
        add_sphere(par, 0, vec3(p), contact.at("sphere_radius"));
    else add_sphere(par, 0, Vec3::Zero(), contact.at("sphere_radius"));
    add_plane(par);
    set_law(par, {.k = contact.at("stiffness"), .c = contact.at("damping")});
    place(run_.x, 0,
          {.X_WB = {.p = vec3(body.at("position")), .q = c.q[0]},
           .V_WB = {.w = vec3(body.at("angular_velocity")), .v = vec3(body.at("velocity"))}});
    run_.device().engaged = c.device != nullptr;
    if (c.device == nullptr) return;
    const nlohmann::json& spring = c.about.at("coupling").at(c.body);
    par.bodies[0].coupling = {.k = spring.at("stiffness"),
                              .g = spring.at("damping"),
                              .k_r = spring.at("rotational_stiffness"),
                              .g_r = spring.at("rotational_damping")};
    engage_at(run_.x, 0, target(0));
  }

  void step() {
    if (case_.device != nullptr) {
      const Target to = target(static_cast<double>(run_.x.tick + 1) * run_.par.h);
      run_.device().target = to;
    }
    run_.step();
    EXPECT_FALSE(any(run_.out.fault));
  }
  double time() const { return static_cast<double>(run_.x.tick) * run_.par.h; }
  const RigidBodyState& body() const { return run_.x.bodies[0].x; }

 private:
  Target target(double t) const {
    const oracle::RigidState s = case_.device->at(t);
    return {.X_WD = {s.p, Quat(s.q.w(), s.q.x(), s.q.y(), s.q.z()).normalized()}, .V_WD = {s.w, s.v}};
  }

  const ContactCase& case_;
  Running<S> run_;
};

/// Largest distance from the reference (m) at those of its times that are multiples of the step.
template <class I>
double worst_error(const ContactCase& c, double h) {
  CaseRun<I> run(c, h);
  double error = 0;
  for (std::size_t row = 0; row < c.t.size(); ++row) {
    while (run.time() < c.t[row] - 0.5 * h) run.step();
    if (std::abs(run.time() - c.t[row]) < 1e-9)
      error = std::max(error, (run.body().X_WB.p - c.p[row]).norm());
  }
  return error;
}

template <class I>
std::vector<double> errors(const char* name, const ContactCase& c, double h, int halvings) {
  std::vector<double> all;
  for (int i = 0; i <= halvings; ++i, h /= 2) {
    all.push_back(worst_error<I>(c, h));
    std::printf("%-7s %-14s %8.5f ms: %.2e m\n", name, I::name, 1e3 * h, all.back());
  }
  return all;
}
double mean_order(const std::vector<double>& errors) {
  return std::log2(errors.front() / errors.back()) / static_cast<double>(errors.size() - 1);
}

class ContactReference : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = test::shared_file("reference");
    if (folder_.empty()) GTEST_SKIP() << "no ../shared/reference and GODOBJECT_SHARED not set";
  }
  ContactCase load(const char* name) const { return load_case(folder_ / name); }

 private:
  std::filesystem::path folder_;
};

TEST_F(ContactReference, PressWithImplicitEuler) {
  const auto e = errors<ImplicitEuler>("press", load("press"), 1e-3, 3);
  EXPECT_LT(e[0], 1e-4);
  EXPECT_GT(mean_order(e), 0.8);
}

TEST_F(ContactReference, PressWithTrBdf2) {
  const auto e = errors<TrBdf2>("press", load("press"), 2e-3, 3);
  EXPECT_LT(e[1], 1e-5);
  EXPECT_GT(mean_order(e), 1.7);
}

/// Motion of a ball between two impacts.
struct Flight {
  double apex = 0;     // above where it touches, m
  double landing = 0;  // s
};

constexpr double gravity = 9.81, radius = 0.01;

/// The flights of a ball through samples, each followed by one in contact.
class Flights {
 public:
  void add(double t, double z, double vz) {
    const double height = z - radius;
    const double apex = height + vz * vz / (2 * gravity);
    if (height > 0) current_ = {.apex = apex, .landing = t + (vz + std::sqrt(2 * gravity * apex)) / gravity};
    if (height <= 0 && current_.landing > 0) {
      all_.push_back(current_);
      current_ = {};
    }
  }
  const std::vector<Flight>& all() const { return all_; }

 private:
  std::vector<Flight> all_;
  Flight current_;
};

std::vector<Flight> reference_flights(const ContactCase& c) {
  Flights flights;
  for (std::size_t i = 0; i < c.t.size(); ++i) flights.add(c.t[i], c.p[i].z(), c.vz[i]);
  return flights.all();
}

template <class I>
std::vector<Flight> flights(const ContactCase& c, double h) {
  CaseRun<I> run(c, h);
  Flights flights;
  while (run.time() < c.t.back()) {
    run.step();
    flights.add(run.time(), run.body().X_WB.p.z(), run.body().v_W.z());
  }
  return flights.all();
}

TEST_F(ContactReference, BounceWithImplicitEuler) {
  const auto e = errors<ImplicitEuler>("bounce", load("bounce"), 1.25e-4, 5);
  EXPECT_GT(mean_order(e), 0.7);
  EXPECT_LT(e.back(), 0.2 * e.front());
  EXPECT_GT(std::log2(e[4] / e[5]), 0.85);
}

TEST_F(ContactReference, BounceWithTrBdf2) {
  const auto e = errors<TrBdf2>("bounce", load("bounce"), 5e-4, 5);
  EXPECT_GT(mean_order(e), 1.7);
}

/// Heights and times of the bounces, within 2 % at 0.25 ms.
TEST_F(ContactReference, EveryBounceOfTrBdf2) {
  const ContactCase c = load("bounce");
  const auto expected = reference_flights(c), found = flights<TrBdf2>(c, 2.5e-4);
  ASSERT_GE(expected.size(), 5u);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    std::printf("bounce %zu: apex %.6f m (reference %.6f), landing %.6f s (%.6f)\n", i, found[i].apex,
                expected[i].apex, found[i].landing, expected[i].landing);
    EXPECT_NEAR(found[i].apex, expected[i].apex, 0.02 * expected[i].apex);
    EXPECT_NEAR(found[i].landing, expected[i].landing, 0.02 * expected[i].landing);
  }
}

/// Implicit Euler damps the contact's spring: at 1 ms a ball comes back with less than the law gives it.
TEST_F(ContactReference, RestitutionThatImplicitEulerLoses) {
  const ContactCase c = load("bounce");
  const auto expected = reference_flights(c);
  const auto restitution = [](const std::vector<Flight>& f) {
    return std::sqrt(f.at(1).apex / f.at(0).apex);
  };
  const double law = restitution(expected), first = restitution(flights<ImplicitEuler>(c, 1e-3)),
               second = restitution(flights<TrBdf2>(c, 1e-3));
  std::printf("restitution at 1 ms: reference %.4f, implicit Euler %.4f, TR-BDF2 %.4f\n", law, first, second);
  RecordProperty("restitution_of_the_law", std::to_string(law));
  RecordProperty("restitution_of_implicit_euler_at_1_ms", std::to_string(first));
  EXPECT_LT(first, law);
  EXPECT_GT(first, 0.6 * law);
  EXPECT_NEAR(second, law, 0.02 * law);
}

}  // namespace
}  // namespace godobject::test_contact_reference
