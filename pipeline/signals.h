#pragma once

#include "slim/base/error.h"

#include <string>

#include <sys/types.h>

namespace slim {

/// Thrown where a stage notices that it was asked to stop: exit 130 (SIGINT), 143 (SIGTERM, SIGHUP)
/// or 4 (SIGXCPU).
struct Interrupted : Error {
    explicit Interrupted(ExitCode code)
        : Error(code, code == ExitCode::terminated ? "terminated"
                      : code == ExitCode::resource
                          ? "the limit of processor time is reached (see `ulimit -t`)"
                          : "interrupted") {}
};

/// Blocks SIGINT, SIGTERM, SIGHUP and SIGXCPU in this and later threads, but for those that are
/// ignored (SIGHUP by nohup, SIGINT by `trap '' INT`), and waits for them in a thread of its own;
/// ignores SIGPIPE and SIGXFSZ (writes fail instead). Call first in main. On a signal: passes it to
/// the child of watch_child, lets check_stop throw, and if the stage has not ended after the grace
/// time (or a second signal comes) removes half-written files and leaves the process. Where the
/// limit of processor time is hard (`ulimit -t`), SIGXCPU comes a second of it earlier (of many
/// processors more, but half of the limit at most), for at that limit the system kills.
/// throws std::system_error where there is no room for the thread; then nothing is blocked
void watch_signals();

/// Throws Interrupted if a signal came.
void check_stop();

/// A running child process that must get our signals too; 0 when it has ended.
void watch_child(pid_t child);

}  // namespace slim
