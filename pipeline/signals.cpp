#include "pipeline/signals.h"

#include "formats/atomic_file.h"
#include "formats/made_folders.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>
#include <string_view>
#include <thread>
#include <unistd.h>

namespace slim {
namespace {

constexpr int kGraceSeconds = 3;
// whose own grace must end first: it removes what it has not finished
constexpr int kMoreForAChild = 2;

std::atomic<int> stop_signal{0};
std::atomic<pid_t> child{0};

/// What `nohup`, `trap '' INT` or the `&` of a script lets its command ignore, which sigwait would
/// notice nevertheless.
bool is_ignored(int signal) {
    struct sigaction now {};
    return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

sigset_t stop_signals() {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU})
        if (!is_ignored(signal)) sigaddset(&set, signal);
    return set;
}

ExitCode exit_code_of(int signal) {
    switch (signal) {
        case SIGINT: return ExitCode::interrupted;
        case SIGXCPU: return ExitCode::resource;
        default: return ExitCode::terminated;
    }
}

/// Those that ask for an end at once if they come a second time: not SIGXCPU, which comes again
/// every second.
sigset_t hurry_signals() {
    sigset_t set = stop_signals();
    sigdelset(&set, SIGXCPU);
    return set;
}

/// Whether one of the set came within so many seconds, in which the process may be stopped
/// (SIGSTOP) and go on.
bool comes_within(int seconds, const sigset_t& set) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point end = Clock::now() + std::chrono::seconds(seconds);
    for (;;) {
        const auto left = std::max(std::chrono::nanoseconds(0),
                                   std::chrono::nanoseconds(end - Clock::now()));
        const timespec time{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
        if (sigtimedwait(&set, nullptr, &time) > 0) return true;
        if (errno != EINTR) return false;
    }
}

void wait_for_signals() {
    const sigset_t set = stop_signals();
    int signal = 0;
    if (sigwait(&set, &signal) != 0) return;
    stop_signal = signal;
    if (const pid_t pid = child.load()) kill(pid, signal);
    const bool has_child = child.load() != 0;
    const bool again =
        comes_within(kGraceSeconds + (has_child ? kMoreForAChild : 0), hurry_signals());
    if (const pid_t pid = child.load(); pid && again) {
        kill(pid, signal);
        sleep(kMoreForAChild);
    }
    if (const pid_t pid = child.load()) kill(pid, SIGKILL);
    remove_live_temporaries();
    remove_empty_made_folders();
    constexpr std::string_view kSaid =
        "interrupted before its work was done: no half-written file is left\n";
    if (!has_child && write(STDERR_FILENO, kSaid.data(), kSaid.size()) < 0)
        _exit(static_cast<int>(ExitCode::internal));
    _exit(static_cast<int>(exit_code_of(signal)));
}

}  // namespace

void watch_signals() {
    const sigset_t set = stop_signals();
    sigset_t before;
    pthread_sigmask(SIG_BLOCK, &set, &before);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // the write then fails, which AtomicFile reports as a full disk
    try {
        std::thread(wait_for_signals).detach();
    } catch (...) {  // nobody waits for them: they are to end the process as they would
        pthread_sigmask(SIG_SETMASK, &before, nullptr);
        throw;
    }
}

void check_stop() {
    if (const int signal = stop_signal.load()) throw Interrupted(exit_code_of(signal));
}

void watch_child(pid_t pid) {
    child = pid;
    // The signal may have come before the child was known.
    if (const int signal = stop_signal.load(); signal && pid) kill(pid, signal);
}

}  // namespace slim
