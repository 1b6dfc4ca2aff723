// The trace: its columns, and numbers that read back bit for bit.
#include "platform/trace/trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "platform/scene/text/csv.h"

namespace godobject::test_trace {
namespace {

SceneConfig coupled_and_free() {
  SceneConfig scene;
  scene.bodies.resize(2);
  scene.bodies[0].name = "tool";
  scene.bodies[0].coupling = SpringParams{};
  scene.bodies[1].name = "brick";
  return scene;
}

TEST(Trace, ColumnsAreThoseOfTheReferenceThenWrenchesTargetPenetrationBits) {
  const std::vector<std::string> columns = trace_columns(coupled_and_free());
  ASSERT_EQ(columns.size(), 1u + 2 * 13 + 12 + 7 + 6 + 1);
  EXPECT_EQ(columns[0], "t");
  EXPECT_EQ(columns[4], "tool.qw");
  EXPECT_EQ(columns[14], "brick.x");
  EXPECT_EQ(columns[27], "tool.coupling.fx");
  EXPECT_EQ(columns[38], "tool.feedback.tz");
  EXPECT_EQ(columns[39], "tool.target.x");
  EXPECT_EQ(columns[45], "tool.target.qz");
  EXPECT_EQ(columns[46], "penetration");
  EXPECT_EQ(columns[47], "energy");
  EXPECT_EQ(columns[48], "energy_balance");
  EXPECT_EQ(columns[49], "fault");
  EXPECT_EQ(columns[50], "limited");
  EXPECT_EQ(columns[51], "rig_fault");
  EXPECT_EQ(columns[52], "tool.engaged");
}

TEST(Trace, ScenesWithContactsHaveTheirColumns) {
  SceneConfig scene = coupled_and_free();
  scene.bodies[1].spheres.push_back({.radius = 0.01});
  EXPECT_EQ(trace_columns(scene), trace_columns(coupled_and_free())) << "there is nothing to touch";
  scene.obstacles.resize(1);
  const std::vector<std::string> columns = trace_columns(scene);
  EXPECT_THAT(std::vector(columns.begin() + 46, columns.end()),
              testing::ElementsAre("brick.contact.fx", "brick.contact.fy", "brick.contact.fz",
                                   "brick.contact.tx", "brick.contact.ty", "brick.contact.tz", "penetration",
                                   "contacts", "contact_residual", "energy", "energy_balance", "fault",
                                   "limited", "rig_fault", "tool.engaged"));

  scene.nets.resize(1);
  EXPECT_THAT(trace_columns(scene), testing::IsSupersetOf({"net_contacts", "net_penetration", "net_stretch",
                                                           "net_iterations", "net_residual"}));
  EXPECT_EQ(trace_columns(scene).size(), columns.size() + 5);
  scene.nets.clear();

  const std::string path = testing::TempDir() + "/godobject_contact_trace.csv";
  TraceWriter writer(path, scene);
  std::array<TraceBody, 2> bodies{};
  bodies[0].contact.f = Vec3(9, 9, 9);  // of a body without contacts
  bodies[1].contact.f = Vec3(1, 2, 3);
  writer.row(0, bodies, std::array<TraceDriven, 1>{}, {},
             {.contacts = {.num_contacts = 5, .deepest = 1e-5, .residual = 1e-7}}, {});
  ASSERT_TRUE(writer.close());
  const CsvResult result = read_csv(path);
  ASSERT_TRUE(result.table.has_value()) << result.errors.front();
  const auto at = [&](const char* column) { return result.table->at(0, result.table->find(column).value()); };
  EXPECT_EQ(at("brick.contact.fz"), 3);
  EXPECT_EQ(at("penetration"), 1e-5);
  EXPECT_EQ(at("contacts"), 5);
  EXPECT_EQ(at("contact_residual"), 1e-7);
}

TEST(Trace, ADeviceThatGripsBodiesHasItsColumns) {
  SceneConfig scene = coupled_and_free();
  scene.device = DeviceConfig{.name = "hand", .holds = "tool", .limits = {}, .rig = {}, .plant = {}};
  ASSERT_TRUE(grips_bodies(scene));
  const std::vector<std::string> columns = trace_columns(scene);
  EXPECT_THAT(std::vector(columns.begin() + 46, columns.begin() + 54),
              testing::ElementsAre("held", "hand.fx", "hand.fy", "hand.fz", "hand.tx", "hand.ty", "hand.tz",
                                   "penetration"));
  const std::string path = testing::TempDir() + "/godobject_grip_trace.csv";
  TraceWriter writer(path, scene);
  const std::array<TraceBody, 2> bodies{};
  const std::array<TraceDriven, 1> driven{};
  TraceScene held{.held = 0};
  held.hand.tau = Vec3(1, 2, 3);
  writer.row(0, bodies, driven, {}, held, {});
  writer.row(1e-3, bodies, driven, {}, {}, {});
  ASSERT_TRUE(writer.close());
  const CsvResult result = read_csv(path);
  ASSERT_TRUE(result.table.has_value()) << result.errors.front();
  const std::size_t column = result.table->find("held").value();
  EXPECT_EQ(result.table->at(0, column), 0);
  EXPECT_EQ(result.table->at(1, column), -1) << "nothing";
  EXPECT_EQ(result.table->at(0, result.table->find("hand.tz").value()), 3);
}

TEST(Trace, NumbersReadBackBitForBit) {
  const std::string path = testing::TempDir() + "/godobject_trace.csv";
  constexpr int num_rows = 1000;  // more than one buffer
  TraceWriter writer(path, coupled_and_free());
  for (int i = 0; i < num_rows; ++i) {
    std::array<TraceBody, 2> bodies{};
    bodies[0].X_WB.p = Vec3(1.0 / 3, -0.0, 1e-310);
    bodies[0].V_WB.w = Vec3(0.1 * i, 0, 0);
    bodies[1].V_WB.v = Vec3(0, 0, 1e300);
    std::array<TraceDriven, 1> driven{};
    driven[0].coupling.f = Vec3(1, 2, 3);
    driven[0].feedback.tau = Vec3(4, 5, 6);
    driven[0].X_WD.p = Vec3(7, 8, 9);
    writer.row(1e-3 * i, bodies, driven, {}, {.contacts = {.deepest = 1e-4}},
               {.fault = 0x80000001u, .limited = 16, .rig_fault = 32});
  }
  ASSERT_TRUE(writer.close());

  const CsvResult result = read_csv(path);
  ASSERT_TRUE(result.table.has_value()) << result.errors.front();
  const CsvTable& table = *result.table;
  ASSERT_EQ(table.num_rows(), static_cast<std::size_t>(num_rows));
  EXPECT_EQ(table.columns(), trace_columns(coupled_and_free()));
  const auto at = [&](std::size_t row, const char* column) {
    return table.at(row, table.find(column).value());
  };
  for (const std::size_t i : {std::size_t{0}, std::size_t{999}}) {
    EXPECT_EQ(at(i, "t"), 1e-3 * static_cast<double>(i));
    EXPECT_EQ(at(i, "tool.x"), 1.0 / 3);
    EXPECT_TRUE(std::signbit(at(i, "tool.y")));
    EXPECT_EQ(at(i, "tool.z"), 1e-310);
    EXPECT_EQ(at(i, "tool.qw"), 1);
    EXPECT_EQ(at(i, "tool.wx"), 0.1 * static_cast<double>(i));
    EXPECT_EQ(at(i, "brick.vz"), 1e300);
    EXPECT_EQ(at(i, "tool.coupling.fy"), 2);
    EXPECT_EQ(at(i, "tool.feedback.tz"), 6);
    EXPECT_EQ(at(i, "tool.target.z"), 9);
    EXPECT_EQ(at(i, "penetration"), 1e-4);
    EXPECT_EQ(at(i, "fault"), 2147483649.0);
    EXPECT_EQ(at(i, "limited"), 16);
    EXPECT_EQ(at(i, "rig_fault"), 32);
  }
}

TEST(Trace, JointsHaveTheirWrenchesBehindTheTargets) {
  SceneConfig scene = coupled_and_free();
  scene.joints.resize(1);
  scene.joints[0].name = "pivot";
  scene.joints[0].child = "tool";
  const std::vector<std::string> columns = trace_columns(scene);
  ASSERT_EQ(columns.size(), 1u + 2 * 13 + 12 + 7 + 6 + 6 + 2);
  EXPECT_EQ(columns[58], "pivot.q");
  EXPECT_EQ(columns[59], "tool.engaged");
  EXPECT_EQ(columns[46], "pivot.fx");
  EXPECT_EQ(columns[49], "pivot.tx");
  const std::string path = testing::TempDir() + "/godobject_trace_joints.csv";
  TraceWriter writer(path, scene);
  const std::array<Wrench, 1> joints{Wrench{.tau = Vec3(4, 5, 6), .f = Vec3(1, 2, 3)}};
  writer.row(0, std::array<TraceBody, 2>{}, std::array<TraceDriven, 1>{}, joints, {}, {});
  ASSERT_TRUE(writer.close());
  const CsvTable table = read_csv(path).table.value();
  EXPECT_EQ(table.at(0, 47), 2);
  EXPECT_EQ(table.at(0, 51), 6);
}

TEST(Trace, DevicesHaveTheirColumnsBehindTheBits) {
  SceneConfig scene = coupled_and_free();
  scene.device.emplace();
  scene.device->kind = DeviceKind::relative;
  scene.device->rig.emplace();
  scene.device->rig->tree.joints.resize(1);
  scene.device->rig->tree.joints[0].name = "elbow";
  scene.device->rig->drives.resize(1);
  scene.device->rig->drives[0].joint = "elbow";
  const std::vector<std::string> columns = trace_columns(scene);
  EXPECT_THAT(std::vector(columns.begin() + 52, columns.end()),
              testing::ElementsAre("t_bus", "tool.engaged", "tool.clutch", "tool.device.x", "tool.device.y",
                                   "tool.device.z", "tool.device.qw", "tool.device.qx", "tool.device.qy",
                                   "tool.device.qz", "device.elbow.q", "drive.elbow.torque",
                                   "drive.elbow.generated"));
  const std::string path = testing::TempDir() + "/godobject_trace_devices.csv";
  TraceWriter writer(path, scene);
  const std::array targets{TargetSample{.X_WD = {.p = Vec3(1, 2, 3)}, .F_WB = {}, .engaged = false}};
  const std::array q{0.25}, torque{-0.5}, energy{2e-6};
  writer.row(
      0, std::array<TraceBody, 2>{}, std::array<TraceDriven, 1>{}, {}, {}, {},
      {.t_bus = 1.75e9, .targets = targets, .device_q = q, .drive_torque = torque, .drive_energy = energy});
  ASSERT_TRUE(writer.close());
  const CsvTable table = read_csv(path).table.value();
  const std::array values{1.75e9, 0.0, 1.0, 1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0, 0.25, -0.5, 2e-6};
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_EQ(table.at(0, 52 + i), values[i]) << columns[52 + i];
  scene.device->kind = DeviceKind::admittance;
  EXPECT_THAT(trace_columns(scene), testing::Contains("tool.hand.tz"));
}

TEST(Trace, UnwritableFileIsReported) {
  TraceWriter writer(CsvRows("/no/such/directory/trace.csv"), coupled_and_free());
  EXPECT_FALSE(writer.close());
}

}  // namespace
}  // namespace godobject::test_trace
