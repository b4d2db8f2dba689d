#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "batch_data.h"
#include "convex_hull.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/error.h"
#include "vantage/math/segment.h"
#include "vantage/observability/batch.h"

namespace vantage {
namespace {

using batch::Family;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Distances inside a rigid body may change by this share of the body's speed.
constexpr double kRigidTolerance = 1e-6;

[[noreturn]] void Refuse(const std::string& key, const std::string& reason) {
  throw ConfigError("", "batch." + key, reason);
}

std::string Item(const char* name, std::size_t i) {
  return std::string(name) + "[" + std::to_string(i) + "]";
}

void CheckSamples(const std::vector<BatchSample>& samples) {
  if (samples.empty()) Refuse("samples", "must be one or more, are none");
  const std::size_t points = samples.front().p_W.size();
  if (points < 1 || points > batch::kMaxBatchPoints) {
    Refuse("samples", "must have 1 to " + std::to_string(batch::kMaxBatchPoints) +
                          " points, have " + std::to_string(points));
  }
  const Eigen::Index joints =
      samples.front().J_p_W.empty() ? 0 : samples.front().J_p_W.front().cols();
  if (joints < 1) Refuse("samples", "must have joints");
  double total = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const BatchSample& sample = samples[i];
    if (sample.p_W.size() != points || sample.J_p_W.size() != points) {
      Refuse(Item("samples", i), "must have " + std::to_string(points) + " points and derivatives");
    }
    if (!(sample.weight >= 0.0) || !std::isfinite(sample.weight)) {
      Refuse(Item("samples", i) + ".weight", "must be >= 0, is " + std::to_string(sample.weight));
    }
    total += sample.weight;
    for (std::size_t j = 0; j < points; ++j) {
      if (sample.J_p_W[j].cols() != joints) Refuse(Item("samples", i), "must have as many joints");
      if (!sample.p_W[j].allFinite() || !sample.J_p_W[j].allFinite()) {
        Refuse(Item("samples", i), "must be finite");
      }
    }
  }
  if (!(total > 0.0)) Refuse("samples", "must have some weight");
}

void CheckRows(const std::vector<BatchRow>& rows, int points) {
  if (rows.empty() || static_cast<int>(rows.size()) > batch::kMaxBatchRows) {
    Refuse("rows", "must be 1 to " + std::to_string(batch::kMaxBatchRows) + ", are " +
                       std::to_string(rows.size()));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const BatchRow& row = rows[i];
    if (row.point < 0 || row.point >= points || row.axis < 0 || row.axis > 1) {
      Refuse(Item("rows", i), "must name one of the points and axis 0 or 1");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (rows[j].point == row.point && rows[j].axis == row.axis) {
        Refuse(Item("rows", i), "must not repeat another");
      }
    }
  }
}

// Points of one body keep their distances: (P_a - P_b) · (dP_a - dP_b) = 0.
bool KeepDistance(const BatchSample& s, std::size_t a, std::size_t b) {
  const Vector3d r = s.p_W[a] - s.p_W[b];
  double speed = 0.0, change = 0.0;
  for (Eigen::Index k = 0; k < s.J_p_W[a].cols(); ++k) {
    const Vector3d dP_a = s.J_p_W[a].col(k), dP_b = s.J_p_W[b].col(k);
    speed = std::max(speed, dP_a.norm() + dP_b.norm());
    change = std::max(change, std::abs(r.dot(dP_a - dP_b)));
  }
  return change <= kRigidTolerance * r.norm() * speed;
}

void CheckRigid(const std::vector<BatchSample>& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (std::size_t a = 1; a < samples[i].p_W.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        if (KeepDistance(samples[i], a, b)) continue;
        Refuse(Item("samples", i), "is no motion of one body: points " + std::to_string(b) +
                                       " and " + std::to_string(a) + " change their distance");
      }
    }
  }
}

std::vector<BatchRow> AllRows(int points) {
  std::vector<BatchRow> rows;
  for (int i = 0; i < points; ++i) {
    rows.push_back({i, 0});
    rows.push_back({i, 1});
  }
  return rows;
}

bool IsRow(const BatchRow& row, int point, int axis) {
  return row.point == point && row.axis == axis;
}

// The first two rows are both coordinates of one point.
bool StartsWithPoint(const std::vector<BatchRow>& rows) {
  return rows.size() >= 2 && IsRow(rows[0], rows[0].point, 0) && IsRow(rows[1], rows[0].point, 1);
}

bool IsAllRows(const std::vector<BatchRow>& rows, int points) {
  if (static_cast<int>(rows.size()) != 2 * points) return false;
  for (int i = 0; i < 2 * points; ++i) {
    if (!IsRow(rows[i], i / 2, i % 2)) return false;
  }
  return true;
}

Family FamilyOf(const BatchScene::Data& data) {
  const auto& rows = data.rows;
  if (rows.size() == 2 && StartsWithPoint(rows) && data.joints >= 2) return Family::kPair;
  if (rows.size() == 3 && StartsWithPoint(rows) && rows[2].axis == 0 &&
      rows[2].point != rows[0].point && data.joints >= 3) {
    return Family::kTriple;
  }
  if (data.body == BatchBody::kRigid && data.joints >= 6 && data.points >= 3 && data.points <= 8 &&
      IsAllRows(rows, data.points)) {
    return Family::kRigidSix;
  }
  return Family::kGeneric;
}

int RankOf(const BatchScene::Data& data) {
  const int rank = std::min(static_cast<int>(data.rows.size()), data.joints);
  return data.body == BatchBody::kRigid ? std::min(rank, 6) : rank;
}

Matrix3d Adjugate(const Matrix3d& A) {
  Matrix3d adjugate;  // rows: cross products of the columns
  adjugate.row(0) = A.col(1).cross(A.col(2)).transpose();
  adjugate.row(1) = A.col(2).cross(A.col(0)).transpose();
  adjugate.row(2) = A.col(0).cross(A.col(1)).transpose();
  return adjugate;
}

// A J turned in joint space, so that the first point's derivatives fill three columns alone; singular
// values of J_c do not change. Columns past the sixth are 0 and left out.
struct TurnedPair {
  Matrix3d A1;
  Matrix3d head;  // of A2
  MatrixXd tail;  // 3×(0..3)
};

TurnedPair TurnPair(const PointJacobian& A1, const PointJacobian& A2) {
  TurnedPair turned;
  if (A1.cols() <= 3) {
    turned.A1.setZero();
    turned.head.setZero();
    turned.A1.leftCols(A1.cols()) = A1;
    turned.head.leftCols(A1.cols()) = A2;
    return turned;
  }
  const Eigen::HouseholderQR<MatrixXd> qr(A1.transpose());
  const MatrixXd turned_A1 = A1 * qr.householderQ();
  const MatrixXd turned_A2 = A2 * qr.householderQ();
  turned.A1 = turned_A1.leftCols<3>();
  turned.head = turned_A2.leftCols<3>();
  const MatrixXd rest = turned_A2.rightCols(A1.cols() - 3);
  if (rest.cols() <= 3) {
    turned.tail = rest;
  } else {
    const Eigen::HouseholderQR<MatrixXd> rest_qr(rest.transpose());
    turned.tail = (rest * rest_qr.householderQ()).leftCols<3>();
  }
  return turned;
}

void Append(const Vector3d& v, std::vector<double>* record) {
  record->insert(record->end(), v.data(), v.data() + 3);
}
void Append(const Matrix3d& m, std::vector<double>* record) {
  for (int i = 0; i < 3; ++i) Append(Vector3d(m.row(i)), record);
}

// M of the triple form without its last entry, M0 = M P1 (its third part freed of that entry's share),
// both times `factor`.
void AppendTripleCore(const Matrix3d& A1, const Matrix3d& A2, const Vector3d& P1,
                      const Vector3d& P2, double factor, std::vector<double>* record) {
  const Matrix3d M = A2 * Adjugate(A1);
  // u = M d1, less its share along d2, which b does not see: u = (M - m I) d2 + M (P1 - P2), m = M(2, 2).
  const Matrix3d reduced = M - M(2, 2) * Matrix3d::Identity();
  const Vector3d constant = reduced * P2 + M * (P1 - P2);
  for (int i = 0; i < 8; ++i) record->push_back(factor * reduced(i / 3, i % 3));
  Append(Vector3d(factor * constant), record);
  Append(P1, record);
  Append(P2, record);
}

std::vector<double> TripleRecord(const BatchScene::Data& data, const BatchSample& s,
                                 double factor) {
  const int first = data.rows[0].point, second = data.rows[2].point;
  const TurnedPair turned = TurnPair(s.J_p_W[first], s.J_p_W[second]);
  const Vector3d& P1 = s.p_W[first];
  std::vector<double> record;
  AppendTripleCore(turned.A1, turned.head, P1, s.p_W[second], factor, &record);
  if (turned.tail.cols() == 0) return record;
  const Matrix3d adjugate = Adjugate(turned.A1);
  Append(adjugate, &record);
  Append(Vector3d(adjugate * P1), &record);
  for (Eigen::Index i = 0; i < turned.tail.cols(); ++i)
    Append(Vector3d(turned.tail.col(i)), &record);
  return record;
}

std::vector<double> PairRecord(const BatchScene::Data& data, const BatchSample& s) {
  const int point = data.rows[0].point;
  const Matrix3d A = TurnPair(s.J_p_W[point], s.J_p_W[point]).A1;
  const Matrix3d adjugate = Adjugate(A);
  std::vector<double> record;
  Append(s.p_W[point], &record);
  Append(adjugate, &record);
  Append(Vector3d(adjugate * s.p_W[point]), &record);
  return record;
}

// 3p×6: velocities of the points by the twist of the body about its first point.
MatrixXd TwistToPoints(const BatchSample& s) {
  MatrixXd T = MatrixXd::Zero(3 * s.p_W.size(), 6);
  for (std::size_t i = 0; i < s.p_W.size(); ++i) {
    T.block<3, 3>(3 * i, 0).setIdentity();
    T.block<3, 3>(3 * i, 3) = -Skew(s.p_W[i] - s.p_W[0]);
  }
  return T;
}

MatrixXd StackedJacobian(const BatchSample& s) {
  MatrixXd A(3 * s.J_p_W.size(), s.J_p_W.front().cols());
  for (std::size_t i = 0; i < s.J_p_W.size(); ++i) A.middleRows<3>(3 * i) = s.J_p_W[i];
  return A;
}

// Volume spanned by the rows of a wide matrix: the product of its singular values.
double RowVolume(const MatrixXd& J) {
  const Eigen::HouseholderQR<MatrixXd> qr(J.transpose());
  return std::abs(qr.matrixQR().diagonal().head(J.rows()).prod());
}

// Twists of the body, from the derivatives of its points. The same distances everywhere make the same
// normal matrix up to a rotation, so one sample tells whether the points span a body.
bool SpansBody(const BatchSample& s) {
  const MatrixXd T = TwistToPoints(s);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(T);
  return qr.rank() == 6;
}

std::vector<double> SixRecord(const BatchSample& s, bool spans) {
  std::vector<double> record;
  Append(s.p_W[0], &record);
  for (std::size_t i = 1; i < s.p_W.size(); ++i) Append(Vector3d(s.p_W[i] - s.p_W[0]), &record);
  double w_r = 0.0;
  if (spans) {
    const MatrixXd J_r = TwistToPoints(s).householderQr().solve(StackedJacobian(s));
    w_r = RowVolume(J_r);
  }
  record.push_back(w_r);
  return record;
}

int GenericColumns(const BatchScene::Data& data) {
  const int most = data.body == BatchBody::kRigid ? 6 : 3 * data.points;
  return std::min(data.joints, most);
}

std::vector<double> GenericRecord(const BatchScene::Data& data, const BatchSample& s) {
  const int columns = GenericColumns(data);
  MatrixXd A = StackedJacobian(s);
  if (columns < data.joints) {
    // All that the points can do lies in the row space; turn it onto the first columns.
    const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const Eigen::Index kept = std::min<Eigen::Index>(columns, svd.singularValues().size());
    MatrixXd turned = MatrixXd::Zero(A.rows(), columns);
    turned.leftCols(kept) =
        svd.matrixU().leftCols(kept) * svd.singularValues().head(kept).asDiagonal();
    A = turned;
  }
  std::vector<double> record;
  for (std::size_t i = 0; i < s.p_W.size(); ++i) {
    Append(s.p_W[i], &record);
    for (int row = 0; row < 3; ++row) {
      for (int j = 0; j < columns; ++j) record.push_back(A(3 * i + row, j));
    }
  }
  return record;
}

std::vector<double> RecordOf(const BatchScene::Data& data, const BatchSample& s, Family family,
                             bool spans) {
  switch (family) {
    case Family::kTriple:
      return TripleRecord(data, s, 1.0);
    case Family::kPair:
      return PairRecord(data, s);
    case Family::kRigidSix:
      return SixRecord(s, spans);
    case Family::kGeneric:
      break;
  }
  return GenericRecord(data, s);
}

int ColumnsOf(const BatchScene::Data& data, Family family) {
  switch (family) {
    case Family::kTriple:
      return std::min(data.joints, 6);
    case Family::kGeneric:
      return GenericColumns(data);
    default:
      return 0;
  }
}

template <class T>
void Pack(const BatchScene::Data& data, Family family, const std::vector<BatchSample>& samples,
          double min_depth, const batch::HullView<T>& hull, batch::PackedScene<T>* out) {
  const auto N = static_cast<int>(samples.size());
  const int padded = batch::Padded(N);
  const bool spans = family == Family::kRigidSix && SpansBody(samples.front());
  int fields = 0;
  for (int i = 0; i < N; ++i) {
    const std::vector<double> record = RecordOf(data, samples[i], family, spans);
    fields = static_cast<int>(record.size());
    for (const double x : record) out->record.push_back(static_cast<T>(x));
    if (family == Family::kTriple && data.joints == 3) {
      for (const double x : TripleRecord(data, samples[i], samples[i].weight)) {
        out->weighted.push_back(static_cast<T>(x));
      }
    }
  }
  out->lanes.resize(static_cast<std::size_t>(fields) * padded);
  out->weight.assign(padded, T(0));
  for (int i = 0; i < padded; ++i) {
    const int source = std::min(i, N - 1);
    for (int f = 0; f < fields; ++f) {
      out->lanes[static_cast<std::size_t>(f) * padded + i] =
          out->record[static_cast<std::size_t>(source) * fields + f];
    }
    if (i < N) out->weight[i] = static_cast<T>(samples[i].weight);
  }
  batch::SceneView<T>& view = out->view;
  view.family = family;
  view.samples = N;
  view.points = data.points;
  view.rows = static_cast<int>(data.rows.size());
  view.columns = ColumnsOf(data, family);
  view.fields = fields;
  for (std::size_t k = 0; k < data.rows.size(); ++k) {
    view.row[k] = {data.rows[k].point, data.rows[k].axis};
  }
  view.record = out->record.data();
  view.lanes = out->lanes.data();
  view.padded = padded;
  view.weight = out->weight.data();
  view.weighted = out->weighted.empty() ? nullptr : out->weighted.data();
  view.min_depth = static_cast<T>(min_depth);
  view.hull = hull;
}

// The motion in units of single precision: lengths near 1, so that products of many of them neither
// overflow nor vanish. J_c does not change.
std::vector<BatchSample> Rescaled(const BatchScene::Data& data) {
  std::vector<BatchSample> scaled = data.samples;
  for (BatchSample& s : scaled) {
    for (Vector3d& p : s.p_W) p = (p - data.origin) / data.unit;
    for (PointJacobian& J : s.J_p_W) J /= data.unit;
  }
  return scaled;
}

void PackForm(const BatchScene::Data& data, Family family, batch::PackedForm* form) {
  Pack(data, family, data.samples, kMinDepth, data.hull64.view, &form->f64);
  Pack(data, family, Rescaled(data), kMinDepth / data.unit, data.hull32.view, &form->f32);
}

// Every so many points of a chain is a node.
constexpr std::size_t kChainLength = 8;

// Chains over the points of the hull, one point of the body after the other along the motion.
template <class T>
void PackHull(const std::vector<Vector3d>& points, const std::vector<int>& hull,
              const std::vector<int>& track, double unit, const Vector3d& origin,
              batch::PackedHull<T>* out) {
  // Rounding of single precision must not make a chain look straighter than it is.
  const double slack = sizeof(T) == 4 ? 1e-5 : 1e-12;
  const auto append = [&](int i, std::vector<T>* to) {
    for (int k = 0; k < 3; ++k) to->push_back(static_cast<T>((points[i](k) - origin(k)) / unit));
  };
  double worst = 0.0;
  std::size_t at = 0;
  while (at < hull.size()) {
    append(hull[at], &out->node);
    std::size_t next = std::min(at + kChainLength, hull.size());
    while (next > at + 1 && (next == hull.size() || track[next] != track[at])) --next;
    batch::Chain<T> chain{};
    chain.first = static_cast<int>(out->xyz.size() / 3);
    if (next < hull.size() && next > at && track[next] == track[at]) {
      const Vector3d& a = points[hull[at]];
      const Vector3d along = points[hull[next]] - a;
      double sag = 0.0;
      for (std::size_t i = at + 1; i < next; ++i) {
        append(hull[i], &out->xyz);
        sag = std::max(sag, std::sqrt(SquaredDistanceToSegment(points[hull[i]], a, along)));
      }
      chain.count = static_cast<int>(next - at) - 1;
      chain.sag = static_cast<T>(sag / unit + slack);
      worst = std::max(worst, sag / unit + slack);
    }
    out->chain.push_back(chain);
    at = std::max(next, at + 1);
  }
  out->view.node = out->node.data();
  out->view.nodes = static_cast<int>(out->node.size() / 3);
  out->view.chain = out->chain.data();
  out->view.xyz = out->xyz.data();
  out->view.sag = static_cast<T>(worst);
}

void PackHulls(BatchScene::Data* data) {
  // Points of one track follow each other along the motion.
  std::vector<Vector3d> all;
  for (int j = 0; j < data->points; ++j) {
    for (const BatchSample& s : data->samples) all.push_back(s.p_W[j]);
  }
  const std::vector<int> hull = ConvexHullVertices(all);
  std::vector<int> track;
  for (const int i : hull) track.push_back(i / static_cast<int>(data->samples.size()));
  data->hull_count = static_cast<int>(hull.size());
  PackHull(all, hull, track, 1.0, Vector3d::Zero(), &data->hull64);
  PackHull(all, hull, track, data->unit, data->origin, &data->hull32);
}

void ChooseUnit(double unit, BatchScene::Data* data) {
  Vector3d low = data->samples.front().p_W.front(), high = low;
  for (const BatchSample& s : data->samples) {
    for (const Vector3d& p : s.p_W) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  data->origin = 0.5 * (low + high);
  data->unit = unit > 0.0 ? unit : std::max((high - low).norm(), 1e-3);
}

}  // namespace

const batch::PackedForm& BatchScene::Data::Generic() const {
  if (family == Family::kGeneric) return form;
  std::call_once(generic_made, [this] { PackForm(*this, Family::kGeneric, &generic); });
  return generic;
}

BatchScene::BatchScene(std::vector<BatchSample> samples, BatchBody body, std::vector<BatchRow> rows,
                       double unit) {
  CheckSamples(samples);
  if (!(unit >= 0.0) || !std::isfinite(unit)) {
    Refuse("unit", "must be >= 0 m, is " + std::to_string(unit));
  }
  auto data = std::make_unique<Data>();
  data->points = static_cast<int>(samples.front().p_W.size());
  data->joints = static_cast<int>(samples.front().J_p_W.front().cols());
  data->rows = rows.empty() ? AllRows(data->points) : std::move(rows);
  CheckRows(data->rows, data->points);
  if (body == BatchBody::kRigid) CheckRigid(samples);
  data->body = body;
  data->samples = std::move(samples);
  for (const BatchSample& s : data->samples) data->total_weight += s.weight;
  data->rank = RankOf(*data);
  data->family = FamilyOf(*data);
  ChooseUnit(unit, data.get());
  PackHulls(data.get());
  PackForm(*data, data->family, &data->form);
  data_ = std::move(data);
}

BatchScene::~BatchScene() = default;
BatchScene::BatchScene(BatchScene&&) noexcept = default;
BatchScene& BatchScene::operator=(BatchScene&&) noexcept = default;

const std::vector<BatchSample>& BatchScene::samples() const noexcept {
  return data_->samples;
}
const std::vector<BatchRow>& BatchScene::rows() const noexcept {
  return data_->rows;
}
int BatchScene::joints() const noexcept {
  return data_->joints;
}
int BatchScene::rank() const noexcept {
  return data_->rank;
}
double BatchScene::total_weight() const noexcept {
  return data_->total_weight;
}
int BatchScene::hull_size() const noexcept {
  return data_->hull_count;
}

std::string BatchScene::form() const {
  switch (data_->family) {
    case Family::kTriple:
      return "triple";
    case Family::kPair:
      return "pair";
    case Family::kRigidSix:
      return "rigid six";
    case Family::kGeneric:
      break;
  }
  return "generic";
}

}  // namespace vantage
