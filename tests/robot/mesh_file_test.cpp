#include "vantage/robot/mesh_file.h"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "temporary_folder.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Vector3f;

std::string MeshErrorOf(const std::string& path) {
  try {
    (void)ReadMeshFile(path);
  } catch (const MeshError& error) {
    return error.what();
  }
  return "nothing thrown";
}

struct Facet {
  Vector3f a, b, c;
};

// The sides of a polygonal tube about z, of radius 1 and height 2.
std::vector<Facet> Tube(int sides) {
  constexpr float kHeight = 2.0F;
  std::vector<Facet> facets;
  for (int i = 0; i < sides; ++i) {
    const auto corner = [&](int k, float z) {
      const float angle = 2.0F * static_cast<float>(kPi) * static_cast<float>(k % sides) /
                          static_cast<float>(sides);
      return Vector3f(std::cos(angle), std::sin(angle), z);
    };
    facets.push_back({corner(i, 0), corner(i + 1, 0), corner(i + 1, kHeight)});
    facets.push_back({corner(i, 0), corner(i + 1, kHeight), corner(i, kHeight)});
  }
  return facets;
}

std::string BinaryStl(const std::vector<Facet>& facets) {
  std::string data(80, ' ');
  const auto append = [&](const void* value, std::size_t size) {
    data.append(static_cast<const char*>(value), size);
  };
  const auto count = static_cast<std::uint32_t>(facets.size());
  append(&count, 4);
  for (const Facet& facet : facets) {
    const Vector3f wrong_normal(0, 0, 1);  // As some exporters write them: not to be trusted.
    for (const Vector3f& v : {wrong_normal, facet.a, facet.b, facet.c}) append(v.data(), 12);
    const std::uint16_t attribute = 0;
    append(&attribute, 2);
  }
  return data;
}

std::string AsciiStl(const std::vector<Facet>& facets) {
  std::string text = "solid test\n";
  for (const Facet& facet : facets) {
    text += "facet normal 0 0 1\nouter loop\n";
    for (const Vector3f& v : {facet.a, facet.b, facet.c}) {
      text += "vertex " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " +
              std::to_string(v.z()) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid test\n";
}

// One triangle in a node, with an up axis, a unit and a colour.
std::string Dae(const std::string& up, const std::string& unit, const std::string& transform = "") {
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="unit" meter=")" +
         unit + R"("/><up_axis>)" + up + R"(</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert><diffuse>
<color>0.25 0.5 0.75 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="m" name="sky"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">1 0 0 0 2 0 0 0 3</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles material="s" count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node id="n">)" +
         transform + R"(
<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"/></technique_common></bind_material></instance_geometry>
</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>)";
}

TEST(ReadMeshFile, ReadsBothKindsOfStlAlike) {
  const test::TemporaryFolder folder;
  const auto binary = ReadMeshFile(folder.Write("b.stl", BinaryStl(Tube(36))));
  const auto ascii = ReadMeshFile(folder.Write("a.STL", AsciiStl(Tube(36))));
  for (const auto& parts : {binary, ascii}) {
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].indices.size(), 3u * 72u);
    EXPECT_FALSE(parts[0].colour.has_value());
  }
}

TEST(ReadMeshFile, JoinsAndSmoothsAnStl) {
  const test::TemporaryFolder folder;
  const auto parts = ReadMeshFile(folder.Write("tube.stl", BinaryStl(Tube(36))));
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].vertices.size(), 72u);  // Of 216 in the file.
  for (std::size_t i = 0; i < parts[0].vertices.size(); ++i) {
    const Vector3f& p = parts[0].vertices[i];
    const Vector3f outwards = Vector3f(p.x(), p.y(), 0.0F).normalized();
    EXPECT_GT(parts[0].normals[i].dot(outwards), std::cos(4.0 * kPi / 180.0));
    EXPECT_NEAR(parts[0].normals[i].norm(), 1.0, 1e-5);
  }
}

// Edges of 45 degrees stay, those of 36 are smoothed.
TEST(ReadMeshFile, KeepsEdgesOfMoreThan40Degrees) {
  const test::TemporaryFolder folder;
  const auto sharp = ReadMeshFile(folder.Write("sharp.stl", BinaryStl(Tube(8))));
  const auto smooth = ReadMeshFile(folder.Write("smooth.stl", BinaryStl(Tube(10))));
  EXPECT_EQ(sharp.at(0).vertices.size(), 32u);
  EXPECT_EQ(smooth.at(0).vertices.size(), 20u);
}

TEST(ReadMeshFile, ReadsColoursOfAnObj) {
  const test::TemporaryFolder folder;
  folder.Write("two.mtl", "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 0.5 0\n");
  const auto parts =
      ReadMeshFile(folder.Write("two.obj",
                                "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                "usemtl red\nf 1 2 3\nusemtl green\nf 1 2 4\n"));
  ASSERT_EQ(parts.size(), 2u);
  ASSERT_TRUE(parts[0].colour.has_value() && parts[1].colour.has_value());
  EXPECT_TRUE(test::Near(*parts[0].colour, Vector3f(1, 0, 0), 1e-6));
  EXPECT_TRUE(test::Near(*parts[1].colour, Vector3f(0, 0.5, 0), 1e-6));
}

TEST(ReadMeshFile, GivesAnObjWithoutMaterialsNoColour) {
  const test::TemporaryFolder folder;
  const auto parts = ReadMeshFile(folder.Write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_FALSE(parts[0].colour.has_value());
  EXPECT_TRUE(test::Near(parts[0].normals.at(0), Vector3f(0, 0, 1), 1e-6));
}

TEST(ReadMeshFile, TakesTheAxesOfADaeAsTheyAre) {
  const test::TemporaryFolder folder;
  for (const std::string up : {"X_UP", "Y_UP", "Z_UP"}) {
    const auto parts = ReadMeshFile(folder.Write(up + ".dae", Dae(up, "1")));
    ASSERT_EQ(parts.size(), 1u) << up;
    ASSERT_EQ(parts[0].vertices.size(), 3u);
    EXPECT_TRUE(test::Near(parts[0].vertices[0], Vector3f(1, 0, 0), 1e-6)) << up;
    EXPECT_TRUE(test::Near(parts[0].vertices[1], Vector3f(0, 2, 0), 1e-6)) << up;
    EXPECT_TRUE(test::Near(parts[0].vertices[2], Vector3f(0, 0, 3), 1e-6)) << up;
    ASSERT_TRUE(parts[0].colour.has_value());
    EXPECT_TRUE(test::Near(*parts[0].colour, Vector3f(0.25, 0.5, 0.75), 1e-6));
  }
}

TEST(ReadMeshFile, AppliesTheUnitOfADae) {
  const test::TemporaryFolder folder;
  const auto parts = ReadMeshFile(folder.Write("mm.dae", Dae("Z_UP", "0.001")));
  EXPECT_TRUE(test::Near(parts.at(0).vertices.at(2), Vector3f(0, 0, 0.003F), 1e-9));
}

TEST(ReadMeshFile, AppliesTheNodesOfADae) {
  const test::TemporaryFolder folder;
  const std::string transform = "<translate>10 0 0</translate><scale>1 1 -1</scale>";
  const auto parts = ReadMeshFile(folder.Write("moved.dae", Dae("Z_UP", "1", transform)));
  ASSERT_EQ(parts.size(), 1u);
  const MeshPart& part = parts[0];
  EXPECT_TRUE(test::Near(part.vertices.at(2), Vector3f(10, 0, -3), 1e-6));
  // Mirrored, the corners run the other way round, so that they agree with the normal.
  const Vector3f& a = part.vertices[part.indices[0]];
  const Vector3f across =
      (part.vertices[part.indices[1]] - a).cross(part.vertices[part.indices[2]] - a);
  EXPECT_GT(across.dot(part.normals[part.indices[0]]), 0.0F);
}

TEST(ReadMeshFile, RefusesWhatIsNoMesh) {
  const test::TemporaryFolder folder;
  const std::string missing = (folder.path() / "missing.stl").string();
  EXPECT_EQ(MeshErrorOf(missing), missing + ": no such file");
  EXPECT_EQ(MeshErrorOf(folder.path().string()), folder.path().string() + ": is not a file");
  const std::string text = folder.Write("text.stl", "this is no mesh");
  EXPECT_EQ(MeshErrorOf(text).rfind(text + ": cannot be read as a mesh: ", 0), 0u)
      << MeshErrorOf(text);
  const std::string unknown = folder.Write("a.txyz", "x");
  EXPECT_EQ(MeshErrorOf(unknown).rfind(unknown + ": cannot be read as a mesh: ", 0), 0u);
  const std::string points = folder.Write("points.obj", "v 0 0 0\nv 1 0 0\np 1 2\n");
  EXPECT_NE(MeshErrorOf(points), "nothing thrown");
}

TEST(ReadMeshFile, RefusesAVertexThatIsNotFinite) {
  const test::TemporaryFolder folder;
  std::vector<Facet> facets = Tube(8);
  facets[3].b.y() = std::numeric_limits<float>::quiet_NaN();
  const std::string path = folder.Write("nan.stl", BinaryStl(facets));
  EXPECT_NE(MeshErrorOf(path), "nothing thrown");
}

}  // namespace
}  // namespace vantage
