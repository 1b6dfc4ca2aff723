// Meshes and grids from files: what a point sees of them is what was drawn.
#include "sim/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/shape_list.h"
#include "sim/mesh_solid.h"
#include "sim/obstacle_file.h"

namespace godobject::test_mesh_file {
namespace {

using testing::HasSubstr;

std::string written(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "/godobject_" + name;
  std::ofstream(path) << text;
  return path;
}

/// Corner i of the unit cube; faces of four corners, counter-clockwise from outside.
Vec3 corner(int i) { return {Real(i & 1), Real(i >> 1 & 1), Real(i >> 2 & 1)}; }
constexpr int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

std::string text_of(const Vec3& p) {
  return std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
}

std::string cube_stl() {
  std::string text = "solid cube\n";
  for (const auto& f : faces)
    for (const auto& t : {std::array{f[0], f[1], f[2]}, std::array{f[0], f[2], f[3]}}) {
      text += "facet normal 0 0 0\nouter loop\n";
      for (const int i : t) text += "vertex " + text_of(corner(i));
      text += "endloop\nendfacet\n";
    }
  return text + "endsolid cube\n";
}

std::string cube_obj(int num_faces = 6) {
  std::string text;
  for (int i = 0; i < 8; ++i) text += "v " + text_of(corner(i));
  for (int f = 0; f < num_faces; ++f) {
    text += "f";
    for (const int i : faces[f]) text += " " + std::to_string(i + 1);
    text += "\n";
  }
  return text;
}

std::string cube_ply() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) text += text_of(corner(i));
  for (const auto& f : faces) {
    text += "4";
    for (const int i : f) text += " " + std::to_string(i);
    text += "\n";
  }
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
}

TEST(MeshFile, SaysWhatItCannotRead) {
  MeshData data;
  EXPECT_THAT(read_mesh(written("cube.txt", cube_obj()), 1, data), HasSubstr("ends in .stl, .obj or .ply"));
  EXPECT_THAT(read_mesh(testing::TempDir() + "/godobject_no_such.stl", 1, data), HasSubstr("cannot be read"));
  EXPECT_THAT(read_mesh(written("broken.ply", "ply\nformat"), 1, data), HasSubstr("broken.ply"));
}

TEST(MeshFile, AnOpenMeshIsNoSolid) {
  ObstacleConfig obstacle;
  obstacle.shape.kind = ShapeKind::mesh;
  obstacle.file = written("open.obj", cube_obj(5));
  EXPECT_THAT(load_file(obstacle), AllOf(HasSubstr("holds no solid"), HasSubstr("not closed")));
}

TEST(MeshFile, AnInsideOutMeshIsNoSolid) {
  MeshData data;
  ASSERT_EQ(read_mesh(written("cube.obj", cube_obj()), 1, data), "");
  for (TriangleIndices& t : data.triangles) std::swap(t[0], t[1]);
  std::string why_not;
  EXPECT_EQ(MeshSolid::make(data, why_not), nullptr);
  EXPECT_THAT(why_not, HasSubstr("inside is outside"));
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
