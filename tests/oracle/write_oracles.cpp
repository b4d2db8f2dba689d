// Writes an oracle file of its own: cases in the form of tests/data/oracles.json, of random arms, cameras and
// features. Independent of the library: the forward map alone, in extended precision, and differences of it.
//
// write_oracles FILE [SEED]
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

namespace {

using Json = nlohmann::json;
using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Matrix4 = Eigen::Matrix<Real, 4, 4>;
using Matrix3 = Eigen::Matrix<Real, 3, 3>;
using Vector3 = Eigen::Matrix<Real, 3, 1>;

constexpr Real kPi = 3.14159265358979323846264338327950288L;

// ---- The forward map ----

Matrix4 Turn(int axis, Real angle) {
  Vector3 w = Vector3::Unit(axis);
  Matrix4 T = Matrix4::Identity();
  T.topLeftCorner<3, 3>() = Eigen::AngleAxis<Real>(angle, w).toRotationMatrix();
  return T;
}

Matrix4 Shift(const Vector3& p) {
  Matrix4 T = Matrix4::Identity();
  T.topRightCorner<3, 1>() = p;
  return T;
}

Matrix4 Shift(int axis, Real length) {
  return Shift(Vector3(length * Vector3::Unit(axis)));
}

// exp of a displacement (translation, rotation vector); to first order is all that is needed.
Matrix4 Displacement(const Vector& d) {
  Matrix4 T = Shift(Vector3(d.head(3)));
  const Vector3 w = d.tail(3);
  if (w.norm() > 0) {
    T.topLeftCorner<3, 3>() = Eigen::AngleAxis<Real>(w.norm(), w.normalized()).toRotationMatrix();
  }
  return T;
}

Matrix4 Transform(const Json& rows) {
  Matrix4 T;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) T(i, j) = rows[i][j].get<double>();
  }
  return T;
}

Matrix4 EndEffector(const Json& robot, const Vector& q) {
  Matrix4 T = Transform(robot["base"]);
  for (std::size_t i = 0; i < robot["joints"].size(); ++i) {
    const Json& joint = robot["joints"][i];
    const auto value = [&](const char* name) -> Real { return joint.value(name, 0.0); };
    const Real moved = q(static_cast<Eigen::Index>(i)) + value("offset");
    const bool prismatic = joint["type"] == "P";
    const Real theta = prismatic ? value("theta") : moved;
    const Real d = prismatic ? moved : value("d");
    const Matrix4 about_z = Turn(2, theta) * Shift(2, d);
    const Matrix4 about_x = Shift(0, value("a")) * Turn(0, value("alpha"));
    T = robot["convention"] == "standard" ? Matrix4(T * about_z * about_x)
                                          : Matrix4(T * about_x * about_z);
  }
  return T * Transform(robot["tool"]);
}

struct Sphere {
  Real R, theta, phi, roll;
};

Matrix4 SphereCamera(const Json& spherical, const Sphere& s) {
  const Vector3 e_r(std::sin(s.theta) * std::cos(s.phi), std::sin(s.theta) * std::sin(s.phi),
                    std::cos(s.theta));
  const Vector3 e_theta(std::cos(s.theta) * std::cos(s.phi), std::cos(s.theta) * std::sin(s.phi),
                        -std::sin(s.theta));
  const Vector3 e_phi(-std::sin(s.phi), std::cos(s.phi), 0);
  Matrix4 T = Matrix4::Identity();
  if (spherical["orientation"] == "lookat") {
    T.block<3, 1>(0, 0) = e_phi;
    T.block<3, 1>(0, 1) = e_theta;
    T.block<3, 1>(0, 2) = -e_r;
  } else {
    T(1, 1) = T(2, 2) = -1;
  }
  for (int i = 0; i < 3; ++i) T(i, 3) = Real(spherical["target"][i].get<double>()) + s.R * e_r(i);
  return T * Turn(2, s.roll);
}

// What the features depend on.
struct State {
  Vector q;
  Vector twist = Vector::Zero(6);   // of E's origin, world axes
  Vector camera = Vector::Zero(6);  // displacement of the camera in its axes
  Sphere sphere{};
  Real focal = 0;  // added to fx and fy
};

Matrix4 MovedEndEffector(const Json& entry, const State& state) {
  Matrix4 T = EndEffector(entry["robot"], state.q);
  const Matrix4 D = Displacement(state.twist);
  T.topLeftCorner<3, 3>() = D.topLeftCorner<3, 3>() * T.topLeftCorner<3, 3>();
  T.topRightCorner<3, 1>() += D.topRightCorner<3, 1>();
  return T;
}

Matrix4 CameraPose(const Json& entry, const State& state, const Matrix4& T_ee) {
  const Json& camera = entry["camera"];
  const Matrix4 moved = Displacement(state.camera);
  if (camera["mount"] == "ee") return T_ee * Transform(camera["T_ec"]) * moved;
  if (camera.contains("spherical")) return SphereCamera(camera["spherical"], state.sphere) * moved;
  return Transform(camera["T_wc"]) * moved;
}

struct Image {
  std::vector<Vector3> p;  // in the camera's frame
  Matrix uv;               // 2×points
};

Image Look(const Json& entry, const State& state) {
  const Matrix4 T_ee = MovedEndEffector(entry, state);
  const Matrix4 T_wc = CameraPose(entry, state, T_ee);
  const Json& K = entry["camera"]["intrinsics"];
  const auto k = [&](const char* name) -> Real { return K[name].get<double>(); };
  Image image;
  image.uv.resize(2, static_cast<Eigen::Index>(entry["points"].size()));
  for (const Json& point : entry["points"]) {
    Vector3 P;
    for (int i = 0; i < 3; ++i) P(i) = point["xyz"][i].get<double>();
    if (point["frame"] == "ee") {
      P = (T_ee.topLeftCorner<3, 3>() * P + T_ee.topRightCorner<3, 1>()).eval();
    }
    const Vector3 p =
        T_wc.topLeftCorner<3, 3>().transpose() * (P - Vector3(T_wc.topRightCorner<3, 1>()));
    const Real x = p(0) / p(2);
    const Real y = p(1) / p(2);
    const auto i = static_cast<Eigen::Index>(image.p.size());
    image.uv(0, i) = (k("fx") + state.focal) * x + k("skew") * y + k("u0");
    image.uv(1, i) = (k("fy") + state.focal) * y + k("v0");
    image.p.push_back(p);
  }
  return image;
}

// Values of all features, and which of them are angles.
Vector Features(const Json& entry, const State& state) {
  const Matrix uv = Look(entry, state).uv;
  const auto at = [&](int i) -> Eigen::Matrix<Real, 2, 1> { return uv.col(i); };
  Vector v(static_cast<Eigen::Index>(entry["features"].size()));
  Eigen::Index row = 0;
  for (const Json& f : entry["features"]) {
    const std::string type = f["type"];
    Real value = 0;
    if (type == "point") {
      value = at(f["p"])(f["coord"] == "x" ? 0 : 1);
    } else if (type == "distance") {
      value = (at(f["j"]) - at(f["i"])).norm();
    } else if (type == "angle") {
      const auto e = (at(f["j"]) - at(f["i"])).eval();
      value = std::atan2(e(1), e(0));
    } else if (type == "edge_angle") {
      const auto a = (at(f["j"]) - at(f["i"])).eval();
      const auto b = (at(f["l"]) - at(f["k"])).eval();
      value = std::atan2(a(0) * b(1) - a(1) * b(0), a.dot(b));
    } else if (type == "area") {
      const auto poly = f["poly"].get<std::vector<int>>();
      for (std::size_t i = 0; i < poly.size(); ++i) {
        const auto a = at(poly[i]);
        const auto b = at(poly[(i + 1) % poly.size()]);
        value += (a(0) * b(1) - b(0) * a(1)) / 2;
      }
    } else {
      const auto pts = f["pts"].get<std::vector<int>>();
      for (const int i : pts) value += at(i)(f["coord"] == "x" ? 0 : 1);
      value /= static_cast<Real>(pts.size());
    }
    v(row++) = value;
  }
  return v;
}

bool IsAngle(const Json& feature) {
  return feature["type"] == "angle" || feature["type"] == "edge_angle";
}

// ---- Differences ----

// Central differences of eighth order: column j is the derivative along step j at 0.
Matrix Derivative(const std::function<Vector(const Vector&)>& f, int columns) {
  constexpr Real h = 0.0005L;
  constexpr Real weight[] = {4.0L / 5, -1.0L / 5, 4.0L / 105, -1.0L / 280};
  Matrix J;
  for (int j = 0; j < columns; ++j) {
    Vector sum;
    for (int i = 1; i <= 4; ++i) {
      const Vector step = i * h * Vector::Unit(columns, j);
      const Vector part = weight[i - 1] * (f(step) - f(-step));
      sum = i == 1 ? part : Vector(sum + part);
    }
    if (j == 0) J.resize(sum.size(), columns);
    J.col(j) = sum / h;
  }
  return J;
}

// Gradient of a number by differences of fourth order: its tolerance is wider, and each value dear.
Vector Gradient(const std::function<Real(const Vector&)>& f, int columns) {
  constexpr Real h = 0.0002L;
  Vector g(columns);
  for (int j = 0; j < columns; ++j) {
    const Vector step = h * Vector::Unit(columns, j);
    g(j) = (2 * (f(step) - f(-step)) / 3 - (f(2 * step) - f(-2 * step)) / 12) / h;
  }
  return g;
}

using Move = std::function<State(State, const Vector&)>;

Matrix FeatureJacobian(const Json& entry, const State& at, const Move& move, int columns) {
  const Vector here = Features(entry, at);
  return Derivative(
      [&](const Vector& step) {
        Vector d = Features(entry, move(at, step)) - here;
        for (Eigen::Index i = 0; i < d.size(); ++i) {
          if (IsAngle(entry["features"][static_cast<std::size_t>(i)])) {
            d(i) = std::remainder(d(i), 2 * kPi);
          }
        }
        return d;
      },
      columns);
}

State ByJoints(State s, const Vector& step) {
  s.q += step;
  return s;
}
State ByTwist(State s, const Vector& step) {
  s.twist += step;
  return s;
}
State ByCamera(State s, const Vector& step) {
  s.camera += step;
  return s;
}
State BySphere(State s, const Vector& step) {
  s.sphere.R += step(0);
  s.sphere.theta += step(1);
  s.sphere.phi += step(2);
  s.sphere.roll += step(3);
  s.focal += step(4);
  return s;
}

Matrix ArmJacobian(const Json& entry, const Vector& q) {
  const Matrix3 R = EndEffector(entry["robot"], q).topLeftCorner<3, 3>();
  const Matrix J = Derivative(
      [&](const Vector& step) {
        const Matrix4 T = EndEffector(entry["robot"], q + step);
        Vector all(12);
        all << T.topRightCorner<3, 1>(), T.block<3, 1>(0, 0), T.block<3, 1>(0, 1),
            T.block<3, 1>(0, 2);
        return all;
      },
      static_cast<int>(q.size()));
  Matrix result(6, q.size());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    Matrix3 dR;
    dR << J.block<3, 1>(3, j), J.block<3, 1>(6, j), J.block<3, 1>(9, j);
    const Matrix3 W = dR * R.transpose();
    result.col(j) << J.block<3, 1>(0, j), (W(2, 1) - W(1, 2)) / 2, (W(0, 2) - W(2, 0)) / 2,
        (W(1, 0) - W(0, 1)) / 2;
  }
  return result;
}

Vector SingularValues(const Matrix& J) {
  return Eigen::JacobiSVD<Matrix>(J).singularValues();
}

// Product of the largest singular values; 0 for what has lost rank but for rounding.
Real Product(const Matrix& J) {
  const Vector sigma = SingularValues(J);
  const Eigen::Index s = std::min<Eigen::Index>(6, sigma.size());
  return sigma(s - 1) > 1e-13L * sigma(0) ? sigma.head(s).prod() : 0;
}

// ---- JSON ----

Json List(const Vector& v) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) list.push_back(static_cast<double>(v(i)));
  return list;
}

Json Rows(const Matrix& m) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) rows.push_back(List(m.row(i).transpose()));
  return rows;
}

// Singular values, s, w and rank under `suffix`. False where the rank is a matter of taste.
bool AddMeasure(const Matrix& J, const std::string& suffix, Json* expected) {
  const Vector sigma = SingularValues(J);
  const Eigen::Index s = std::min<Eigen::Index>(6, sigma.size());
  int rank = 0;
  for (Eigen::Index i = 0; i < s; ++i) {
    const Real share = sigma(0) > 0 ? sigma(i) / sigma(0) : 0;
    if (share > 1e-13L && share < 1e-5L) return false;
    rank += share >= 1e-5L ? 1 : 0;
  }
  (*expected)["sv_" + suffix] = List(sigma);
  (*expected)["s_" + suffix] = s;
  (*expected)["rank_" + suffix] = rank;
  (*expected)["w_" + suffix] = rank == s ? static_cast<double>(sigma.head(s).prod()) : 0.0;
  return true;
}

Json Sphere5(const Vector& g) {
  return {{"R", static_cast<double>(g(0))},
          {"theta", static_cast<double>(g(1))},
          {"phi", static_cast<double>(g(2))},
          {"roll", static_cast<double>(g(3))},
          {"f", static_cast<double>(g(4))}};
}

// The translation-only block of a 3-joint arm.
Json TaskBlock(const Matrix& J_v, const Matrix& J_r, const Matrix& J_c) {
  const Matrix view = J_v.leftCols(3);
  const Matrix arm = J_r.topRows(3);
  const Real w_v = Product(view);
  const Real w_r = Product(arm);
  Json task{{"rows", {0, 1, 2}},
            {"m", 3},
            {"J_v", Rows(view)},
            {"J_r", Rows(arm)},
            {"w_v", static_cast<double>(w_v)},
            {"w_r", static_cast<double>(w_r)},
            {"product", static_cast<double>(w_v * w_r)},
            {"J_v_times_J_r_equals_J_c",
             (view * arm - J_c).cwiseAbs().maxCoeff() < 1e-12L * J_c.cwiseAbs().maxCoeff()}};
  if (view.rows() == 3) {
    const Matrix square = J_c * arm.inverse();
    task["J_v_square"] = Rows(square);
    task["w_v_square"] = static_cast<double>(Product(square));
  }
  return task;
}

// What is expected of an entry; null where it makes no clear case.
Json Expected(const Json& entry) {
  State at;
  at.q.resize(static_cast<Eigen::Index>(entry["q"].size()));
  for (Eigen::Index i = 0; i < at.q.size(); ++i) at.q(i) = entry["q"][i].get<double>();
  const auto n = static_cast<int>(at.q.size());
  const Json& camera = entry["camera"];
  if (camera.contains("spherical")) {
    const Json& s = camera["spherical"];
    at.sphere = {s["R"].get<double>(), s["theta"].get<double>(), s["phi"].get<double>(),
                 s["roll"].get<double>()};
  }
  const Image image = Look(entry, at);
  const Real f = camera["intrinsics"]["fx"].get<double>();
  for (std::size_t i = 0; i < image.p.size(); ++i) {
    const Vector3& p = image.p[i];
    // In front, within the image, and apart from each other.
    if (!(p(2) > 0.5L && p.head<2>().norm() < 1.2L * p(2))) return nullptr;
    for (std::size_t j = 0; j < i; ++j) {
      if ((image.uv.col(i) - image.uv.col(j)).norm() < 0.05L * f) return nullptr;
    }
  }
  const Matrix4 T_ee = MovedEndEffector(entry, at);
  const Matrix J_v = FeatureJacobian(entry, at, ByTwist, 6);
  const Matrix J_r = ArmJacobian(entry, at.q);
  const Matrix J_c = FeatureJacobian(entry, at, ByJoints, n);
  Json depth = Json::array();
  for (const Vector3& p : image.p) depth.push_back(static_cast<double>(p(2)));
  Json expected{{"T_ee", Rows(T_ee)},
                {"T_wc", Rows(CameraPose(entry, at, T_ee))},
                {"v", List(Features(entry, at))},
                {"uv", Rows(image.uv.transpose())},
                {"depth", depth},
                {"J_v", Rows(J_v)},
                {"J_r", Rows(J_r)},
                {"J_c", Rows(J_c)},
                {"L_cam", Rows(FeatureJacobian(entry, at, ByCamera, 6))}};
  // A camera that moves with all it sees, or an arm that moves nothing, is not what is asked about here.
  if (J_c.cwiseAbs().maxCoeff() < 1e-3L * f) return nullptr;
  if (!AddMeasure(J_v, "v", &expected) || !AddMeasure(J_r, "r", &expected) ||
      !AddMeasure(J_c, "c", &expected)) {
    return nullptr;
  }
  const int s = expected["s_c"];
  const Vector sigma = SingularValues(J_c);
  const bool full = expected["rank_c"] == s;
  expected["sigma_min_c"] = full ? static_cast<double>(sigma(s - 1)) : 0.0;
  expected["cond_c"] = full ? Json(static_cast<double>(sigma(0) / sigma(s - 1))) : Json(nullptr);
  if (n == 3) {
    const Vector moved = SingularValues(J_r.topRows(3));
    if (moved(2) < 1e-3L * moved(0)) return nullptr;  // its inverse would tell of rounding
    expected["task"] = TaskBlock(J_v, J_r, J_c);
  }

  const auto gradient = [&](const Move& move, int columns, const Move& of, int of_columns) {
    return Gradient(
        [&](const Vector& step) {
          return Product(FeatureJacobian(entry, move(at, step), of, of_columns));
        },
        columns);
  };
  if (full) {
    expected["grad_wc_cam_twist"] = List(gradient(ByCamera, 6, ByJoints, n));
    expected["grad_wc_q"] = List(gradient(ByJoints, n, ByJoints, n));
    if (camera.contains("spherical") && camera["intrinsics"]["fx"] == camera["intrinsics"]["fy"]) {
      expected["grad_wc_spherical"] = Sphere5(gradient(BySphere, 5, ByJoints, n));
    }
  }
  if (expected["rank_v"] == expected["s_v"]) {
    expected["grad_wv_cam_twist"] = List(gradient(ByCamera, 6, ByTwist, 6));
  }
  return expected;
}

// ---- Random cases ----

class Cases {
 public:
  explicit Cases(unsigned seed) : random_(seed) {}

  Json Next(int number) {
    while (true) {
      Json entry = Entry(number);
      entry["expected"] = Expected(entry);
      if (!entry["expected"].is_null()) return entry;
    }
  }

 private:
  double Draw(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }
  int Pick(int a, int b) { return std::uniform_int_distribution<int>(a, b)(random_); }

  Json Pose(double reach) {
    Eigen::Quaterniond Q(Draw(-1, 1), Draw(-1, 1), Draw(-1, 1), Draw(-1, 1));
    const Eigen::Matrix3d R = Q.normalized().toRotationMatrix();
    Json rows = Json::array();
    for (int i = 0; i < 3; ++i) {
      rows.push_back({R(i, 0), R(i, 1), R(i, 2), Draw(-reach, reach)});
    }
    rows.push_back({0.0, 0.0, 0.0, 1.0});
    return rows;
  }

  Json Robot(int n) {
    Json joints = Json::array();
    for (int i = 0; i < n; ++i) {
      const bool prismatic = Pick(0, 3) == 0;
      Json joint{{"type", prismatic ? "P" : "R"},
                 {"a", Draw(-0.3, 0.3)},
                 {"alpha", Draw(-2, 2)},
                 {"offset", Draw(-0.5, 0.5)}};
      joint[prismatic ? "theta" : "d"] = Draw(-0.5, 0.5);
      joints.push_back(joint);
    }
    return {{"name", "random"},
            {"convention", Pick(0, 1) == 0 ? "standard" : "modified"},
            {"base", Pose(0.5)},
            {"tool", Pose(0.2)},
            {"joints", joints}};
  }

  Json Camera() {
    Json camera;
    const int units = Pick(0, 2);  // normalised, metric, pixels
    const double f = units == 0 ? 1.0 : units == 1 ? Draw(0.5, 2.0) : Draw(300, 900);
    camera["intrinsics"] = {{"fx", f},
                            {"fy", units == 2 && Pick(0, 1) == 0 ? f * Draw(0.9, 1.1) : f},
                            {"skew", units == 2 ? Draw(-5, 5) : 0.0},
                            {"u0", units == 2 ? Draw(300, 340) : 0.0},
                            {"v0", units == 2 ? Draw(220, 260) : 0.0}};
    const int place = Pick(0, 3);
    camera["mount"] = place == 3 ? "ee" : "world";
    if (place == 3) camera["T_ec"] = Pose(0.3);
    if (place == 2) camera["T_wc"] = Pose(2.0);
    if (place < 2) {
      camera["spherical"] = {{"R", Draw(1.5, 3.0)},
                             {"theta", Draw(0.05, 1.4)},
                             {"phi", Draw(-3, 3)},
                             {"roll", Draw(-3, 3)},
                             {"target", {Draw(-0.3, 0.3), Draw(-0.3, 0.3), Draw(-0.3, 0.3)}},
                             {"orientation", place == 0 ? "lookat" : "fixed_down"}};
    }
    return camera;
  }

  Json Feature(int points) {
    std::vector<int> p(points);
    for (int i = 0; i < points; ++i) p[i] = i;
    std::shuffle(p.begin(), p.end(), random_);
    const char* const coord = Pick(0, 1) == 0 ? "x" : "y";
    const std::vector<int> some(p.begin(), p.begin() + Pick(3, points));
    switch (Pick(0, 7)) {
      case 0:
        return {{"type", "distance"}, {"i", p[0]}, {"j", p[1]}};
      case 1:
        return {{"type", "angle"}, {"i", p[0]}, {"j", p[1]}};
      case 2:
        return {{"type", "edge_angle"}, {"i", p[0]}, {"j", p[1]}, {"k", p[1]}, {"l", p[2]}};
      case 3:
        return {{"type", "area"}, {"poly", some}};
      case 4:
        return {{"type", "centroid"}, {"pts", some}, {"coord", coord}};
      default:
        return {{"type", "point"}, {"p", p[0]}, {"coord", coord}};
    }
  }

  Json Entry(int number) {
    // Every size of arm that the library holds comes up.
    const int n = 1 + number % 16;
    const int k = Pick(1, 10);
    Json entry{{"id", "W" + std::to_string(number)},
               {"group", "random"},
               {"description", "random arm, camera and features"},
               {"k", k},
               {"n", n},
               {"m", 6}};
    entry["robot"] = Robot(n);
    for (int i = 0; i < n; ++i) entry["q"].push_back(Draw(-1, 1));
    const int points = Pick(3, 6);
    for (int i = 0; i < points; ++i) {
      entry["points"].push_back({{"frame", Pick(0, 3) == 0 ? "world" : "ee"},
                                 {"xyz", {Draw(-0.5, 0.5), Draw(-0.5, 0.5), Draw(-0.5, 0.5)}}});
    }
    for (int i = 0; i < k; ++i) entry["features"].push_back(Feature(points));
    entry["camera"] = Camera();
    return entry;
  }

  std::mt19937 random_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: write_oracles FILE [SEED]\n";
    return 2;
  }
  Cases cases(argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1U);
  Json file{{"cases", Json::array()}};
  for (int i = 0; i < 32; ++i) file["cases"].push_back(cases.Next(i));
  std::ofstream out(argv[1]);
  out << file.dump() << '\n';
  return out ? 0 : 3;
}
