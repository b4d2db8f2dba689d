// The ranks of an MPI job: vantage-plan-mpi.
//
// Rank 0 deals: a worker sends its last result (or nothing, at first) and gets its next item, so a slow machine
// holds nobody up. Rank 0's own share is worked on by a second thread that never calls MPI.

#include <chrono>
#include <cstdio>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include <mpi.h>

#include "app.h"
#include "plan_team.h"

namespace vantage {
namespace {

constexpr int kResult = 1, kItem = 2;  // tags
constexpr int kNoItem = -1;            // there is none left
// Blocking calls of MPI spin and would take a core from the work.
constexpr std::chrono::microseconds kPoll{200};

int RankOf() noexcept {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  return rank;
}

[[noreturn]] void EndJob(const char* what) {
  std::fprintf(stderr, "vantage-plan-mpi: rank %d: %s\n", RankOf(), what);
  MPI_Abort(MPI_COMM_WORLD, 1);
  std::abort();
}

void WaitForMessage(int source, int tag, MPI_Status* status) {
  for (int arrived = 0;;) {
    MPI_Iprobe(source, tag, MPI_COMM_WORLD, &arrived, status);
    if (arrived != 0) return;
    std::this_thread::sleep_for(kPoll);
  }
}

// An item's number and its line, as sent: "17 text".
std::string Packed(int item, const std::string& line) {
  return std::to_string(item) + " " + line;
}

void Work(const std::function<std::string(int)>& work) {
  std::string result;
  for (;;) {
    MPI_Send(result.data(), static_cast<int>(result.size()), MPI_CHAR, 0, kResult, MPI_COMM_WORLD);
    MPI_Status status;
    WaitForMessage(0, kItem, &status);
    int item = kNoItem;
    MPI_Recv(&item, 1, MPI_INT, 0, kItem, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    if (item == kNoItem) return;
    result = Packed(item, work(item));
  }
}

// Items still to be dealt and results of the own thread, shared by the two threads of rank 0.
class Desk {
 public:
  explicit Desk(const std::vector<int>& items) : items_(items.begin(), items.end()) {}

  [[nodiscard]] int NextItem() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (items_.empty()) return kNoItem;
    const int item = items_.front();
    items_.pop_front();
    return item;
  }

  void Put(int item, std::string line) {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_.emplace_back(item, std::move(line));
  }

  [[nodiscard]] bool Take(std::pair<int, std::string>* result) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (done_.empty()) return false;
    *result = std::move(done_.front());
    done_.pop_front();
    return true;
  }

 private:
  std::mutex mutex_;
  std::deque<int> items_;
  std::deque<std::pair<int, std::string>> done_;
};

void DealOut(const std::vector<int>& items, int workers,
             const std::function<std::string(int)>& work,
             const std::function<void(int, const std::string&)>& take) {
  Desk desk(items);
  std::thread own([&] {
    try {
      for (int item = desk.NextItem(); item != kNoItem; item = desk.NextItem()) {
        desk.Put(item, work(item));
      }
    } catch (const std::exception& error) {
      EndJob(error.what());
    }
  });
  std::size_t taken = 0;
  for (int busy = workers; busy > 0 || taken < items.size();) {
    bool idle = true;
    std::pair<int, std::string> result;
    if (desk.Take(&result)) {
      take(result.first, result.second);
      ++taken;
      idle = false;
    }
    int arrived = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, kResult, MPI_COMM_WORLD, &arrived, &status);
    if (arrived != 0) {
      int length = 0;
      MPI_Get_count(&status, MPI_CHAR, &length);
      std::string text(static_cast<std::size_t>(length), '\0');
      MPI_Recv(text.data(), length, MPI_CHAR, status.MPI_SOURCE, kResult, MPI_COMM_WORLD,
               MPI_STATUS_IGNORE);
      if (!text.empty()) {
        const std::size_t space = text.find(' ');
        take(std::stoi(text), text.substr(space + 1));
        ++taken;
      }
      const int item = desk.NextItem();
      MPI_Send(&item, 1, MPI_INT, status.MPI_SOURCE, kItem, MPI_COMM_WORLD);
      if (item == kNoItem) --busy;
      idle = false;
    }
    if (idle) std::this_thread::sleep_for(kPoll);
  }
  own.join();
}

}  // namespace

const char* const PlanTeam::kProgram = "vantage-plan-mpi";

PlanTeam::PlanTeam(int* argc, char*** argv) {
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);
  if (provided < MPI_THREAD_FUNNELED) EndJob("this MPI does not go with threads");
}

PlanTeam::~PlanTeam() {
  MPI_Finalize();
}

int PlanTeam::rank() const noexcept {
  return RankOf();
}

int PlanTeam::size() const noexcept {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

void PlanTeam::Deal(const std::vector<int>& items, const std::function<std::string(int)>& work,
                    const std::function<void(int, const std::string&)>& take) {
  try {
    if (rank() == 0) {
      DealOut(items, size() - 1, work, take);
    } else {
      Work(work);
    }
  } catch (const std::exception& error) {
    EndJob(error.what());
  }
}

void PlanTeam::Leave(int exit_code) const noexcept {
  if (exit_code >= kExitUsage && size() > 1) MPI_Abort(MPI_COMM_WORLD, exit_code);
}

}  // namespace vantage
