#include "pipeline/child_process.h"

#include "pipeline/signals.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace slim {
namespace {

[[noreturn]] void fail(const std::string& program, int error) {
    throw IoError(fmt::format("{}: cannot run: {}", program, std::strerror(error)),
                  ExitCode::internal);
}

struct Pipe {
    Pipe() {
        if (pipe2(ends, O_CLOEXEC) != 0) fail("pipe", errno);
    }
    ~Pipe() {
        close(ends[0]);
        close_in();
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    int out() const { return ends[0]; }
    int in() const { return ends[1]; }
    void close_in() {
        if (ends[1] >= 0) close(ends[1]);
        ends[1] = -1;
    }
    int ends[2];
};

/// A file for a child's stderr; -1 without a name.
class ErrorsFile {
public:
    explicit ErrorsFile(const std::string& path) {
        if (path.empty()) return;
        file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (file_ < 0)
            throw IoError(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
    }
    ~ErrorsFile() {
        if (file_ >= 0) close(file_);
    }
    ErrorsFile(const ErrorsFile&) = delete;
    ErrorsFile& operator=(const ErrorsFile&) = delete;
    int get() const { return file_; }

private:
    int file_ = -1;
};

/// The child after fork: other threads may have held locks, so system calls only. Stdout to `out`,
/// stderr to `errors` unless that is -1, the signals that watch_signals blocked and ignored as they
/// were; why it could not start goes to `said`.
[[noreturn]] void become(char* const* argv, int out, int errors, int said, pid_t parent) {
    // The child works for its parent alone: were that killed, it would go on and hold the folder's
    // lock.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(static_cast<int>(ExitCode::internal));  // it ended before
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    std::signal(SIGPIPE, SIG_DFL);
    if (dup2(out, STDOUT_FILENO) >= 0 && (errors < 0 || dup2(errors, STDERR_FILENO) >= 0))
        execv(argv[0], argv);
    const int error = errno;
    [[maybe_unused]] const ssize_t written = write(said, &error, sizeof error);
    _exit(static_cast<int>(ExitCode::internal));
}

/// Call in the main thread: the kernel takes the end of the thread that forked for the parent's
/// end.
pid_t spawn(const std::vector<std::string>& arguments, int out, int errors) {
    std::vector<char*> argv;
    for (const std::string& word : arguments) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);

    Pipe trouble;  // closed by exec: nothing to read then
    const pid_t parent = getpid();
    const pid_t pid = fork();
    if (pid == 0) become(argv.data(), out, errors, trouble.in(), parent);
    if (pid < 0) fail(arguments[0], errno);
    trouble.close_in();
    int error = 0;
    ssize_t n = 0;
    while ((n = read(trouble.out(), &error, sizeof error)) < 0 && errno == EINTR) {
    }
    if (n != sizeof error) return pid;
    waitpid(pid, nullptr, 0);
    fail(arguments[0], error);
}

std::string read_all(int in) {
    std::string text;
    char buffer[1 << 14];
    for (;;) {
        const ssize_t n = read(in, buffer, sizeof buffer);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return text;
        text.append(buffer, static_cast<std::size_t>(n));
    }
}

/// What an ended child that was not waited for yet has read.
std::uint64_t bytes_read_by(pid_t pid) {
    siginfo_t info;
    while (waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOWAIT) < 0 && errno == EINTR) {
    }
    std::ifstream io(fmt::format("/proc/{}/io", pid));
    std::string key;
    std::uint64_t value = 0;
    while (io >> key >> value)
        if (key == "rchar:") return value;
    return 0;
}

double seconds_of(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

}  // namespace

std::filesystem::path program_folder() {
    return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

ChildResult run_child(const std::vector<std::string>& arguments, const std::string& errors) {
    const ErrorsFile to(errors);
    Pipe output;
    const auto start = std::chrono::steady_clock::now();
    const pid_t pid = spawn(arguments, output.in(), to.get());
    output.close_in();
    watch_child(pid);
    ChildResult result;
    result.output = read_all(output.out());
    result.bytes_read = bytes_read_by(pid);
    int status = 0;
    rusage usage{};
    while (wait4(pid, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    watch_child(0);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    result.seconds = seconds.count();
    result.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    result.processor_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
    result.peak_memory_bytes = 1024 * static_cast<std::uint64_t>(usage.ru_maxrss);
    return result;
}

}  // namespace slim
