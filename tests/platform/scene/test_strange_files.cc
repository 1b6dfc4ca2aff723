// Scenes and their files may be hostile: they read only files beside them, and errors are quick, short and
// printable.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <numeric>

#include "hal/rig/params.h"
#include "platform/motion/motion.h"
#include "platform/scene/text/csv.h"
#include "platform/scene/text/diagnostics.h"
#include "platform/scene/toml.h"
#include "tests/support/cpu_time.h"

namespace godobject::test_strange_files {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string one_body =
    "[scene]\nname = \"s\"\n\n[[body]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, 1]\n";
constexpr double at_once_s = 5;  // limit with sanitizers on a busy machine; 0.1 to 1 s without

/// A folder with a scene in it, and a secret beside the folder.
class SceneFolder : public testing::Test {
 protected:
  SceneFolder() {
    fs::create_directories(folder_ / "scene" / "meshes");
    write("secret.csv", "x,y,z\nroot:x:0:0\n");
    write("scene/spheres.csv", "x,y,z\n0,0,0\n");
    write("scene/meshes/spheres.csv", "x,y,z\n0,0,0\n1,0,0\n");
  }
  ~SceneFolder() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  void link(const fs::path& to, const std::string& name) const {
    fs::create_symlink(to, folder_ / "scene" / name);
  }

  /// Reads a scene with spheres from that file.
  LoadResult read(const std::string& file) const {
    return parse_scene(
        one_body + "\n[[obstacle]]\nname = \"o\"\nkind = \"sphere\"\nradius = 1\nfile = \"" + file + "\"\n",
        (folder_ / "scene" / "a.toml").string());
  }
  std::string error(const std::string& file) const {
    const std::vector<std::string> errors = read(file).errors;
    return std::accumulate(errors.begin(), errors.end(), std::string());
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / ("godobject-strange-" + std::to_string(getpid()));
};

TEST_F(SceneFolder, ASceneReadsFilesInItsFolderAndBelow) {
  EXPECT_EQ(read("spheres.csv").scene.value().obstacles[0].centres.size(), 1u);
  EXPECT_EQ(read("meshes/spheres.csv").scene.value().obstacles[0].centres.size(), 2u);
  EXPECT_EQ(read("meshes/../spheres.csv").scene.value().obstacles[0].centres.size(), 1u);
  link("meshes/spheres.csv", "linked.csv");
  EXPECT_EQ(read("linked.csv").scene.value().obstacles[0].centres.size(), 2u);
  link(folder_ / "scene", "itself");
  EXPECT_EQ(read("itself/meshes/spheres.csv").scene.value().obstacles[0].centres.size(), 2u);
}

TEST_F(SceneFolder, ASceneReadsNothingElse) {
  link("../secret.csv", "link.csv");
  link("..", "up");
  link("/dev/zero", "zero.csv");
  ASSERT_EQ(mkfifo((folder_ / "scene" / "fifo.csv").c_str(), 0600), 0);
  EXPECT_THAT(error("../secret.csv"), HasSubstr("a.toml:13:8: 'file' leads out of the scene's folder"));
  EXPECT_THAT(error("meshes/../../secret.csv"), HasSubstr("leads out of the scene's folder"));
  EXPECT_THAT(error((folder_ / "secret.csv").string()), HasSubstr("'file' is an absolute path"));
  EXPECT_THAT(error("/etc/passwd"), HasSubstr("'file' is an absolute path"));
  EXPECT_THAT(error("link.csv"), HasSubstr("is a link that leads out of the scene's folder"));
  EXPECT_THAT(error("up/secret.csv"), HasSubstr("is a link that leads out of the scene's folder"));
  EXPECT_THAT(error("zero.csv"), HasSubstr("is a link that leads out of the scene's folder"));
  EXPECT_THAT(error("fifo.csv"), HasSubstr("'file' cannot be read, because it is not a file"));
  EXPECT_THAT(error("meshes"), HasSubstr("'file' cannot be read, because it is not a file"));
  EXPECT_THAT(
      error("none.csv"),
      HasSubstr("'file' cannot be read: check the path none.csv, which is relative to the scene file"));
  for (const char* const file : {"../secret.csv", "link.csv", "up/secret.csv"})
    EXPECT_THAT(error(file), Not(HasSubstr("root"))) << file;
}

TEST_F(SceneFolder, AProfileIsBelowItOrShipped) {
  const std::string profile = "[identity]\ndevice_profile = 402\n";
  write("outside.toml", profile);
  write("scene/mine.toml", profile);
  link("../outside.toml", "linked.toml");
  const auto errors = [&](const std::string& name) {
    RigParams rig;
    rig.drives.resize(1);
    rig.drives[0].joint = "j";
    rig.drives[0].profile = name;
    const std::vector<std::string> all = load_profiles(rig, 1e-3, (folder_ / "scene").string()).errors;
    return std::accumulate(all.begin(), all.end(), std::string());
  };
  const std::string refused = "drive of joint 'j': profile";
  EXPECT_THAT(errors("mine"), Not(HasSubstr(refused)));
  EXPECT_THAT(errors("mine.toml"), Not(HasSubstr(refused)));
  EXPECT_THAT(errors("../outside.toml"),
              AllOf(HasSubstr(refused), HasSubstr("leads out of the scene's folder")));
  EXPECT_THAT(errors((folder_ / "outside.toml").string()), HasSubstr("is an absolute path"));
  EXPECT_THAT(errors("linked"), HasSubstr(refused));
  EXPECT_THAT(errors("linked.toml"), HasSubstr("is a link that leads out"));
}

TEST_F(SceneFolder, TheEffectiveConfigurationNamesFilesAsTheSceneDoes) {
  const LoadResult read_first = read("meshes/spheres.csv");
  const std::string text = effective_config_toml(read_first.scene.value());
  EXPECT_THAT(text, HasSubstr("file = \"meshes/spheres.csv\""));
  const LoadResult again = parse_scene(text, (folder_ / "scene" / "b.toml").string());
  EXPECT_EQ(again.scene.value().obstacles[0].centres.size(), 2u);
}

// ---- files that a user names ---------------------------------------------------------------------

TEST(NamedFile, IsARegularFileOrAPipeAndNotTooLarge) {
  EXPECT_EQ(read_file("/dev/zero", 100).why_not, "cannot be read, because it is neither a file nor a pipe");
  EXPECT_EQ(read_file(testing::TempDir(), 100).why_not, "cannot be read, because it is a directory");
  EXPECT_EQ(read_file("/no/such", 100).why_not, "cannot be read: check the path");
  EXPECT_THAT(load_scene("/dev/zero").errors, ElementsAre(HasSubstr("/dev/zero: cannot be read")));
  const std::string path = testing::TempDir() + "/godobject-large-" + std::to_string(getpid());
  std::ofstream(path) << std::string(1 << 20, 'x') << "y";
  EXPECT_EQ(read_file(path, 1 << 20).why_not, "is larger than 1 MB, the limit of this program");
  EXPECT_EQ(read_file(path, 2 << 20).text.value().size(), (1u << 20) + 1);
  fs::remove(path);
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "t,b.x\n", 6), 6);
  close(ends[1]);
  EXPECT_EQ(read_file("/dev/fd/" + std::to_string(ends[0]), 100).text.value(), "t,b.x\n");
  close(ends[0]);
}

TEST(NamedFile, MayHaveAnyBytesInItsName) {
  const std::string name = "/no/such\xFF\x1B[31m.toml";
  EXPECT_THAT(load_scene(name).errors, ElementsAre(HasSubstr("/no/such\\xFF\\x1B[31m.toml: cannot be read")));
  const std::string path = testing::TempDir() + "/godobject-\xFF-" + std::to_string(getpid()) + ".toml";
  std::ofstream(path) << one_body;
  EXPECT_THAT(load_scene(path).errors, IsEmpty());
  fs::remove(path);
}

TEST(Printable, LeavesTextAndEscapesWhatHasNoPicture) {
  EXPECT_EQ(printable("caf\u00e9 \u20ac \U0001F600 'a\\b'"), "caf\u00e9 \u20ac \U0001F600 'a\\b'");
  EXPECT_EQ(printable(std::string("a\0b\n\x7F", 5)), "a\\x00b\\x0A\\x7F");
  EXPECT_EQ(printable("\xC3("), "\\xC3(");
  EXPECT_EQ(printable("\xC0\xAF \xED\xA0\x80 \xC2\x9B \xF5"), "\\xC0\\xAF \\xED\\xA0\\x80 \\xC2\\x9B \\xF5");
  EXPECT_EQ(printable("\xE2\x82"), "\\xE2\\x82");
  EXPECT_EQ(excerpt(std::string(3'000'000, 'k')), "'" + std::string(40, 'k') + "... (3000000 bytes)'");
}

// ---- sizes ---------------------------------------------------------------------------------------

class TooLarge : public testing::Test {
 protected:
  static std::vector<std::string> errors(const std::string& toml) {
    const double begin_s = test::cpu_time_s();
    const LoadResult result = parse_scene(toml, "a.toml");
    const double seconds = test::cpu_time_s() - begin_s;
    EXPECT_LT(seconds, at_once_s) << toml.substr(0, 100);
    EXPECT_LE(result.errors.size(), 101u);
    for (const std::string& error : result.errors) EXPECT_LT(error.size(), 1100u);
    return result.errors;
  }
  static std::string repeated(const std::string& part, int times) {
    std::string text;
    for (int i = 0; i < times; ++i) text += part;
    return text;
  }
};

TEST_F(TooLarge, TwoHundredThousandBodies) {
  std::string text = "[scene]\nname = \"s\"\n";
  for (int i = 0; i < 200'000; ++i)
    text += "[[body]]\nname = \"b" + std::to_string(i) + "\"\nmass = 1\ninertia = [1, 1, 1]\n";
  EXPECT_THAT(errors(text),
              testing::Contains(HasSubstr("there are 200000 tables [[body]]; at most 256 are possible")));
}

TEST_F(TooLarge, KeysAndStringsOfThreeMegabytes) {
  const std::string word(3'000'000, 'k');
  EXPECT_THAT(
      errors(one_body + word + " = 1\n"),
      ElementsAre(HasSubstr("unknown key 'kkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkkk... (3000000 bytes)'")));
  EXPECT_THAT(errors("[" + word + "]\n[" + word + "]\n"), ElementsAre(HasSubstr("not TOML")));
  EXPECT_THAT(errors("[scene]\nname = \"s\"\nintegrator = \"" + word + "\"\n" + one_body.substr(18)),
              ElementsAre(HasSubstr("kkk... (3000000 bytes)")));
  errors("[scene]\nname = \"" + word + "\"\n");
  errors(one_body + "like = \"" + word + "\"\n");
}

TEST_F(TooLarge, ManyUnknownKeys) {
  std::string text = one_body;
  for (int i = 0; i < 300'000; ++i) text += "unknown_key_number_" + std::to_string(i) + " = 1\n";
  EXPECT_THAT(errors(text).back(), HasSubstr("and 299900 more"));
}

TEST_F(TooLarge, DeepNesting) {
  EXPECT_THAT(errors("a" + repeated(".a", 1'000'000) + " = 1\n"), ElementsAre(HasSubstr("1000 dots")));
  EXPECT_THAT(errors("[a" + repeated(".a", 1'000'000) + "]\n"), ElementsAre(HasSubstr("1000 dots")));
  EXPECT_THAT(errors("a" + repeated("\t. \"a\"", 1'000'000) + " = 1\n"), ElementsAre(HasSubstr("1000 dots")));
  EXPECT_THAT(errors("a = " + repeated("[", 1'000'000)), ElementsAre(HasSubstr("not TOML")));
  EXPECT_THAT(errors("a = " + repeated("{a=", 1'000'000)), ElementsAre(HasSubstr("not TOML")));
  errors("a" + repeated(".a", 900) + " = {" + "a" + repeated(".a", 900) + " = 1}\n");
}

TEST_F(TooLarge, AllThatIsAllowedOfWhatIsCombined) {
  // 256 equal bodies in a chain, children before parents, each with spheres of every material.
  std::string text = "[scene]\nname = \"s\"\n[[body]]\nname = \"b0\"\nmass = 1\ninertia = [1, 1, 1]\n";
  for (int i = 0; i < 1000; ++i)
    text += "[[body.sphere]]\nradius = 1\ncount = 10000\nspacing = [1, 0, 0]\nmaterial = \"m" +
            std::to_string(i % 8) + "\"\n";
  for (int i = 1; i < 256; ++i) text += "[[body]]\nname = \"b" + std::to_string(i) + "\"\nlike = \"b0\"\n";
  for (int i = 0; i < 255; ++i)
    text += "[[joint]]\nname = \"j" + std::to_string(i) + "\"\nkind = \"ball\"\nparent = \"b" +
            std::to_string(i + 1) + "\"\nchild = \"b" + std::to_string(i) + "\"\n";
  errors(text);
}

TEST_F(TooLarge, MoreMaterialsThanThereCanBe) {
  std::string text = one_body;
  for (int i = 0; i < 1000; ++i)
    text += "[[body.sphere]]\nradius = 1\nmaterial = \"m" + std::to_string(i) + "\"\n";
  EXPECT_THAT(errors(text), ElementsAre(HasSubstr("has 1000 materials; at most 8")));
}

TEST_F(TooLarge, TablesOfNumbers) {
  const double begin_s = test::cpu_time_s();
  std::string header;
  for (int i = 0; i < 300'000; ++i) header += "c" + std::to_string(i) + ",";
  EXPECT_THAT(parse_csv(header, "a.csv").errors.front(), HasSubstr("more than 1000 columns"));
  const CsvResult wide = parse_csv("t,x\n" + std::string(10'000'000, ','), "a.csv");
  EXPECT_THAT(wide.errors, testing::Contains(HasSubstr("has 10000001 values, the header 2")));
  EXPECT_LE(wide.errors.size(), 5u);
  const std::string cell = parse_csv("t\n" + std::string(3'000'000, '\x1B'), "a.csv").errors.front();
  EXPECT_LT(cell.size(), 300u);
  EXPECT_THAT(cell, HasSubstr("a.csv:2:1: '\\x1B"));
  EXPECT_LT(test::cpu_time_s() - begin_s, at_once_s);
}

}  // namespace
}  // namespace godobject::test_strange_files
