#include "urdf_document.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include "vantage/math/error.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = 16u << 20;

std::string ReadText(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw ConfigError(path, "", "is a directory");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  if (file == nullptr) {
    throw ConfigError(path, "", std::string("cannot be opened: ") + std::strerror(errno));
  }
  std::string text;
  std::string block(1u << 16, '\0');
  while (const std::size_t count = std::fread(block.data(), 1, block.size(), file.get())) {
    text.append(block, 0, count);
    if (text.size() > kMaxBytes) {
      throw ConfigError(path, "", "is larger than " + std::to_string(kMaxBytes) + " bytes");
    }
  }
  if (std::ferror(file.get()) != 0) {
    throw ConfigError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  return text;
}

// "XML_ERROR_MISMATCHED_ELEMENT" to "mismatched element".
std::string XmlErrorText(const tinyxml2::XMLDocument& xml) {
  std::string text = xml.ErrorName();
  const std::string prefix = "XML_ERROR_";
  if (text.compare(0, prefix.size(), prefix) == 0) text.erase(0, prefix.size());
  for (char& c : text) c = c == '_' ? ' ' : static_cast<char>(std::tolower(c));
  return text;
}

const tinyxml2::XMLElement* FindXacro(const tinyxml2::XMLElement& element) {
  if (std::strncmp(element.Name(), "xacro:", 6) == 0) return &element;
  for (auto* child = element.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    if (const auto* found = FindXacro(*child)) return found;
  }
  return nullptr;
}

// Collects what urdfdom logs while it is alive. Console bridge has one handler for the process.
class LogCapture : public console_bridge::OutputHandler {
 public:
  LogCapture() : lock_(mutex_), previous_(console_bridge::getOutputHandler()) {
    console_bridge::useOutputHandler(this);
  }
  ~LogCapture() override { console_bridge::useOutputHandler(previous_); }
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_WARN) messages_.push_back(text);
  }
  [[nodiscard]] std::vector<std::string> Take() { return std::move(messages_); }

 private:
  static inline std::mutex mutex_;
  std::lock_guard<std::mutex> lock_;
  console_bridge::OutputHandler* previous_;
  std::vector<std::string> messages_;
};

// Once each, without those that say nothing.
std::vector<std::string> Sifted(const std::vector<std::string>& messages) {
  std::vector<std::string> kept;
  for (const std::string& message : messages) {
    if (message.find("xml is not initialized correctly") != std::string::npos) continue;
    if (std::find(kept.begin(), kept.end(), message) == kept.end()) kept.push_back(message);
  }
  return kept;
}

std::string Joined(const std::vector<std::string>& texts) {
  std::string joined;
  for (const std::string& text : texts) joined += (joined.empty() ? "" : "; ") + text;
  return joined;
}

}  // namespace

UrdfDocument::UrdfDocument(const std::string& path) : path_(path) {
  const std::string text = ReadText(path);
  Locate(text);
  Parse(text);
  RequireTree();
}

void UrdfDocument::Locate(const std::string& text) {
  const auto fail = [this](int line, const std::string& reason) {
    throw ConfigError(path_ + (line > 0 ? ":" + std::to_string(line) : ""), "", reason);
  };
  tinyxml2::XMLDocument xml;
  if (xml.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    fail(xml.ErrorLineNum(), "not valid XML: " + XmlErrorText(xml));
  }
  const tinyxml2::XMLElement* root = xml.RootElement();
  if (root == nullptr) fail(0, "not valid XML: has no element");
  if (std::strcmp(root->Name(), "robot") != 0) {
    fail(root->GetLineNum(),
         std::string("is no URDF: the root element must be <robot>, is <") + root->Name() + ">");
  }
  if (const auto* xacro = FindXacro(*root)) {
    fail(xacro->GetLineNum(), std::string("<") + xacro->Name() +
                                  "> must be expanded first: xacro FILE.xacro > FILE.urdf");
  }
  for (auto* element = root->FirstChildElement(); element != nullptr;
       element = element->NextSiblingElement()) {
    const char* name = element->Attribute("name");
    if (name == nullptr) continue;
    if (std::strcmp(element->Name(), "link") == 0) link_lines_[name] = element->GetLineNum();
    if (std::strcmp(element->Name(), "joint") == 0) joint_lines_[name] = element->GetLineNum();
  }
}

void UrdfDocument::Parse(const std::string& text) {
  std::string exception;
  {
    LogCapture log;
    try {
      model_ = urdf::parseURDF(text);
    } catch (const std::exception& error) {
      exception = error.what();
    }
    complaints_ = Sifted(log.Take());
  }
  if (model_ != nullptr && model_->getRoot() != nullptr) return;
  if (!exception.empty()) complaints_.push_back(exception);
  const int line = LineOfElementIn(complaints_);
  throw ConfigError(path_ + (line > 0 ? ":" + std::to_string(line) : ""), "",
                    "not a valid URDF: " + Joined(complaints_));
}

// Urdfdom names elements, as "[name]" or "'name'", and no lines.
int UrdfDocument::LineOfElementIn(const std::vector<std::string>& messages) const {
  for (const std::string& message : messages) {
    const Lines& lines = message.find("oint") != std::string::npos ? joint_lines_ : link_lines_;
    for (const auto& [name, line] : lines) {
      if (message.find("[" + name + "]") != std::string::npos ||
          message.find("'" + name + "'") != std::string::npos) {
        return line;
      }
    }
  }
  return 0;
}

// Urdfdom takes two parents of one link, and circles beside the tree.
void UrdfDocument::RequireTree() const {
  std::map<std::string, std::string> joint_above;
  for (const auto& [name, joint] : model_->joints_) {
    const auto [other, is_new] = joint_above.emplace(joint->child_link_name, name);
    if (!is_new) {
      FailLink(joint->child_link_name,
               "is the child of two joints, '" + other->second + "' and '" + name + "'");
    }
  }
  std::set<std::string> reached;
  std::vector<urdf::LinkConstSharedPtr> open{model_->getRoot()};
  while (!open.empty()) {
    const urdf::LinkConstSharedPtr link = open.back();
    open.pop_back();
    reached.insert(link->name);
    open.insert(open.end(), link->child_links.begin(), link->child_links.end());
  }
  std::string in_circle;
  for (const auto& [name, link] : model_->links_) {
    if (reached.count(name) != 0) continue;
    if (in_circle.empty()) in_circle = name;
    link->child_links.clear();  // links of a circle own one another: nothing else would free them
  }
  if (!in_circle.empty()) FailLink(in_circle, "is in a circle of joints");
}

std::string UrdfDocument::Where(const Lines& lines, const std::string& name) const {
  const auto line = lines.find(name);
  return path_ + (line == lines.end() ? "" : ":" + std::to_string(line->second));
}

std::string UrdfDocument::Link(const std::string& name) const {
  return Where(link_lines_, name) + ": link '" + name + "'";
}

std::string UrdfDocument::Joint(const std::string& name) const {
  return Where(joint_lines_, name) + ": joint '" + name + "'";
}

void UrdfDocument::FailLink(const std::string& name, const std::string& reason) const {
  throw ConfigError(Where(link_lines_, name), "link '" + name + "'", reason);
}

void UrdfDocument::FailJoint(const std::string& name, const std::string& reason) const {
  throw ConfigError(Where(joint_lines_, name), "joint '" + name + "'", reason);
}

void UrdfDocument::Fail(const std::string& reason) const {
  throw ConfigError(path_, "", reason);
}

}  // namespace vantage
