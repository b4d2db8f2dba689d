#include "vantage/vision/calibration_file.h"

#include <cmath>
#include <fstream>
#include <initializer_list>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <visp3/core/vpXmlParserCamera.h>

#include "vantage/math/error.h"

namespace vantage {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;

std::string ReadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxBytes + 1, '\0');
  if (file) file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad()) throw ConfigError(path, "", "cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.empty()) throw ConfigError(path, "", "is empty");
  if (text.size() > kMaxBytes) throw ConfigError(path, "", "is larger than 1 MiB");
  return text;
}

// The first of some keys that a file has.
struct Entry {
  std::string key;
  cv::FileNode node;
};

Entry Find(const cv::FileStorage& file, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    const cv::FileNode node = file[key];
    if (!node.empty()) return {key, node};
  }
  return {*keys.begin(), {}};
}

// The numbers of a matrix, OpenCV's or ROS's, or of a plain list.
std::vector<double> Numbers(const std::string& path, const Entry& entry) {
  cv::FileNode list = entry.node;
  if (list.isMap()) list = list["data"];
  std::vector<double> numbers;
  if (!list.isSeq()) throw ConfigError(path, entry.key, "must be a matrix");
  for (const cv::FileNode& value : list) {
    const double number = value.isReal() || value.isInt() ? value.real() : std::nan("");
    if (!std::isfinite(number)) throw ConfigError(path, entry.key, "must hold finite numbers");
    numbers.push_back(number);
  }
  return numbers;
}

int Size(const std::string& path, const Entry& entry, int in_use) {
  if (entry.node.empty()) {
    if (in_use > 0) return in_use;
    throw ConfigError(path, entry.key, "missing, and the image size is not known otherwise");
  }
  const int size = entry.node.isInt() ? static_cast<int>(entry.node) : 0;
  if (size < 16 || size > 8192) {
    throw ConfigError(path, entry.key,
                      "must be in [16, 8192] px, is " +
                          (entry.node.isInt() ? std::to_string(size) : "no integer"));
  }
  if (in_use > 0 && size != in_use) {
    throw ConfigError(path, entry.key,
                      "is " + std::to_string(size) + " px, but the images in use have " +
                          std::to_string(in_use) + " px");
  }
  return size;
}

void CheckMatrix(const std::string& path, const std::string& key, const CameraModel& camera) {
  const bool fits = camera.fx >= 1.0 && camera.fx <= 1e5 && camera.fy >= 1.0 && camera.fy <= 1e5 &&
                    std::abs(camera.u0) <= 2e4 && std::abs(camera.v0) <= 2e4 &&
                    std::abs(camera.skew) <= 1e4;
  if (!fits) {
    throw ConfigError(path, key,
                      "is no camera matrix [fx skew u0; 0 fy v0; 0 0 1] in pixels with focal "
                      "lengths in [1, 100000] px");
  }
}

CameraModel ReadOpenCv(const std::string& path, const std::string& text, int width, int height) {
  // What programs other than OpenCV write lacks the first line that it insists on.
  const bool plain_yaml = text[0] != '%' && text[0] != '<' && text[0] != '{';
  cv::FileStorage file;
  try {
    file.open((plain_yaml ? "%YAML:1.0\n" : "") + text,
              cv::FileStorage::READ | cv::FileStorage::MEMORY);
  } catch (const cv::Exception& error) {
    throw ConfigError(path, "", "is no YAML, XML or JSON that OpenCV reads: " + error.err);
  }
  CameraModel camera;
  const Entry matrix =
      Find(file, {"camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "M1", "intrinsics"});
  if (matrix.node.empty()) throw ConfigError(path, matrix.key, "missing");
  const std::vector<double> K = Numbers(path, matrix);
  if (K.size() != 9 || K[3] != 0.0 || K[6] != 0.0 || K[7] != 0.0 || K[8] != 1.0) {
    throw ConfigError(path, matrix.key, "must be 3x3 with rows [fx skew u0; 0 fy v0; 0 0 1]");
  }
  camera.fx = K[0];
  camera.skew = K[1];
  camera.u0 = K[2];
  camera.fy = K[4];
  camera.v0 = K[5];
  CheckMatrix(path, matrix.key, camera);

  const Entry model = Find(file, {"distortion_model", "model"});
  if (model.node.isString()) {
    const std::string name = static_cast<std::string>(model.node);
    if (name != "plumb_bob" && name != "radtan" && name != "pinhole") {
      throw ConfigError(path, model.key, "must be plumb_bob (radial-tangential), is " + name);
    }
  }
  const Entry lens = Find(file, {"distortion_coefficients", "dist_coeffs", "distCoeffs",
                                 "Distortion_Coefficients", "distortion", "D", "D1"});
  if (!lens.node.empty()) {
    std::vector<double> d = Numbers(path, lens);
    for (std::size_t i = 5; i < d.size(); ++i) {
      if (d[i] != 0.0) {
        throw ConfigError(path, lens.key,
                          "has more than the five coefficients k1 k2 p1 p2 k3: only "
                          "radial-tangential lenses are supported");
      }
    }
    if (d.size() < 4) {
      throw ConfigError(path, lens.key,
                        "must hold 4 or 5 coefficients, holds " + std::to_string(d.size()));
    }
    d.resize(5, 0.0);
    for (const double value : d) {
      if (std::abs(value) > 10.0) {
        throw ConfigError(path, lens.key, "must be in [-10, 10], is " + std::to_string(value));
      }
    }
    camera.distortion = {d[0], d[1], d[2], d[3], d[4]};
  }
  camera.width = Size(path, Find(file, {"image_width", "width", "image_Width"}), width);
  camera.height = Size(path, Find(file, {"image_height", "height", "image_Height"}), height);
  return camera;
}

// ViSP's parser tells standard output what it finds.
class QuietOutput {
 public:
  QuietOutput() : buffer_(std::cout.rdbuf(nullptr)) {}
  ~QuietOutput() {
    std::cout.rdbuf(buffer_);
    std::cout.clear();
  }
  QuietOutput(const QuietOutput&) = delete;
  QuietOutput& operator=(const QuietOutput&) = delete;

 private:
  std::streambuf* buffer_;
};

// The name of the only camera of ViSP's file.
std::string OnlyName(const std::string& path, const std::string& text) {
  std::set<std::string> names;
  const std::string open = "<name>";
  for (std::size_t at = text.find(open); at != std::string::npos; at = text.find(open, at + 1)) {
    const std::size_t begin = at + open.size();
    const std::size_t end = text.find('<', begin);
    if (end != std::string::npos) names.insert(text.substr(begin, end - begin));
  }
  if (names.size() == 1) return *names.begin();
  std::string known;
  for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
  throw ConfigError(path, "name",
                    names.empty() ? "the file names no camera" : "choose one of " + known);
}

CameraModel ReadVisp(const std::string& path, const std::string& text, int width, int height,
                     std::string name) {
  if (name.empty()) name = OnlyName(path, text);
  const QuietOutput quiet;
  vpXmlParserCamera parser;
  vpCameraParameters parameters;
  const auto parse = [&](vpCameraParameters::vpCameraParametersProjType type) {
    return parser.parse(parameters, path, name, type, static_cast<unsigned>(width),
                        static_cast<unsigned>(height)) == vpXmlParserCamera::SEQUENCE_OK;
  };
  const bool bent = parse(vpCameraParameters::perspectiveProjWithDistortion);
  if (!bent && !parse(vpCameraParameters::perspectiveProjWithoutDistortion)) {
    throw ConfigError(
        path, "camera",
        "has no camera named '" + name + "'" +
            (width > 0 ? " of " + std::to_string(width) + "x" + std::to_string(height) + " px"
                       : "") +
            ", or several that differ");
  }
  CameraModel camera;
  camera.fx = parameters.get_px();
  camera.fy = parameters.get_py();
  camera.u0 = parameters.get_u0();
  camera.v0 = parameters.get_v0();
  // kud takes undistorted to distorted rays: the first radial coefficient.
  if (bent) camera.distortion.k1 = parameters.get_kud();
  camera.width = width > 0 ? width : static_cast<int>(parser.getWidth());
  camera.height = height > 0 ? height : static_cast<int>(parser.getHeight());
  CheckMatrix(path, "camera", camera);
  if (camera.width < 16 || camera.height < 16) {
    throw ConfigError(path, "image_width", "missing, and the image size is not known otherwise");
  }
  return camera;
}

}  // namespace

CameraModel ReadCalibration(const std::string& path, int width, int height,
                            const std::string& name) {
  const std::string text = ReadText(path);
  const bool is_visp =
      text.find("opencv_storage") == std::string::npos && text.find("<root") != std::string::npos;
  return is_visp ? ReadVisp(path, text, width, height, name)
                 : ReadOpenCv(path, text, width, height);
}

}  // namespace vantage
