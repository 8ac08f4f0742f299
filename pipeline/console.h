#pragma once

#include "slim/base/reporter.h"

#include <chrono>
#include <mutex>
#include <string>

namespace slim {

/// The Reporter of the executables: log and progress on stderr. On a terminal the progress line is
/// redrawn in place, elsewhere it is written at most every five seconds.
class Console : public Reporter {
public:
    enum class Level { quiet, normal, verbose };

    Console(std::string program, Level level);
    ~Console() override;

    void info(const std::string& text) override;
    void warn(const std::string& text) override;
    /// Also notices SIGINT and SIGTERM: throws Interrupted.
    void progress(std::string_view what, std::uint64_t done, std::uint64_t total) override;
    void error(const std::string& text);

private:
    using Clock = std::chrono::steady_clock;

    void line(const std::string& text);
    void clear_progress();
    bool due(bool finished) const;

    std::mutex mutex_;
    std::string program_;
    Level level_;
    bool terminal_;
    bool drawn_ = false;  // a progress line stands on the terminal
    Clock::time_point start_;
    std::string what_;  // the progress going on
    Clock::time_point what_start_;
    Clock::time_point last_draw_;
};

/// "slicing 12.3 M of 45.6 M (27 %), 1.2 M/s, 0:28 left"
std::string progress_text(std::string_view what, std::uint64_t done, std::uint64_t total,
                          double seconds);

}  // namespace slim
