#include "pipeline/signals.h"

#include "formats/atomic_file.h"
#include "formats/made_folders.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <ctime>
#include <limits>
#include <string_view>
#include <thread>
#include <sys/resource.h>
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

/// The hard limit of processor time, at which the system kills without a word; infinite without.
double hard_limit_s() {
    rlimit limit{};
    const bool is_none = getrlimit(RLIMIT_CPU, &limit) != 0 || limit.rlim_max == RLIM_INFINITY;
    return is_none ? std::numeric_limits<double>::infinity() : static_cast<double>(limit.rlim_max);
}

/// How long before a hard limit of processor time its end begins, in seconds of it: a second, of
/// many processors, which may all be at work, a tenth of a second of each, but half of it at most.
double time_to_end_s(double hard_s) {
    constexpr double kOfEach = 0.1;
    const auto processors = static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN));
    return std::min(std::max(1.0, kOfEach * processors), hard_s / 2);
}

/// `ulimit -t 10` sets the soft limit, at which SIGXCPU comes, and the hard one alike, and the
/// system kills at the latter: then the signal is to come a little earlier.
void signal_before_hard_limit() {
    rlimit limit{};
    const double hard_s = hard_limit_s();
    if (std::isinf(hard_s) || is_ignored(SIGXCPU) || getrlimit(RLIMIT_CPU, &limit) != 0) return;
    const double at_s = hard_s - time_to_end_s(hard_s);
    if (static_cast<double>(limit.rlim_cur) <= at_s) return;
    sigevent event{};
    event.sigev_notify = SIGEV_SIGNAL, event.sigev_signo = SIGXCPU;
    timer_t timer{};
    if (timer_create(CLOCK_PROCESS_CPUTIME_ID, &event, &timer) != 0) return;
    itimerspec when{};
    when.it_value.tv_sec = static_cast<time_t>(at_s);
    when.it_value.tv_nsec = static_cast<long>((at_s - std::floor(at_s)) * 1e9);
    timer_settime(timer, TIMER_ABSTIME, &when, nullptr);
}

/// Whether so little is left of the hard limit that what is half-written must go now.
bool is_hard_limit_near() {
    timespec now{};
    if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now) != 0) return false;
    const double hard_s = hard_limit_s(),
                 used_s = static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
    return hard_s - used_s < time_to_end_s(hard_s) / 2;
}

/// Whether one of the set came within so many seconds, in which the process may be stopped
/// (SIGSTOP) and go on. Ends early near a hard limit of processor time.
bool comes_within(int seconds, const sigset_t& set) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::nanoseconds kLook = std::chrono::milliseconds(20);
    const Clock::time_point end = Clock::now() + std::chrono::seconds(seconds);
    while (!is_hard_limit_near()) {
        const auto left = std::clamp(std::chrono::nanoseconds(end - Clock::now()),
                                     std::chrono::nanoseconds(0), kLook);
        const timespec time{0, left.count()};
        if (sigtimedwait(&set, nullptr, &time) > 0) return true;
        if (errno != EINTR && errno != EAGAIN) return false;
        if (Clock::now() >= end) return false;
    }
    return false;
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
    const std::string_view said =
        signal == SIGXCPU
            ? "the limit of processor time (see `ulimit -t`) ended the work before it was done: no "
              "half-written file is left\n"
            : "interrupted before its work was done: no half-written file is left\n";
    if (!has_child && write(STDERR_FILENO, said.data(), said.size()) < 0)
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
        signal_before_hard_limit();
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
