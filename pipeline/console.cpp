#include "pipeline/console.h"

#include "pipeline/signals.h"

#include <fmt/format.h>

#include <cstdio>

#include <unistd.h>

namespace slim {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds kRedraw{0.1};
constexpr Seconds kLinePeriod{5.0};

std::string count_text(double n) {
    if (n >= 1e9) return fmt::format("{:.4g} G", n / 1e9);
    if (n >= 1e6) return fmt::format("{:.3g} M", n / 1e6);
    if (n >= 1e4) return fmt::format("{:.3g} k", n / 1e3);
    return n >= 100 || n == static_cast<double>(static_cast<std::uint64_t>(n))
               ? fmt::format("{:.0f}", n)
               : fmt::format("{:.2g}", n);
}

std::string clock_text(double seconds) {
    const auto s = static_cast<std::uint64_t>(seconds + 0.5);
    if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
    return fmt::format("{}:{:02}", s / 60, s % 60);
}

/// A message as the one line that it is to be: a file may be called as control characters are.
std::string on_one_line(const std::string& text) {
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '\n') out += "\\n";
        else if (byte < 0x20 || byte == 0x7f) out += fmt::format("\\x{:02x}", byte);
        else out += c;
    }
    return out;
}

}  // namespace

std::string progress_text(std::string_view what, std::uint64_t done, std::uint64_t total,
                          double seconds) {
    const auto n = static_cast<double>(done);
    const double rate = seconds > 0 ? n / seconds : 0;
    std::string text = fmt::format("{} {}", what, count_text(n));
    if (total > 0)
        text += fmt::format(" of {} ({:.0f} %)", count_text(static_cast<double>(total)),
                            100.0 * n / static_cast<double>(total));
    if (rate > 0) text += fmt::format(", {}/s", count_text(rate));
    if (rate > 0 && total > done)
        text += fmt::format(", {} left", clock_text(static_cast<double>(total - done) / rate));
    return text;
}

Console::Console(std::string program, Level level)
    : program_(std::move(program)), level_(level), terminal_(isatty(STDERR_FILENO) != 0),
      start_(Clock::now()) {}

Console::~Console() { clear_progress(); }

void Console::info(const std::string& text) {
    if (level_ == Level::quiet) return;
    const std::lock_guard lock(mutex_);
    line(text);
}

void Console::warn(const std::string& text) {
    const std::lock_guard lock(mutex_);
    line("warning: " + on_one_line(text));
}

void Console::error(const std::string& text) {
    const std::lock_guard lock(mutex_);
    line("error: " + on_one_line(text));
}

void Console::line(const std::string& text) {
    clear_progress();
    std::string prefix = program_;
    if (level_ == Level::verbose)
        prefix += fmt::format(" [{:.2f} s]", Seconds(Clock::now() - start_).count());
    std::fputs(fmt::format("{}: {}\n", prefix, text).c_str(), stderr);
}

void Console::clear_progress() {
    if (drawn_) std::fputs("\r\033[K", stderr);
    drawn_ = false;
}

bool Console::due(bool finished) const {
    const auto now = Clock::now();
    if (terminal_) return finished || now - last_draw_ >= kRedraw;
    return now - last_draw_ >= kLinePeriod;
}

void Console::progress(std::string_view what, std::uint64_t done, std::uint64_t total) {
    check_stop();
    if (level_ == Level::quiet) return;
    const std::lock_guard lock(mutex_);
    if (what != what_) {
        what_ = what;
        what_start_ = last_draw_ = Clock::now();
    }
    if (!due(done == total)) return;
    const double seconds = Seconds(Clock::now() - what_start_).count();
    const std::string text = progress_text(what, done, total, seconds);
    last_draw_ = Clock::now();
    if (!terminal_) {
        line(text);
        return;
    }
    std::fputs(fmt::format("\r{}: {}\033[K", program_, text).c_str(), stderr);
    std::fflush(stderr);
    drawn_ = true;
}

}  // namespace slim
