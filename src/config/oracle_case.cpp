#include "vantage/config/oracle_case.h"

#include <cmath>
#include <fstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "vantage/math/error.h"

namespace vantage {
namespace {

using Json = nlohmann::json;

[[noreturn]] void Fail(const std::string& key, const std::string& reason) {
  throw ConfigError("", key, reason);
}

const Json& Member(const Json& object, const char* name, const std::string& key) {
  if (!object.is_object()) Fail(key, "must be an object");
  const auto found = object.find(name);
  if (found == object.end()) Fail(key + "." + name, "is missing");
  return *found;
}

double Number(const Json& value, const std::string& key) {
  if (!value.is_number()) Fail(key, "must be a number, is " + value.dump());
  const auto number = value.get<double>();
  if (!std::isfinite(number)) Fail(key, "must be finite");
  return number;
}

double NumberOr(const Json& object, const char* name, double other, const std::string& key) {
  const auto found = object.find(name);
  return found == object.end() ? other : Number(*found, key + "." + name);
}

int Integer(const Json& value, const std::string& key) {
  if (!value.is_number_integer()) Fail(key, "must be a whole number, is " + value.dump());
  const auto number = value.get<long long>();
  if (number < -1000000 || number > 1000000) {
    Fail(key, "must be in [-1000000, 1000000], is " + value.dump());
  }
  return static_cast<int>(number);
}

std::string Text(const Json& value, const std::string& key) {
  if (!value.is_string()) Fail(key, "must be text, is " + value.dump());
  return value.get<std::string>();
}

const Json& List(const Json& value, const std::string& key) {
  if (!value.is_array()) Fail(key, "must be a list");
  return value;
}

std::string Index(const std::string& key, std::size_t i) {
  return key + "[" + std::to_string(i) + "]";
}

std::vector<int> Integers(const Json& list, const std::string& key) {
  std::vector<int> values;
  for (const Json& value : List(list, key)) values.push_back(Integer(value, key));
  return values;
}

Eigen::Vector3d Vector3(const Json& list, const std::string& key) {
  const Eigen::VectorXd values = ParseJsonVector(list, key);
  if (values.size() != 3) Fail(key, "must hold 3 numbers, holds " + std::to_string(values.size()));
  return values;
}

Eigen::Isometry3d Pose(const Json& rows, const std::string& key) {
  const Eigen::MatrixXd matrix = ParseJsonMatrix(rows, key);
  if (matrix.rows() != 4 || matrix.cols() != 4) Fail(key, "must be 4 by 4");
  if (matrix.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) {
    Fail(key, "must have the last row 0 0 0 1");
  }
  const Eigen::Isometry3d X(Eigen::Matrix4d{matrix});
  if (!IsPose(X)) Fail(key, "must be a rigid motion");
  return X;
}

JointKind Kind(const Json& joint, const std::string& key) {
  const std::string type = Text(Member(joint, "type", key), key + ".type");
  if (type == "R") return JointKind::kRevolute;
  if (type == "P") return JointKind::kPrismatic;
  Fail(key + ".type", "must be R or P, is " + type);
}

DhRow Row(const Json& joint, const std::string& key) {
  DhRow row;
  row.kind = Kind(joint, key);
  row.a = Number(Member(joint, "a", key), key + ".a");
  row.alpha = Number(Member(joint, "alpha", key), key + ".alpha");
  row.offset = NumberOr(joint, "offset", 0.0, key);
  // Which of the two is the variable says the kind; the other may not be left out.
  if (row.kind == JointKind::kRevolute) {
    row.d = Number(Member(joint, "d", key), key + ".d");
  } else {
    row.theta = Number(Member(joint, "theta", key), key + ".theta");
  }
  return row;
}

bool IsX(const Json& feature, const std::string& key) {
  const std::string coordinate = Text(Member(feature, "coord", key), key + ".coord");
  if (coordinate != "x" && coordinate != "y") {
    Fail(key + ".coord", "must be x or y, is " + coordinate);
  }
  return coordinate == "x";
}

CameraModel Intrinsics(const Json& intrinsics, const std::string& key) {
  CameraModel camera;
  camera.fx = Number(Member(intrinsics, "fx", key), key + ".fx");
  camera.fy = Number(Member(intrinsics, "fy", key), key + ".fy");
  if (!(camera.fx > 0.0)) Fail(key + ".fx", "must be > 0, is " + intrinsics.at("fx").dump());
  if (!(camera.fy > 0.0)) Fail(key + ".fy", "must be > 0, is " + intrinsics.at("fy").dump());
  camera.skew = NumberOr(intrinsics, "skew", 0.0, key);
  camera.u0 = NumberOr(intrinsics, "u0", 0.0, key);
  camera.v0 = NumberOr(intrinsics, "v0", 0.0, key);
  return camera;
}

OracleSphere Sphere(const Json& spherical, const std::string& key) {
  OracleSphere sphere;
  sphere.rig.kind = RigKind::kSpherical;
  const std::string orientation = Text(Member(spherical, "orientation", key), key + ".orientation");
  if (orientation == "lookat") {
    sphere.rig.orientation = RigOrientation::kLookAt;
  } else if (orientation == "fixed_down") {
    sphere.rig.orientation = RigOrientation::kFixedDown;
  } else {
    Fail(key + ".orientation", "must be lookat or fixed_down, is " + orientation);
  }
  if (spherical.contains("target")) {
    sphere.rig.target_W = Vector3(spherical.at("target"), key + ".target");
  }
  constexpr double kWide = 1e6;
  sphere.q_c.resize(4);
  int axis = 0;
  for (const char* name : {"R", "theta", "phi"}) {
    sphere.q_c(axis++) = Number(Member(spherical, name, key), key + "." + name);
    sphere.rig.axes.push_back({name, -kWide, kWide, 1.0, 1.0});
  }
  sphere.q_c(3) = NumberOr(spherical, "roll", 0.0, key);
  sphere.rig.axes.push_back({"roll", -kWide, kWide, 1.0, 1.0});
  return sphere;
}

OracleCamera Camera(const Json& camera, const std::string& key) {
  OracleCamera result;
  result.model = Intrinsics(Member(camera, "intrinsics", key), key + ".intrinsics");
  const std::string mount = Text(Member(camera, "mount", key), key + ".mount");
  if (mount == "ee") {
    result.eye_in_hand = true;
    result.X = Pose(Member(camera, "T_ec", key), key + ".T_ec");
  } else if (mount != "world") {
    Fail(key + ".mount", "must be world or ee, is " + mount);
  } else if (camera.contains("spherical")) {
    result.sphere = Sphere(camera.at("spherical"), key + ".spherical");
    result.X = RigPose(result.sphere->rig, result.sphere->q_c);
  } else {
    result.X = Pose(Member(camera, "T_wc", key), key + ".T_wc");
  }
  return result;
}

OraclePoint Point(const Json& point, const std::string& key) {
  const std::string frame = Text(Member(point, "frame", key), key + ".frame");
  if (frame != "ee" && frame != "world") Fail(key + ".frame", "must be ee or world, is " + frame);
  return {frame == "ee", Vector3(Member(point, "xyz", key), key + ".xyz")};
}

void RequireCount(const Json& entry, const char* name, int count) {
  if (!entry.contains(name)) return;
  const int stated = Integer(entry.at(name), name);
  if (stated != count) {
    Fail(name, "says " + std::to_string(stated) + " where the case has " + std::to_string(count));
  }
}

JointVector Joints(const Json& values, const ArmModel& arm) {
  const Eigen::VectorXd q = ParseJsonVector(values, "q");
  if (q.size() != arm.size()) {
    Fail("q",
         "must hold " + std::to_string(arm.size()) + " numbers, holds " + std::to_string(q.size()));
  }
  return q;
}

std::vector<OraclePoint> Points(const Json& list) {
  std::vector<OraclePoint> points;
  for (const Json& point : List(list, "points")) {
    points.push_back(Point(point, Index("points", points.size())));
  }
  return points;
}

std::vector<Feature> Features(const Json& list) {
  std::vector<Feature> features;
  for (const Json& feature : List(list, "features")) {
    features.push_back(ParseOracleFeature(feature, Index("features", features.size())));
  }
  return features;
}

}  // namespace

nlohmann::json ReadJsonFile(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw ConfigError(path, "", "cannot be opened");
  try {
    return Json::parse(file);
  } catch (const Json::exception& error) {
    throw ConfigError(path, "", error.what());
  }
}

Eigen::VectorXd ParseJsonVector(const nlohmann::json& values, const std::string& key) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(List(values, key).size()));
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    result(i) = Number(values[index], Index(key, index));
  }
  return result;
}

Eigen::MatrixXd ParseJsonMatrix(const nlohmann::json& rows, const std::string& key) {
  Eigen::MatrixXd result;
  for (std::size_t i = 0; i < List(rows, key).size(); ++i) {
    const Eigen::VectorXd row = ParseJsonVector(rows[i], Index(key, i));
    if (i == 0) result.resize(static_cast<Eigen::Index>(rows.size()), row.size());
    if (row.size() != result.cols()) Fail(Index(key, i), "is longer or shorter than the first row");
    result.row(static_cast<Eigen::Index>(i)) = row;
  }
  return result;
}

Feature ParseOracleFeature(const nlohmann::json& feature, const std::string& key) {
  const std::string type = Text(Member(feature, "type", key), key + ".type");
  const auto index = [&](const char* name) {
    return Integer(Member(feature, name, key), key + "." + name);
  };
  if (type == "point") {
    const FeatureKind kind = IsX(feature, key) ? FeatureKind::kPointX : FeatureKind::kPointY;
    return {kind, {index("p")}};
  }
  if (type == "distance") return {FeatureKind::kDistance, {index("i"), index("j")}};
  if (type == "angle") return {FeatureKind::kAngle, {index("i"), index("j")}};
  if (type == "edge_angle") {
    return {FeatureKind::kEdgeAngle, {index("i"), index("j"), index("k"), index("l")}};
  }
  if (type == "area") {
    return {FeatureKind::kArea, Integers(Member(feature, "poly", key), key + ".poly")};
  }
  if (type == "centroid") {
    const FeatureKind kind = IsX(feature, key) ? FeatureKind::kCentroidX : FeatureKind::kCentroidY;
    return {kind, Integers(Member(feature, "pts", key), key + ".pts")};
  }
  Fail(key + ".type", "is not a kind of feature: " + type);
}

ArmModel ParseOracleArm(const nlohmann::json& robot, const std::string& key) {
  const std::string convention = Text(Member(robot, "convention", key), key + ".convention");
  if (convention != "standard" && convention != "modified") {
    Fail(key + ".convention", "must be standard or modified, is " + convention);
  }
  std::vector<DhRow> rows;
  for (const Json& joint : List(Member(robot, "joints", key), key + ".joints")) {
    rows.push_back(Row(joint, Index(key + ".joints", rows.size())));
  }
  const std::vector<JointLimits> limits(rows.size(), {-100.0, 100.0, 1.0, 10.0});
  return ArmModel(Text(Member(robot, "name", key), key + ".name"),
                  convention == "modified" ? DhConvention::kModified : DhConvention::kStandard,
                  rows, limits, Pose(Member(robot, "base", key), key + ".base"),
                  Pose(Member(robot, "tool", key), key + ".tool"));
}

OracleCase ParseOracleCase(const nlohmann::json& entry) {
  std::string id = Text(Member(entry, "id", "case"), "id");
  const ArmModel arm = ParseOracleArm(Member(entry, "robot", "case"), "robot");
  std::vector<OraclePoint> points = Points(Member(entry, "points", "case"));
  std::vector<Feature> features = Features(Member(entry, "features", "case"));
  RequireCount(entry, "k", static_cast<int>(features.size()));
  RequireCount(entry, "n", arm.size());
  const int task_dimension = entry.contains("m") ? Integer(entry.at("m"), "m") : 6;
  if (task_dimension < 1 || task_dimension > 6) {
    Fail("m", "must be in [1, 6], is " + std::to_string(task_dimension));
  }
  const auto num_points = static_cast<int>(points.size());
  return {std::move(id),
          entry.contains("description") ? Text(entry.at("description"), "description") : "",
          arm,
          Joints(Member(entry, "q", "case"), arm),
          std::move(points),
          FeatureSet(std::move(features), num_points),
          Camera(Member(entry, "camera", "case"), "camera"),
          task_dimension};
}

OracleCase LoadOracleCase(const std::string& path, const std::string& id) {
  const Json file = ReadJsonFile(path);
  std::string ids;
  try {
    for (const Json& entry : List(Member(file, "cases", "file"), "cases")) {
      const std::string name = Text(Member(entry, "id", "case"), "id");
      if (name == id) return ParseOracleCase(entry);
      ids += (ids.empty() ? "" : " ") + name;
    }
  } catch (const ConfigError& error) {
    throw ConfigError(path, "", error.what());  // Which names the key.
  }
  throw ConfigError(path, id, "is not a case of this file; there are: " + ids);
}

Eigen::Isometry3d CameraPoseOf(const OracleCamera& camera, const Eigen::Isometry3d& X_WE) noexcept {
  return camera.eye_in_hand ? X_WE * camera.X : camera.X;
}

PointViews ViewPoints(const std::vector<OraclePoint>& points, const Eigen::Isometry3d& X_WE,
                      const Eigen::Isometry3d& X_WC) {
  PointViews views;
  const Eigen::Isometry3d X_CW = X_WC.inverse();
  for (const OraclePoint& point : points) {
    const Eigen::Vector3d p_WP = point.on_body ? Eigen::Vector3d(X_WE * point.p) : point.p;
    views.push_back(ViewOf(X_CW * p_WP, point.on_body));
  }
  return views;
}

}  // namespace vantage
