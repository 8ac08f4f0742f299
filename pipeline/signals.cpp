#include "pipeline/signals.h"

#include "formats/atomic_file.h"

#include <atomic>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <string>
#include <thread>
#include <unistd.h>

namespace slim {
namespace {

constexpr int kGraceSeconds = 3;

std::atomic<int> stop_signal{0};
std::atomic<pid_t> child{0};

sigset_t stop_signals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    return set;
}

ExitCode exit_code_of(int signal) {
    return signal == SIGTERM ? ExitCode::terminated : ExitCode::interrupted;
}

void wait_for_signals() {
    const sigset_t set = stop_signals();
    int signal = 0;
    if (sigwait(&set, &signal) != 0) return;
    stop_signal = signal;
    if (const pid_t pid = child.load()) kill(pid, signal);
    const timespec grace{kGraceSeconds, 0};
    sigtimedwait(&set, nullptr, &grace);
    if (const pid_t pid = child.load()) kill(pid, SIGKILL);
    remove_open_temporaries();
    _exit(static_cast<int>(exit_code_of(signal)));
}

}  // namespace

void watch_signals() {
    const sigset_t set = stop_signals();
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // the write then fails, which AtomicFile reports as a full disk
    std::thread(wait_for_signals).detach();
}

void check_stop() {
    if (const int signal = stop_signal.load()) throw Interrupted(exit_code_of(signal));
}

void watch_child(pid_t pid) {
    child = pid;
    // The signal may have come before the child was known.
    if (const int signal = stop_signal.load(); signal && pid) kill(pid, signal);
}

void remove_open_temporaries() {
    namespace fs = std::filesystem;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator("/proc/self/fd", error)) {
        const fs::path target = fs::read_symlink(entry.path(), error);
        if (!error && target.filename().string().ends_with(temporary_suffix()))
            fs::remove(target, error);
    }
}

}  // namespace slim
