// Meshes and grids from files: queries of points agree with the drawn shape.
#include "platform/scene/mesh/file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>

#include "core/shape/list.h"
#include "platform/scene/contact/params.h"
#include "tests/support/cpu_time.h"
#include "tests/support/mesh_files.h"

namespace godobject::test_mesh_file {
namespace {

using testing::HasSubstr;

std::string written(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "/godobject_" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string why_not(const std::string& name, const std::string& text) {
  MeshData data;
  return parse_mesh(text, name, 1, data);
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  text.replace(text.find(from), from.size(), to);
  return text;
}

void expect_cube(const std::string& path) {
  MeshData data;
  ASSERT_EQ(read_mesh(path, 0.1, data), "");
  EXPECT_EQ(data.vertices.size(), 8u);
  EXPECT_EQ(data.triangles.size(), 12u);
  std::string why_not;
  const std::unique_ptr<MeshSolid> solid = MeshSolid::make(data, why_not);
  ASSERT_TRUE(solid) << why_not;
  const ShapeParams shape{.kind = ShapeKind::mesh, .mesh = &solid->mesh()};
  ASSERT_TRUE(is_valid(shape));
  const SurfacePoint above = nearest(shape, Vec3(0.05, 0.04, 0.13), 0.1);
  EXPECT_NEAR(above.distance, 0.03, 1e-8) << "0.1 m per unit of the file";
  EXPECT_NEAR(above.n.z(), 1, 1e-8);
  EXPECT_NEAR(nearest(shape, Vec3(0.05, 0.02, 0.05), 0.1).distance, -0.02, 1e-8);
}

TEST(MeshFile, StlObjAndPlyAreTheSameSolid) {
  expect_cube(written("cube.stl", cube_stl()));
  expect_cube(written("cube.obj", cube_obj()));
  expect_cube(written("cube.ply", cube_ply()));
  for (const MeshFileText& file : cubes_in_every_format())
    expect_cube(written(std::string("any") + file.extension, file.bytes));
}

TEST(MeshFile, IsReadAsItIsWrittenElsewhere) {
  expect_cube(written("crlf.obj", std::regex_replace(cube_obj(), std::regex("\n"), "\r\n")));
  expect_cube(written("crlf.ply", std::regex_replace(cube_ply(), std::regex("\n"), "\r\n")));
  expect_cube(written("upper.STL", std::regex_replace(cube_stl(), std::regex("vertex"), "  VERTEX")));
  expect_cube(written("more.obj",
                      "mtllib none.mtl\no cube\nvt 0 0\nusemtl red\ns off\n" +
                          std::regex_replace(cube_obj(), std::regex("f (.) (.)"), "f $1/1/1 \\\n $2//1")));
  expect_cube(written("back.obj", changed(cube_obj(), "f 1 3 4 2", "f -8 -6 -5 -7")));
  const std::string extra =
      changed(cube_ply(), "property float z\n",
              "property float z\nproperty list uchar short seen_by\nproperty uchar red\n");
  expect_cube(written("extra.ply", std::regex_replace(extra, std::regex("000000\n"), "000000 2 -1 7 255\n")));
}

TEST(MeshFile, AFaceOfManyCornersIsCutWhereItIsBentInward) {
  // An arrow head along z: from the corner at the dent, number 4, all of it is visible.
  const std::string corners = "v 0 0 Z\nv 2 -1 Z\nv 0 3 Z\nv -2 -1 Z\n";
  const std::string arrow = std::regex_replace(corners, std::regex("Z"), "0") +
                            std::regex_replace(corners, std::regex("Z"), "1") +
                            "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  MeshData data;
  ASSERT_EQ(read_mesh(written("arrow.obj", arrow), 1, data), "");
  std::string complaint;
  const std::unique_ptr<MeshSolid> solid = MeshSolid::make(data, complaint);
  ASSERT_TRUE(solid) << complaint;
  const ShapeParams shape{.kind = ShapeKind::mesh, .mesh = &solid->mesh()};
  EXPECT_GT(nearest(shape, Vec3(0, -0.5, 0.5), 1).distance, 0.3) << "in the dent";
  EXPECT_NEAR(nearest(shape, Vec3(0, 1, 0.8), 1).distance, -0.2, 1e-6);
  EXPECT_EQ(why_not("z.obj",
                    "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"
                    "f 1 2 3 4 5 6 7 8\n"),
            "z.obj: line 9: a face of 8 corners is not flat, or not star-shaped from any corner: cut it into "
            "triangles with a mesh editor");
}

TEST(MeshFile, SaysWhereItIsWrong) {
  EXPECT_THAT(why_not("a.ply", "ply\nformat ascii "),
              HasSubstr("no line \"end_header\": export the file again"));
  EXPECT_EQ(why_not("a.ply", changed(cube_ply(), "4 0 2", "4 0 99")),
            "a.ply: face 0: there is no vertex 99 (counted from 0): the file has 8");
  EXPECT_THAT(why_not("a.ply", changed(cube_ply(), "4 0 2", "4 0 -2")),
              HasSubstr("face 0: there is no vertex"));
  EXPECT_THAT(why_not("a.ply", changed(cube_ply(), "face 6", "face 18446744073709551615")),
              HasSubstr("face 6: the file ends too early"));
  EXPECT_THAT(why_not("a.ply", changed(cube_ply(), "face 6", "face many")),
              HasSubstr("line 8: 'many' is not a number of elements"));
  EXPECT_THAT(why_not("a.ply", changed(cube_ply(), "float z", "half z")),
              HasSubstr("line 7: 'half' is not a type"));
  EXPECT_THAT(why_not("a.ply", changed(cube_ply(), "vertex_indices", "strips")),
              HasSubstr("no list vertex_indices"));
  EXPECT_THAT(why_not("a.ply", changed(cube_ply(), "element face", "element gap 7\nelement face")),
              HasSubstr("element 'gap' has no properties"));
  EXPECT_EQ(why_not("a.obj", changed(cube_obj(), "f 1 3", "f 1 9")),
            "a.obj: line 9: there is no vertex 8 (counted from 0): the file has 8");
  EXPECT_THAT(why_not("a.obj", changed(cube_obj(), "f 1 3", "f 1 0")),
              HasSubstr("line 9: '0' is not a vertex number"));
  EXPECT_THAT(why_not("a.obj", changed(cube_obj(), "f 1 3", "f 1 -9")),
              HasSubstr("line 9: '-9' is not a vertex number"));
  EXPECT_THAT(why_not("a.obj", changed(cube_obj(), "v 0.000000", "v 1e39")),
              HasSubstr("line 1: a coordinate"));
  EXPECT_THAT(why_not("a.obj", changed(cube_obj(), "v 0.000000", "v nan")),
              HasSubstr("line 1: a coordinate"));
  EXPECT_THAT(why_not("a.obj", changed(cube_obj(), "v 0.000000", "v x\x1b[31m")),
              HasSubstr("line 1: 'x\\x1B[31m' is not a number"));
  EXPECT_THAT(why_not("a.stl", changed(cube_stl(), "endloop\nendfacet", "endloop\nfacet")),
              HasSubstr("line 15: a facet has 6 vertices, not 3"));
  EXPECT_THAT(why_not("a.stl", cube_stl().substr(0, 100)), HasSubstr("export it again"));
  EXPECT_THAT(why_not("a.stl", cube_binary_stl().substr(0, 300)), HasSubstr("export it again"));
}

/// The slowest file of this size took some milliseconds.
constexpr double longest_s = 2;

TEST(MeshFile, MutatedFilesAreReadOrRefusedAtOnce) {
  const std::vector<MeshFileText> files = cubes_in_every_format();
  int num_read = 0, num_refused = 0;
  for (std::uint32_t seed = 0; seed < 2500; ++seed) {
    const MeshFileText& file = files[seed % files.size()];
    const std::string name = "m" + std::to_string(seed) + file.extension;
    const double begin_s = test::cpu_time_s();
    MeshData data;
    const std::string why_not = parse_mesh(mutated(file.bytes, seed), name, 1, data);
    std::string complaint;
    if (why_not.empty()) MeshSolid::make(data, complaint);
    EXPECT_LT(test::cpu_time_s() - begin_s, longest_s) << name;
    ++(why_not.empty() ? num_read : num_refused);
    if (why_not.empty()) continue;
    EXPECT_THAT(why_not, testing::StartsWith(name + ": "));
    EXPECT_TRUE(data.triangles.empty()) << name;
  }
  EXPECT_GT(num_read, 100);
  EXPECT_GT(num_refused, 1000);
}

TEST(MeshFile, AFewLargeTrianglesAmongManySmallOnesTakeNoLonger) {
  // Needles of 1 m on a cube of 1 mm: cells of the mean edge length would be millions.
  std::string text = cube_obj();
  for (int i = 0; i < 20'000; ++i)
    for (const Vec3& p : {Vec3(i, 0, 0), Vec3(i + 1, 0, 0), Vec3(i, 1, 0)}) text += "v " + text_of(1e-4 * p);
  for (int i = 0; i < 100; ++i)
    for (const Vec3& p : {Vec3(0, 0, i), Vec3(4, 0, i), Vec3(0, 4, i)}) text += "v " + text_of(p);
  for (int i = 0; i < 20'100; ++i) {
    const int v = 9 + 3 * i;
    text += "f " + std::to_string(v) + " " + std::to_string(v + 1) + " " + std::to_string(v + 2) + "\n";
    text += "f " + std::to_string(v) + " " + std::to_string(v + 2) + " " + std::to_string(v + 1) + "\n";
  }
  MeshData data;
  ASSERT_EQ(parse_mesh(text, "needles.obj", 1, data), "");
  const double begin_s = test::cpu_time_s();
  std::string complaint;
  MeshSolid::make(data, complaint);
  EXPECT_LT(test::cpu_time_s() - begin_s, 5 * longest_s);
}

TEST(MeshFile, SaysWhatItCannotRead) {
  MeshData data;
  EXPECT_THAT(read_mesh(written("cube.txt", cube_obj()), 1, data),
              HasSubstr("must end in .stl, .obj or .ply"));
  EXPECT_THAT(read_mesh(testing::TempDir() + "/godobject_no_such.stl", 1, data), HasSubstr("cannot be read"));
  EXPECT_THAT(read_mesh(written("broken.ply", "ply\nformat"), 1, data), HasSubstr("broken.ply"));
}

TEST(MeshFile, AnOpenMeshIsNoSolid) {
  ObstacleConfig obstacle;
  obstacle.shape.kind = ShapeKind::mesh;
  EXPECT_THAT(load_file(written("open.obj", cube_obj(5)), obstacle),
              AllOf(HasSubstr("holds no solid"), HasSubstr("not closed")));
}

TEST(MeshFile, AnInsideOutMeshIsNoSolid) {
  MeshData data;
  ASSERT_EQ(read_mesh(written("cube.obj", cube_obj()), 1, data), "");
  for (TriangleIndices& t : data.triangles) std::swap(t[0], t[1]);
  std::string why_not;
  EXPECT_EQ(MeshSolid::make(data, why_not), nullptr);
  EXPECT_THAT(why_not, HasSubstr("triangles face inwards"));
}

TEST(HeightFile, RowsAreAlongX) {
  HeightGrid grid;
  ASSERT_EQ(read_heights(written("grid.csv", "1, 2,3\r\n4,5, 6e0\n"), grid), "");
  EXPECT_EQ(grid.columns, 3u);
  EXPECT_EQ(grid.rows, 2u);
  EXPECT_THAT(grid.height, testing::ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(HeightFile, SaysWhichLineIsWrong) {
  HeightGrid grid;
  EXPECT_THAT(read_heights(written("grid.csv", "1,2\n3\n"), grid), HasSubstr("line 2: has 1 numbers"));
  EXPECT_THAT(read_heights(written("grid.csv", "1,2\n3,x\n"), grid), HasSubstr("line 2: must be numbers"));
  EXPECT_THAT(read_heights(written("grid.csv", "1,nan\n3,4\n"), grid), HasSubstr("line 1: must be numbers"));
  EXPECT_THAT(read_heights(written("grid.csv", "1,2\n"), grid), HasSubstr("at least 2 rows"));
}

TEST(CentresFile, NeedsItsColumns) {
  std::vector<Vec3> centres;
  EXPECT_EQ(read_centres(written("c.csv", "z,y,x\n3,2,1\n"), centres), "");
  EXPECT_THAT(centres, testing::ElementsAre(Vec3(1, 2, 3)));
  EXPECT_THAT(read_centres(written("c.csv", "x,y\n1,2\n"), centres), HasSubstr("no column 'z'"));
}

}  // namespace
}  // namespace godobject::test_mesh_file
