#include "vantage/messaging/event_recorder.h"

#include <atomic>
#include <chrono>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <thread>

#include "vantage/messaging/event_log.h"
#include "vantage/messaging/lcm_link.h"

namespace vantage {
namespace {

// Recorders send themselves numbers here, which are not recorded. When one is back, a hub knows the recorder's subscription,
// and has passed on what had reached it before: however little of the processor hub and recorder got. Numbers of other
// recorders come too.
constexpr const char* kEchoChannel = "VANTAGE_RECORDER_ECHO";
using EchoNumber = std::uint64_t;

constexpr std::chrono::milliseconds kQuiet{60};
constexpr std::chrono::seconds kLongestWait{2};
constexpr std::chrono::milliseconds kPoll{1};

}  // namespace

struct EventRecorder::Impl {
  Impl(const std::string& url, const std::string& path) : log(path), link({url, ""}) {
    link.SubscribeAll([this](std::string_view channel, const void* data, std::size_t size) {
      if (channel == kEchoChannel) {
        EchoNumber came = 0;
        if (size == sizeof(came)) std::memcpy(&came, data, size);
        echo = came;
        return;
      }
      using std::chrono::duration_cast;
      using std::chrono::microseconds;
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      event.utime = duration_cast<microseconds>(now).count();
      event.channel = channel;
      const auto* bytes = static_cast<const std::uint8_t*>(data);
      event.data.assign(bytes, bytes + size);
      log.Write(event);
      ++recorded;
    });
    link.Start();
    WaitForEcho(Clock::now() + kLongestWait);
  }

  // Waits until a number has gone the way of all messages; not where nobody passes it on.
  void WaitForEcho(Time end) {
    ++number;
    Bytes bytes(sizeof(number));
    std::memcpy(bytes.data(), &number, sizeof(number));
    if (!link.PublishBytes(kEchoChannel, bytes)) return;
    while (echo != number && Clock::now() < end) std::this_thread::sleep_for(kPoll);
  }

  EventLogWriter log;
  LoggedEvent event;  // In the link's thread alone; keeps its memory.
  std::atomic<std::int64_t> recorded{0};
  EchoNumber number{std::random_device{}()};  // Sent last.
  std::atomic<EchoNumber> echo{0};            // Came last.
  LcmLink link;                               // Last: its thread ends first.
};

EventRecorder::EventRecorder(const std::string& url, const std::string& path)
    : impl_(std::make_unique<Impl>(url, path)) {}

EventRecorder::~EventRecorder() {
  // What is on its way is taken too: until nothing has come for a while and while a number went round.
  const Time end = Clock::now() + kLongestWait;
  std::int64_t before = -1;
  while (impl_->recorded != before && Clock::now() < end) {
    before = impl_->recorded;
    std::this_thread::sleep_for(kQuiet);
    impl_->WaitForEcho(end);
  }
}

std::int64_t EventRecorder::lost() const noexcept {
  return impl_->link.stats().callback_errors;
}

}  // namespace vantage
