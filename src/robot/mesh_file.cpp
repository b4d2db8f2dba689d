#include "vantage/robot/mesh_file.h"

#include <cctype>
#include <filesystem>
#include <system_error>

#include <Eigen/Geometry>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3f;
using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr float kSharpEdge = 40.0F;  // [deg].

std::string LowerExtension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void RequireFile(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw MeshError(path, "no such file");
  if (!fs::is_regular_file(path, error)) throw MeshError(path, "is not a file");
}

// Points and lines are sorted into meshes of their own, and those are dropped.
const aiScene* Import(Assimp::Importer* importer, const std::string& path) {
  const unsigned int steps = aiProcess_RemoveComponent | aiProcess_Triangulate |
                             aiProcess_SortByPType | aiProcess_GenSmoothNormals |
                             aiProcess_JoinIdenticalVertices;
  importer->SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                               aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer->SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer->SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, kSharpEdge);
  // What nobody draws would keep vertices apart; an STL's normals, one to a facet, would keep every
  // edge sharp as well.
  int unwanted = aiComponent_TEXCOORDS | aiComponent_COLORS | aiComponent_TANGENTS_AND_BITANGENTS |
                 aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS;
  if (LowerExtension(path) == ".stl") unwanted |= aiComponent_NORMALS;
  importer->SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, unwanted);
  const aiScene* scene = importer->ReadFile(path, steps);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw MeshError(path, std::string("cannot be read as a mesh: ") + importer->GetErrorString());
  }
  return scene;
}

std::optional<Vector3f> ColourOf(const aiScene& scene, const aiMesh& mesh) {
  if (mesh.mMaterialIndex >= scene.mNumMaterials) return std::nullopt;
  const aiMaterial& material = *scene.mMaterials[mesh.mMaterialIndex];
  aiString name;
  if (material.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS &&
      std::string(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME) {
    return std::nullopt;  // Assimp's own, of files without materials.
  }
  if (material.GetTextureCount(aiTextureType_DIFFUSE) > 0) return std::nullopt;
  aiColor4D diffuse;
  if (material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) != aiReturn_SUCCESS) return std::nullopt;
  const Vector3f colour(diffuse.r, diffuse.g, diffuse.b);
  if (!colour.allFinite()) return std::nullopt;
  return colour.cwiseMax(0.0F).cwiseMin(1.0F);
}

Matrix4f ToEigen(const aiMatrix4x4& m) {
  Matrix4f result;
  for (unsigned int i = 0; i < 4; ++i) {
    for (unsigned int j = 0; j < 4; ++j) result(i, j) = m[i][j];
  }
  return result;
}

MeshPart MakePart(const aiScene& scene, const aiMesh& mesh, const Matrix4f& X) {
  MeshPart part;
  part.colour = ColourOf(scene, mesh);
  const Matrix3f linear = X.topLeftCorner<3, 3>();
  const Matrix3f to_normal = linear.inverse().transpose();
  for (unsigned int i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& p = mesh.mVertices[i];
    const aiVector3D& n = mesh.mNormals[i];
    part.vertices.emplace_back(linear * Vector3f(p.x, p.y, p.z) + X.topRightCorner<3, 1>());
    Vector3f normal = to_normal * Vector3f(n.x, n.y, n.z);
    normal = normal.allFinite() && normal.norm() > 0.0F ? normal.normalized() : Vector3f::UnitZ();
    part.normals.push_back(normal);
  }
  const bool mirrored = linear.determinant() < 0.0F;
  for (unsigned int i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    if (face.mNumIndices != 3) continue;
    part.indices.push_back(face.mIndices[0]);
    part.indices.push_back(face.mIndices[mirrored ? 2 : 1]);
    part.indices.push_back(face.mIndices[mirrored ? 1 : 2]);
  }
  return part;
}

void Collect(const aiScene& scene, const aiNode& node, const Matrix4f& X_parent,
             std::vector<MeshPart>* parts) {
  const Matrix4f X = X_parent * ToEigen(node.mTransformation);
  for (unsigned int i = 0; i < node.mNumMeshes; ++i) {
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
    if (mesh.mNormals == nullptr) continue;  // No triangles.
    MeshPart part = MakePart(scene, mesh, X);
    if (!part.indices.empty()) parts->push_back(std::move(part));
  }
  for (unsigned int i = 0; i < node.mNumChildren; ++i) {
    Collect(scene, *node.mChildren[i], X, parts);
  }
}

}  // namespace

std::vector<MeshPart> ReadMeshFile(const std::string& path) {
  RequireFile(path);
  Assimp::Importer importer;
  const aiScene* scene = Import(&importer, path);
  std::vector<MeshPart> parts;
  Collect(*scene, *scene->mRootNode, Matrix4f::Identity(), &parts);
  std::size_t triangles = 0;
  for (const MeshPart& part : parts) {
    triangles += part.indices.size() / 3;
    for (const Vector3f& vertex : part.vertices) {
      if (!vertex.allFinite()) throw MeshError(path, "has a vertex that is not finite");
    }
  }
  if (triangles == 0) throw MeshError(path, "has no triangle");
  if (triangles > kMaxMeshTriangles) {
    throw MeshError(path, "has " + std::to_string(triangles) + " triangles; at most " +
                              std::to_string(kMaxMeshTriangles) + " are taken");
  }
  return parts;
}

}  // namespace vantage
