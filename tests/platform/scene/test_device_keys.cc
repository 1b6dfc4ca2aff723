// The tree of the device in scene files: parents, handles, homing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/joint/kinematic_tree.h"
#include "hal/rig/validate.h"
#include "platform/scene/toml.h"

namespace godobject::test_device_keys {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string body(const std::string& name, bool coupled = true) {
  return "[[body]]\nname = \"" + name + "\"\nmass = 0.1\ninertia = [3e-4, 3e-4, 2e-5]\n" +
         (coupled ? "[body.coupling]\nstiffness = 1000\nrotational_stiffness = 1\n" : "");
}
std::string joint(const std::string& name, const std::string& more = "") {
  return "[[device.joint]]\nname = \"" + name + "\"\n" + more;
}
std::string handle(const std::string& of_body, const std::string& on_joint, const std::string& more = "") {
  return "[[device.handle]]\nbody = \"" + of_body + "\"\njoint = \"" + on_joint + "\"\n" + more;
}

/// Returns a scene with these device tables, and an encoder on each of its joints a, b and c.
std::string scene(const std::string& device, const std::string& chain = "") {
  std::string text = "[scene]\nname = \"test\"\n" + body("ground", false) + body("shaft") + body("jaw") +
                     "[[bus]]\nname = \"can0\"\n[device]\nname = \"d\"\n" + chain + device;
  int node_id = 1;
  for (const char* name : {"a", "b", "c"}) {
    text += "[[device.encoder]]\nbus = \"can0\"\ncounts_per_turn = 4096\njoint = \"" + std::string(name) +
            "\"\nnode_id = " + std::to_string(node_id++) + "\n";
  }
  return text;
}

LoadResult load(const std::string& text) { return parse_scene(text, "a.toml"); }

const std::string serial = joint("a") + joint("b") + joint("c");

TEST(DeviceKeys, JointsSitOnTheOneBeforeUnlessTheyNameAnother) {
  const LoadResult result =
      load(scene(joint("a") + joint("b", "parent = \"base\"\n") + joint("c", "parent = \"a\"\n")));
  ASSERT_THAT(result.errors, IsEmpty());
  const std::vector<DeviceJoint>& joints = result.scene->device->rig->tree.joints;
  EXPECT_EQ(parent_link(joints, 0), 0u);
  EXPECT_EQ(parent_link(joints, 1), 0u);
  EXPECT_EQ(parent_link(joints, 2), 1u);
  EXPECT_EQ(parent_link(load(scene(serial)).scene->device->rig->tree.joints, 2), 2u);
  EXPECT_THAT(validate(*result.scene->device->rig, result.scene->step), IsEmpty());
}

TEST(DeviceKeys, ParentsMustBeEarlierJoints) {
  EXPECT_THAT(load(scene(joint("a") + joint("b", "parent = \"c\"\n") + joint("c"))).errors,
              ElementsAre(AllOf(HasSubstr("a.toml:29:10:"),
                                HasSubstr("'parent' is \"c\"; admissible is \"base\", \"a\""))));
  EXPECT_THAT(load(scene(joint("a") + joint("b", "parent = \"b\"\n") + joint("c"))).errors,
              ElementsAre(HasSubstr("'parent' is \"b\"")));
  EXPECT_THAT(load(scene(joint("base") + serial)).errors,
              Contains(HasSubstr("'name' is the name of the base")));
}

TEST(DeviceKeys, WithoutHandlesThereIsOneOnTheLastJointForTheFirstCoupledBody) {
  const std::string chain = "[device.chain]\nhandle_position = [0.1, 0.2, 0.3]\n";
  const LoadResult result = load(scene(serial, chain));
  ASSERT_THAT(result.errors, IsEmpty());
  const std::vector<HandleParams>& handles = result.scene->device->rig->tree.handles;
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_EQ(handles[0].body, "shaft");
  EXPECT_EQ(handles[0].joint, "c");
  EXPECT_EQ(handles[0].X_LH.p, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(load(scene(serial)).scene->device->rig->tree.handles[0].X_LH.p, Vec3::Zero());
}

TEST(DeviceKeys, HandlesAreReadInTheirOrder) {
  const LoadResult result =
      load(scene(serial + handle("jaw", "c", "position = [0, 0, 0.5]\norientation_wxyz = [0, 1, 0, 0]\n") +
                 handle("shaft", "a")));
  ASSERT_THAT(result.errors, IsEmpty());
  const std::vector<HandleParams>& handles = result.scene->device->rig->tree.handles;
  ASSERT_EQ(handles.size(), 2u);
  EXPECT_EQ(handles[0].body, "jaw");
  EXPECT_EQ(handles[0].X_LH.p.z(), 0.5);
  EXPECT_EQ(handles[0].X_LH.q.x(), 1);
  EXPECT_EQ(handles[1].joint, "a");
}

TEST(DeviceKeys, WrongHandlesAreRefusedWithTheirPlace) {
  const auto errors = [](const std::string& tables, const std::string& chain = "") {
    return load(scene(serial + tables, chain)).errors;
  };
  EXPECT_THAT(
      errors(handle("jaws", "c")),
      ElementsAre(AllOf(HasSubstr("a.toml:32:8: 'body' is \"jaws\"; admissible is \"shaft\", \"jaw\""),
                        HasSubstr("nearest is \"jaw\""))));
  EXPECT_THAT(errors(handle("ground", "c")), ElementsAre(HasSubstr("'body' is \"ground\"")));
  EXPECT_THAT(errors(handle("jaw", "base")), ElementsAre(HasSubstr("a.toml:33:9: 'joint' is \"base\"")));
  EXPECT_THAT(errors(handle("jaw", "c") + handle("jaw", "b")),
              ElementsAre(HasSubstr("a.toml:35:8: 'body' has an earlier handle")));
  EXPECT_THAT(errors("[[device.handle]]\njoint = \"c\"\n"), Contains(HasSubstr("required key 'body'")));
  EXPECT_THAT(errors(handle("jaw", "c"), "[device.chain]\nhandle_position = [0, 0, 0]\n"),
              ElementsAre(HasSubstr("'handle' and handle_position in [device.chain] both place handles")));
  EXPECT_THAT(errors(handle("jaw", "c"), "[device.chain]\nhandle_orientation_wxyz = [1, 0, 0, 0]\n"),
              ElementsAre(HasSubstr("'handle' and handle_position in [device.chain] both place handles")));
  EXPECT_THAT(errors(handle("jaw", "c"), "[device.chain]\nbase_position = [0, 0, 1]\n"), IsEmpty());
}

TEST(DeviceKeys, NumbersOfJointsAndHandlesAreBounded) {
  std::string joints = serial, handles, bodies = "[scene]\nname = \"test\"\n";
  for (char name = 'd'; name <= 'q'; ++name) joints += joint(std::string(1, name));
  EXPECT_THAT(load(scene(joints)).errors,
              Contains(HasSubstr("must be 1 to 16 tables [[device.joint]], not 17")));
  for (char name = 'd'; name <= 'l'; ++name) {
    bodies += body(std::string(1, name));
    handles += handle(std::string(1, name), "c");
  }
  const std::string rest = scene(serial + handles);
  EXPECT_THAT(load(bodies + rest.substr(rest.find("[[body]]"))).errors,
              ElementsAre(HasSubstr("must be at most 8 tables [[device.handle]], not 9")));
}

TEST(DeviceKeys, HomeIsRead) {
  const std::string text = scene(serial);
  const LoadResult result =
      load(text +
           "home = -0.25\n[[device.drive]]\njoint = \"a\"\nbus = \"can0\"\nnode_id = 9\n"
           "counts_per_turn = 4096\nhome = 0.5\n");
  ASSERT_THAT(result.errors, IsEmpty());
  EXPECT_EQ(result.scene->device->rig->encoders[2].calibration.home, -0.25);
  EXPECT_EQ(result.scene->device->rig->drives[0].calibration.home, 0.5);
  EXPECT_EQ(result.scene->device->rig->encoders[0].calibration.home, 0);
}

TEST(DeviceKeys, ATreeWithHandlesLoadsBackAsItself) {
  const std::string tree = joint("a") + joint("b", "parent = \"base\"\n") + joint("c", "parent = \"a\"\n");
  for (const std::string& text :
       {scene(serial, "[device.chain]\nhandle_position = [0.1, 0.2, 0.3]\n"),
        scene(tree + handle("jaw", "c", "position = [0, 0, 0.5]\n") + handle("shaft", "b")) +
            "home = 0.1\n"}) {
    const LoadResult first = load(text);
    ASSERT_THAT(first.errors, IsEmpty());
    const std::string printed = effective_config_toml(*first.scene);
    const LoadResult back = load(printed);
    ASSERT_THAT(back.errors, IsEmpty()) << printed;
    EXPECT_EQ(effective_config_toml(*back.scene), printed);
    const KinematicTreeParams &a = first.scene->device->rig->tree, &b = back.scene->device->rig->tree;
    ASSERT_EQ(a.handles.size(), b.handles.size());
    for (std::size_t i = 0; i < a.joints.size(); ++i) EXPECT_EQ(a.joints[i].parent, b.joints[i].parent);
    for (std::size_t i = 0; i < a.handles.size(); ++i) {
      EXPECT_EQ(a.handles[i].body, b.handles[i].body);
      EXPECT_EQ(a.handles[i].joint, b.handles[i].joint);
      EXPECT_EQ(a.handles[i].X_LH.p, b.handles[i].X_LH.p);
    }
  }
}

const std::string moteus_bus = "[[bus]]\nname = \"can1\"\ndata_bit_rate = 5e6\n";
const std::string classic_bus = "[[bus]]\nname = \"can1\"\n";

std::string with_bus(const std::string& bus, const std::string& tables) {
  std::string text = scene(serial);
  text.insert(text.find("[device]"), bus);
  return text + tables;
}
std::string drive(const std::string& of_joint, const std::string& more) {
  return "[[device.drive]]\njoint = \"" + of_joint + "\"\ncounts_per_turn = 1e6\n" + more;
}
std::string button(int node_id, int bit, const std::string& more = "") {
  return "[[device.button]]\nbus = \"can0\"\nnode_id = " + std::to_string(node_id) +
         "\nbit = " + std::to_string(bit) + "\n" + more;
}

TEST(DeviceKeys, TorqueLimitIsOneThatCommandsEncode) {
  const auto errors = [](const std::string& more) {
    return load(with_bus(classic_bus,
                         drive("a", "bus = \"can1\"\nnode_id = 9\ntorque_rated_Nm = 0.1\n" + more)))
        .errors;
  };
  EXPECT_THAT(errors("torque_max_Nm = 3.2767\n"), IsEmpty());
  EXPECT_THAT(errors("torque_max_Nm = 3.277\n"),
              ElementsAre(HasSubstr("'torque_max_Nm' must be at most 3.2767 N m: commands in per mille")));
  EXPECT_THAT(errors("torque_max_Nm = 50.0\nprotocol = \"odrive\"\nwatchdog = \"drive\"\n"), IsEmpty());
}

TEST(DeviceKeys, ProtocolsProfilesAndButtonsLoadBackAsThemselves) {
  const std::string text =
      with_bus(moteus_bus, drive("a", "bus = \"can1\"\nprotocol = \"moteus\"\nnode_id = 1\n") +
                               drive("b", "bus = \"can0\"\nprofile = \"epos4\"\nnode_id = 21\n") +
                               button(9, 0) + button(9, 3, "use = \"clutch\"\nactive_low = true\n"));
  const LoadResult first = load(text);
  ASSERT_THAT(first.errors, IsEmpty());
  const std::string printed = effective_config_toml(*first.scene);
  const LoadResult back = load(printed);
  ASSERT_THAT(back.errors, IsEmpty()) << printed;
  EXPECT_EQ(effective_config_toml(*back.scene), printed);
  const RigParams& rig = *back.scene->device->rig;
  EXPECT_EQ(rig.buses[1].data_bit_rate, 5e6);
  EXPECT_EQ(rig.drives[0].protocol, DriveProtocol::moteus);
  EXPECT_EQ(rig.drives[1].profile, "epos4");
  ASSERT_EQ(rig.buttons.size(), 2u);
  EXPECT_TRUE(rig.buttons[1].use == ButtonUse::clutch && rig.buttons[1].active_low);
  EXPECT_EQ(rig.buttons[1].bit, 3);
  EXPECT_THAT(validate(rig, back.scene->step), IsEmpty());
}

TEST(DeviceKeys, ProtocolsThatDoNotFitAreRefused) {
  const auto errors = [](const std::string& bus, const std::string& more) {
    return load(with_bus(bus, drive("a", "bus = \"can1\"\n" + more))).errors;
  };
  const std::string odrive = "protocol = \"odrive\"\nnode_id = ";
  EXPECT_THAT(load(scene(serial) + drive("a", "bus = \"can0\"\n" + odrive + "10\n")).errors,
              ElementsAre(HasSubstr("bus 'can0' has devices of more than one protocol")));
  EXPECT_THAT(errors(classic_bus, "protocol = \"moteus\"\nnode_id = 1\n"),
              ElementsAre(HasSubstr("bus 'can1' carries CAN FD: give it a data_bit_rate")));
  EXPECT_THAT(errors(classic_bus, odrive + "63\n"),
              ElementsAre(HasSubstr("'node_id' must be at most 62 with this protocol")));
  EXPECT_THAT(errors(classic_bus, odrive + "10\nprofile = \"x\"\n"),
              ElementsAre(HasSubstr("'profile' has no meaning with this protocol")));
  EXPECT_THAT(load(with_bus("[[bus]]\nname = \"can1\"\ndata_bit_rate = 5e5\n", "")).errors,
              ElementsAre(HasSubstr("'data_bit_rate' is below bit_rate")));
}

TEST(DeviceKeys, ButtonsHaveAnInputOfTheirOwn) {
  EXPECT_THAT(load(scene(serial) + button(9, 1) + button(9, 1)).errors,
              ElementsAre(HasSubstr("'bit' is the input of an earlier button: choose another")));
  EXPECT_THAT(load(scene(serial) + button(2, 1)).errors,
              ElementsAre(HasSubstr("'node_id' is taken by the host or by another device")));
}

/// Returns a scene in which a turns, b and c slide.
std::string mixed(const std::string& plant) {
  std::string text = scene("[device.plant]\n" + plant + joint("a") + joint("b", "kind = \"slider\"\n") +
                           joint("c", "kind = \"slider\"\n"));
  for (const std::string slide : {"b", "c"}) {
    const std::string counts = "counts_per_turn = 4096\njoint = \"" + slide;
    text.replace(text.find(counts), counts.size(), "counts_per_unit = 1e5\njoint = \"" + slide);
  }
  return text;
}

TEST(DeviceKeys, TurnsAndSlidesHaveMechanicsOfTheirOwn) {
  const PlantConfig plant = load(mixed("")).scene.value().device->plant;
  EXPECT_EQ(plant.of("a").inertia, 1e-3);
  EXPECT_EQ(plant.of("a").hand_stiffness, 20);
  for (const char* slide : {"b", "c"}) {
    EXPECT_EQ(plant.of(slide).inertia, 0.1);
    EXPECT_EQ(plant.of(slide).damping, 1);
    EXPECT_EQ(plant.of(slide).hand_stiffness, 500);
  }
}

TEST(DeviceKeys, AJointHasMechanicsOfItsOwn) {
  const LoadResult result =
      load(mixed("damping = 0.3\nhand_damping = 2\n[[device.plant.joint]]\njoint = \"b\"\ninertia = 0.7\n"
                 "damping = 5\nfriction = 0.2\n"));
  ASSERT_THAT(result.errors, IsEmpty());
  const PlantConfig& plant = result.scene->device->plant;
  EXPECT_EQ(plant.of("a").damping, 0.3);
  EXPECT_EQ(plant.of("a").inertia, 1e-3);
  EXPECT_EQ(plant.of("b").inertia, 0.7);
  EXPECT_EQ(plant.of("b").damping, 5);
  EXPECT_EQ(plant.of("b").friction, 0.2);
  EXPECT_EQ(plant.of("b").hand_damping, 2);
  EXPECT_EQ(plant.of("c").damping, 0.3);
  EXPECT_EQ(plant.of("c").inertia, 0.1);
  // N m s/rad for a are N s/m for c
  EXPECT_THAT(result.warnings, ElementsAre(AllOf(HasSubstr("'damping'"), HasSubstr("slide 'c'"))));
  const LoadResult again = parse_scene(effective_config_toml(*result.scene), "b.toml");
  ASSERT_THAT(again.errors, IsEmpty());
  for (const char* name : {"a", "b", "c"}) {
    const JointPlant &was = plant.of(name), &is = again.scene->device->plant.of(name);
    EXPECT_EQ(is.inertia, was.inertia) << name;
    EXPECT_EQ(is.damping, was.damping) << name;
    EXPECT_EQ(is.friction, was.friction) << name;
    EXPECT_EQ(is.hand_stiffness, was.hand_stiffness) << name;
    EXPECT_EQ(is.hand_damping, was.hand_damping) << name;
  }
}

TEST(DeviceKeys, MechanicsAreOfAJointThatIsThereAndOnce) {
  const std::string of_b = "[[device.plant.joint]]\njoint = \"b\"\n";
  EXPECT_THAT(load(mixed("[[device.plant.joint]]\njoint = \"d\"\n")).errors,
              ElementsAre(HasSubstr("'joint' is \"d\"; admissible is \"a\", \"b\", \"c\"")));
  EXPECT_THAT(load(mixed(of_b + of_b)).errors, ElementsAre(HasSubstr("has an earlier table")));
  EXPECT_THAT(load(mixed(of_b + "inertia = 0\n")).errors, ElementsAre(HasSubstr("inertia")));
}

}  // namespace
}  // namespace godobject::test_device_keys
