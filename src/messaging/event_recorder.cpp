#include "vantage/messaging/event_recorder.h"

#include <atomic>
#include <chrono>
#include <thread>

#include "vantage/messaging/event_log.h"
#include "vantage/messaging/lcm_link.h"

namespace vantage {

struct EventRecorder::Impl {
  Impl(const std::string& url, const std::string& path) : log(path), link({url, ""}) {
    link.SubscribeAll([this](std::string_view channel, const void* data, std::size_t size) {
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
  }

  EventLogWriter log;
  LoggedEvent event;  // In the link's thread alone; keeps its memory.
  std::atomic<std::int64_t> recorded{0};
  LcmLink link;  // Last: its thread ends first.
};

EventRecorder::EventRecorder(const std::string& url, const std::string& path)
    : impl_(std::make_unique<Impl>(url, path)) {}

EventRecorder::~EventRecorder() {
  // What is on its way is taken too: until nothing has come for a while, at most a second.
  const Time end = Clock::now() + std::chrono::seconds(1);
  std::int64_t before = -1;
  while (impl_->recorded != before && Clock::now() < end) {
    before = impl_->recorded;
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
  }
}

std::int64_t EventRecorder::lost() const noexcept {
  return impl_->link.stats().callback_errors;
}

}  // namespace vantage
